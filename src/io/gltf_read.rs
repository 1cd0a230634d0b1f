//! glTF 2.0, as `.gltf` with its buffers or as `.glb`.
//!
//! Front faces reflect and emit; a `doubleSided` material does so on both sides. Skins and morph targets are read in the
//! pose that the file shows without its animations. A hostile file ends in a [`BadInput`], never in a panic: what is used
//! is checked first.

mod instances;
mod light;
mod material;
mod node;
mod omitted;
mod shape;
mod triangles;

use super::gltf_data::accessor::{self, Numbers};
use super::gltf_data::buffers::{Buffers, Folder};
use super::gltf_data::place::normal_matrix;
use super::gltf_data::{document, texture};
use super::{ReadSettings, Unit, index_u32, place_of, read_file};
use crate::bad_input::BadInput;
use crate::scene::{RawPolygon, RawScene};
use crate::warning::Warning;
use glam::{DMat3, DMat4, DVec2, DVec3};
use gltf::Semantic;
use material::Converted;
use node::PlacedNode;
use omitted::Omitted;
use shape::{Shape, Source};
use std::path::Path;

/// Polygons of a scene, instances counted each time. A small file can name one mesh from many nodes; this is where it
/// would outgrow the memory (some 4 GB for the list alone).
const MAX_POLYGONS: usize = 50_000_000;

/// Extensions that a file may use without requiring them, and what is lost without them.
const UNREAD_EXTENSIONS: [(&str, &str); 2] = [
    (
        "KHR_texture_basisu",
        "pictures in its format are not read, others are",
    ),
    ("KHR_materials_variants", "the default variant is used"),
];

/// The scene in a glTF file.
pub(super) fn read(path: &Path, settings: &ReadSettings) -> Result<RawScene, BadInput> {
    let place = place_of(path);
    read_bytes(&read_file(path)?, path, &place, settings)
}

/// The scene in the bytes of a glTF file; `path` is where other files are looked for.
fn read_bytes(
    bytes: &[u8],
    path: &Path,
    place: &str,
    settings: &ReadSettings,
) -> Result<RawScene, BadInput> {
    let (document, blob) = document::parse(bytes, place)?;
    let folder = Folder::Of(path);
    let buffers = Buffers::load(&document, blob, &folder, place)?;
    let is_quantized = document
        .extensions_used()
        .any(|e| e == "KHR_mesh_quantization");
    let mut builder = Builder {
        scene: RawScene {
            source: place.to_owned(),
            ..RawScene::default()
        },
        material_of: vec![None; document.materials().count() + 1],
        texture_of: vec![None; document.textures().count()],
        source: Source {
            buffers: &buffers,
            place,
            numbers: if is_quantized {
                Numbers::Quantized
            } else {
                Numbers::Core
            },
        },
        document: &document,
        folder,
        place,
        settings,
        omitted: Omitted::default(),
    };
    builder.warn_of_document();
    let nodes = node::placed_nodes(&document, place)?;
    let mut worlds = vec![None; document.nodes().count()];
    for placed in &nodes {
        worlds[placed.node.index()] = Some(placed.world);
    }
    for placed in &nodes {
        builder.push_node(placed, &worlds)?;
    }
    Ok(builder.finish())
}

struct Builder<'a> {
    scene: RawScene,
    /// Each material of the document that a face uses; the last is for "none".
    material_of: Vec<Option<Converted>>,
    /// Each texture of the document that was looked at: its index in the scene, if it could be read.
    texture_of: Vec<Option<Option<u32>>>,
    source: Source<'a>,
    document: &'a gltf::Document,
    folder: Folder<'a>,
    place: &'a str,
    settings: &'a ReadSettings,
    omitted: Omitted,
}

