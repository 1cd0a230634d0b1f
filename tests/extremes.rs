//! Stiff scenes and extreme ones: the light is finite, not negative, balanced, and as exact as is said.

use crate::common::bake::bake;
use crate::common::library::world_of_mesh;
use crate::common::obj_lite::ObjMesh;
use std::f64::consts::PI;
use std::time::Instant;
use umbrage::pipeline::{MEASURE_SLACK, Solution};
use umbrage::radiosity::Bounces;

/// Error asked for.
const ERROR: f64 = 0.03;

type Corners = [[f64; 3]; 4];

/// A rectangle at height `y`, front up or down.
fn level(x: [f64; 2], z: [f64; 2], y: f64, is_up: bool) -> Corners {
    let mut corners = [
        [x[0], y, z[0]],
        [x[0], y, z[1]],
        [x[1], y, z[1]],
        [x[1], y, z[0]],
    ];
    if !is_up {
        corners.reverse();
    }
    corners
}

/// A closed room of `size` metres, fronts inside, whose six sides reflect as given: floor, ceiling, walls.
fn room(size: [f64; 3], reflectance: [f64; 3]) -> ObjMesh {
    let [x, y, z] = size;
    let mut mesh = ObjMesh::default();
    mesh.add(&level([0., x], [0., z], 0.0, true), reflectance[0], 0.0);
    mesh.add(&level([0., x], [0., z], y, false), reflectance[1], 0.0);
    let walls: [Corners; 4] = [
        [[0., 0., 0.], [0., y, 0.], [0., y, z], [0., 0., z]],
        [[x, 0., 0.], [x, 0., z], [x, y, z], [x, y, 0.]],
        [[0., 0., 0.], [x, 0., 0.], [x, y, 0.], [0., y, 0.]],
        [[0., 0., z], [0., y, z], [x, y, z], [x, 0., z]],
    ];
    for wall in walls {
        mesh.add(&wall, reflectance[2], 0.0);
    }
    mesh
}

/// A black lamp of side `2 half` at height `y` that shines down, each m² with `exitance`.
fn lamp(mesh: &mut ObjMesh, at: [f64; 2], half: f64, y: f64, exitance: f64) {
    let [x, z] = at;
    let corners = level([x - half, x + half], [z - half, z + half], y, false);
    mesh.add(&corners, 0.0, exitance / PI);
}

/// What the account of the energy is off by, relative to all that arrives on what reflects.
fn imbalance(solution: &Solution) -> f64 {
    let lit = solution.receivers.iter().filter(|r| r.is_lit);
    let arriving: f64 = lit.map(|r| r.power().mean()).sum();
    let energy = solution.energy().expect("all bounces are followed");
    let emitted = energy.emitted_w.iter().sum::<f64>() / 3.0;
    (energy.imbalance * emitted / arriving).abs()
}

/// Bakes, and holds the light to what must be true of it.
fn check(name: &str, mesh: &ObjMesh, error: f64) {
    let world = world_of_mesh(name, mesh);
    let start = Instant::now();
    let solution = bake(&world, error, Bounces::All);
    let s = &solution.summary;
    let off = imbalance(&solution);
    eprintln!(
        "{name}: {} faces, {} elements, {} sweeps, {} rounds, measured {:.4}, out of balance by {off:.4}, {:.1} s",
        world.scene.faces.len(),
        s.elements,
        s.solve.residuals.len(),
        s.rounds,
        s.measured.relative_rms,
        start.elapsed().as_secs_f64(),
    );
    let lit = || solution.receivers.iter().filter(|r| r.is_lit);
    assert!(lit().count() > 0, "{name}: nothing is lit");
    for r in lit() {
        for site in 0..r.mesh.site_vertices.len() {
            let light = r.site_total(site).0;
            assert!(
                light.is_finite() && light.0.min_element() >= 0.0,
                "{name}: {light:?} on face {:?}",
                r.domain.face
            );
        }
    }
    assert!(
        s.measured.relative_rms <= (1.0 + MEASURE_SLACK) * error,
        "{name}: {:?}",
        s.measured
    );
    assert!(off <= error, "{name}: out of balance by {off}");
}

