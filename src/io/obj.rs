//! Wavefront OBJ with its MTL libraries.

mod geometry;
mod materials;
mod mtl;
mod text;
mod texture;

use super::{ReadSettings, index_u32, place_of, read_file};
use crate::bad_input::BadInput;
use crate::scene::{RawPolygon, RawScene};
use crate::warning::Warning;
use geometry::{Corner, Geometry};
use glam::{DVec2, DVec3};
use materials::Materials;
use std::collections::HashMap;
use std::path::Path;
use text::decode;
use texture::UvMove;

/// The scene in an OBJ file; its faces reflect on both sides and emit from the front.
pub(super) fn read(path: &Path, settings: &ReadSettings) -> Result<RawScene, BadInput> {
    let place = place_of(path);
    let bytes = read_file(path)?;
    let geometry = Geometry::read(&decode(&bytes), &place)?;

    let mut warnings = warnings_of(&geometry, &place);
    let mut materials = Materials::default();
    for library in &geometry.libraries {
        materials.read_library(path, library, &mut warnings)?;
    }
    let mut material_of = Vec::with_capacity(geometry.used.len());
    for used in &geometry.used {
        material_of.push(materials.ensure(used, &mut warnings));
    }
    let mut builder = Builder {
        scene: RawScene {
            source: place.clone(),
            warnings,
            groups: geometry.groups.clone(),
            ..RawScene::default()
        },
        place: &place,
        settings,
        geometry: &geometry,
        known: HashMap::new(),
    };
    for face in &geometry.faces {
        let index = materials.use_for(face.material.map(|m| material_of[m]), &place);
        let uv = materials.open_texture(index, &mut builder.scene)?;
        let corners = &geometry.corners[face.corners.clone()];
        let polygon = RawPolygon {
            corners: builder.enter_all(corners, uv)?,
            material: index_u32(index, &place)?,
            group: face.group,
        };
        builder.scene.polygons.push(polygon);
    }
    let mut scene = builder.finish();
    materials.finish(&mut scene)?;
    Ok(scene)
}

fn warnings_of(geometry: &Geometry, place: &str) -> Vec<Warning> {
    let counted = [
        (
            geometry.without_area,
            "point, line and curve statements left out: they are no polygons",
        ),
        (geometry.dropped, "faces with fewer than 3 corners left out"),
    ];
    counted
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| Warning::new(place, format!("{count} {what}")))
        .collect()
}

/// A name in the file and `file:line` of the statement.
struct NamedAt {
    name: String,
    place: String,
}

impl NamedAt {
    fn new(name: &str, place: String) -> Self {
        let name = name.to_owned();
        Self { name, place }
    }
}

struct Builder<'a> {
    scene: RawScene,
    place: &'a str,
    settings: &'a ReadSettings,
    geometry: &'a Geometry,
    /// Index in the scene of each corner that has entered it: corners that differ in texture or normal are apart.
    known: HashMap<Corner, u32>,
}

impl Builder<'_> {
    /// Indices of the corners; `uv` says how a texture of theirs is looked up, if they have one.
    fn enter_all(&mut self, corners: &[Corner], uv: Option<UvMove>) -> Result<Vec<u32>, BadInput> {
        let enter = |corner: &Corner| self.enter(*corner, uv);
        corners.iter().map(enter).collect()
    }

    fn enter(&mut self, corner: Corner, uv: Option<UvMove>) -> Result<u32, BadInput> {
        let geometry = self.geometry;
        let number = |list: usize, n: u32| if n as usize <= list { n } else { 0 };
        let key = Corner {
            uv: uv.map_or(0, |_| number(geometry.uvs.len(), corner.uv)),
            normal: number(geometry.normals.len(), corner.normal),
            ..corner
        };
        if let Some(&index) = self.known.get(&key) {
            return Ok(index);
        }
        let index = index_u32(self.scene.positions.len(), self.place)?;
        let unit = self.settings.unit.unwrap_or_default();
        let up = self.settings.up;
        let local = geometry.positions[key.position as usize];
        let position = up.to_y_up(unit.to_metres(local));
        if !position.is_finite() {
            return Err(BadInput::new(
                self.place,
                format!("vertex {} is not finite in metres", key.position + 1),
                "check the unit",
            ));
        }
        let before = |n: u32| (n as usize).checked_sub(1);
        let normal = before(key.normal).map_or(DVec3::ZERO, |i| geometry.normals[i]);
        let place = before(key.uv).and_then(|i| geometry.uvs[i]);
        let place = place.zip(uv).map_or(DVec2::ZERO, |(p, uv)| uv.apply(p));
        self.scene.positions.push(position);
        self.scene.normals.push(up.to_y_up(normal));
        self.scene.uvs.push(place);
        self.known.insert(key, index);
        Ok(index)
    }

    /// The scene without lists that say nothing.
    fn finish(mut self) -> RawScene {
        if self.scene.textures.is_empty() {
            self.scene.uvs.clear();
        }
        if self.scene.normals.iter().all(|n| *n == DVec3::ZERO) {
            self.scene.normals.clear();
        }
        self.scene
    }
}
