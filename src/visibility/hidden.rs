//! The commonest answer first: a few walls stand before all of it.
//!
//! A ray towards what is left of the target finds a face that hides some of it; that is cut away, and the next ray goes to
//! what is left then. Most of what is hidden is gone after a ray or two, without a search of all the space between.

use super::{Blockers, Cones, Scratch, Target, Viewpoint};
use crate::scene::FaceId;
use glam::DVec3;
use smallvec::SmallVec;

/// Rays at most. Where that many faces do not hide a target together it is usually seen, in part.
const PROBES: usize = 12;

/// In a world of no more screens than this finding all that are between costs less than the rays.
const SMALL_WORLD: usize = 64;

impl Scratch {
    /// True when the faces that a few rays from `view` meet hide all of `target` that is above the horizon. False says
    /// nothing.
    pub(super) fn is_hidden_by_few(
        &mut self,
        blockers: &Blockers,
        view: &Viewpoint,
        target: Target,
        cones: &mut Cones,
    ) -> bool {
        for _ in 0..PROBES {
            let Some(base) = self.pieces.last() else {
                return true;
            };
            let way = base.iter().sum::<DVec3>() / base.len() as f64;
            let Some(face) = blockers.first_on(view, way, target) else {
                return false;
            };
            let mut screens: SmallVec<[u32; 8]> = blockers
                .parts_of(face)
                .map(|part| blockers.screen_of(part))
                .filter(|&s| blockers.is_between(view, target.plane, blockers.corners_of(s)))
                .collect();
            screens.dedup();
            blockers.cones(&screens, view, target.plane, &base, cones);
            if cones.is_empty() {
                return false;
            }
            for cone in cones.iter() {
                self.pieces.subtract(&cone);
            }
        }
        self.pieces.last().is_none()
    }
}

impl Blockers {
    /// Whether finding all that are between costs less than [`Scratch::is_hidden_by_few`].
    pub(super) fn is_small_world(&self) -> bool {
        self.screen_count() <= SMALL_WORLD
    }

    /// The first face from `view` on the way `way` (metres) that ends on `target`.
    fn first_on(&self, view: &Viewpoint, way: DVec3, target: Target) -> Option<FaceId> {
        let tol = self.weld_distance();
        let length = way.length();
        if length <= tol {
            return None;
        }
        // What lies in the plane of the target does not hide it.
        let is_before = |t: f64| target.plane.distance(view.position + way * t) > tol;
        let hit = self
            .rays()
            .nearest_where(view.position, way, tol / length, 1.0, |h| is_before(h.t))?;
        Some(self.ray_owner(hit.triangle))
    }
}
