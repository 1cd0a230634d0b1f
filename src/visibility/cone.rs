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
}

impl Viewpoint {
    /// A viewpoint at `position` on a surface with unit normal `normal`.
    pub fn new(position: DVec3, normal: DVec3) -> Self {
        Self {
            position,
            horizon: Plane::new(position, normal),
        }
    }
}

/// One side of a convex polygon that is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// Corners, counter-clockwise seen from the side of `plane.normal`.
    pub corners: &'a [DVec3],
    /// Its plane, normal towards the side that is looked at.
    pub plane: Plane,
}

/// A convex polygon as directions from the viewpoint, metres.
type Piece = SmallVec<[DVec3; 8]>;

/// Buffers that live over many calls.
#[derive(Default)]
pub struct Scratch {
    pieces: Vec<Piece>,
    next: Vec<Piece>,
    candidates: Vec<u32>,
    cones: Cones,
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

    /// True when one cone alone hides all of `directions`.
    pub fn hide_all(&self, directions: &[DVec3]) -> bool {
        self.iter().any(|c| directions.iter().all(|&d| c.hides(d)))
    }

    /// Adds the cone with the given rim (directions, turning counter-clockwise when `facing` is 1, clockwise when −1).
    fn push(&mut self, rim: &[DVec3], facing: f64) {
        let mut width = 0.0;
        let first = self.rims.len() as u32;
        for (i, &a) in rim.iter().enumerate() {
            let b = rim[(i + 1) % rim.len()];
            // Seen from the front the corners turn counter-clockwise, and b × a points inwards.
            let normal = b.cross(a) * facing;
            width += normal.length_squared() / (a.length_squared() * b.length_squared());
            self.rims.push(a);
            self.sides.push(ConeSide {
                normal,
                slack: side_slack(a, b),
            });
        }
        self.items.push(ConeItem {
            first,
            count: rim.len() as u32,
            width,
        });
    }
}

