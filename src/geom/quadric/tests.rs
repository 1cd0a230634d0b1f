//! Rulings and arcs of quadrics whose equations are known.

use super::*;

/// Lines nearer than this to a common plane count as lying in one, metres: far from those of the tests.
const COPLANAR: f64 = 1e-9;

/// Rounding of a few operations on coordinates up to 10.
const ROUNDOFF: f64 = 1e-12;

/// How far chords may depart from an arc, metres: coarse, middling, fine.
const CHORD_TOLERANCES: [f64; 3] = [1e-1, 1e-3, 1e-5];

/// Edges on {x = a, z = a·y}, a = 0, 1, 2: the quadric z = xy.
fn saddle() -> Regulus {
    let edge = |a: f64| [-4.0, 4.0].map(|y| DVec3::new(a, y, a * y));
    Regulus::new([edge(0.0), edge(1.0), edge(2.0)], COPLANAR).expect("the edges are skew")
}

#[test]
fn rulings_of_the_saddle_lie_on_it() {
    let saddle = saddle();
    assert_eq!(saddle.ranges(), [(0.0, 1.0)]);
    for t in [0.0, 0.1, 0.37, 0.5, 0.99] {
        let r = saddle.ruling(t);
        for s in [-3.0, 0.0, 0.5, 7.0] {
            let p = r.points[0] + r.direction * s;
            assert!((p.z - p.x * p.y).abs() < ROUNDOFF, "{p}");
        }
        // The rulings that meet the edges run in planes of constant y.
        for q in r.points {
            assert!((q.y - (8.0 * t - 4.0)).abs() < ROUNDOFF, "{q}");
        }
    }
}

#[test]
fn saddle_draws_hyperbolas_on_horizontal_planes() {
    let saddle = saddle();
    for c in [-2.0, 0.5, 3.0] {
        let plane = Plane::new(DVec3::Z * c, DVec3::Z);
        let arc = saddle.arc_on(&plane, 0.55, 1.0);
        let points = arc.chorded(CHORD_TOLERANCES[1] / 10.0);
        assert!(points.len() > 10, "{}", points.len());
        for p in points {
            assert!(
                (p.z - c).abs() < ROUNDOFF && (p.x * p.y - c).abs() < ROUNDOFF,
                "{p}"
            );
        }
    }
}

#[test]
fn chords_depart_from_their_arc_by_no_more_than_the_tolerance() {
    let arc = saddle().arc_on(&Plane::new(DVec3::Z, DVec3::Z), 0.52, 1.0);
    for tolerance in CHORD_TOLERANCES {
        let points = arc.chorded(tolerance);
        for i in 0..4000 {
            let p = arc.at(0.52 + 0.48 * f64::from(i) / 4000.0);
            let off = points
                .windows(2)
                .map(|w| distance_to_chord(p, w[0], w[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(off <= 1.1 * tolerance, "{off:e} off for {tolerance:e}");
        }
    }
}

#[test]
fn segments_end_the_range() {
    let edge = |a: f64, lo: f64, hi: f64| [lo, hi].map(|y| DVec3::new(a, y, a * y));
    let short = [
        edge(0.0, -4.0, 4.0),
        edge(1.0, -1.0, 2.0),
        edge(2.0, 0.0, 9.0),
    ];
    let regulus = Regulus::new(short, COPLANAR).expect("the edges are skew");
    let ranges = regulus.ranges();
    assert_eq!(ranges.len(), 1, "{ranges:?}");
    assert!((ranges[0].0 - 0.5).abs() < ROUNDOFF && (ranges[0].1 - 0.75).abs() < ROUNDOFF);
}

#[test]
fn a_fourth_line_is_met_twice_or_not_at_all() {
    let saddle = saddle();
    // On the quadric's other side of the diagonal x = y: z = x² = 1 at x = ±1.
    let line = [DVec3::new(-3.0, -3.0, 1.0), DVec3::new(3.0, 3.0, 1.0)];
    let mut t = saddle.meetings(line, 0.0, 1.0);
    t.sort_unstable_by(f64::total_cmp);
    assert_eq!(t.len(), 2, "{t:?}");
    assert!((t[0] - 0.375).abs() < ROUNDOFF && (t[1] - 0.625).abs() < ROUNDOFF);
    let above = line.map(|p| p - DVec3::Z * 2.0);
    assert!(saddle.meetings(above, 0.0, 1.0).is_empty());
}

#[test]
fn lines_in_one_plane_span_no_quadric() {
    let x = [DVec3::ZERO, DVec3::X];
    let skew = [DVec3::Y, DVec3::new(0.0, 1.0, 1.0)];
    let parallel = x.map(|p| p + DVec3::Z);
    let meeting = [DVec3::new(3.0, -1.0, -1.0), DVec3::new(3.0, 1.0, 1.0)];
    assert!(Regulus::new([x, skew, parallel], COPLANAR).is_none());
    assert!(Regulus::new([x, skew, meeting], COPLANAR).is_none());
}