#[test]
fn a_black_floor_in_a_room_that_absorbs_next_to_nothing() {
    let mut mesh = room([1.0, 1.0, 1.0], [0.0, 0.9999, 0.9999]);
    lamp(&mut mesh, [0.5, 0.5], 0.2, 0.9, 1.0);
    check("0 and 0.9999", &mesh, ERROR);
}

#[test]
fn a_speck_of_black_in_a_room_that_absorbs_next_to_nothing() {
    let mut mesh = room([1.0, 1.0, 1.0], [0.9999; 3]);
    lamp(&mut mesh, [0.5, 0.5], 0.01, 0.9, 1.0);
    check("a speck of 0 in 0.9999", &mesh, ERROR);
}

#[test]
fn emitters_over_twelve_powers_of_ten() {
    let mut mesh = room([4.0, 2.5, 3.0], [0.3, 0.7, 0.5]);
    for (i, exitance) in [1e-6, 1e-2, 1e2, 1e6].into_iter().enumerate() {
        lamp(&mut mesh, [0.5 + i as f64, 1.5], 0.2, 2.4, exitance);
    }
    check("10⁻⁶ … 10⁶ W/m²", &mesh, ERROR);
}

#[test]
fn a_tiny_lamp_beside_a_huge_one() {
    // The tiny one sends a quarter of the light from 0.4 × 0.4 mm.
    let mut mesh = room([4.0, 2.5, 3.0], [0.3, 0.7, 0.5]);
    lamp(&mut mesh, [1.2, 1.3], 1.0, 2.4, 1.0);
    lamp(&mut mesh, [3.2, 2.1], 2e-4, 1.3, 4.0 / 1.6e-7 / 4.0);
    check("0.4 mm and 2 m", &mesh, ERROR);
}

#[test]
fn two_faces_a_micrometre_apart() {
    let mut mesh = room([1.0, 1.0, 1.0], [0.5, 0.5, 0.5]);
    lamp(&mut mesh, [0.5, 0.5], 0.2, 0.9, 1.0);
    mesh.add(&level([0.3, 0.8], [0.2, 0.6], 1e-6, true), 0.8, 0.0);
    check("1 µm above the floor", &mesh, ERROR);
}

#[test]
fn a_blocker_that_touches_the_lamp() {
    let mut mesh = room([1.0, 1.0, 1.0], [0.5, 0.5, 0.5]);
    lamp(&mut mesh, [0.5, 0.5], 0.2, 0.9, 1.0);
    // It hangs from the middle of the lamp, and another lies against half of it.
    let curtain = [
        [0.5, 0.9, 0.2],
        [0.5, 0.6, 0.2],
        [0.5, 0.6, 0.8],
        [0.5, 0.9, 0.8],
    ];
    mesh.add(&curtain, 0.5, 0.0);
    check("curtain on the lamp", &mesh, ERROR);
    let mut covered = room([1.0, 1.0, 1.0], [0.5, 0.5, 0.5]);
    lamp(&mut covered, [0.5, 0.5], 0.2, 0.9, 1.0);
    covered.add(&level([0.5, 0.8], [0.2, 0.8], 0.9, false), 0.5, 0.0);
    let world = world_of_mesh("half covered lamp", &covered);
    let solution = bake(&world, ERROR, Bounces::All);
    assert!(solution.summary.measured.relative_rms <= ERROR);
}

/// A ceiling full of lamps, 3 cm wide each.
fn many_lamps(columns: usize, rows: usize) -> ObjMesh {
    let mut mesh = room([4.0, 2.5, 3.0], [0.3, 0.7, 0.5]);
    for i in 0..columns {
        for j in 0..rows {
            let at = |k: usize, n: usize, size: f64| size * (k as f64 + 0.5) / n as f64;
            lamp(
                &mut mesh,
                [at(i, columns, 4.0), at(j, rows, 3.0)],
                0.015,
                2.4,
                10.0,
            );
        }
    }
    mesh
}

#[test]
fn a_dozen_dozen_lamps() {
    check("144 lamps", &many_lamps(12, 12), 0.05);
}

#[test]
#[ignore = "minutes: cost grows with the square of the lamps"]
fn two_thousand_lamps() {
    check("2000 lamps", &many_lamps(50, 40), 0.05);
}
