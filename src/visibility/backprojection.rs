//! Backprojection: the part of a convex polygon that a point sees, exactly.
//!
//! A convex blocker hides the cone of directions through it; the cone is bounded by the planes through the viewpoint and
//! the blocker's edges. Cutting the target along these planes, blocker by blocker, leaves convex pieces whose union is
//! the visible part. No projection, so no singularity; overlapping blockers are subtracted once.
//!
//! ```text
//!        target  ───────[    ]───────     pieces left and right of the cone stay
//!                        \  /
//!        blocker          ==
//!                         \/
//!        viewpoint         x
//! ```

use super::cone::{Piece, clip};
use super::pieces::Pieces;
use super::{Blockers, Cone, Cones, Region, Target, Viewpoint};
use glam::DVec3;

/// To cut so few screens out of something costs less than a ray.
pub(crate) const FEW_SCREENS: usize = 8;

/// Where the screens are looked for that may stand before something.
#[derive(Clone, Copy, Debug)]
pub enum Screening<'s> {
    /// Among all, unless more than so many may be in the way.
    AtMost(usize),
    /// Among these, ascending: no other one is in the way.
    Known(&'s [u32]),
}

/// How much is seen of something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// All of it that is above the horizon.
    All,
    /// Some of it, or next to nothing.
    Part,
    /// Nothing.
    Nothing,
}

/// Buffers that live over many calls.
#[derive(Default)]
pub struct Scratch {
    pub(super) pieces: Pieces,
    /// One piece, for the caller to see.
    shown: Vec<DVec3>,
    candidates: Vec<u32>,
    cones: Cones,
}

impl Scratch {
    /// Calls `visit` with each convex piece of `target` that `view` sees above its horizon, as directions from the
    /// viewpoint.
    ///
    /// `blockers` are those of the scene; faces in the plane of the viewpoint's surface or of the target hide nothing.
    pub fn visible_pieces(
        &mut self,
        blockers: &Blockers,
        view: &Viewpoint,
        target: Target,
        visit: impl FnMut(&[DVec3]),
    ) {
        let all = Screening::AtMost(usize::MAX);
        let mut visit = visit;
        if self.visible_among(all, blockers, view, target, &mut visit) == Some(Seen::All) {
            self.visible_past(blockers, std::iter::empty(), view, target, visit);
        }
    }

    /// As [`Scratch::visible_pieces`] past the screens that `screening` finds. Where they are too many it visits nothing and
    /// returns none; nor does it visit anything where all of what is above the horizon is seen.
    pub fn visible_among(
        &mut self,
        screening: Screening,
        blockers: &Blockers,
        view: &Viewpoint,
        target: Target,
        visit: impl FnMut(&[DVec3]),
    ) -> Option<Seen> {
        let (mut candidates, mut cones) = (
            std::mem::take(&mut self.candidates),
            std::mem::take(&mut self.cones),
        );
        let seen = self.screened(
            screening,
            blockers,
            view,
            target,
            &mut candidates,
            &mut cones,
        );
        self.candidates = candidates;
        self.cones = cones;
        if seen == Some(Seen::Part) {
            self.show(visit);
        }
        seen
    }

    /// Holds the pieces that are seen past the screens that `screening` finds, unless they are too many.
    fn screened(
        &mut self,
        screening: Screening,
        blockers: &Blockers,
        view: &Viewpoint,
        target: Target,
        candidates: &mut Vec<u32>,
        cones: &mut Cones,
    ) -> Option<Seen> {
        if !self.starts(blockers, view, target) {
            return Some(Seen::Nothing);
        }
        let are_few = matches!(screening, Screening::Known(s) if s.len() <= FEW_SCREENS);
        if !are_few && !blockers.is_small_world() {
            if self.is_hidden_by_few(blockers, view, target, cones) {
                return Some(Seen::Nothing);
            }
            self.starts(blockers, view, target);
        }
        // Counter-clockwise seen from in front is counter-clockwise seen from the viewpoint, which is in front.
        let region = Region::pyramid(view.position, target.corners)
            .in_front_of([view.horizon, target.plane]);
        let plane = target.plane;
        candidates.clear();
        match screening {
            Screening::AtMost(most) => {
                if !blockers.collect_few_screens(most, view, &region, plane, candidates) {
                    return None;
                }
            }
            Screening::Known(screens) => {
                let may_hide = |&&s: &&u32| blockers.may_hide(s, view, &region, plane);
                candidates.extend(screens.iter().filter(may_hide));
            }
        }
        if candidates.is_empty() {
            return Some(Seen::All);
        }
        let base: Piece = target.corners.iter().map(|&c| c - view.position).collect();
        if blockers
            .cones(candidates, view, plane, &base, cones)
            .is_some()
        {
            return Some(Seen::Nothing);
        }
        let is_cut = self.pieces.subtract_all(cones);
        Some(if self.pieces.is_empty() {
            Seen::Nothing
        } else if is_cut {
            Seen::Part
        } else {
            Seen::All
        })
    }

    /// As [`Scratch::visible_pieces`], past the given cones only.
    pub fn visible_past<'c>(
        &mut self,
        blockers: &Blockers,
        cones: impl Iterator<Item = Cone<'c>>,
        view: &Viewpoint,
        target: Target,
        mut visit: impl FnMut(&[DVec3]),
    ) {
        let mut cones = cones.peekable();
        if cones.peek().is_none() {
            let above = above_horizon(blockers, view, target);
            above.into_iter().for_each(|piece| visit(&piece));
        } else if self.starts(blockers, view, target) {
            for cone in cones {
                self.pieces.subtract(&cone);
            }
            self.show(visit);
        }
    }

    /// Calls `visit` with each piece that is held.
    fn show(&mut self, mut visit: impl FnMut(&[DVec3])) {
        for piece in self.pieces.iter() {
            self.shown.clear();
            self.shown.extend(piece);
            visit(&self.shown);
        }
    }

    /// Holds what is above the horizon of `view` as the one piece; returns whether that is anything and faces it.
    fn starts(&mut self, blockers: &Blockers, view: &Viewpoint, target: Target) -> bool {
        let above = above_horizon(blockers, view, target);
        above.inspect(|piece| self.pieces.start(piece)).is_some()
    }
}

/// What of the target is above the horizon of `view`, if there is anything and it faces it.
fn above_horizon(blockers: &Blockers, view: &Viewpoint, target: Target) -> Option<Piece> {
    let is_seen = faces(blockers, view, target);
    let above = is_seen.then(|| clip_to_horizon(view, target.corners))?;
    (above.len() >= 3).then_some(above)
}

/// True when `view` stands in front of the target, clear of its plane by more than round-off: within it, it would see the
/// target under half of the sky or not at all as the last digit falls, and the back of an emitter would be lit by its front.
fn faces(blockers: &Blockers, view: &Viewpoint, target: Target) -> bool {
    target.plane.distance(view.position) > blockers.roundoff()
}

/// The part of a convex polygon above the horizon of `view`, as directions from it.
fn clip_to_horizon(view: &Viewpoint, corners: &[DVec3]) -> Piece {
    let height = |d: &DVec3| view.horizon.normal.dot(*d);
    let directions: Piece = corners.iter().map(|&c| c - view.position).collect();
    if directions.iter().all(|d| height(d) >= 0.0) {
        return directions;
    }
    clip(&directions, height)
}
