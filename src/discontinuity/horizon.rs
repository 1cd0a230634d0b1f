//! The emitter's horizon: where its own plane meets a receiver, light begins with a jump of the slope (D1).

use super::event::Search;
use super::trace;
use super::wedge::{Apex, Wedge};
use super::{Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::direct::DirectLight;
use crate::geom::Plane;
use crate::scene::{EmitterId, FaceSide, Scene};
use crate::visibility::{Part, Region, Scratch, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;

/// The horizon lines of all emitters on all receivers that they reach, as far as some corner of the emitter sees them within
/// its plane.
pub(super) fn find(search: &Search) -> Vec<Discontinuity> {
    let emitters: Vec<EmitterId> = search.scene.emitters.ids().collect();
    let found: Vec<Vec<Discontinuity>> = emitters
        .par_iter()
        .map(|&emitter| of_emitter(search, emitter))
        .collect();
    found.into_iter().flatten().collect()
}

fn of_emitter(search: &Search, emitter: EmitterId) -> Vec<Discontinuity> {
    let (scene, light) = (search.scene, search.light);
    let e = scene.emitters[emitter];
    let (origin, normal) = (
        scene.faces[e.face].frame.origin,
        scene.normal(e.face, e.side),
    );
    let plane = Plane::new(origin, normal);
    let above_and_below = normal * scene.weld_distance;
    let slab = Region {
        planes: [
            Plane::new(origin - above_and_below, normal),
            Plane::new(origin + above_and_below, -normal),
        ]
        .into_iter()
        .collect(),
        bounds: search.bounds(emitter),
    };
    let mut parts = Vec::new();
    light.blockers.query(&slab, |i| parts.push(i));
    parts.sort_unstable();
    let mut out = Vec::new();
    for i in parts {
        let part = light.blockers.part(i);
        let crossing = crossing(light, part, &plane);
        let Some(ends) = crossing.filter(|ends| search.is_within_reach(emitter, ends)) else {
            continue;
        };
        for side in [FaceSide::Front, FaceSide::Back] {
            if scene.receives(part.face, side) {
                on_receiver(scene, light, emitter, part, side, ends, &mut out);
            }
        }
    }
    out
}

/// The segment in which a convex part crosses `plane`; none when it only touches it.
pub(super) fn crossing(light: &DirectLight, part: &Part, plane: &Plane) -> Option<[DVec3; 2]> {
    let tol = light.blockers.weld_distance();
    let corners = light.blockers.corners(part);
    let d: Vec<f64> = corners
        .iter()
        .map(|&c| {
            let d = plane.distance(c);
            if d.abs() <= tol { 0.0 } else { d }
        })
        .collect();
    if !(d.iter().any(|&d| d > 0.0) && d.iter().any(|&d| d < 0.0)) {
        return None;
    }
    let mut ends = Vec::with_capacity(2);
    for i in 0..corners.len() {
        let j = (i + 1) % corners.len();
        if d[i] == 0.0 {
            ends.push(corners[i]);
        } else if d[i] * d[j] < 0.0 {
            ends.push(corners[i] + (corners[j] - corners[i]) * (d[i] / (d[i] - d[j])));
        }
    }
    (ends.len() == 2).then(|| [ends[0], ends[1]])
}

/// Adds the stretches of `ends` that some corner of the emitter sees.
fn on_receiver(
    scene: &Scene,
    light: &DirectLight,
    emitter: EmitterId,
    part: &Part,
    side: FaceSide,
    ends: [DVec3; 2],
    out: &mut Vec<Discontinuity>,
) {
    let tol = scene.weld_distance;
    let normal = scene.normal(part.face, side);
    let horizon = Plane::new(ends[0], normal);
    let mut lit: Vec<(f64, f64)> = scene.faces[scene.emitters[emitter].face]
        .loops
        .iter()
        .flatten()
        .filter(|&&v| horizon.distance(scene.vertices[v]) > tol)
        .filter_map(|&v| Wedge::new(Apex::Vertex(v, scene.vertices[v]), ends, None, tol))
        .flat_map(|w| trace::lit_on_rim(&w, scene, light.blockers))
        .collect();
    lit.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut scratch = Scratch::default();
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for (a, b) in lit {
        match merged.last_mut() {
            Some(last) if a <= last.1 => last.1 = last.1.max(b),
            _ => merged.push((a, b)),
        }
    }
    for (a, b) in merged {
        let at = |s: f64| ends[0] + (ends[1] - ends[0]) * s;
        let plane = light.polygons_of(emitter).first().map(|p| p.plane);
        // On the line itself the emitter is seen edge-on; its size away from it gives the scale of the break.
        let size = scene.faces[scene.emitters[emitter].face].area.sqrt();
        let jump = plane.map_or(0.0, |p| {
            let beside = Viewpoint::new(at(0.5 * (a + b)) + p.normal * size, normal);
            light.unoccluded_from(emitter, &beside, &mut scratch).mean()
        });
        if at(a).distance(at(b)) > tol && jump > 0.0 {
            out.push(Discontinuity {
                face: part.face,
                side,
                ends: [at(a), at(b)],
                order: DiscontinuityOrder::D1,
                kind: EventKind::Horizon,
                emitter: Some(emitter),
                cause: Cause::EmitterPlane,
                jump,
            });
        }
    }
}
