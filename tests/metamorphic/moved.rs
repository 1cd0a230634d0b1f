//! The fixtures far from the origin, and much smaller or larger: the same lines, the same light.

use super::direct::{assert_same, front_points, light_at};
use crate::common::bake::{clean, raw, raw_at, world};
use crate::common::rng::Rng;
use crate::common::scenes::{fixture_names, read_fixture, shared_scene};
use glam::DVec3;
use std::collections::BTreeMap;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{Discontinuity, LineTolerance, find_lines};
use umbrage::geom::newell_normal;
use umbrage::pipeline::World;
use umbrage::scene::{FaceSide, RawScene};

/// Relative to the largest light found.
const TOLERANCE: f64 = 1e-6;

/// Scene and the step (metres) of which its moved versions, which are exact, are 10⁴ and 10⁶.
const EXACTLY_MOVED: [(&str, f64); 4] = [
    ("square-over-square", 8.0),
    ("rotated-blocker", 8.0),
    ("box-on-table", 8.0),
    ("blinds", 4.0),
];

/// Where the rounding of all coordinates parts events that coincide, lines may come and go: so many of those of the slats of a
/// blind, which line up exactly or not, and of boxes with two lamps on each edge.
const COINCIDENCES: [(&str, f64); 2] = [("D1", 0.002), ("D2", 0.02)];
const COINCIDENT: [&str; 2] = ["blinds", "furnace-cornell"];

/// Number of lines for each label.
type Counts = BTreeMap<String, usize>;