impl Builder<'_> {
    fn warn_of_document(&mut self) {
        let mut warn = |message| self.scene.warnings.push(Warning::new(self.place, message));
        if self.settings.unit.is_some_and(|unit| unit != Unit::Metre) {
            warn("the unit is left out of account: glTF is in metres".to_owned());
        }
        for (name, loss) in UNREAD_EXTENSIONS {
            if self.document.extensions_used().any(|used| used == name) {
                warn(format!("uses {name}: {loss}"));
            }
        }
    }

    /// The scene, with its warnings, without lists that say nothing.
    fn finish(mut self) -> RawScene {
        self.omitted.warn(self.place, &mut self.scene.warnings);
        if self.scene.textures.is_empty() {
            self.scene.uvs.clear();
        }
        if self.scene.normals.iter().all(|n| *n == DVec3::ZERO) {
            self.scene.normals.clear();
        }
        self.scene
    }

    fn push_node(
        &mut self,
        placed: &PlacedNode<'_>,
        worlds: &[Option<DMat4>],
    ) -> Result<(), BadInput> {
        let up = self.settings.up;
        if let Some(camera) = placed.node.camera() {
            match node::camera(placed, &camera, up) {
                Some(camera) => self.scene.cameras.push(camera),
                None => self.omitted.cameras += 1,
            }
        }
        if let Some(light) = placed.node.light() {
            match light::light(placed, &light, up) {
                Some(light) => self.scene.lights.push(light),
                None => self.omitted.lights += 1,
            }
        }
        let Some(mesh) = placed.node.mesh() else {
            return Ok(());
        };
        let name = placed.node.name().or(mesh.name());
        let name = name.map_or_else(|| format!("node {}", placed.node.index()), str::to_owned);
        let group = index_u32(self.scene.groups.len(), self.place)?;
        self.scene.groups.push(name);
        let buffers = self.source.buffers;
        let instances = instances::instances(&placed.node, self.document, buffers, self.place)?;
        let joints = self.joints(&placed.node, worlds)?;
        for primitive in mesh.primitives() {
            self.push_primitive(placed, &primitive, group, &instances, &joints)?;
        }
        Ok(())
    }

    /// Where each joint of the node's skin takes a point of the mesh; empty without a skin.
    fn joints(
        &self,
        node: &gltf::Node<'_>,
        worlds: &[Option<DMat4>],
    ) -> Result<Vec<DMat4>, BadInput> {
        let Some(skin) = node.skin() else {
            return Ok(Vec::new());
        };
        let (buffers, place) = (self.source.buffers, self.place);
        let inverse = skin.inverse_bind_matrices();
        let inverse = inverse
            .map(|a| accessor::vectors::<16>(&a, buffers, place, Numbers::Core, "bind matrices"))
            .transpose()?;
        let joint = |(i, joint): (usize, gltf::Node<'_>)| {
            let bind = inverse.as_ref().and_then(|list| list.get(i));
            let bind = bind.map_or(DMat4::IDENTITY, DMat4::from_cols_array);
            // A joint outside the scene stands at its root.
            worlds[joint.index()].unwrap_or(DMat4::IDENTITY) * bind
        };
        Ok(skin.joints().enumerate().map(joint).collect())
    }

    fn push_primitive(
        &mut self,
        placed: &PlacedNode<'_>,
        primitive: &gltf::Primitive<'_>,
        group: u32,
        instances: &[DMat4],
        joints: &[DMat4],
    ) -> Result<(), BadInput> {
        let is_drawn = !matches!(
            primitive.mode(),
            gltf::mesh::Mode::Points
                | gltf::mesh::Mode::Lines
                | gltf::mesh::Mode::LineLoop
                | gltf::mesh::Mode::LineStrip
        );
        if !is_drawn {
            self.omitted.primitives += 1;
            return Ok(());
        }
        let material = self.material(&primitive.material())?;
        let Some(mut shape) = self.source.shape(primitive, material.uv)? else {
            self.omitted.primitives += 1;
            return Ok(());
        };
        let mesh_weights = placed.node.mesh().and_then(|mesh| mesh.weights());
        let weights = placed.node.weights().or(mesh_weights).unwrap_or(&[]);
        self.source.morph(&mut shape, primitive, weights)?;
        let is_posed = !joints.is_empty() && self.source.pose(&mut shape, primitive, joints)?;
        // The joints stand in the world: the place of a skinned node itself does not count.
        let world = if is_posed {
            DMat4::IDENTITY
        } else {
            placed.world
        };
        self.omitted.leftovers += usize::from(shape.has_leftover);
        self.omitted.colours += usize::from(primitive.get(&Semantic::Colors(0)).is_some());
        self.omitted.without_uvs += usize::from(material.uv.is_some() && shape.uvs.is_empty());
        if primitive.material().index().is_none() {
            self.omitted.without_material += shape.triangles.len();
        }
        let added = shape.triangles.len().saturating_mul(instances.len());
        if self.scene.polygons.len().saturating_add(added) > MAX_POLYGONS {
            return Err(BadInput::new(
                self.place,
                format!("more than {MAX_POLYGONS} triangles, instances counted"),
                "split the scene",
            ));
        }
        for &instance in instances {
            let at = Placement {
                node: placed.node.index(),
                world: world * instance,
                material: material.index,
                group,
            };
            self.push_shape(&shape, &at)?;
        }
        Ok(())
    }

    /// The material in the scene, which gets it at its first use.
    fn material(&mut self, source: &gltf::Material<'_>) -> Result<Converted, BadInput> {
        let slot = source.index().unwrap_or(self.material_of.len() - 1);
        if let Some(known) = self.material_of[slot] {
            return Ok(known);
        }
        let (mut material, textures) =
            material::convert(source, self.place, &mut self.scene.warnings)?;
        let mut uv = None;
        if let Some(info) = textures.emissive.filter(|_| material.is_emitter()) {
            let what = "emissive";
            material.emission_texture = self.texture(&info.texture(), &material.name, what)?;
            uv = material
                .emission_texture
                .map(|_| texture::UvSource::of(&info));
        }
        if let Some(info) = textures.base {
            let what = "base colour";
            material.texture = self.texture(&info.texture(), &material.name, what)?;
            uv = material
                .texture
                .map(|_| texture::UvSource::of(&info))
                .or(uv);
        }
        let index = index_u32(self.scene.materials.len(), self.place)?;
        self.scene.materials.push(material);
        let converted = Converted { index, uv };
        self.material_of[slot] = Some(converted);
        Ok(converted)
    }

    /// Index of the texture in the scene; none, with a warning, when it cannot be read.
    fn texture(
        &mut self,
        source: &gltf::Texture<'_>,
        material: &str,
        what: &str,
    ) -> Result<Option<u32>, BadInput> {
        if let Some(known) = self.texture_of[source.index()] {
            return Ok(known);
        }
        let index = match texture::load(source, self.document, self.source.buffers, &self.folder) {
            Ok(texture) => {
                self.scene.textures.push(texture);
                Some(index_u32(self.scene.textures.len() - 1, self.place)?)
            }
            Err(why) => {
                let message = format!(
                    "material \"{material}\": its {what} texture {why}; the factor alone is used"
                );
                self.scene.warnings.push(Warning::new(self.place, message));
                None
            }
        };
        self.texture_of[source.index()] = Some(index);
        Ok(index)
    }

    /// Adds triangles, of whose corners only those in use enter the scene: exporters share one array among many
    /// primitives.
    fn push_shape(&mut self, shape: &Shape, at: &Placement) -> Result<(), BadInput> {
        let is_mirrored = DMat3::from_mat4(at.world).determinant() < 0.0;
        let mut entered: Vec<Option<u32>> = vec![None; shape.positions.len()];
        for triangle in &shape.triangles {
            let mut corners = Vec::with_capacity(3);
            for &corner in triangle {
                corners.push(self.enter(shape, at, &mut entered, corner)?);
            }
            // A mirror turns fronts into backs; the other way round the corners, the front is the front again.
            if is_mirrored {
                corners.swap(1, 2);
            }
            self.scene.polygons.push(RawPolygon {
                corners,
                material: at.material,
                group: at.group,
            });
        }
        Ok(())
    }

    fn enter(
        &mut self,
        shape: &Shape,
        at: &Placement,
        entered: &mut [Option<u32>],
        corner: u32,
    ) -> Result<u32, BadInput> {
        let error = |what| {
            let at = format!("{}: node {}", self.place, at.node);
            BadInput::new(at, what, "the file is damaged: export it again")
        };
        let i = corner as usize;
        let Some(slot) = entered.get_mut(i) else {
            return Err(error(format!(
                "index {corner} is out of range ({} vertices)",
                shape.positions.len()
            )));
        };
        if let Some(index) = *slot {
            return Ok(index);
        }
        let up = self.settings.up;
        let world = up.to_y_up(at.world.transform_point3(shape.positions[i]));
        if !world.is_finite() {
            return Err(error(format!(
                "the position of vertex {corner} is not finite"
            )));
        }
        let normal = shape.normals.get(i).map_or(DVec3::ZERO, |&n| {
            up.to_y_up(normal_matrix(at.world) * n).normalize_or_zero()
        });
        let index = index_u32(self.scene.positions.len(), self.place)?;
        self.scene.positions.push(world);
        self.scene.normals.push(normal);
        self.scene
            .uvs
            .push(shape.uvs.get(i).copied().unwrap_or(DVec2::ZERO));
        *slot = Some(index);
        Ok(index)
    }
}

/// One copy of a shape.
struct Placement {
    node: usize,
    world: DMat4,
    material: u32,
    group: u32,
}
