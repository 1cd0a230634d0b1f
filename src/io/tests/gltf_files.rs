//! glTF files that hold what they should.

use super::*;
use crate::quantity::Radiance;
use glam::DVec3;
use serde_json::{Value, json};

/// A document with one triangle (0,0,0) (1,0,0) (0,1,0), indices of 16 bits, one material and a perspective camera, and
/// its 44 bytes: 36 of positions, 6 of indices, 2 of padding.
pub(super) fn triangle() -> (Value, Vec<u8>) {
    let mut bytes = Vec::new();
    for value in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(value.to_le_bytes());
    }
    for index in [0u16, 1, 2, 0] {
        bytes.extend(index.to_le_bytes());
    }
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "room", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "name": "paint", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0.125, 1.0] } }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 8 }
        ],
        "buffers": [{ "byteLength": 44 }]
    });
    (document, bytes)
}

/// A GLB of the two chunks.
pub(super) fn glb(document: &Value, bytes: &[u8]) -> Vec<u8> {
    let glb = gltf::binary::Glb {
        header: gltf::binary::Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        },
        json: serde_json::to_vec(document).unwrap().into(),
        bin: Some(bytes.into()),
    };
    glb.to_vec().unwrap()
}

pub(super) fn read_glb(document: &Value, bytes: &[u8]) -> Result<RawScene, BadInput> {
    read_files(
        "a.glb",
        &[("a.glb", &glb(document, bytes))],
        &ReadSettings::default(),
    )
}

/// The triangle with another value at a JSON pointer; the parent must exist.
pub(super) fn with(changes: &[(&str, Value)]) -> Result<RawScene, BadInput> {
    let (mut document, bytes) = triangle();
    for (pointer, value) in changes {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match document.pointer_mut(parent).unwrap() {
            Value::Array(items) => items[key.parse::<usize>().unwrap()] = value.clone(),
            object => object[key] = value.clone(),
        }
    }
    read_glb(&document, &bytes)
}

fn material(change: Value) -> Material {
    with(&[("/materials/0", change)]).unwrap().materials[0].clone()
}

#[test]
fn a_triangle_is_read() {
    let scene = with(&[]).unwrap();
    assert_eq!(scene.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(scene.polygons[0].corners, [0, 1, 2]);
    assert_eq!(scene.groups, ["room"]);
    assert_eq!(scene.materials[0].reflectance, Rgb::new(0.5, 0.25, 0.125));
    assert!(!scene.materials[0].reflects_back && !scene.materials[0].emits_back);
    assert_eq!(scene.warnings, []);
}

#[test]
fn buffers_come_from_data_uris_and_files() {
    let (mut document, bytes) = triangle();
    document["buffers"][0]["uri"] = json!("my%20data.bin");
    let text = serde_json::to_vec(&document).unwrap();
    let files: [(&str, &[u8]); 2] = [("a.gltf", &text), ("my data.bin", &bytes)];
    assert_eq!(
        read_files("a.gltf", &files, &ReadSettings::default())
            .unwrap()
            .polygons
            .len(),
        1
    );

    let encoded = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAA=";
    document["buffers"][0]["uri"] =
        json!(format!("data:application/octet-stream;base64,{encoded}"));
    let text = serde_json::to_vec(&document).unwrap();
    let scene = read_files("a.gltf", &[("a.gltf", &text)], &ReadSettings::default()).unwrap();
    assert_eq!(scene.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
}

#[test]
fn transforms_multiply_from_the_root_and_mirrors_keep_the_front() {
    let scene = with(&[(
        "/nodes",
        json!([
            { "children": [1], "translation": [10, 0, 0], "rotation": [0, 0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2] },
            { "name": "mirrored", "mesh": 0, "scale": [-2, 1, 1] }
        ]),
    )])
    .unwrap();
    // x · −2, then a quarter turn about z, then +10.
    let expected = [
        DVec3::new(10.0, 0.0, 0.0),
        DVec3::new(10.0, -2.0, 0.0),
        DVec3::new(9.0, 0.0, 0.0),
    ];
    for (found, expected) in scene.positions.iter().zip(expected) {
        assert!(found.distance(expected) < 1e-12, "{found} {expected}");
    }
    assert_eq!(scene.polygons[0].corners, [0, 2, 1]);
    let [a, b, c] = [0, 1, 2].map(|i| scene.positions[scene.polygons[0].corners[i] as usize]);
    assert!((b - a).cross(c - a).z > 0.0);
}

#[test]
fn z_up_turns_positions() {
    let (document, bytes) = triangle();
    let settings = ReadSettings {
        unit: Some(Unit::Inch),
        up: UpAxis::Z,
    };
    let scene = read_files("a.glb", &[("a.glb", &glb(&document, &bytes))], &settings).unwrap();
    assert_eq!(scene.positions, [DVec3::ZERO, DVec3::X, DVec3::NEG_Z]);
    assert!(scene.warnings[0].message.contains("glTF is in metres"));
}

#[test]
fn emissive_strength_multiplies() {
    let emitter = material(json!({
        "emissiveFactor": [1.0, 0.5, 0.25],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 120.0 } }
    }));
    assert_eq!(emitter.emission, Radiance(Rgb::new(120.0, 60.0, 30.0)));
    assert_eq!(emitter.name, "material 0");
    assert_eq!(
        material(json!({ "emissiveFactor": [1, 1, 1] })).emission,
        Radiance(Rgb::grey(1.0))
    );
}

