//! Lights without a surface: where their shadows end the value jumps (D0), at the rims of a spot's cone a derivative.
//!
//! A shadow ends where a sight line from the light grazes an edge: the VE wedge of an emitter that has shrunk to one vertex. Of
//! a directional light the rays of a wedge are parallel.

use super::contact::clip_to_part;
use super::event::is_silhouette;
use super::landing::Landing;
use super::trace;
use super::wedge::{Apex, Wedge};
use super::{Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::direct::{DirectLight, cone_cosines, unoccluded_by};
use crate::scene::{EdgeId, FaceSide, PunctualKind, PunctualLight, Scene};
use crate::visibility::{Part, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// The rim of a cone is followed in so many steps at first, and each halved until its chord is close enough.
const FIRST_STEPS: usize = 16;

/// Halvings of a step at most: they part the rim in more pieces than a mesh could hold.
const MOST_HALVINGS: u32 = 8;

/// The ends of all shadows of all lights.
pub(super) fn shadows(scene: &Scene, light: &DirectLight) -> Vec<Discontinuity> {
    let edges: Vec<EdgeId> = scene.edges.ids().collect();
    let found: Vec<Vec<Discontinuity>> = edges
        .par_iter()
        .map(|&edge| {
            let mut out = Vec::new();
            for (number, source) in light.lights.iter().enumerate() {
                past_edge(scene, light, (number as u32, source), edge, &mut out);
            }
            out
        })
        .collect();
    found.into_iter().flatten().collect()
}

/// Adds what the shadow of one edge ends at.
fn past_edge(
    scene: &Scene,
    light: &DirectLight,
    (number, source): (u32, &PunctualLight),
    edge: EdgeId,
    out: &mut Vec<Discontinuity>,
) {
    let ends = scene.edges[edge].ends;
    let rim = ends.map(|v| scene.vertices[v]);
    let tol = scene.weld_distance;
    let wedge = match source.kind {
        PunctualKind::Directional => {
            Wedge::parallel(source.direction * scene.diagonal, rim, ends, tol)
        }
        PunctualKind::Point | PunctualKind::Spot { .. } => {
            Wedge::new(Apex::Point(source.position), rim, Some(ends), tol)
        }
    };
    let Some(wedge) = wedge.filter(|w| is_silhouette(scene, &w.plane, edge)) else {
        return;
    };
    for landing in trace::past_edge_from_light(&wedge, scene, light.blockers) {
        let Some(ends) = within_cone(source, landing.ends) else {
            continue;
        };
        let jump = greatest(scene, source, &landing, ends);
        if jump > 0.0 && ends[0].distance(ends[1]) > tol {
            out.push(Discontinuity {
                face: landing.face,
                side: landing.side,
                ends,
                order: DiscontinuityOrder::D0,
                kind: EventKind::Ve,
                emitter: None,
                cause: Cause::LightEdge(number, edge),
                jump,
            });
        }
    }
}

/// What the light gives at an end or in the middle of a line, whichever is most, W/m².
fn greatest(scene: &Scene, source: &PunctualLight, landing: &Landing, ends: [DVec3; 2]) -> f64 {
    let normal = scene.normal(landing.face, landing.side);
    [ends[0], 0.5 * (ends[0] + ends[1]), ends[1]]
        .map(|p| unoccluded_by(source, &Viewpoint::new(p, normal)).mean())
        .into_iter()
        .fold(0.0, f64::max)
}

/// The part of a segment inside a spot's cone; all of it where the light is no spot.
fn within_cone(source: &PunctualLight, [a, b]: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let Some([_, cosine]) = cone_cosines(source) else {
        return Some([a, b]);
    };
    // On the double cone (p·axis)² = cos² p²; the half that is lit has p·axis ≥ cos |p|.
    let (p, d) = (a - source.position, b - a);
    let axis = source.direction;
    let bend = |u: DVec3, v: DVec3| axis.dot(u) * axis.dot(v) - cosine * cosine * u.dot(v);
    let (qa, qb, qc) = (bend(d, d), bend(d, p), bend(p, p));
    let mut cuts = vec![0.0, 1.0];
    let root = (qb * qb - qa * qc).sqrt();
    cuts.extend(
        [(-qb - root) / qa, (-qb + root) / qa]
            .into_iter()
            .filter(|t| *t > 0.0 && *t < 1.0),
    );
    cuts.sort_unstable_by(f64::total_cmp);
    let is_inside = |t: f64| {
        let q = p + d * t;
        axis.dot(q) > cosine * q.length()
    };
    let inside = || cuts.windows(2).filter(|c| is_inside(0.5 * (c[0] + c[1])));
    let (from, to) = (inside().next()?[0], inside().next_back()?[1]);
    let at = |t: f64| if t >= 1.0 { b } else { a + d * t };
    Some([at(from), at(to)])
}

/// The rims of all spots' cones on the faces that they light, as chords: where the light begins to fall off its slope
/// jumps, where it ends its curvature.
pub(super) fn cones(scene: &Scene, light: &DirectLight, chord: f64) -> Vec<Discontinuity> {
    let mut out = Vec::new();
    for (number, source) in light.lights.iter().enumerate() {
        let Some([full, none]) = cone_cosines(source) else {
            continue;
        };
        let rims = [
            (full, DiscontinuityOrder::D1),
            (none, DiscontinuityOrder::D2),
        ];
        for (cosine, order) in rims.into_iter().filter(|r| r.0.abs() < 1.0) {
            let rim = Rim {
                scene,
                light,
                source,
                number: number as u32,
                cosine,
                order,
            };
            for part in light.blockers.parts() {
                for side in [FaceSide::Front, FaceSide::Back] {
                    if scene.receives(part.face, side) {
                        rim.on_part(part, side, chord, &mut out);
                    }
                }
            }
        }
    }
    out
}

/// A circle of directions around the axis of a spot.
struct Rim<'s> {
    scene: &'s Scene,
    light: &'s DirectLight<'s>,
    source: &'s PunctualLight,
    number: u32,
    cosine: f64,
    order: DiscontinuityOrder,
}

impl Rim<'_> {
    fn direction(&self, turn: f64) -> DVec3 {
        let axis = self.source.direction;
        let (u, v) = axis.any_orthonormal_pair();
        let sine = (1.0 - self.cosine * self.cosine).sqrt();
        axis * self.cosine + (u * turn.cos() + v * turn.sin()) * sine
    }

    /// Adds the chords of the rim on one side of a convex part.
    fn on_part(&self, part: &Part, side: FaceSide, chord: f64, out: &mut Vec<Discontinuity>) {
        let normal = self.scene.normal(part.face, side);
        let height = part.plane.distance(self.source.position) * side.sign();
        if height <= self.scene.weld_distance {
            return;
        }
        let hit = |turn: f64| {
            let d = self.direction(turn);
            let t = height / -normal.dot(d);
            (t > 0.0 && t.is_finite()).then(|| self.source.position + d * t)
        };
        let tolerance = chord * self.scene.faces[part.face].area.sqrt();
        let step = |i: usize| TAU * i as f64 / FIRST_STEPS as f64;
        for i in 0..FIRST_STEPS {
            let mut points = Vec::new();
            subdivide(
                &hit,
                (step(i), step(i + 1)),
                tolerance,
                MOST_HALVINGS,
                &mut points,
            );
            for ends in points {
                self.push(part, side, ends, out);
            }
        }
    }

    /// Adds a chord as far as it lies on the part, when some of it is lit.
    fn push(&self, part: &Part, side: FaceSide, ends: [DVec3; 2], out: &mut Vec<Discontinuity>) {
        let (scene, blockers) = (self.scene, self.light.blockers);
        let Some(ends) = clip_to_part(blockers, part, ends) else {
            return;
        };
        let normal = scene.normal(part.face, side);
        // Beside the rim, where the spot shines: on the outer rim itself it gives nothing.
        let whole = PunctualLight {
            kind: PunctualKind::Point,
            ..self.source.clone()
        };
        let lit = DirectLight::of_light(whole, blockers);
        let mut scratch = crate::visibility::Scratch::default();
        let jump = [0.0, 0.5, 1.0]
            .map(|t| Viewpoint::new(ends[0].lerp(ends[1], t), normal))
            .map(|view| lit.irradiance(&view, &mut scratch).mean())
            .into_iter()
            .fold(0.0, f64::max);
        if jump > 0.0 {
            out.push(Discontinuity {
                face: part.face,
                side,
                ends,
                order: self.order,
                kind: EventKind::Ve,
                emitter: None,
                cause: Cause::Cone(self.number),
                jump,
            });
        }
    }
}

/// Appends chords of a curve between two parameters that depart from it by `tolerance` at most.
fn subdivide(
    hit: &impl Fn(f64) -> Option<DVec3>,
    (from, to): (f64, f64),
    tolerance: f64,
    halvings: u32,
    out: &mut Vec<[DVec3; 2]>,
) {
    let middle = 0.5 * (from + to);
    let (a, m, b) = (hit(from), hit(middle), hit(to));
    if let (Some(a), Some(m), Some(b)) = (a, m, b) {
        let off = (m - a).reject_from(b - a).length();
        if off <= tolerance || halvings == 0 {
            out.push([a, b]);
            return;
        }
    }
    // Parts of the rim that never meet the plane end where the halvings do.
    if halvings > 0 && (a.is_some() || m.is_some() || b.is_some()) {
        subdivide(hit, (from, middle), tolerance, halvings - 1, out);
        subdivide(hit, (middle, to), tolerance, halvings - 1, out);
    }
}
