//! Polygons that bend, or whose texture or shading does, become triangles.

use super::best_plane::best_plane;
use super::outline::trace;
use super::piece::{Piece, Positions};
use super::surface::Corners;
use super::triangulate::triangulate;
use crate::geom::Plane;

/// What [`split_bent`] did.
#[derive(Default)]
pub(super) struct Bent {
    /// Polygons cut into triangles because they bend out of their plane.
    pub(super) split: usize,
    /// File indices of polygons that cross themselves, dropped.
    pub(super) dropped: Vec<u32>,
}

/// Replaces each polygon with a corner farther than `planarity` from its plane, or with a texture or shading that is not
/// linear over it, by triangles.
///
/// The plane is Newell's through the mean of the corners; the triangles are Delaunay in its projection, so they do not
/// depend on the corner that the file names first.
pub(super) fn split_bent(
    pieces: &mut Vec<Piece>,
    positions: &Positions,
    planarity: f64,
    corners: &Corners<'_>,
) -> Bent {
    let mut report = Bent::default();
    let mut kept = Vec::with_capacity(pieces.len());
    for piece in pieces.drain(..) {
        let is_flat = piece.corners.len() == 3 || bend(&piece, positions) <= planarity;
        if is_flat && corners.are_linear(&piece, positions) {
            kept.push(piece);
            continue;
        }
        match triangles(&piece, positions) {
            Some(triangles) => {
                report.split += usize::from(!is_flat);
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
