//! The fixtures far from the origin, and much smaller or larger: the same lines, the same light.

use super::direct::{assert_same, front_points, light_at};
use crate::common::bake::world;
use crate::common::scenes::read_fixture;
use glam::DVec3;
use std::collections::BTreeMap;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{Discontinuity, LineTolerance, find_lines};
use umbrage::pipeline::World;
use umbrage::scene::FaceSide;

/// Relative to the largest light found.
const TOLERANCE: f64 = 1e-6;

/// Scene and the step (metres) of which its moved versions are 10⁴ and 10⁶.
const SCENES: [(&str, f64); 4] = [
    ("square-over-square", 8.0),
    ("rotated-blocker", 8.0),
    ("box-on-table", 8.0),
    ("blinds", 4.0),
];

/// Lines that may come and go with the rounding of all coordinates: among D1 those of face planes (seen through the rows
/// of a blind, whose slats line up exactly or not), among D2 those of events that coincide.
const FACE_PLANES: f64 = 0.04;
const COINCIDENCES: f64 = 0.02;

/// Number of lines for each label.
type Counts = BTreeMap<String, usize>;

fn line_counts(world: &World, label: impl Fn(&Discontinuity) -> String) -> Counts {
    let scene = &world.scene;
    let lines = find_lines(
        scene,
        &DirectLight::new(scene, &world.blockers),
        LineTolerance::default(),
    );
    let mut counts = Counts::new();
    for face in scene.faces.ids() {
        for side in [FaceSide::Front, FaceSide::Back] {
            let found = lines.of(face, side);
            for line in found.contacts.iter().chain(&found.candidates) {
                *counts.entry(label(line)).or_default() += 1;
            }
        }
    }
    counts
}

fn check(
    suffix: &str,
    moved: impl Fn(DVec3, f64) -> DVec3,
    compare: impl Fn(&World, &World, &str),
) {
    for (name, step) in SCENES {
        let what = format!("{name}-{suffix}");
        let (plain, other) = (world(name), world(&what));
        let points = front_points(&read_fixture(name), 10);
        let expected = light_at(&plain, &points);
        let places: Vec<_> = points.iter().map(|&[p, n]| [moved(p, step), n]).collect();
        assert_same(&light_at(&other, &places), &expected, TOLERANCE, &what);
        compare(&plain, &other, &what);
    }
}

/// Moves are exact: every line has its twin of the same kind and order.
fn same_kinds(plain: &World, other: &World, what: &str) {
    let label = |line: &Discontinuity| format!("{:?} {:?}", line.kind, line.order);
    let (found, expected) = (line_counts(other, label), line_counts(plain, label));
    assert_eq!(found, expected, "{what}");
}

/// Scaling rounds every coordinate: where a VE and an EV event draw the same line either may come first, and lines as short
/// as the rounding may come and go, as may those of face planes that cut an emitter. Jumps of the value may not.
fn same_orders(plain: &World, other: &World, what: &str) {
    let label = |line: &Discontinuity| format!("{:?}", line.order);
    let (mut found, mut expected) = (line_counts(other, label), line_counts(plain, label));
    for (order, share) in [("D1", FACE_PLANES), ("D2", COINCIDENCES)] {
        let [a, b] = [&mut found, &mut expected].map(|counts| counts.remove(order).unwrap_or(0));
        assert!(
            a.abs_diff(b) as f64 <= share * b as f64,
            "{what}: {a} {order} lines instead of {b}"
        );
    }
    assert_eq!(found, expected, "{what}");
}

#[test]
fn a_scene_ten_thousand_times_its_size_away_is_the_same() {
    check("t1e4", |p, step| p + DVec3::splat(1e4 * step), same_kinds);
}

#[test]
fn a_scene_a_million_times_its_size_away_is_the_same() {
    check("t1e6", |p, step| p + DVec3::splat(1e6 * step), same_kinds);
}

#[test]
fn a_scene_of_millimetres_is_the_same() {
    check("s1e-3", |p, _| p / 1000.0, same_orders);
}

#[test]
fn a_scene_of_kilometres_is_the_same() {
    check("s1e3", |p, _| p * 1000.0, same_orders);
}
