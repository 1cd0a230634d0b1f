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
    cones: Vec<Cone>,
}

/// A blocker's cone: the directions `d` with `side · d > 0` for all `sides`.
pub struct Cone {
    rim: Piece,
    sides: SmallVec<[ConeSide; 8]>,
    /// How wide it looks: sum of the squared sines between neighbouring rim directions.
    width: f64,
}

struct ConeSide {
    normal: DVec3,
    /// Rounding error of `normal · d` for a direction of unit length.
    slack: f64,
}

impl Cone {
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
        if target.plane.distance(view.position) > 0.0 {
            // Counter-clockwise seen from in front is counter-clockwise seen from the viewpoint, which is in front.
            let region = Region::pyramid(view.position, target.corners);
            blockers.collect(view, region, target.plane, &mut candidates);
        }
        cones.clear();
        blockers.cones(&candidates, view, target.plane, &mut cones);
        self.visible_past(cones.iter(), view, target, visit);
        self.candidates = candidates;
        self.cones = cones;
    }

    /// As [`Scratch::visible_pieces`], past the given cones only.
    pub fn visible_past<'c>(
        &mut self,
        cones: impl Iterator<Item = &'c Cone>,
        view: &Viewpoint,
        target: Target,
        mut visit: impl FnMut(&[DVec3]),
    ) {
        self.pieces.clear();
        if target.plane.distance(view.position) <= 0.0 {
            return;
        }
        let above = clip_to_horizon(view, target.corners);
        if above.len() < 3 {
            return;
        }
        self.pieces.push(above);
        for cone in cones {
            self.subtract(cone);
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
            for side in &cone.sides {
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

    /// Appends the cones of the given parts as far as they lie in front of the plane `target`, the widest first: what
    /// is hidden is then gone before small blockers cut it into pieces.
    pub fn cones(&self, parts: &[u32], view: &Viewpoint, target: Plane, out: &mut Vec<Cone>) {
        out.extend(
            parts
                .iter()
                .filter_map(|&i| blocker_cone(self, i, view, target)),
        );
        out.sort_by(|a, b| b.width.total_cmp(&a.width));
    }
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

/// The cone of the part of a blocker in front of the target's plane; none when it hides nothing.
fn blocker_cone(blockers: &Blockers, index: u32, view: &Viewpoint, target: Plane) -> Option<Cone> {
    let part = blockers.part(index);
    let eye = view.position;
    let distance = part.plane.distance(eye);
    // Seen edge-on it hides nothing.
    if distance.abs() <= blockers.roundoff() {
        return None;
    }
    let tol = blockers.weld_distance();
    // Points within the weld distance of the target's plane are in it: a ceiling does not hide the lamp flush with it.
    let ahead = |p: &DVec3| {
        let d = target.distance(*p);
        if d.abs() <= tol { 0.0 } else { d }
    };
    let corners = blockers.corners(part);
    if !corners.iter().any(|c| ahead(c) > 0.0) {
        return None;
    }
    let clipped = if corners.iter().any(|c| ahead(c) < 0.0) {
        clip(corners, ahead)
    } else {
        Piece::from_slice(corners)
    };
    let rim: Piece = clipped.iter().map(|&c| c - eye).collect();
    if rim.len() < 3 {
        return None;
    }
    // Seen from the front the corners turn counter-clockwise, and b × a points inwards.
    let facing = distance.signum();
    let sides = (0..rim.len())
        .map(|i| {
            let (a, b) = (rim[i], rim[(i + 1) % rim.len()]);
            ConeSide {
                normal: b.cross(a) * facing,
                // Two roundings in each component of the cross product, three in the dot product.
                slack: 8.0 * f64::EPSILON * a.length() * b.length(),
            }
        })
        .collect();
    let width = (0..rim.len())
        .map(|i| {
            let (a, b) = (rim[i], rim[(i + 1) % rim.len()]);
            a.cross(b).length_squared() / (a.length_squared() * b.length_squared())
        })
        .sum();
    Some(Cone { rim, sides, width })
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
            let m = piece[(i + 1) % piece.len()].cross(piece[i]);
            cone.rim.iter().all(|r| m.dot(*r) <= 0.0)
        })
}

/// A convex piece cut by a plane through the viewpoint.
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
