//! Which polygons count, and the local origin and tolerances they are cleaned with.

use super::piece::Piece;
use super::reflectance::CutOuts;
use super::{CleanSettings, Tolerances};
use crate::bad_input::BadInput;
use crate::geom::bounds;
use crate::scene::{Material, RawScene, VertexId};
use glam::DVec3;

/// Weld distance over the scene's diagonal where the user states none.
///
/// Files carry coordinates rounded to float32, and exporters multiply them by matrices in float32: shared corners come
/// out 10⁻⁸ to 10⁻⁷ of the scene's size apart. The smallest detail of a modelled room is a thousand times larger.
const WELD_DISTANCE_OVER_DIAGONAL: f64 = 1e-6;

/// Roundings between a world coordinate and the local one that is compared: stored, shifted, differenced, measured.
const ROUNDINGS: f64 = 4.0;

/// The polygons that take part, on unwelded vertices.
pub(super) struct Selection {
    /// Polygons that are not see-through; a corner is an index into `points`.
    pub(super) pieces: Vec<Piece>,
    /// Positions that they use, local, in the order of the file.
    pub(super) points: Vec<DVec3>,
    /// The point of each position of the file; any for those that take no part.
    point_of: Vec<u32>,
    /// World position of the local origin.
    pub(super) origin: DVec3,
    /// Diagonal of the box around `points`.
    pub(super) diagonal: f64,
    /// The tolerances in metres.
    pub(super) tolerances: Tolerances,
}

impl Selection {
    /// What belongs to each position of the file, from what belongs to each point.
    pub(super) fn through_points(&self, of_point: &[VertexId]) -> Vec<VertexId> {
        let of = |&point: &u32| of_point.get(point as usize).copied();
        self.point_of
            .iter()
            .map(|point| of(point).unwrap_or(VertexId(0)))
            .collect()
    }
}

/// Picks the polygons that are not see-through and moves them to the centre of their box.
pub(super) fn select(raw: &RawScene, settings: &CleanSettings) -> Result<Selection, BadInput> {
    let mut pieces = Vec::with_capacity(raw.polygons.len());
    let mut is_used = vec![false; raw.positions.len()];
    check_attributes(raw)?;
    let cut_outs = CutOuts::new(raw);
    for (index, polygon) in raw.polygons.iter().enumerate() {
        let Some(material) = raw.materials.get(polygon.material as usize) else {
            return Err(broken(raw, index, "refers to a material that is not there"));
        };
        for &corner in &polygon.corners {
            match raw.positions.get(corner as usize) {
                None => return Err(broken(raw, index, "refers to a position that is not there")),
                Some(p) if !p.is_finite() => {
                    return Err(broken(raw, index, "has a corner that is not a number"));
                }
                Some(_) => {}
            }
        }
        if material.is_see_through || cut_outs.is_away(polygon) {
            continue;
        }
        polygon
            .corners
            .iter()
            .for_each(|&c| is_used[c as usize] = true);
        pieces.push(Piece {
            corners: polygon.corners.iter().map(|&c| VertexId(c)).collect(),
            material: polygon.material,
            group: polygon.group,
            source: u32::try_from(index).expect("fewer than 2³² polygons"),
            maps: None,
        });
    }
    let (lo, hi) = bounds(used(&raw.positions, &is_used));
    if pieces.is_empty() || lo.x > hi.x {
        return Err(nothing_left(
            raw,
            "the scene has no polygon that light meets",
        ));
    }
    let diagonal = lo.distance(hi);
    let origin = local_origin(lo.midpoint(hi), diagonal);
    let largest = lo.abs().max(hi.abs()).max_element();
    let tolerances = tolerances(raw, settings, diagonal, largest)?;

    // Number the used positions densely: unused ones neither weld nor move the box.
    let mut dense = vec![0_u32; is_used.len()];
    let mut next = 0;
    for (slot, &is_used) in dense.iter_mut().zip(&is_used) {
        *slot = next;
        next += u32::from(is_used);
    }
    for corner in pieces.iter_mut().flat_map(|p| &mut p.corners) {
        *corner = VertexId(dense[corner.0 as usize]);
    }
    Ok(Selection {
        points: used(&raw.positions, &is_used).map(|p| p - origin).collect(),
        point_of: dense,
        pieces,
        origin,
        diagonal,
        tolerances,
    })
}

