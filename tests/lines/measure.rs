//! What the search costs: `cargo test --release -- --ignored --nocapture measure_the_search`.

use crate::common::library::world_of_raw;
use crate::common::scenes::shared_scene;
use std::time::Instant;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{LineMap, LineTolerance, find_lines};
use umbrage::io::{ReadSettings, read_scene};
use umbrage::scene::{FaceSide, Scene};

/// As a bake at an error of 1 % asks for.
const FLOOR: f64 = 0.0025;

/// A number that any change of a line changes.
fn fingerprint(scene: &Scene, lines: &LineMap) -> u64 {
    let mut sum = 0_u64;
    for face in scene.faces.ids() {
        for side in [FaceSide::Front, FaceSide::Back] {
            let l = lines.of(face, side);
            for d in l.contacts.iter().chain(&l.candidates) {
                let numbers = d.ends.iter().flat_map(|p| p.to_array()).chain([d.jump]);
                for x in numbers {
                    sum = sum.rotate_left(5) ^ x.to_bits();
                    sum = sum.wrapping_mul(0x9e37_79b9_7f4a_7c15);
                }
            }
        }
    }
    sum
}

#[test]
#[ignore = "prints measurements"]
fn measure_the_search() {
    for file in [
        "veach-ajar/veach-ajar.obj",
        "modern-hall/modern-hall.obj",
        "freedoom-e2m2/freedoom-e2m2.obj",
    ] {
        let Some(path) = shared_scene(file) else {
            continue;
        };
        let raw = read_scene(&path, &ReadSettings::default()).expect("the scene can be read");
        let world = world_of_raw(&raw);
        let light = DirectLight::new(&world.scene, &world.blockers);
        let start = Instant::now();
        let lines = find_lines(
            &world.scene,
            &light,
            LineTolerance {
                floor: FLOOR,
                ..LineTolerance::default()
            },
        );
        eprintln!(
            "{file}: {:.2} s; {} faces, {} edges, {} vertices, {} emitters; {:?}; {:016x}",
            start.elapsed().as_secs_f64(),
            world.scene.faces.len(),
            world.scene.edges.len(),
            world.scene.vertices.len(),
            world.scene.emitters.len(),
            lines.report,
            fingerprint(&world.scene, &lines)
        );
    }
}
