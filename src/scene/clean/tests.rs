//! Small soups with one trouble each, and (ignored) large ones for the clock.

use super::*;
use crate::quantity::{Radiance, Rgb};
use crate::scene::RawPolygon;
use std::f64::consts::FRAC_PI_3;

mod files;
mod fuzz;
mod large;

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
        emits_back: false,
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

/// Fails where a vertex lies within the weld distance of another one or of an edge that does not end there.
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
            let is_off = (p - d * t).length() > reach;
            assert!(
                edge.ends.contains(&v) || is_off,
                "vertex {v}, edge {id}: {} of {reach} ends {:?} t {t}",
                (p - d * t).length(),
                edge.ends
            );
        });
    }
}

/// The numbers that must not depend on place, size or order.
fn counts(report: &CleanReport) -> CleanReport {
    CleanReport {
        weld_distance_m: 0.0,
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
fn a_vertex_in_the_middle_of_an_edge_is_inserted() {
    // A wall of one quad below two narrower ones of another material.
    let raw = soup(
        &[
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.7, 1.0, 0.0],
            [0.7, 2.0, 0.0],
            [0.0, 2.0, 0.0],
            [2.0, 2.0, 0.0],
        ],
        &[
            (&[0, 1, 2, 3], GREY),
            (&[3, 4, 5, 6], RED),
            (&[4, 2, 7, 5], LAMP),
        ],
    );
    let (scene, report) = cleaned(&raw);
    assert_eq!((report.t_junctions, report.faces), (1, 3));
    assert_eq!(scene.faces[FaceId(0)].loops[0].len(), 5);
    assert_eq!(report.boundary_edges, 7);
    assert_eq!(report.emitters, 1);
}

#[test]
fn vertices_on_straight_edges_vanish_where_no_other_face_ends() {
    // A floor of two cells, a wall of two cells on one side of it, and a fin at the seam on the other side.
    let positions = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [2.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [2.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, 2.0, 0.0],
    ];
    let raw = soup(
        &positions,
        &[
            (&[0, 1, 4, 3], GREY),
            (&[1, 2, 5, 4], GREY),
            (&[0, 6, 7, 1], GREY),
            (&[1, 7, 8, 2], GREY),
            (&[4, 10, 9], GREY),
        ],
    );
    let (scene, report) = cleaned(&raw);
    assert_eq!((report.faces, report.straightened), (3, 2));
    assert_eq!(scene.faces[FaceId(0)].loops[0].len(), 5);
    assert_eq!(scene.faces[FaceId(1)].loops[0].len(), 4);
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
fn a_gap_of_float32_rounding_closes() {
    let raw = soup(
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0 + 1e-8, 0.0, 1e-8],
            [2.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [1.0, 1.0 - 1e-8, 0.0],
        ],
        &[(&[0, 1, 2, 3], GREY), (&[4, 5, 6, 7], GREY)],
    );
    let (_, report) = cleaned(&raw);
    assert_eq!((report.welded, report.faces), (2, 1));
}

#[test]
fn a_quad_that_bends_becomes_triangles() {
    let raw = soup(
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.01],
            [0.0, 1.0, 0.0],
        ],
        &[(&[0, 1, 2, 3], GREY)],
    );
    let (_, report) = cleaned(&raw);
    assert_eq!((report.bent, report.faces), (1, 2));
}

#[test]
fn a_needle_vanishes_and_its_corner_goes_into_the_edge() {
    let raw = soup(
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.5, 1e-9, 0.0],
            [0.5, 1.0, 0.0],
            [0.5, 0.0, 1.0],
        ],
        &[
            (&[0, 1, 2], GREY),
            (&[0, 2, 3], GREY),
            (&[2, 1, 3], GREY),
            (&[0, 1, 4], GREY),
        ],
    );
    let (_, report) = cleaned(&raw);
    assert_eq!(
        (report.degenerate, report.t_junctions, report.faces),
        (1, 1, 2)
    );
}

#[test]
fn of_doubled_polygons_one_stays() {
    let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let raw = soup(
        &triangle,
        &[
            (&[0, 1, 2], GREY),
            (&[1, 2, 0], LAMP),
            (&[2, 1, 0], GREY),
            (&[0, 1, 2], GLASS),
        ],
    );
    let (scene, report) = cleaned(&raw);
    assert_eq!(
        (report.duplicates, report.see_through, report.faces),
        (2, 1, 1)
    );
    assert_eq!(scene.faces[FaceId(0)].material, LAMP);

    let sheet = soup(
        &triangle,
        &[(&[0, 1, 2], ONE_SIDED), (&[2, 1, 0], ONE_SIDED)],
    );
    assert_eq!(cleaned(&sheet).1.faces, 2);
    let lamp = soup(&triangle, &[(&[0, 1, 2], LAMP), (&[2, 1, 0], LAMP)]);
    assert_eq!(cleaned(&lamp).1.emitters, 2);
}

#[test]
fn of_faces_with_the_same_outline_one_stays() {
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let polygons: [(&[u32], u32); 4] = [
        (&[0, 1, 2], GREY),
        (&[0, 2, 3], GREY),
        (&[3, 1, 0], GREY),
        (&[3, 2, 1], GREY),
    ];
    let (_, report) = cleaned(&soup(&square, &polygons));
    assert_eq!((report.duplicate_faces, report.faces), (1, 1));
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
fn a_polygon_that_crosses_itself_is_named() {
    let raw = soup(
        &[
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [4.0, 1.0, 0.0],
            [0.0, 3.0, 0.0],
            [9.0, 0.0, 0.0],
        ],
        &[(&[1, 4, 2], GREY), (&[0, 1, 3, 2], GREY)],
    );
    let (_, report, warnings) = clean(&raw, &CleanSettings::default()).expect("one is left");
    assert_eq!((report.self_crossing, report.faces), (1, 1));
    assert!(warnings.iter().any(|w| w.message.ends_with("number 2")));
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

#[test]
fn nothing_left_is_bad_input() {
    let line = soup(
        &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        &[(&[0, 1, 2], GREY)],
    );
    assert!(clean(&line, &CleanSettings::default()).is_err());
    assert!(clean(&soup(&[], &[]), &CleanSettings::default()).is_err());
    let broken = soup(&[[0.0; 3]], &[(&[0, 1, 2], GREY)]);
    assert!(clean(&broken, &CleanSettings::default()).is_err());
}
