//! What of its textures a face shows, on the mean.

use super::piece::Positions;
use crate::quantity::{Radiance, Rgb};
use crate::scene::{Face, Material, Pattern, RawPolygon, RawScene};
use crate::texture::MipMap;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A polygon of which less than this share is there counts as not there. No share of it can be right: light meets either
/// all of a face or none of it.
const AWAY_BELOW: f64 = 0.5;

/// A face whose part of an emissive texture has less than this of the factor's radiance is dark: compression leaves black
/// parts of a picture not quite black, and each emitting face costs its own lines.
const DARK_BELOW: f64 = 1e-3;

/// Reflectance is known in cells of this share of the scene's diagonal: light that comes from a pattern as fine as that is
/// even wherever anything stands, but in its immediate neighbourhood.
const PATTERN_SPACING: f64 = 0.01;

/// Along each side of a face at most so many.
const PATTERN_CELLS: u32 = 64;

/// A texture that stays this close to its mean is even.
const PATTERN_CONTRAST: f64 = 0.01;

/// Fills in what each face reflects and emits: what its material does, times the area mean of the part of the texture that
/// it shows.
///
/// One texture is open at a time: at full resolution, a large scene's do not fit the memory in linear light.
pub(super) fn average(faces: &mut [Face], positions: &Positions, raw: &RawScene, diagonal: f64) {
    for face in faces.iter_mut() {
        let material = &raw.materials[face.material as usize];
        face.reflectance = material.reflectance;
        face.emission = material.emission;
    }
    let shown = |face: &Face| face.uv.is_some().then_some(face.material);
    let mut materials: Vec<u32> = faces.iter().filter_map(shown).collect();
    materials.sort_unstable();
    materials.dedup();
    for index in materials {
        let material = &raw.materials[index as usize];
        let over_faces = |faces: &mut [Face], map: &MipMap, set: fn(&mut Face, &Material, Rgb)| {
            let of_material = faces.par_iter_mut().filter(|face| face.material == index);
            of_material.for_each(|face| {
                if let Some(mean) = mean_over(face, positions, map) {
                    set(face, material, mean);
                }
            });
        };
        if let Some(map) = mip_map(raw, material.texture, material.cut_off) {
            over_faces(faces, &map, |face, material, mean| {
                face.reflectance = material.reflectance * mean;
            });
            let of_material = faces.par_iter_mut().filter(|face| face.material == index);
            of_material.for_each(|face| {
                face.pattern = pattern(face, material, &map, diagonal).map(Arc::new);
            });
        }
        let emission = material.emission_texture.filter(|_| material.is_emitter());
        if let Some(map) = mip_map(raw, emission, None) {
            over_faces(faces, &map, |face, material, mean| {
                let emission = Radiance(material.emission.0 * mean);
                let is_dark = emission.mean() < DARK_BELOW * material.emission.mean();
                face.emission = if is_dark { Radiance::ZERO } else { emission };
            });
        }
    }
}

/// A texture of the scene in linear light.
fn mip_map(raw: &RawScene, texture: Option<u32>, cut_off: Option<f64>) -> Option<MipMap> {
    let texture = raw.textures.get(texture? as usize)?;
    let texels = Arc::clone(&texture.texels);
    Some(MipMap::new(texels, texture.wrap, cut_off))
}

/// Mean colour over a face, by its triangles; none without texture coordinates or with nothing there.
fn mean_over(face: &Face, positions: &Positions, map: &MipMap) -> Option<Rgb> {
    let uv = face.uv?;
    let (mut sum, mut weight) = (Rgb::BLACK, 0.0);
    for t in &face.triangles {
        let corners = t.map(|v| positions[v]);
        let mean = map.mean(corners.map(|p| DVec2::from(uv.at(p))));
        let share = area(corners) * mean.coverage;
        sum += mean.colour * share;
        weight += share;
    }
    (weight > 0.0).then(|| sum * (1.0 / weight))
}

/// Reflectance place by place, where it is not the same everywhere.
fn pattern(face: &Face, material: &Material, map: &MipMap, diagonal: f64) -> Option<Pattern> {
    let uv = face.uv?;
    let (low, high) = face.outline.bounds();
    let mean = |corners: [DVec2; 4]| {
        let [a, b, c, d] = corners.map(|p| DVec2::from(uv.at(face.frame.to_space(p))));
        let halves = [[a, b, c], [a, c, d]].map(|t| map.mean(t));
        let there: f64 = halves.iter().map(|h| h.coverage).sum();
        if there > 0.0 {
            let colour =
                halves[0].colour * halves[0].coverage + halves[1].colour * halves[1].coverage;
            material.reflectance * (colour * (1.0 / there))
        } else {
            face.reflectance
        }
    };
    Pattern::new(
        [low, high],
        PATTERN_SPACING * diagonal,
        PATTERN_CELLS,
        (face.reflectance, PATTERN_CONTRAST),
        mean,
    )
}

fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// The cut-out textures of a scene.
pub(super) struct CutOuts<'a> {
    raw: &'a RawScene,
    maps: BTreeMap<u32, MipMap>,
}

impl<'a> CutOuts<'a> {
    /// Opens the textures of all materials with a cut-off.
    pub(super) fn new(raw: &'a RawScene) -> Self {
        let open = |(index, material): (usize, &Material)| {
            material.cut_off?;
            Some((
                index as u32,
                mip_map(raw, material.texture, material.cut_off)?,
            ))
        };
        Self {
            raw,
            maps: raw.materials.iter().enumerate().filter_map(open).collect(),
        }
    }

    /// Whether more of the polygon is cut away than is there.
    pub(super) fn is_away(&self, polygon: &RawPolygon) -> bool {
        let Some(map) = self.maps.get(&polygon.material) else {
            return false;
        };
        let (positions, uvs) = (&self.raw.positions, &self.raw.uvs);
        let [first, rest @ ..] = &polygon.corners[..] else {
            return false;
        };
        if uvs.len() != positions.len() {
            return false;
        }
        let (mut there, mut all) = (0.0, 0.0);
        for pair in rest.windows(2) {
            let t = [*first, pair[0], pair[1]].map(|c| c as usize);
            let size = area(t.map(|c| positions[c]));
            there += map.mean(t.map(|c| uvs[c])).coverage * size;
            all += size;
        }
        there < AWAY_BELOW * all
    }
}
