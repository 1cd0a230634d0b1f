//! What stands in the space between two convex polygons, or a box and a polygon.

use super::{Blockers, Part, Region, Target, Viewpoint};
use crate::geom::{Plane, bounds};
use crate::scene::FaceId;
use glam::{BVec3, DVec3};
use smallvec::SmallVec;
use std::borrow::Cow;
use std::cell::Cell;

/// So many faces on the line between the middles are tried. Of the emitters that pieces of a large level do not see half are
/// found so, at a cost of three tries each.
const MOST_TRIES: usize = 8;

/// So many parts of a surface are gone over; one in ten thousand tries asks for more.
const MOST_PARTS: usize = 32;

/// How much of one polygon another one sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// All of it, from everywhere.
    Clear,
    /// Nothing: one blocker crosses every line between them.
    Hidden,
    /// Something may stand between.
    Partial,
}

/// The lines of sight between two convex polygons that face each other, or between a box and a polygon.
pub struct Shaft<'a> {
    ends: [End<'a>; 2],
    region: Region,
}

/// One end of a shaft.
struct End<'a> {
    corners: Cow<'a, [DVec3]>,
    /// By its corners' numbers.
    edges: SmallVec<[[usize; 2]; 12]>,
    /// The plane of a polygon, normal towards the other end: nothing behind it stands in the way.
    plane: Option<Plane>,
}

impl<'a> End<'a> {
    fn polygon(target: Target<'a>) -> Self {
        let n = target.corners.len();
        Self {
            corners: Cow::Borrowed(target.corners),
            edges: (0..n).map(|i| [i, (i + 1) % n]).collect(),
            plane: Some(target.plane),
        }
    }

    /// A box from its lowest to its highest corner. Bit k of a corner's number says which of the two its coordinate k is from.
    fn cuboid(low: DVec3, high: DVec3) -> Self {
        let corner = |i: u32| {
            let bit = |k: u32| i >> k & 1 == 1;
            DVec3::select(BVec3::new(bit(0), bit(1), bit(2)), high, low)
        };
        let edges = (0..8).flat_map(|i| [1, 2, 4].map(|bit| [i, i | bit]));
        Self {
            corners: (0..8).map(corner).collect(),
            edges: edges.filter(|[i, j]| i != j).collect(),
            plane: None,
        }
    }

    fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / self.corners.len() as f64
    }

    /// Somebody on the front of a polygon.
    fn view(&self) -> Option<Viewpoint> {
        let plane = self.plane?;
        Some(Viewpoint::new(self.corners[0], plane.normal))
    }
}

impl<'a> Shaft<'a> {
    /// The shaft between `a` and `b`.
    pub fn new(a: Target<'a>, b: Target<'a>) -> Self {
        Self::between(End::polygon(a), End::polygon(b))
    }

    /// The shaft between the box from `low` to `high` and `b`, which may reach into the box.
    pub fn from_box((low, high): (DVec3, DVec3), b: Target<'a>) -> Self {
        Self::between(End::cuboid(low, high), End::polygon(b))
    }

    fn between(a: End<'a>, b: End<'a>) -> Self {
        Self {
            region: hull(&a, &b),
            ends: [a, b],
        }
    }

    /// How its ends see each other. Faces in the plane of either hide nothing.
    pub fn sight(&self, blockers: &Blockers) -> Sight {
        let tol = blockers.weld_distance();
        let mut sight = Sight::Clear;
        blockers.query(&self.region, |i| {
            let part = blockers.part(i);
            let corners = blockers.corners(part);
            if sight != Sight::Hidden
                && self.is_between(corners, tol)
                && self.region.may_meet_polygon(corners, 0.0)
            {
                sight = if self.is_hidden_by(part, blockers) {
                    Sight::Hidden
                } else {
                    Sight::Partial
                };
            }
        });
        sight
    }

