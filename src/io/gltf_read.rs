//! glTF 2.0, as `.gltf` with its buffers or as `.glb`.
//!
//! Front faces reflect and emit; a `doubleSided` material does so on both sides. A hostile file ends in a [`BadInput`],
//! never in a panic: what is used is checked first, and what the `gltf` crate itself trips over is caught.

mod accessor;
mod buffers;
mod material;
mod node;
mod omitted;
mod shield;
mod triangles;

use super::{ReadSettings, Unit, index_u32, place_of, read_file};
use crate::bad_input::BadInput;
use crate::scene::{RawPolygon, RawScene};
use crate::warning::Warning;
use buffers::Buffers;
use glam::{DMat3, DVec3};
use gltf::Semantic;
use gltf::mesh::Mode;
use node::PlacedNode;
use omitted::Omitted;
use std::path::Path;

/// Polygons of a scene, instances counted each time. A small file can name one mesh from many nodes; this is where it
/// would outgrow the memory (some 4 GB for the list alone).
const MAX_POLYGONS: usize = 50_000_000;

/// Extensions that a file may use without requiring them, and what is lost without them.
const UNREAD_EXTENSIONS: [(&str, &str); 5] = [
    ("EXT_mesh_gpu_instancing", "its instances are not read"),
    (
        "KHR_lights_punctual",
        "point, spot and directional lights are not read: light comes from emissive faces",
    ),
    (
        "KHR_materials_pbrSpecularGlossiness",
        "the base colour factor is used instead",
    ),
    (
        "KHR_materials_transmission",
        "such surfaces count as opaque",
    ),
    ("KHR_materials_variants", "the default variant is used"),
];

/// The scene in a glTF file.
pub(super) fn read(path: &Path, settings: &ReadSettings) -> Result<RawScene, BadInput> {
    let place = place_of(path);
    let bytes = read_file(path)?;
    shield::shielded(|| read_bytes(&bytes, path, &place, settings)).unwrap_or_else(|panic| {
        Err(BadInput::new(
            &place,
            format!("damaged glTF, at which its reader failed ({panic})"),
            "export the file again, or find its faults with the Khronos glTF validator",
        ))
    })
}

fn read_bytes(
    bytes: &[u8],
    path: &Path,
    place: &str,
    settings: &ReadSettings,
) -> Result<RawScene, BadInput> {
    let (document, blob) = parse(bytes, place)?;
    let buffers = Buffers::load(&document, blob, path, place)?;
    let mut builder = Builder {
        scene: RawScene {
            source: place.to_owned(),
            ..RawScene::default()
        },
        material_of: vec![None; document.materials().count() + 1],
        buffers,
        place,
        settings,
        omitted: Omitted::default(),
    };
    builder.warn_of_document(&document);
    for placed in node::placed_nodes(&document, place)? {
        builder.push_node(&placed)?;
    }
    builder.omitted.warn(place, &mut builder.scene.warnings);
    Ok(builder.scene)
}

/// The document, checked, and the binary chunk.
fn parse(bytes: &[u8], place: &str) -> Result<(gltf::Document, Option<Vec<u8>>), BadInput> {
    let gltf = gltf::Gltf::from_slice_without_validation(bytes).map_err(|e| invalid(place, &e))?;
    // Ahead of the crate's checks, which would name the extension last among the consequences of not knowing it.
    let unknown: Vec<_> = gltf
        .document
        .extensions_required()
        .filter(|name| !gltf::json::extensions::ENABLED_EXTENSIONS.contains(name))
        .collect();
    if !unknown.is_empty() {
        return Err(BadInput::new(
            place,
            format!("requires {}, which is not supported", unknown.join(", ")),
            "export without mesh compression, quantization and other required extensions",
        ));
    }
    let document =
        gltf::Document::from_json(gltf.document.into_json()).map_err(|e| invalid(place, &e))?;
    Ok((document, gltf.blob))
}

fn invalid(place: &str, error: &gltf::Error) -> BadInput {
    let what = match error {
        gltf::Error::Validation(mistakes) => match &mistakes[..] {
            [(path, first), others @ ..] => {
                format!("invalid glTF: {path}: {first} (and {} more)", others.len())
            }
            [] => "invalid glTF".to_owned(),
        },
        other => format!("cannot be read as glTF 2.0: {other}"),
    };
    BadInput::new(place, what, "export the file again")
}

struct Builder<'a> {
    scene: RawScene,
    /// Index into `scene.materials` of each material of the document that a face uses; the last is for "none".
    material_of: Vec<Option<u32>>,
    buffers: Buffers,
    place: &'a str,
    settings: &'a ReadSettings,
    omitted: Omitted,
}

