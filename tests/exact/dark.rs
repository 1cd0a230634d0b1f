//! Sides that are taken for dark are dark: no emitter shows at any point of them.

use crate::common::bake::bake;
use crate::common::library::{receiver_sides, world_of, world_of_raw};
use crate::common::rng::Rng;
use crate::common::scenes::{fixture_names, shared_scene};
use std::collections::BTreeSet;
use umbrage::io::{ReadSettings, read_scene};
use umbrage::pipeline::World;
use umbrage::radiosity::Bounces;
use umbrage::visibility::{Scratch, Viewpoint};

/// Openings through which light reaches a small patch of a side only may be missed, with this share of all that is emitted.
const MISSED: f64 = 1e-5;

/// Points on each triangle of a dark side.
const POINTS: usize = 16;

/// The share of the emitters' power that falls on sides that show none, and how many there are.
fn light_on_dark_sides(world: &World) -> (f64, usize) {
    let scene = &world.scene;
    let solution = bake(world, 0.5, Bounces::Count(0));
    let lit: BTreeSet<_> = (solution.receivers.iter())
        .filter(|r| r.is_lit)
        .map(|r| (r.domain.face, r.domain.side))
        .collect();
    let (mut rng, mut scratch) = (Rng::new(11), Scratch::default());
    let (mut power, mut dark) = (0.0, 0);
    let reflecting = |s: &(_, _)| !scene.faces[s.0].is_pure_emitter();
    for (face, side) in receiver_sides(scene).into_iter().filter(reflecting) {
        if lit.contains(&(face, side)) {
            continue;
        }
        dark += 1;
        let frame = scene.faces[face].frame;
        for triangle in &scene.faces[face].triangles {
            let [a, b, c] = triangle.map(|v| frame.to_space(frame.to_plane(scene.vertices[v])));
            let share = 0.5 * (b - a).cross(c - a).length() / POINTS as f64;
            for _ in 0..POINTS {
                let (u, v) = (rng.unit().sqrt(), rng.unit());
                let at = a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
                let view = Viewpoint::new(at, scene.normal(face, side));
                power += share * solution.direct.irradiance(&view, &mut scratch).mean();
            }
        }
    }
    let emitted = scene.emitters.iter().map(|(_, e)| {
        let face = &scene.faces[e.face];
        std::f64::consts::PI * face.emission.0.mean() * face.area
    });
    (power / emitted.sum::<f64>(), dark)
}

#[test]
fn what_is_taken_for_dark_is_dark_in_all_fixtures() {
    let mut all = 0;
    for name in fixture_names() {
        let world = world_of(&name);
        if world.scene.emitters.is_empty() {
            continue;
        }
        let (share, dark) = light_on_dark_sides(&world);
        assert!(share <= MISSED, "{name}: {share} on {dark} sides");
        all += dark;
    }
    assert!(all > 100, "{all} dark sides");
}

#[test]
fn what_is_taken_for_dark_is_dark_in_a_level_of_many_rooms() {
    let Some(path) = shared_scene("freedoom-e2m2/freedoom-e2m2.obj") else {
        return;
    };
    let world = world_of_raw(&read_scene(&path, &ReadSettings::default()).expect("a scene"));
    let (share, dark) = light_on_dark_sides(&world);
    assert!(share <= MISSED, "{share} on {dark} sides");
    assert!(dark > 50, "{dark}");
}