    /// True when a surface that the line between the middles of both ends meets hides each from the other; `last`, the face of
    /// the second end, hides nothing. False says nothing.
    pub fn is_hidden_along_its_middle(&self, last: FaceId, blockers: &Blockers) -> bool {
        let [a, b] = [self.ends[0].middle(), self.ends[1].middle()];
        let length = a.distance(b);
        if length == 0.0 {
            return false;
        }
        // What the first end holds or cuts does not hide it.
        let start = (self.way_out(a, b) + blockers.weld_distance()) / length;
        let (tries, is_hidden) = (Cell::new(0), Cell::new(false));
        let goes_on = |t: u32| {
            let face = blockers.ray_owner(t);
            if face != last {
                let part = blockers.part_across(face, [a, b]);
                is_hidden.set(part.is_some_and(|p| self.is_hidden_by_surface(p, blockers)));
                tries.set(tries.get() + 1);
            }
            !is_hidden.get() && tries.get() < MOST_TRIES
        };
        blockers.rays().is_blocked(a, b, start, 1.0, goes_on);
        is_hidden.get()
    }

    /// How far the line from the middle of a box, `a`, to `b` runs in it, metres; in a polygon it does not.
    fn way_out(&self, a: DVec3, b: DVec3) -> f64 {
        if self.ends[0].plane.is_some() {
            return 0.0;
        }
        let half = self.ends[0].corners[7] - a;
        let steps = half / (b - a).abs();
        let steps = steps.to_array().into_iter().filter(|s| s.is_finite());
        steps.fold(1.0, f64::min) * a.distance(b)
    }

    /// True when the surface of convex parts around `first`, which the line between the middles meets, hides one end from the
    /// other.
    ///
    /// A line that moves within the shaft, its ends on the shaft's, goes on meeting a surface until it meets the surface's border,
    /// or an edge at which both faces lie to one side of it; or until an end passes through. Where nothing of this lies in the
    /// shaft all its lines meet the surface, as one does. At an edge the line goes from one face over to the other when it comes
    /// to both from the same side of the surface.
    fn is_hidden_by_surface(&self, first: u32, blockers: &Blockers) -> bool {
        let Some(front) = self.side_of(first, blockers) else {
            return false;
        };
        let mut surface: SmallVec<[(u32, bool); MOST_PARTS]> = SmallVec::new();
        surface.push((first, front));
        let mut done = 0;
        while let Some(&(index, is_front)) = surface.get(done) {
            done += 1;
            let part = blockers.part(index);
            let corners = blockers.corners(part);
            let crossings = self.crossings(&part.plane);
            for (i, &p) in corners.iter().enumerate() {
                let q = corners[(i + 1) % corners.len()];
                let inwards = part.plane.normal.cross(q - p);
                let misses = |x: &Crossings| x.iter().all(|&x| inwards.dot(x - p) >= 0.0);
                if crossings.as_ref().is_some_and(misses)
                    || !self.region.may_meet_polygon(&[p, q], 0.0)
                {
                    continue;
                }
                // Whatever goes on beyond the edge as the same side of the surface.
                let next = blockers.beside(index, i).find_map(|(beside, is_turned)| {
                    let is_front = is_front != is_turned;
                    let goes_on = self.side_of(beside, blockers) == Some(is_front);
                    goes_on.then_some((beside, is_front))
                });
                let Some(next) = next else {
                    return false;
                };
                if !surface.contains(&next) {
                    if surface.len() == MOST_PARTS {
                        return false;
                    }
                    surface.push(next);
                }
            }
        }
        true
    }