impl Builder<'_> {
    fn warn_of_document(&mut self, document: &gltf::Document) {
        let mut warn = |message| self.scene.warnings.push(Warning::new(self.place, message));
        if self.settings.unit.is_some_and(|unit| unit != Unit::Metre) {
            warn("the unit is left out of account: glTF is in metres".to_owned());
        }
        for (name, loss) in UNREAD_EXTENSIONS {
            if document.extensions_used().any(|used| used == name) {
                warn(format!("uses {name}: {loss}"));
            }
        }
    }

    fn push_node(&mut self, placed: &PlacedNode<'_>) -> Result<(), BadInput> {
        if let Some(camera) = placed.node.camera() {
            match node::camera(placed, &camera, self.settings.up) {
                Some(camera) => self.scene.cameras.push(camera),
                None => self.omitted.cameras += 1,
            }
        }
        let Some(mesh) = placed.node.mesh() else {
            return Ok(());
        };
        let name = placed.node.name().or(mesh.name());
        let name = name.map_or_else(|| format!("node {}", placed.node.index()), str::to_owned);
        let group = index_u32(self.scene.groups.len(), self.place)?;
        self.scene.groups.push(name);
        self.omitted.skins += usize::from(placed.node.skin().is_some());
        for primitive in mesh.primitives() {
            self.push_primitive(placed, &primitive, group)?;
        }
        Ok(())
    }

    fn push_primitive(
        &mut self,
        placed: &PlacedNode<'_>,
        primitive: &gltf::Primitive<'_>,
        group: u32,
    ) -> Result<(), BadInput> {
        let Some(source) = primitive.get(&Semantic::Positions) else {
            self.omitted.primitives += 1;
            return Ok(());
        };
        let positions = accessor::positions(&source, &self.buffers, self.place)?;
        let indices = match primitive.indices() {
            Some(indices) => accessor::indices(&indices, &self.buffers, self.place)?,
            None => (0..index_u32(positions.len(), self.place)?).collect(),
        };
        let Some(triangles) = triangles::triangles(primitive.mode(), &indices) else {
            self.omitted.primitives += 1;
            return Ok(());
        };
        if primitive.mode() == Mode::Triangles && indices.len() % 3 != 0 {
            self.omitted.leftovers += 1;
        }
        self.omitted.colours += usize::from(primitive.get(&Semantic::Colors(0)).is_some());
        self.omitted.morphs += usize::from(primitive.morph_targets().next().is_some());
        if self.scene.polygons.len() + triangles.len() > MAX_POLYGONS {
            return Err(BadInput::new(
                self.place,
                format!("more than {MAX_POLYGONS} triangles, instances counted"),
                "split the scene",
            ));
        }
        let material = self.material(&primitive.material(), triangles.len())?;
        self.push_triangles(placed, &positions, &triangles, material, group)
    }

    /// Index of the material in the scene, which gets it at its first use.
    fn material(&mut self, source: &gltf::Material<'_>, faces: usize) -> Result<u32, BadInput> {
        if source.index().is_none() {
            self.omitted.without_material += faces;
        }
        let slot = source.index().unwrap_or(self.material_of.len() - 1);
        if let Some(index) = self.material_of[slot] {
            return Ok(index);
        }
        let index = index_u32(self.scene.materials.len(), self.place)?;
        let converted = material::convert(source, self.place, &mut self.scene.warnings)?;
        self.scene.materials.push(converted);
        self.material_of[slot] = Some(index);
        Ok(index)
    }

    /// Adds triangles over `local` positions, of which only those in use enter the scene: exporters share one array
    /// among many primitives.
    fn push_triangles(
        &mut self,
        placed: &PlacedNode<'_>,
        local: &[[f32; 3]],
        triangles: &[[u32; 3]],
        material: u32,
        group: u32,
    ) -> Result<(), BadInput> {
        let is_mirrored = DMat3::from_mat4(placed.world).determinant() < 0.0;
        let mut entered: Vec<Option<u32>> = vec![None; local.len()];
        for triangle in triangles {
            let mut corners = Vec::with_capacity(3);
            for &corner in triangle {
                corners.push(self.enter(placed, local, &mut entered, corner)?);
            }
            // A mirror turns fronts into backs; the other way round the corners, the front is the front again.
            if is_mirrored {
                corners.swap(1, 2);
            }
            self.scene.polygons.push(RawPolygon {
                corners,
                material,
                group,
            });
        }
        Ok(())
    }

    fn enter(
        &mut self,
        placed: &PlacedNode<'_>,
        local: &[[f32; 3]],
        entered: &mut [Option<u32>],
        corner: u32,
    ) -> Result<u32, BadInput> {
        let error = |what| {
            let at = format!("{}: node {}", self.place, placed.node.index());
            BadInput::new(at, what, "the file is damaged: export it again")
        };
        let Some(slot) = entered.get_mut(corner as usize) else {
            return Err(error(format!(
                "index {corner} is out of range ({} vertices)",
                local.len()
            )));
        };
        if let Some(index) = *slot {
            return Ok(index);
        }
        let position = DVec3::from_array(local[corner as usize].map(f64::from));
        let world = self
            .settings
            .up
            .to_y_up(placed.world.transform_point3(position));
        if !world.is_finite() {
            return Err(error(format!(
                "the position of vertex {corner} is not finite"
            )));
        }
        let index = index_u32(self.scene.positions.len(), self.place)?;
        self.scene.positions.push(world);
        *slot = Some(index);
        Ok(index)
    }
}
