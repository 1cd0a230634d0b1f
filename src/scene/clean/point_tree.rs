//! A tree of boxes over vertices that finds those close to a segment.

use super::piece::Positions;
use crate::scene::VertexId;
use glam::DVec3;

/// Vertices in a leaf: below this, testing them costs less than splitting them.
const LEAF_SIZE: usize = 8;

/// A balanced tree over vertices; the children of node `i` are `2i + 1` and `2i + 2`, each half of its vertices.
pub(super) struct PointTree<'a> {
    positions: &'a Positions,
    order: Vec<VertexId>,
    boxes: Vec<(DVec3, DVec3)>,
}

impl<'a> PointTree<'a> {
    /// The tree over `members`.
    pub(super) fn new(positions: &'a Positions, members: Vec<VertexId>) -> Self {
        let mut tree = Self {
            positions,
            order: members,
            boxes: Vec::new(),
        };
        tree.split(0, 0, tree.order.len());
        tree
    }

    fn split(&mut self, node: usize, start: usize, end: usize) {
        let positions = self.positions;
        let members = &mut self.order[start..end];
        let (lo, hi) = members
            .iter()
            .map(|&v| positions[v])
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| {
                (lo.min(p), hi.max(p))
            });
        if self.boxes.len() <= node {
            self.boxes
                .resize(node + 1, (DVec3::INFINITY, DVec3::NEG_INFINITY));
        }
        self.boxes[node] = (lo, hi);
        if members.len() <= LEAF_SIZE {
            return;
        }
        let axis = (hi - lo).max_position();
        let half = members.len() / 2;
        members.select_nth_unstable_by(half, |&a, &b| {
            positions[a][axis]
                .total_cmp(&positions[b][axis])
                .then(a.cmp(&b))
        });
        self.split(2 * node + 1, start, start + half);
        self.split(2 * node + 2, start + half, end);
    }

    /// Calls `found` with each vertex whose box, grown by `reach`, the segment `a b` meets.
    pub(super) fn near_segment(
        &self,
        a: DVec3,
        b: DVec3,
        reach: f64,
        found: &mut impl FnMut(VertexId),
    ) {
        let query = Query {
            a,
            direction: b - a,
            reach: DVec3::splat(reach),
        };
        self.visit(0, 0, self.order.len(), &query, found);
    }

    fn visit(
        &self,
        node: usize,
        start: usize,
        end: usize,
        query: &Query,
        found: &mut impl FnMut(VertexId),
    ) {
        let (lo, hi) = self.boxes[node];
        if !query.meets(lo, hi) {
            return;
        }
        if end - start <= LEAF_SIZE {
            self.order[start..end].iter().for_each(|&v| found(v));
            return;
        }
        let half = start + (end - start) / 2;
        self.visit(2 * node + 1, start, half, query, found);
        self.visit(2 * node + 2, half, end, query, found);
    }
}

struct Query {
    a: DVec3,
    direction: DVec3,
    reach: DVec3,
}

impl Query {
    /// Slab test of the segment against the grown box.
    fn meets(&self, lo: DVec3, hi: DVec3) -> bool {
        let (lo, hi) = (lo - self.reach, hi + self.reach);
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (a, d) = (self.a[axis], self.direction[axis]);
            let (near, far) = if d >= 0.0 {
                (lo[axis], hi[axis])
            } else {
                (hi[axis], lo[axis])
            };
            if d.abs() > 0.0 {
                enter = enter.max((near - a) / d);
                leave = leave.min((far - a) / d);
            } else if a < near || a > far {
                return false;
            }
        }
        // A quotient of two rounded differences may be off by a few roundings: keep the doubtful.
        enter <= leave * (1.0 + ROUNDINGS * f64::EPSILON)
    }
}

/// Roundings in one slab parameter: two subtractions and a division, at either end.
const ROUNDINGS: f64 = 6.0;
