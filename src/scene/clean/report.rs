//! What the clean-up did, in numbers and as warnings.

use crate::scene::Scene;
use crate::warning::Warning;

/// Polygons that a warning names before it says "and others".
const NAMED_POLYGONS: usize = 5;

/// What was repaired.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct CleanReport {
    /// Polygons of the input.
    pub polygons: usize,
    /// Polygons left out because light passes through their material.
    pub see_through: usize,
    /// Below this distance two points became one, metres.
    pub weld_distance_m: f64,
    /// Below this distance a vertex lay on an edge, metres.
    pub edge_distance_m: f64,
    /// Farthest that a corner may lie off its face's plane, metres.
    pub planarity_m: f64,
    /// Positions that became the same vertex as an earlier one.
    pub welded: usize,
    /// Polygons dropped because they are no wider than the edge distance.
    pub degenerate: usize,
    /// Polygons dropped because another one has the same corners.
    pub duplicates: usize,
    /// Polygons cut into triangles because they bend out of their plane.
    pub bent: usize,
    /// Polygons dropped because they cross themselves.
    pub self_crossing: usize,
    /// Vertices inserted into edges that they lay on, each counted once an edge.
    pub t_junctions: usize,
    /// Polygons before coplanar ones were merged.
    pub pieces: usize,
    /// Sets of coplanar polygons left unmerged because they have no common outline.
    pub unmerged: usize,
    /// Merged faces dropped because another one has the same outline.
    pub duplicate_faces: usize,
    /// Vertices removed from the middle of straight edges.
    pub straightened: usize,
    /// Faces of the scene.
    pub faces: usize,
    /// Vertices of the scene.
    pub vertices: usize,
    /// Edges of the scene.
    pub edges: usize,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Emitting sides of faces.
    pub emitters: usize,
    /// Lights without a surface.
    pub lights: usize,
}

impl CleanReport {
    /// Fills in what the finished scene consists of.
    pub(super) fn count(&mut self, scene: &Scene) {
        let edges_with = |is_meant: fn(usize) -> bool| {
            scene
                .edges
                .iter()
                .filter(|(_, e)| is_meant(e.uses.len()))
                .count()
        };
        self.faces = scene.faces.len();
        self.vertices = scene.vertices.len();
        self.edges = scene.edges.len();
        self.boundary_edges = edges_with(|uses| uses == 1);
        self.non_manifold_edges = edges_with(|uses| uses > 2);
        self.emitters = scene.emitters.len();
        self.lights = scene.lights.len();
    }

    /// One line a kind of repair; `crossing` holds the file indices of the polygons that cross themselves.
    pub(super) fn warnings(&self, source: &str, crossing: &[u32]) -> Vec<Warning> {
        let width = self.edge_distance_m;
        let planarity = self.planarity_m;
        let counted = [
            (
                self.degenerate,
                format!("narrower than {width:.1e} m, dropped"),
            ),
            (
                self.duplicates,
                "with the corners of another one, dropped".to_owned(),
            ),
            (
                self.bent,
                format!("bent out of plane by more than {planarity:.1e} m, cut into triangles"),
            ),
        ];
        let mut lines: Vec<String> = counted
            .into_iter()
            .filter(|&(count, _)| count > 0)
            .map(|(count, what)| format!("{count} of {} polygons {what}", self.polygons))
            .collect();
        if self.duplicate_faces > 0 {
            lines.push(format!(
                "{} faces with the outline of another one, dropped",
                self.duplicate_faces
            ));
        }
        if self.t_junctions > 0 {
            lines.push(format!(
                "{} vertices in the middle of an edge, inserted there",
                self.t_junctions
            ));
        }
        if self.unmerged > 0 {
            lines.push(format!(
                "{} sets of coplanar polygons overlap and were left unmerged",
                self.unmerged
            ));
        }
        if !crossing.is_empty() {
            let mut named: Vec<String> = crossing
                .iter()
                .take(NAMED_POLYGONS)
                .map(|i| (i + 1).to_string())
                .collect();
            if crossing.len() > NAMED_POLYGONS {
                named.push("others".to_owned());
            }
            lines.push(format!(
                "{} of {} polygons cross themselves, dropped: number {}",
                crossing.len(),
                self.polygons,
                named.join(", ")
            ));
        }
        lines
            .into_iter()
            .map(|line| Warning::new(source, line))
            .collect()
    }
}
