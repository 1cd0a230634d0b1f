//! Edges and the faces along them.

use super::{Edge, EdgeId, EdgeUse, Face, FaceId, IdVec, VertexId};

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
        });
        for u in along {
            faces[u.face].loop_edges[u.loop_index][u.at] = id;
        }
    }
    edges
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
