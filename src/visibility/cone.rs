//! The cones of directions that convex blockers hide from a point.
//!
//! A cone is bounded by the planes through the viewpoint and the blocker's edges: no projection, so no singularity.

use super::Blockers;
use crate::geom::Plane;
use glam::DVec3;
use smallvec::SmallVec;

/// Rounding error of `(b × a) · d` for directions of unit length: two roundings in each component of the cross product,
/// three in the dot product.
pub(super) const SIDE_ROUNDOFF: f64 = 8.0 * f64::EPSILON;

/// Rounding error of what is compared to tell whether round cones are apart, for directions of unit length: six roundings in
/// the axes and their product, and ten in the sines and cosines.
const ROUND_ROUNDOFF: f64 = 16.0 * f64::EPSILON;

/// A convex polygon in space or as directions from the viewpoint, metres.
pub(crate) type Piece = SmallVec<[DVec3; 8]>;

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

/// The cones of several screens from one viewpoint, the widest first.
///
/// What a screen hides from a viewpoint does not depend on what is looked at, unless the plane of that cuts the screen:
/// cones are kept until the viewpoint changes.
#[derive(Default)]
pub struct Cones {
    rims: Vec<DVec3>,
    sides: Vec<ConeSide>,
    pub(super) items: Vec<ConeItem>,
    kept: Kept,
}

/// The cones of whole screens from one viewpoint: the first so many rims and sides.
#[derive(Default)]
struct Kept {
    /// Of which world, and from where.
    of: Option<(u64, DVec3)>,
    found: Vec<(u32, Whole)>,
    /// For each screen its place in `found`, if that holds it at all.
    places: Vec<u32>,
    rims: usize,
}

/// What is known of a screen as a whole.
#[derive(Clone, Copy, Default)]
pub(super) enum Whole {
    /// It is seen edge-on.
    #[default]
    Nothing,
    /// It has this cone.
    Cone(ConeItem),
    /// A solid that is not seen from outside: each of its parts for itself.
    Parts,
}

#[derive(Clone, Copy)]
pub(super) struct ConeItem {
    first: u32,
    count: u32,
    /// How wide it looks: sum of the squared sines between neighbouring rim directions.
    pub(super) width: f64,
    /// The screen that it belongs to.
    screen: u32,
    hull: RoundCone,
}

/// A round cone around a polygon of directions: to tell quickly that two of them are apart.
#[derive(Clone, Copy)]
pub(super) struct RoundCone {
    axis: DVec3,
    /// Of the angle between its axis and its surface.
    cos: f64,
    sin: f64,
}

/// A ball as it is seen from the viewpoint.
pub struct Ball {
    centre: DVec3,
    radius: f64,
    /// Length of a tangent from the viewpoint, metres.
    tangent: f64,
    /// Rounding error of the comparison with a cone, metres.
    slack: f64,
}

/// A blocker's cone: the directions `d` with `side · d > 0` for all `sides`.
#[derive(Clone, Copy)]
pub struct Cone<'c> {
    pub(super) rim: &'c [DVec3],
    pub(super) sides: &'c [ConeSide],
    pub(super) hull: &'c RoundCone,
}

#[derive(Clone, Copy)]
pub(super) struct ConeSide {
    pub(super) normal: DVec3,
    /// Rounding error of `normal · d` for a direction of unit length.
    pub(super) slack: f64,
}

impl Cones {
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
        let item = &self.items[i];
        let range = item.first as usize..(item.first + item.count) as usize;
        Cone {
            rim: &self.rims[range.clone()],
            sides: &self.sides[range],
            hull: &item.hull,
        }
    }

    /// True when cone number `i` surely has nothing in common with the directions to `ball`: quickly told.
    pub fn is_clear_of(&self, i: usize, ball: &Ball) -> bool {
        let hull = &self.items[i].hull;
        // The angle between the axis and the way to the centre exceeds that of the cone and that of the ball.
        hull.axis.dot(ball.centre) < hull.cos * ball.tangent - hull.sin * ball.radius - ball.slack
    }

    /// All cones, the widest first.
    pub fn iter(&self) -> impl Iterator<Item = Cone<'_>> {
        (0..self.items.len()).map(|i| self.get(i))
    }

    /// Forgets all cones but those of whole screens of `blockers` from `eye`.
    pub(super) fn start(&mut self, blockers: &Blockers, eye: DVec3) {
        self.items.clear();
        let kept = &mut self.kept;
        let of = Some((blockers.id(), eye));
        if kept.of != of {
            kept.of = of;
            kept.rims = 0;
            kept.found.clear();
            kept.places.resize(blockers.screen_count(), 0);
        }
        self.rims.truncate(kept.rims);
        self.sides.truncate(kept.rims);
    }

    /// The whole of a screen, as `look` finds it unless it has been seen before.
    pub(super) fn whole(&mut self, screen: u32, look: impl FnOnce(&mut Self) -> Whole) -> Whole {
        let place = self.kept.places[screen as usize] as usize;
        if let Some(&(found, whole)) = self.kept.found.get(place)
            && found == screen
        {
            return whole;
        }
        let whole = look(self);
        self.kept.rims = self.rims.len();
        self.kept.places[screen as usize] = self.kept.found.len() as u32;
        self.kept.found.push((screen, whole));
        whole
    }

    /// Makes the cone with the given rim (directions, turning counter-clockwise when `facing` is 1, clockwise when −1).
    pub(super) fn cone(
        &mut self,
        rim: impl Iterator<Item = DVec3>,
        facing: f64,
        screen: u32,
    ) -> Option<ConeItem> {
        let first = self.rims.len();
        self.rims.extend(rim);
        let rim = &self.rims[first..];
        let &last = rim.last()?;
        let (mut width, mut a, mut a_length) = (0.0, last, last.length());
        for &b in rim {
            // Seen from the front the corners turn counter-clockwise, and b × a points inwards.
            let normal = b.cross(a) * facing;
            let b_length = b.length();
            let product = a_length * b_length;
            width += normal.length_squared() / (product * product);
            self.sides.push(ConeSide {
                normal,
                slack: SIDE_ROUNDOFF * product,
            });
            (a, a_length) = (b, b_length);
        }
        Some(ConeItem {
            hull: RoundCone::new(rim.iter().map(|r| (*r, r.length()))),
            first: first as u32,
            count: (self.rims.len() - first) as u32,
            width,
            screen,
        })
    }

    /// Leaves out the cones that one of their own sides parts from the convex polygon `base` (directions); returns a
    /// screen whose cone alone holds all of it.
    pub(super) fn narrow(&mut self, base: &[DVec3]) -> Option<u32> {
        let mut hider = None;
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
            if holds_all {
                hider = Some(item.screen);
            }
            true
        });
        hider
    }
}

