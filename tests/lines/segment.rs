//! A lamp as narrow as a segment over two disjoint triangles: its umbra falls into several pieces (up to four: Demouth,
//! Devillers, Everett, Glisse, Lazard & Seidel, *Between umbra and penumbra*, 2007).

use crate::common::library::{all_lines, distance_to_segment, moved, world_of_mesh};
use crate::common::obj_lite::ObjMesh;
use crate::common::reference::DirectReference;
use glam::DVec3;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{EventKind, LineTolerance, find_lines};
use umbrage::scene::{FaceId, FaceSide};

/// Half the floor's side, metres, and points along it at which the umbra is looked for.
const HALF: f64 = 6.0;
const POINTS: usize = 180;

/// Half the lamp's width, metres: a hundredth of the distance between points.
const HALF_WIDTH: f64 = 3e-4;

/// Darker than this share of the brightest point is umbra: only round-off is left.
const DARK: f64 = 1e-9;

/// Pieces of the umbra of this scene.
const PIECES: usize = 4;

/// Pieces of fewer points are the ends of others.
const SMALLEST: usize = 4;

/// The edge of the umbra is off a line by no more than this, metres: the chords of arcs.
const NEAR: f64 = 2.5e-4 * 2.0 * HALF;

fn scene() -> ObjMesh {
    let mut mesh = ObjMesh::default();
    let floor = [(-HALF, HALF), (HALF, HALF), (HALF, -HALF), (-HALF, -HALF)];
    mesh.add(&floor.map(|(x, z)| [x, 0.0, z]), 0.5, 0.0);
    let lamp = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    mesh.add(&lamp.map(|(x, z)| [x, 2.0, z * HALF_WIDTH]), 0.0, 1.0);
    // Found by a search for as many pieces as possible.
    let triangles = [
        [
            [1.813, 1.612, 1.979],
            [-0.290, 0.558, 0.232],
            [2.192, 1.672, 0.970],
        ],
        [
            [-0.265, 0.929, 2.133],
            [3.929, 1.541, -1.845],
            [-1.162, 0.956, 3.933],
        ],
    ];
    for t in &triangles {
        mesh.add(t, 0.5, 0.0);
    }
    mesh
}

/// Sizes of the connected pieces (by eight neighbours) of the marked points of a square grid.
fn pieces(mut is_marked: Vec<bool>) -> Vec<usize> {
    let mut sizes = Vec::new();
    for start in 0..is_marked.len() {
        if !std::mem::take(&mut is_marked[start]) {
            continue;
        }
        let (mut size, mut open) = (0, vec![start]);
        while let Some(at) = open.pop() {
            size += 1;
            let (i, j) = (at / POINTS, at % POINTS);
            for k in i.saturating_sub(1)..(i + 2).min(POINTS) {
                for l in j.saturating_sub(1)..(j + 2).min(POINTS) {
                    if std::mem::take(&mut is_marked[k * POINTS + l]) {
                        open.push(k * POINTS + l);
                    }
                }
            }
        }
        sizes.push(size);
    }
    sizes.sort_unstable();
    sizes
}

#[test]
fn each_piece_of_the_umbra_of_a_segment_is_bounded_by_lines() {
    let mesh = scene();
    let world = world_of_mesh("segment", &mesh);
    let light = DirectLight::new(&world.scene, &world.blockers);
    let lines = find_lines(&world.scene, &light, LineTolerance::default());
    let on_floor = lines.of(FaceId(0), FaceSide::Front);
    let reference = DirectReference::new(&moved(mesh, &world.scene));
    let origin = world.scene.origin;
    let at = |i: f64, j: f64| {
        let place = |k: f64| HALF * (2.0 * (k + 0.5) / POINTS as f64 - 1.0);
        DVec3::new(place(i), 0.0, place(j)) - origin
    };
    let bright = reference.irradiance(at(0.0, 0.0), DVec3::Y).x;
    let is_dark = |p: DVec3| reference.irradiance(p, DVec3::Y).x <= DARK * bright;
    let grid: Vec<bool> = (0..POINTS * POINTS)
        .map(|k| is_dark(at((k / POINTS) as f64, (k % POINTS) as f64)))
        .collect();
    let sizes = pieces(grid.clone());
    let large = sizes.iter().filter(|&&s| s >= SMALLEST).count();
    assert_eq!(large, PIECES, "{sizes:?}");
    let (mut crossings, mut missed) = (0, 0);
    for i in 0..POINTS {
        for j in 1..POINTS {
            let [a, b] = [j - 1, j].map(|j| grid[i * POINTS + j]);
            if a == b {
                continue;
            }
            crossings += 1;
            let [before, here] = [j - 1, j].map(|j| j as f64);
            let (mut dark, mut lit) = if a { (before, here) } else { (here, before) };
            for _ in 0..40 {
                let middle = 0.5 * (dark + lit);
                if is_dark(at(i as f64, middle)) {
                    dark = middle;
                } else {
                    lit = middle;
                }
            }
            let p = at(i as f64, dark);
            if !all_lines(on_floor).any(|l| distance_to_segment(p, l.ends) <= NEAR) {
                eprintln!("no line along the umbra at {:?}", p + origin);
                missed += 1;
            }
        }
    }
    eprintln!("{sizes:?}, {crossings} crossings");
    assert_eq!(missed, 0, "of {crossings}");
    // Pieces that both triangles make together are bounded by arcs.
    let arcs = on_floor.arcs.iter();
    assert!(arcs.filter(|a| a.line.kind == EventKind::Eee).count() > 0);
}
