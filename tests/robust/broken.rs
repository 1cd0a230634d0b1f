//! Files broken by rule: every value of a document by every kind of wrong one, every field of a header, every word of a
//! text. The kinds are those that the test suites of validators hold.

use super::pictures::{BASELINE_JPEG, GREY_JPEG, LOSSY_WEBP, PROGRESSIVE_JPEG};
use super::seeds::{self, Document};
use super::{Bench, Files, Outcome};
use serde_json::{Value, json};

/// What may stand where something else should.
fn wrong_values() -> Vec<Value> {
    vec![
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(0.5),
        json!(7),
        json!(99_999),
        json!(u32::MAX),
        json!(1u64 << 40),
        json!(u64::MAX),
        json!(1e39),
        json!(-1e300),
        json!(""),
        json!("NaN"),
        json!("../../etc/passwd"),
        json!("data:;base64,AAAA"),
        json!([]),
        json!([0, 0, 0, 0, 0]),
        json!({}),
        json!({ "a": 1 }),
    ]
}

/// JSON pointers to all values below `value`.
pub(super) fn pointers(value: &Value) -> Vec<String> {
    let mut all = Vec::new();
    let mut open = vec![(String::new(), value)];
    while let Some((path, value)) = open.pop() {
        match value {
            Value::Object(fields) => {
                open.extend(fields.iter().map(|(k, v)| (format!("{path}/{k}"), v)));
            }
            Value::Array(items) => {
                let numbered = items.iter().enumerate();
                open.extend(numbered.map(|(i, v)| (format!("{path}/{i}"), v)));
            }
            _ => {}
        }
        if !path.is_empty() {
            all.push(path);
        }
    }
    all.sort();
    all
}

/// Removes the value at a pointer from its parent.
pub(super) fn remove(json: &mut Value, pointer: &str) {
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer has a parent");
    match json.pointer_mut(parent) {
        Some(Value::Object(fields)) => drop(fields.remove(key)),
        Some(Value::Array(items)) => drop(items.remove(key.parse().expect("an index"))),
        _ => {}
    }
}

/// Counts the cases and what became of them.
#[derive(Default)]
struct Tally {
    read: usize,
    refused: usize,
}

impl Tally {
    fn count(&mut self, outcome: Outcome) {
        match outcome {
            Outcome::Read => self.read += 1,
            Outcome::Refused => self.refused += 1,
        }
    }

    /// Enough cases, and enough of both kinds that the rules reach something and the seed was whole.
    fn check(&self, cases: usize) {
        let (read, refused) = (self.read, self.refused);
        assert!(read + refused >= cases, "{read} read, {refused} refused");
        assert!(
            read * 20 >= cases && refused * 20 >= cases,
            "{read} read, {refused} refused"
        );
    }
}

#[test]
fn the_seeds_are_whole() {
    let bench = Bench::new();
    assert_eq!(
        bench.scene(&seeds::document().files(), "glTF"),
        Outcome::Read
    );
    assert_eq!(bench.scene(&seeds::obj(), "OBJ"), Outcome::Read);
    assert_eq!(bench.lit(&seeds::lit(), "lit"), Outcome::Read);
}

#[test]
fn every_value_of_a_gltf_may_be_wrong() {
    let (bench, seed, mut tally) = (Bench::new(), seeds::document(), Tally::default());
    for pointer in pointers(&seed.json) {
        let mut gone = seed.clone();
        remove(&mut gone.json, &pointer);
        tally.count(bench.scene(&gone.files(), &format!("{pointer} removed")));
        for value in wrong_values() {
            let case = format!("{pointer} = {value}");
            let mut wrong = seed.clone();
            *wrong
                .json
                .pointer_mut(&pointer)
                .expect("a pointer of the seed") = value;
            tally.count(bench.scene(&wrong.files(), &case));
        }
    }
    tally.check(5000);
}

#[test]
fn every_value_of_a_lit_file_may_be_wrong() {
    let (bench, seed, mut tally) = (Bench::new(), seeds::lit(), Tally::default());
    let glb = gltf::binary::Glb::from_slice(&seed).expect("our own file");
    let json: Value = serde_json::from_slice(&glb.json).expect("our own JSON");
    let bytes = glb.bin.expect("our own buffer").to_vec();
    for pointer in pointers(&json) {
        for value in wrong_values() {
            let case = format!("{pointer} = {value}");
            let mut wrong = Document {
                json: json.clone(),
                bytes: bytes.clone(),
            };
            *wrong
                .json
                .pointer_mut(&pointer)
                .expect("a pointer of the seed") = value;
            tally.count(bench.lit(&wrong.glb(), &case));
        }
    }
    tally.check(2000);
}

#[test]
fn every_word_of_a_glb_frame_may_be_wrong() {
    let (bench, seed) = (Bench::new(), seeds::document().glb());
    let json_length = u32::from_le_bytes([seed[12], seed[13], seed[14], seed[15]]) as usize;
    let bin = 20 + json_length;
    let (magic, version, length) = (0, 4, 8);
    let words = [magic, version, length, 12, 16, bin, bin + 4];
    let values = [
        0,
        1,
        3,
        11,
        12,
        19,
        20,
        0x7fff_ffff,
        0x8000_0000,
        u32::MAX - 3,
        u32::MAX,
    ];
    let mut refused = 0;
    for at in words {
        for value in values {
            let mut wrong = seed.clone();
            wrong[at..at + 4].copy_from_slice(&value.to_le_bytes());
            let files = Files {
                files: vec![("a.glb".to_owned(), wrong.clone())],
            };
            let case = format!("word at {at} = {value}");
            refused += usize::from(bench.scene(&files, &case) == Outcome::Refused);
            bench.lit(&wrong, &case);
        }
    }
    assert!(refused > 60, "only {refused} refused");
    for cut in (0..seed.len()).step_by(7) {
        let files = Files {
            files: vec![("a.glb".to_owned(), seed[..cut].to_vec())],
        };
        assert_eq!(
            bench.scene(&files, &format!("cut at {cut}")),
            Outcome::Refused
        );
    }
}

