//! Lamps that lie against something else give no light there, and all others do.

use crate::common::bake::bake;
use crate::common::library::{regression_world, world_of_mesh};
use crate::common::obj_lite::{ObjMesh, Polygon, Surface};
use glam::DVec3;
use umbrage::direct::stuck_emitters;
use umbrage::pipeline::World;
use umbrage::radiosity::Bounces;
use umbrage::scene::FaceSide;

const WALL: usize = 0;
const LAMP: usize = 1;

/// A mesh of nothing yet, with a wall's and a lamp's material.
fn mesh() -> ObjMesh {
    let surface = |name: &str, kd: f64, ke: f64| Surface {
        name: name.to_owned(),
        kd: DVec3::splat(kd),
        ke: DVec3::splat(ke),
    };
    ObjMesh {
        surfaces: vec![surface("wall", 0.5, 0.0), surface("lamp", 0.0, 1.0)],
        ..ObjMesh::default()
    }
}

/// A rectangle with its front towards `u × v`.
fn rectangle(mesh: &mut ObjMesh, surface: usize, corner: DVec3, u: DVec3, v: DVec3) {
    mesh.polygons.push(Polygon {
        corners: vec![corner, corner + u, corner + u + v, corner + v],
        surface,
        object: "part".to_owned(),
    });
}

/// A box with its fronts outwards.
fn solid(mesh: &mut ObjMesh, surface: usize, lo: DVec3, hi: DVec3) {
    let size = hi - lo;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| a * size.dot(a));
    for k in 0..3 {
        let (u, v) = (axes[(k + 1) % 3], axes[(k + 2) % 3]);
        rectangle(mesh, surface, lo, v, u);
        rectangle(mesh, surface, lo + axes[k], u, v);
    }
}

/// The normals of what shines, in the order of the emitters.
fn shining(world: &World) -> Vec<DVec3> {
    let emitters = world.scene.emitters.iter();
    emitters
        .map(|(_, e)| world.scene.normal(e.face, e.side).round())
        .collect()
}

#[test]
fn a_pane_shines_out_of_its_frame_and_not_into_it() {
    let world = regression_world("pane-in-a-frame");
    assert_eq!(shining(&world), [DVec3::NEG_Z, DVec3::Z]);
    assert!(
        world
            .warnings
            .iter()
            .any(|w| w.message.starts_with("4 sides")),
        "{:?}",
        world.warnings
    );
    let solution = bake(&world, 0.05, Bounces::All);
    let (mut brightest, mut within) = (0.0_f64, 0.0_f64);
    for r in solution.receivers.iter().filter(|r| r.is_lit) {
        let most = match r.domain.side {
            FaceSide::Front => &mut brightest,
            FaceSide::Back => &mut within,
        };
        *most = most.max(r.mean().mean());
    }
    // Past its rim as much comes in as through a crack of the weld distance.
    assert!(within < 1e-5 * brightest, "{within} W/m² of {brightest}");
}

#[test]
fn a_lamp_under_a_ceiling_does_not_shine_through_it() {
    let mut mesh = mesh();
    // Seen from below.
    let (u, v) = (4.0 * DVec3::X, 4.0 * DVec3::Z);
    rectangle(&mut mesh, WALL, DVec3::new(-2.0, 2.0, -2.0), u, v);
    let half = DVec3::new(0.3, 0.05, 0.3);
    let middle = DVec3::new(0.1, 1.95, 0.2);
    solid(&mut mesh, LAMP, middle - half, middle + half);
    let shining = shining(&world_of_mesh("lamp under a ceiling", &mesh));
    assert_eq!(shining.len(), 5);
    assert!(!shining.contains(&DVec3::Y), "{shining:?}");
}

#[test]
fn a_sheet_that_shines_in_the_plane_of_a_ceiling_is_no_body() {
    // The ceiling's front is turned up, as careless models have it.
    let mut mesh = mesh();
    let (u, v) = (4.0 * DVec3::X, 4.0 * DVec3::Z);
    rectangle(&mut mesh, WALL, DVec3::new(-2.0, 2.0, -2.0), v, u);
    rectangle(
        &mut mesh,
        LAMP,
        DVec3::new(-0.5, 2.0, -0.5),
        0.25 * u,
        0.25 * v,
    );
    // Another lamp, so that not all would go.
    rectangle(
        &mut mesh,
        LAMP,
        DVec3::new(-0.5, 0.0, -0.5),
        0.25 * u,
        0.25 * v,
    );
    let shining = shining(&world_of_mesh("turned ceiling", &mesh));
    assert_eq!(shining, [DVec3::NEG_Y, DVec3::NEG_Y]);
}

#[test]
fn a_lamp_that_sticks_out_of_what_it_stands_on_goes_on_shining_down() {
    let mut mesh = mesh();
    solid(&mut mesh, WALL, DVec3::ZERO, DVec3::ONE);
    let lo = DVec3::new(0.5, 1.0, 0.25);
    solid(&mut mesh, LAMP, lo, lo + DVec3::new(0.6, 0.5, 0.5));
    let shining = shining(&world_of_mesh("overhanging lamp", &mesh));
    assert_eq!(shining.len(), 6);
}

#[test]
fn where_all_lamps_would_go_all_stay() {
    // A room of which the fronts look outwards, and a lamp let into its ceiling.
    let mut mesh = mesh();
    solid(&mut mesh, WALL, DVec3::ZERO, DVec3::ONE);
    let (u, v) = (0.2 * DVec3::X, 0.2 * DVec3::Z);
    rectangle(&mut mesh, LAMP, DVec3::new(0.4, 1.0, 0.4), u, v);
    let world = world_of_mesh("inside out", &mesh);
    // It does lie against the ceiling.
    assert_eq!(stuck_emitters(&world.scene, &world.blockers).len(), 1);
    assert_eq!(shining(&world), [DVec3::NEG_Y]);
}
