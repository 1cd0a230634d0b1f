//! How wide the penumbra is that a line belongs to.

use super::{Cause, Discontinuity};
use crate::scene::{EmitterId, Scene};
use glam::DVec3;

/// Width of the penumbra at both ends of `line`, across it on its receiver, metres: how far it would move while its
/// generator moved over the whole emitter. None where no one blocker edge or vertex makes it.
///
/// ```text
///   ●───────● emitter, extent c across the critical plane
///     ╲   ╱   s
///       ╳ blocker, distance s from the emitter and r from the receiver
///     ╱   ╲   r
///   ───────── receiver: c · r / s, and longer where it is slanted to the plane
/// ```
pub fn penumbra_width(scene: &Scene, line: &Discontinuity) -> Option<[f64; 2]> {
    let at = |v| scene.vertices[v];
    let widths = |towards: [DVec3; 2], from: [DVec3; 2]| {
        let emitter = line.emitter?;
        let plane = (line.ends[1] - line.ends[0])
            .cross(towards[0] - line.ends[0])
            .try_normalize()?;
        let extent = extent(scene, emitter, plane);
        let normal = scene.normal(line.face, line.side);
        // The line moves within the receiver, at this angle to the plane's normal.
        let slant = (1.0 - normal.dot(plane).powi(2)).max(0.0).sqrt();
        Some([0, 1].map(|i| {
            let (r, s) = (line.ends[i].distance(from[i]), from[i].distance(towards[i]));
            let width = extent * r / (s * slant);
            if width.is_finite() { width } else { f64::MAX }
        }))
    };
    match line.cause {
        Cause::VertexEdge(vertex, edge) => {
            let ends = scene.edges[edge].ends.map(at);
            let from = line.ends.map(|p| nearest_on(ends, [at(vertex), p]));
            widths([at(vertex); 2], from)
        }
        Cause::EdgeVertex(rim, vertex) => {
            let towards = line.ends.map(|p| nearest_on(rim.map(at), [p, at(vertex)]));
            widths(towards, [at(vertex); 2])
        }
        _ => None,
    }
}

/// Extent of an emitter along a unit vector, metres.
fn extent(scene: &Scene, emitter: EmitterId, along: DVec3) -> f64 {
    let face = &scene.faces[scene.emitters[emitter].face];
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for &v in face.loops.iter().flatten() {
        let t = along.dot(scene.vertices[v]);
        (lo, hi) = (lo.min(t), hi.max(t));
    }
    hi - lo
}

/// The point of the line through `on` next to the line through `ray`. Beyond its ends, too: a line merged of several has
/// the generators of one, and the others lie in the same plane.
fn nearest_on(on: [DVec3; 2], ray: [DVec3; 2]) -> DVec3 {
    let (d, u) = (on[1] - on[0], (ray[1] - ray[0]).normalize_or_zero());
    // Across the ray only.
    let flat = |v: DVec3| v - u * u.dot(v);
    let (d_flat, to_ray) = (flat(d), flat(ray[0] - on[0]));
    let t = to_ray.dot(d_flat) / d_flat.length_squared();
    if t.is_finite() { on[0] + d * t } else { on[0] }
}
