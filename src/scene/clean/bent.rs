//! Polygons that bend out of their plane become triangles.

use super::best_plane::best_plane;
use super::outline::trace;
use super::piece::{Piece, Positions};
use super::triangulate::triangulate;
use crate::geom::Plane;

/// What [`split_bent`] did.
#[derive(Default)]
pub(super) struct Bent {
    /// Polygons cut into triangles.
    pub(super) split: usize,
    /// File indices of polygons that cross themselves, dropped.
    pub(super) dropped: Vec<u32>,
}

/// Replaces each polygon with a corner farther than `planarity` from its plane by triangles.
///
/// The plane is Newell's through the mean of the corners; the triangles are Delaunay in its projection, so they do not
/// depend on the corner that the file names first.
pub(super) fn split_bent(pieces: &mut Vec<Piece>, positions: &Positions, planarity: f64) -> Bent {
    let mut report = Bent::default();
    let mut kept = Vec::with_capacity(pieces.len());
    for piece in pieces.drain(..) {
        if piece.corners.len() == 3 || bend(&piece, positions) <= planarity {
            kept.push(piece);
            continue;
        }
        match triangles(&piece, positions) {
            Some(triangles) => {
                report.split += 1;
                kept.extend(triangles);
            }
            None => report.dropped.push(piece.source),
        }
    }
    *pieces = kept;
    report
}

/// Distance of the corner farthest from the polygon's plane.
fn bend(piece: &Piece, positions: &Positions) -> f64 {
    let plane = Plane::new(
        piece.mean(positions),
        piece.newell(positions).normalize_or_zero(),
    );
    piece
        .points(positions)
        .map(|p| plane.distance(p).abs())
        .fold(0.0, f64::max)
}

fn triangles(piece: &Piece, positions: &Positions) -> Option<Vec<Piece>> {
    let frame = best_plane(piece.newell(positions), piece.points(positions))?;
    let mut triangles = Vec::new();
    for loops in trace(&[piece], &frame, positions)? {
        let triangulation = triangulate(&loops, &frame, positions)?;
        triangles.extend(triangulation.triangles.iter().map(|t| Piece {
            corners: t.iter().map(|&i| triangulation.vertices[i]).collect(),
            ..*piece
        }));
    }
    Some(triangles)
}
