//! Two polygons past whatever stands between them.
//!
//! One polygon is cut into triangles. A triangle that sees the other polygon in full has its contour integral; one from
//! which a single blocker hides all of it has nothing; between them the visible part is exact at each point, and Gauss
//! over the points is compared with Gauss over the triangle's four parts.

use super::contour::{exchange, order};
use super::edge_pair::Bounded;
use super::patch::{ROUNDINGS, extent};
use super::rule::RADON;
use super::{Exchange, Patch};
use crate::direct::form_factor_of_directions;
use crate::visibility::{Blockers, Scratch, Shaft, Sight, Viewpoint};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Triangles in partial view are divided at least so often, so that no blocker stands unseen between all points: a
/// sixteenth of a polygon, looked at from seven points and 28 more.
const LEAST_DEPTH: u32 = 2;

/// Triangles divided at most, each for 140 looks more: an error of a few parts in a million where shadows cross a polygon.
const MAX_DIVIDED: usize = 4096;

/// The share of the permitted error that triangles in full view may use.
const CLEAR_SHARE: f64 = 0.25;

/// What `first` and `second` exchange past `blockers`, which may hold the two themselves. The form factor of the smaller one
/// is estimated to be off by less than `tolerance`, unless [`Exchange::error`] says that this took too many points.
pub fn past(first: &Patch, second: &Patch, blockers: &Blockers, tolerance: f64) -> Exchange {
    let areas = [first.area, second.area];
    let permitted = tolerance * areas[0].min(areas[1]);
    let (a, b) = match order(first, second) {
        Ordering::Greater => (second, first),
        _ => (first, second),
    };
    let size = extent(&[a.corners.as_slice(), b.corners.as_slice()].concat());
    let roundoff = (ROUNDINGS * size).max(blockers.roundoff());
    let (Some(a), Some(b)) = (
        a.in_front_of(b.plane, roundoff),
        b.in_front_of(a.plane, roundoff),
    ) else {
        return Exchange::new(0.0, 0.0, true, areas);
    };
    if Shaft::new(a.target(), b.target()).sight(blockers) == Sight::Clear {
        let found = exchange(&a, &b, permitted);
        return Exchange::new(found.value, found.error, true, areas);
    }
    let mut search = Search {
        permitted: CLEAR_SHARE * permitted / a.area,
        from: a,
        to: b,
        blockers,
        scratch: Scratch::default(),
        settled: Bounded::default(),
        open: BinaryHeap::new(),
    };
    let corners = search.from.corners.clone();
    let mut error = 0.0;
    for i in 2..corners.len() {
        error += search.add([corners[0], corners[i - 1], corners[i]], 0);
    }
    search.refine(error, permitted);
    let is_proven = search.open.is_empty();
    let found = search.result();
    Exchange::new(found.value, found.error, is_proven, areas)
}

/// A triangle in partial view.
struct Piece {
    corners: [DVec3; 3],
    /// `∫ F dA` by way of its four parts, m².
    value: f64,
    /// How far that is from the value of one rule over all of it.
    error: f64,
    depth: u32,
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        // Equal errors in an order of their own, so that the same pieces come out on every machine.
        let key = |p: &Self| p.corners.map(|c| c.to_array());
        let (x, y) = (key(self), key(other));
        let places = x.as_flattened().iter().zip(y.as_flattened());
        let places = places.map(|(x, y)| x.total_cmp(y));
        places.fold(self.error.total_cmp(&other.error), Ordering::then)
    }
}

struct Search<'b> {
    from: Patch,
    to: Patch,
    blockers: &'b Blockers,
    /// Error permitted per square metre in full view.
    permitted: f64,
    scratch: Scratch,
    /// Triangles in full view.
    settled: Bounded,
    open: BinaryHeap<Piece>,
}

impl Search<'_> {
    /// Takes a triangle up: settled where nothing or one blocker alone stands before it, else to be compared with its parts.
    /// Returns the error that this adds, m².
    fn add(&mut self, t: [DVec3; 3], depth: u32) -> f64 {
        let patch = Patch::flat(t.to_vec(), self.from.plane);
        if patch.area <= 0.0 {
            return 0.0;
        }
        match Shaft::new(patch.target(), self.to.target()).sight(self.blockers) {
            Sight::Clear => {
                let found = exchange(&patch, &self.to, self.permitted * patch.area);
                self.settled.add(found);
                found.error
            }
            Sight::Hidden => 0.0,
            Sight::Partial if depth < LEAST_DEPTH => {
                let parts = quarters(t).map(|part| self.add(part, depth + 1));
                parts.iter().sum()
            }
            Sight::Partial => {
                let whole = self.gauss(t, patch.area);
                let parts = quarters(t).map(|part| self.gauss(part, 0.25 * patch.area));
                let value = parts.iter().sum::<f64>();
                let error = (whole - value).abs();
                self.open.push(Piece {
                    corners: t,
                    value,
                    error,
                    depth,
                });
                error
            }
        }
    }

    fn gauss(&mut self, t: [DVec3; 3], area: f64) -> f64 {
        let mean: f64 = RADON
            .into_iter()
            .map(|(w, weight)| weight * self.factor(t[0] * w[0] + t[1] * w[1] + t[2] * w[2]))
            .sum();
        mean * area
    }

    /// The form factor of what `x` sees.
    fn factor(&mut self, x: DVec3) -> f64 {
        let view = Viewpoint::new(x, self.from.plane.normal);
        let target = self.to.target();
        let mut sum = 0.0;
        self.scratch
            .visible_pieces(self.blockers, &view, target, |piece| {
                sum += form_factor_of_directions(view.shading, piece);
            });
        sum.clamp(0.0, 1.0)
    }

    /// Divides the worst triangles until the error, `error` so far, is permitted (m²).
    fn refine(&mut self, mut error: f64, permitted: f64) {
        let mut divided = 0;
        while error > permitted && divided < MAX_DIVIDED {
            let Some(worst) = self.open.pop() else { break };
            error -= worst.error;
            for part in quarters(worst.corners) {
                error += self.add(part, worst.depth + 1);
            }
            divided += 1;
        }
    }

    /// All triangles together.
    fn result(self) -> Bounded {
        // Summed from the smallest, so that few digits are lost.
        let mut sum = Bounded::default();
        for piece in self.open.into_sorted_vec() {
            sum.value += piece.value;
            sum.error += piece.error;
        }
        sum.add(self.settled);
        sum
    }
}

/// The four parts that the middles of its edges cut a triangle into.
fn quarters(t: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let m = [0, 1, 2].map(|k| t[k].midpoint(t[(k + 1) % 3]));
    [
        [t[0], m[0], m[2]],
        [m[0], t[1], m[1]],
        [m[2], m[1], t[2]],
        m,
    ]
}
