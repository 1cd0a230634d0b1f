//! Whole bakes of equivalent scenes.

use super::direct::{reversed, turned};
use crate::common::bake::{bake, clean, raw};
use rayon::ThreadPoolBuilder;
use umbrage::io::write_glb;
use umbrage::pipeline::World;
use umbrage::radiosity::Bounces;

/// Of light that is seven times as bright, relative to the brightest: a few hundred roundings.
const ROUND_OFF: f64 = 1e-12;

/// An emission that changes every rounding.
const BRIGHTER: f64 = 7.0;

#[test]
fn light_is_linear_in_the_emission() {
    for name in ["crossing-blockers", "furnace-l-room-r50"] {
        let raw = raw(name);
        let mut brighter = raw.clone();
        for material in &mut brighter.materials {
            material.emission.0 = material.emission.0 * BRIGHTER;
        }
        let (plain, bright) = (clean(&raw), clean(&brighter));
        let [plain, bright] =
            [&plain, &bright].map(|world| bake(world, 0.03, Bounces::All).lit_scene());
        assert_eq!(plain.meshes.len(), bright.meshes.len(), "{name}");
        let values = |lit: &umbrage::lit_scene::LitScene| -> Vec<f64> {
            let meshes = lit.meshes.iter();
            meshes
                .flat_map(|m| &m.irradiance)
                .map(|e| e.0.0.x)
                .collect()
        };
        let (plain, bright) = (values(&plain), values(&bright));
        let largest = plain.iter().copied().fold(0.0, f64::max);
        assert!(largest > 0.0, "{name} is dark");
        assert_eq!(plain.len(), bright.len(), "{name}: another mesh");
        for (p, b) in plain.iter().zip(&bright) {
            let off = (b / BRIGHTER - p).abs();
            assert!(off <= ROUND_OFF * largest, "{name}: {b} instead of 7 × {p}");
        }
    }
}

/// Error asked for of turned scenes.
const ASKED: f64 = 0.03;

#[test]
fn turned_and_reordered_scenes_are_as_good() {
    for name in ["crossing-blockers", "box-on-table"] {
        let raw = raw(name);
        let summary = |world: &World| {
            let solution = bake(world, ASKED, Bounces::Count(0));
            let measured = solution.measure(10_000, 3);
            (
                measured.relative_rms,
                measured.mean,
                solution.summary.elements,
            )
        };
        let (error, mean, elements) = summary(&clean(&raw));
        for (how, other) in [("turned", turned(&raw)), ("reordered", reversed(&raw))] {
            let found = summary(&clean(&other));
            let what = format!(
                "{name} {how}: {found:?} instead of {:?}",
                (error, mean, elements)
            );
            // Ten thousand points know the mean to a percent. How far the error stays below what is asked for depends on
            // where the starting points fall.
            assert!((found.1 / mean - 1.0).abs() < 0.02, "{what}");
            assert!(found.0.max(error) <= ASKED, "{what}");
            assert!(
                (found.2 as f64 / elements as f64 - 1.0).abs() < 0.25,
                "{what}"
            );
        }
    }
}

#[test]
fn threads_and_repetition_change_no_byte() {
    for (name, bounces) in [
        ("box-on-table", Bounces::Count(0)),
        ("wall-piercing-floor", Bounces::All),
    ] {
        let world = clean(&raw(name));
        let bytes = |threads: usize| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads can be started")
                .install(|| write_glb(&bake(&world, 0.05, bounces).lit_scene()))
        };
        let one = bytes(1);
        assert!(one == bytes(2), "{name}: two threads write another file");
        assert!(
            one == bytes(2),
            "{name}: the second run writes another file"
        );
        // Cleaning depends on no thread, but on no address or hash either.
        let again = clean(&raw(name));
        let repeated = write_glb(&bake(&again, 0.05, bounces).lit_scene());
        assert!(one == repeated, "{name}: a new world writes another file");
    }
}
