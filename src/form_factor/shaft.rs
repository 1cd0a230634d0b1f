//! What stands in the space between two convex polygons.

use super::Patch;
use crate::geom::Plane;
use crate::visibility::{Blockers, Part, Region};
use glam::DVec3;

/// How much of one polygon another one sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sight {
    /// All of it, from everywhere.
    Clear,
    /// Nothing: one blocker crosses every line between them.
    Hidden,
    /// Something may stand between.
    Partial,
}

/// How `a` and `b` see each other. Faces in the plane of either hide nothing.
pub(super) fn sight(a: &Patch, b: &Patch, blockers: &Blockers) -> Sight {
    let region = shaft(a, b);
    let tol = blockers.weld_distance();
    let is_ahead =
        |plane: &Plane, corners: &[DVec3]| corners.iter().any(|&c| plane.distance(c) > tol);
    let mut sight = Sight::Clear;
    blockers.query(&region, |i| {
        let part = blockers.part(i);
        let corners = blockers.corners(part);
        let stands_between = is_ahead(&a.plane, corners)
            && is_ahead(&b.plane, corners)
            && region.may_meet_polygon(corners, 0.0);
        if sight != Sight::Hidden && stands_between {
            sight = if hides_all(part, corners, a, b) {
                Sight::Hidden
            } else {
                Sight::Partial
            };
        }
    });
    sight
}

/// The convex hull of both polygons (Haines & Wallace 1991): the planes through an edge of one and a corner of the other
/// that have all of both on one side, and the box around them.
fn shaft(a: &Patch, b: &Patch) -> Region {
    let points = || a.corners.iter().chain(&b.corners).copied();
    let mut region = Region {
        planes: [a.plane, b.plane].into_iter().collect(),
        bounds: (
            points().fold(DVec3::INFINITY, DVec3::min),
            points().fold(DVec3::NEG_INFINITY, DVec3::max),
        ),
    };
    for (from, to) in [(a, b), (b, a)] {
        for [p, q] in from.edges() {
            for &v in &to.corners {
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

/// Whether the convex blocker crosses every straight line from `a` to `b`: those between their corners are enough, as where
/// all others cross its plane lies among where these do.
fn hides_all(part: &Part, corners: &[DVec3], a: &Patch, b: &Patch) -> bool {
    let heights =
        |p: &Patch| -> Vec<f64> { p.corners.iter().map(|&c| part.plane.distance(c)).collect() };
    let (from, to) = (heights(a), heights(b));
    let is_apart = |above: &[f64], below: &[f64]| {
        above.iter().all(|&h| h > 0.0) && below.iter().all(|&h| h < 0.0)
    };
    if !is_apart(&from, &to) && !is_apart(&to, &from) {
        return false;
    }
    let holds = |x: DVec3| {
        (0..corners.len()).all(|i| {
            let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
            part.plane.normal.dot((q - p).cross(x - p)) >= 0.0
        })
    };
    a.corners.iter().zip(&from).all(|(&x, hx)| {
        b.corners
            .iter()
            .zip(&to)
            .all(|(&y, hy)| holds(x + (y - x) * (hx / (hx - hy))))
    })
}
