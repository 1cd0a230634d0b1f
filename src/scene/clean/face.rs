//! Faces from groups of coplanar polygons.

use super::convex::convex_parts;
use super::outline::{Loops, trace};
use super::piece::{Piece, Positions};
use super::triangulate::triangulate;
use crate::geom::{PlaneFrame, Polygon2, newell_normal};
use crate::scene::Face;
use glam::DVec3;
use rayon::prelude::*;

/// Faces, and what could not become one.
#[derive(Default)]
pub(super) struct Built {
    /// The faces, in the order of the groups; their edges are still to be filled in.
    pub(super) faces: Vec<Face>,
    /// Groups that made no valid outline together and stayed apart.
    pub(super) unmerged: usize,
    /// File indices of polygons that cross themselves.
    pub(super) dropped: Vec<u32>,
}

/// One face a group; a group that has no valid outline falls back to one face a piece.
pub(super) fn build_faces(pieces: &[Piece], groups: &[Vec<usize>], positions: &Positions) -> Built {
    let each: Vec<Built> = groups
        .par_iter()
        .map(|group| {
            let members: Vec<&Piece> = group.iter().map(|&i| &pieces[i]).collect();
            build_group(&members, positions)
        })
        .collect();
    each.into_iter().fold(Built::default(), |mut all, one| {
        all.faces.extend(one.faces);
        all.dropped.extend(one.dropped);
        all.unmerged += one.unmerged;
        all
    })
}

fn build_group(members: &[&Piece], positions: &Positions) -> Built {
    if let Some(faces) = try_build(members, positions) {
        return Built {
            faces,
            ..Built::default()
        };
    }
    let mut built = Built {
        unmerged: usize::from(members.len() > 1),
        ..Built::default()
    };
    for &piece in members {
        match try_build(&[piece], positions) {
            Some(faces) => built.faces.extend(faces),
            None => built.dropped.push(piece.source),
        }
    }
    built
}

fn try_build(members: &[&Piece], positions: &Positions) -> Option<Vec<Face>> {
    let frame = frame_of(
        members.iter().map(|p| p.newell(positions)).sum(),
        members.iter().flat_map(|p| p.points(positions)),
    )?;
    trace(members, &frame, positions)?
        .into_iter()
        .map(|loops| face(loops, members[0], positions))
        .collect()
}

fn face(mut loops: Loops, like: &Piece, positions: &Positions) -> Option<Face> {
    // Each loop starts at its lowest vertex, so that it does not depend on where the trace began.
    for l in &mut loops {
        let lowest = (0..l.len()).min_by_key(|&i| l[i]).unwrap_or(0);
        l.rotate_left(lowest);
    }
    loops[1..].sort_unstable();
    let corners = |l: &[_]| l.iter().map(|&v| positions[v]).collect::<Vec<DVec3>>();
    let frame = frame_of(
        loops.iter().map(|l| newell_normal(corners(l))).sum(),
        loops.iter().flat_map(|l| corners(l)),
    )?;
    let triangulation = triangulate(&loops, &frame, positions)?;
    let outline = Polygon2 {
        loops: loops
            .iter()
            .map(|l| l.iter().map(|&v| frame.to_plane(positions[v])).collect())
            .collect(),
    };
    Some(Face {
        frame,
        loop_edges: Vec::new(),
        area: outline.area(),
        outline,
        convex_parts: convex_parts(&triangulation),
        triangles: triangulation
            .triangles
            .iter()
            .map(|t| t.map(|i| triangulation.vertices[i]))
            .collect(),
        loops,
        material: like.material,
        group: like.group,
    })
}

/// The frame along `area` through the point that lies nearest to the middle of all points' distances along it.
///
/// A point of the face rather than a mean: the points of an exact plane then have the distance zero exactly.
pub(super) fn frame_of(
    area: DVec3,
    points: impl Iterator<Item = DVec3> + Clone,
) -> Option<PlaneFrame> {
    let normal = area.try_normalize()?;
    let height = |p: DVec3| normal.dot(p);
    let (lo, hi) = points
        .clone()
        .map(height)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), h| {
            (lo.min(h), hi.max(h))
        });
    let off_middle = |p: DVec3| (height(p) - lo.midpoint(hi)).abs();
    let origin = points.min_by(|&p, &q| off_middle(p).total_cmp(&off_middle(q)))?;
    Some(PlaneFrame::new(origin, normal))
}