#[test]
fn alpha_decides_what_is_see_through() {
    for (mode, alpha, cutoff, is_see_through) in [
        ("OPAQUE", 0.0, None, false),
        ("BLEND", 0.4, None, true),
        ("BLEND", 0.5, None, false),
        ("MASK", 0.4, None, true),
        ("MASK", 0.5, None, false),
        ("MASK", 0.5, Some(0.6), true),
    ] {
        let mut source = json!({ "alphaMode": mode, "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, alpha] } });
        if let Some(cutoff) = cutoff {
            source["alphaCutoff"] = json!(cutoff);
        }
        assert_eq!(
            material(source).is_see_through,
            is_see_through,
            "{mode} {alpha} {cutoff:?}"
        );
    }
}

#[test]
fn double_sided_materials_reflect_and_emit_on_both_sides() {
    let both = material(json!({ "doubleSided": true }));
    assert!(both.reflects_back && both.emits_back);
}

#[test]
fn a_texture_that_is_not_there_is_warned_of_once() {
    let scene = with(&[
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture",
            json!({ "index": 0 }),
        ),
        ("/textures", json!([{ "source": 0 }])),
        ("/images", json!([{ "uri": "a.png" }])),
        (
            "/nodes",
            json!([{ "mesh": 0, "children": [1] }, { "mesh": 0 }]),
        ),
    ])
    .unwrap();
    assert_eq!(scene.polygons.len(), 2);
    assert_eq!(scene.warnings.len(), 1);
    let message = &scene.warnings[0].message;
    assert!(
        message.contains("\"paint\": its base colour texture cannot be read: its file"),
        "{message}"
    );
    assert_eq!(scene.materials[0].texture, None);
    assert_eq!(scene.groups, ["node 0", "node 1"]);
}

/// The triangle with a texture of one texel beside it, and texture coordinates (0, 0) (1, 0) (0, 1).
fn textured(info: Value) -> RawScene {
    let (mut document, mut bytes) = triangle();
    let picture = crate::io::write_png(&crate::render::Picture {
        width: 1,
        height: 1,
        pixels: vec![[255; 3]],
    });
    for value in [0.0f32, 0.0, 1.0, 0.0, 0.0, 1.0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend(&picture);
    document["buffers"][0]["byteLength"] = json!(bytes.len());
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 0, "byteOffset": 44, "byteLength": 24 }));
    views.push(json!({ "buffer": 0, "byteOffset": 68, "byteLength": picture.len() }));
    let accessors = document["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2" }));
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(2);
    document["images"] = json!([{ "bufferView": 3, "mimeType": "image/png" }]);
    document["samplers"] = json!([{ "wrapS": 33071, "magFilter": 9728 }]);
    document["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = info;
    read_glb(&document, &bytes).unwrap()
}

#[test]
fn a_texture_comes_with_its_coordinates_and_sampler() {
    let scene = textured(json!({ "index": 0, "texCoord": 1 }));
    assert_eq!(scene.warnings, []);
    assert_eq!(
        scene.uvs,
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(glam::DVec2::from)
    );
    assert_eq!(scene.materials[0].texture, Some(0));
    let texture = &scene.textures[0];
    assert_eq!(texture.filters, [Some(9728), None]);
    let wrap = [crate::texture::Wrap::Clamp, crate::texture::Wrap::Repeat];
    assert_eq!(texture.wrap, wrap);
}

