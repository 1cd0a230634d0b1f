//! Planes of blockers that cut an emitter: where the blocker is seen edge-on, the slope of the light jumps (D1).
//!
//! On both sides of such a plane a flat blocker hides the emitter the more the farther the plane is away, and a solid
//! hides it with one or the other rim of the face: the hidden part grows linearly, at another rate on each side.
//!
//! ```text
//!      S ────────── the emitter, cut by the plane in a segment S
//!       \    /
//!        \  F       the blocker's face, which lies in the plane
//!         \ │\
//!   ───────lines──  a receiver: lit by some point of S past F
//! ```

use super::trace::{self, Landing};
use super::wedge::{Apex, Wedge};
use super::{Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::direct::DirectLight;
use crate::geom::Plane;
use crate::scene::{EmitterId, FaceId, Scene};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;

/// So many points of the emitter are followed past a face at first.
const FIRST_POINTS: usize = 9;

/// Between two points from which light lands differently the emitter is halved so many times: the ends of lines are then
/// as good as this power of two makes them.
const HALVINGS: u32 = 7;

/// The lines of all faces' planes, for all emitters.
pub(super) fn find(scene: &Scene, light: &DirectLight) -> Vec<Discontinuity> {
    let faces: Vec<FaceId> = scene.faces.ids().collect();
    let found: Vec<Vec<Discontinuity>> = faces
        .par_iter()
        .map(|&face| {
            let plane = scene.faces[face].frame.plane();
            let mut out = Vec::new();
            for emitter in scene.emitters.ids() {
                if scene.emitters[emitter].face == face {
                    continue;
                }
                if let Some(cut) = cut(scene, light, emitter, &plane) {
                    past_face(scene, light, emitter, face, cut, &mut out);
                }
            }
            out
        })
        .collect();
    found.into_iter().flatten().collect()
}

/// The segment in which `plane` cuts an emitter, from one end to the other; none when it only touches it.
fn cut(
    scene: &Scene,
    light: &DirectLight,
    emitter: EmitterId,
    plane: &Plane,
) -> Option<[DVec3; 2]> {
    let tol = scene.weld_distance;
    let own = scene.normal(scene.emitters[emitter].face, scene.emitters[emitter].side);
    let along = own.cross(plane.normal).try_normalize()?;
    let mut ends: Option<[DVec3; 2]> = None;
    for polygon in light.polygons.iter().filter(|p| p.emitter == emitter) {
        let corners = &polygon.corners;
        let heights = || corners.iter().map(|&c| plane.distance(c));
        if !(heights().any(|h| h > tol) && heights().any(|h| h < -tol)) {
            continue;
        }
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let (ha, hb) = (plane.distance(a), plane.distance(b));
            if (ha > 0.0) == (hb > 0.0) {
                continue;
            }
            let p = a + (b - a) * (ha / (ha - hb));
            let [first, last] = ends.get_or_insert([p, p]);
            if (p - *first).dot(along) < 0.0 {
                *first = p;
            }
            if (p - *last).dot(along) > 0.0 {
                *last = p;
            }
        }
    }
    ends.filter(|[a, b]| a.distance(*b) > tol)
}

/// Follows the plane of `face` from points of the emitter's segment `cut` past the face to the receivers.
fn past_face(
    scene: &Scene,
    light: &DirectLight,
    emitter: EmitterId,
    face: FaceId,
    cut: [DVec3; 2],
    out: &mut Vec<Discontinuity>,
) {
    let e = scene.emitters[emitter];
    let plane = Plane::new(
        scene.faces[e.face].frame.origin,
        scene.normal(e.face, e.side),
    );
    let tol = scene.weld_distance;
    let points: Vec<DVec3> = scene.faces[face]
        .loops
        .iter()
        .flatten()
        .map(|&v| scene.vertices[v])
        .filter(|&p| plane.distance(p) > tol)
        .collect();
    let past = |share: f64| -> Vec<Landing> {
        let apex = cut[0].lerp(cut[1], share);
        chord(apex, &points, plane.normal, tol)
            .and_then(|rim| Wedge::new(Apex::Point(apex), rim, None, tol))
            .map_or(Vec::new(), |wedge| {
                trace::past_edge(&wedge, scene, light.blockers).landings
            })
    };
    let mut stretches = Vec::new();
    let share = |i: usize| i as f64 / (FIRST_POINTS - 1) as f64;
    let mut before = past(0.0);
    for i in 1..FIRST_POINTS {
        let after = past(share(i));
        let shares = (share(i - 1), share(i));
        follow(&past, shares, (&before, &after), HALVINGS, &mut stretches);
        before = after;
    }
    let mut scratch = Scratch::default();
    for l in united(stretches, tol) {
        let middle = 0.5 * (l.ends[0] + l.ends[1]);
        let view = Viewpoint::new(middle, scene.normal(l.face, l.side));
        let jump = light.unoccluded_from(emitter, &view, &mut scratch).mean();
        if jump > 0.0 && l.face != face {
            out.push(Discontinuity {
                face: l.face,
                side: l.side,
                ends: l.ends,
                order: DiscontinuityOrder::D1,
                kind: EventKind::EdgeOn,
                emitter: Some(emitter),
                cause: Cause::Face(face),
                jump,
            });
        }
    }
}

