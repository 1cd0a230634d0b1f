//! Exact direct light at corresponding points.

use crate::common::bake::{clean, raw};
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use crate::common::scenes::read_fixture;
use glam::DVec3;
use umbrage::direct::DirectLight;
use umbrage::pipeline::World;
use umbrage::quantity::Rgb;
use umbrage::scene::RawScene;
use umbrage::visibility::{Scratch, Viewpoint};

/// Relative to the largest light found: a few hundred roundings.
const ROUND_OFF: f64 = 1e-12;

const SCENES: [&str; 5] = [
    "crossing-blockers",
    "box-on-table",
    "two-emitters",
    "non-convex-emitter",
    "l-room",
];

/// Random points on the fronts of a scene, with their normals.
pub(super) fn front_points(mesh: &ObjMesh, a_polygon: usize) -> Vec<[DVec3; 2]> {
    let mut rng = Rng::new(11);
    let mut points = Vec::new();
    for polygon in &mesh.polygons {
        for _ in 0..a_polygon {
            // A convex combination of the corners, inside.
            let weights: Vec<f64> = polygon
                .corners
                .iter()
                .map(|_| rng.range(0.05, 1.0))
                .collect();
            let sum: f64 = weights.iter().sum();
            let first = polygon.corners[0];
            let offset: DVec3 = polygon
                .corners
                .iter()
                .zip(&weights)
                .map(|(&c, w)| (c - first) * (w / sum))
                .sum();
            points.push([first + offset, polygon.normal()]);
        }
    }
    points
}

/// Direct irradiance at points of the scene's own coordinates.
pub(super) fn light_at(world: &World, points: &[[DVec3; 2]]) -> Vec<DVec3> {
    let light = DirectLight::new(&world.scene, &world.blockers);
    let mut scratch = Scratch::default();
    points
        .iter()
        .map(|&[p, n]| {
            let view = Viewpoint::new(p - world.scene.origin, n);
            light.irradiance(&view, &mut scratch).0.0
        })
        .collect()
}

/// Fails when the two differ by more than `tolerance` of the largest.
#[track_caller]
pub(super) fn assert_same(found: &[DVec3], expected: &[DVec3], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = expected.iter().map(|e| e.max_element()).fold(0.0, f64::max);
    assert!(largest > 0.0, "{what}: all is dark");
    for (i, (f, e)) in found.iter().zip(expected).enumerate() {
        assert!(
            (*f - *e).abs().max_element() <= tolerance * largest,
            "{what}: point {i} has {f} instead of {e}"
        );
    }
}

pub(super) fn with_positions(raw: &RawScene, change: impl Fn(DVec3) -> DVec3) -> RawScene {
    let mut changed = raw.clone();
    changed.positions.iter_mut().for_each(|p| *p = change(*p));
    changed
}

/// A quarter turn about y, exact.
pub(super) fn turn(v: DVec3) -> DVec3 {
    DVec3::new(v.z, v.y, -v.x)
}

pub(super) fn turned(raw: &RawScene) -> RawScene {
    with_positions(raw, turn)
}

pub(super) fn reversed(raw: &RawScene) -> RawScene {
    let mut changed = raw.clone();
    changed.polygons.reverse();
    changed
}

#[test]
fn a_quarter_turn_changes_no_light() {
    for name in SCENES {
        let raw = raw(name);
        let points = front_points(&read_fixture(name), 20);
        let expected = light_at(&clean(&raw), &points);
        let moved: Vec<_> = points.iter().map(|p| p.map(turn)).collect();
        let found = light_at(&clean(&turned(&raw)), &moved);
        assert_same(&found, &expected, ROUND_OFF, name);
    }
}

#[test]
fn the_order_of_polygons_changes_no_light() {
    for name in SCENES {
        let raw = raw(name);
        let points = front_points(&read_fixture(name), 20);
        let expected = light_at(&clean(&raw), &points);
        let found = light_at(&clean(&reversed(&raw)), &points);
        assert_same(&found, &expected, ROUND_OFF, name);
    }
}

#[test]
fn two_emitters_give_the_sum_of_each_alone() {
    let both = raw("two-emitters");
    let alone = |lamp: &str| {
        let mut scene = both.clone();
        let mut dark = 0;
        for material in &mut scene.materials {
            if material.name.ends_with("-lamp") && material.name != lamp {
                material.emission.0 = Rgb::BLACK;
                dark += 1;
            }
        }
        assert!(dark > 0, "no other lamp than {lamp}");
        clean(&scene)
    };
    let points = front_points(&read_fixture("two-emitters"), 100);
    let red = light_at(&alone("red-lamp"), &points);
    let blue = light_at(&alone("blue-lamp"), &points);
    let sum: Vec<DVec3> = red.iter().zip(&blue).map(|(r, b)| *r + *b).collect();
    let found = light_at(&clean(&both), &points);
    assert_same(&found, &sum, ROUND_OFF, "two-emitters");
    assert_ne!(red, sum);
    assert_ne!(blue, sum);
}