    /// Whether the first end lies in front of a part, or behind it; none when neither, when the part may cut an end, and when it
    /// lies in the plane of one and hides nothing.
    fn side_of(&self, part: u32, blockers: &Blockers) -> Option<bool> {
        let part = blockers.part(part);
        if !self.is_between(blockers.corners(part), blockers.weld_distance()) {
            return None;
        }
        let plane = part.plane;
        let [first, last] = [0, 1].map(|i| {
            let heights = self.ends[i].corners.iter().map(|&c| plane.distance(c));
            let (lo, hi) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), h| {
                (lo.min(h), hi.max(h))
            });
            let slack = blockers.roundoff();
            match (lo >= -slack && hi > slack, hi <= slack && lo < -slack) {
                (true, _) => Some(true),
                (_, true) => Some(false),
                _ => None,
            }
        });
        last.and(first)
    }

    /// Appends the screens that may hide something of one end from the other, ascending, unless they are more than `most`: then
    /// some are appended and it returns false. From a box none are, as if they were too many.
    pub fn collect_few_screens(
        &self,
        most: usize,
        blockers: &Blockers,
        out: &mut Vec<u32>,
    ) -> bool {
        let (Some(view), Some(target)) = (self.ends[0].view(), self.ends[1].plane) else {
            return false;
        };
        blockers.collect_few_screens(most, &view, &self.region, target, out)
    }

    /// Whether screen `i` is one of those that [`Shaft::collect_few_screens`] appends.
    pub fn may_hide(&self, i: u32, blockers: &Blockers) -> bool {
        match (self.ends[0].view(), self.ends[1].plane) {
            (Some(view), Some(target)) => blockers.may_hide(i, &view, &self.region, target),
            _ => true,
        }
    }

    /// Whether some of the corners lie in front of either end.
    fn is_between(&self, corners: &[DVec3], tol: f64) -> bool {
        let is_ahead = |plane: Plane| corners.iter().any(|&c| plane.distance(c) > tol);
        self.ends.iter().all(|e| e.plane.is_none_or(is_ahead))
    }

    /// Whether a convex part crosses every straight line from one end to the other: those between their corners are enough, as
    /// where all others cross its plane lies among where these do.
    fn is_hidden_by(&self, part: &Part, blockers: &Blockers) -> bool {
        let corners = blockers.corners(part);
        let is_inside = |x: DVec3| {
            (0..corners.len()).all(|i| {
                let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
                part.plane.normal.dot((q - p).cross(x - p)) >= 0.0
            })
        };
        let crossings = self.crossings(&part.plane);
        crossings.is_some_and(|c| c.iter().all(|&x| is_inside(x)))
    }

    /// Where the straight lines between the corners of both ends cross a plane, if it lies between the ends.
    fn crossings(&self, plane: &Plane) -> Option<Crossings> {
        let [a, b] = &self.ends;
        let heights = |end: &End| -> SmallVec<[f64; 8]> {
            end.corners.iter().map(|&c| plane.distance(c)).collect()
        };
        let (from, to) = (heights(a), heights(b));
        let is_apart = |above: &[f64], below: &[f64]| {
            above.iter().all(|&h| h > 0.0) && below.iter().all(|&h| h < 0.0)
        };
        if !is_apart(&from, &to) && !is_apart(&to, &from) {
            return None;
        }
        let mut crossings = Crossings::new();
        for (&x, hx) in a.corners.iter().zip(&from) {
            for (&y, hy) in b.corners.iter().zip(&to) {
                crossings.push(x + (y - x) * (hx / (hx - hy)));
            }
        }
        Some(crossings)
    }
}

/// Points where lines between two polygons, usually of four corners, cross a plane.
type Crossings = SmallVec<[DVec3; 16]>;

/// The convex hull of both ends (Haines & Wallace 1991): the planes through an edge of one and a corner of the other
/// that have all of both on one side, and the box around them.
fn hull(a: &End, b: &End) -> Region {
    let points = || a.corners.iter().chain(b.corners.iter()).copied();
    let mut region = Region {
        planes: [a.plane, b.plane].into_iter().flatten().collect(),
        bounds: bounds(points()),
    };
    for (from, to) in [(a, b), (b, a)] {
        for &[i, j] in &from.edges {
            let (p, q) = (from.corners[i], from.corners[j]);
            for &v in to.corners.iter() {
                let Some(normal) = (q - p).cross(v - p).try_normalize() else {
                    continue;
                };
                let side = Plane::new(p, normal);
                // The three points that it goes through lie on it but for round-off; they do not count.
                let is_on = |x: DVec3| x == p || x == q || x == v;
                let rest = || points().filter(|&x| !is_on(x)).map(|x| side.distance(x));
                if rest().all(|d| d >= 0.0) {
                    region.planes.push(side);
                } else if rest().all(|d| d <= 0.0) {
                    region.planes.push(Plane::new(p, -normal));
                }
            }
        }
    }
    region
}
