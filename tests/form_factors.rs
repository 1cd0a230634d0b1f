//! Form factors of polygons and of scenes, where they are known.

use crate::common::bake::world;
use crate::common::library::world_of_mesh;
use crate::common::obj_lite::ObjMesh;
use crate::common::tables::rows;
use glam::DVec3;
use umbrage::form_factor::{FLAT, FormFactors, Patch, between, past};
use umbrage::pipeline::World;
use umbrage::scene::{FaceId, FaceSide, IdVec};

/// Half a unit of the tables' last digit, and as much again.
const TABLE_DIGITS: f64 = 1e-10;

fn patch(corners: &[[f64; 3]]) -> Patch {
    let corners: Vec<DVec3> = corners.iter().map(|&c| c.into()).collect();
    Patch::new(&corners, FLAT).unwrap_or_else(|e| panic!("{e}"))
}

/// A rectangle at height `y` that faces up, or down.
fn level(x: [f64; 2], z: [f64; 2], y: f64, is_up: bool) -> Vec<[f64; 3]> {
    let mut corners = vec![
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

const UNIT: [f64; 2] = [0.0, 1.0];

#[test]
fn parallel_squares() {
    for row in rows("form_factors", "parallel_unit_squares") {
        let floor = patch(&level(UNIT, UNIT, 0.0, true));
        let lid = patch(&level(UNIT, UNIT, row[0], false));
        let found = between(&floor, &lid, 1e-12).from_first();
        let off = (found.value - row[1]).abs();
        assert!(
            off <= TABLE_DIGITS && found.error <= 1e-13,
            "at {}: {found:?}",
            row[0]
        );
    }
}

#[test]
fn a_closed_cube_sums_to_one_by_closed_forms_alone() {
    let floor = patch(&level(UNIT, UNIT, 0.0, true));
    let lid = patch(&level(UNIT, UNIT, 1.0, false));
    let wall = patch(&[[0., 0., 0.], [0., 1., 0.], [0., 1., 1.], [0., 0., 1.]]);
    let beside = between(&floor, &wall, 1e-15).from_first();
    let expected = rows("form_factors", "perpendicular_unit_squares")[0][0];
    assert!((beside.value - expected).abs() <= 1e-13, "{beside:?}");
    let above = between(&floor, &lid, 1e-15).from_first();
    let sum = 4.0 * beside.value + above.value;
    assert!((sum - 1.0).abs() <= 1e-15, "{sum}");
}

#[test]
fn infinite_strips() {
    // Off by half the square of width over length.
    let length = [-1e4, 1e4];
    let floor = patch(&level(UNIT, length, 0.0, true));
    let lid = patch(&level(UNIT, length, 1.0, false));
    let found = between(&floor, &lid, 1e-9).from_first();
    let expected = rows("form_factors", "infinite_strips")[0][0];
    // What escapes at the two ends is of the order of the gap over the length.
    assert!(
        (found.value - expected).abs() <= 1.0 / length[1],
        "{found:?}"
    );
    // Half as long ends lose twice as much of it: extrapolated they lose nothing.
    let half = length.map(|z| 0.5 * z);
    let shorter = between(
        &patch(&level(UNIT, half, 0.0, true)),
        &patch(&level(UNIT, half, 1.0, false)),
        1e-9,
    );
    let limit = 2.0 * found.value - shorter.from_first().value;
    let slack = 1e-8 + 2.0 * found.error + shorter.from_first().error;
    assert!((limit - expected).abs() <= slack, "{limit} ± {slack:e}");
}

/// Unit squares at heights 0 and 1 that face each other, and a blocker over `x` × `x` at `height`.
fn squares_past(x: [f64; 2], height: f64) -> World {
    let mut mesh = ObjMesh::default();
    mesh.add(&level(UNIT, UNIT, 0.0, true), 0.1, 0.0);
    mesh.add(&level(UNIT, UNIT, 1.0, false), 0.2, 0.0);
    mesh.add(&level(x, x, height, true), 0.3, 0.0);
    world_of_mesh("squares past a blocker", &mesh)
}

/// The side of the face with reflectance `kd` that faces up or down.
fn side(world: &World, kd: f64, is_up: bool) -> Patch {
    let faces: &IdVec<FaceId, _> = &world.scene.faces;
    let (id, face) = faces
        .iter()
        .find(|(_, f)| (f.reflectance.0.x - kd).abs() < 1e-9)
        .expect("a face of this reflectance");
    let side = if (face.frame.n.y > 0.0) == is_up {
        FaceSide::Front
    } else {
        FaceSide::Back
    };
    let pieces = Patch::of_side(&world.scene, id, side);
    assert_eq!(pieces.len(), 1, "a square is one convex piece");
    pieces[0].clone()
}

#[test]
fn squares_past_a_blocker() {
    let cases = [
        ([0.25, 0.75], 0.75, "shapiro"),
        ([0.25, 0.75], 0.5, "centred_blocker_at_half"),
        ([0.0, 0.5], 0.5, "corner_blocker_at_half"),
    ];
    for (x, height, name) in cases {
        let world = squares_past(x, height);
        let (floor, lid) = (side(&world, 0.1, true), side(&world, 0.2, false));
        let found = past(&floor, &lid, &world.blockers, 1e-8);
        assert_eq!(found, past(&floor, &lid, &world.blockers, 1e-8));
        let back = past(&lid, &floor, &world.blockers, 1e-8);
        assert_eq!(found.area.to_bits(), back.area.to_bits(), "{name}");
        let found = found.from_first();
        let expected = rows("form_factors", name)[0][0];
        let off = (found.value - expected).abs();
        eprintln!("{name}: {found:?}, {off:e} off");
        assert!(off <= 1e-8 && found.error <= 1e-8, "{name}: {found:?}");
    }
}

#[test]
fn shapiros_blocker_is_seen_from_below() {
    let world = squares_past([0.25, 0.75], 0.75);
    let (floor, blocker) = (side(&world, 0.1, true), side(&world, 0.3, false));
    let found = past(&floor, &blocker, &world.blockers, 1e-12);
    let row = &rows("form_factors", "shapiro")[0];
    for (f, expected) in [(found.from_first(), row[1]), (found.from_second(), row[2])] {
        assert!(f.is_proven, "nothing stands between: {f:?}");
        assert!((f.value - expected).abs() <= TABLE_DIGITS, "{f:?}");
    }
}

/// All fronts of closed rooms look into them: Σ F = 1. Backs may see each other outside.
fn check_closed(name: &str, tolerance: f64) {
    let world = world(name);
    let found = FormFactors::new(&world.scene, &world.blockers, tolerance);
    let n = found.sides.len();
    let mut worst = 0.0_f64;
    for i in 0..n {
        let row = found.row_sum(i);
        let off = (row.value - 1.0).abs();
        if found.sides[i].1 == FaceSide::Front {
            worst = worst.max(off);
            assert!(
                off <= row.error.max(tolerance),
                "{name}: side {:?} sums to {row:?}",
                found.sides[i]
            );
        }
        assert!(
            row.value <= 1.0 + row.error.max(tolerance),
            "{name}: {row:?}"
        );
        for j in 0..n {
            let f = found.get(i, j);
            assert!((0.0..=1.0).contains(&f.value), "{name}: {f:?}");
            let back = found.get(j, i).value * found.areas[j];
            let off = (f.value * found.areas[i] - back).abs();
            assert!(off <= 4.0 * f64::EPSILON * back, "{name}: {f:?} and {back}");
        }
    }
    eprintln!("{name}: rows miss 1 by at most {worst:e}");
}

#[test]
fn rows_of_a_closed_box_sum_to_one() {
    check_closed("furnace-box-r50", 1e-12);
}

#[test]
fn rows_of_a_closed_l_room_sum_to_one() {
    check_closed("furnace-l-room-r50", 1e-4);
}

#[test]
#[ignore = "a minute: a room with two boxes to a hundred-thousandth"]
fn rows_of_a_closed_room_with_boxes_sum_to_one() {
    check_closed("furnace-cornell-r50", 1e-5);
}

/// The triangles of an icosahedron with corners on the unit sphere, each divided into four so many times; fronts inside.
fn sphere(divisions: u32) -> Vec<Patch> {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (a, b) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        points.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]].map(DVec3::from));
    }
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                // Edges have length 2, the next distance is 2 golden.
                let [a, b, c] = [points[i], points[j], points[k]];
                if [(a, b), (b, c), (c, a)]
                    .iter()
                    .all(|(p, q)| p.distance(*q) < 2.5)
                {
                    triangles.push([a, b, c].map(DVec3::normalize));
                }
            }
        }
    }
    for _ in 0..divisions {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let inwards = |[a, b, c]: [DVec3; 3]| {
        let normal = (b - a).cross(c - a);
        if normal.dot(a) < 0.0 {
            [a, b, c]
        } else {
            [a, c, b]
        }
    };
    triangles
        .into_iter()
        .map(|t| Patch::new(&inwards(t), FLAT).unwrap_or_else(|e| panic!("{e}")))
        .collect()
}

