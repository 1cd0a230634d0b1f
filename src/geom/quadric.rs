//! The lines that meet three skew lines: one family of rulings of a quadric, and the conics it draws on planes.
//!
//! With `p(t)` on the first line, the ruling through it is where the planes through `p(t)` and each other line meet.
//! Both planes are linear in `t`, so the ruling's Plücker coordinates (direction and moment) are quadratic: it meets any
//! other line at no more than two `t`, and any plane in a conic, `x(t) = (n × m(t) + w d(t)) / (n · d(t))`.

use super::Plane;
use glam::DVec3;

/// Bisections of a chord at most: a guard against tolerances below round-off. Arcs that run far along a hyperbola need
/// up to a dozen, because their parameter runs unevenly.
const MAX_DEPTH: u32 = 16;

/// `c[0] + c[1] t + c[2] t²`.
type Quadratic<T> = [T; 3];

/// The lines that meet three segments in space, by the parameter `t` (0…1) at which they meet the first.
#[derive(Clone, Debug)]
pub struct Regulus {
    /// Start of the first segment; everything else is relative to it.
    origin: DVec3,
    /// Start and direction of each segment.
    segments: [(DVec3, DVec3); 3],
    direction: Quadratic<DVec3>,
    moment: Quadratic<DVec3>,
}

/// One line that meets the three.
#[derive(Clone, Copy, Debug)]
pub struct Ruling {
    /// Where it meets each segment, metres.
    pub points: [DVec3; 3],
    /// Its direction, unit.
    pub direction: DVec3,
}

/// A plane through `p(t)` and a segment: `(n0 + t n1) · x = t w`.
struct Pencil {
    n: [DVec3; 2],
    w: f64,
}

impl Regulus {
    /// None when two of the segments' lines lie in one plane, within `tolerance` (metres): such lines are met by the rays
    /// of planar fans instead.
    pub fn new(segments: [[DVec3; 2]; 3], tolerance: f64) -> Option<Self> {
        let origin = segments[0][0];
        let s = segments.map(|[a, b]| (a - origin, b - a));
        if (0..3).any(|i| are_coplanar(s[i], s[(i + 1) % 3], tolerance)) {
            return None;
        }
        let [p, q] = [pencil(s[0].1, s[1]), pencil(s[0].1, s[2])];
        let direction = [
            p.n[0].cross(q.n[0]),
            p.n[0].cross(q.n[1]) + p.n[1].cross(q.n[0]),
            p.n[1].cross(q.n[1]),
        ];
        let moment = [
            DVec3::ZERO,
            p.n[0] * q.w - q.n[0] * p.w,
            p.n[1] * q.w - q.n[1] * p.w,
        ];
        Some(Self {
            origin,
            segments: s,
            direction,
            moment,
        })
    }

    /// Where the ruling meets segment `i` (1 or 2), as a share `numerator / denominator` of its length, both linear in `t`.
    fn share(&self, i: usize) -> ([f64; 2], [f64; 2]) {
        let other = pencil(self.segments[0].1, self.segments[3 - i]);
        let (a, u) = self.segments[i];
        (
            [-other.n[0].dot(a), other.w - other.n[1].dot(a)],
            [other.n[0].dot(u), other.n[1].dot(u)],
        )
    }

