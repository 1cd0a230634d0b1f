//! What the lines and the adaptation are worth: elements against uniform meshes with the same error.

use crate::common::bake::{bake, settings, world};
use crate::common::rng::Rng;
use glam::DVec2;
use rayon::prelude::*;
use std::path::Path;
use umbrage::adapt::{Meshing, Receiver};
use umbrage::direct::DirectLight;
use umbrage::discontinuity::DiscontinuityOrder;
use umbrage::mesh::{FaceDomain, GridPoint, ReceiverMesh};
use umbrage::pipeline::{
    ConvergenceRow, Solution, convergence, convergence_csv, convergence_slope, meshing_name,
};
use umbrage::quantity::Irradiance;
use umbrage::radiosity::Bounces;
use umbrage::settings::Settings;
use umbrage::visibility::{Scratch, Viewpoint};

/// Floors in penumbra, and how many times as many elements than ours, at an error of 1 %, a lattice of equilateral triangles
/// needs at least: the best uniform mesh there is.
///
/// Where the light or its slope jumps, elements along lines save most. At D2 lines only the curvature does, and what is saved
/// is what adaptation saves anywhere. The last row's light bends over half of the floor: there is little to save.
const SCENES: [(&str, f64); 6] = [
    ("blocker-touching-floor", 12.0),
    ("box-on-table", 12.0),
    ("square-over-square", 7.0),
    ("crossing-blockers", 5.0),
    ("tilted-triangle", 5.0),
    ("rotated-blocker", 4.2),
];

/// Uniform refinement, which halves squares and cuts them in two, needs at least so many times as many everywhere.
const LEAST: f64 = 5.0;

/// Points at which meshes are measured.
const POINTS: usize = 4000;

/// Uniform meshes get finer by this factor, until one is at least as good.
const STEP: f64 = 0.97;

/// RMS error over one face of linear interpolation between `values` at the sites of `mesh`, W/m².
fn rms(
    light: &DirectLight,
    domain: &FaceDomain,
    mesh: &ReceiverMesh,
    values: &[Irradiance],
) -> f64 {
    let mut sums = vec![0.0];
    for e in 0..mesh.elements.len() {
        sums.push(sums[e] + mesh.area(e));
    }
    let total = sums[mesh.elements.len()];
    let mut rng = Rng::new(19);
    let points: Vec<(usize, [f64; 3])> = (0..POINTS)
        .map(|i| {
            let at = total * (i as f64 + rng.unit()) / POINTS as f64;
            let e = sums.partition_point(|&s| s <= at) - 1;
            let (mut a, mut b) = (rng.unit(), rng.unit());
            if a + b > 1.0 {
                (a, b) = (1.0 - a, 1.0 - b);
            }
            (e.min(mesh.elements.len() - 1), [1.0 - a - b, a, b])
        })
        .collect();
    let squares: Vec<f64> = points
        .par_iter()
        .map_init(Scratch::default, |scratch, &(e, w)| {
            let corners = mesh.corners(e);
            let p = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
            let exact = light.irradiance(&view(domain, p), scratch);
            let [a, b, c] = mesh.sites[e].map(|s| values[s as usize]);
            (a * w[0] + b * w[1] + c * w[2] - exact).0.mean_square()
        })
        .collect();
    (squares.iter().sum::<f64>() / POINTS as f64).sqrt()
}

fn view(domain: &FaceDomain, p: DVec2) -> Viewpoint {
    Viewpoint::new(domain.frame.to_space(p), domain.normal)
}

/// The face that the shadow falls on: the largest lit one.
fn floor<'a>(solution: &'a Solution) -> &'a Receiver {
    let lit = solution.receivers.iter().filter(|r| r.is_lit);
    lit.max_by(|a, b| a.area().total_cmp(&b.area()))
        .expect("something is lit")
}

/// Corners of equal squares over a rectangular face, at most `spacing` wide.
fn squares(domain: &FaceDomain, spacing: f64) -> Vec<GridPoint> {
    let (lo, hi) = domain.polygon().bounds();
    let count = ((hi - lo).max_element() / spacing).ceil() as u32;
    let mut points = Vec::new();
    for y in 0..=count {
        for x in 0..=count {
            let t = DVec2::new(f64::from(x), f64::from(y)) / f64::from(count);
            points.push(domain.grid.snap(lo + (hi - lo) * t));
        }
    }
    points
}

/// Elements of the first uniform mesh that is at least as good as `target`; its RMS error.
fn uniform(
    light: &DirectLight,
    domain: &FaceDomain,
    start: f64,
    target: f64,
    points: impl Fn(&FaceDomain, f64) -> Vec<GridPoint>,
) -> (usize, f64) {
    let mut spacing = start;
    loop {
        let mesh = domain.mesh(&[], &points(domain, spacing));
        let mesh = mesh.expect("the face can be meshed");
        let values: Vec<Irradiance> = mesh
            .site_points
            .par_iter()
            .map_init(Scratch::default, |scratch, &p| {
                light.irradiance(&view(domain, p), scratch)
            })
            .collect();
        let found = rms(light, domain, &mesh, &values);
        if found <= target {
            return (mesh.elements.len(), found);
        }
        spacing *= STEP;
    }
}

