//! Backprojection as a structure: which features bound the part of an emitter that a point sees.
//!
//! Edges of the emitter that are in sight, edges of blockers with the emitter close behind them, and the vertices among
//! their ends. The structure changes only across a line, so it is one for all points between lines; neighbours that see
//! different structures with no line between them prove that a line was missed.

use super::event::is_silhouette;
use super::span::LitSpans;
use super::trace;
use super::wedge::{Apex, Section, Wedge};
use crate::direct::DirectLight;
use crate::scene::{EdgeId, EmitterId, FaceId, Scene, VertexId};
use crate::visibility::{Region, Viewpoint};
use glam::DVec3;

/// Stretches shorter than this share of their edge are what rounding leaves of hidden ones: some thousand roundings.
const SLIVER: f64 = 4096.0 * f64::EPSILON;

/// The features on the visible outline of an emitter, sorted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outline {
    /// Edges of the emitter and of blockers, with the number of stretches that are in sight.
    pub edges: Vec<(EdgeId, u32)>,
    /// Ends of these edges that are in sight.
    pub vertices: Vec<VertexId>,
}

impl Outline {
    /// What bounds the visible part of `emitter` from `view`, a point on `face` (on whose plane nothing hides anything).
    pub fn from_point(
        scene: &Scene,
        light: &DirectLight,
        emitter: EmitterId,
        (face, view): (FaceId, &Viewpoint),
    ) -> Self {
        let mut outline = Self::default();
        let source = scene.emitters[emitter];
        let front = scene.normal(source.face, source.side);
        let height = front.dot(view.position - scene.faces[source.face].frame.origin);
        if source.face == face || height <= scene.weld_distance {
            return outline;
        }
        let mut rim: Vec<EdgeId> = scene.faces[source.face]
            .loop_edges
            .iter()
            .flatten()
            .copied()
            .collect();
        rim.sort_unstable();
        let mut edges = edges_before(light, emitter, view);
        edges.extend(&rim);
        edges.sort_unstable();
        edges.dedup();
        let eye = Eye {
            scene,
            light,
            face,
            view,
            target: source.face,
        };
        for e in edges {
            eye.look_along(e, rim.binary_search(&e).is_ok(), &mut outline);
        }
        outline.vertices.sort_unstable();
        outline.vertices.dedup();
        outline
    }
}

/// Edges of the blockers between a viewpoint and an emitter.
fn edges_before(light: &DirectLight, emitter: EmitterId, view: &Viewpoint) -> Vec<EdgeId> {
    let mut parts = Vec::new();
    for polygon in light.polygons_of(emitter) {
        let region = Region::pyramid(view.position, &polygon.corners);
        light
            .blockers
            .collect(view, region, polygon.plane, &mut parts);
    }
    parts
        .iter()
        .flat_map(|&i| light.blockers.edges(light.blockers.part(i)))
        .flatten()
        .copied()
        .collect()
}

/// A point that looks at one emitter.
struct Eye<'a> {
    scene: &'a Scene,
    light: &'a DirectLight<'a>,
    /// The face that the point lies on.
    face: FaceId,
    view: &'a Viewpoint,
    /// The face of the emitter.
    target: FaceId,
}

impl Eye<'_> {
    /// Adds an edge as far as it bounds what is seen of the emitter.
    fn look_along(&self, edge: EdgeId, is_rim: bool, outline: &mut Outline) {
        let (scene, blockers) = (self.scene, self.light.blockers);
        let ends = scene.edges[edge].ends;
        let Some((rim, is_whole)) = self.above_horizon(ends.map(|v| scene.vertices[v])) else {
            return;
        };
        let apex = Apex::Point(self.view.position);
        let Some(wedge) = Wedge::new(apex, rim, Some(ends), scene.weld_distance) else {
            return;
        };
        if !is_rim && !is_silhouette(scene, &wedge.plane, edge) {
            return;
        }
        let mut lit = LitSpans::whole();
        let before = self.elsewhere(wedge.sections_before_rim(scene, blockers));
        trace::hide(&mut lit, &before, wedge.rim_slack);
        let spans = if is_rim || lit.is_empty() {
            lit.iter().collect()
        } else {
            let ahead = self.elsewhere(wedge.sections_ahead(scene, blockers));
            trace::shone_from(scene, &wedge, &lit, ahead, self.target)
        };
        let spans: Vec<(f64, f64)> = united(spans)
            .into_iter()
            .filter(|(a, b)| b - a > SLIVER)
            .collect();
        if spans.is_empty() {
            return;
        }
        outline.edges.push((edge, spans.len() as u32));
        let starts = spans[0].0 <= SLIVER && is_whole[0];
        let stops = spans[spans.len() - 1].1 >= 1.0 - SLIVER && is_whole[1];
        outline.vertices.extend(starts.then_some(ends[0]));
        outline.vertices.extend(stops.then_some(ends[1]));
    }

    /// The part of a segment above the horizon, and whether its ends are those of the segment.
    fn above_horizon(&self, [a, b]: [DVec3; 2]) -> Option<([DVec3; 2], [bool; 2])> {
        let horizon = self.view.horizon;
        let (da, db) = (horizon.distance(a), horizon.distance(b));
        let tol = self.scene.weld_distance;
        if da <= tol && db <= tol {
            return None;
        }
        let cut = a + (b - a) * (da / (da - db));
        let is_whole = [da >= 0.0, db >= 0.0];
        let ends = [
            if is_whole[0] { a } else { cut },
            if is_whole[1] { b } else { cut },
        ];
        Some((ends, is_whole))
    }

    /// Sections of faces other than the viewpoint's own and those in its plane.
    fn elsewhere(&self, mut sections: Vec<Section>) -> Vec<Section> {
        let (scene, horizon) = (self.scene, self.view.horizon);
        sections.retain(|s| {
            s.face.is_none_or(|f| {
                let mut points = scene.faces[f].loops.iter().flatten();
                f != self.face
                    && points
                        .any(|&v| horizon.distance(scene.vertices[v]).abs() > scene.weld_distance)
            })
        });
        sections
    }
}

/// Intervals with those that touch made one.
fn united(mut spans: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut out: Vec<(f64, f64)> = Vec::new();
    for (a, b) in spans {
        match out.last_mut() {
            Some(last) if a <= last.1 + SLIVER => last.1 = last.1.max(b),
            _ => out.push((a, b)),
        }
    }
    out
}
