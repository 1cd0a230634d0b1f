//! The direct light on every side of every scene of our own, against the exact reference.

use crate::common::library::{local_mesh, random_point, receiver_sides, world_of};
use crate::common::reference::DirectReference;
use crate::common::rng::Rng;
use crate::common::scenes::fixture_names;
use umbrage::direct::DirectLight;
use umbrage::visibility::{Scratch, Viewpoint};

/// Permitted difference over the value.
const RELATIVE: f64 = 1e-9;

/// Permitted difference besides, over the brightest emitter's exitance: the reference's round-off where nothing is seen.
/// In the closed slats of the blinds, whose walls fill most of the view, it comes to 1e-13.
const FACTOR_ROUND_OFF: f64 = 1e-12;

/// Compares at `points` random points on each side; returns how many of them see some of an emitter and not all, and
/// prints the largest differences.
fn compare(name: &str, points: usize, rng: &mut Rng) -> usize {
    let world = world_of(name);
    let scene = &world.scene;
    let light = DirectLight::new(scene, &world.blockers);
    let reference = DirectReference::new(&local_mesh(name, scene));
    let mut scratch = Scratch::default();
    let exitances = light.polygons.iter().map(|p| p.exitance.0.0.max_element());
    let exitance = exitances.fold(0.0, f64::max);
    let (mut partly, mut worst, mut most_off) = (0, 0.0_f64, 0.0_f64);
    for (face, side) in receiver_sides(scene) {
        let normal = scene.normal(face, side);
        for _ in 0..points {
            let x = random_point(scene, face, rng);
            let view = Viewpoint::new(x, normal);
            let found = light.irradiance(&view, &mut scratch).0.0;
            let open = light.unoccluded(&view, &mut scratch).0.0.max_element();
            let expected = reference.irradiance(x, normal);
            let value = expected.max_element();
            let off = (found - expected).abs().max_element();
            assert!(
                off <= RELATIVE * value + FACTOR_ROUND_OFF * exitance,
                "{name}: {found} instead of {expected} at {x:?}, {side:?} of {face:?} ({}), unoccluded {open}",
                scene.groups[scene.faces[face].group as usize]
            );
            if value > RELATIVE * exitance {
                worst = worst.max(off / value);
            }
            most_off = most_off.max(off / exitance);
            partly += usize::from(value > RELATIVE * exitance && value < open * (1.0 - RELATIVE));
        }
    }
    eprintln!(
        "{name}: {partly} points in part light; off by at most {worst:.1e} of the value, {most_off:.1e} of the exitance"
    );
    partly
}

/// Compares on all scenes with this many points in each.
fn compare_all(points_per_scene: usize) {
    let mut rng = Rng::new(7);
    let mut partly = 0;
    for name in fixture_names() {
        let sides = receiver_sides(&world_of(&name).scene).len();
        partly += compare(&name, points_per_scene.div_ceil(sides), &mut rng);
    }
    assert!(
        partly > points_per_scene,
        "only {partly} points in part light"
    );
}

#[test]
fn direct_light_is_exact_on_all_fixtures() {
    compare_all(60);
}

#[test]
#[ignore = "takes a minute"]
fn direct_light_is_exact_on_all_fixtures_at_many_points() {
    compare_all(6000);
}
