//! From a polygon soup to a [`Scene`].
//!
//! Earlier meshers died of their input: cracks, vertices in the middle of edges, needles, doubled faces, quads that are
//! not flat. [`clean`] repairs what it can and counts it:
//!
//! ```text
//! select → weld → drop needles → drop duplicates → split bent → insert T-vertices → merge coplanar
//!        → faces → straighten edges → edges with their faces
//! ```

mod bent;
mod best_plane;
mod convex;
mod duplicates;
mod face;
mod merge;
mod outline;
mod piece;
mod point_tree;
mod reflectance;
mod report;
mod select;
mod straighten;
mod surface;
mod t_junction;
#[cfg(test)]
mod tests;
mod triangulate;
mod weld;

pub use report::CleanReport;

use super::adjacency::{connect, mark_smooth};
use super::{Emitter, Face, FaceId, FaceSide, IdVec, Material, RawScene, Scene, VertexId};
use crate::bad_input::BadInput;
use crate::warning::Warning;
use glam::DVec3;
use piece::{Piece, Positions, Shape};
use surface::Corners;

/// Tolerances of the clean-up, metres; `None` derives them from the scene's diagonal.
#[derive(Clone, Copy, Debug, Default)]
pub struct CleanSettings {
    /// Below this distance two points are the same point.
    pub weld_distance: Option<f64>,
    /// How far a corner may lie outside its face's plane.
    pub planarity: Option<f64>,
}

/// The tolerances that hold for one scene, metres.
#[derive(Clone, Copy, Debug)]
struct Tolerances {
    weld_distance: f64,
    /// Below this distance a vertex lies on an edge: half the weld distance, which is what lets the insertion of vertices
    /// into edges come to an end.
    edge_distance: f64,
    planarity: f64,
}

/// The scene that `raw` describes, what was repaired (in numbers), and the same as text.
///
/// See-through polygons are left out. Faces are numbered in the order of the file. Coplanar faces that overlap without
/// having the same corners stay as they are.
///
/// # Errors
/// When a polygon refers to nothing or to a coordinate that is not finite, when a tolerance is below the rounding of the
/// coordinates, or when no face is left.
pub fn clean(
    raw: &RawScene,
    settings: &CleanSettings,
) -> Result<(Scene, CleanReport, Vec<Warning>), BadInput> {
    let mut selection = select::select(raw, settings)?;
    let tolerances = selection.tolerances;
    let mut report = CleanReport {
        polygons: raw.polygons.len(),
        see_through: raw.polygons.len() - selection.pieces.len(),
        weld_distance_m: tolerances.weld_distance,
        edge_distance_m: tolerances.edge_distance,
        planarity_m: tolerances.planarity,
        ..CleanReport::default()
    };
    let mut pieces = std::mem::take(&mut selection.pieces);
    let (positions, vertex_of) = weld_corners(
        &mut pieces,
        &selection.points,
        tolerances.weld_distance,
        &mut report,
    );
    let corners = Corners::new(raw, selection.through_points(&vertex_of));
    let mut folded = drop_degenerate(&mut pieces, &positions, tolerances, &mut report);
    report.duplicates = duplicates::drop_duplicates(&mut pieces, &raw.materials);

    let bent = bent::split_bent(&mut pieces, &positions, tolerances.planarity, &corners);
    report.bent = bent.split;
    folded.extend(bent.dropped);
    // Triangles cut from a bent polygon can be needles.
    folded.extend(drop_degenerate(
        &mut pieces,
        &positions,
        tolerances,
        &mut report,
    ));

    let maps = corners.all_maps(&mut pieces, &positions);
    let t_junctions =
        t_junction::insert_vertices(&mut pieces, &positions, tolerances.edge_distance);
    report.t_junctions = t_junctions.inserted;
    report.degenerate += t_junctions.collapsed;
    // A corner that only one of two doubles had is now a corner of both.
    report.duplicates += duplicates::drop_duplicates(&mut pieces, &raw.materials);

    let groups = merge::coplanar_groups(&pieces, &positions, tolerances.planarity, &corners, &maps);
    let mut built = face::build_faces(&pieces, &groups, &maps, &positions);
    report.pieces = pieces.len();
    report.unmerged = built.unmerged;
    folded.extend(built.dropped);
    folded.sort_unstable();
    folded.dedup();
    report.self_crossing = folded.len();
    if built.faces.is_empty() {
        return Err(select::nothing_left(raw, "every face is degenerate"));
    }
    report.duplicate_faces = duplicates::drop_duplicate_faces(&mut built.faces, &raw.materials);
    report.straightened =
        straighten::straighten(&mut built.faces, &positions, tolerances.edge_distance);
    reflectance::average(&mut built.faces, &positions, raw, selection.diagonal);
    let (faces, vertices) = compact(built.faces, &positions);
    let scene = assemble(
        raw,
        faces,
        vertices,
        selection.origin,
        &tolerances,
        selection.diagonal,
    );
    report.count(&scene);
    let warnings = report.warnings(&raw.source, &folded);
    Ok((scene, report, warnings))
}

