//! The cones of directions that convex blockers hide from a point.
//!
//! A cone is bounded by the planes through the viewpoint and the blocker's edges: no projection, so no singularity.

use super::{Blockers, Region, Viewpoint};
use crate::geom::Plane;
use crate::scene::FaceId;
use glam::DVec3;
use smallvec::SmallVec;

/// Rounding error of `(b × a) · d` for directions of unit length: two roundings in each component of the cross product,
/// three in the dot product.
pub(super) const SIDE_ROUNDOFF: f64 = 8.0 * f64::EPSILON;

/// A convex polygon in space or as directions from the viewpoint, metres.
pub(super) type Piece = SmallVec<[DVec3; 8]>;

/// How a cone lies to a convex polygon of directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// They share nothing but borders.
    Apart,
    /// The cone holds all of the polygon.
    Holds,
    /// Neither can be said.
    Touches,
}

/// The cones of several blockers from one viewpoint, the widest first.
#[derive(Default)]
pub struct Cones {
    rims: Vec<DVec3>,
    sides: Vec<ConeSide>,
    items: Vec<ConeItem>,
}

#[derive(Clone, Copy)]
struct ConeItem {
    first: u32,
    count: u32,
    /// How wide it looks: sum of the squared sines between neighbouring rim directions.
    width: f64,
}

/// A blocker's cone: the directions `d` with `side · d > 0` for all `sides`.
#[derive(Clone, Copy)]
pub struct Cone<'c> {
    pub(super) rim: &'c [DVec3],
    pub(super) sides: &'c [ConeSide],
}

#[derive(Clone, Copy)]
pub(super) struct ConeSide {
    pub(super) normal: DVec3,
    /// Rounding error of `normal · d` for a direction of unit length.
    pub(super) slack: f64,
}

impl Cones {
    /// No cones.
    pub fn clear(&mut self) {
        self.rims.clear();
        self.sides.clear();
        self.items.clear();
    }

    /// Number of cones.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Cone number `i`.
    pub fn get(&self, i: usize) -> Cone<'_> {
        let item = self.items[i];
        let range = item.first as usize..(item.first + item.count) as usize;
        Cone {
            rim: &self.rims[range.clone()],
            sides: &self.sides[range],
        }
    }

    /// All cones, the widest first.
    pub fn iter(&self) -> impl Iterator<Item = Cone<'_>> {
        (0..self.items.len()).map(|i| self.get(i))
    }

    /// Adds the cone with the given rim (directions, turning counter-clockwise when `facing` is 1, clockwise when −1).
    fn push(&mut self, rim: impl Iterator<Item = DVec3>, facing: f64) {
        let first = self.rims.len();
        self.rims.extend(rim);
        let rim = &self.rims[first..];
        let Some(&last) = rim.last() else { return };
        let (mut width, mut a, mut a_squared) = (0.0, last, last.length_squared());
        for &b in rim {
            // Seen from the front the corners turn counter-clockwise, and b × a points inwards.
            let normal = b.cross(a) * facing;
            let b_squared = b.length_squared();
            let product = a_squared * b_squared;
            width += normal.length_squared() / product;
            self.sides.push(ConeSide {
                normal,
                slack: SIDE_ROUNDOFF * product.sqrt(),
            });
            (a, a_squared) = (b, b_squared);
        }
        self.items.push(ConeItem {
            first: first as u32,
            count: (self.rims.len() - first) as u32,
            width,
        });
    }

    /// Leaves out the cones that one of their own sides parts from the convex polygon `base` (directions); returns whether
    /// one cone alone holds all of it.
    fn narrow(&mut self, base: &[DVec3]) -> bool {
        let mut is_hidden = false;
        let (sides, items) = (&self.sides, &mut self.items);
        items.retain(|item| {
            let range = item.first as usize..(item.first + item.count) as usize;
            let mut holds_all = true;
            for side in &sides[range] {
                let outside = base.iter().filter(|d| side.is_outside(**d)).count();
                if outside == base.len() {
                    return false;
                }
                holds_all &= outside == 0;
            }
            is_hidden |= holds_all;
            true
        });
        is_hidden
    }
}

impl ConeSide {
    fn is_outside(&self, direction: DVec3) -> bool {
        self.normal.dot(direction) <= self.slack * direction.length()
    }
}

