use super::{FLAT, Patch, between};
use glam::DVec3;

fn patch(corners: &[[f64; 3]]) -> Patch {
    let corners: Vec<DVec3> = corners.iter().map(|&c| c.into()).collect();
    Patch::new(&corners, FLAT).expect("a convex polygon")
}

fn floor() -> Patch {
    patch(&[[0., 0., 0.], [0., 0., 1.], [1., 0., 1.], [1., 0., 0.]])
}

/// A unit square that shares the edge x = 0 of the floor and rises from it at an angle (radians).
fn wall(angle: f64) -> Patch {
    let (y, x) = angle.sin_cos();
    patch(&[[0., 0., 0.], [x, y, 0.], [x, y, 1.], [0., 0., 1.]])
}

/// The factor of the floor to the wall by Gauss over both points, in pieces that shrink by two towards the shared edge's
/// ends: knows nothing of contours.
fn by_area(angle: f64) -> f64 {
    let wall = wall(angle);
    let graded: Vec<f64> = (0..=30)
        .map(|k| if k == 0 { 0.0 } else { 0.5_f64.powi(30 - k) })
        .collect();
    let mut sum = 0.0;
    for x in graded.windows(2) {
        for z in graded.windows(2) {
            for (s, ws) in super::rule::nodes(0.5 * (x[0] + x[1]), 0.5 * (x[1] - x[0])) {
                for (t, wt) in super::rule::nodes(0.5 * (z[0] + z[1]), 0.5 * (z[1] - z[0])) {
                    // Symmetric about z = ½: one half counts twice.
                    let p = DVec3::new(s, 0.0, 0.5 * t);
                    sum += ws * wt * crate::direct::form_factor(p, DVec3::Y, wall.corners());
                }
            }
        }
    }
    sum
}

#[test]
fn walls_at_any_angle_are_what_points_find() {
    for degrees in [20.0_f64, 45.0, 60.0, 90.0, 120.0, 150.0] {
        let angle = degrees.to_radians();
        let found = between(&floor(), &wall(angle), 1e-12).from_first();
        let expected = by_area(angle);
        let off = (found.value - expected).abs();
        assert!(
            found.is_proven && found.error <= 2e-12,
            "{degrees}°: {found:?}"
        );
        assert!(
            off <= found.error + 1e-11,
            "{degrees}°: {found:?} instead of {expected:.15}"
        );
    }
}

#[test]
fn both_ways_round_are_the_same_to_the_last_bit() {
    let (a, b) = (floor(), wall(1.1));
    let c = patch(&[[0.2, 0.7, 0.1], [1.3, 0.9, 0.4], [0.6, 1.2, 1.7]]);
    for (a, b) in [(&a, &b), (&a, &c), (&c, &b)] {
        assert_eq!(between(a, b, 1e-9).area, between(b, a, 1e-9).area);
    }
}

#[test]
fn a_tighter_tolerance_stays_within_the_looser_one() {
    let c = patch(&[[-0.4, 0.05, 0.1], [1.3, 0.9, 0.4], [0.6, 1.2, 1.7]]);
    let finest = between(&floor(), &c, 1e-14).from_first();
    for tolerance in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
        let found = between(&floor(), &c, tolerance).from_first();
        let off = (found.value - finest.value).abs();
        assert!(
            off <= found.error + finest.error && found.error <= tolerance,
            "{tolerance:e}: {found:?}, {off:e} off"
        );
    }
}

#[test]
fn far_away_a_factor_is_that_of_a_point() {
    for distance in [10.0, 1e2, 1e3, 1e4] {
        let d = DVec3::new(0.3, 1.0, -0.2).normalize() * distance;
        let corners: Vec<DVec3> = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]]
            .map(|[x, z]| DVec3::new(x, 0.0, z) + d)
            .into();
        let there = Patch::new(&corners, FLAT).expect("a square");
        let found = between(&floor(), &there, 1e-9).from_first();
        let cosine = d.y / distance;
        let expected = cosine * cosine / (std::f64::consts::PI * distance * distance);
        let off = (found.value / expected - 1.0).abs();
        // The next term is of the order of the square of size over distance.
        let limit = 2.0 / (distance * distance) + found.error / expected;
        assert!(
            off <= limit,
            "{distance}: {found:?} for {expected:e}, {off:e} off"
        );
        assert!(found.error <= 1e-13, "{distance}: {found:?}");
    }
}

#[test]
fn only_what_lies_in_front_of_both_counts() {
    // A wall through the middle of the floor: each half sees one side of it.
    let through = patch(&[[0.5, -1., 0.], [0.5, 1., 0.], [0.5, 1., 1.], [0.5, -1., 1.]]);
    let above = patch(&[[0.5, 0., 0.], [0.5, 1., 0.], [0.5, 1., 1.], [0.5, 0., 1.]]);
    let half = patch(&[[0.5, 0., 0.], [0.5, 0., 1.], [1., 0., 1.], [1., 0., 0.]]);
    let whole = between(&floor(), &through, 1e-12);
    let part = between(&half, &above, 1e-12);
    assert!((whole.area - part.area).abs() <= whole.error + part.error);
    // Back to back, side by side, and the same polygon twice.
    let below = patch(&[[0., -1., 0.], [1., -1., 0.], [1., -1., 1.], [0., -1., 1.]]);
    let beside = patch(&[[2., 0., 0.], [2., 0., 1.], [3., 0., 1.], [3., 0., 0.]]);
    for nothing in [&below, &beside, &floor()] {
        assert_eq!(between(&floor(), nothing, 1e-9).area, 0.0);
    }
}

#[test]
fn two_faces_a_millionth_apart_exchange_all_but_their_rims() {
    let gap = 1e-6;
    let lid = patch(&[[0., gap, 0.], [1., gap, 0.], [1., gap, 1.], [0., gap, 1.]]);
    let found = between(&floor(), &lid, 1e-12).from_first();
    // What leaves through the slit: 4 sides of length 1, gap/2 of each by the strips' formula, √(1 + g²) − g.
    let expected = 1.0 - 2.0 * gap;
    assert!(
        (found.value - expected).abs() <= 20.0 * gap * gap + found.error,
        "{found:?}"
    );
    assert!(found.error <= 1e-12);
}

#[test]
fn bad_corners_are_refused_in_words() {
    let refused = |corners: &[[f64; 3]]| {
        let corners: Vec<DVec3> = corners.iter().map(|&c| c.into()).collect();
        Patch::new(&corners, FLAT)
            .expect_err("no polygon")
            .to_string()
    };
    assert!(refused(&[[0., 0., 0.], [1., 0., 0.]]).contains("three"));
    assert!(refused(&[[0., 0., 0.], [1., 0., 0.], [f64::NAN, 1., 0.]]).contains("finite"));
    assert!(refused(&[[0., 0., 0.], [1., 0., 0.], [2., 0., 0.]]).contains("no area"));
    let bent = [[0., 0., 0.], [1., 0., 0.], [1., 0.1, 1.], [0., 0., 1.]];
    assert!(refused(&bent).contains("bends"));
    let dart = [[0., 0., 0.], [0.2, 0., 0.1], [0., 0., 1.], [-0.2, 0., 0.1]];
    assert!(!refused(&[dart[0], [0.05, 0., 0.5], dart[2], [1., 0., 0.5]]).is_empty());
}
