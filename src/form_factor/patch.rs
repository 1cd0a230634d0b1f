//! A convex polygon in space that sends light from its front.

use crate::bad_input::BadInput;
use crate::geom::{Plane, newell_normal};
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::Target;
use glam::DVec3;

/// A planarity for [`Patch::new`] that fits corners known in single precision: relative to the patch's size.
pub const FLAT: f64 = 1e-6;

/// A coordinate is known to so many roundings of the patch's size.
pub(super) const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

/// A convex polygon with a front.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    pub(super) corners: Vec<DVec3>,
    pub(super) plane: Plane,
    pub(super) area: f64,
}

impl Patch {
    /// The convex polygon with these corners (metres), counter-clockwise seen from its front. They are moved into their
    /// mean plane, by at most `planarity` times the polygon's size.
    ///
    /// # Errors
    /// Fewer than three corners, numbers that are not finite, no area, corners that bend out of the plane or inwards.
    pub fn new(corners: &[DVec3], planarity: f64) -> Result<Self, BadInput> {
        let refuse = |what: &str, remedy: &str| Err(BadInput::new("patch", what, remedy));
        if corners.len() < 3 || !corners.iter().all(|c| c.is_finite()) {
            let what = format!("{} corners, all of them finite, are asked for", 3);
            return refuse(&what, "give at least three points");
        }
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let size = extent(corners);
        let Some(normal) = newell_normal(corners.iter().copied()).try_normalize() else {
            return refuse("has no area", "leave it out");
        };
        let plane = Plane::new(centre, normal);
        let bend = corners
            .iter()
            .map(|&c| normal.dot(c - centre).abs())
            .fold(0.0, f64::max);
        if bend > planarity * size {
            let what = format!(
                "bends {bend:.2e} m out of its plane (limit {:.2e} m)",
                planarity * size
            );
            return refuse(&what, "cut it into triangles");
        }
        let flat: Vec<DVec3> = corners
            .iter()
            .map(|&c| c - normal * normal.dot(c - centre))
            .collect();
        let n = flat.len();
        let turn = |i: usize| {
            let (a, b, c) = (flat[i], flat[(i + 1) % n], flat[(i + 2) % n]);
            normal.dot((b - a).cross(c - b))
        };
        let slack = planarity.max(ROUNDINGS) * size * size;
        if (0..n).any(|i| turn(i) < -slack) {
            return refuse("is not convex", "cut it into convex pieces");
        }
        let patch = Self::flat(flat, plane);
        if patch.area > 0.0 {
            Ok(patch)
        } else {
            refuse("has no area", "leave it out")
        }
    }

    /// A polygon that is known to be convex and to lie in `plane`.
    pub(super) fn flat(corners: Vec<DVec3>, plane: Plane) -> Self {
        let area = match corners.first() {
            Some(&first) => {
                let twice = corners
                    .windows(2)
                    .map(|w| (w[0] - first).cross(w[1] - first))
                    .sum::<DVec3>();
                0.5 * plane.normal.dot(twice)
            }
            None => 0.0,
        };
        Self {
            corners,
            plane,
            area,
        }
    }

    /// The convex pieces of one side of a face, metres, local.
    pub fn of_side(scene: &Scene, face: FaceId, side: FaceSide) -> Vec<Self> {
        let of = &scene.faces[face];
        let normal = scene.normal(face, side);
        of.convex_parts
            .iter()
            .map(|part| {
                let mut corners: Vec<DVec3> = part
                    .iter()
                    .map(|&v| of.frame.to_space(of.frame.to_plane(scene.vertices[v])))
                    .collect();
                if side == FaceSide::Back {
                    corners.reverse();
                }
                Self::flat(corners, Plane::new(of.frame.origin, normal))
            })
            .filter(|patch| patch.area > 0.0)
            .collect()
    }

    /// Corners, counter-clockwise seen from the front, metres.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// m².
    pub fn area(&self) -> f64 {
        self.area
    }

    /// As something that is looked at.
    pub(super) fn target(&self) -> Target<'_> {
        Target {
            corners: &self.corners,
            plane: self.plane,
        }
    }

    /// Edges from each corner to the next.
    pub(super) fn edges(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        let n = self.corners.len();
        (0..n).map(move |i| [self.corners[i], self.corners[(i + 1) % n]])
    }

    /// The part in front of `plane`; none when nothing of it is, by more than `roundoff` (metres).
    pub(super) fn in_front_of(&self, plane: Plane, roundoff: f64) -> Option<Self> {
        let heights: Vec<f64> = self
            .corners
            .iter()
            .map(|&c| plane.distance(c))
            .map(|d| if d.abs() <= roundoff { 0.0 } else { d })
            .collect();
        if heights.iter().all(|&d| d <= 0.0) {
            return None;
        }
        if heights.iter().all(|&d| d >= 0.0) {
            return Some(self.clone());
        }
        let mut corners = Vec::with_capacity(heights.len() + 1);
        for (i, &a) in self.corners.iter().enumerate() {
            let j = (i + 1) % heights.len();
            let (da, db) = (heights[i], heights[j]);
            if da >= 0.0 {
                corners.push(a);
            }
            if da * db < 0.0 {
                corners.push(a + (self.corners[j] - a) * (da / (da - db)));
            }
        }
        Some(Self::flat(corners, self.plane)).filter(|p| p.area > 0.0)
    }
}

/// Diagonal of the box around points, metres.
pub(super) fn extent(points: &[DVec3]) -> f64 {
    let lo = points.iter().fold(DVec3::INFINITY, |a, &p| a.min(p));
    let hi = points.iter().fold(DVec3::NEG_INFINITY, |a, &p| a.max(p));
    lo.distance(hi)
}
