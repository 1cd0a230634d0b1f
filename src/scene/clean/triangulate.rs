//! Triangles of a face without new vertices (constrained Delaunay, by the crate `spade`).

use super::outline::Loops;
use crate::geom::predicates::{Side, side_of_line};
use crate::geom::{PlaneFrame, loop_area};
use crate::scene::{IdVec, VertexId};
use glam::{DVec2, DVec3};
use spade::handles::FixedFaceHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation as _};

/// A triangulated face: indices into its own list of corners.
pub(super) struct Triangulation {
    /// Its vertices, ascending.
    pub(super) vertices: Vec<VertexId>,
    /// Where they lie in the face's frame.
    pub(super) points: Vec<DVec2>,
    /// Triangles, counter-clockwise.
    pub(super) triangles: Vec<[usize; 3]>,
}

/// Triangulates the inside of `loops` as projected on `frame`; `None` when the loops cross or touch in that projection.
pub(super) fn triangulate(
    loops: &Loops,
    frame: &PlaneFrame,
    positions: &IdVec<VertexId, DVec3>,
) -> Option<Triangulation> {
    let mut vertices: Vec<VertexId> = loops.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let points: Vec<DVec2> = vertices
        .iter()
        .map(|&v| frame.to_plane(positions[v]))
        .collect();
    let local: Vec<Vec<usize>> = loops
        .iter()
        .map(|l| {
            l.iter()
                .map(|v| vertices.partition_point(|w| w < v))
                .collect()
        })
        .collect();
    let triangles = match local.as_slice() {
        [l] if l.len() == 3 => {
            let [a, b, c] = [l[0], l[1], l[2]];
            (side_of_line(points[a], points[b], points[c]) == Side::Left).then(|| vec![[a, b, c]])
        }
        _ => inside_triangles(&local, &points),
    }?;
    covers(&local, &points, &triangles).then_some(Triangulation {
        vertices,
        points,
        triangles,
    })
}

/// Whether the triangles have the area of the loops, to round-off.
///
/// Each area is a sum of `n` products of coordinates, so the round-off is at most `(n + 3) ε` times the sum of their
/// magnitudes (three more roundings in each product and difference).
fn covers(loops: &[Vec<usize>], points: &[DVec2], triangles: &[[usize; 3]]) -> bool {
    let sum = |area: f64, magnitude: f64, l: &[usize]| {
        let corners: Vec<DVec2> = l.iter().map(|&i| points[i]).collect();
        let size: f64 = corners
            .iter()
            .map(|p| (*p - corners[0]).length_squared())
            .sum();
        (area + loop_area(&corners), magnitude + size)
    };
    let (wanted, wanted_size) = loops.iter().fold((0.0, 0.0), |(a, m), l| sum(a, m, l));
    let (got, got_size) = triangles.iter().fold((0.0, 0.0), |(a, m), t| sum(a, m, t));
    let terms = points.len() + triangles.len() + 3;
    wanted > 0.0 && (wanted - got).abs() <= terms as f64 * f64::EPSILON * (wanted_size + got_size)
}

struct Corner(Point2<f64>);

impl HasPosition for Corner {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.0
    }
}

fn inside_triangles(loops: &[Vec<usize>], points: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let corners = points
        .iter()
        .map(|p| Corner(spade::mitigate_underflow(Point2::new(p.x, p.y))))
        .collect();
    let edges = loops
        .iter()
        .flat_map(|l| (0..l.len()).map(|i| [l[i], l[(i + 1) % l.len()]]))
        .collect();
    let mut has_conflict = false;
    let cdt = ConstrainedDelaunayTriangulation::<Corner>::try_bulk_load_cdt(corners, edges, |_| {
        has_conflict = true;
    })
    .ok()?;
    // Corners on one spot are merged, which would shift the indices.
    if has_conflict || cdt.num_vertices() != points.len() {
        return None;
    }
    // From the outside inwards: each outline edge changes sides.
    let mut is_inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
    let mut open = vec![cdt.outer_face().fix()];
    is_inside[open[0].index()] = Some(false);
    while let Some(face) = open.pop() {
        let here = is_inside[face.index()].expect("only classified faces are open");
        let around: Vec<(FixedFaceHandle<_>, bool)> = borders(&cdt, face);
        for (neighbour, is_outline) in around {
            let there = &mut is_inside[neighbour.index()];
            if there.is_none() {
                *there = Some(here != is_outline);
                open.push(neighbour);
            }
        }
    }
    Some(
        cdt.inner_faces()
            .filter(|f| is_inside[f.fix().index()] == Some(true))
            .map(|f| f.vertices().map(|v| v.fix().index()))
            .collect(),
    )
}

type AnyFace = FixedFaceHandle<spade::handles::PossiblyOuterTag>;

/// The faces across the edges of a face, and whether the edge is part of the outline.
fn borders(cdt: &ConstrainedDelaunayTriangulation<Corner>, face: AnyFace) -> Vec<(AnyFace, bool)> {
    let across = |e: spade::handles::DirectedEdgeHandle<'_, Corner, (), spade::CdtEdge<()>, ()>| {
        (e.rev().face().fix(), e.is_constraint_edge())
    };
    match cdt.face(face).as_inner() {
        Some(inner) => inner.adjacent_edges().map(across).to_vec(),
        None => cdt.convex_hull().map(across).collect(),
    }
}
