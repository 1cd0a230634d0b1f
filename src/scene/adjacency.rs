//! Edges and the faces along them.

use super::{Edge, EdgeId, EdgeUse, Face, FaceId, IdVec, VertexId};
use glam::DVec3;

/// Shading normals of two facets that differ by less than this are one, radians (1°): exporters store them in as few as
/// eight bits a component.
const SAME_NORMAL: f64 = std::f64::consts::PI / 180.0;

/// All edges of the faces' loops, sorted by their ends; fills in each face's `loop_edges`.
pub(super) fn connect(faces: &mut IdVec<FaceId, Face>) -> IdVec<EdgeId, Edge> {
    let mut uses: Vec<LoopEdge> = Vec::new();
    for (face, f) in faces.iter() {
        for (loop_index, l) in f.loops.iter().enumerate() {
            uses.extend((0..l.len()).map(|at| {
                let (a, b) = (l[at], l[(at + 1) % l.len()]);
                LoopEdge {
                    ends: [a.min(b), a.max(b)],
                    face,
                    loop_index,
                    at,
                    is_forward: a < b,
                }
            }));
        }
    }
    uses.sort_unstable();
    for face in faces.ids() {
        let f = &mut faces[face];
        f.loop_edges = f.loops.iter().map(|l| vec![EdgeId(0); l.len()]).collect();
    }
    let mut edges = IdVec::default();
    for along in uses.chunk_by(|a, b| a.ends == b.ends) {
        let id: EdgeId = edges.push(Edge {
            ends: along[0].ends,
            uses: along
                .iter()
                .map(|u| EdgeUse {
                    face: u.face,
                    is_forward: u.is_forward,
                })
                .collect(),
            is_smooth: false,
        });
        for u in along {
            faces[u.face].loop_edges[u.loop_index][u.at] = id;
        }
    }
    edges
}

/// Marks the edges inside curved surfaces, and those between faces in one plane (corners off it by `planarity` at most,
/// metres): a wall of two materials.
pub(super) fn mark_smooth(
    edges: &mut IdVec<EdgeId, Edge>,
    faces: &IdVec<FaceId, Face>,
    vertices: &IdVec<VertexId, DVec3>,
    planarity: f64,
) {
    let lies_in = |f: &Face, g: &Face| {
        let plane = g.frame.plane();
        let mut corners = f.loops.iter().flatten().map(|&v| vertices[v]);
        corners.all(|p| plane.distance(p).abs() <= planarity)
    };
    for id in edges.ids() {
        let edge = &mut edges[id];
        let &[a, b] = edge.uses.as_slice() else {
            continue;
        };
        let (f, g) = (&faces[a.face], &faces[b.face]);
        let is_curved = f.shading.is_some() || g.shading.is_some();
        let is_same = |p: DVec3| f.shading_normal(p).distance(g.shading_normal(p)) <= SAME_NORMAL;
        edge.is_smooth = a.is_forward != b.is_forward
            && edge.ends.iter().all(|&v| is_same(vertices[v]))
            && (is_curved || (lies_in(f, g) && lies_in(g, f)));
    }
}

/// One step of one loop; the order of the fields is the order of edges and of their uses.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct LoopEdge {
    ends: [VertexId; 2],
    face: FaceId,
    loop_index: usize,
    at: usize,
    is_forward: bool,
}
