//! A [`LitScene`] as a binary glTF that any viewer shows lit.
//!
//! One root node stands at the scene's origin; below it one node for each group, with one primitive for each material (and
//! for each emitting material a second one). Materials are unlit, so a viewer shows `baseColor × COLOR_0` and nothing else:
//!
//! | | base colour | `COLOR_0` |
//! |---|---|---|
//! | a side that reflects only | reflectance ρ, factor and texture | `E / π × exposure` |
//! | a side that emits | white | `(M + ρ E) / π × exposure` |
//!
//! both clamped to 0…1, since glTF allows no more. `_RADIOSITY` holds `M + ρ E` in W/m², unclamped; where there is a texture,
//! with its mean over the face for ρ. `_ERROR`, where it was asked for, holds the estimated error of E in W/m². Pictures keep the bytes they came in. The primitives of sides
//! that emit say `exitance` (M, W/m²) and `reflectance` in their extras.
//!
//! `COLOR_0` is linear, and float: 8 bits would band in the darks; 16 bits need a fourth component to stay aligned, save a
//! twelfth of the file, and still show steps in a viewer that brightens the picture.

use super::glb::{GlbBuilder, Unlit};
use crate::lit_scene::{LitMesh, LitScene};
use crate::quantity::{Radiance, Rgb};
use crate::scene::{Camera, Material};
use glam::{DMat3, DQuat, DVec3};
use gltf_json as gj;
use gltf_json::mesh::{Mode, Semantic};
use gltf_json::validation::Checked::Valid;
use serde_json::value::{RawValue, to_raw_value};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Near plane of written cameras, as a fraction of the diagonal of the scene: near enough to clip nothing that matters,
/// far enough for a 24-bit depth buffer to tell a thousandth of the scene apart at its far end.
const NEAR_PLANE: f64 = 1e-3;

/// A material of the file: index of the scene's material, and which variant of it.
type Variant = (u32, Look);

/// Variants of a material.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Look {
    /// For sides that reflect and show its texture.
    Textured,
    /// For sides that reflect and have no texture, or no coordinates for it.
    Plain,
    /// For sides that emit.
    Emitting,
}

impl Look {
    fn of(mesh: &LitMesh, material: &Material) -> Self {
        let has_texture = material.texture.is_some() && !mesh.uvs.is_empty();
        match (mesh.exitance.0.is_black(), has_texture) {
            (false, _) => Self::Emitting,
            (true, true) => Self::Textured,
            (true, false) => Self::Plain,
        }
    }
}

/// `lit` as a binary glTF; the same scene gives the same bytes.
///
/// The scene's extras are `lit.extras` with `exposure`, `origin` (metres, in full precision) and `units` beside them.
///
/// # Panics
/// When the file would pass the 4 GiB of its format, or a mesh names a group, material or vertex that is not there.
pub fn write_glb(lit: &LitScene) -> Vec<u8> {
    let mut glb = GlbBuilder::new();
    let mut groups: BTreeMap<u32, BTreeMap<Variant, Vec<&LitMesh>>> = BTreeMap::new();
    for mesh in lit.meshes.iter().filter(|mesh| !mesh.triangles.is_empty()) {
        let look = Look::of(mesh, &lit.materials[mesh.material as usize]);
        let variant = (mesh.material, look);
        let group = groups.entry(mesh.group).or_default();
        group.entry(variant).or_default().push(mesh);
    }

    let used: BTreeMap<Variant, ()> = groups
        .values()
        .flat_map(|parts| parts.keys().map(|&variant| (variant, ())))
        .collect();
    let mut textures = BTreeMap::new();
    for &(material, _) in used.keys() {
        if let Some(index) = lit.materials[material as usize].texture {
            let texture = &lit.textures[index as usize];
            textures
                .entry(index)
                .or_insert_with(|| glb.texture(texture));
        }
    }
    let materials: BTreeMap<Variant, _> = used
        .into_keys()
        .map(|variant| (variant, write_material(&mut glb, lit, variant, &textures)))
        .collect();

    let mut children = Vec::new();
    for (group, parts) in groups {
        let primitives = parts
            .into_iter()
            .map(|(variant, meshes)| {
                let mut primitive = write_primitive(&mut glb, lit, variant, &meshes);
                primitive.material = Some(materials[&variant]);
                primitive
            })
            .collect();
        children.push(glb.mesh_node(&lit.groups[group as usize], primitives));
    }
    let near = near_plane(lit);
    for camera in &lit.cameras {
        children.push(write_camera(&mut glb, camera, lit.origin, near));
    }
    let root = root_node(&mut glb, lit.origin, children);
    glb.finish(root, Some(&scene_extras(lit)))
}

