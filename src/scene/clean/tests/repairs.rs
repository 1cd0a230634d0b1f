//! Soups with one trouble each.

use super::*;

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

#[test]
fn a_lone_square_keeps_its_corners_only() {
    // The first vertex, where a walk around it starts, is not one of them.
    let raw = soup(
        &[
            [1.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [2.0, 2.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.0, 0.5, 0.0],
            [0.0, 0.0, 0.0],
        ],
        &[(&[0, 1, 2, 3, 4, 5, 6], GREY)],
    );
    let (scene, report) = cleaned(&raw);
    assert_eq!((report.straightened, scene.vertices.len()), (3, 4));
}

#[test]
fn a_straight_run_parallel_to_the_chain_thins_too() {
    // Between the two ends of the fin the outline makes a detour whose far side has a vertex in its middle.
    let raw = soup(
        &[
            [0.0, 0.0, 0.0],
            [3.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [1.5, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [3.0, 0.0, 1.0],
        ],
        &[(&[0, 1, 2, 3, 4], GREY), (&[0, 5, 6, 1], GREY)],
    );
    let (scene, report) = cleaned(&raw);
    assert_eq!((report.straightened, scene.vertices.len()), (1, 6));
}
