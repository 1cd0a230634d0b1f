//! The formulas of the fit against brute force, the turning of diagonals, and what is remembered of the light.

use super::fit::fit;
use super::misfit::{Misfit, unfitted};
use super::{Illumination, Receiver};
use crate::direct::DirectLight;
use crate::discontinuity::FaceLines;
use crate::mesh::{FaceDomain, GridPoint, ReceiverMesh};
use crate::quantity::{Irradiance, Radiance, Rgb};
use crate::radiosity::{Basis, Bounces, IndirectField, Linking, Request, SolveMesh, Solver};
use crate::scene::{CleanSettings, FaceSide, Material, RawPolygon, RawScene, Scene, clean};
use crate::visibility::Blockers;
use glam::{DVec2, DVec3};

/// Squares along a side of the mesh.
const SIDE: i64 = 6;

/// A few pseudo-random numbers in −1…1.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }
}

fn light(mut next: impl FnMut() -> f64) -> Irradiance {
    Irradiance(Rgb(DVec3::new(next(), next(), next())))
}

/// Barycentric coordinates of the middles of `n²` equal parts of a triangle.
fn parts(n: usize) -> Vec<[f64; 3]> {
    let h = 1.0 / n as f64;
    let mut weights = Vec::new();
    for i in 0..n {
        for j in 0..n - i {
            let at = |t: f64| [(i as f64 + t) * h, (j as f64 + t) * h];
            let mut push = |[a, b]: [f64; 2]| weights.push([a, b, 1.0 - a - b]);
            push(at(1.0 / 3.0));
            if i + j + 1 < n {
                push(at(2.0 / 3.0));
            }
        }
    }
    weights
}

#[test]
fn means_of_the_misfit_are_those_of_its_formula() {
    let mut next = numbers(3);
    let parts = parts(200);
    for _ in 0..5 {
        let edges = [0; 3].map(|_| light(&mut next));
        let added = [0; 3].map(|_| light(&mut next));
        let centre = light(&mut next);
        let misfit = Misfit::new(edges, centre);
        let bubble = centre - (edges[0] + edges[1] + edges[2]) * (4.0 / 9.0);
        let value = |w: [f64; 3]| {
            (0..3).fold(bubble * (27.0 * w[0] * w[1] * w[2]), |sum, k| {
                sum + edges[k] * (4.0 * w[k] * w[(k + 1) % 3])
            })
        };
        let (mut square, mut moment) = (0.0, Irradiance::ZERO);
        for &w in &parts {
            let rest = (0..3).fold(value(w), |sum, k| sum - added[k] * w[k]);
            square += rest.0.mean_square() / parts.len() as f64;
            moment += value(w) * (w[1] / parts.len() as f64);
        }
        assert!((misfit.mean_square(added) - square).abs() < 1e-3 * square);
        assert!((misfit.moments()[1] - moment).0.mean_square() < 1e-6);
        // Without a bubble and with the mean taken off.
        let plain = Misfit::new(edges, (edges[0] + edges[1] + edges[2]) * (4.0 / 9.0));
        let mean = (edges[0] + edges[1] + edges[2]) * (1.0 / 3.0);
        let expected = plain.mean_square([mean; 3]);
        assert!((unfitted(edges) - expected).abs() < 1e-12);
    }
}

/// Squares of a unit square, each cut in two, with their neighbours.
fn mesh() -> ReceiverMesh {
    let mut mesh = ReceiverMesh::default();
    let pixels = 1 << 20;
    for y in 0..=SIDE {
        for x in 0..=SIDE {
            mesh.vertices.push(GridPoint::new(x * pixels, y * pixels));
            mesh.plane
                .push(DVec2::new(x as f64, y as f64) / SIDE as f64);
        }
    }
    let row = SIDE as u32 + 1;
    for y in 0..SIDE as u32 {
        for x in 0..SIDE as u32 {
            let a = y * row + x;
            mesh.elements.push([a, a + 1, a + row + 1]);
            mesh.elements.push([a, a + row + 1, a + row]);
        }
    }
    mesh.sites = mesh.elements.clone();
    mesh.site_vertices = (0..mesh.vertices.len() as u32).collect();
    mesh.edges = vec![[None; 3]; mesh.elements.len()];
    mesh.neighbours = neighbours(&mesh.elements);
    mesh
}