fn lines(world: &World, label: impl Fn(&Discontinuity) -> String) -> Counts {
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

fn by_kind(line: &Discontinuity) -> String {
    format!("{:?} {:?}", line.kind, line.order)
}

/// Where two events draw the same line, either may come first once coordinates are rounded.
fn by_order(line: &Discontinuity) -> String {
    format!("{:?}", line.order)
}

/// Moves that are exact: every line has its twin of the same kind and order.
fn check_exact_move(suffix: &str, factor: f64) {
    for (name, step) in EXACTLY_MOVED {
        let what = format!("{name}-{suffix}");
        let (plain, other) = (world(name), world(&what));
        assert_eq!(lines(&other, by_kind), lines(&plain, by_kind), "{what}");
        let moved = |p| p + DVec3::splat(factor * step);
        check_light(name, &plain, &other, moved, &what);
    }
}

/// The light at random points of a fixture is what it is at the same points of its moved version.
fn check_light(
    name: &str,
    plain: &World,
    other: &World,
    moved: impl Fn(DVec3) -> DVec3,
    what: &str,
) {
    let points = front_points(&read_fixture(name), 10);
    let places: Vec<_> = points.iter().map(|&[p, n]| [moved(p), n]).collect();
    let (found, expected) = (light_at(other, &places), light_at(plain, &points));
    assert_same(&found, &expected, TOLERANCE, what);
}

/// The scene with every coordinate moved and rounded.
fn moved_scene(raw: &RawScene, moved: impl Fn(DVec3) -> DVec3) -> World {
    let mut raw = raw.clone();
    raw.positions.iter_mut().for_each(|p| *p = moved(*p));
    clean(&raw)
}

/// As many lines of each order, or nearly so where edges line up.
fn assert_same_orders(plain: &World, other: &World, is_aligned: bool, what: &str) {
    let (mut found, mut expected) = (lines(other, by_order), lines(plain, by_order));
    for (order, share) in COINCIDENCES.iter().filter(|_| is_aligned) {
        let [a, b] = [&mut found, &mut expected].map(|counts| counts.remove(*order).unwrap_or(0));
        assert!(
            a.abs_diff(b) as f64 <= share * b as f64,
            "{what}: {a} {order} lines instead of {b}"
        );
    }
    assert_eq!(found, expected, "{what}");
}

/// All fixtures of our own with every coordinate moved and rounded: as many lines, the same light.
fn check_rounded(what: &str, moved: impl Fn(DVec3) -> DVec3) {
    let is_version = |name: &str| ["-s1e", "-t1e"].iter().any(|v| name.contains(v));
    for name in fixture_names().iter().filter(|n| !is_version(n)) {
        let what = format!("{name} {what}");
        let plain = raw(name);
        let (plain, other) = (clean(&plain), moved_scene(&plain, &moved));
        assert_same_orders(
            &plain,
            &other,
            COINCIDENT.iter().any(|c| name.starts_with(c)),
            &what,
        );
        check_light(name, &plain, &other, &moved, &what);
    }
}

#[test]
fn a_scene_ten_thousand_times_its_size_away_is_the_same() {
    check_exact_move("t1e4", 1e4);
}

#[test]
fn a_scene_a_million_times_its_size_away_is_the_same() {
    check_exact_move("t1e6", 1e6);
}

#[test]
fn scenes_a_million_metres_away_are_the_same() {
    check_rounded("a million metres away", |p| p + DVec3::splat(1e6));
}

#[test]
fn scenes_of_millimetres_are_the_same() {
    check_rounded("a thousandth", |p| p / 1000.0);
}

#[test]
fn scenes_of_kilometres_are_the_same() {
    check_rounded("a thousandfold", |p| p * 1000.0);
}

/// A change of all coordinates.
type Move = fn(DVec3) -> DVec3;

/// The shared scenes are written in few digits: what these let coincide, rounding parts. So many lines may come or go, as a share
/// of those of their order, and at so many of the points the light may be another.
const PARTED_LINES: f64 = 0.03;
const PARTED_POINTS: f64 = 0.01;

/// Points at which the light of a shared scene is compared.
const POINTS: usize = 300;

/// Random points on the polygons that have three or four corners, by their area, with their normals.
fn points_of(raw: &RawScene) -> Vec<[DVec3; 2]> {
    let mut triangles = Vec::new();
    let mut areas = vec![0.0];
    for polygon in raw.polygons.iter().filter(|p| p.corners.len() <= 4) {
        let corner = |i: usize| raw.positions[polygon.corners[i] as usize];
        for i in 2..polygon.corners.len() {
            let triangle = [corner(0), corner(i - 1), corner(i)];
            areas.push(areas[triangles.len()] + newell_normal(triangle).length());
            triangles.push(triangle);
        }
    }
    let mut rng = Rng::new(5);
    let mut point = || {
        let at = rng.unit() * areas[triangles.len()];
        let [a, b, c] = triangles[areas.partition_point(|&s| s <= at) - 1];
        // Half of the square is the triangle; the other half is turned onto it.
        let (mut u, mut v) = (rng.unit(), rng.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let normal = newell_normal([a, b, c]).normalize();
        [a + (b - a) * u + (c - a) * v, normal]
    };
    (0..POINTS).map(|_| point()).collect()
}

#[test]
#[ignore = "minutes: the lines of all shared scenes four times"]
fn shared_scenes_moved_and_scaled_have_the_same_lines_and_light() {
    let moves: [(&str, Move); 3] = [
        ("a million away", |p| p + DVec3::splat(1e6)),
        ("a thousandth", |p| p / 1000.0),
        ("a thousandfold", |p| p * 1000.0),
    ];
    let scenes = [
        "cornell-mcguire/cornell-mcguire.obj",
        "cornell-bitterli/cornell-bitterli.obj",
        "veach-ajar/veach-ajar.obj",
        "freedoom-e2m2/freedoom-e2m2.obj",
        "godot-living-room/living_room_lit.glb",
        "modern-hall/modern-hall.obj",
        "veach-ajar/veach-ajar-full.glb",
        "fzk-haus/fzk-haus.obj",
        "pandora/pandora.obj",
        "wooden-staircase/wooden-staircase.glb",
    ];
    let mut misses = Vec::new();
    for path in scenes.iter().filter_map(|s| shared_scene(s)) {
        let raw = raw_at(&path);
        let points = points_of(&raw);
        let plain = clean(&raw);
        let expected = lines(&plain, by_order);
        let light = light_at(&plain, &points);
        let largest = light.iter().map(|e| e.max_element()).fold(0.0, f64::max);
        for (what, moved) in moves {
            let what = format!("{} {what}", path.display());
            let other = moved_scene(&raw, moved);
            let found = lines(&other, by_order);
            let places: Vec<_> = points.iter().map(|&[p, n]| [moved(p), n]).collect();
            let differences = light_at(&other, &places)
                .into_iter()
                .zip(&light)
                .map(|(a, &b)| (a - b).abs().max_element() / largest);
            let parted = differences.filter(|&d| d > TOLERANCE).count();
            eprintln!(
                "{what}: {found:?}, unmoved {expected:?}; other light at {parted} of {POINTS} points"
            );
            for (order, &count) in &expected {
                let other = found.get(order).copied().unwrap_or(0);
                if other.abs_diff(count) as f64 > PARTED_LINES * count as f64 {
                    misses.push(format!("{what}: {other} {order} lines instead of {count}"));
                }
            }
            if parted as f64 > PARTED_POINTS * POINTS as f64 {
                misses.push(format!("{what}: other light at {parted} points"));
            }
        }
    }
    assert!(misses.is_empty(), "{misses:#?}");
}
