//! `∫∫ ln r ds·dt` over two straight edges.
//!
//! ```text
//!       t0 ──────── t1     u = t − foot of x
//!            │ h           ½ ∫ ln(h² + u²) du = u/2 ln(h² + u²) − u + h atan(u/h)
//!      ──────x──────       and once more, for parallel edges
//! ```

use super::patch::ROUNDINGS;
use super::rule;
use glam::DVec3;

/// Pieces of one edge at most: beyond that the bound is what it is.
const MAX_PIECES: usize = 4096;

/// Pieces near a singular point shrink by two; so many of them may have this share of the permitted error each.
const SINGULAR_SHARE: f64 = 1.0 / 64.0;

/// Edges are far from each other when Gauss's rule reaches to this error, relative to their lengths, without division.
const FAR_ERROR: f64 = f64::EPSILON;

/// Roundings of the closed forms: of each term, relative to it.
const TERM_ROUNDOFF: f64 = 16.0 * f64::EPSILON;

/// An integral and a bound of its error.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounded {
    pub(super) value: f64,
    pub(super) error: f64,
}

impl Bounded {
    pub(super) fn add(&mut self, other: Self) {
        self.value += other.value;
        self.error += other.error;
    }
}

/// A directed edge.
#[derive(Clone, Copy)]
struct Edge {
    start: DVec3,
    /// Unit.
    direction: DVec3,
    length: f64,
}

impl Edge {
    fn new([a, b]: [DVec3; 2]) -> Option<Self> {
        let length = a.distance(b);
        (length > 0.0).then(|| Self {
            start: a,
            direction: (b - a) / length,
            length,
        })
    }

    fn at(&self, s: f64) -> DVec3 {
        self.start + self.direction * s
    }

    fn distance(&self, p: DVec3) -> f64 {
        let t = self.direction.dot(p - self.start).clamp(0.0, self.length);
        p.distance(self.at(t))
    }
}

/// `∫∫ ln(r / unit) ds·dt` over the edges `a` and `b`, to about `permitted` where that can be reached.
pub(super) fn integral(a: [DVec3; 2], b: [DVec3; 2], unit: f64, permitted: f64) -> Bounded {
    let (Some(a), Some(b)) = (Edge::new(a), Edge::new(b)) else {
        return Bounded::default();
    };
    let cosine = a.direction.dot(b.direction);
    if cosine == 0.0 {
        return Bounded::default();
    }
    let between = far(a, b, unit)
        .or_else(|| parallel(a, b, unit, permitted / cosine.abs()))
        .unwrap_or_else(|| skew(a, b, unit, permitted / cosine.abs()));
    Bounded {
        value: cosine * between.value,
        error: cosine.abs() * between.error,
    }
}

/// Gauss's rule along both edges, where they are so far from each other that it is as exact as numbers are: closed forms
/// would lose the digits that the differences of large terms lose.
fn far(a: Edge, b: Edge, unit: f64) -> Option<Bounded> {
    let (ha, hb) = (0.5 * a.length, 0.5 * b.length);
    let way = b.at(hb) - a.at(ha);
    // From the middle of either edge to any point of the other.
    let distance = way.length() - ha.max(hb);
    let error = rule::bound(ha, distance) * b.length + rule::bound(hb, distance) * a.length;
    // Not true of an infinite error either.
    let is_exact = error <= FAR_ERROR * a.length * b.length;
    is_exact.then(|| {
        let (mut value, mut size) = (0.0, 0.0);
        let squared = unit * unit;
        let constant = (way.length_squared() - squared) / squared;
        for (s, ws) in rule::nodes(0.0, ha) {
            for (t, wt) in rule::nodes(0.0, hb) {
                let d = b.direction * t - a.direction * s;
                let more = (2.0 * way.dot(d) + d.length_squared()) / squared;
                let term = 0.5 * ws * wt * (constant + more).ln_1p();
                value += term;
                size += term.abs();
            }
        }
        Bounded {
            value,
            // The distance of the middles itself is known to a few roundings.
            error: error + TERM_ROUNDOFF * (size + a.length * b.length),
        }
    })
}

