//! What newer exporters write: quantized attributes, instances, skins, morph targets, lights, other materials.

use super::gltf_files::{read_glb, triangle};
use super::*;
use crate::quantity::Radiance;
use crate::scene::{PunctualKind, PunctualLight};
use glam::DVec3;
use serde_json::{Value, json};

/// The triangle, to which more bytes and accessors are added.
struct Growing {
    document: Value,
    bytes: Vec<u8>,
}

impl Growing {
    fn new() -> Self {
        let (document, bytes) = triangle();
        Self { document, bytes }
    }

    /// Index of a new accessor over new bytes; `more` holds its other fields.
    fn add(&mut self, bytes: &[u8], more: Value) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let views = self.document["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }));
        let mut accessor = more;
        accessor["bufferView"] = json!(views.len() - 1);
        self.document["buffers"][0]["byteLength"] = json!(self.bytes.len());
        let accessors = self.document["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], count: usize, kind: &str) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(
            &bytes,
            json!({ "componentType": 5126, "count": count, "type": kind }),
        )
    }

    fn read(&self) -> RawScene {
        read_glb(&self.document, &self.bytes).unwrap()
    }
}

fn close(found: &[DVec3], wanted: &[[f64; 3]]) {
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().zip(wanted) {
        let wanted = DVec3::from(*wanted);
        assert!(found.distance(wanted) < 1e-6, "{found} {wanted}");
    }
}

/// 16-bit positions, once as they stand and once as fractions, with a stride; 8-bit normals.
#[test]
fn quantized_attributes_are_what_they_stand_for() {
    for (is_normalized, unit) in [(false, 1.0), (true, 1.0 / 32767.0)] {
        let mut g = Growing::new();
        let positions: Vec<u8> = [[0i16, 0, 0, 9], [16384, 0, 0, 9], [0, -32767, 0, 9]]
            .concat()
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let position = g.add(
            &positions,
            json!({ "componentType": 5122, "count": 3, "type": "VEC3", "normalized": is_normalized,
                "min": [0, -32767, 0], "max": [16384, 0, 0] }),
        );
        g.document["bufferViews"][2]["byteStride"] = json!(8);
        let normals = [[0u8, 0, 0x81, 0], [0, 0, 0x81, 0], [90, 0, 0xa6, 0]].concat();
        let normal = g.add(
            &normals,
            json!({ "componentType": 5120, "count": 3, "type": "VEC3", "normalized": true }),
        );
        g.document["bufferViews"][3]["byteStride"] = json!(4);
        g.document["meshes"][0]["primitives"][0]["attributes"] =
            json!({ "POSITION": position, "NORMAL": normal });
        g.document["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        g.document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let scene = g.read();
        let wanted = [
            [0.0; 3],
            [16384.0 * unit, 0.0, 0.0],
            [0.0, -32767.0 * unit, 0.0],
        ];
        close(&scene.positions, &wanted);
        let slant = std::f64::consts::FRAC_1_SQRT_2;
        close(
            &scene.normals,
            &[[0.0, 0.0, -1.0], [0.0, 0.0, -1.0], [slant, 0.0, -slant]],
        );
    }
}

#[test]
fn instances_stand_where_their_lists_say() {
    let mut g = Growing::new();
    let moves = g.floats(&[5., 0., 0., 0., 6., 0.], 2, "VEC3");
    let scales = g.floats(&[1., 1., 1., 2., 2., 2.], 2, "VEC3");
    // No turn, then half a turn about z, as normalised 16-bit integers.
    let turns: Vec<u8> = [0i16, 0, 0, 32767, 0, 0, 32767, 0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let turns = g.add(
        &turns,
        json!({ "componentType": 5122, "count": 2, "type": "VEC4", "normalized": true }),
    );
    g.document["nodes"][0]["translation"] = json!([0, 0, 1]);
    g.document["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": {
        "TRANSLATION": moves, "SCALE": scales, "ROTATION": turns
    } } });
    g.document["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    g.document["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = g.read();
    assert_eq!((scene.polygons.len(), scene.groups.len()), (2, 1));
    close(
        &scene.positions,
        &[
            [5., 0., 1.],
            [6., 0., 1.],
            [5., 1., 1.],
            [0., 6., 1.],
            [-2., 6., 1.],
            [0., 4., 1.],
        ],
    );
}

/// Two joints 1 m apart, of which the second is turned a quarter; the corners hang on the first, on both, on the second.
#[test]
fn skins_are_posed_by_their_joints_and_not_by_their_node() {
    let mut g = Growing::new();
    let joints = g.add(
        &[0, 1, 0, 0].repeat(3),
        json!({ "componentType": 5121, "count": 3, "type": "VEC4" }),
    );
    let weights = g.floats(
        &[1., 0., 0., 0., 0.5, 0.5, 0., 0., 0., 1., 0., 0.],
        3,
        "VEC4",
    );
    let mut bind = [0.0f32; 32];
    for joint in 0..2 {
        for i in 0..4 {
            bind[16 * joint + 5 * i] = 1.0;
        }
    }
    // The second joint was bound at y = 1.
    bind[16 + 13] = -1.0;
    let bind = g.floats(&bind, 2, "MAT4");
    let half = std::f32::consts::FRAC_1_SQRT_2;
    g.document["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": bind }]);
    g.document["scenes"][0]["nodes"] = json!([0, 1]);
    g.document["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [100, 0, 0] },
        { "children": [2], "translation": [10, 0, 0] },
        { "translation": [0, 1, 0], "rotation": [0, 0, half, half] }
    ]);
    let attributes = &mut g.document["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    let scene = g.read();
    // (1, 0, 0) by the first joint is (11, 0, 0); by the second, (1, −1, 0) turned is (1, 1, 0), then + (10, 1, 0).
    close(
        &scene.positions,
        &[[10., 0., 0.], [11., 1., 0.], [10., 1., 0.]],
    );
    assert_eq!(scene.warnings, []);
}

