//! What a larger scene costs.

use super::cities::add_box;
use crate::common::library::world_of_mesh;
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use std::time::Instant;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{LineTolerance, SearchReport, find_lines};

/// Twice the boxes may cost so many times as much: linear growth, and the depth of a tree.
const DEAREST_DOUBLING: f64 = 2.3;

/// As a bake at an error of 1 % asks for.
const FLOOR: f64 = 0.0025;

/// Boxes on the blocks of a street plan, and a lamp high above the middle.
fn city(columns: usize, rows: usize) -> ObjMesh {
    let mut rng = Rng::new((columns * rows) as u64);
    let mut mesh = ObjMesh::default();
    let (w, d) = (columns as f64, rows as f64);
    let floor = [[0.0, 0.0, d], [w, 0.0, d], [w, 0.0, 0.0], [0.0, 0.0, 0.0]];
    mesh.add(&floor, 0.5, 0.0);
    for i in 0..columns * rows {
        let (x, z) = ((i % columns) as f64, (i / columns) as f64);
        let low = [x + rng.range(0.1, 0.3), 0.0, z + rng.range(0.1, 0.3)];
        let top = rng.range(0.3, 1.0);
        let high = [x + rng.range(0.6, 0.9), top, z + rng.range(0.6, 0.9)];
        add_box(&mut mesh, low, high, false);
    }
    let (x, y, z) = (0.5 * w + 0.13, 8.0, 0.5 * d + 0.17);
    let lamp = [
        [x, y, z],
        [x + 0.7, y, z],
        [x + 0.7, y, z + 0.7],
        [x, y, z + 0.7],
    ];
    mesh.add(&lamp, 0.0, 1.0);
    mesh
}

/// Seconds of one thread, and what the search did.
fn cost(columns: usize, rows: usize) -> (f64, SearchReport) {
    let world = world_of_mesh("city", &city(columns, rows));
    let light = DirectLight::new(&world.scene, &world.blockers);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one = one.expect("a thread can be started");
    let start = Instant::now();
    let lines = one.install(|| {
        find_lines(
            &world.scene,
            &light,
            LineTolerance {
                floor: FLOOR,
                ..LineTolerance::default()
            },
        )
    });
    (start.elapsed().as_secs_f64(), lines.report)
}

#[test]
fn twice_the_city_is_twice_the_work() {
    let work = |r: SearchReport| (r.wedges + r.triples) as f64;
    let (small, large) = (work(cost(6, 4).1), work(cost(6, 8).1));
    assert!(large <= DEAREST_DOUBLING * small, "{large} after {small}");
    assert!(small > 1000.0, "{small}");
}

#[test]
#[ignore = "measures time"]
fn twice_the_city_takes_twice_the_time() {
    let mut last: Option<f64> = None;
    for (columns, rows) in [(8, 8), (8, 16), (16, 16), (16, 32)] {
        // The best of three is least disturbed.
        let runs: Vec<(f64, SearchReport)> = (0..3).map(|_| cost(columns, rows)).collect();
        let seconds = runs.iter().map(|r| r.0).fold(f64::INFINITY, f64::min);
        let ratio = last.map_or(0.0, |l| seconds / l);
        eprintln!(
            "{columns} × {rows}: {seconds:.3} s, {ratio:.2} ×, {:?}",
            runs[0].1
        );
        assert!(ratio <= DEAREST_DOUBLING, "{ratio:.2} ×");
        last = Some(seconds);
    }
}