/// Refuses texture coordinates and normals that do not belong to the positions.
fn check_attributes(raw: &RawScene) -> Result<(), BadInput> {
    let count = raw.positions.len();
    let bad = |what: String| BadInput::new(&raw.source, what, "export the file again");
    for (name, length) in [
        ("texture coordinates", raw.uvs.len()),
        ("normals", raw.normals.len()),
    ] {
        if length != 0 && length != count {
            return Err(bad(format!("{length} {name} for {count} positions")));
        }
    }
    let is_finite =
        raw.uvs.iter().all(|uv| uv.is_finite()) && raw.normals.iter().all(|n| n.is_finite());
    if !is_finite {
        return Err(bad(
            "a texture coordinate or a normal is not finite".to_owned()
        ));
    }
    let is_there = |material: &Material| {
        let both = [material.texture, material.emission_texture];
        let mut named = both.into_iter().flatten();
        named.all(|index| (index as usize) < raw.textures.len())
    };
    match raw.materials.iter().find(|m| !is_there(m)) {
        Some(material) => Err(bad(format!(
            "material \"{}\" refers to a texture that is not there",
            material.name
        ))),
        None => Ok(()),
    }
}

/// The middle of the scene; far off, the nearest point with coordinates of 32 bits, so that glTF can say where it is.
fn local_origin(middle: DVec3, diagonal: f64) -> DVec3 {
    let rounded = middle.as_vec3().as_dvec3();
    let is_far = rounded.distance(middle) > f64::from(f32::EPSILON) * diagonal;
    if is_far && rounded.is_finite() {
        rounded
    } else {
        middle
    }
}

fn used<'a>(positions: &'a [DVec3], is_used: &'a [bool]) -> impl Iterator<Item = DVec3> + 'a {
    positions
        .iter()
        .zip(is_used)
        .filter_map(|(&p, &is_used)| is_used.then_some(p))
}

/// The user's tolerances or the derived ones; never below what rounding has already blurred.
fn tolerances(
    raw: &RawScene,
    settings: &CleanSettings,
    diagonal: f64,
    largest_coordinate: f64,
) -> Result<Tolerances, BadInput> {
    let roundoff = ROUNDINGS * f64::EPSILON * largest_coordinate;
    let derived = (WELD_DISTANCE_OVER_DIAGONAL * diagonal).max(roundoff);
    let checked = |name: &str, value: Option<f64>, default: f64| match value {
        None => Ok(default),
        Some(v) if v.is_finite() && v >= roundoff => Ok(v),
        Some(v) => Err(BadInput::new(
            &raw.source,
            format!("{name} of {v} m is below the rounding of the coordinates, {roundoff:.1e} m"),
            format!("raise it, or leave it out for {derived:.1e} m"),
        )),
    };
    let weld_distance = checked("weld distance", settings.weld_distance, derived)?;
    Ok(Tolerances {
        weld_distance,
        edge_distance: 0.5 * weld_distance,
        planarity: checked("planarity", settings.planarity, weld_distance)?,
    })
}

/// The error for a scene without a face.
pub(super) fn nothing_left(raw: &RawScene, why: impl Into<String>) -> BadInput {
    BadInput::new(
        &raw.source,
        why,
        "check that the file holds opaque surfaces larger than the weld distance",
    )
}

fn broken(raw: &RawScene, polygon: usize, what: &str) -> BadInput {
    BadInput::new(
        &raw.source,
        format!("polygon {} of {} {what}", polygon + 1, raw.polygons.len()),
        "export the file again",
    )
}
