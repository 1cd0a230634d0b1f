//! The lines that the search finds, held against closed forms.

pub(crate) mod cities;
mod growth;
mod lamps;
mod measure;
mod segment;

use crate::common::library::{faces_of, local_mesh, regression_world, world_of};
use crate::common::scenes::fixture_names;
use crate::common::tables::rows;
use glam::DVec3;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{
    Cause, Discontinuity, DiscontinuityOrder, EventKind, FaceLines, LineTolerance, find_lines,
    penumbra_width,
};
use umbrage::pipeline::World;
use umbrage::scene::{FaceId, FaceSide};

/// Coordinates of found lines may be off by this share of the scene's size: some thousand roundings.
const LINE_ACCURACY: f64 = 1e-12;

/// Both sides of one face of `object`: front, then back.
fn lines_on(world: &World, object: &str) -> [FaceLines; 2] {
    let face = faces_of(&world.scene, object)[0];
    lines_of_face(world, face)
}

fn lines_of_face(world: &World, face: FaceId) -> [FaceLines; 2] {
    let light = DirectLight::new(&world.scene, &world.blockers);
    let mut lines = find_lines(&world.scene, &light, LineTolerance::default());
    [FaceSide::Front, FaceSide::Back].map(|side| lines.take(face, side))
}

/// Whether a line has these ends, in either order, in the coordinates of the file.
fn has_ends(world: &World, line: &Discontinuity, ends: [DVec3; 2]) -> bool {
    let near = |p: DVec3, q: DVec3| {
        (p - (q - world.scene.origin)).length() <= LINE_ACCURACY * world.scene.diagonal
    };
    let [a, b] = line.ends;
    (near(a, ends[0]) && near(b, ends[1])) || (near(a, ends[1]) && near(b, ends[0]))
}

/// Exactly these lines, each once.
#[track_caller]
fn assert_lines(world: &World, found: &[Discontinuity], expected: &[[DVec3; 2]], what: &str) {
    let listing = || format!("{what}: {found:#?}");
    assert_eq!(found.len(), expected.len(), "{}", listing());
    for &ends in expected {
        let count = found.iter().filter(|l| has_ends(world, l, ends)).count();
        assert_eq!(count, 1, "{ends:?} in {}", listing());
    }
}

#[test]
fn penumbra_of_a_square_is_drawn_by_eight_lines_of_its_closed_form() {
    let [_, _, _, _, outer, umbra] = rows("penumbra", "square_over_square")[0][..] else {
        panic!("six numbers a row")
    };
    let mut checked = 0;
    for (suffix, scale, times) in [
        ("", 1.0, 0.0),
        ("-t1e4", 1.0, 1e4),
        ("-t1e6", 1.0, 1e6),
        ("-s1e-3", 1e-3, 0.0),
        ("-s1e3", 1e3, 0.0),
    ] {
        let name = format!("square-over-square{suffix}");
        let world = world_of(&name);
        // The move counts in multiples of the size of 8 m.
        let place = |x: f64, z: f64| DVec3::new(x, 0.0, z) * scale + DVec3::splat(8.0 * times);
        let mut expected = Vec::new();
        for half in [outer, umbra] {
            for side in [-half, half] {
                // From one outer corner of the penumbra to the next: the umbra's sides run on through the penumbra.
                expected.push([place(side, -outer), place(side, outer)]);
                expected.push([place(-outer, side), place(outer, side)]);
            }
        }
        let [front, back] = lines_on(&world, "floor");
        assert_lines(&world, &front.candidates, &expected, &name);
        assert!(
            front
                .candidates
                .iter()
                .all(|l| l.order == DiscontinuityOrder::D1)
        );
        assert!(front.contacts.is_empty() && back.candidates.is_empty());
        checked += 1;
    }
    let versions = fixture_names();
    let versions = versions
        .iter()
        .filter(|n| n.starts_with("square-over-square"));
    assert_eq!(checked, versions.count());
}

#[test]
fn each_pair_of_coplanar_edges_draws_one_line_of_slope() {
    let world = world_of("coplanar-edges");
    let mesh = local_mesh("coplanar-edges", &world.scene);
    let edges = |object: &str| -> Vec<[DVec3; 2]> {
        let polygon = mesh.polygons.iter().find(|p| p.object == object);
        let corners = &polygon.expect("the object is there").corners;
        (0..corners.len())
            .map(|i| [corners[i], corners[(i + 1) % corners.len()]])
            .collect()
    };
    let [front, _] = lines_on(&world, "floor");
    let slope_lines: Vec<&Discontinuity> = front
        .candidates
        .iter()
        .filter(|l| l.order == DiscontinuityOrder::D1)
        .collect();
    let mut pairs = 0;
    for e in edges("lamp") {
        for b in edges("blocker") {
            // The edges are 1 m long and the coordinates multiples of 2⁻¹⁶ m.
            let normal = (e[1] - e[0]).cross(b[0] - e[0]).normalize();
            if normal.dot(b[1] - b[0]).abs() > f64::from(f32::EPSILON) {
                continue;
            }
            pairs += 1;
            let on_plane = slope_lines.iter().filter(|l| {
                l.ends
                    .iter()
                    .all(|&p| normal.dot(p - e[0]).abs() <= LINE_ACCURACY * world.scene.diagonal)
            });
            assert_eq!(on_plane.count(), 1, "{e:?} and {b:?}: {slope_lines:#?}");
        }
    }
    assert_eq!(pairs, 6);
    assert_eq!(slope_lines.len(), pairs, "{slope_lines:#?}");
}