/// Moves the corners onto welded vertices; returns the positions of these, and the vertex of each point.
fn weld_corners(
    pieces: &mut [Piece],
    points: &[DVec3],
    weld_distance: f64,
    report: &mut CleanReport,
) -> (Positions, Vec<VertexId>) {
    let welded = weld::weld(points, weld_distance);
    report.welded = points.len() - welded.vertices.len();
    for corner in pieces.iter_mut().flat_map(|p| &mut p.corners) {
        *corner = welded.vertex_of[corner.0 as usize];
    }
    (welded.vertices, welded.vertex_of)
}

/// Drops polygons without area; returns the file indices of those that cross themselves.
fn drop_degenerate(
    pieces: &mut Vec<Piece>,
    positions: &Positions,
    tolerances: Tolerances,
    report: &mut CleanReport,
) -> Vec<u32> {
    let mut folded = Vec::new();
    pieces.retain_mut(|piece| {
        piece.remove_spikes();
        match piece.shape(positions, tolerances.edge_distance) {
            Shape::Sound => return true,
            Shape::Degenerate => report.degenerate += 1,
            Shape::Folded => folded.push(piece.source),
        }
        false
    });
    folded
}

/// Numbers the vertices that faces still use densely, in order.
fn compact(mut faces: Vec<Face>, positions: &Positions) -> (IdVec<FaceId, Face>, Positions) {
    let mut is_used = vec![false; positions.len()];
    for &v in faces.iter().flat_map(|f| f.loops.iter().flatten()) {
        is_used[v.0 as usize] = true;
    }
    let mut vertices = Positions::default();
    let new_id: Vec<VertexId> = positions
        .iter()
        .map(|(old, &p)| {
            if is_used[old.0 as usize] {
                vertices.push(p)
            } else {
                old
            }
        })
        .collect();
    for face in &mut faces {
        let loops = face.loops.iter_mut().flatten();
        let triangles = face.triangles.iter_mut().flatten();
        let parts = face.convex_parts.iter_mut().flatten();
        for v in loops.chain(triangles).chain(parts) {
            *v = new_id[v.0 as usize];
        }
    }
    (IdVec::from(faces), vertices)
}

fn assemble(
    raw: &RawScene,
    mut faces: IdVec<FaceId, Face>,
    vertices: Positions,
    origin: DVec3,
    tolerances: &Tolerances,
    diagonal: f64,
) -> Scene {
    let mut edges = connect(&mut faces);
    mark_smooth(&mut edges, &faces, &vertices, tolerances.planarity);
    Scene {
        source: raw.source.clone(),
        origin,
        vertices,
        edges,
        emitters: emitters(&faces, &raw.materials),
        faces,
        materials: raw.materials.clone(),
        textures: raw.textures.clone(),
        groups: raw.groups.clone(),
        cameras: raw.cameras.clone(),
        lights: raw.lights.iter().map(|l| l.seen_from(origin)).collect(),
        weld_distance: tolerances.weld_distance,
        diagonal,
    }
}

/// The shining sides of faces, in the order of the faces, front before back.
fn emitters(
    faces: &IdVec<FaceId, Face>,
    materials: &[Material],
) -> IdVec<super::EmitterId, Emitter> {
    let mut emitters = IdVec::default();
    for (face, f) in faces.iter() {
        let material = &materials[f.material as usize];
        if f.emission.0.is_black() {
            continue;
        }
        emitters.push(Emitter {
            face,
            side: FaceSide::Front,
        });
        if material.emits_back {
            emitters.push(Emitter {
                face,
                side: FaceSide::Back,
            });
        }
    }
    emitters
}
