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

use super::{Blockers, Region};
use crate::geom::Plane;
use crate::scene::FaceId;
use glam::DVec3;
use smallvec::SmallVec;

/// A point that looks into the half-space in front of it.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Where it stands, metres, local.
    pub position: DVec3,
    /// The plane it lies in, normal towards the side it looks to.
    pub horizon: Plane,
    /// Unit normal that light is weighed by: that of the curved surface which the plane stands for. What is below the
    /// plane is hidden all the same, and what is behind this normal has no weight.
    pub shading: DVec3,
}

impl Viewpoint {
    /// A viewpoint at `position` on a surface with unit normal `normal`.
    pub fn new(position: DVec3, normal: DVec3) -> Self {
        Self {
            position,
            horizon: Plane::new(position, normal),
            shading: normal,
        }
    }

    /// The same on a plane that stands for a curved surface with unit normal `shading` there.
    pub fn on_curve(position: DVec3, normal: DVec3, shading: DVec3) -> Self {
        Self {
            shading,
            ..Self::new(position, normal)
        }
    }
}

/// Rounding error of `(b × a) · d` for directions of unit length: two roundings in each component of the cross product,
/// three in the dot product.
const SIDE_ROUNDOFF: f64 = 8.0 * f64::EPSILON;

/// One side of a convex polygon that is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// Corners, counter-clockwise seen from the side of `plane.normal`.
    pub corners: &'a [DVec3],
    /// Its plane, normal towards the side that is looked at.
    pub plane: Plane,
}

/// A convex polygon in space or as directions from the viewpoint, metres.
type Piece = SmallVec<[DVec3; 8]>;

/// Buffers that live over many calls.
#[derive(Default)]
pub struct Scratch {
    pieces: Pieces,
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

/// Convex polygons, their corners one after the other in one buffer; and the buffers to cut them.
#[derive(Default)]
struct Pieces {
    corners: Vec<Corner>,
    ranges: Vec<(u32, u32)>,
    /// What is left of the piece that is being cut, its heights above the plane that cuts it, and what remains then.
    rest: Vec<Corner>,
    heights: Vec<f64>,
    inside: Vec<Corner>,
}

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
    rim: &'c [DVec3],
    sides: &'c [ConeSide],
}

#[derive(Clone, Copy)]
struct ConeSide {
    normal: DVec3,
    /// Rounding error of `normal · d` for a direction of unit length.
    slack: f64,
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
        let (mut candidates, mut cones) = (
            std::mem::take(&mut self.candidates),
            std::mem::take(&mut self.cones),
        );
        candidates.clear();
        if faces(blockers, view, target) {
            // Counter-clockwise seen from in front is counter-clockwise seen from the viewpoint, which is in front.
            let region = Region::pyramid(view.position, target.corners);
            blockers.collect(view, region, target.plane, &mut candidates);
        }
        let base: Piece = target.corners.iter().map(|&c| c - view.position).collect();
        if !blockers.cones(&candidates, view, target.plane, &base, &mut cones) {
            self.visible_past(blockers, cones.iter(), view, target, visit);
        }
        self.candidates = candidates;
        self.cones = cones;
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
        if !faces(blockers, view, target) {
            return;
        }
        let above = clip_to_horizon(view, target.corners);
        if above.len() < 3 {
            return;
        }
        self.pieces.start(&above);
        for cone in cones {
            self.pieces.subtract(&cone);
            if self.pieces.ranges.is_empty() {
                return;
            }
        }
        for &range in &self.pieces.ranges {
            self.shown.clear();
            self.shown
                .extend(self.pieces.piece(range).iter().map(|c| c.direction));
            visit(&self.shown);
        }
    }
}

impl Pieces {
    /// Holds `piece` and nothing else.
    fn start(&mut self, piece: &[DVec3]) {
        self.corners.clear();
        self.corners.extend(piece.iter().map(|&d| Corner::new(d)));
        self.ranges.clear();
        self.ranges.push((0, piece.len() as u32));
    }

    fn piece(&self, (from, to): (u32, u32)) -> &[Corner] {
        &self.corners[from as usize..to as usize]
    }

    /// Cuts `cone` out of all pieces.
    fn subtract(&mut self, cone: &Cone) {
        let count = self.ranges.len();
        let mut kept = 0;
        for i in 0..count {
            let range = self.ranges[i];
            if is_apart(self.piece(range), cone) || !self.cut(range, cone) {
                self.ranges[kept] = range;
                kept += 1;
            }
        }
        self.ranges.drain(kept..count);
    }

    /// Adds what `cone` leaves of a piece, and returns true; or adds nothing when the cone hides none of it, so that it may
    /// stay whole rather than in splinters.
    fn cut(&mut self, range: (u32, u32), cone: &Cone) -> bool {
        let before = (self.ranges.len(), self.corners.len());
        self.rest.clear();
        self.rest
            .extend_from_slice(&self.corners[range.0 as usize..range.1 as usize]);
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
        self.ranges.push((first as u32, self.corners.len() as u32));
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

/// True when `view` stands in front of the target, clear of its plane by more than round-off: within it, it would see the
/// target under half of the sky or not at all as the last digit falls, and the back of an emitter would be lit by its front.
fn faces(blockers: &Blockers, view: &Viewpoint, target: Target) -> bool {
    target.plane.distance(view.position) > blockers.roundoff()
}

/// The part of a convex polygon above the horizon of `view`, as directions from it.
fn clip_to_horizon(view: &Viewpoint, corners: &[DVec3]) -> Piece {
    let height = |d: &DVec3| view.horizon.normal.dot(*d);
    clip(
        &corners
            .iter()
            .map(|&c| c - view.position)
            .collect::<Piece>(),
        height,
    )
}

/// Sutherland–Hodgman against one half-space given by a signed distance.
fn clip(points: &[DVec3], distance: impl Fn(&DVec3) -> f64) -> Piece {
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

/// Rounding error of `(b × a) · d` for a direction `d` of unit length.
fn side_slack(a: DVec3, b: DVec3) -> f64 {
    SIDE_ROUNDOFF * (a.length_squared() * b.length_squared()).sqrt()
}
