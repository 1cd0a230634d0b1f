//! Polygons with holes, in the plane and in space.

use super::predicates::{Side, side_of_line};
use glam::{DVec2, DVec3};

/// A polygon with holes: the first loop is the outline, counter-clockwise; the others are holes, clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygon2 {
    /// Closed loops without a repeated last point.
    pub loops: Vec<Vec<DVec2>>,
}

impl Polygon2 {
    /// Signed area: positive when the outline is counter-clockwise, holes subtracted.
    pub fn area(&self) -> f64 {
        self.loops.iter().map(|l| loop_area(l)).sum()
    }

    /// True when `p` lies inside (even–odd rule; points exactly on the outline may go either way).
    pub fn contains(&self, p: DVec2) -> bool {
        let mut inside = false;
        for (a, b) in self.loops.iter().flat_map(|l| edges(l)) {
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y) {
                inside = !inside;
            }
        }
        inside
    }

    /// Distance from `p` to the nearest point of any loop, metres.
    pub fn distance_to_outline(&self, p: DVec2) -> f64 {
        self.loops
            .iter()
            .flat_map(|l| edges(l))
            .map(|(a, b)| {
                let d = b - a;
                let t = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
                p.distance(a + d * t)
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// The longest stretch inside of the segment from `a` to `b`, as shares of its length; none when it stays outside.
    pub fn longest_inside(&self, a: DVec2, b: DVec2) -> Option<[f64; 2]> {
        let side = |p: DVec2| (b - a).perp_dot(p - a);
        let mut cuts = vec![0.0, 1.0];
        for (p, q) in self.loops.iter().flat_map(|l| edges(l)) {
            let (from, to) = (side(p), side(q));
            if (from > 0.0) != (to > 0.0) {
                let meets = p + (q - p) * (from / (from - to));
                let t = (meets - a).dot(b - a) / (b - a).length_squared();
                cuts.extend((t > 0.0 && t < 1.0).then_some(t));
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        let is_inside = |w: &[f64]| self.contains(a.lerp(b, f64::midpoint(w[0], w[1])));
        let stretches = cuts.windows(2).filter(|w| is_inside(w));
        let longest = stretches.max_by(|v, w| (v[1] - v[0]).total_cmp(&(w[1] - w[0])))?;
        Some([longest[0], longest[1]])
    }

    /// Smallest box around all loops.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        self.loops
            .iter()
            .flatten()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), &p| {
                (lo.min(p), hi.max(p))
            })
    }
}

/// The corners of the smallest convex polygon around all points, counter-clockwise, none in the middle of an edge (Andrew
/// 1979). Fewer than three when all lie on a line.
pub fn convex_hull(points: impl IntoIterator<Item = DVec2>) -> Vec<DVec2> {
    let mut points: Vec<DVec2> = points.into_iter().collect();
    points.sort_unstable_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    points.dedup();
    // From the first to the last point along the right, and back along the left.
    let mut hull: Vec<DVec2> = Vec::new();
    let half = |hull: &mut Vec<DVec2>, way: &mut dyn Iterator<Item = &DVec2>| {
        let first = hull.len();
        for &p in way {
            let bends = |h: &[DVec2]| side_of_line(h[0], h[1], p) == Side::Left;
            while hull.len() >= first + 2 && !bends(&hull[hull.len() - 2..]) {
                hull.pop();
            }
            hull.push(p);
        }
        // The next half begins there.
        hull.pop();
    };
    half(&mut hull, &mut points.iter());
    half(&mut hull, &mut points.iter().rev());
    hull
}

fn edges(points: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    points
        .iter()
        .copied()
        .zip(points.iter().copied().cycle().skip(1))
}

/// Signed area of a closed loop, m²: positive when it runs counter-clockwise.
///
/// Taken relative to the first point, so that a far-away loop loses no digits.
pub fn loop_area(points: &[DVec2]) -> f64 {
    let Some(&first) = points.first() else {
        return 0.0;
    };
    let twice: f64 = edges(points)
        .map(|(a, b)| (a - first).perp_dot(b - first))
        .sum();
    0.5 * twice
}

/// Twice the area vector of a closed loop in space (Newell): its direction is the normal, its length twice the area.
///
/// Taken relative to the first point, so that a far-away loop loses no digits.
pub fn newell_normal(points: impl IntoIterator<Item = DVec3>) -> DVec3 {
    let mut points = points.into_iter();
    let Some(first) = points.next() else {
        return DVec3::ZERO;
    };
    let mut sum = DVec3::ZERO;
    let mut previous = DVec3::ZERO;
    for p in points {
        let p = p - first;
        sum += previous.cross(p);
        previous = p;
    }
    sum
}
