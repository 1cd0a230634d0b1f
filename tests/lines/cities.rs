//! Random cities of boxes: the search survives them, and its lines lie where lines can lie.

use crate::common::library::{all_lines, receiver_sides, world_of_mesh};
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{LineTolerance, find_lines};

/// Coordinates are multiples of this, so that faces coincide and boxes touch, metres.
const RASTER: f64 = 0.25;

/// Roundings of a line's end, over the scene's diagonal.
const ROUND_OFF: f64 = 1e-12;

/// Adds a box without or with a bottom.
pub(crate) fn add_box(mesh: &mut ObjMesh, low: [f64; 3], high: [f64; 3], has_bottom: bool) {
    let p = |i: usize| -> [f64; 3] {
        [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] })
    };
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    for side in sides {
        mesh.add(&side.map(p), 0.5, 0.0);
    }
    if has_bottom {
        mesh.add(&[0, 1, 5, 4].map(p), 0.5, 0.0);
    }
}

/// A floor, boxes on it, on each other, in each other, side by side, and one or two emitters above.
fn city(rng: &mut Rng, boxes: usize) -> ObjMesh {
    // Sometimes far away, in steps that f64 holds exactly.
    let shift = if rng.below(3) == 0 { 8e6 } else { 0.0 };
    let mut mesh = ObjMesh::default();
    let at = |x: f64, y: f64, z: f64| [x + shift, y + shift, z + shift];
    mesh.add(
        &[
            at(0.0, 0.0, 4.0),
            at(4.0, 0.0, 4.0),
            at(4.0, 0.0, 0.0),
            at(0.0, 0.0, 0.0),
        ],
        0.5,
        0.0,
    );
    for _ in 0..boxes {
        let mut raster = |from: usize, to: usize| (from + rng.below(to - from)) as f64 * RASTER;
        let (x, z) = (raster(0, 14), raster(0, 14));
        let (w, h, d) = (raster(1, 6), raster(1, 6), raster(1, 6));
        let y = if rng.below(4) == 0 { h } else { 0.0 };
        let has_bottom = rng.below(2) == 0;
        add_box(&mut mesh, at(x, y, z), at(x + w, y + h, z + d), has_bottom);
    }
    for _ in 0..1 + rng.below(2) {
        let mut raster = |from: usize, to: usize| (from + rng.below(to - from)) as f64 * RASTER;
        let (x, y, z, w, d) = (
            raster(0, 12),
            raster(4, 14),
            raster(0, 12),
            raster(1, 5),
            raster(1, 5),
        );
        let corners = [
            at(x, y, z),
            at(x + w, y, z),
            at(x + w, y, z + d),
            at(x, y, z + d),
        ];
        mesh.add(&corners, 0.0, 1.0);
    }
    mesh
}

/// Checks every line of one city; returns how many there are.
fn check(seed: u64, boxes: usize) -> usize {
    let mesh = city(&mut Rng::new(seed), boxes);
    let world = world_of_mesh(&format!("city {seed}"), &mesh);
    let scene = &world.scene;
    let light = DirectLight::new(scene, &world.blockers);
    let lines = find_lines(scene, &light, LineTolerance::default());
    let mut count = 0;
    for (id, side) in receiver_sides(scene) {
        let face = &scene.faces[id];
        for line in all_lines(lines.of(id, side)) {
            count += 1;
            for p in line.ends {
                let what = || format!("city {seed}, {side:?} of {id:?}: {line:?}");
                assert!(p.is_finite() && line.jump.is_finite(), "{}", what());
                // Contact lines may be edges of the touching face, which weld within the weld distance.
                let height = face.frame.plane().distance(p).abs();
                let flat = match line.emitter {
                    Some(_) => ROUND_OFF * scene.diagonal,
                    None => scene.weld_distance,
                };
                assert!(height <= flat, "{height:e} off the plane: {}", what());
                let q = face.frame.to_plane(p);
                let off = face.outline.distance_to_outline(q);
                assert!(
                    face.outline.contains(q) || off <= scene.weld_distance,
                    "{off:e} outside: {}",
                    what()
                );
            }
            assert!((line.face, line.side) == (id, side));
        }
    }
    count
}

#[test]
fn lines_of_random_cities_lie_on_their_faces() {
    let lines: usize = (0..25).map(|seed| check(seed, 3 + seed as usize % 4)).sum();
    assert!(lines > 1000, "{lines} lines");
}

#[test]
#[ignore = "takes minutes"]
fn lines_of_many_random_cities_lie_on_their_faces() {
    let lines: usize = (100..2000)
        .map(|seed| check(seed, 2 + seed as usize % 9))
        .sum();
    eprintln!("{lines} lines");
}
