//! Whole files that use all that the readers know, to be broken.

use super::Files;
use glam::DVec3;
use serde_json::{Value, json};
use umbrage::io::write_glb;
use umbrage::lit_scene::{LitMesh, LitScene};
use umbrage::quantity::{Irradiance, Rgb};
use umbrage::scene::{Camera, Material};
use umbrage::texture::Texture;

/// A PNG of 4 × 4 texels.
pub(super) fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 4);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let data: Vec<u8> = (0..64).map(|i| (i * 37) as u8 | 128).collect();
    let mut writer = encoder.write_header().expect("a PNG has a header");
    writer.write_image_data(&data).expect("16 texels");
    drop(writer);
    bytes
}

/// A glTF document and the bytes of its buffer.
#[derive(Clone)]
pub(super) struct Document {
    pub(super) json: Value,
    pub(super) bytes: Vec<u8>,
}

impl Document {
    /// As a GLB.
    pub(super) fn glb(&self) -> Vec<u8> {
        let json = serde_json::to_vec(&self.json).expect("a JSON value has a text");
        glb(&json, &self.bytes)
    }

    pub(super) fn files(&self) -> Files {
        Files {
            files: vec![("a.glb".to_owned(), self.glb())],
        }
    }

    /// Adds a view and an accessor over new bytes; returns the index of the accessor.
    fn add(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        let view = self.view(bytes);
        let accessors = self.json["accessors"].as_array_mut().expect("a list");
        accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind
        }));
        accessors.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let views = self.json["bufferViews"].as_array_mut().expect("a list");
        views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }));
        views.len() - 1
    }
}

/// A GLB of two chunks.
pub(super) fn glb(json: &[u8], bytes: &[u8]) -> Vec<u8> {
    let glb = gltf::binary::Glb {
        header: gltf::binary::Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        },
        json: json.into(),
        bin: Some(bytes.into()),
    };
    glb.to_vec().expect("memory takes every byte")
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A square with normals, a texture, a skin, morph targets, sparse positions and instances, beside a quantized triangle,
/// a lamp, lights and cameras.
pub(super) fn document() -> Document {
    let mut d = Document {
        json: json!({
            "asset": { "version": "2.0" },
            "extensionsUsed": ["KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_lights_punctual",
                "KHR_texture_transform", "KHR_materials_transmission", "KHR_materials_emissive_strength"],
            "extensionsRequired": ["KHR_mesh_quantization"],
            "accessors": [], "bufferViews": [], "buffers": [{ "byteLength": 0 }]
        }),
        bytes: Vec::new(),
    };
    let positions = floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    let position = d.add(&positions, 5126, 4, "VEC3");
    let normal = d.add(&floats(&[0., 0., 1.].repeat(4)), 5126, 4, "VEC3");
    let uv = d.add(&floats(&[0., 0., 1., 0., 1., 1., 0., 1.]), 5126, 4, "VEC2");
    let indices: Vec<u8> = [0u16, 1, 2, 0, 2, 3]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    let index = d.add(&indices, 5123, 6, "SCALAR");
    let moved = d.add(&floats(&[0., 0., 0.5].repeat(4)), 5126, 4, "VEC3");
    let joints = d.add(&[0, 1, 0, 0].repeat(4), 5121, 4, "VEC4");
    let weights = d.add(&floats(&[0.5, 0.5, 0., 0.].repeat(4)), 5126, 4, "VEC4");
    let identity = [
        1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.,
    ];
    let bind = d.add(&floats(&identity.repeat(2)), 5126, 2, "MAT4");
    let small: Vec<u8> = [0i16, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let small = d.add(&small, 5122, 3, "VEC3");
    d.json["bufferViews"][8]["byteStride"] = json!(8);
    let places = d.add(&floats(&[0., 0., 2., 0., 3., 2.]), 5126, 2, "VEC3");
    let turns = d.add(&floats(&[0., 0., 0., 1., 0., 1., 0., 0.]), 5126, 2, "VEC4");
    let (sparse_index, sparse_value) = (d.view(&[1, 0, 0, 0]), d.view(&floats(&[2., 0., 0.])));
    let picture = d.view(&png());
    let limits = [
        (position, [0., 0., 0.], [2., 1., 0.]),
        (small, [0., 0., 0.], [9., 9., 0.]),
    ];
    for (accessor, low, high) in limits {
        d.json["accessors"][accessor]["min"] = json!(low);
        d.json["accessors"][accessor]["max"] = json!(high);
    }
    d.json["accessors"][position]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": sparse_index, "componentType": 5121 },
        "values": { "bufferView": sparse_value }
    });
    d.json["buffers"][0]["byteLength"] = json!(d.bytes.len());
    let square = json!({ "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv,
        "JOINTS_0": joints, "WEIGHTS_0": weights });
    let parts = json!({
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2, 3, 4, 5] }, { "nodes": [0] }],
        "nodes": [
            { "name": "square", "mesh": 0, "skin": 0, "children": [6], "weights": [0.5] },
            { "mesh": 1, "translation": [0, 0, 3], "scale": [1, -1, 1] },
            { "mesh": 1, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places, "ROTATION": turns } } } },
            { "camera": 0, "matrix": identity },
            { "camera": 1, "rotation": [0, 0, 0, 1] },
            { "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "name": "joint", "children": [7] },
            { "extensions": { "KHR_lights_punctual": { "light": 1 } } }
        ],
        "skins": [{ "joints": [6, 7], "inverseBindMatrices": bind }],
        "cameras": [
            { "type": "perspective", "perspective": { "yfov": 0.6, "znear": 0.1, "aspectRatio": 1.5 } },
            { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9 } }
        ],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "spot", "color": [1, 0.5, 0.2], "intensity": 8, "range": 5, "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.5 } },
            { "type": "directional" }
        ] } },
        "meshes": [
            { "primitives": [{ "attributes": square, "indices": index, "material": 0, "targets": [{ "POSITION": moved }] }], "weights": [0.25] },
            { "primitives": [
                { "attributes": { "POSITION": small }, "material": 1, "mode": 5 },
                { "attributes": { "POSITION": small }, "mode": 6 },
                { "attributes": { "POSITION": small }, "mode": 1 }
            ] }
        ],
        "materials": [
            { "name": "paper", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25, "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 0.125, 1], "baseColorTexture": { "index": 0, "texCoord": 0,
                "extensions": { "KHR_texture_transform": { "offset": [0.5, 0], "rotation": 0.3, "scale": [2, 3] } } } } },
            { "name": "lamp", "emissiveFactor": [1, 1, 1], "extensions": {
                "KHR_materials_emissive_strength": { "emissiveStrength": 7 }, "KHR_materials_transmission": { "transmissionFactor": 0.1 } } }
        ],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987 }],
        "images": [{ "bufferView": picture, "mimeType": "image/png" }]
    });
    let Value::Object(parts) = parts else {
        unreachable!("an object was written")
    };
    d.json.as_object_mut().expect("an object").extend(parts);
    d
}