/// Adds what the points between two shares of the cut light. Where both light the same stretches one for one, those
/// between do nothing but move.
fn follow(
    past: &impl Fn(f64) -> Vec<Landing>,
    (from, to): (f64, f64),
    (before, after): (&[Landing], &[Landing]),
    halvings: u32,
    out: &mut Vec<Landing>,
) {
    let is_same = before.len() == after.len()
        && before
            .iter()
            .zip(after)
            .all(|(a, b)| (a.face, a.side) == (b.face, b.side));
    if is_same {
        out.extend(before.iter().zip(after).map(|(a, b)| hull(a, b)));
    } else if halvings == 0 {
        out.extend(before.iter().chain(after));
    } else {
        let middle = 0.5 * (from + to);
        let between = past(middle);
        follow(past, (from, middle), (before, &between), halvings - 1, out);
        follow(past, (middle, to), (&between, after), halvings - 1, out);
    }
}

/// The stretch from the first end of two collinear ones to the last.
fn hull(a: &Landing, b: &Landing) -> Landing {
    let along = a.ends[1] - a.ends[0];
    let mut ends = [a.ends[0], a.ends[1], b.ends[0], b.ends[1]];
    ends.sort_unstable_by(|p, q| along.dot(*p).total_cmp(&along.dot(*q)));
    Landing {
        ends: [ends[0], ends[3]],
        ..*a
    }
}

/// Stretches on one side of one face – all of them collinear – with those that touch made one.
fn united(mut stretches: Vec<Landing>, tol: f64) -> Vec<Landing> {
    stretches.sort_by_key(|l| (l.face, l.side));
    let mut out: Vec<Landing> = Vec::new();
    for group in stretches.chunk_by_mut(|a, b| (a.face, a.side) == (b.face, b.side)) {
        let along = (group[0].ends[1] - group[0].ends[0]).normalize_or_zero();
        for l in group.iter_mut() {
            if along.dot(l.ends[1] - l.ends[0]) < 0.0 {
                l.ends.swap(0, 1);
            }
        }
        group.sort_by(|a, b| along.dot(a.ends[0]).total_cmp(&along.dot(b.ends[0])));
        let first = out.len();
        for l in group.iter() {
            match out[first..].last_mut() {
                Some(last) if along.dot(l.ends[0] - last.ends[1]) <= tol => {
                    if along.dot(l.ends[1] - last.ends[1]) > 0.0 {
                        last.ends[1] = l.ends[1];
                    }
                }
                _ => out.push(*l),
            }
        }
    }
    out
}

/// The two of `points` (in a plane with `apex`) between which all others are seen from there, left and right of the
/// direction `ahead`.
fn chord(apex: DVec3, points: &[DVec3], ahead: DVec3, tol: f64) -> Option<[DVec3; 2]> {
    let directions = || points.iter().map(|&p| p - apex);
    let mut far = directions().filter(|d| d.length() > tol);
    let first = far.next()?;
    // All lie ahead, within half a turn: the sine of the angle between two of them says which is farther left.
    let normal = directions()
        .map(|d| first.cross(d))
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?
        .try_normalize()?;
    let is_left = |a: DVec3, b: DVec3| a.cross(b).dot(normal) > 0.0;
    let (mut left, mut right) = (first, first);
    for d in far.filter(|d| d.dot(ahead) > 0.0) {
        if is_left(left, d) {
            left = d;
        }
        if is_left(d, right) {
            right = d;
        }
    }
    Some([apex + right, apex + left])
}