/// The closed form for parallel edges. Edges that are nearly so are turned to be; `None` when that changes more than half of
/// `permitted`, and more than the roundings of the corners do.
fn parallel(a: Edge, b: Edge, unit: f64, permitted: f64) -> Option<Bounded> {
    let sine = a.direction.cross(b.direction).length();
    let shift = 0.5 * b.length * sine;
    let turned = a.length * rule::modulus(shift, b.length);
    let farthest = a.start.abs().max(b.start.abs()).max_element() + a.length + b.length;
    let rounded = a.length * rule::modulus(ROUNDINGS * farthest, b.length);
    if turned > rounded.max(0.5 * permitted) {
        return None;
    }
    let way = b.at(0.5 * b.length) - a.start;
    let along = a.direction.dot(way);
    let h = (way - a.direction * along).length();
    let half = 0.5 * b.length;
    let mut sum = Bounded::default();
    for (t, sign) in [(along + half, 1.0), (along - half, -1.0)] {
        for (u, sign) in [(t, sign), (t - a.length, -sign)] {
            let term = second_primitive(u, h, unit);
            sum.value += sign * term.value;
            sum.error += term.error;
        }
    }
    sum.error += turned;
    Some(sum)
}

/// The function whose second derivative is `½ ln((h² + u²) / unit²)`.
fn second_primitive(u: f64, h: f64, unit: f64) -> Bounded {
    let squared = h * h + u * u;
    if squared <= 0.0 {
        return Bounded::default();
    }
    let terms = [
        0.25 * (u * u - h * h) * (squared / (unit * unit)).ln(),
        -0.75 * u * u,
        h * u * u.atan2(h),
    ];
    Bounded {
        value: terms.iter().sum(),
        error: TERM_ROUNDOFF * terms.iter().map(|t| t.abs()).sum::<f64>(),
    }
}

/// Closed form along `b`, Gauss along pieces of `a`.
fn skew(a: Edge, b: Edge, unit: f64, permitted: f64) -> Bounded {
    let mut sum = Bounded::default();
    let mut open = vec![(0.5 * a.length, 0.5 * a.length)];
    let mut count = 0;
    while let Some((centre, half)) = open.pop() {
        count += 1;
        let distance = b.distance(a.at(centre));
        let smooth = rule::bound(half, distance) * b.length;
        // Half of what is permitted goes to smooth pieces by their lengths, half to those near singular points.
        if smooth <= 0.5 * permitted * half / a.length {
            for (s, weight) in rule::nodes(centre, half) {
                let inner = along(b, a.at(s), unit);
                sum.value += weight * inner.value;
                sum.error += weight * inner.error;
            }
            sum.error += smooth;
            continue;
        }
        let rough = 2.0 * half * rule::modulus(half, b.length);
        if rough <= SINGULAR_SHARE * permitted || count >= MAX_PIECES {
            let inner = along(b, a.at(centre), unit);
            sum.value += 2.0 * half * inner.value;
            sum.error += 2.0 * half * inner.error + rough;
            continue;
        }
        let quarter = 0.5 * half;
        open.push((centre + quarter, quarter));
        open.push((centre - quarter, quarter));
    }
    sum
}

/// `∫ ln(r / unit) dt` along `b`, from `x`.
fn along(b: Edge, x: DVec3, unit: f64) -> Bounded {
    let way = b.start - x;
    let from = b.direction.dot(way);
    let h = (way - b.direction * from).length();
    let mut sum = Bounded::default();
    for (u, sign) in [(from + b.length, 1.0), (from, -1.0)] {
        let squared = h * h + u * u;
        if squared <= 0.0 {
            continue;
        }
        let terms = [0.5 * u * (squared / (unit * unit)).ln(), -u, h * u.atan2(h)];
        sum.value += sign * terms.iter().sum::<f64>();
        sum.error += TERM_ROUNDOFF * terms.iter().map(|t| t.abs()).sum::<f64>();
    }
    sum
}
