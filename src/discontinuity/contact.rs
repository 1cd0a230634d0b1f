//! D0 lines: where another face stands on a receiver, pierces it, or lies in its plane.

use super::event::Search;
use super::horizon::crossing;
use super::{Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::direct::{DirectLight, unoccluded_by};
use crate::geom::bounds;
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::{Blockers, Part, Region, Scratch, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;

/// All contact lines.
pub(super) fn find(search: &Search) -> Vec<Discontinuity> {
    let (scene, light) = (search.scene, search.light);
    let blockers = light.blockers;
    from_near_pairs(blockers, |receiver, other, scratch, out| {
        for (ends, sides) in contacts(scene, light, receiver, other) {
            let Some(ends) = clip_to_part(blockers, receiver, ends) else {
                continue;
            };
            for side in [FaceSide::Front, FaceSide::Back] {
                if sides[usize::from(side == FaceSide::Back)] && scene.receives(receiver.face, side)
                {
                    let middle = 0.5 * (ends[0] + ends[1]);
                    let view = Viewpoint::new(middle, scene.normal(receiver.face, side));
                    out.push(Discontinuity {
                        face: receiver.face,
                        side,
                        ends,
                        order: DiscontinuityOrder::D0,
                        kind: EventKind::Contact,
                        emitter: None,
                        cause: Cause::Face(other.face),
                        jump: jump_at(search, &view, scratch),
                    });
                }
            }
        }
    })
}

/// What the emitters that matter there, and the lights, give at `view` if nothing hides them, W/m².
fn jump_at(search: &Search, view: &Viewpoint, scratch: &mut Scratch) -> f64 {
    let light = search.light;
    let lights = light.lights.iter().map(|l| unoccluded_by(l, view).mean());
    let emitters = search.that_reach(&[view.position]).into_iter();
    let emitters = emitters.map(|e| light.unoccluded_from(e, view, scratch).mean());
    emitters.sum::<f64>() + lights.sum::<f64>()
}

/// Pairs (covered face, face seen instead of it) among coplanar overlapping faces.
pub(super) fn covers(scene: &Scene, blockers: &Blockers) -> Vec<(FaceId, FaceId)> {
    let mut out = from_near_pairs(blockers, |receiver, other, _, out| {
        if lies_in_plane(blockers, other, receiver) && covers_face(scene, other.face, receiver.face)
        {
            out.push((receiver.face, other.face));
        }
    });
    out.sort_unstable();
    out.dedup();
    out
}

/// Whether `upper` is seen where it overlaps `lower` in one plane: an emitter before others, then the smaller face
/// (a decal on a wall) when both face the same way. Faces back to back hide nothing of each other.
fn covers_face(scene: &Scene, upper: FaceId, lower: FaceId) -> bool {
    let emits = |f| scene.material_of(f).is_emitter();
    match (emits(upper), emits(lower)) {
        (true, false) => true,
        (false, true) => false,
        _ => {
            let (u, l) = (&scene.faces[upper], &scene.faces[lower]);
            u.frame.n.dot(l.frame.n) > 0.0 && (u.area, upper) < (l.area, lower)
        }
    }
}

/// What `visit(receiver, other, scratch, out)` appends for every ordered pair of parts of different faces whose boxes touch
/// within the weld distance, in the order of the parts.
fn from_near_pairs<T: Send>(
    blockers: &Blockers,
    visit: impl Fn(&Part, &Part, &mut Scratch, &mut Vec<T>) + Sync,
) -> Vec<T> {
    let pad = DVec3::splat(blockers.weld_distance());
    let of_receiver = |scratch: &mut Scratch, receiver: &Part| {
        let corners = blockers.corners(receiver);
        let (low, high) = bounds(corners.iter().copied());
        let region = Region {
            planes: [].into_iter().collect(),
            bounds: (low - pad, high + pad),
        };
        let (mut near, mut out) = (Vec::new(), Vec::new());
        blockers.query(&region, |i| near.push(i));
        near.sort_unstable();
        for i in near {
            let other = blockers.part(i);
            if other.face != receiver.face {
                visit(receiver, other, scratch, &mut out);
            }
        }
        out
    };
    let parts = blockers.parts().par_iter();
    let found: Vec<Vec<T>> = parts.map_init(Scratch::default, of_receiver).collect();
    found.into_iter().flatten().collect()
}

fn lies_in_plane(blockers: &Blockers, part: &Part, of: &Part) -> bool {
    blockers
        .corners(part)
        .iter()
        .all(|&c| of.plane.distance(c).abs() <= blockers.weld_distance())
}

/// The segments in which `other` meets the plane of `receiver`, each with the sides (front, back) it affects.
fn contacts(
    scene: &Scene,
    light: &DirectLight,
    receiver: &Part,
    other: &Part,
) -> Vec<([DVec3; 2], [bool; 2])> {
    let blockers = light.blockers;
    if let Some(ends) = crossing(light, other, &receiver.plane) {
        return vec![(ends, [true, true])];
    }
    let is_coplanar = lies_in_plane(blockers, other, receiver);
    if is_coplanar && !covers_face(scene, other.face, receiver.face) {
        return Vec::new();
    }
    let corners = blockers.corners(other);
    let tol = blockers.weld_distance();
    let d: Vec<f64> = corners
        .iter()
        .map(|&c| receiver.plane.distance(c))
        .collect();
    let sides = if is_coplanar {
        [true, true]
    } else {
        let is_in_front = d.iter().any(|&d| d > tol);
        [is_in_front, !is_in_front]
    };
    let edges = blockers.edges(other);
    (0..corners.len())
        .filter_map(|i| {
            let j = (i + 1) % corners.len();
            let edge = edges[i]?;
            let is_own = scene.edges[edge]
                .uses
                .iter()
                .any(|u| u.face == receiver.face);
            (d[i].abs() <= tol && d[j].abs() <= tol && !is_own)
                .then(|| ([corners[i], corners[j]], sides))
        })
        .collect()
}

/// The stretch of a segment (in the part's plane) inside a convex part; none when it is no longer than the weld distance.
pub(super) fn clip_to_part(
    blockers: &Blockers,
    part: &Part,
    ends: [DVec3; 2],
) -> Option<[DVec3; 2]> {
    let corners = blockers.corners(part);
    let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let inwards = part.plane.normal.cross(b - a);
        let (da, db) = (inwards.dot(ends[0] - a), inwards.dot(ends[1] - a));
        if da < 0.0 && db < 0.0 {
            return None;
        } else if da < 0.0 {
            t0 = t0.max(da / (da - db));
        } else if db < 0.0 {
            t1 = t1.min(da / (da - db));
        }
    }
    let at = |t: f64| {
        if t >= 1.0 {
            ends[1]
        } else {
            ends[0] + (ends[1] - ends[0]) * t
        }
    };
    (t0 < t1 && at(t0).distance(at(t1)) > blockers.weld_distance()).then(|| [at(t0), at(t1)])
}
