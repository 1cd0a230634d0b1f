//! A vertex in the interior of an edge becomes a corner of every polygon along that edge.

use super::piece::{Piece, Positions, Shape};
use super::point_tree::PointTree;
use crate::scene::VertexId;
use rayon::prelude::*;

/// What [`insert_vertices`] did.
#[derive(Default)]
pub(super) struct TJunctions {
    /// Vertices inserted, each counted once an edge.
    pub(super) inserted: usize,
    /// Polygons that collapsed by it: they were narrower than the edge distance somewhere.
    pub(super) collapsed: usize,
}

/// Inserts each vertex within `edge_distance` (`e`) of the interior of an edge into that edge, and drops what collapses.
///
/// An insertion bends an edge by up to `e`, which can bring more vertices within reach, so it goes on in rounds. It ends,
/// because vertices lie more than `2e` apart: the foot of one at most `e` from an edge of length `L` is more than `√3 e`
/// from both ends, so either part `l` of the edge is shorter, `l² < (L − √3 e)² + e² < L² − 8 e²`.
pub(super) fn insert_vertices(
    pieces: &mut Vec<Piece>,
    positions: &Positions,
    edge_distance: f64,
) -> TJunctions {
    let mut report = TJunctions::default();
    let tree = PointTree::new(positions, used_vertices(pieces, positions.len()));
    let mut tested: Vec<Edge> = Vec::new();
    loop {
        // Only edges that the last round made need a test, against vertices that some polygon still has.
        let mut is_used = vec![false; positions.len()];
        mark_used(pieces, &mut is_used);
        let edges = edges_of(pieces);
        let fresh: Vec<Edge> = edges
            .iter()
            .copied()
            .filter(|e| tested.binary_search(e).is_err())
            .collect();
        let splits = find_splits(&fresh, &tree, positions, &is_used, edge_distance);
        if splits.is_empty() {
            return report;
        }
        report.inserted += splits.iter().map(|s| s.inner.len()).sum::<usize>();
        for piece in pieces.iter_mut() {
            split_edges(piece, &splits);
        }
        let before = pieces.len();
        pieces.retain(|p| p.shape(positions, edge_distance) == Shape::Sound);
        report.collapsed += before - pieces.len();
        // A split edge can come back as part of a longer one: it is not done with.
        tested = edges;
        tested.retain(|e| splits.binary_search_by_key(e, |s| s.edge).is_err());
    }
}

type Edge = (VertexId, VertexId);

/// The vertices inside one edge, from its lower end to its higher one.
struct Split {
    edge: Edge,
    inner: Vec<VertexId>,
}

fn edges_of(pieces: &[Piece]) -> Vec<Edge> {
    let mut edges: Vec<Edge> = pieces
        .iter()
        .flat_map(|p| p.edges())
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    edges.par_sort_unstable();
    edges.dedup();
    edges
}

fn mark_used(pieces: &[Piece], is_used: &mut [bool]) {
    for &v in pieces.iter().flat_map(|p| &p.corners) {
        is_used[v.0 as usize] = true;
    }
}

fn used_vertices(pieces: &[Piece], vertices: usize) -> Vec<VertexId> {
    let mut is_used = vec![false; vertices];
    mark_used(pieces, &mut is_used);
    (0..vertices)
        .filter(|&i| is_used[i])
        .map(VertexId::from)
        .collect()
}

/// The edges that vertices lie on, sorted by edge.
fn find_splits(
    edges: &[Edge],
    tree: &PointTree<'_>,
    positions: &Positions,
    is_used: &[bool],
    edge_distance: f64,
) -> Vec<Split> {
    edges
        .par_iter()
        .filter_map(|&(from, to)| {
            let (a, b) = (positions[from], positions[to]);
            let along = (b - a).normalize();
            let length = a.distance(b);
            let mut inner = Vec::new();
            tree.near_segment(a, b, edge_distance, &mut |v| {
                if v == from || v == to || !is_used[v.0 as usize] {
                    return;
                }
                let p = positions[v] - a;
                let t = p.dot(along);
                // Vertices keep their distance from the ends by welding, so a foot inside means inside.
                if t > 0.0 && t < length && (p - along * t).length() <= edge_distance {
                    inner.push((t, v));
                }
            });
            inner.sort_by(|(s, v), (t, w)| s.total_cmp(t).then(v.cmp(w)));
            (!inner.is_empty()).then(|| Split {
                edge: (from, to),
                inner: inner.into_iter().map(|(_, v)| v).collect(),
            })
        })
        .collect()
}

/// Puts the inner vertices of each split edge between its ends, in the direction in which the polygon runs.
fn split_edges(piece: &mut Piece, splits: &[Split]) {
    let find = |a: VertexId, b: VertexId| {
        splits
            .binary_search_by_key(&(a.min(b), a.max(b)), |s| s.edge)
            .ok()
            .map(|i| &splits[i].inner)
    };
    if piece.edges().all(|(a, b)| find(a, b).is_none()) {
        return;
    }
    let mut corners = Vec::with_capacity(piece.corners.len() + 1);
    for (a, b) in piece.edges() {
        corners.push(a);
        match find(a, b) {
            None => {}
            Some(inner) if a < b => corners.extend(inner),
            Some(inner) => corners.extend(inner.iter().rev()),
        }
    }
    piece.corners = corners;
    piece.remove_spikes();
}