fn neighbours(elements: &[[u32; 3]]) -> Vec<[Option<u32>; 3]> {
    let across = |a: u32, b: u32| {
        let has = |e: &[u32; 3]| (0..3).any(|k| e[k] == b && e[(k + 1) % 3] == a);
        elements.iter().position(has).map(|e| e as u32)
    };
    elements
        .iter()
        .map(|e| [0, 1, 2].map(|k| across(e[k], e[(k + 1) % 3])))
        .collect()
}

fn misfits(mesh: &ReceiverMesh, f: impl Fn(DVec2) -> f64) -> (Vec<Irradiance>, Vec<Misfit>) {
    let grey = |v: f64| Irradiance(Rgb::grey(v));
    let values: Vec<Irradiance> = mesh.plane.iter().map(|&p| grey(f(p))).collect();
    let misfits = (0..mesh.elements.len())
        .map(|e| {
            let p = mesh.corners(e);
            let edges = [0, 1, 2].map(|k| {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                grey(f(a.midpoint(b)) - 0.5 * (f(a) + f(b)))
            });
            let corners = p.iter().map(|&p| f(p)).sum::<f64>() / 3.0;
            Misfit::new(edges, grey(f(mesh.centre(e)) - corners))
        })
        .collect();
    (values, misfits)
}

fn square(mesh: &ReceiverMesh, misfits: &[Misfit], added: &[Irradiance]) -> f64 {
    (0..mesh.elements.len())
        .map(|e| {
            let corners = mesh.sites[e].map(|s| added[s as usize]);
            mesh.area(e) * misfits[e].mean_square(corners)
        })
        .sum()
}

#[test]
fn no_other_values_fit_better() {
    let mesh = mesh();
    let (values, misfits) = misfits(&mesh, |p| 2.0 + p.x * p.x + 0.3 * p.x * p.y + p.y.powi(3));
    let added = fit(&mesh, &values, &misfits);
    let best = square(&mesh, &misfits, &added);
    let interpolated = square(&mesh, &misfits, &vec![Irradiance::ZERO; added.len()]);
    assert!(best < 0.25 * interpolated, "{best} of {interpolated}");
    // What the last step of the conjugate gradients left is far below this change.
    let change = Irradiance(Rgb::grey(1e-4));
    for s in 0..added.len() {
        for sign in [1.0, -1.0] {
            let mut other = added.clone();
            other[s] += change * sign;
            assert!(square(&mesh, &misfits, &other) > best, "site {s}");
        }
    }
}

#[test]
fn linear_light_and_darkness_stay_as_they_are() {
    let mesh = mesh();
    let (values, flat) = misfits(&mesh, |p| 1.0 + 2.0 * p.x - 0.5 * p.y);
    for added in fit(&mesh, &values, &flat) {
        assert!(added.0.0.abs().max_element() < 1e-14);
    }
    // A shadow's edge in the middle of the mesh: no light leaks into the dark, none is negative.
    let (values, misfits) = misfits(&mesh, |p| (p.x - 0.5).max(0.0).powi(2));
    for (value, added) in values.iter().zip(fit(&mesh, &values, &misfits)) {
        assert!(value.mean() > 0.0 || added == Irradiance::ZERO);
        assert!((*value + added).0.0.min_element() >= 0.0);
    }
}

#[test]
fn turned_diagonals_leave_a_mesh() {
    let mut mesh = mesh();
    let mut next = numbers(11);
    let mut turned = 0;
    for _ in 0..400 {
        let e = ((next() + 1.0) * 0.5 * mesh.elements.len() as f64) as usize % mesh.elements.len();
        let k = ((next() + 1.0) * 1.5) as usize % 3;
        let Some(f) = mesh.neighbours[e][k].map(|f| f as usize) else {
            continue;
        };
        let m = (0..3)
            .find(|&m| mesh.neighbours[f][m] == Some(e as u32))
            .expect("neighbours are mutual");
        let before = mesh.clone();
        mesh.flip(e, k, f, m);
        // Keep what is convex.
        if mesh.area(e) <= 0.0 || mesh.area(f) <= 0.0 {
            mesh = before;
            continue;
        }
        turned += 1;
        assert_eq!(mesh.neighbours, neighbours(&mesh.elements));
        assert_eq!(mesh.sites, mesh.elements);
        let area: f64 = (0..mesh.elements.len()).map(|e| mesh.area(e)).sum();
        assert!((area - 1.0).abs() < 1e-12);
    }
    assert!(turned > 100, "only {turned}");
}