#[test]
fn morph_targets_move_by_the_weights_of_the_node_or_else_of_the_mesh() {
    let mut g = Growing::new();
    let up = g.floats(&[0., 0., 4.].repeat(3), 3, "VEC3");
    let aside = g.floats(&[8., 0., 0., 0., 0., 0., 0., 0., 0.], 3, "VEC3");
    g.document["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": up }, { "POSITION": aside }]);
    g.document["meshes"][0]["weights"] = json!([0.5, 0.0]);
    close(
        &g.read().positions,
        &[[0., 0., 2.], [1., 0., 2.], [0., 1., 2.]],
    );
    g.document["nodes"][0]["weights"] = json!([0.0, 0.25]);
    close(
        &g.read().positions,
        &[[2., 0., 0.], [1., 0., 0.], [0., 1., 0.]],
    );
}

#[test]
fn punctual_lights_are_listed_in_the_world() {
    let mut g = Growing::new();
    g.document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    g.document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "name": "desk", "color": [1, 0.5, 0.25], "intensity": 8, "range": 5,
          "spot": { "innerConeAngle": 0.125, "outerConeAngle": 0.5 } },
        { "type": "directional", "intensity": 3 },
        { "type": "point" }
    ] } });
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let light = |i| json!({ "KHR_lights_punctual": { "light": i } });
    g.document["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    g.document["nodes"] = json!([
        { "mesh": 0 },
        { "translation": [1, 2, 3], "rotation": [-half, 0, 0, half], "extensions": light(0) },
        { "name": "sun", "extensions": light(1) },
        { "scale": [0, 1, 1], "extensions": light(2) }
    ]);
    let scene = g.read();
    assert_eq!(scene.lights.len(), 3);
    let desk = &scene.lights[0];
    assert!(desk.direction.distance(DVec3::NEG_Y) < 1e-7);
    let wanted = PunctualLight {
        name: "desk".to_owned(),
        kind: PunctualKind::Spot {
            inner_angle_rad: 0.125,
            outer_angle_rad: 0.5,
        },
        position: DVec3::new(1.0, 2.0, 3.0),
        direction: desk.direction,
        intensity: Rgb::new(8.0, 4.0, 2.0) * (1.0 / 683.0),
        range: Some(5.0),
    };
    assert_eq!(*desk, wanted);
    let sun = &scene.lights[1];
    assert_eq!(
        (sun.name.as_str(), sun.kind),
        ("sun", PunctualKind::Directional)
    );
    assert_eq!(
        (sun.direction, sun.intensity),
        (DVec3::NEG_Z, Rgb::grey(3.0 / 683.0))
    );
    let names = scene.warnings.iter().map(|w| &w.message);
    assert!(names.clone().all(|m| !m.contains("KHR_lights_punctual")));
}

#[test]
fn other_kinds_of_materials_have_a_diffuse_part() {
    let read = |material: Value| {
        let mut g = Growing::new();
        g.document["materials"][0] = material;
        g.read().materials[0].clone()
    };
    let older = read(
        json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.25, 0.5, 0.75, 1], "specularFactor": [1, 1, 1] } } }),
    );
    assert_eq!(older.reflectance, Rgb::new(0.25, 0.5, 0.75));
    let glass = |factor: f64| {
        read(
            json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": factor } } }),
        )
    };
    assert!(glass(0.9).is_see_through && !glass(0.4).is_see_through);
    let coated = read(json!({ "emissiveFactor": [1, 1, 1], "extensions": {
        "KHR_materials_unlit": {}, "KHR_materials_specular": { "specularFactor": 0.5 }, "KHR_materials_clearcoat": {} } }));
    assert_eq!(coated.emission, Radiance(Rgb::grey(1.0)));
}

