//! The scenes are what their descriptions say.

use crate::common::rng::Rng;
use crate::common::scenes::{FURNACES, fixture_names, read_fixture, shared_scene};
use glam::DVec3;
use std::collections::BTreeMap;

#[test]
fn fixtures_are_convex_planar_and_complete() {
    let names = fixture_names();
    assert_eq!(names.len(), 44);
    for name in names {
        let mesh = read_fixture(&name);
        let (low, high) = mesh.bounds();
        // Coordinates moved by 10⁶ sizes keep ten digits; scaled ones are rounded once.
        let round_off = 4.0 * f64::EPSILON * low.abs().max(high.abs()).max_element();
        for polygon in &mesh.polygons {
            let n = polygon.normal();
            let corners = &polygon.corners;
            for (i, &a) in corners.iter().enumerate() {
                let (b, c) = (
                    corners[(i + 1) % corners.len()],
                    corners[(i + 2) % corners.len()],
                );
                let height = (a - polygon.centre()).dot(n);
                assert!(
                    height.abs() <= round_off,
                    "{name}: a face of {} bends by {height:e}",
                    polygon.object
                );
                assert!(
                    (b - a).cross(c - b).dot(n) > 0.0,
                    "{name}: a face of {} is not convex",
                    polygon.object
                );
            }
        }
        assert!(
            mesh.surfaces.iter().any(|s| s.ke != DVec3::ZERO),
            "{name}: no light"
        );
    }
}

#[test]
fn rooms_are_closed_and_face_inwards() {
    let rooms = FURNACES.iter().copied().chain(["l-room", "blinds"]);
    for name in rooms {
        let mesh = read_fixture(name);
        let mut edges: BTreeMap<[[u64; 3]; 2], i32> = BTreeMap::new();
        let mut volume = 0.0;
        for polygon in mesh.polygons.iter().filter(|p| p.object == "room") {
            let key = |v: DVec3| (v + DVec3::ZERO).to_array().map(f64::to_bits);
            let corners = &polygon.corners;
            for (i, &a) in corners.iter().enumerate() {
                let b = corners[(i + 1) % corners.len()];
                *edges.entry([key(a), key(b)]).or_default() += 1;
                *edges.entry([key(b), key(a)]).or_default() -= 1;
            }
            volume += polygon.area() * polygon.normal().dot(polygon.centre()) / 3.0;
        }
        assert!(!edges.is_empty(), "{name}: no room");
        assert!(
            edges.values().all(|&uses| uses == 0),
            "{name}: the room is open"
        );
        assert!(volume < 0.0, "{name}: the room faces outwards");
    }
}

#[test]
fn moved_fixtures_are_the_same_bits() {
    for (name, size) in [
        ("square-over-square", 8.0),
        ("rotated-blocker", 8.0),
        ("box-on-table", 8.0),
        ("blinds", 4.0),
    ] {
        let plain = read_fixture(name);
        for (suffix, times) in [("t1e4", 1e4), ("t1e6", 1e6)] {
            let moved = read_fixture(&format!("{name}-{suffix}"));
            assert_eq!(plain.polygons.len(), moved.polygons.len());
            for (a, b) in plain.polygons.iter().zip(&moved.polygons) {
                let back: Vec<DVec3> = b
                    .corners
                    .iter()
                    .map(|&c| c - DVec3::splat(size * times))
                    .collect();
                assert_eq!(a.corners, back, "{name}-{suffix}");
            }
        }
    }
}

#[test]
fn a_missing_shared_scene_is_none() {
    assert!(shared_scene("no-such-scene/no-such-file.obj").is_none());
}

#[test]
fn random_numbers_are_uniform_and_repeat() {
    let mut rng = Rng::new(1);
    // The generator's published first output for seed 0.
    assert_eq!(Rng::new(0).next_u64(), 0xe220_a839_7b1d_cdaf);
    let mut counts = [0_u32; 6];
    for _ in 0..6000 {
        counts[rng.below(6)] += 1;
    }
    assert!(
        counts.iter().all(|&c| (880..1120).contains(&c)),
        "{counts:?}"
    );
}