/// The node that moves local coordinates to their place in the world.
///
/// It is written even without children: a scene without nodes is valid, but some readers insist on the list.
pub(super) fn root_node(
    glb: &mut GlbBuilder,
    origin: DVec3,
    children: Vec<gj::Index<gj::Node>>,
) -> gj::Index<gj::Node> {
    glb.node(gj::Node {
        name: Some(String::from("scene")),
        children: (!children.is_empty()).then_some(children),
        translation: (origin != DVec3::ZERO).then(|| to_f32(origin)),
        ..Default::default()
    })
}

fn write_material(
    glb: &mut GlbBuilder,
    lit: &LitScene,
    (material, look): Variant,
    textures: &BTreeMap<u32, gj::Index<gj::Texture>>,
) -> gj::Index<gj::Material> {
    let material = &lit.materials[material as usize];
    let [r, g, b] = match look {
        Look::Emitting => [1.0; 3],
        Look::Textured | Look::Plain => to_f32(material.reflectance.0),
    };
    let is_textured = look == Look::Textured;
    let texture = material.texture.filter(|_| is_textured);
    glb.material(Unlit {
        name: material.name.clone(),
        texture: texture.map(|index| textures[&index]),
        cut_off: material.cut_off.filter(|_| is_textured).map(|c| c as f32),
        base_colour: [r, g, b, 1.0],
    })
}