/// A quarter turn takes u to −v: counter-clockwise on the picture, where v points down.
#[test]
fn texture_transforms_scale_then_turn_then_move() {
    let scene = textured(
        json!({ "index": 0, "extensions": { "KHR_texture_transform": {
        "texCoord": 1, "offset": [0.25, 0.5], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0]
    } } }),
    );
    let wanted = [[0.25, 0.5], [0.25, -1.5], [3.25, 0.5]].map(glam::DVec2::from);
    for (found, wanted) in scene.uvs.iter().zip(wanted) {
        assert!(found.distance(wanted) < 1e-6, "{found} {wanted}");
    }
}

#[test]
fn faces_without_material_are_grey() {
    let primitive = json!([{ "attributes": { "POSITION": 0 } }]);
    let scene = with(&[
        ("/meshes/0/primitives", primitive),
        ("/meshes/0/name", json!("mesh")),
    ])
    .unwrap();
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials[0].reflectance, Rgb::grey(0.5));
    assert!(
        scene.warnings[0]
            .message
            .contains("1 triangles have no material")
    );
}

#[test]
fn lines_are_left_out_with_a_warning() {
    let scene = with(&[(
        "/meshes/0/primitives",
        json!([
            { "attributes": { "POSITION": 0 }, "mode": 1 },
            { "attributes": { "POSITION": 0 }, "indices": 1, "material": 0, "mode": 5 }
        ]),
    )])
    .unwrap();
    assert_eq!(scene.polygons.len(), 1);
    assert_eq!(
        scene.warnings[0].message,
        "1 primitives of points or lines left out"
    );
}

#[test]
fn sparse_positions_replace_those_of_the_base() {
    let (mut document, mut bytes) = triangle();
    bytes.extend([2, 0, 0, 0]);
    for value in [0.0f32, 7.0, 0.0] {
        bytes.extend(value.to_le_bytes());
    }
    document["buffers"][0]["byteLength"] = json!(60);
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 0, "byteOffset": 44, "byteLength": 4 }));
    views.push(json!({ "buffer": 0, "byteOffset": 48, "byteLength": 12 }));
    document["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": 2, "componentType": 5121 },
        "values": { "bufferView": 3 }
    });
    let scene = read_glb(&document, &bytes).unwrap();
    assert_eq!(
        scene.positions,
        [DVec3::ZERO, DVec3::X, DVec3::new(0.0, 7.0, 0.0)]
    );
}

#[test]
fn cameras_stand_in_the_world() {
    let scene = with(&[
        ("/cameras", json!([
            { "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1, "aspectRatio": 1.5 } },
            { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9 } }
        ])),
        ("/nodes", json!([
            { "mesh": 0, "children": [1, 2] },
            { "name": "view", "camera": 0, "translation": [1, 2, 3], "rotation": [0, std::f32::consts::FRAC_1_SQRT_2, 0, std::f32::consts::FRAC_1_SQRT_2], "scale": [3, 3, 3] },
            { "camera": 1 }
        ])),
    ])
    .unwrap();
    assert_eq!(scene.cameras.len(), 1);
    let camera = &scene.cameras[0];
    assert_eq!(
        (camera.name.as_str(), camera.eye),
        ("view", DVec3::new(1.0, 2.0, 3.0))
    );
    assert!(camera.forward.distance(DVec3::NEG_X) < 1e-12 && camera.up.distance(DVec3::Y) < 1e-12);
    assert_eq!((camera.vertical_fov_rad, camera.aspect), (0.5, Some(1.5)));
    assert_eq!(
        scene.warnings[0].message,
        "1 cameras without perspective left out"
    );
}

#[test]
fn the_first_scene_or_all_roots_stand_in_for_a_default() {
    let two = json!([{ "mesh": 0 }, { "mesh": 0 }]);
    let scenes = json!([{ "nodes": [0] }, { "nodes": [0, 1] }]);
    let count = |changes: &[(&str, Value)]| with(changes).unwrap().polygons.len();
    assert_eq!(
        count(&[
            ("/nodes", two.clone()),
            ("/scenes", scenes.clone()),
            ("/scene", json!(1))
        ]),
        2
    );
    let (mut document, bytes) = triangle();
    document["nodes"] = two;
    document["scenes"] = scenes;
    document.as_object_mut().unwrap().remove("scene");
    assert_eq!(read_glb(&document, &bytes).unwrap().polygons.len(), 1);
    document.as_object_mut().unwrap().remove("scenes");
    assert_eq!(read_glb(&document, &bytes).unwrap().polygons.len(), 2);
}
