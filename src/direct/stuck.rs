//! Lamps that lie against another body: no light leaves there.
//!
//! A pane of glass that shines and fills its frame shines with its edges, too, and these lie in the planes of the frame's faces.
//! Of faces in one plane the lamp is the one that is seen, so that its edges would light the wood from within: ten times as
//! bright as the room, where nobody looks.

use super::emitters::convex_polygons;
use crate::geom::{Plane, bounds, even_point, even_point_of};
use crate::scene::{EmitterId, Scene};
use crate::visibility::{Blockers, Hit, Region, clip_to_front};
use glam::DVec3;
use rayon::prelude::*;

/// Points of a lamp from which is looked, and rays from each.
const POINTS: u32 = 4;
const RAYS: u32 = 16;

/// The emitters that lie with all of their front against the fronts of other faces, where either they or those are the skin of a
/// body: of something that shows only backs from within. Ascending.
pub fn stuck_emitters(scene: &Scene, blockers: &Blockers) -> Vec<EmitterId> {
    let ids: Vec<EmitterId> = scene.emitters.ids().collect();
    let is_stuck = |&id: &EmitterId| {
        let emitter = scene.emitters[id];
        let normal = scene.normal(emitter.face, emitter.side);
        let polygons = convex_polygons(scene, emitter);
        polygons.iter().all(|p| is_covered(p, normal, blockers))
            && [normal, -normal].into_iter().any(|way| {
                polygons
                    .iter()
                    .all(|p| is_inside_body(p, way, scene, blockers))
            })
    };
    ids.into_par_iter().filter(is_stuck).collect()
}

/// Whether other faces in the plane of a convex polygon, turned towards its front, leave nothing of it as wide as the weld distance.
fn is_covered(polygon: &[DVec3], normal: DVec3, blockers: &Blockers) -> bool {
    let (plane, tol) = (Plane::new(polygon[0], normal), blockers.weld_distance());
    let pad = DVec3::splat(tol);
    let (low, high) = bounds(polygon.iter().copied());
    let region = Region {
        planes: [].into_iter().collect(),
        bounds: (low - pad, high + pad),
    };
    let mut near = Vec::new();
    blockers.query(&region, |i| near.push(i));
    near.sort_unstable();
    let mut left = vec![polygon.to_vec()];
    for part in near.into_iter().map(|i| blockers.part(i)) {
        let corners = blockers.corners(part);
        let is_flush = || corners.iter().all(|&c| plane.distance(c).abs() <= tol);
        if part.plane.normal.dot(normal) < 0.0 && is_flush() {
            left = left
                .into_iter()
                .flat_map(|piece| without(piece, corners, part.plane.normal, tol))
                .collect();
        }
    }
    left.is_empty()
}

/// What the convex polygon `hole` leaves of another one in its plane, but for strips narrower than `tol`.
fn without(piece: Vec<DVec3>, hole: &[DVec3], normal: DVec3, tol: f64) -> Vec<Vec<DVec3>> {
    let mut rest = piece;
    let mut left = Vec::new();
    for (i, &a) in hole.iter().enumerate() {
        let b = hole[(i + 1) % hole.len()];
        let Some(inwards) = normal.cross(b - a).try_normalize() else {
            continue;
        };
        let outside = clip_to_front(&rest, Plane::new(a, -inwards));
        if is_wider(&outside, tol) {
            left.push(outside.to_vec());
        }
        rest = clip_to_front(&rest, Plane::new(a, inwards)).to_vec();
        if rest.len() < 3 {
            break;
        }
    }
    left
}

/// Whether a convex polygon is wider than `tol` across its longest extent, about: a strip has its width times half of its outline
/// for its area.
fn is_wider(corners: &[DVec3], tol: f64) -> bool {
    if corners.len() < 3 {
        return false;
    }
    let n = corners.len();
    let outline: f64 = (0..n)
        .map(|i| corners[i].distance(corners[(i + 1) % n]))
        .sum();
    let fan = (1..n - 1).map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]));
    0.5 * fan.sum::<DVec3>().length() > tol * 0.5 * outline
}

/// Whether all that is seen from a convex polygon towards `way` are backs, near which there may be fronts in the same place.
fn is_inside_body(polygon: &[DVec3], way: DVec3, scene: &Scene, blockers: &Blockers) -> bool {
    let (rays, tol) = (blockers.rays(), blockers.weld_distance());
    let reach = 2.0 * scene.diagonal;
    let (u, v) = way.any_orthonormal_pair();
    (0..POINTS).all(|i| {
        let origin = even_point_of(polygon, i);
        (0..RAYS).all(|k| {
            let [along, around] = even_point(i * RAYS + k).to_array();
            // Evenly over the half of all directions, but for those next to the plane.
            let height = 0.5 * (1.0 + along);
            let flat = (1.0 - height * height).sqrt();
            let (sine, cosine) = (std::f64::consts::TAU * around).sin_cos();
            let dir = way * height + (u * cosine + v * sine) * flat;
            let Some(first) = rays.nearest(origin, dir, tol, reach) else {
                return false;
            };
            let is_back = |h: &Hit| !h.is_front;
            // Of two bodies that touch, the front of one may be met before the back of the other.
            is_back(&first) || {
                let back = rays.nearest_where(origin, dir, tol, first.t + tol, is_back);
                back.is_some()
            }
        })
    })
}