/// An OBJ with a library and a texture.
pub(super) fn obj() -> Files {
    let obj = "# a room\nmtllib a.mtl\no floor\nv 0 0 0\nv 0 0 2 1 0 0\nv 2 0 2\nv 2 0 0\nvt 0 0\nvt 0 1\nvt 1 1\n\
               vt 1 0\nvn 0 1 0\nvn 0.6 0.8 0\nusemtl tiles\ns 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\ng lamp\nv 0 1 0\nv 1 1 0\n\
               v 1 1 1\nv 0 1 \\\n 1\nusemtl lamp\nf -4//2 -3//2 -2//2 -1//2\nusemtl none\nf 1 2 7\nl 1 2\np 3\n";
    let mtl = "newmtl tiles\nKd 0.5 0.5 0.5\nmap_Kd -s 2 2 -clamp on a.png\nmap_d a.png\nd 1\nnewmtl lamp\nKd 0\n\
               Ke 9 8 7\nTr 0\nillum 2\nmap_Ke a.png\n";
    Files {
        files: vec![
            ("a.obj".to_owned(), obj.as_bytes().to_vec()),
            ("a.mtl".to_owned(), mtl.as_bytes().to_vec()),
            ("a.png".to_owned(), png()),
        ],
    }
}

/// A lit file with a texture and a camera.
pub(super) fn lit() -> Vec<u8> {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let mesh = LitMesh {
        normal: DVec3::Z,
        positions: corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
        uvs: corners.map(glam::DVec2::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        irradiance: vec![Irradiance(Rgb::grey(2.0)); 4],
        ..LitMesh::default()
    };
    write_glb(&LitScene {
        origin: DVec3::new(1.0, 2.0, 3.0),
        materials: vec![Material {
            name: "paper".to_owned(),
            texture: Some(0),
            cut_off: Some(0.5),
            ..Material::default()
        }],
        textures: vec![Texture::new("a", png()).expect("a whole picture")],
        groups: vec!["all".to_owned()],
        cameras: vec![Camera {
            name: "door".to_owned(),
            eye: DVec3::Z,
            forward: DVec3::NEG_Z,
            up: DVec3::Y,
            vertical_fov_rad: 0.6,
            aspect: Some(1.5),
        }],
        meshes: vec![mesh],
        exposure: 1.0,
        extras: json!({ "settings": {} }),
    })
}