impl Cone<'_> {
    /// One bit for each side of the cone that `direction` lies on or beyond; 0 inside the cone. Sides past the sixteenth
    /// are left out, so that 0 then only says "perhaps inside".
    pub fn outside(&self, direction: DVec3) -> u16 {
        let length = direction.length();
        self.sides
            .iter()
            .take(16)
            .enumerate()
            .filter(|(_, s)| s.normal.dot(direction) <= s.slack * length)
            .fold(0, |mask, (i, _)| mask | 1 << i)
    }

    /// True when the cone hides `direction`.
    pub fn hides(&self, direction: DVec3) -> bool {
        self.sides.iter().all(|s| s.normal.dot(direction) > 0.0)
    }

    /// Whether [`Cone::outside`] tells inside from outside for certain.
    pub fn is_simple(&self) -> bool {
        self.sides.len() <= 16
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
        blockers.cones(&candidates, view, target.plane, &mut cones);
        self.visible_past(blockers, cones.iter(), view, target, visit);
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
        self.pieces.clear();
        if !faces(blockers, view, target) {
            return;
        }
        let above = clip_to_horizon(view, target.corners);
        if above.len() < 3 {
            return;
        }
        self.pieces.push(above);
        for cone in cones {
            self.subtract(&cone);
            if self.pieces.is_empty() {
                return;
            }
        }
        for piece in &self.pieces {
            visit(piece);
        }
    }

    /// Cuts `cone` out of all pieces.
    fn subtract(&mut self, cone: &Cone) {
        let mut i = 0;
        let mut end = self.pieces.len();
        while i < end {
            if is_apart(&self.pieces[i], cone) {
                i += 1;
                continue;
            }
            // What falls outside one side after the other stays; what is inside all of them is hidden.
            let before = self.next.len();
            let mut rest = None;
            for side in cone.sides {
                let piece = rest.as_ref().unwrap_or(&self.pieces[i]);
                match split(piece, side) {
                    Split::Inside => {}
                    Split::Outside => {
                        rest = Some(Piece::new());
                        break;
                    }
                    Split::Both(inside, outside) => {
                        self.next.push(outside);
                        rest = Some(inside);
                    }
                }
            }
            if rest.is_some_and(|r| r.is_empty()) {
                // Nothing was hidden after all: keep the piece whole rather than in splinters.
                self.next.truncate(before);
                i += 1;
            } else {
                end -= 1;
                self.pieces.swap(i, end);
                self.pieces.swap_remove(end);
            }
        }
        self.pieces.append(&mut self.next);
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

    /// Fills `out` with the cones of the given parts as far as they lie in front of the plane `target`. The widest come
    /// first: what is hidden is then gone before small blockers cut it into pieces.
    pub fn cones(&self, parts: &[u32], view: &Viewpoint, target: Plane, out: &mut Cones) {
        out.clear();
        for &i in parts {
            push_cone(self, i, view, target, out);
        }
        out.items.sort_by(|a, b| b.width.total_cmp(&a.width));
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
    let mut rim = if any_behind {
        clip(corners, ahead)
    } else {
        Piece::from_slice(corners)
    };
    if rim.len() >= 3 {
        rim.iter_mut().for_each(|c| *c -= eye);
        out.push(&rim, distance.signum());
    }
}

/// True when a plane through the viewpoint and an edge of either shape has them on different sides.
fn is_apart(piece: &[DVec3], cone: &Cone) -> bool {
    let beyond_cone = cone.sides.iter().any(|s| {
        piece
            .iter()
            .all(|p| s.normal.dot(*p) <= s.slack * p.length())
    });
    beyond_cone
        || (0..piece.len()).any(|i| {
            let (a, b) = (piece[i], piece[(i + 1) % piece.len()]);
            let m = b.cross(a);
            cone.rim.iter().all(|r| m.dot(*r) <= 0.0) && holds(piece, m, side_slack(a, b))
        })
}

/// True when the piece clearly reaches to the inner side of the plane with normal `m` and not to the other. The plane of an
/// edge as short as round-off points anywhere and holds nothing.
fn holds(piece: &[DVec3], m: DVec3, slack: f64) -> bool {
    let height = |p: &DVec3| (m.dot(*p), slack * p.length());
    piece.iter().map(height).all(|(h, slack)| h >= -slack)
        && piece.iter().map(height).any(|(h, slack)| h > slack)
}

/// Rounding error of `(b × a) · d` for a direction `d` of unit length: two roundings in each component of the cross
/// product, three in the dot product.
fn side_slack(a: DVec3, b: DVec3) -> f64 {
    8.0 * f64::EPSILON * a.length() * b.length()
}

/// A convex piece cut by a plane through the viewpoint.
#[allow(
    clippy::large_enum_variant,
    reason = "lives on the stack for one cut; a box would cost an allocation each"
)]
enum Split {
    Inside,
    Outside,
    Both(Piece, Piece),
}

fn split(piece: &[DVec3], side: &ConeSide) -> Split {
    let d: SmallVec<[f64; 8]> = piece
        .iter()
        .map(|p| {
            let d = side.normal.dot(*p);
            if d.abs() <= side.slack * p.length() {
                0.0
            } else {
                d
            }
        })
        .collect();
    if !d.iter().any(|&d| d > 0.0) {
        return Split::Outside;
    }
    if !d.iter().any(|&d| d < 0.0) {
        return Split::Inside;
    }
    let (mut inside, mut outside) = (Piece::new(), Piece::new());
    for i in 0..piece.len() {
        let j = (i + 1) % piece.len();
        if d[i] >= 0.0 {
            inside.push(piece[i]);
        }
        if d[i] <= 0.0 {
            outside.push(piece[i]);
        }
        if (d[i] > 0.0 && d[j] < 0.0) || (d[i] < 0.0 && d[j] > 0.0) {
            let cut = piece[i] + (piece[j] - piece[i]) * (d[i] / (d[i] - d[j]));
            inside.push(cut);
            outside.push(cut);
        }
    }
    Split::Both(inside, outside)
}