#[test]
fn the_default_scene_alone_is_read_with_its_cameras() {
    let mut g = Growing::new();
    g.document["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    g.document["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "children": [2] }, { "camera": 0 }]);
    g.document["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }]);
    g.document["scene"] = json!(1);
    let scene = g.read();
    assert_eq!((scene.polygons.len(), scene.cameras.len()), (1, 1));
    g.document["scene"] = json!(0);
    assert_eq!(g.read().cameras.len(), 0);
}

/// A WebP of 1 × 1 texels, lossless, of one colour: its header, and five codes of one symbol each.
#[test]
fn a_webp_texture_is_read_by_its_extension() {
    let (red, green, blue) = (200u8, 100u8, 50u8);
    let mut bits = Bits::default();
    bits.put(0x2f, 8);
    bits.put(0, 14); // width − 1
    bits.put(0, 14);
    bits.put(0, 1); // opaque
    bits.put(0, 3); // version
    bits.put(0, 1); // no transform
    bits.put(0, 1); // no colour cache
    bits.put(0, 1); // one set of codes
    for symbol in [green, red, blue, 255, 0] {
        bits.put(1, 1); // a simple code
        bits.put(0, 1); // of one symbol
        bits.put(1, 1); // of eight bits
        bits.put(u32::from(symbol), 8);
    }
    let mut chunk = bits.bytes;
    let length = chunk.len() as u32;
    chunk.resize(chunk.len().next_multiple_of(2), 0);
    let mut webp = b"RIFF".to_vec();
    webp.extend((chunk.len() as u32 + 12).to_le_bytes());
    webp.extend(b"WEBPVP8L");
    webp.extend(length.to_le_bytes());
    webp.extend(&chunk);

    let mut g = Growing::new();
    let uv = g.floats(&[0., 0., 1., 0., 0., 1.], 3, "VEC2");
    g.add(
        &webp,
        json!({ "componentType": 5121, "count": 1, "type": "SCALAR" }),
    );
    let view = g.document["bufferViews"].as_array().unwrap().len() - 1;
    g.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    g.document["images"] = json!([{ "bufferView": view, "mimeType": "image/webp" }]);
    g.document["textures"] = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    g.document["extensionsUsed"] = json!(["EXT_texture_webp"]);
    g.document["extensionsRequired"] = json!(["EXT_texture_webp"]);
    g.document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    let scene = g.read();
    assert_eq!(scene.warnings, []);
    assert_eq!(scene.textures[0].texels.rgba, [[red, green, blue, 255]]);
}

/// Bits from the lowest on.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    used: u32,
}

impl Bits {
    fn put(&mut self, value: u32, count: u32) {
        for i in 0..count {
            if self.used.is_multiple_of(8) {
                self.bytes.push(0);
            }
            let last = self.bytes.last_mut().unwrap();
            *last |= ((value >> i & 1) as u8) << (self.used % 8);
            self.used += 1;
        }
    }
}

/// The emissive texture follows the coordinates of the base colour's, or is left out with a warning.
#[test]
fn emissive_textures_need_the_coordinates_of_the_base_colour() {
    let picture = crate::io::write_png(&crate::render::Picture {
        width: 1,
        height: 1,
        pixels: vec![[255; 3]],
    });
    for (set, is_read) in [(0, true), (1, false)] {
        let mut g = Growing::new();
        let uv = g.floats(&[0., 0., 1., 0., 0., 1.], 3, "VEC2");
        g.add(
            &picture,
            json!({ "componentType": 5121, "count": 1, "type": "SCALAR" }),
        );
        let view = g.document["bufferViews"].as_array().unwrap().len() - 1;
        g.document["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
        g.document["textures"] = json!([{ "source": 0 }]);
        g.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
        let material = &mut g.document["materials"][0];
        material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
        material["emissiveTexture"] = json!({ "index": 0, "texCoord": set });
        material["emissiveFactor"] = json!([1, 1, 1]);
        let scene = g.read();
        assert_eq!(scene.materials[0].emission_texture.is_some(), is_read);
        assert_eq!(scene.warnings.len(), usize::from(!is_read));
        assert_eq!((scene.textures.len(), scene.uvs.len()), (1, 3));
    }
}
