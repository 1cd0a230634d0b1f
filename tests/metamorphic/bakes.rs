//! Whole bakes of equivalent scenes.

use super::direct::{reversed, turned, with_positions};
use crate::common::bake::{bake, clean, raw};
use glam::DMat3;
use rayon::ThreadPoolBuilder;
use umbrage::io::write_glb;
use umbrage::radiosity::Bounces;
use umbrage::scene::RawScene;

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

/// Turns by angles that have nothing to do with the axes: another lattice to start from each, and nothing else.
const TURNS: usize = 8;
const TURN: f64 = 0.37;

/// Of so many standard deviations a normal variable stays within, 299 times of 300.
const SCATTER: f64 = 3.0;

/// Measured error at ten thousand points, mean irradiance (W/m²) and number of elements.
fn measured(raw: &RawScene) -> [f64; 3] {
    let world = clean(raw);
    let solution = bake(&world, ASKED, Bounces::Count(0));
    let measured = solution.measure(10_000, 3);
    [
        measured.relative_rms,
        measured.mean,
        solution.summary.elements as f64,
    ]
}

#[test]
fn turned_and_reordered_scenes_are_as_good() {
    for name in ["crossing-blockers", "box-on-table"] {
        let raw = raw(name);
        let others: Vec<[f64; 3]> = (1..=TURNS)
            .map(|i| {
                let turn = DMat3::from_rotation_y(TURN * i as f64);
                measured(&with_positions(&raw, |p| turn * p))
            })
            .collect();
        for (how, scene) in [
            ("as it is", &raw),
            ("turned", &turned(&raw)),
            ("reordered", &reversed(&raw)),
        ] {
            let found = measured(scene);
            assert!(found[0] <= ASKED, "{name} {how}: {found:?}");
            for (k, what) in ["error", "mean", "elements"].into_iter().enumerate() {
                let mean = others.iter().map(|o| o[k]).sum::<f64>() / TURNS as f64;
                let square = others.iter().map(|o| (o[k] - mean).powi(2)).sum::<f64>();
                let deviation = (square / (TURNS - 1) as f64).sqrt();
                assert!(
                    (found[k] - mean).abs() <= SCATTER * deviation,
                    "{name} {how}: {what} {} instead of {mean} ± {deviation}",
                    found[k]
                );
            }
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