/// All of `meshes` in one set of vertices, without a material yet.
fn write_primitive(
    glb: &mut GlbBuilder,
    lit: &LitScene,
    (_, look): Variant,
    meshes: &[&LitMesh],
) -> gj::mesh::Primitive {
    let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    let (mut colours, mut radiosities, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    let mut errors: Vec<f32> = Vec::new();
    for mesh in meshes {
        let first =
            u32::try_from(positions.len()).expect("a glTF mesh has fewer than 2³² vertices");
        for (i, &position) in mesh.positions.iter().enumerate() {
            let radiosity = mesh.radiosity(i);
            let shown = if look == Look::Emitting {
                radiosity.to_radiance()
            } else {
                Radiance(mesh.irradiance[i].0 * (1.0 / PI))
            };
            positions.push(to_f32(position));
            normals.push(to_f32(mesh.normal_at(i)));
            colours.push(exposed(shown, lit.exposure));
            radiosities.push(to_f32(radiosity.0.0));
        }
        if look == Look::Textured {
            uvs.extend(mesh.uvs.iter().map(|uv| uv.as_vec2().to_array()));
        }
        errors.extend(mesh.errors.iter().map(|&e| (e as f32).min(f32::MAX)));
        indices.extend(mesh.triangles.as_flattened().iter().map(|i| first + i));
    }
    let mut attributes = BTreeMap::from([
        (Valid(Semantic::Positions), glb.positions(&positions)),
        (Valid(Semantic::Normals), glb.vectors(&normals)),
        (Valid(Semantic::Colors(0)), glb.vectors(&colours)),
        (
            Valid(Semantic::Extras(String::from("RADIOSITY"))),
            glb.vectors(&radiosities),
        ),
    ]);
    if look == Look::Textured {
        attributes.insert(Valid(Semantic::TexCoords(0)), glb.pairs(&uvs));
    }
    if errors.len() == positions.len() {
        let name = Semantic::Extras(String::from("ERROR"));
        attributes.insert(Valid(name), glb.scalars(&errors));
    }
    gj::mesh::Primitive {
        attributes,
        indices: Some(glb.indices(&indices, positions.len())),
        material: None,
        mode: Valid(Mode::Triangles),
        targets: None,
        extensions: None,
        extras: (look == Look::Emitting).then(|| emitter_extras(meshes[0])),
    }
}

/// What a side that emits has of its own: its `COLOR_0` alone does not tell how much of it was reflected.
fn emitter_extras(mesh: &LitMesh) -> Box<RawValue> {
    to_raw_value(&json!({
        "exitance": mesh.exitance.0.to_array(),
        "reflectance": mesh.reflectance.to_array(),
    }))
    .expect("numbers and texts are JSON")
}

/// `radiance × exposure`, clamped to what `COLOR_0` may hold.
fn exposed(radiance: Radiance, exposure: f64) -> [f32; 3] {
    let Rgb(colour) = radiance.0;
    to_f32((colour * exposure).clamp(DVec3::ZERO, DVec3::ONE))
}

/// Rounded to what the file holds; never infinite, since a validator refuses the whole file for one such number.
pub(super) fn to_f32(v: DVec3) -> [f32; 3] {
    debug_assert!(v.is_finite(), "{v} is to be written");
    let limit = DVec3::splat(f64::from(f32::MAX));
    v.clamp(-limit, limit).as_vec3().to_array()
}

fn near_plane(lit: &LitScene) -> f64 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &p in lit.meshes.iter().flat_map(|mesh| &mesh.positions) {
        (low, high) = (low.min(p), high.max(p));
    }
    let diagonal = low.distance(high);
    // Without meshes there is nothing to clip: a metre is as good as any.
    let diagonal = if low.x <= high.x && diagonal > 0.0 {
        diagonal
    } else {
        1.0
    };
    diagonal * NEAR_PLANE
}

/// The camera and its node, relative to `origin`. glTF cameras look along their −z.
fn write_camera(
    glb: &mut GlbBuilder,
    camera: &Camera,
    origin: DVec3,
    near: f64,
) -> gj::Index<gj::Node> {
    let index = glb.camera(gj::Camera {
        name: Some(camera.name.clone()),
        orthographic: None,
        perspective: Some(gj::camera::Perspective {
            aspect_ratio: camera.aspect.map(|aspect| aspect as f32),
            yfov: camera.vertical_fov_rad as f32,
            zfar: None,
            znear: near as f32,
            extensions: None,
            extras: None,
        }),
        type_: Valid(gj::camera::Type::Perspective),
        extensions: None,
        extras: None,
    });
    let back = -camera.forward.normalize();
    let right = camera.up.cross(back).normalize();
    let turn = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)).normalize();
    glb.node(gj::Node {
        camera: Some(index),
        name: Some(camera.name.clone()),
        translation: Some(to_f32(camera.eye - origin)),
        rotation: Some(gj::scene::UnitQuaternion(turn.as_quat().to_array())),
        ..Default::default()
    })
}

fn scene_extras(lit: &LitScene) -> Value {
    let mut extras = match &lit.extras {
        Value::Object(fields) => fields.clone(),
        Value::Null => serde_json::Map::new(),
        other => serde_json::Map::from_iter([(String::from("extras"), other.clone())]),
    };
    extras.insert(String::from("exposure"), json!(lit.exposure));
    extras.insert(String::from("origin"), json!(lit.origin.to_array()));
    let units = json!({ "length": "metres", "radiosity": "W/m²", "exposure": "1/(W m⁻² sr⁻¹)" });
    extras.insert(String::from("units"), units);
    Value::Object(extras)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
pub(crate) mod tests;