/// How many times as many elements as ours uniform refinement and a lattice need. Both hold the contact lines.
fn ratios(name: &str, error: f64) -> [f64; 2] {
    let world = world(name);
    let solution = bake(&world, error, Bounces::Count(0));
    let floor = floor(&solution);
    let (light, domain) = (&solution.direct, &floor.domain);
    // Whatever was asked for: what the floor's mesh is worth is the error that it has.
    let target = rms(light, domain, &floor.mesh, &floor.direct);
    let start = world.scene.diagonal / 20.0;
    let own = floor.mesh.elements.len();
    let ours = format!(
        "{own} elements along {} lines ({target:.2e} W/m²)",
        floor.kept().count()
    );
    let refined = uniform(light, domain, start, target, squares);
    let lattice = uniform(light, domain, start, target, FaceDomain::seed_points);
    let [a, b] = [refined, lattice].map(|(count, _)| count as f64 / own as f64);
    eprintln!(
        "{name} at {error}: {ours}, {} by uniform refinement ({:.2e}): {a:.1} times, lattice of {} ({:.2e}): {b:.1} times",
        refined.0, refined.1, lattice.0, lattice.1
    );
    [a, b]
}

#[test]
fn uniform_meshes_need_many_more_elements() {
    for (name, least) in SCENES {
        let [refined, lattice] = ratios(name, 0.01);
        assert!(refined >= LEAST, "{name}: only {refined:.1} times");
        assert!(lattice >= least, "{name}: only {lattice:.1} times");
    }
}

#[test]
#[ignore = "prints how the ratio grows as the error shrinks"]
fn ratios_at_other_errors() {
    for (name, _) in SCENES {
        for error in [0.1, 0.03, 0.01, 0.003] {
            ratios(name, error);
        }
    }
}

/// Direct light only, measured at enough points that the slope is not theirs.
fn direct_only() -> Settings {
    Settings {
        samples: Some(4000),
        ..settings(0.01, Bounces::Count(0))
    }
}

fn slope(rows: &[ConvergenceRow], scene: &str, meshing: Meshing) -> f64 {
    // A mesh that was cut off at the most elements that there may be is as good as it happens to be.
    let is_cut_off = |r: &ConvergenceRow| meshing == Meshing::Uniform && r.elements >= 250_000;
    let of = rows
        .iter()
        .filter(|r| r.scene == scene && r.meshing == meshing && !is_cut_off(r));
    convergence_slope(of).expect("several errors")
}

#[test]
fn along_lines_the_error_falls_as_the_elements_grow() {
    for name in ["square-over-square", "rotated-blocker"] {
        let rows = convergence(
            &world(name),
            name,
            &[Meshing::Discontinuity],
            &[0.08, 0.04, 0.02, 0.01],
            &direct_only(),
        );
        let rows = rows.unwrap_or_else(|e| panic!("{e}"));
        let found = slope(&rows, name, Meshing::Discontinuity);
        assert!(found <= -0.95, "{name}: {found:.2}, {rows:?}");
    }
}

/// The errors of the long table: from 8 % to 0.1 %, and before them those that a uniform mesh reaches where light jumps.
const ERRORS: [f64; 7] = [0.08, 0.04, 0.02, 0.01, 0.005, 0.002, 0.001];
const COARSE_ERRORS: [f64; 3] = [0.4, 0.3, 0.15];

#[test]
#[ignore = "bakes for minutes and writes error_against_elements.csv into the build directory"]
fn error_against_elements() {
    let kinds = [Meshing::Discontinuity, Meshing::Adaptive, Meshing::Uniform];
    let uniform_errors = [&COARSE_ERRORS[..], &ERRORS[..]].concat();
    let series = [(&kinds[..2], &ERRORS[..]), (&kinds[2..], &uniform_errors)];
    let mut rows = Vec::new();
    for (name, _) in SCENES {
        let world = world(name);
        for (kinds, errors) in series {
            let found = convergence(&world, name, kinds, errors, &direct_only());
            rows.extend(found.unwrap_or_else(|e| panic!("{e}")));
        }
        let slopes = kinds.map(|k| format!("{} {:.2}", meshing_name(k), slope(&rows, name, k)));
        eprintln!("{name}: {}", slopes.join(", "));
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("error_against_elements.csv");
    std::fs::write(&path, convergence_csv(&rows)).expect("the build directory can be written to");
    eprintln!("written: {}", path.display());
    for (name, _) in SCENES {
        let found = slope(&rows, name, Meshing::Discontinuity);
        assert!(found <= -0.95, "{name}: {found:.2}");
    }
    // Uniform meshes lose most where the light itself jumps: the root of the spacing, a quarter of the elements' power. Where
    // only its curvature jumps they need more elements, but not a lower power.
    for name in ["blocker-touching-floor", "box-on-table"] {
        let found = slope(&rows, name, Meshing::Uniform);
        assert!(found >= -0.55, "{name}: {found:.2}");
    }
}

#[test]
fn lines_that_are_not_needed_are_not_inserted() {
    let world = world("square-over-square");
    let kept = |error: f64| bake(&world, error, Bounces::Count(0)).summary.lines_kept;
    // Flat grey is good enough for whoever accepts any error.
    assert_eq!(kept(2.0), 0);
    let fine = kept(0.01);
    assert!(fine >= 8, "the 8 lines where the slope jumps, not {fine}");
}

#[test]
fn no_line_breaks_by_more_than_the_light_there_is() {
    for (name, _) in SCENES {
        let world = world(name);
        let solution = bake(&world, 0.01, Bounces::Count(0));
        for receiver in &solution.receivers {
            for (i, measured) in receiver.kept() {
                let line = &receiver.lines.candidates[i];
                // Half of the emitter's light is predicted where a corner of it appears; no break exceeds the whole.
                let whole = match line.order {
                    DiscontinuityOrder::D2 => 2.0 * line.jump,
                    _ => line.jump,
                };
                assert!(
                    measured <= whole,
                    "{name}: {measured} W/m² measured, {line:?}"
                );
            }
        }
    }
}