/// A floor and a wall, a lamp above and a board between, all of the same reflectance; the lamp is the last.
fn corner_with_a_lamp() -> Scene {
    let quads: [[[f64; 3]; 4]; 4] = [
        [
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 2.0, 0.0],
            [0.0, 2.0, 0.0],
        ],
        [
            [0.0, 0.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.0, 2.0, 2.0],
            [0.0, 0.0, 2.0],
        ],
        [
            [0.8, 0.5, 0.7],
            [1.5, 0.5, 0.7],
            [1.5, 1.2, 0.7],
            [0.8, 1.2, 0.7],
        ],
        [
            [0.9, 0.9, 1.6],
            [0.9, 1.3, 1.6],
            [1.3, 1.3, 1.6],
            [1.3, 0.9, 1.6],
        ],
    ];
    let reflecting = Material {
        reflectance: Rgb::grey(0.5),
        ..Material::default()
    };
    let shining = Material {
        emission: Radiance(Rgb::grey(10.0)),
        ..reflecting.clone()
    };
    let polygon = |i: u32| RawPolygon {
        corners: (4 * i..4 * i + 4).collect(),
        material: u32::from(i == 3),
        group: 0,
    };
    let raw = RawScene {
        source: "test".to_owned(),
        positions: quads.iter().flatten().copied().map(DVec3::from).collect(),
        polygons: (0..4).map(polygon).collect(),
        materials: vec![reflecting, shining],
        groups: vec!["quads".to_owned()],
        ..RawScene::default()
    };
    clean(&raw, &CleanSettings::default()).expect("a scene").0
}

#[test]
fn direct_light_is_looked_at_once_when_the_indirect_light_changes() {
    let scene = corner_with_a_lamp();
    let blockers = Blockers::new(&scene);
    let direct = DirectLight::new(&scene, &blockers);
    let domain = |f| FaceDomain::new(&scene, f, FaceSide::Front, &[], &[], &[]);
    let sides = scene
        .faces
        .ids()
        .map(|f| (domain(f).into(), Rgb::grey(0.5)));
    let mesh = SolveMesh::new(sides.collect(), 0.7).expect("a clean scene can be meshed");
    let request = Request {
        error: 0.01,
        ambient: 0.5,
        bounces: Bounces::All,
        tolerance: 1e-7,
        basis: Basis::default(),
        linking: Linking::default(),
        solver: Solver::default(),
    };
    let even = |_: &_, _, _| Irradiance(Rgb::grey(1.0));
    let solved = IndirectField::solve(mesh, &blockers, request, even);
    let (field, _) = solved.expect("the default solver has no limit");
    let [without, with] = [None, Some(&field)].map(|indirect| Illumination {
        direct: &direct,
        tolerance: 0.0,
        indirect,
    });
    let measured = |r: &mut Receiver, light: &Illumination| {
        r.update_mesh(light, None).expect("it can be meshed");
        r.update_errors(light, 0.01, true);
    };
    let floor = scene.faces.ids().next().expect("the floor is first");
    let receiver = || {
        let lines = FaceLines::default();
        let mut r = Receiver::new(&scene, domain(floor).into(), lines, 0.3);
        r.solve_face = Some(0);
        r
    };
    let [mut relit, mut fresh] = [receiver(), receiver()];
    measured(&mut relit, &without);
    let dark = relit.expected_error();
    relit.relight();
    measured(&mut relit, &with);
    measured(&mut fresh, &with);
    assert_eq!(relit.evaluations(), fresh.evaluations());
    assert_eq!(relit.expected_error(), fresh.expected_error());
    assert_ne!(relit.expected_error(), dark);
    let shown = |r: &Receiver| [r.direct.clone(), r.indirect.clone()];
    assert_eq!(shown(&relit), shown(&fresh));
    assert!(relit.indirect.iter().any(|e| e.mean() > 0.0));
}
