//! Many small lamps: what is too dim for a line is not looked for, and nothing else is lost.

use crate::common::library::{all_lines, receiver_sides, world_of_mesh};
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{Discontinuity, LineMap, LineTolerance, find_lines};
use umbrage::pipeline::World;

/// Lamps in each direction, and their distance, metres.
const LAMPS: usize = 5;
const STEP: f64 = 4.0;

/// Half a lamp's side, metres.
const HALF: f64 = 0.025;

/// Lines that break by less are left out, W/m². A lamp gives as much at 3.5 m, right below it.
const LEAST: f64 = 2e-4;

/// Metres.
const NEAR: f64 = 1e-9;

/// A floor, a lamp 2 m above each square of it, and a leaning sheet under each.
fn hall() -> World {
    let mut rng = Rng::new(12);
    let mut mesh = ObjMesh::default();
    let side = STEP * LAMPS as f64;
    let floor = [
        [0.0, 0.0, side],
        [side, 0.0, side],
        [side, 0.0, 0.0],
        [0.0; 3],
    ];
    mesh.add(&floor, 0.5, 0.0);
    for i in 0..LAMPS * LAMPS {
        let x = STEP * ((i % LAMPS) as f64 + 0.5) + rng.range(-0.3, 0.3);
        let z = STEP * ((i / LAMPS) as f64 + 0.5) + rng.range(-0.3, 0.3);
        let turn = rng.range(0.0, 1.5);
        let corner = |k: f64, r: f64, y: f64| {
            let (sine, cosine) = (turn + k * std::f64::consts::FRAC_PI_2).sin_cos();
            [x + r * cosine, y, z + r * sine]
        };
        // Counter-clockwise seen from below.
        let lamp = [0.0, 1.0, 2.0, 3.0].map(|k| corner(k, HALF * 2.0_f64.sqrt(), 2.0));
        mesh.add(&lamp, 0.0, 1.0);
        let mut height = || rng.range(0.3, 1.4);
        let sheet = [0.3, 1.4, 2.6].map(|k| corner(k, 0.6, height()));
        mesh.add(&sheet, 0.5, 0.0);
    }
    world_of_mesh("hall", &mesh)
}

fn search(world: &World, least: f64) -> LineMap {
    let light = DirectLight::new(&world.scene, &world.blockers);
    let tolerance = LineTolerance {
        least,
        ..LineTolerance::default()
    };
    find_lines(&world.scene, &light, tolerance)
}

#[test]
fn lines_that_matter_are_found_and_no_others() {
    let world = hall();
    let (all, few) = (search(&world, 0.0), search(&world, LEAST));
    let (mut strong, mut lost) = (0, 0);
    for (face, side) in receiver_sides(&world.scene) {
        let found: Vec<&Discontinuity> = all_lines(few.of(face, side)).collect();
        for line in &found {
            assert!(line.jump >= LEAST, "{line:?}");
        }
        for line in all_lines(all.of(face, side)).filter(|l| l.jump >= LEAST) {
            strong += 1;
            let is_same = |l: &&Discontinuity| {
                l.cause == line.cause
                    && (0..2).all(|i| l.ends.iter().any(|p| p.distance(line.ends[i]) < NEAR))
            };
            lost += usize::from(!found.iter().any(is_same));
        }
    }
    let work = |map: &LineMap| map.report.wedges;
    eprintln!(
        "{strong} of {} lines, {lost} lost, {} of {} wedges",
        all.report.lines,
        work(&few),
        work(&all)
    );
    assert!(strong > 200 && lost == 0, "{lost} of {strong} lines lost");
    assert!(
        3 * work(&few) < work(&all),
        "{} of {}",
        work(&few),
        work(&all)
    );
}
