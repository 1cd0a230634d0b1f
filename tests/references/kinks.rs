//! The kink finder, on made-up functions and on light whose breaks are known.

use super::UP;
use crate::common::kinks::{Kink, KinkSettings, find_kinks};
use crate::common::reference::DirectReference;
use crate::common::rng::Rng;
use crate::common::scenes::read_fixture;
use glam::DVec3;

/// Smooth light with breaks `(position, order, size)` added: `size (t - position)^order` to the right of each.
pub(super) fn broken(t: f64, breaks: &[(f64, i32, f64)]) -> f64 {
    let smooth = (1.3 * t).sin() + 1.0 / (1.0 + 2.0 * (t - 0.4) * (t - 0.4));
    let added = breaks
        .iter()
        .filter(|b| t > b.0)
        .map(|&(at, order, size)| size * (t - at).powi(order));
    smooth + added.sum::<f64>()
}

pub(super) fn kinks_of(breaks: &[(f64, i32, f64)]) -> Vec<Kink> {
    find_kinks(&|t| broken(t, breaks), (0.0, 1.0), &KinkSettings::default())
}

/// The order, or −1 for several breaks at once.
pub(super) fn order_of(kink: &Kink) -> i32 {
    kink.order.map_or(-1, i32::from)
}

#[test]
fn smooth_functions_have_no_kinks() {
    let functions: [fn(f64) -> f64; 5] = [
        |t| broken(t, &[]),
        |t| (20.0 * t).sin(),
        |_| 3.0,
        |t| (-40.0 * (t - 0.3) * (t - 0.3)).exp(),
        |t| 1.0 / (0.01 + t * t),
    ];
    for (i, f) in functions.iter().enumerate() {
        let found = find_kinks(f, (0.0, 1.0), &KinkSettings::default());
        assert!(found.is_empty(), "function {i}: {found:?}");
    }
}

#[test]
fn kinks_of_each_order_are_found_and_measured() {
    for (order, sizes) in [
        (0, [1.0, 1e-3, 1e-6, 1e-9, 1e-11]),
        (1, [1.0, 1e-2, 1e-4, 1e-6, 1e-8]),
        (2, [10.0, 1.0, 1e-1, 1e-2, 1e-3]),
    ] {
        for size in sizes {
            for at in [0.123_456_789, 0.5, std::f64::consts::FRAC_1_PI * 2.7] {
                let found = kinks_of(&[(at, order, size)]);
                let what = format!("order {order}, size {size}, at {at}: {found:?}");
                assert_eq!(found.len(), 1, "{what}");
                let kink = found[0];
                assert_eq!(order_of(&kink), order, "{what}");
                assert!((kink.t - at).abs() <= kink.uncertainty.max(1e-9), "{what}");
                // Half of the second derivative is the factor of the square; values are scaled to a maximum of 1.
                let scale = (0..=64)
                    .map(|i| broken(f64::from(i) / 64.0, &[(at, order, size)]).abs())
                    .fold(0.0, f64::max);
                let expected = if order == 2 { 2.0 * size } else { size } / scale;
                let jump = kink.jumps[order as usize];
                assert!(
                    (jump / expected - 1.0).abs() < 0.05,
                    "{what}: jump {jump:e} for {expected:e}"
                );
            }
        }
    }
}

#[test]
fn kinks_close_to_each_other_are_told_apart() {
    for distance in [0.1, 0.03, 0.01, 0.003] {
        let breaks = [
            (0.31, 1, 0.5),
            (0.31 + distance, 2, 3.0),
            (0.31 + 2.0 * distance, 0, 0.01),
        ];
        let found = kinks_of(&breaks);
        let orders: Vec<i32> = found.iter().map(order_of).collect();
        assert_eq!(orders, [1, 2, 0], "at a distance of {distance}: {found:?}");
        for (kink, (at, ..)) in found.iter().zip(breaks) {
            assert!(
                (kink.t - at).abs() < 0.02 * distance,
                "at a distance of {distance}: {found:?}"
            );
        }
    }
}

