//! The lines of a page, with the corners and edges that make them.

use super::surfaces::PartOnPage;
use crate::discontinuity::{Cause, EventKind};
use crate::pipeline::{LineRecord, Solution, kind_name, line_records, order_number};
use crate::scene::{EdgeId, EmitterId, FaceId, FaceSide, PunctualKind, Scene, VertexId};
use glam::DVec3;
use std::collections::BTreeMap;

/// One line; its ends stand in a list of their own.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct LineOnPage {
    /// Index of the part that it lies on.
    part: usize,
    order: u8,
    kind: &'static str,
    /// W/m².
    jump: f64,
    is_kept: bool,
    /// What made it, in words.
    cause: String,
    /// The edges and sight lines that make it, metres, local.
    generators: Vec<[[f64; 3]; 2]>,
}

/// The lines on the parts, and both ends of each, metres, local.
pub(super) fn lines_of(solution: &Solution, parts: &[PartOnPage]) -> (Vec<LineOnPage>, Vec<f64>) {
    let scene = &solution.world.scene;
    let index: BTreeMap<(Option<u32>, &str), usize> = parts
        .iter()
        .enumerate()
        .map(|(i, p)| ((p.face, p.side), i))
        .collect();
    let (mut lines, mut ends) = (Vec::new(), Vec::new());
    for record in line_records(solution) {
        let side = match record.side {
            FaceSide::Front => "front",
            FaceSide::Back => "back",
        };
        // A face that is wholly covered by another one has no mesh to draw on.
        let Some(&part) = index.get(&(Some(record.face.0), side)) else {
            continue;
        };
        let local = record.ends.map(|p| p - scene.origin);
        ends.extend(local.iter().flat_map(|p| p.to_array()));
        lines.push(LineOnPage {
            part,
            order: order_number(record.order),
            kind: kind_name(record.kind),
            jump: record.jump,
            is_kept: record.is_kept,
            cause: words(scene, &record),
            generators: generators(scene, &record, local),
        });
    }
    (lines, ends)
}

fn words(scene: &Scene, record: &LineRecord) -> String {
    let lamp = record.emitter.map_or_else(
        || "an emitter".to_owned(),
        |e| format!("emitter {e} ({})", name(scene, scene.emitters[e].face)),
    );
    match record.cause {
        Cause::VertexEdge(v, e) => {
            let whose = match record.kind {
                EventKind::Nve => format!(", seen before {lamp},"),
                _ => format!(" of {lamp}"),
            };
            format!(
                "corner v{v}{whose} disappears behind edge e{e}{}",
                owner(scene, e)
            )
        }
        Cause::Edges(edges) => {
            let [a, b, c] = edges.map(|e| format!("e{e}{}", owner(scene, e)));
            format!("edges {a}, {b} and {c} share sight lines to {lamp}")
        }
        Cause::EdgeVertex([a, b], v) => {
            format!("edge v{a}–v{b} of {lamp} disappears behind corner v{v}")
        }
        Cause::Face(f) => format!(
            "face {f} ({}) touches, pierces or is seen edge-on",
            name(scene, f)
        ),
        Cause::EmitterPlane => format!("the plane of {lamp}"),
        Cause::LightEdge(light, e) => format!(
            "light {light} ({}) disappears behind edge e{e}{}",
            scene.lights[light as usize].name,
            owner(scene, e)
        ),
        Cause::Cone(light) => format!("the cone of light {}", scene.lights[light as usize].name),
    }
}

fn name(scene: &Scene, face: FaceId) -> &str {
    &scene.groups[scene.faces[face].group as usize]
}

/// Whose edge it is.
fn owner(scene: &Scene, edge: EdgeId) -> String {
    let face = scene.edges[edge].uses.first().map(|u| u.face);
    face.map_or_else(String::new, |f| format!(" ({})", name(scene, f)))
}

/// For a wedge its edge and the sight lines along its two sides; for a plane the outline that spans it.
fn generators(scene: &Scene, record: &LineRecord, ends: [DVec3; 2]) -> Vec<[[f64; 3]; 2]> {
    let at = |v: VertexId| scene.vertices[v];
    let segments = match record.cause {
        Cause::VertexEdge(v, e) => {
            let [a, b] = scene.edges[e].ends;
            vec![[at(a), at(b)], [at(v), ends[0]], [at(v), ends[1]]]
        }
        Cause::EdgeVertex([a, b], v) => {
            // From the line past the corner to the emitter: the far ends of these sight lines lie on its edge.
            let mut all = vec![[at(a), at(b)]];
            all.extend(ends.map(|p| [p, beyond(p, at(v), [at(a), at(b)])]));
            all
        }
        Cause::Edges(edges) => edges.map(|e| scene.edges[e].ends.map(at)).to_vec(),
        Cause::Face(f) => outline(scene, f),
        Cause::LightEdge(light, e) => {
            let light = &scene.lights[light as usize];
            let far = scene.diagonal;
            let source = |p: DVec3| match light.kind {
                PunctualKind::Directional => p - light.direction * far,
                _ => light.position,
            };
            let mut all = vec![scene.edges[e].ends.map(at)];
            all.extend(ends.map(|p| [source(p), p]));
            all
        }
        Cause::Cone(light) => ends
            .map(|p| [scene.lights[light as usize].position, p])
            .to_vec(),
        Cause::EmitterPlane => record.emitter.map_or_else(Vec::new, |e: EmitterId| {
            outline(scene, scene.emitters[e].face)
        }),
    };
    segments
        .into_iter()
        .map(|s| s.map(|p| p.to_array()))
        .collect()
}

fn outline(scene: &Scene, face: FaceId) -> Vec<[DVec3; 2]> {
    let edges = scene.faces[face].loop_edges.iter().flatten();
    edges
        .map(|&e| scene.edges[e].ends.map(|v| scene.vertices[v]))
        .collect()
}

/// Where the sight line from `p` through `v` passes the segment `ab` the nearest: the point on the segment.
fn beyond(p: DVec3, v: DVec3, [a, b]: [DVec3; 2]) -> DVec3 {
    let (d, e) = (v - p, b - a);
    let n = d.cross(e);
    // Nearly parallel lines meet anywhere; the nearer end of the segment shows it best.
    let t = (a - p).cross(d).dot(n) / n.length_squared();
    a + e * if t.is_finite() {
        t.clamp(0.0, 1.0)
    } else {
        0.0
    }
}
