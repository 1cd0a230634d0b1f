//! Faces from groups of coplanar polygons.

use super::best_plane::best_plane;
use super::convex::convex_parts;
use super::outline::{Loops, trace};
use super::piece::{Piece, Positions};
use super::surface::SurfaceMaps;
use super::triangulate::triangulate;
use crate::geom::{AffineMap, Polygon2, newell_normal};
use crate::quantity::{Radiance, Rgb};
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
pub(super) fn build_faces(
    pieces: &[Piece],
    groups: &[Vec<usize>],
    maps: &[SurfaceMaps],
    positions: &Positions,
) -> Built {
    let each: Vec<Built> = groups
        .par_iter()
        .map(|group| {
            let members: Vec<&Piece> = group.iter().map(|&i| &pieces[i]).collect();
            build_group(&members, maps, positions)
        })
        .collect();
    each.into_iter().fold(Built::default(), |mut all, one| {
        all.faces.extend(one.faces);
        all.dropped.extend(one.dropped);
        all.unmerged += one.unmerged;
        all
    })
}

fn build_group(members: &[&Piece], maps: &[SurfaceMaps], positions: &Positions) -> Built {
    if let Some(faces) = try_build(members, maps, positions) {
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
        match try_build(&[piece], maps, positions) {
            Some(faces) => built.faces.extend(faces),
            None => built.dropped.push(piece.source),
        }
    }
    built
}

fn try_build(members: &[&Piece], maps: &[SurfaceMaps], positions: &Positions) -> Option<Vec<Face>> {
    // The maps of the largest piece: rounding blurs them least.
    let area = |p: &Piece| p.newell(positions).length_squared();
    let largest = members
        .iter()
        .reduce(|best, p| if area(p) > area(best) { p } else { best })?;
    let maps = largest.maps.map(|i| maps[i as usize]);
    let look = Look {
        material: largest.material,
        group: largest.group,
        uv: maps.and_then(|m| m.uv),
        shading: maps.and_then(|m| m.shading),
    };
    let frame = best_plane(
        members.iter().map(|p| p.newell(positions)).sum(),
        members.iter().flat_map(|p| p.points(positions)),
    )?;
    trace(members, &frame, positions)?
        .into_iter()
        .map(|loops| face(loops, look, positions))
        .collect()
}

/// What a face shows.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub(super) material: u32,
    pub(super) group: u32,
    pub(super) uv: Option<AffineMap<2>>,
    pub(super) shading: Option<AffineMap<3>>,
}

impl Look {
    /// That of a face.
    pub(super) fn of(face: &Face) -> Self {
        Self {
            material: face.material,
            group: face.group,
            uv: face.uv,
            shading: face.shading,
        }
    }
}

/// The face with these loops, its reflectance and its edges still to be filled in; `None` when they cross or enclose nothing.
pub(super) fn face(mut loops: Loops, look: Look, positions: &Positions) -> Option<Face> {
    // Each loop starts at its lowest vertex, so that it does not depend on where the trace began.
    for l in &mut loops {
        let lowest = (0..l.len()).min_by_key(|&i| l[i]).unwrap_or(0);
        l.rotate_left(lowest);
    }
    loops[1..].sort_unstable();
    let corners = |l: &[_]| l.iter().map(|&v| positions[v]).collect::<Vec<DVec3>>();
    let frame = best_plane(
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
        material: look.material,
        group: look.group,
        uv: look.uv,
        shading: look.shading,
        reflectance: Rgb::BLACK,
        pattern: None,
        emission: Radiance::ZERO,
    })
}
