//! How the cells of one face look from one viewpoint, and what they are worth there.

use super::SolveFace;
use super::cells::{Cell, FaceCells};
use super::gather::Oracle;
use super::kernel::{add_triangle, cell_corners, is_far};
use crate::direct::form_factor_of_directions;
use crate::geom::Plane;
use crate::visibility::{Ball, Cone, Target, Viewpoint};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// A cell as seen from the viewpoint.
pub(super) struct Seen {
    pub(super) corners: [DVec3; 3],
    pub(super) ball: Ball,
    pub(super) is_above: bool,
    /// A bound of its form factor.
    pub(super) form_factor: f64,
    /// Square of its width over its distance, at most 1.
    pub(super) spread: f64,
}

impl Seen {
    /// Whether a quadrature tells its form factor, or that of any part of it, so well that all that it sends is right to
    /// `permitted`, W/m².
    pub(super) fn is_far(&self, strength: &Strength, permitted: f64) -> bool {
        is_far(self.spread, self.form_factor, strength.rms, permitted)
    }
}

/// Light sent per form factor by the cell at hand.
pub(super) struct Strength {
    pub(super) deviation: f64,
    pub(super) range: f64,
    /// RMS over the cell: it sends no more than this, whatever hides part of it.
    pub(super) rms: f64,
}

/// What stays the same while the trees of one face are walked.
pub(super) struct Walk<'w> {
    pub(super) view: &'w Viewpoint,
    pub(super) oracle: &'w Oracle<'w>,
    pub(super) f: usize,
    pub(super) face: &'w SolveFace,
    pub(super) tree: &'w FaceCells,
    /// [`Sources::ambient`] as this face reflects it.
    pub(super) ambient: f64,
}

impl Walk<'_> {
    pub(super) fn strength(&self, c: usize) -> Strength {
        let light = &self.oracle.sources.faces[self.f].cells[c];
        Strength {
            deviation: light.deviation + self.ambient,
            range: light.range() + self.ambient,
            rms: light.rms() + self.ambient,
        }
    }

    pub(super) fn target(&self, c: usize) -> Target<'_> {
        Target {
            corners: &self.tree.cells[c].corners,
            plane: self.face.plane,
        }
    }

    /// The cell at `p` (frame coordinates) that is good enough as it is; none where the face has no area.
    pub(super) fn cell_at(&self, p: DVec2) -> Option<usize> {
        let mut c = self.tree.root_at(p)?;
        loop {
            let Some(seen) = self.look(c) else {
                return Some(c);
            };
            let weight = seen.form_factor * seen.spread;
            if self.strength(c).deviation * weight <= self.oracle.link {
                return Some(c);
            }
            let Some(child) = self.tree.child_towards(c, p) else {
                self.tree.expose(c, weight);
                return Some(c);
            };
            c = child;
        }
    }

    /// How cell `c` is seen; none when it lies below the horizon.
    pub(super) fn look(&self, c: usize) -> Option<Seen> {
        let cell = &self.tree.cells[c];
        let eye = self.view.position;
        let corners = cell.corners.map(|p| p - eye);
        let heights = corners.map(|d| self.view.horizon.normal.dot(d));
        let highest = heights[0].max(heights[1]).max(heights[2]);
        if highest <= 0.0 {
            return None;
        }
        let across = self.face.plane.distance(eye);
        // From close by the cell is seen as its nearest point is, not as its middle.
        let squared = cell.centre.distance_squared(eye);
        let nearest = (squared.sqrt() - cell.radius).max(across);
        let cosines = (highest / nearest).min(1.0) * (across / nearest);
        Some(Seen {
            corners,
            ball: Ball::new(cell.centre - eye, cell.radius),
            is_above: heights.iter().all(|&h| h >= 0.0),
            form_factor: (cell.area * cosines / (PI * nearest * nearest)).min(1.0),
            spread: (cell.width_squared / (nearest * nearest)).min(1.0),
        })
    }
}

/// Square of the width of a cell over its distance from `eye`, at most 1; it lies in `plane`.
pub(super) fn spread(cell: &Cell, plane: &Plane, eye: DVec3) -> f64 {
    let nearest = (cell.centre.distance(eye) - cell.radius).max(plane.distance(eye));
    if nearest > 0.0 {
        (cell.width_squared / (nearest * nearest)).min(1.0)
    } else {
        1.0
    }
}

/// The weights of a cell in full view.
pub(super) fn clear(walk: &Walk, seen: &Seen, strength: &Strength) -> [f64; 3] {
    let n = walk.view.horizon.normal;
    if strength.range * seen.form_factor * seen.spread.sqrt() <= walk.oracle.link {
        return [form_factor_of_directions(n, &seen.corners) / 3.0; 3];
    }
    let mut sum = [0.0; 3];
    let is_far = seen.is_far(strength, walk.oracle.link);
    add_triangle(n, cell_corners(seen.corners), is_far, &mut sum);
    sum
}

/// The form factor of a triangle of directions by the share of its sixteen equal parts whose middles no cone hides.
pub(super) fn sampled<'c, I: Iterator<Item = Cone<'c>>>(
    n: DVec3,
    t: [DVec3; 3],
    cones: impl Fn() -> I,
) -> f64 {
    if t.iter().any(|d| n.dot(*d) < 0.0) {
        // Near the horizon the cosine is next to nothing.
        return 0.0;
    }
    let visible = share_of_samples(t, |d| !cones().any(|c| c.hides(d)));
    form_factor_of_directions(n, &t) * visible
}

/// The share of the sixteen equal parts of a triangle of directions whose middles are visible.
pub(super) fn share_of_samples(t: [DVec3; 3], is_visible: impl Fn(DVec3) -> bool) -> f64 {
    let middles = SAMPLE_WEIGHTS
        .iter()
        .map(|w| t[0] * w[0] + t[1] * w[1] + t[2] * w[2]);
    middles.filter(|&d| is_visible(d)).count() as f64 / SAMPLE_WEIGHTS.len() as f64
}

/// Middles of the sixteen triangles that two halvings of the edges make: barycentric coordinates.
const SAMPLE_WEIGHTS: [[f64; 3]; 16] = {
    let mut w = [[0.0; 3]; 16];
    let (mut k, mut i) = (0, 0);
    while i < 4 {
        let mut j = 0;
        while i + j < 4 {
            // Upright triangles, then the inverted ones between them.
            let (a, b) = (i as f64, j as f64);
            w[k] = [
                (a + 1.0 / 3.0) / 4.0,
                (b + 1.0 / 3.0) / 4.0,
                1.0 - (a + b + 2.0 / 3.0) / 4.0,
            ];
            k += 1;
            if i + j < 3 {
                w[k] = [
                    (a + 2.0 / 3.0) / 4.0,
                    (b + 2.0 / 3.0) / 4.0,
                    1.0 - (a + b + 4.0 / 3.0) / 4.0,
                ];
                k += 1;
            }
            j += 1;
        }
        i += 1;
    }
    w
};
