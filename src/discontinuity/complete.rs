//! Whether lines were missed: neighbouring points that see different outlines of an emitter have a line between them.

use super::reach::Reach;
use super::{Discontinuity, FaceLines, LineMap, LineTolerance, Outline};
use crate::direct::DirectLight;
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::{Scratch, Viewpoint};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Distance of the two points of a pair, over the size of their face: about an element.
const STEP: f64 = 1.0 / 64.0;

/// Additive recurrences on these irrational steps fill the unit cube evenly: the powers of the root of x⁵ = x + 1, the
/// generalised golden ratio of dimension 4 (Roberts 2018).
const STEPS: [f64; 4] = [
    0.856_674_883_854_502_9,
    0.733_891_856_627_126,
    0.628_706_721_037_808_6,
    0.538_597_257_223_61,
];

/// What comparing neighbours told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct OutlineCheck {
    /// Pairs of points within the reach of an emitter, each held against one that reaches it.
    pub pairs: usize,
    /// Pairs that see different outlines.
    pub changed: usize,
    /// Of these, pairs with no line between them across which the light bends more than the lines that were left out.
    pub missed: usize,
}

/// Compares the outlines from `count` pairs of neighbouring points, spread evenly over the area of all sides and over the
/// emitters that reach them: with each emitter from each pair, a street of lamps would take longer than all its lines.
///
/// `tolerance` is that of [`super::find_lines`].
pub fn check_outlines(
    scene: &Scene,
    light: &DirectLight,
    lines: &LineMap,
    tolerance: LineTolerance,
    count: usize,
) -> OutlineCheck {
    let mut triangles: Vec<(f64, FaceId, FaceSide, usize)> = Vec::new();
    let mut sum = 0.0;
    for (face, f) in scene.faces.iter() {
        for side in [FaceSide::Front, FaceSide::Back] {
            if !scene.receives(face, side) || lines.of(face, side).candidates.is_empty() {
                continue;
            }
            for (i, t) in f.triangles.iter().enumerate() {
                let [a, b, c] = t.map(|v| scene.vertices[v]);
                sum += (b - a).cross(c - a).length();
                triangles.push((sum, face, side, i));
            }
        }
    }
    let check = Check {
        scene,
        light,
        reach: Reach::new(scene, tolerance.least),
        tolerance,
    };
    let checks: Vec<OutlineCheck> = (0..if triangles.is_empty() { 0 } else { count })
        .into_par_iter()
        .map(|i| {
            let [s, t, turn, choice] = STEPS.map(|step| (0.5 + step * i as f64).fract());
            let at = sum * (i as f64 + 0.5) / count as f64;
            let k = triangles
                .partition_point(|c| c.0 <= at)
                .min(triangles.len() - 1);
            let (_, face, side, triangle) = triangles[k];
            let [a, b, c] = scene.faces[face].triangles[triangle].map(|v| scene.vertices[v]);
            let root = s.sqrt();
            let p = a * (1.0 - root) + b * (root * (1.0 - t)) + c * (root * t);
            check.compare(lines.of(face, side), (face, side), p, [turn, choice])
        })
        .collect();
    checks
        .iter()
        .fold(OutlineCheck::default(), |sum, c| OutlineCheck {
            pairs: sum.pairs + c.pairs,
            changed: sum.changed + c.changed,
            missed: sum.missed + c.missed,
        })
}

/// What all pairs are compared in.
struct Check<'c> {
    scene: &'c Scene,
    light: &'c DirectLight<'c>,
    /// Emitters draw no lines that matter beyond.
    reach: Reach,
    tolerance: LineTolerance,
}

impl Check<'_> {
    /// Compares a point of a face with one a step away; `turn` (0…1) tells in which direction, and `choice` (0…1) from which
    /// of the emitters.
    fn compare(
        &self,
        lines: &FaceLines,
        (face, side): (FaceId, FaceSide),
        p: DVec3,
        [turn, choice]: [f64; 2],
    ) -> OutlineCheck {
        let (scene, light, tolerance) = (self.scene, self.light, self.tolerance);
        let f = &scene.faces[face];
        let size = f.area.sqrt();
        let p = f.frame.to_plane(p);
        let q = p + DVec2::from_angle(TAU * turn) * (STEP * size);
        let mut check = OutlineCheck::default();
        // Both on the face, on one side of every hole.
        let is_apart = f.outline.loops.iter().any(|l| {
            let edge = |i: usize| [l[i], l[(i + 1) % l.len()]];
            (0..l.len()).any(|i| distance([p, q], edge(i)) <= scene.weld_distance)
        });
        if is_apart || !f.outline.contains(q) {
            return check;
        }
        let normal = scene.normal(face, side);
        let view = |p: DVec2| Viewpoint::new(f.frame.to_space(p), normal);
        let (from, to) = (view(p), view(q));
        let ends = [from.position, to.position];
        let reaching = scene.emitters.ids();
        let reaching: Vec<_> = reaching.filter(|&e| self.reach.holds(e, &ends)).collect();
        let Some(&emitter) = reaching.get((choice * reaching.len() as f64) as usize) else {
            return check;
        };
        let outline = |v| Outline::from_point(scene, light, emitter, (face, v));
        check.pairs = 1;
        if outline(&from) == outline(&to) {
            return check;
        }
        check.changed = 1;
        let is_line = |l: &Discontinuity| {
            let ends = l.ends.map(|e| f.frame.to_plane(e));
            distance([p, q], ends) <= 2.0 * tolerance.chord * size
        };
        if lines.contacts.iter().chain(&lines.candidates).any(is_line) {
            return check;
        }
        // A change that bends the light less than the lines that were left out is one of them.
        let mut scratch = Scratch::default();
        let mut at = |v: &Viewpoint| light.irradiance(v, &mut scratch).mean();
        let bend = at(&from) - 2.0 * at(&view(p.midpoint(q))) + at(&to);
        let whole = light
            .unoccluded_from(emitter, &from, &mut Scratch::default())
            .mean();
        let is_missed = tolerance.floor <= 0.0 || bend.abs() > tolerance.floor * whole;
        check.missed = usize::from(is_missed);
        check
    }
}

/// Distance between two segments of the plane.
fn distance(s: [DVec2; 2], t: [DVec2; 2]) -> f64 {
    let side = |[a, b]: [DVec2; 2], p: DVec2| (b - a).perp_dot(p - a);
    let parts = |s: [DVec2; 2], t: [DVec2; 2]| side(s, t[0]) * side(s, t[1]) <= 0.0;
    if parts(s, t) && parts(t, s) {
        return 0.0;
    }
    let from = |p: DVec2, [a, b]: [DVec2; 2]| {
        let d = b - a;
        let along = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
        p.distance(a + d * along)
    };
    from(s[0], t)
        .min(from(s[1], t))
        .min(from(t[0], s))
        .min(from(t[1], s))
}
