//! The path tracer, where the answer is known.

use super::{UP, assert_near};
use crate::common::path_tracer::{PathSettings, PathTracer};
use crate::common::reference::DirectReference;
use crate::common::scenes::{FURNACES, read_fixture};
use glam::DVec3;

#[test]
fn furnaces_receive_one_watt_everywhere() {
    for name in FURNACES {
        let mesh = read_fixture(name);
        let tracer = PathTracer::new(&mesh);
        let settings = |from_emitters| PathSettings {
            // Paths at a reflectance of 0.99 are a hundred reflections long.
            paths: if name.ends_with("r99") { 100 } else { 1000 },
            bounces: 5000,
            seed: 17,
            from_emitters,
        };
        let floor = DVec3::new(0.07, 0.0, 0.83);
        for from_emitters in [false, true] {
            let found = tracer.irradiance(floor, UP, &settings(from_emitters));
            let z = found.z(DVec3::ONE, 1e-9);
            assert!(
                z < 4.0,
                "{name}, from emitters {from_emitters}: {found:?} is {z} standard errors off"
            );
        }
    }
}

#[test]
fn paths_without_reflection_give_the_direct_light() {
    for name in ["rotated-blocker", "two-emitters", "box-on-table", "blinds"] {
        let mesh = read_fixture(name);
        let (exact, tracer) = (DirectReference::new(&mesh), PathTracer::new(&mesh));
        for (i, x) in [DVec3::new(0.9, 0.0, 0.4), DVec3::new(1.8, 0.0, 1.1)]
            .into_iter()
            .enumerate()
        {
            for from_emitters in [false, true] {
                let settings = PathSettings {
                    paths: 20_000,
                    bounces: 0,
                    seed: 23 + i as u64,
                    from_emitters,
                };
                let (expected, found) =
                    (exact.irradiance(x, UP), tracer.irradiance(x, UP, &settings));
                let z = found.z(expected, 1e-12);
                assert!(
                    z < 4.0,
                    "{name} at {x}, from emitters {from_emitters}: {found:?} for {expected}"
                );
            }
        }
    }
}

#[test]
fn both_ways_of_tracing_agree_around_a_corner() {
    let mesh = read_fixture("l-room");
    let tracer = PathTracer::new(&mesh);
    let x = DVec3::new(1.2, 0.0, 3.8);
    let direct = DirectReference::new(&mesh).irradiance(x, UP);
    assert_near(direct.x, 0.0, 1e-15, "no direct light around the corner");
    let estimate = |from_emitters, paths| {
        let settings = PathSettings {
            paths,
            bounces: 100,
            seed: 29,
            from_emitters,
        };
        tracer.irradiance(x, UP, &settings)
    };
    let (hits, emitters) = (estimate(false, 60_000), estimate(true, 20_000));
    let error = hits.standard_error.x.hypot(emitters.standard_error.x);
    assert!(hits.mean.x > 0.0);
    assert!(
        (hits.mean.x - emitters.mean.x).abs() < 4.0 * error,
        "{hits:?} and {emitters:?}"
    );
}
