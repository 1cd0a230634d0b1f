//! Small soups: what becomes of sound ones here, one trouble each in `repairs`, and (ignored) large ones for the clock.

use super::*;
use crate::quantity::{Radiance, Rgb};
use crate::scene::RawPolygon;
use std::f64::consts::FRAC_PI_3;

mod files;
mod fuzz;
mod large;
mod repairs;

const GREY: u32 = 0;
const RED: u32 = 1;
const LAMP: u32 = 2;
const GLASS: u32 = 3;
const ONE_SIDED: u32 = 4;

fn material(name: &str, emitted: f64) -> Material {
    Material {
        name: name.to_owned(),
        reflectance: Rgb::grey(0.5),
        emission: Radiance(Rgb::grey(emitted)),
        is_see_through: name == "glass",
        reflects_back: name != "one-sided",
        ..Material::default()
    }
}

fn soup(positions: &[[f64; 3]], polygons: &[(&[u32], u32)]) -> RawScene {
    RawScene {
        source: "soup".to_owned(),
        positions: positions.iter().map(|&p| DVec3::from(p)).collect(),
        polygons: polygons
            .iter()
            .map(|&(corners, material)| RawPolygon {
                corners: corners.to_vec(),
                material,
                group: 0,
            })
            .collect(),
        materials: vec![
            material("grey", 0.0),
            material("red", 0.0),
            material("lamp", 5.0),
            material("glass", 0.0),
            material("one-sided", 0.0),
        ],
        groups: vec!["all".to_owned()],
        ..RawScene::default()
    }
}

fn cleaned(raw: &RawScene) -> (Scene, CleanReport) {
    let (scene, report, _) = clean(raw, &CleanSettings::default()).expect("the soup has faces");
    scene
        .check_invariants(report.planarity_m)
        .expect("the scene is valid");
    assert_separated(&scene);
    (scene, report)
}

/// Fails where a vertex lies within the weld distance of another one, or within half of it of an edge that does not end
/// there.
fn assert_separated(scene: &Scene) {
    let tree = point_tree::PointTree::new(&scene.vertices, scene.vertices.ids().collect());
    let reach = scene.weld_distance;
    for (v, &p) in scene.vertices.iter() {
        tree.near_segment(p, p, reach, &mut |w| {
            assert!(v == w || p.distance(scene.vertices[w]) > reach, "{v} {w}");
        });
    }
    for (id, edge) in scene.edges.iter() {
        let [a, b] = edge.ends.map(|v| scene.vertices[v]);
        tree.near_segment(a, b, reach, &mut |v| {
            let (p, d) = (scene.vertices[v] - a, b - a);
            let t = (p.dot(d) / d.length_squared()).clamp(0.0, 1.0);
            let is_off = (p - d * t).length() > 0.5 * reach;
            assert!(edge.ends.contains(&v) || is_off, "vertex {v}, edge {id}");
        });
    }
}

/// The numbers that must not depend on place, size or order.
fn counts(report: &CleanReport) -> CleanReport {
    CleanReport {
        weld_distance_m: 0.0,
        edge_distance_m: 0.0,
        planarity_m: 0.0,
        ..report.clone()
    }
}

fn cube() -> RawScene {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from);
    let corners: Vec<_> = (0..8).map(corner).collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles: Vec<[u32; 3]> = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    let polygons: Vec<(&[u32], u32)> = triangles.iter().map(|t| (t.as_slice(), GREY)).collect();
    soup(&corners, &polygons)
}

/// A square with a square hole, as eight triangles.
fn plate() -> RawScene {
    let positions = [
        [0.0, 0.0, 0.0],
        [3.0, 0.0, 0.0],
        [3.0, 3.0, 0.0],
        [0.0, 3.0, 0.0],
        [1.0, 1.0, 0.0],
        [2.0, 1.0, 0.0],
        [2.0, 2.0, 0.0],
        [1.0, 2.0, 0.0],
    ];
    let triangles: Vec<[u32; 3]> = (0..4)
        .flat_map(|i| {
            let j = (i + 1) % 4;
            [[i, j, j + 4], [i, j + 4, i + 4]]
        })
        .collect();
    let polygons: Vec<(&[u32], u32)> = triangles.iter().map(|t| (t.as_slice(), GREY)).collect();
    soup(&positions, &polygons)
}

#[test]
fn twelve_triangles_are_a_cube() {
    let (scene, report) = cleaned(&cube());
    assert_eq!(
        (report.faces, report.edges, report.vertices),
        (6, 12, 8),
        "{report:?}"
    );
    assert!(scene.edges.iter().all(|(_, e)| e.uses.len() == 2));
    assert!(scene.faces.iter().all(|(_, f)| f.convex_parts.len() == 1));
    for (id, f) in scene.faces.iter() {
        let outwards = f.frame.origin + scene.normal(id, FaceSide::Front);
        assert!(outwards.length() > f.frame.origin.length());
    }
}

