//! The direct light where it is known in closed form.

use crate::common::library::world_of_mesh;
use crate::common::obj_lite::ObjMesh;
use crate::common::quadrature::gauss_between;
use crate::common::tables::rows;
use glam::DVec3;
use std::f64::consts::PI;
use umbrage::direct::{DirectLight, form_factor};
use umbrage::pipeline::World;
use umbrage::visibility::{Scratch, Viewpoint};

/// Exitance 1 W/m².
const UNIT_EXITANCE: f64 = 1.0 / PI;

/// Half a unit of the tables' last digit, and as much for the quadrature.
const TABLE_DIGITS: f64 = 1e-10;

/// Roundings of sums of a few arc tangents.
const ROUND_OFF: f64 = 1e-14;

/// A rectangle at height `y` that faces down.
fn facing_down(x: [f64; 2], z: [f64; 2], y: f64) -> [[f64; 3]; 4] {
    [
        [x[0], y, z[0]],
        [x[1], y, z[0]],
        [x[1], y, z[1]],
        [x[0], y, z[1]],
    ]
}

/// A world of one emitter of exitance 1 and blockers.
fn world(emitter: &[[f64; 3]], blockers: &[&[[f64; 3]]]) -> World {
    let mut mesh = ObjMesh::default();
    mesh.add(emitter, 0.0, UNIT_EXITANCE);
    for blocker in blockers {
        mesh.add(blocker, 0.3, 0.0);
    }
    world_of_mesh("made up", &mesh)
}

/// Irradiance at points of the plane y = 0, facing up.
fn at_floor(world: &World) -> impl FnMut(f64, f64) -> f64 {
    let light = DirectLight::new(&world.scene, &world.blockers);
    let mut scratch = Scratch::default();
    let origin = world.scene.origin;
    move |x, z| {
        let view = Viewpoint::new(DVec3::new(x, 0.0, z) - origin, DVec3::Y);
        light.irradiance(&view, &mut scratch).0.0.x
    }
}

/// Mean irradiance of a square of the plane y = 0 whose sides are divided at `breaks`.
fn mean_over_floor(world: &World, breaks: &[f64]) -> f64 {
    let line = gauss_between(breaks, 16);
    let side = breaks[breaks.len() - 1] - breaks[0];
    let mut at = at_floor(world);
    let mut sum = 0.0;
    for &(x, wx) in &line {
        for &(z, wz) in &line {
            sum += wx * wz * at(x, z);
        }
    }
    sum / (side * side)
}

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{what}: {found:.15} instead of {expected:.15} ± {tolerance:e}"
    );
}

#[test]
fn points_under_a_unit_square() {
    let world = world(&facing_down([-0.5, 0.5], [-0.5, 0.5], 1.0), &[]);
    let mut at = at_floor(&world);
    let known = |name: &str| rows("point_factors", name)[0][0];
    assert_near(at(0.0, 0.0), known("below_centre"), ROUND_OFF, "centre");
    assert_near(at(0.5, -0.5), known("below_corner"), ROUND_OFF, "corner");
}

#[test]
fn half_plane_hides_half_of_the_emitter() {
    // As wide as the emitter seen from the floor is enough of a half-plane.
    let world = world(
        &facing_down([-0.5, 0.5], [-0.5, 0.5], 1.0),
        &[&facing_down([-4.0, 0.0], [-4.0, 4.0], 0.5)],
    );
    let mut at = at_floor(&world);
    let known = |name: &str| rows("point_factors", name)[0].clone();
    let expected = known("below_centre_half_hidden")[0];
    assert_near(at(0.0, 0.0), expected, ROUND_OFF, "under its edge");
    let [power, factor] = known("onset_parallel")[..] else {
        panic!("two numbers")
    };
    let d: f64 = 1e-5;
    assert_near(at(-0.5, 0.0), 0.0, ROUND_OFF, "at the umbra's end");
    assert_near(
        at(-0.5 + d, 0.0) / d.powf(power),
        factor,
        10.0 * d,
        "past the umbra's end",
    );
}

#[test]
fn parallel_squares() {
    for row in rows("form_factors", "parallel_unit_squares") {
        let world = world(&facing_down([0.0, 1.0], [0.0, 1.0], row[0]), &[]);
        let found = mean_over_floor(&world, &[0.0, 0.5, 1.0]);
        assert_near(found, row[1], TABLE_DIGITS, &format!("at {}", row[0]));
    }
}

#[test]
fn perpendicular_squares_with_a_shared_edge() {
    // The factor depends on direction alone near the ends of the shared edge: pieces grow by two from there.
    let graded: Vec<f64> = (0..=40)
        .map(|k| if k == 0 { 0.0 } else { 0.5_f64.powi(40 - k) })
        .collect();
    let mut across: Vec<f64> = graded.iter().map(|t| 0.5 * t).collect();
    across.extend(graded.iter().rev().skip(1).map(|t| 1.0 - 0.5 * t));
    let wall = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 1.0, 1.0],
        [0.0, 0.0, 1.0],
    ];
    let wall = wall.map(DVec3::from);
    let mut sum = 0.0;
    for &(x, wx) in &gauss_between(&graded, 8) {
        for &(z, wz) in &gauss_between(&across, 8) {
            sum += wx * wz * form_factor(DVec3::new(x, 0.0, z), DVec3::Y, &wall).abs();
        }
    }
    let expected = rows("form_factors", "perpendicular_unit_squares")[0][0];
    assert_near(sum, expected, 1e-11, "perpendicular squares");
}

#[test]
fn squares_past_a_blocker() {
    let past = |x: [f64; 2], height: f64, breaks: &[f64]| {
        let world = world(
            &facing_down([0.0, 1.0], [0.0, 1.0], 1.0),
            &[&facing_down(x, x, height)],
        );
        mean_over_floor(&world, breaks)
    };
    let known = |name: &str| rows("form_factors", name)[0][0];
    let centred = past([0.25, 0.75], 0.75, &[0.0, 1.0]);
    assert_near(centred, known("shapiro"), TABLE_DIGITS, "Shapiro");
    let centred = past([0.25, 0.75], 0.5, &[0.0, 0.5, 1.0]);
    let expected = known("centred_blocker_at_half");
    assert_near(centred, expected, TABLE_DIGITS, "centred");
    let corner = past([0.0, 0.5], 0.5, &[0.0, 0.5, 1.0]);
    let expected = known("corner_blocker_at_half");
    assert_near(corner, expected, TABLE_DIGITS, "corner");
}

#[test]
fn infinite_strips() {
    // Off by half the square of width over length.
    let half = 1e6;
    let strip = facing_down([0.0, 1.0], [-half, half], 1.0).map(DVec3::from);
    let found: f64 = gauss_between(&[0.0, 0.5, 1.0], 16)
        .iter()
        .map(|&(x, w)| w * form_factor(DVec3::new(x, 0.0, 0.0), DVec3::Y, &strip))
        .sum();
    let expected = rows("form_factors", "infinite_strips")[0][0];
    assert_near(found, expected, 1e-11, "strips");
}
