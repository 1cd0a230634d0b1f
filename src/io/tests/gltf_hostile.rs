//! glTF files that are broken, by accident or on purpose.

use super::gltf_files::{glb, read_glb, triangle, with};
use super::*;
use serde_json::{Value, json};

fn refusal(changes: &[(&str, Value)]) -> String {
    with(changes).expect_err("must be refused").to_string()
}

#[test]
fn documents_that_lie_are_refused() {
    let cases: Vec<(&str, Value, &str)> = vec![
        ("/nodes/0/children", json!([0]), "reached twice"),
        (
            "/nodes",
            json!([{ "children": [1] }, { "children": [0], "mesh": 0 }]),
            "reached twice",
        ),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "rotation is zero"),
        ("/nodes/0/scale", json!([1e39, 1, 1]), "not finite"),
        ("/nodes/0/mesh", json!(7), "invalid glTF"),
        ("/scene", json!(7), "invalid glTF"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(7),
            "attributes.POSITION: accessor 7 is not there",
        ),
        (
            "/accessors/0/componentType",
            json!(5122),
            "stored as I16 Vec3",
        ),
        ("/accessors/0/type", json!("VEC2"), "stored as F32 Vec2"),
        (
            "/accessors/1/componentType",
            json!(5126),
            "stored as F32 Scalar",
        ),
        ("/accessors/0/count", json!(0), "accessor 0: its 0 elements"),
        ("/accessors/0/count", json!(4), "do not lie within"),
        ("/accessors/0/count", json!(u64::MAX), "do not lie within"),
        (
            "/accessors/0/byteOffset",
            json!(u64::MAX - 3),
            "do not lie within",
        ),
        ("/accessors/1/count", json!(5), "do not lie within"),
        ("/bufferViews/0/byteStride", json!(4), "do not lie within"),
        (
            "/bufferViews/1/byteOffset",
            json!(u64::MAX - 3),
            "do not lie within",
        ),
        (
            "/buffers/0/byteLength",
            json!(45),
            "44 bytes of the promised 45",
        ),
        (
            "/buffers/0/uri",
            json!("../secret.bin"),
            "refers to \"../secret.bin\"",
        ),
        ("/buffers/0/uri", json!("/etc/hostname"), "refers to"),
        (
            "/buffers/0/uri",
            json!("https://example.org/a.bin"),
            "refers to",
        ),
        (
            "/buffers/0/uri",
            json!("gone.bin"),
            "gone.bin: cannot be read",
        ),
        (
            "/buffers/0/uri",
            json!("data:;base64,@@"),
            "not valid base64",
        ),
        (
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            json!([1.5, 0, 0, 1]),
            "\"paint\" has reflectance [1.5",
        ),
        ("/materials/0/emissiveFactor", json!([-1, 0, 0]), "negative"),
        (
            "/materials/0/emissiveFactor",
            json!([1e39, 0, 0]),
            "not finite",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "requires KHR_draco_mesh_compression",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_mesh_quantization", "EXT_meshopt_compression"]),
            "requires EXT_meshopt_compression, which",
        ),
        ("/asset/version", json!(7), "cannot be read as glTF 2.0"),
        ("/nodes/0", json!({}), "no faces"),
    ];
    for (pointer, value, expected) in cases {
        let error = refusal(&[(pointer, value.clone())]);
        assert!(error.starts_with("a.glb"), "{pointer}: {error}");
        assert!(error.contains(expected), "{pointer} = {value}: {error}");
    }
}

#[test]
fn positions_that_are_not_finite_are_refused() {
    let (document, mut bytes) = triangle();
    bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = read_glb(&document, &bytes).unwrap_err().to_string();
    assert!(
        error.contains("node 0: the position of vertex 1 is not finite"),
        "{error}"
    );
}

#[test]
fn indices_out_of_range_are_refused() {
    let (document, mut bytes) = triangle();
    bytes[38] = 9;
    let error = read_glb(&document, &bytes).unwrap_err().to_string();
    assert!(
        error.contains("index 9 is out of range (3 vertices)"),
        "{error}"
    );
}

#[test]
fn sparse_zeros_cannot_fill_the_memory() {
    let (mut document, bytes) = triangle();
    document["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    document["accessors"][0]["count"] = json!(1u64 << 40);
    document["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": 1, "componentType": 5123 },
        "values": { "bufferView": 0 }
    });
    let error = read_glb(&document, &bytes).unwrap_err().to_string();
    assert!(error.contains("do not lie within"), "{error}");
}

#[test]
fn every_truncation_of_a_glb_is_refused() {
    let (document, bytes) = triangle();
    let whole = glb(&document, &bytes);
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("a.glb");
    for length in 0..whole.len() {
        replace_file(&path, &whole[..length]);
        assert!(
            read_scene(&path, &ReadSettings::default()).is_err(),
            "{length}"
        );
    }
}

#[test]
fn flipped_bytes_and_changed_numbers_never_panic() {
    let (document, bytes) = triangle();
    let whole = glb(&document, &bytes);
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("a.glb");
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let digits: Vec<usize> = (20..whole.len() - 52)
        .filter(|&i| whole[i].is_ascii_digit())
        .collect();
    let mut refused = 0;
    for round in 0..6000 {
        let mut mutated = whole.clone();
        for _ in 0..=random.below(3) {
            if round % 2 == 0 {
                let at = random.below(mutated.len());
                mutated[at] ^= 1 << random.below(8);
            } else {
                // A digit for a digit keeps the JSON whole, so that the damage reaches what reads it.
                mutated[digits[random.below(digits.len())]] = b'0' + random.below(10) as u8;
            }
        }
        replace_file(&path, &mutated);
        match read_scene(&path, &ReadSettings::default()) {
            Ok(scene) => check_indices(&scene),
            Err(_) => refused += 1,
        }
    }
    assert!(
        refused > 1000,
        "only {refused} of 6000 were refused: the mutations reach nothing"
    );
}