impl Cone<'_> {
    /// How the cone lies to the triangle `t` (directions, counter-clockwise).
    pub fn relation(&self, t: &[DVec3; 3]) -> Relation {
        let lengths = t.map(DVec3::length);
        let mut holds = true;
        for side in self.sides {
            let outside = (0..3)
                .filter(|&k| side.normal.dot(t[k]) <= side.slack * lengths[k])
                .count();
            if outside == 3 {
                return Relation::Apart;
            }
            holds &= outside == 0;
        }
        if holds {
            Relation::Holds
        } else if self.is_beyond_edge_of(t) {
            Relation::Apart
        } else {
            Relation::Touches
        }
    }

    /// True when a plane through the viewpoint and an edge of the triangle `t` (directions, counter-clockwise) has the
    /// triangle on one side and the cone on the other.
    fn is_beyond_edge_of(&self, t: &[DVec3; 3]) -> bool {
        [[0, 1, 2], [1, 2, 0], [2, 0, 1]].iter().any(|&[a, b, c]| {
            let m = t[b].cross(t[a]);
            // The plane of an edge as short as round-off points anywhere and parts nothing.
            self.rim.iter().all(|r| m.dot(*r) <= 0.0)
                && m.dot(t[c]) > side_slack(t[a], t[b]) * t[c].length()
        })
    }

    /// True when the cone hides `direction`, its border included: no direction slips through between two blockers that
    /// share an edge.
    pub fn hides(&self, direction: DVec3) -> bool {
        let length = direction.length();
        self.sides
            .iter()
            .all(|s| s.normal.dot(direction) >= -s.slack * length)
    }
}

impl Blockers {
    /// Appends the parts that may hide from `view` something that lies in `region` and in the plane `target`.
    pub fn collect(&self, view: &Viewpoint, mut region: Region, target: Plane, out: &mut Vec<u32>) {
        region.planes.push(view.horizon);
        region.planes.push(target);
        let tol = self.weld_distance();
        self.query(&region, |i| {
            let corners = self.corners(self.part(i));
            if corners.iter().any(|&c| view.horizon.distance(c) > tol)
                && corners.iter().any(|&c| target.distance(c) > tol)
                && region.may_meet_polygon(corners, 0.0)
            {
                out.push(i);
            }
        });
        // The tree's order depends on its shape; the scene's order gives the same pieces in the same order.
        out.sort_unstable();
    }

    /// Fills `out` with the cones of the given parts as far as they lie in front of the plane `target` and may hide some of
    /// the convex polygon `base` (directions from the viewpoint). The widest come first: what is hidden is then gone before
    /// small blockers cut it into pieces. Returns whether one of them alone hides all of `base`.
    pub fn cones(
        &self,
        parts: &[u32],
        view: &Viewpoint,
        target: Plane,
        base: &[DVec3],
        out: &mut Cones,
    ) -> bool {
        out.clear();
        for &i in parts {
            push_cone(self, i, view, target, out);
        }
        let is_hidden = out.narrow(base);
        out.items.sort_by(|a, b| b.width.total_cmp(&a.width));
        is_hidden
    }

    /// True when the straight line from `view` to `point` on `face` meets no other face, tested by a ray.
    pub fn sees(&self, view: &Viewpoint, point: DVec3, face: FaceId) -> bool {
        // Nothing within the weld distance of the viewpoint stands in the way: that is the surface it lies on.
        let start = self.weld_distance() / view.position.distance(point);
        !self
            .rays()
            .is_blocked(view.position, point, start, 1.0, |t| {
                self.ray_owner(t) == face
            })
    }
}

/// Sutherland–Hodgman against one half-space given by a signed distance.
pub(super) fn clip(points: &[DVec3], distance: impl Fn(&DVec3) -> f64) -> Piece {
    let mut out = Piece::new();
    for (i, a) in points.iter().enumerate() {
        let b = &points[(i + 1) % points.len()];
        let (da, db) = (distance(a), distance(b));
        if da >= 0.0 {
            out.push(*a);
        }
        if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
            out.push(*a + (*b - *a) * (da / (da - db)));
        }
    }
    out
}

/// Adds the cone of the part of a blocker in front of the target's plane, unless it hides nothing.
fn push_cone(blockers: &Blockers, index: u32, view: &Viewpoint, target: Plane, out: &mut Cones) {
    let part = blockers.part(index);
    let eye = view.position;
    let distance = part.plane.distance(eye);
    // Seen edge-on it hides nothing.
    if distance.abs() <= blockers.roundoff() {
        return;
    }
    let tol = blockers.weld_distance();
    // Points within the weld distance of the target's plane are in it: a ceiling does not hide the lamp flush with it.
    let ahead = |p: &DVec3| {
        let d = target.distance(*p);
        if d.abs() <= tol { 0.0 } else { d }
    };
    let corners = blockers.corners(part);
    let (mut any_ahead, mut any_behind) = (false, false);
    for c in corners {
        let d = ahead(c);
        any_ahead |= d > 0.0;
        any_behind |= d < 0.0;
    }
    if !any_ahead {
        return;
    }
    if any_behind {
        let rim = clip(corners, ahead);
        if rim.len() >= 3 {
            out.push(rim.iter().map(|c| c - eye), distance.signum());
        }
    } else {
        out.push(corners.iter().map(|c| c - eye), distance.signum());
    }
}

/// Rounding error of `(b × a) · d` for a direction `d` of unit length.
fn side_slack(a: DVec3, b: DVec3) -> f64 {
    SIDE_ROUNDOFF * (a.length_squared() * b.length_squared()).sqrt()
}