/// The largest deviation of the factor between two faces of the icosahedron, blown up to the sphere, from the share of the
/// sphere that each of them is, relative to that; and of any facet's row from 1. By symmetry one of the faces tells it all.
fn sphere_errors(divisions: u32) -> (f64, f64) {
    let facets = 4_usize.pow(divisions);
    let patches = sphere(divisions);
    let total: f64 = patches.iter().map(Patch::area).sum();
    let mut exchanges = vec![0.0; patches.len() / facets];
    let mut row_worst = 0.0_f64;
    for a in &patches[..facets] {
        let mut row = 0.0;
        for (j, b) in patches.iter().enumerate() {
            let found = between(a, b, 1e-13);
            row += found.from_first().value;
            exchanges[j / facets] += found.area;
        }
        row_worst = row_worst.max((row - 1.0).abs());
    }
    let share = total / exchanges.len() as f64;
    let expected = share * share / total;
    // The first face sees itself, as it is not flat.
    let off = exchanges.iter().map(|e| (e / expected - 1.0).abs());
    (off.fold(0.0, f64::max), row_worst)
}

#[test]
fn inside_a_sphere_factors_are_areas() {
    let (coarse, coarse_row) = sphere_errors(1);
    let (fine, fine_row) = sphere_errors(2);
    eprintln!("sphere: {coarse:.4} and {fine:.4} off, rows {coarse_row:e} and {fine_row:e}");
    assert!(
        coarse_row.max(fine_row) <= 1e-12,
        "{coarse_row:e}, {fine_row:e}"
    );
    // Facets lie off the sphere by the square of their size: a quarter at half the size.
    assert!(fine < 0.2 && fine < 0.4 * coarse, "{coarse} and {fine}");
}
