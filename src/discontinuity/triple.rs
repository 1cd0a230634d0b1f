//! Which three edges may share sight lines: told by the rays of wedges that touch a further edge.
//!
//! An arc of a second-order surface (EEE) ends where a ruling runs through a vertex, and there the wedge of that vertex
//! and of one of the edges touches the other; or where the ruling meets a fourth edge. So the ends of the wedges lead to
//! all arcs, and the ends of arcs to further ones; edges that no sight line joins are never compared.

use super::Cause;
use super::event::{Search, Touched};
use super::trace::Touch;
use super::wedge::Mark;
use crate::scene::{EdgeId, EmitterId, VertexId};

/// Three edges, sorted, at most one of them of the emitter's outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Triple {
    pub(super) edges: [EdgeId; 3],
    pub(super) emitter: EmitterId,
}

impl Triple {
    /// None where two edges share a vertex, so that no quadric is spanned, or two belong to the emitter.
    pub(super) fn new(search: &Search, emitter: EmitterId, mut edges: [EdgeId; 3]) -> Option<Self> {
        edges.sort_unstable();
        let meets = |i: usize, j: usize| {
            let [a, b] = [i, j].map(|k| search.scene.edges[edges[k]].ends);
            a.iter().any(|v| b.contains(v))
        };
        let is_own = |e: &EdgeId| search.is_rim(emitter, *e);
        let own = edges.iter().filter(|e| is_own(e)).count();
        let are_long = edges
            .iter()
            .all(|e| is_own(e) || search.is_worth(emitter, *e, search.worth.wedge));
        (own <= 1 && are_long && !meets(0, 1) && !meets(1, 2) && !meets(0, 2))
            .then_some(Self { edges, emitter })
    }
}

/// Appends the triples that start where a wedge's ray touches a feature.
pub(super) fn start(search: &Search, touched: &Touched, out: &mut Vec<Triple>) {
    let Touched {
        emitter,
        cause,
        touch: Touch { mark, along },
    } = *touched;
    // The edges that a ruling near the ray grazes instead of a vertex, and beside it.
    let (at_vertex, beside): (Vec<EdgeId>, EdgeId) = match cause {
        Cause::VertexEdge(v, e) => (edges_at(search, emitter, v), e),
        Cause::EdgeVertex(ends, v) => match search.rim_edge(emitter, ends) {
            Some(e) => (edges_at(search, emitter, v), e),
            None => return,
        },
        _ => return,
    };
    let third: &[EdgeId] = match &mark {
        Mark::Edge(e) => std::slice::from_ref(e),
        Mark::Vertex(v) => &search.incident[*v],
        Mark::Inside => &[],
    };
    // The rim of the emitter is passed from outside, whatever stands beside it.
    let grazes = |e: &&EdgeId| search.is_rim(emitter, **e) || search.may_graze(**e, along);
    for &first in at_vertex.iter().filter(grazes) {
        for &last in third.iter().filter(grazes) {
            out.extend(Triple::new(search, emitter, [first, beside, last]));
        }
    }
}

/// Edges at a vertex: of the emitter's corner those of its outline.
fn edges_at(search: &Search, emitter: EmitterId, vertex: VertexId) -> Vec<EdgeId> {
    let edges = &search.incident[vertex];
    let rim: Vec<EdgeId> = edges
        .iter()
        .copied()
        .filter(|&e| search.is_rim(emitter, e))
        .collect();
    if rim.is_empty() { edges.clone() } else { rim }
}
