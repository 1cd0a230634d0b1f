//! One polygon of the file on welded vertices, on its way to becoming part of a face.

use crate::geom::newell_normal;
use crate::scene::{IdVec, VertexId};
use glam::DVec3;

/// Welded positions, local metres.
pub(super) type Positions = IdVec<VertexId, DVec3>;

/// A polygon over welded vertices.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Corners, counter-clockwise seen from the front.
    pub(super) corners: Vec<VertexId>,
    /// Index into the materials.
    pub(super) material: u32,
    /// Index into the groups.
    pub(super) group: u32,
    /// Index of the polygon in the file.
    pub(super) source: u32,
    /// Index of its surface maps.
    pub(super) maps: Option<u32>,
}

/// What a polygon's corners amount to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// It encloses area.
    Sound,
    /// Fewer than three corners, or all within the edge distance of one line.
    Degenerate,
    /// Its corners span a plane and yet enclose no net area: it crosses itself.
    Folded,
}

impl Piece {
    /// Positions of the corners.
    pub(super) fn points<'a>(
        &'a self,
        positions: &'a Positions,
    ) -> impl ExactSizeIterator<Item = DVec3> + Clone + 'a {
        self.corners.iter().map(|&v| positions[v])
    }

    /// Corners in order with their successors.
    pub(super) fn edges(&self) -> impl Iterator<Item = (VertexId, VertexId)> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().copied().zip(next.copied())
    }

    /// Twice the area vector (Newell).
    pub(super) fn newell(&self, positions: &Positions) -> DVec3 {
        newell_normal(self.points(positions))
    }

    /// Mean of the corners.
    pub(super) fn mean(&self, positions: &Positions) -> DVec3 {
        self.points(positions).sum::<DVec3>() / self.corners.len() as f64
    }

    /// Removes repeated corners and spikes (`a b a`), around the end of the list too.
    pub(super) fn remove_spikes(&mut self) {
        let mut kept: Vec<VertexId> = Vec::with_capacity(self.corners.len());
        for &corner in &self.corners {
            let n = kept.len();
            if kept.last() == Some(&corner) {
                continue;
            }
            if n >= 2 && kept[n - 2] == corner {
                kept.pop();
            } else {
                kept.push(corner);
            }
        }
        // The seam between the last corner and the first can hide one more of either kind at a time.
        loop {
            let n = kept.len();
            if n >= 2 && kept[n - 1] == kept[0] {
                kept.pop();
            } else if n >= 3 && kept[n - 2] == kept[0] {
                kept.truncate(n - 2);
            } else if n >= 3 && kept[n - 1] == kept[1] {
                kept.pop();
                kept.remove(0);
            } else {
                break;
            }
        }
        self.corners = kept;
    }

    /// Whether the corners enclose area, as seen at `edge_distance`.
    ///
    /// The width is measured from the longest line through two corners that two sweeps find: for a triangle that is its
    /// longest edge, and the width its smallest height.
    pub(super) fn shape(&self, positions: &Positions, edge_distance: f64) -> Shape {
        if self.corners.len() < 3 {
            return Shape::Degenerate;
        }
        let farthest_from = |p: DVec3| {
            self.points(positions)
                .fold((p, 0.0), |(best, distance), q| {
                    let d = p.distance_squared(q);
                    if d > distance {
                        (q, d)
                    } else {
                        (best, distance)
                    }
                })
                .0
        };
        let a = farthest_from(positions[self.corners[0]]);
        let b = farthest_from(a);
        let axis = (b - a).normalize_or_zero();
        let width = self
            .points(positions)
            .map(|p| axis.cross(p - a).length())
            .fold(0.0, f64::max);
        if width < edge_distance {
            Shape::Degenerate
        } else if self.newell(positions).length() < edge_distance * a.distance(b) {
            Shape::Folded
        } else {
            Shape::Sound
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(corners: &[u32]) -> Vec<u32> {
        let mut piece = Piece {
            corners: corners.iter().map(|&c| VertexId(c)).collect(),
            material: 0,
            group: 0,
            source: 0,
            maps: None,
        };
        piece.remove_spikes();
        piece.corners.iter().map(|v| v.0).collect()
    }

    #[test]
    fn spikes_and_repeats_vanish_around_the_seam_too() {
        assert_eq!(cleaned(&[0, 0, 1, 2, 2, 0]), [0, 1, 2]);
        assert_eq!(cleaned(&[0, 1, 5, 1, 2]), [0, 1, 2]);
        assert_eq!(cleaned(&[0, 1, 2, 0, 7]), [0, 1, 2]);
        assert_eq!(cleaned(&[7, 0, 1, 2, 0]), [0, 1, 2]);
        assert!(cleaned(&[0, 1, 0, 1]).len() < 3);
    }
}