#[test]
fn graphs_that_are_no_trees_are_refused() {
    let bench = Bench::new();
    let cycles = [
        json!([{ "children": [0] }]),
        json!([{ "children": [1] }, { "children": [0] }]),
        json!([{ "children": [1, 1] }, {}]),
        json!([{ "children": [1, 2] }, { "children": [2] }, {}]),
        // A long chain must not use up the stack, and ends in a cycle.
        Value::Array(
            (0..20_000)
                .map(|i| json!({ "children": [(i + 1) % 20_000] }))
                .collect(),
        ),
    ];
    for (i, nodes) in cycles.into_iter().enumerate() {
        let mut document = seeds::document();
        document.json["nodes"] = nodes;
        document.json["scenes"] = json!([{ "nodes": [0] }]);
        document
            .json
            .as_object_mut()
            .expect("an object")
            .remove("skins");
        assert_eq!(
            bench.scene(&document.files(), &format!("cycle {i}")),
            Outcome::Refused
        );
    }
}

#[test]
fn every_word_of_an_obj_may_be_wrong() {
    let (bench, seed, mut tally) = (Bench::new(), seeds::obj(), Tally::default());
    let words = [
        "",
        "nan",
        "inf",
        "-1",
        "0",
        "1e999",
        "1e308",
        "99999999999999999999",
        "-99999999999999999999",
        "1/2/3/4",
        "//",
        "/",
        "-",
        "\\",
        "#",
        "\u{0}",
        "é",
        "..",
        "1,5",
        "0x10",
    ];
    for file in [0, 1] {
        let text = String::from_utf8(seed.files[file].1.clone()).expect("our own text");
        let lines: Vec<&str> = text.split('\n').collect();
        for (i, line) in lines.iter().enumerate() {
            let parts: Vec<&str> = line.split(' ').collect();
            for (j, word) in (0..parts.len()).flat_map(|j| words.map(|word| (j, word))) {
                let mut parts = parts.clone();
                parts[j] = word;
                let line = parts.join(" ");
                let mut lines = lines.clone();
                lines[i] = &line;
                let mut files = seed.clone();
                files.files[file].1 = lines.join("\n").into_bytes();
                tally.count(bench.scene(&files, &format!("file {file} line {}: {line}", i + 1)));
            }
        }
    }
    tally.check(2000);
}

/// A damaged picture costs its texture, never the scene.
#[test]
fn every_byte_of_a_picture_may_be_wrong() {
    let (bench, seed) = (Bench::new(), seeds::obj());
    for at in 0..seed.files[2].1.len() {
        for value in [0, 1, 127, 255] {
            let mut files = seed.clone();
            files.files[2].1[at] = value;
            let case = format!("picture byte {at} = {value}");
            assert_eq!(bench.scene(&files, &case), Outcome::Read, "{case}");
        }
    }
}

/// The document with a picture in the text, in base64.
fn with_picture(base64: &str) -> Files {
    let mut document = seeds::document();
    document.json["images"][0] = json!({ "uri": format!("data:image/x;base64,{base64}") });
    document.files()
}

/// Colours of what other programs wrote: left and right, to what compression may lose.
#[test]
fn pictures_of_other_programs_have_their_colours() {
    const LOSS: i32 = 4;
    let (red, blue, grey) = ([200, 60, 30], [20, 90, 220], [120; 3]);
    for (base64, left, right) in [
        (BASELINE_JPEG, red, blue),
        (PROGRESSIVE_JPEG, red, blue),
        (GREY_JPEG, grey, grey),
        (LOSSY_WEBP, red, red),
    ] {
        let bench = Bench::new();
        let (name, bytes) = with_picture(base64).files.swap_remove(0);
        let path = bench.put(&name, &bytes);
        let scene = umbrage::io::read_scene(&path, &Default::default()).expect("a whole file");
        let texels = &scene.textures[0].texels;
        let row = &texels.rgba[..texels.width as usize];
        for (found, wanted) in [(row[1], left), (row[row.len() - 2], right)] {
            let near = |k: usize| (i32::from(found[k]) - wanted[k]).abs() <= LOSS;
            assert!((0..3).all(near) && found[3] == 255, "{found:?} {wanted:?}");
        }
    }
}

#[test]
fn every_letter_of_a_picture_in_the_text_may_be_wrong() {
    let bench = Bench::new();
    for base64 in [BASELINE_JPEG, PROGRESSIVE_JPEG, GREY_JPEG, LOSSY_WEBP] {
        for at in 0..base64.len() {
            for letter in ["A", "z", ""] {
                let wrong = format!("{}{letter}{}", &base64[..at], &base64[at + 1..]);
                let case = format!("letter {at} = {letter}");
                assert_eq!(
                    bench.scene(&with_picture(&wrong), &case),
                    Outcome::Read,
                    "{case}"
                );
            }
        }
    }
}
