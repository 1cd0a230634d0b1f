//! Solids that stand in each other, and faces that lie in each other: what is seen is lit once, the rest is dark.

use crate::common::bake::{bake, clean};
use glam::DVec3;
use umbrage::discontinuity::DiscontinuityOrder;
use umbrage::pipeline::Solution;
use umbrage::quantity::{Radiance, Rgb};
use umbrage::radiosity::Bounces;
use umbrage::scene::{FaceSide, Material, RawPolygon, RawScene};

const ERROR: f64 = 0.05;

/// A scene of polygons given by their corners, each a group of its own; the last one shines.
fn scene(polygons: &[(&str, Vec<DVec3>)]) -> RawScene {
    let mut raw = RawScene {
        source: "soup".to_owned(),
        materials: vec![
            Material {
                name: "matte".to_owned(),
                reflectance: Rgb::grey(0.5),
                ..Material::default()
            },
            Material {
                name: "lamp".to_owned(),
                emission: Radiance(Rgb::grey(10.0)),
                ..Material::default()
            },
        ],
        ..RawScene::default()
    };
    for (i, (name, corners)) in polygons.iter().enumerate() {
        let first = raw.positions.len() as u32;
        raw.positions.extend(corners);
        raw.groups.push((*name).to_owned());
        raw.polygons.push(RawPolygon {
            corners: (first..first + corners.len() as u32).collect(),
            material: u32::from(i + 1 == polygons.len()),
            group: i as u32,
        });
    }
    raw
}

/// The faces of an axis-parallel box, each seen counter-clockwise from outside: left, right, bottom, top, back, front.
fn faces_of_box(names: [&'static str; 6], lo: DVec3, hi: DVec3) -> Vec<(&'static str, Vec<DVec3>)> {
    let corner = |i: usize| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 0 {
                lo[axis]
            } else {
                hi[axis]
            }
        };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let loops = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    names
        .into_iter()
        .zip(loops)
        .map(|(name, l)| (name, l.map(corner).to_vec()))
        .collect()
}

/// A horizontal rectangle seen counter-clockwise from above, or from below.
fn level(x: [f64; 2], z: [f64; 2], y: f64, is_up: bool) -> Vec<DVec3> {
    let mut corners = vec![
        DVec3::new(x[0], y, z[1]),
        DVec3::new(x[1], y, z[1]),
        DVec3::new(x[1], y, z[0]),
        DVec3::new(x[0], y, z[0]),
    ];
    if !is_up {
        corners.reverse();
    }
    corners
}

/// Length of the contact lines on the front of a face, and the lines.
fn contacts(solution: &Solution, name: &str) -> (f64, Vec<[DVec3; 2]>) {
    let scene = &solution.world.scene;
    let receiver = solution
        .receivers
        .iter()
        .find(|r| {
            let face = &scene.faces[r.domain.face];
            scene.groups[face.group as usize] == name && r.domain.side == FaceSide::Front
        })
        .unwrap_or_else(|| panic!("no {name}"));
    let lines: Vec<[DVec3; 2]> = receiver
        .lines
        .contacts
        .iter()
        .map(|l| {
            assert_eq!(l.order, DiscontinuityOrder::D0);
            l.ends.map(|p| p + scene.origin)
        })
        .collect();
    (lines.iter().map(|[a, b]| a.distance(*b)).sum(), lines)
}

#[test]
fn a_box_in_a_box_draws_where_they_meet_and_is_dark_inside() {
    let mut polygons = faces_of_box(
        [
            "b left", "b right", "b bottom", "b top", "b back", "b front",
        ],
        DVec3::new(-1.0, 0.0, -1.0),
        DVec3::new(1.0, 1.0, 1.0),
    );
    polygons.extend(faces_of_box(
        [
            "c left", "c right", "c bottom", "c top", "c back", "c front",
        ],
        DVec3::new(0.0, 0.5, -0.5),
        DVec3::new(2.0, 1.5, 0.5),
    ));
    polygons.push(("lamp", level([-3.0, 4.0], [-3.0, 3.0], 4.0, false)));
    let world = clean(&scene(&polygons));
    let solution = bake(&world, ERROR, Bounces::Count(0));

    // Where c comes out of b: along a U on its top and a U on its right side.
    for (name, expected) in [
        ("b top", 3.0),
        ("b right", 2.0),
        ("c left", 1.0),
        ("c bottom", 1.0),
        ("c back", 1.5),
        ("c front", 1.5),
        ("b left", 0.0),
        ("c top", 0.0),
    ] {
        let (found, lines) = contacts(&solution, name);
        assert!(
            (found - expected).abs() < 1e-5,
            "{name}: {found} m, {lines:?}"
        );
    }
    let is_inside = |p: DVec3, lo: [f64; 3], hi: [f64; 3]| {
        (0..3).all(|i| p[i] >= lo[i] - 1e-5 && p[i] <= hi[i] + 1e-5)
    };
    // Every corner of an element that lies in both boxes is dark, however bright it is beside it.
    let (mut dark, mut bright) = (0.0, 0.0);
    for r in &solution.receivers {
        for (e, sites) in r.mesh.sites.iter().enumerate() {
            let centre = r.domain.frame.to_space(r.mesh.centre(e)) + world.scene.origin;
            let hidden = is_inside(centre, [-1.0, 0.0, -1.0], [1.0, 1.0, 1.0])
                && is_inside(centre, [0.0, 0.5, -0.5], [2.0, 1.5, 0.5]);
            let light = sites.map(|s| r.site_total(s as usize).mean());
            if hidden {
                dark += r.mesh.area(e);
                assert!(light.iter().all(|l| l.abs() < 1e-9), "{centre}: {light:?}");
            } else if light.iter().all(|&l| l > 1e-3) {
                bright += r.mesh.area(e);
            }
        }
    }
    // b's top and right side within c, c's left, bottom, back and front within b: on their fronts and backs.
    assert!(dark > 2.9, "{dark} m² are inside");
    assert!(bright > 10.0, "{bright} m² are lit");
}

#[test]
fn sheets_that_overlap_in_one_plane_are_lit_once_and_reported() {
    let polygons = [
        ("floor", level([0.0, 4.0], [0.0, 4.0], 0.0, true)),
        ("rug", level([1.0, 2.5], [1.0, 3.0], 0.0, true)),
        ("mat", level([2.0, 5.0], [1.5, 2.0], 0.0, true)),
        ("lamp", level([0.0, 4.0], [0.0, 4.0], 3.0, false)),
    ];
    let world = clean(&scene(&polygons));
    let solution = bake(&world, ERROR, Bounces::Count(0));
    let mut lit = 0.0;
    for r in &solution.receivers {
        let is_lamp = world.scene.material_of(r.domain.face).is_emitter();
        if r.is_lit && !is_lamp && r.domain.side == FaceSide::Front {
            lit += r.area();
        }
    }
    // The floor, and what of the mat is beside it.
    assert!((lit - (16.0 + 0.5)).abs() < 1e-4, "{lit} m²");
    let told = solution.summary.warnings.iter();
    let told: Vec<&String> = told.filter(|w| w.contains("same plane")).collect();
    assert_eq!(told.len(), 1, "{:?}", solution.summary.warnings);
    assert!(told[0].contains("same plane: 2"), "{}", told[0]);
}