#[test]
fn kinks_too_close_to_tell_apart_are_no_jump() {
    for order in [1, 2] {
        let found = kinks_of(&[(0.31, order, 1.0), (0.310_03, order, -1.0)]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_ne!(found[0].order, Some(0), "{found:?}");
        assert!((found[0].t - 0.31).abs() < 2e-4, "{found:?}");
    }
}

#[test]
fn kinks_are_found_wherever_they_are() {
    let mut rng = Rng::new(43);
    for order in 0..=2 {
        for _ in 0..100 {
            let at = rng.range(0.05, 0.95);
            let found = kinks_of(&[(at, order, 0.3)]);
            let orders: Vec<i32> = found.iter().map(order_of).collect();
            assert_eq!(orders, [order], "at {at}: {found:?}");
        }
    }
}

#[test]
fn kinks_of_a_penumbra_are_where_the_geometry_says() {
    let scene = DirectReference::new(&read_fixture("square-over-square"));
    // Along x at z = 0.1: the penumbra's ends, all of them coplanar edges, and nothing in between.
    let along = |x: f64| scene.irradiance(DVec3::new(x, 0.0, 0.1), UP).x;
    let found = find_kinks(&along, (-2.7, 2.9), &KinkSettings::default());
    let expected = [-1.5, -0.5, 0.5, 1.5];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (kink, at) in found.iter().zip(expected) {
        assert_eq!(kink.order, Some(1), "{found:?}");
        assert!((kink.t - at).abs() < 1e-9, "{found:?}");
    }
}

#[test]
fn kinks_of_generic_penumbrae_lie_on_critical_planes() {
    for name in ["rotated-blocker", "tilted-triangle"] {
        let mesh = read_fixture(name);
        let scene = DirectReference::new(&mesh);
        let corners = |object: &str| -> Vec<DVec3> {
            let polygon = mesh.polygons.iter().find(|p| p.object == object);
            polygon.expect("the object is there").corners.clone()
        };
        let (emitter, blocker) = (corners("lamp"), corners("blocker"));
        let mut most = 0;
        for z in [0.1, -0.43, 0.77] {
            // Where a plane through a corner of one and an edge of the other meets the line.
            let mut planes = Vec::new();
            for (points, edges) in [(&emitter, &blocker), (&blocker, &emitter)] {
                for &p in points {
                    for (i, &a) in edges.iter().enumerate() {
                        let n = (a - p).cross(edges[(i + 1) % edges.len()] - a);
                        planes.push(n.dot(p - DVec3::new(0.0, 0.0, z)) / n.x);
                    }
                }
            }
            let along = |x: f64| scene.irradiance(DVec3::new(x, 0.0, z), UP).x;
            let found = find_kinks(&along, (-2.7, 2.9), &KinkSettings::default());
            most = most.max(found.len());
            for kink in &found {
                assert_eq!(kink.order, Some(2), "{name}, z = {z}: {kink:?}");
                let off = |plane: &f64| (plane - kink.t).abs();
                let nearest = planes.iter().map(off).fold(f64::INFINITY, f64::min);
                assert!(
                    nearest <= 1e-7,
                    "{name}, z = {z}: {kink:?} is {nearest:e} m off"
                );
            }
        }
        assert!(most >= 6, "{name}: at most {most} kinks on a line");
    }
}

#[test]
fn contact_line_and_horizon_are_breaks_of_value_and_slope() {
    let scene = DirectReference::new(&read_fixture("wall-piercing-floor"));
    let along = |x: f64| scene.irradiance(DVec3::new(x, 0.0, 0.0), UP).x;
    let found = find_kinks(&along, (-1.3, 1.6), &KinkSettings::default());
    let contact: Vec<_> = found.iter().filter(|k| k.order == Some(0)).collect();
    assert_eq!(contact.len(), 1, "{found:?}");
    assert!(contact[0].t.abs() < 1e-7, "{found:?}");

    let scene = DirectReference::new(&read_fixture("emitter-plane-on-receiver"));
    let along = |x: f64| scene.irradiance(DVec3::new(x, 0.0, 0.3), UP).x;
    let found = find_kinks(&along, (-2.7, 2.9), &KinkSettings::default());
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].order, Some(1), "{found:?}");
    assert!((found[0].t + 0.5).abs() < 1e-9, "{found:?}");
}