    /// The intervals of `t` in which the ruling meets all three segments within their ends.
    pub fn ranges(&self) -> Vec<(f64, f64)> {
        let shares = [self.share(1), self.share(2)];
        let mut cuts = vec![0.0, 1.0];
        for (n, d) in shares {
            for [c, m] in [n, d, [d[0] - n[0], d[1] - n[1]]] {
                let t = -c / m;
                if t > 0.0 && t < 1.0 {
                    cuts.push(t);
                }
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.dedup();
        let is_inside = |t: f64| {
            shares.iter().all(|(n, d)| {
                let s = (n[0] + n[1] * t) / (d[0] + d[1] * t);
                s > 0.0 && s < 1.0
            })
        };
        let mut out: Vec<(f64, f64)> = Vec::new();
        for pair in cuts.windows(2) {
            if !is_inside(0.5 * (pair[0] + pair[1])) {
                continue;
            }
            match out.last_mut() {
                Some(last) if last.1 >= pair[0] => last.1 = pair[1],
                _ => out.push((pair[0], pair[1])),
            }
        }
        out
    }

    /// The ruling at `t`.
    pub fn ruling(&self, t: f64) -> Ruling {
        let [first, second, third] = self.segments;
        let on = |i: usize, (a, u): (DVec3, DVec3)| {
            let (n, d) = self.share(i);
            a + u * ((n[0] + n[1] * t) / (d[0] + d[1] * t))
        };
        let points = [first.1 * t, on(1, second), on(2, third)].map(|p| p + self.origin);
        Ruling {
            points,
            direction: at(&self.direction, t).normalize_or_zero(),
        }
    }

    /// The parameters inside (`from`, `to`) at which the ruling meets the line through `a` and `b`.
    pub fn meetings(&self, [a, b]: [DVec3; 2], from: f64, to: f64) -> Vec<f64> {
        let (u, p) = (b - a, a - self.origin);
        let m = p.cross(u);
        roots([0, 1, 2].map(|k| self.direction[k].dot(m) + self.moment[k].dot(u)))
            .into_iter()
            .filter(|&t| t > from && t < to)
            .collect()
    }

    /// The parameters inside (`from`, `to`) at which the ruling is parallel to a plane with this normal.
    pub fn parallels(&self, normal: DVec3, from: f64, to: f64) -> Vec<f64> {
        roots(self.direction.map(|d| d.dot(normal)))
            .into_iter()
            .filter(|&t| t > from && t < to)
            .collect()
    }

    /// The conic on `plane` from `t = from` to `t = to`.
    pub fn arc_on(&self, plane: &Plane, from: f64, to: f64) -> ConicArc {
        let n = plane.normal;
        let w = -plane.distance(self.origin);
        ConicArc {
            origin: self.origin,
            numerator: [0, 1, 2].map(|k| n.cross(self.moment[k]) + self.direction[k] * w),
            denominator: self.direction.map(|d| d.dot(n)),
            from,
            to,
        }
    }
}

/// An arc of a conic as a rational quadratic curve, `origin + numerator(t) / denominator(t)`, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct ConicArc {
    origin: DVec3,
    numerator: Quadratic<DVec3>,
    denominator: Quadratic<f64>,
    /// First parameter.
    pub from: f64,
    /// Last parameter.
    pub to: f64,
}

impl ConicArc {
    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        let [c, b, a] = self.denominator;
        self.origin + at(&self.numerator, t) / (c + (b + a * t) * t)
    }

    /// Points along the arc whose chords depart from it by no more than `tolerance`, metres; both ends included.
    pub fn chorded(&self, tolerance: f64) -> Vec<DVec3> {
        let mut points = vec![self.at(self.from)];
        self.divide((self.from, self.to), tolerance, MAX_DEPTH, &mut points);
        points
    }

    /// Appends the ends of the chords between two parameters.
    fn divide(&self, (from, to): (f64, f64), tolerance: f64, depth: u32, points: &mut Vec<DVec3>) {
        let (a, b) = (self.at(from), self.at(to));
        let middle = 0.5 * (from + to);
        // The parameter may run unevenly along the arc: three points tell how far it bulges.
        let is_flat = [0.25, 0.5, 0.75].iter().all(|s| {
            let p = self.at(from + (to - from) * s);
            distance_to_chord(p, a, b) <= tolerance
        });
        if is_flat || depth == 0 {
            points.push(b);
            return;
        }
        self.divide((from, middle), tolerance, depth - 1, points);
        self.divide((middle, to), tolerance, depth - 1, points);
    }
}

fn distance_to_chord(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
    p.distance(a + d * t)
}

fn at(c: &Quadratic<DVec3>, t: f64) -> DVec3 {
    c[0] + (c[1] + c[2] * t) * t
}

/// The planes through the points `t v` and the line `a + s u`.
fn pencil(v: DVec3, (a, u): (DVec3, DVec3)) -> Pencil {
    let turn = u.cross(v);
    Pencil {
        n: [a.cross(u), turn],
        w: turn.dot(a),
    }
}

/// True when the lines of two segments meet or are parallel within `tolerance`.
fn are_coplanar((a, u): (DVec3, DVec3), (b, v): (DVec3, DVec3), tolerance: f64) -> bool {
    let normal = u.cross(v);
    let longest = u.length().max(v.length());
    // Over the shorter segment's length parallel lines part by no more than the tolerance.
    normal.length() <= tolerance * longest
        || (b - a).dot(normal).abs() <= tolerance * normal.length()
}

/// Real roots of `c[0] + c[1] t + c[2] t²`, without cancellation (Kahan); none where it vanishes altogether.
fn roots([c, b, a]: Quadratic<f64>) -> Vec<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return Vec::new();
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    [q / a, c / q]
        .into_iter()
        .filter(|t| t.is_finite())
        .collect()
}

#[cfg(test)]
mod tests;
