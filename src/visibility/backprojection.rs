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

use super::cone::{ConeSide, Piece, RoundCone, SIDE_ROUNDOFF, clip};
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

/// A direction from the viewpoint, metres, and its length.
#[derive(Clone, Copy)]
struct Corner {
    direction: DVec3,
    length: f64,
}

/// Where the corners of a piece are, and a cone around them.
#[derive(Clone, Copy)]
struct PieceRange {
    from: u32,
    to: u32,
    /// Once it was asked for: what no further cone is held against has none.
    hull: Option<RoundCone>,
}

/// Convex polygons, their corners one after the other in one buffer; and the buffers to cut them.
#[derive(Default)]
pub(super) struct Pieces {
    corners: Vec<Corner>,
    ranges: Vec<PieceRange>,
    /// What is left of the piece that is being cut, its heights above the plane that cuts it, and what remains then.
    rest: Vec<Corner>,
    heights: Vec<f64>,
    inside: Vec<Corner>,
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
        let is_cut = self.cut_out(cones.iter());
        Some(if self.pieces.ranges.is_empty() {
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
        visit: impl FnMut(&[DVec3]),
    ) {
        if self.starts(blockers, view, target) {
            self.cut_out(cones);
            self.show(visit);
        }
    }

    /// Cuts `cones` out of what is held; returns whether they hide any of it.
    fn cut_out<'c>(&mut self, cones: impl Iterator<Item = Cone<'c>>) -> bool {
        let mut is_cut = false;
        for cone in cones {
            is_cut |= self.pieces.subtract(&cone);
            if self.pieces.ranges.is_empty() {
                break;
            }
        }
        is_cut
    }

    /// Calls `visit` with each piece that is held.
    fn show(&mut self, mut visit: impl FnMut(&[DVec3])) {
        for &range in &self.pieces.ranges {
            self.shown.clear();
            self.shown
                .extend(self.pieces.piece(range).iter().map(|c| c.direction));
            visit(&self.shown);
        }
    }

    /// Holds what is above the horizon of `view` as the one piece; returns whether that is anything and faces it.
    fn starts(&mut self, blockers: &Blockers, view: &Viewpoint, target: Target) -> bool {
        if !faces(blockers, view, target) {
            return false;
        }
        let above = clip_to_horizon(view, target.corners);
        if above.len() < 3 {
            return false;
        }
        self.pieces.start(&above);
        true
    }
}

impl Pieces {
    /// Holds `piece` and nothing else.
    fn start(&mut self, piece: &[DVec3]) {
        self.corners.clear();
        self.corners.extend(piece.iter().map(|&d| Corner::new(d)));
        self.ranges.clear();
        self.push(0);
    }

    /// The corners from number `first` on are a new piece.
    fn push(&mut self, first: usize) {
        self.ranges.push(PieceRange {
            from: first as u32,
            to: self.corners.len() as u32,
            hull: None,
        });
    }

    fn piece(&self, range: PieceRange) -> &[Corner] {
        &self.corners[range.from as usize..range.to as usize]
    }

    /// One of the pieces, if any is left.
    pub(super) fn last(&self) -> Option<Piece> {
        let range = self.ranges.last()?;
        Some(self.piece(*range).iter().map(|c| c.direction).collect())
    }

    /// Cuts `cone` out of all pieces; returns whether it hides any of them.
    pub(super) fn subtract(&mut self, cone: &Cone) -> bool {
        let count = self.ranges.len();
        let mut kept = 0;
        for i in 0..count {
            let mut range = self.ranges[i];
            let corners = self.piece(range).iter();
            let hull = range
                .hull
                .get_or_insert_with(|| RoundCone::new(corners.map(|c| (c.direction, c.length))));
            if hull.is_apart(cone.hull)
                || is_apart(self.piece(range), cone)
                || !self.cut(range, cone)
            {
                self.ranges[kept] = range;
                kept += 1;
            }
        }
        self.ranges.drain(kept..count);
        kept < count
    }

    /// Adds what `cone` leaves of a piece, and returns true; or adds nothing when the cone hides none of it, so that it may
    /// stay whole rather than in splinters.
    fn cut(&mut self, range: PieceRange, cone: &Cone) -> bool {
        let before = (self.ranges.len(), self.corners.len());
        self.rest.clear();
        self.rest
            .extend_from_slice(&self.corners[range.from as usize..range.to as usize]);
        // What falls outside one side after the other stays; what is inside all of them is hidden.
        for side in cone.sides {
            let (is_above, is_below) = self.measure(side);
            if !is_above {
                self.ranges.truncate(before.0);
                self.corners.truncate(before.1);
                return false;
            }
            if is_below {
                self.split();
            }
        }
        true
    }

    /// Fills in the heights of the rest above a side; returns whether any is positive and whether any is negative.
    fn measure(&mut self, side: &ConeSide) -> (bool, bool) {
        self.heights.clear();
        let (mut is_above, mut is_below) = (false, false);
        for c in &self.rest {
            let mut d = side.normal.dot(c.direction);
            if d.abs() <= side.slack * c.length {
                d = 0.0;
            }
            is_above |= d > 0.0;
            is_below |= d < 0.0;
            self.heights.push(d);
        }
        (is_above, is_below)
    }

    /// Splits the rest at height zero: what lies below becomes a piece, what lies above is the new rest.
    fn split(&mut self) {
        let first = self.corners.len();
        self.inside.clear();
        for (i, &a) in self.rest.iter().enumerate() {
            let j = if i + 1 < self.rest.len() { i + 1 } else { 0 };
            let (da, db) = (self.heights[i], self.heights[j]);
            if da >= 0.0 {
                self.inside.push(a);
            }
            if da <= 0.0 {
                self.corners.push(a);
            }
            if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
                let b = self.rest[j].direction;
                let cut = Corner::new(a.direction + (b - a.direction) * (da / (da - db)));
                self.inside.push(cut);
                self.corners.push(cut);
            }
        }
        self.push(first);
        std::mem::swap(&mut self.rest, &mut self.inside);
    }
}

impl Corner {
    fn new(direction: DVec3) -> Self {
        Self {
            direction,
            length: direction.length(),
        }
    }
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

/// True when a plane through the viewpoint and an edge of either shape has them on different sides.
fn is_apart(piece: &[Corner], cone: &Cone) -> bool {
    let beyond_cone = cone.sides.iter().any(|s| {
        piece
            .iter()
            .all(|c| s.normal.dot(c.direction) <= s.slack * c.length)
    });
    beyond_cone
        || (0..piece.len()).any(|i| {
            let (a, b) = (piece[i], piece[(i + 1) % piece.len()]);
            let m = b.direction.cross(a.direction);
            let slack = SIDE_ROUNDOFF * a.length * b.length;
            cone.rim.iter().all(|r| m.dot(*r) <= 0.0) && holds(piece, m, slack)
        })
}

/// True when the piece clearly reaches to the inner side of the plane with normal `m` and not to the other. The plane of an
/// edge as short as round-off points anywhere and holds nothing.
fn holds(piece: &[Corner], m: DVec3, slack: f64) -> bool {
    let height = |c: &Corner| (m.dot(c.direction), slack * c.length);
    piece.iter().map(height).all(|(h, slack)| h >= -slack)
        && piece.iter().map(height).any(|(h, slack)| h > slack)
}
