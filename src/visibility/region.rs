//! Convex regions as intersections of half-spaces, tested against boxes and polygons.

use crate::geom::Plane;
use glam::DVec3;
use smallvec::SmallVec;

/// The points on the positive side of every plane, inside a box.
#[derive(Clone, Debug)]
pub struct Region {
    /// The bounding half-spaces; the region lies on their positive side.
    pub planes: SmallVec<[Plane; 8]>,
    /// A box around the region.
    pub bounds: (DVec3, DVec3),
}

impl Region {
    /// The pyramid from `apex` to the convex polygon `base`, counter-clockwise seen from the apex.
    pub fn pyramid(apex: DVec3, base: &[DVec3]) -> Self {
        let mut planes = SmallVec::new();
        let (mut lo, mut hi) = (apex, apex);
        for (i, &a) in base.iter().enumerate() {
            let b = base[(i + 1) % base.len()];
            // Seen from the apex the inside lies to the left of a → b: there b × a points.
            let n = (b - apex).cross(a - apex);
            if let Some(n) = n.try_normalize() {
                planes.push(Plane::new(apex, n));
            }
            lo = lo.min(a);
            hi = hi.max(a);
        }
        Self {
            planes,
            bounds: (lo, hi),
        }
    }

    /// What of it lies in front of `planes`, too.
    pub fn in_front_of(mut self, planes: [Plane; 2]) -> Self {
        self.planes.extend(planes);
        self
    }

    /// False only when the box certainly misses the region.
    pub fn may_meet_box(&self, lo: DVec3, hi: DVec3) -> bool {
        if lo.cmpgt(self.bounds.1).any() || hi.cmplt(self.bounds.0).any() {
            return false;
        }
        let (centre, half) = ((lo + hi) * 0.5, (hi - lo) * 0.5);
        self.planes
            .iter()
            .all(|p| p.distance(centre) + p.normal.abs().dot(half) >= 0.0)
    }

    /// False only when the polygon lies wholly outside one of the half-spaces, farther than `slack`.
    pub fn may_meet_polygon(&self, corners: &[DVec3], slack: f64) -> bool {
        self.planes
            .iter()
            .all(|p| corners.iter().any(|&c| p.distance(c) > slack))
    }
}
