//! Files broken at random, the same ones every time.

use super::broken::{pointers, remove};
use super::{Bench, Files, Outcome, peak_memory, seeds};
use crate::common::rng::Rng;
use serde_json::{Value, json};

/// Mutations of each kind in the default run: about five seconds of a debug build in all.
const ROUNDS: u64 = 3000;

/// More virtual memory than this no file of a few kB may claim. The tests beside take their share of it too.
const MAX_MEMORY: u64 = 1 << 30;

/// Flips, overwrites, removes, repeats or cuts off some bytes.
fn mutate_bytes(bytes: &mut Vec<u8>, rng: &mut Rng) {
    for _ in 0..=rng.below(3) {
        if bytes.is_empty() {
            return;
        }
        let at = rng.below(bytes.len());
        match rng.below(8) {
            0 => bytes[at] ^= 1 << rng.below(8),
            1 => bytes[at] = rng.below(256) as u8,
            2 => bytes[at] = b"0123456789-+.eE/\\# \n\"[]{},:"[rng.below(27)],
            3 => drop(bytes.remove(at)),
            4 => bytes.insert(at, rng.below(256) as u8),
            5 => {
                let end = (at + rng.below(40)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                let to = rng.below(bytes.len());
                bytes.splice(to..to, copy);
            }
            6 => {
                let value = [0u32, 1, 0x7fff_ffff, u32::MAX][rng.below(4)].to_le_bytes();
                for (slot, byte) in bytes[at..].iter_mut().zip(value) {
                    *slot = byte;
                }
            }
            _ if rng.below(10) == 0 => bytes.truncate(at),
            _ => {}
        }
    }
}

/// Removes values, replaces them by others of the document or by strange ones, repeats list items.
fn mutate_json(json: &mut Value, rng: &mut Rng) {
    for _ in 0..=rng.below(3) {
        let all = pointers(json);
        if all.is_empty() {
            return;
        }
        let (here, there) = (&all[rng.below(all.len())], &all[rng.below(all.len())]);
        let other = json.pointer(there).cloned().unwrap_or(Value::Null);
        let big = rng.unit() * 10f64.powi(rng.below(40) as i32);
        let strange = [
            json!(rng.below(12)),
            json!(-1),
            json!(big),
            json!(big as u64),
            json!("x"),
        ];
        match rng.below(5) {
            0 => remove(json, here),
            1 => replace(json, here, other),
            2 => {
                if let Some(Value::Array(items)) = json.pointer_mut(here) {
                    items.push(other);
                }
            }
            _ => replace(json, here, strange[rng.below(strange.len())].clone()),
        }
    }
}

fn replace(json: &mut Value, pointer: &str, value: Value) {
    if let Some(slot) = json.pointer_mut(pointer) {
        *slot = value;
    }
}

fn fuzz(rounds: u64, seed: u64) {
    let bench = Bench::new();
    let before = peak_memory();
    let (document, obj, lit) = (seeds::document(), seeds::obj(), seeds::lit());
    let (glb, mut refused) = (document.glb(), 0);
    let mut count = |outcome: Outcome| refused += u64::from(outcome == Outcome::Refused);
    for round in 0..rounds {
        let rng = &mut Rng::new(seed ^ round);
        let case = |kind: &str| format!("{kind}, seed {seed}, round {round}");

        let mut changed = document.clone();
        mutate_json(&mut changed.json, rng);
        if rng.below(4) == 0 {
            mutate_bytes(&mut changed.bytes, rng);
        }
        count(bench.scene(&changed.files(), &case("glTF")));

        let mut bytes = glb.clone();
        mutate_bytes(&mut bytes, rng);
        let files = Files {
            files: vec![("a.glb".to_owned(), bytes)],
        };
        count(bench.scene(&files, &case("GLB")));

        let mut files = obj.clone();
        let which = rng.below(files.files.len());
        mutate_bytes(&mut files.files[which].1, rng);
        count(bench.scene(&files, &case("OBJ")));

        let mut bytes = lit.clone();
        mutate_bytes(&mut bytes, rng);
        count(bench.lit(&bytes, &case("lit")));
    }
    // An eighth at least: else the mutations reach nothing.
    assert!(
        refused * 8 > rounds * 4,
        "only {refused} of {} were refused",
        4 * rounds
    );
    if let (Some(before), Some(after)) = (before, peak_memory()) {
        let grown = (after - before) >> 20;
        assert!(after - before < MAX_MEMORY, "{grown} MB more than before");
    }
}

#[test]
fn mutated_files_are_read_or_refused() {
    fuzz(ROUNDS, 0x9e37_79b9);
}

#[test]
#[ignore = "minutes"]
fn many_mutated_files_are_read_or_refused() {
    for seed in 1..=4 {
        fuzz(10 * ROUNDS, seed << 32);
    }
}