impl RoundCone {
    /// All directions: no comparison with it holds, so that it is apart from nothing.
    pub(super) const ALL: Self = Self {
        axis: DVec3::ZERO,
        cos: f64::NAN,
        sin: f64::NAN,
    };

    /// Around the given directions, each with its length.
    pub(super) fn new(rim: impl Iterator<Item = (DVec3, f64)> + Clone) -> Self {
        let sum: DVec3 = rim.clone().map(|(r, length)| r / length).sum();
        let axis = sum.normalize_or_zero();
        let (mut cos, mut sin) = (1.0_f64, 0.0_f64);
        for (r, length) in rim {
            cos = cos.min(axis.dot(r) / length);
            sin = sin.max(axis.cross(r).length() / length);
        }
        if cos > 0.0 {
            return Self { axis, cos, sin };
        }
        // Wider than a half-space.
        Self::ALL
    }

    /// True when the two surely share nothing.
    pub(super) fn is_apart(&self, other: &Self) -> bool {
        // The angle between the axes exceeds the sum of those of the cones.
        let least = self.cos * other.cos - self.sin * other.sin;
        self.axis.dot(other.axis) < least - ROUND_ROUNDOFF
    }
}

impl Ball {
    /// The ball of the given `radius` (metres) about `centre` (from the viewpoint, metres).
    pub fn new(centre: DVec3, radius: f64) -> Self {
        let squared = centre.length_squared();
        let beyond = squared - radius * radius;
        if beyond > 0.0 {
            return Self {
                centre,
                radius,
                tangent: beyond.sqrt(),
                slack: ROUND_ROUNDOFF * squared.sqrt(),
            };
        }
        // The viewpoint is in it, and sees it everywhere.
        Self {
            centre,
            radius: f64::INFINITY,
            tangent: 0.0,
            slack: 0.0,
        }
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

/// What of a convex polygon lies in front of `plane`.
pub(crate) fn clip_to_front(points: &[DVec3], plane: Plane) -> Piece {
    clip(points, |&p| plane.distance(p))
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

/// Rounding error of `(b × a) · d` for a direction `d` of unit length.
fn side_slack(a: DVec3, b: DVec3) -> f64 {
    SIDE_ROUNDOFF * (a.length_squared() * b.length_squared()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    /// A triangle of directions about `axis`, up to `width` times as wide as it is far.
    fn triangle(random: &mut Random, axis: DVec3, width: f64) -> [DVec3; 3] {
        [0, 1, 2].map(|_| axis + random.point(width))
    }

    fn hull(t: &[DVec3; 3]) -> RoundCone {
        RoundCone::new(t.iter().map(|d| (*d, d.length())))
    }

    #[test]
    fn round_cones_that_share_a_direction_are_not_apart() {
        let mut random = Random(7);
        let (mut apart, mut wide) = (0, 0);
        for i in 0..20_000 {
            // From needles to more than half of all directions.
            let width = [1e-6, 1e-2, 0.5, 3.0][i % 4];
            let other = [1e-6, 1e-2, 0.5, 3.0][i / 4 % 4];
            let axis = random.point(1.0).normalize();
            let a = triangle(&mut random, axis, width);
            let mut b = triangle(&mut random, axis, other);
            let own = hull(&a);
            wide += usize::from(own.cos.is_nan());
            if own.is_apart(&hull(&b)) {
                apart += 1;
                continue;
            }
            // A corner in common, and a point of the side of one: then they are not, however they lie otherwise.
            b[0] = 2.0 * a[0];
            assert!(!own.is_apart(&hull(&b)), "{a:?} {b:?}");
            b[0] = 0.3 * a[0] + 0.7 * a[1];
            assert!(!own.is_apart(&hull(&b)), "{a:?} {b:?}");
            // A ball that a corner's direction meets is not clear of the cone.
            let mut cones = Cones::default();
            let item = cones.cone(a.into_iter(), 1.0, 0).expect("a triangle");
            cones.items.push(item);
            let centre = 2.0 * a[2] + random.point(width);
            let across = (centre - centre.project_onto(a[2])).length();
            if centre.dot(a[2]) > 0.0 {
                assert!(!cones.is_clear_of(0, &Ball::new(centre, across)), "{a:?}");
            }
        }
        assert!(apart > 100 && wide > 100, "{apart} apart, {wide} wide");
    }
}