#[test]
fn plane_of_an_emitter_draws_its_horizon() {
    let world = world_of("emitter-plane-on-receiver");
    let [front, back] = lines_on(&world, "floor");
    let ends = [DVec3::new(-0.5, 0.0, -3.0), DVec3::new(-0.5, 0.0, 3.0)];
    assert_lines(&world, &front.candidates, &[ends], "floor");
    assert_eq!(front.candidates[0].order, DiscontinuityOrder::D1);
    assert_eq!(front.candidates[0].kind, EventKind::Horizon);
    assert!(front.contacts.is_empty() && back.candidates.is_empty());
}

#[test]
fn plane_of_a_receiver_draws_nothing_on_it() {
    let world = world_of("receiver-through-emitter");
    let [front, back] = lines_on(&world, "floor");
    let is_horizon = |l: &&Discontinuity| l.kind == EventKind::Horizon;
    assert_eq!(front.candidates.iter().filter(is_horizon).count(), 0);
    assert_eq!(back.candidates.iter().filter(is_horizon).count(), 0);
}

/// Foot of the wall in the scenes with a wall.
const FOOT: [DVec3; 2] = [
    DVec3::new(-0.158_935_546_875, 0.0, -0.784_057_617_187_5),
    DVec3::new(0.158_935_546_875, 0.0, 0.784_057_617_187_5),
];

#[test]
fn wall_on_the_floor_touches_the_front_only() {
    let world = world_of("blocker-touching-floor");
    let [front, back] = lines_on(&world, "floor");
    assert_lines(&world, &front.contacts, &[FOOT], "front of the floor");
    assert_eq!(front.contacts[0].order, DiscontinuityOrder::D0);
    assert!(back.contacts.is_empty(), "{:#?}", back.contacts);
    // Its own foot is the wall's border.
    for side in lines_on(&world, "wall") {
        assert!(side.contacts.is_empty(), "{:#?}", side.contacts);
    }
}

#[test]
fn wall_through_the_floor_draws_on_both_sides_of_both() {
    let world = world_of("wall-piercing-floor");
    for object in ["floor", "wall"] {
        for side in lines_on(&world, object) {
            assert_lines(&world, &side.contacts, &[FOOT], object);
            assert_eq!(side.contacts[0].order, DiscontinuityOrder::D0);
        }
    }
}

#[test]
fn boxes_on_a_table_draw_their_feet_on_its_top() {
    for (suffix, scale, times) in [
        ("", 1.0, 0.0),
        ("-t1e4", 1.0, 1e4),
        ("-t1e6", 1.0, 1e6),
        ("-s1e-3", 1e-3, 0.0),
        ("-s1e3", 1e3, 0.0),
    ] {
        let name = format!("box-on-table{suffix}");
        let world = world_of(&name);
        let mesh = local_mesh(&name, &world.scene);
        let top = (0.75 * scale + 8.0 * times) - world.scene.origin.y;
        let is_on_top = |p: &DVec3| (p.y - top).abs() <= LINE_ACCURACY * world.scene.diagonal;
        let mut expected: Vec<[DVec3; 2]> = Vec::new();
        for polygon in &mesh.polygons {
            let c = &polygon.corners;
            // The walls of the boxes, not the bottom of one of them.
            if polygon.object.ends_with("-box") && !c.iter().all(is_on_top) {
                let edges = (0..c.len()).map(|i| [c[i], c[(i + 1) % c.len()]]);
                expected.extend(edges.filter(|e| e.iter().all(is_on_top)));
            }
        }
        assert_eq!(expected.len(), 8);
        for ends in &mut expected {
            *ends = ends.map(|p| p + world.scene.origin);
        }
        let faces = faces_of(&world.scene, "table-top");
        let is_up = |f: &&FaceId| world.scene.faces[**f].frame.n.y > 0.5;
        let face = *faces.iter().find(is_up).expect("a table has a top");
        let [front, back] = lines_of_face(&world, face);
        assert_lines(&world, &front.contacts, &expected, &name);
        assert!(back.contacts.is_empty(), "{name}: {:#?}", back.contacts);
        let [floor, below] = lines_on(&world, "floor");
        assert!(floor.contacts.is_empty() && below.contacts.is_empty());
    }
}

#[test]
fn no_line_gets_through_what_a_box_stands_on_or_into_the_box() {
    let world = regression_world("box-on-two-sheets");
    let box_faces = faces_of(&world.scene, "box");
    let insides = box_faces.into_iter().map(|f| (f, FaceSide::Back));
    let lower = faces_of(&world.scene, "lower")[0];
    let dark = insides.chain([(lower, FaceSide::Front), (lower, FaceSide::Back)]);
    for (face, side) in dark {
        let [front, back] = lines_of_face(&world, face);
        let lines = if side == FaceSide::Front { front } else { back };
        assert!(
            lines.candidates.is_empty(),
            "{side:?} of {face:?}: {:#?}",
            lines.candidates
        );
    }
}

#[test]
fn penumbrae_are_as_wide_as_the_lamp_looks_from_the_blocker() {
    // A lamp of side 1 with a blocker halfway down: the shadow moves as far as its generator does over the lamp, across
    // the shadow's edge. That is 1 for edges of the lamp, and cos t + sin t for blocker edges turned by t against it.
    for (name, turn) in [("square-over-square", 0.0_f64), ("rotated-blocker", 0.3)] {
        let world = world_of(name);
        let [front, _] = lines_on(&world, "floor");
        let mut count = 0;
        for line in &front.candidates {
            let expected = match line.cause {
                Cause::VertexEdge(..) => turn.cos() + turn.sin(),
                _ => 1.0,
            };
            let widths = penumbra_width(&world.scene, line).expect("an edge or a vertex made it");
            for width in widths {
                // The fixture's coordinates are rounded to 1/65536.
                assert!((width - expected).abs() < 1e-3, "{name}: {width}, {line:?}");
                count += 1;
            }
        }
        assert!(count >= 16, "{name}: {count}");
    }
}
