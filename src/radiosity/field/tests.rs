//! What points remember of their gathers, held against gathering.

use super::super::field_face::{Point, Source};
use super::super::tests::{cube, mesh_of};
use super::{IndirectField, Request};
use crate::quantity::{Irradiance, Rgb};
use crate::radiosity::{Basis, Bounces, Linking, SolveFace, Solver};
use crate::visibility::Blockers;
use glam::DVec2;

const REFLECTANCE: f64 = 0.5;

/// Permitted error, W/m²; the direct light is about 1.
const ERROR: f64 = 0.003;

/// Direct light with a bright spot on every face, W/m².
fn spot(_: &SolveFace, _: usize, p: DVec2) -> Irradiance {
    let from_spot = p - DVec2::new(0.2, 0.1);
    Irradiance(Rgb::grey(2.0 / (1.0 + 20.0 * from_spot.length_squared())))
}

/// A field in the cube, refined so that points have been gathered.
fn refined(blockers: &Blockers) -> IndirectField<'_> {
    let mesh = mesh_of(&cube(REFLECTANCE), REFLECTANCE, 0.7);
    let request = Request {
        error: ERROR,
        ambient: 0.5,
        bounces: Bounces::All,
        tolerance: 1e-7,
        basis: Basis::default(),
        linking: Linking::default(),
        solver: Solver::default(),
    };
    let solved = IndirectField::solve(mesh, blockers, request, spot);
    let (mut field, _) = solved.expect("the default solver has no limit");
    field
        .refine(0.3 * ERROR, || false, |_| true)
        .expect("the faces can be meshed");
    field
}

fn points<'f>(field: &'f IndirectField) -> impl Iterator<Item = &'f Point> {
    field.faces.iter().flat_map(|f| f.points())
}

#[test]
fn a_point_receives_what_its_links_say() {
    let scene = cube(REFLECTANCE);
    let blockers = Blockers::new(&scene);
    let field = refined(&blockers);
    let light = &field.solution.light.faces;
    let mut count = 0;
    for point in points(&field) {
        if let Source::Cells(links) = &point.source {
            let told = links.iter().map(|l| l.irradiance(light));
            let told = told.fold(Irradiance::ZERO, |sum, e| sum + e).mean();
            let gathered = point.value.mean();
            // Weights are kept in single precision; none is negative, so that their roundings do not grow.
            let round_off = f64::from(f32::EPSILON) * gathered;
            assert!((told - gathered).abs() <= round_off, "{told} {gathered}");
            count += 1;
        }
    }
    assert!(count > 100, "{count} points were gathered");
}

#[test]
fn a_correction_is_the_same_without_links() {
    let scene = cube(REFLECTANCE);
    let blockers = Blockers::new(&scene);
    let [mut with, mut without] = [refined(&blockers), refined(&blockers)];
    for face in &mut without.faces {
        face.forget_links();
    }
    assert_eq!(without.link_count(), 0);
    let corrected = [&mut with, &mut without].map(|f| f.correct(spot));
    assert!(corrected[0] > 0.0);
    // Both gather the same residual, with mistakes that are permitted but not the same.
    let pairs = points(&with).zip(points(&without));
    let squares: Vec<f64> = pairs
        .map(|(a, b)| (a.value.mean() - b.value.mean()).powi(2))
        .collect();
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!(rms > 0.0, "none was gathered anew");
    assert!(rms <= 0.1 * ERROR, "{rms} W/m² at a permitted {ERROR}");
}
