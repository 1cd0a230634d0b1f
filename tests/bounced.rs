//! Direct and bounced light against the path tracer, which knows nothing of meshes, rows or sweeps.

use crate::common::bake::{bake, world};
use crate::common::fine_field::FineField;
use crate::common::path_tracer::{PathSettings, PathTracer};
use crate::common::scenes::read_fixture;
use glam::DVec3;
use umbrage::quantity::Irradiance;
use umbrage::radiosity::Bounces;
use umbrage::visibility::{Scratch, Viewpoint};

/// Standard errors that chance may account for: once in 16 000 points.
const LARGEST_Z: f64 = 4.0;

/// How light is found at a point.
#[derive(Clone, Copy)]
struct Effort {
    paths: u32,
    /// Elements of the solution.
    elements: f64,
    /// Error of that solution, relative to the light at the point.
    slack: f64,
}

/// Compares the light at points of the floor or of a wall: position, normal.
fn check(name: &str, points: &[[DVec3; 2]], effort: Effort) {
    let world = world(name);
    // Only the sides that light reaches are taken from the bake.
    let solution = bake(&world, 0.3, Bounces::All);
    let field = FineField::new(&solution, effort.elements).expect("the room reflects");
    let tracer = PathTracer::new(&read_fixture(name));
    let mut scratch = Scratch::default();
    for (i, &[place, normal]) in points.iter().enumerate() {
        let view = Viewpoint::new(place - world.scene.origin, normal);
        let direct: Irradiance = solution.direct.irradiance(&view, &mut scratch);
        let light = (direct + field.irradiance(&mut field.gatherer(), &view))
            .0
            .0;
        let traced = tracer.irradiance(
            place,
            normal,
            &PathSettings {
                paths: effort.paths,
                bounces: 200,
                seed: 41 + i as u64,
                from_emitters: true,
            },
        );
        let z = traced.z(light, effort.slack * light.max_element());
        eprintln!(
            "{name} at {place}: {:.5} W/m², traced {:.5} ± {:.5}: z = {z:.2}",
            light.x, traced.mean.x, traced.standard_error.x
        );
        assert!(z < LARGEST_Z, "{name} at {place}: {light} for {traced:?}");
    }
}

fn l_room_points() -> Vec<[DVec3; 2]> {
    vec![
        [DVec3::new(3.3, 0.0, 0.6), DVec3::Y],
        [DVec3::new(1.1, 0.0, 1.3), DVec3::Y],
        [DVec3::new(0.9, 0.0, 3.1), DVec3::Y],
        [DVec3::new(0.0, 1.3, 3.7), DVec3::X],
        [DVec3::new(1.7, 2.5, 0.4), DVec3::NEG_Y],
    ]
}

fn blinds_points() -> Vec<[DVec3; 2]> {
    vec![
        [DVec3::new(2.9, 0.0, 1.4), DVec3::Y],
        [DVec3::new(1.9, 0.75, 1.7), DVec3::Y],
        [DVec3::new(4.0, 2.2, 0.4), DVec3::NEG_X],
        [DVec3::new(1.2, 3.0, 2.2), DVec3::NEG_Y],
    ]
}

#[test]
fn light_around_a_corner_is_what_paths_find() {
    let effort = Effort {
        paths: 8000,
        elements: 800.0,
        slack: 0.02,
    };
    check("l-room", &l_room_points(), effort);
}

#[test]
#[ignore = "a million paths a point"]
fn light_of_rooms_is_what_a_million_paths_find() {
    let effort = Effort {
        paths: 1_000_000,
        elements: 6000.0,
        slack: 0.005,
    };
    check("l-room", &l_room_points(), effort);
    check("blinds", &blinds_points(), effort);
}