#[test]
fn eight_triangles_are_a_plate_with_a_hole() {
    let (scene, _) = cleaned(&plate());
    assert_eq!(scene.faces.len(), 1);
    let face = &scene.faces[FaceId(0)];
    assert_eq!(face.loops.len(), 2);
    assert!((face.area - 8.0).abs() < 1e-12);
    assert!((4..=5).contains(&face.convex_parts.len()));
}

#[test]
fn counts_do_not_depend_on_place_size_and_turn() {
    for raw in [cube(), plate()] {
        let expected = counts(&cleaned(&raw).1);
        for scale in [1e-3, 1.0, 1e3] {
            for shift in [0.0, 1e6 * scale] {
                for angle in [0.0, FRAC_PI_3] {
                    let turn = glam::DQuat::from_axis_angle(DVec3::ONE.normalize(), angle);
                    let mut moved = raw.clone();
                    for p in &mut moved.positions {
                        *p = turn * *p * scale + DVec3::splat(shift);
                    }
                    assert_eq!(
                        counts(&cleaned(&moved).1),
                        expected,
                        "{scale} {shift} {angle}"
                    );
                }
            }
        }
    }
}

#[test]
fn counts_do_not_depend_on_the_order_of_polygons() {
    let expected = counts(&cleaned(&plate()).1);
    for step in [3, 5, 7] {
        let mut raw = plate();
        let n = raw.polygons.len();
        raw.polygons = (0..n).map(|i| raw.polygons[i * step % n].clone()).collect();
        assert_eq!(counts(&cleaned(&raw).1), expected);
    }
}

#[test]
fn materials_keep_coplanar_triangles_apart() {
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let two = soup(&square, &[(&[0, 1, 2], GREY), (&[0, 2, 3], RED)]);
    assert_eq!(cleaned(&two).1.faces, 2);
    let one = soup(&square, &[(&[0, 1, 2], GREY), (&[0, 2, 3], GREY)]);
    assert_eq!(cleaned(&one).1.faces, 1);
    let opposite = soup(&square, &[(&[0, 1, 2], GREY), (&[0, 3, 2], GREY)]);
    assert_eq!(cleaned(&opposite).1.faces, 2);
}

#[test]
fn squares_that_touch_at_a_corner_are_two_faces() {
    // Around a hole in a ring of eight cells, two opposite corners of which are missing: the ring is pinched there.
    let mut positions = Vec::new();
    for y in 0..4 {
        for x in 0..4 {
            positions.push([f64::from(x), f64::from(y), 0.0]);
        }
    }
    let cell = |x: u32, y: u32| [4 * y + x, 4 * y + x + 1, 4 * y + x + 5, 4 * y + x + 4];
    let faces_of = |cells: &[(u32, u32)]| {
        let quads: Vec<[u32; 4]> = cells.iter().map(|&(x, y)| cell(x, y)).collect();
        let polygons: Vec<(&[u32], u32)> = quads.iter().map(|q| (q.as_slice(), GREY)).collect();
        cleaned(&soup(&positions, &polygons)).0
    };
    assert_eq!(faces_of(&[(0, 0), (1, 1)]).faces.len(), 2);

    // An annulus whose hole meets the outline at vertex 5 stays one face with an outline and a hole.
    let pinched = faces_of(&[(1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]);
    assert_eq!(pinched.faces.len(), 1);
    assert_eq!(pinched.faces[FaceId(0)].loops.len(), 2);
    assert!((pinched.faces[FaceId(0)].area - 7.0).abs() < 1e-12);

    // Pinched at two opposite corners it falls into two faces.
    let cut = faces_of(&[(1, 0), (2, 0), (2, 1), (0, 1), (0, 2), (1, 2)]);
    assert_eq!(cut.faces.len(), 2);
}

#[test]
fn a_corner_of_a_slit_polygon_is_visited_twice() {
    // The keyhole way to write a hole: outline and hole joined by an edge that is walked both ways.
    let mut raw = plate();
    raw.polygons.truncate(1);
    raw.polygons[0].corners = vec![0, 1, 2, 3, 0, 4, 7, 6, 5, 4];
    let (scene, _) = cleaned(&raw);
    assert_eq!(scene.faces[FaceId(0)].loops.len(), 2);
    assert!((scene.faces[FaceId(0)].area - 8.0).abs() < 1e-12);
}
