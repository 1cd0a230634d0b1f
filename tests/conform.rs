//! The lit meshes as a viewer gets them: no T-junction, no gap, no overlap, nothing that is not a number, no leak.

use crate::common::bake::{bake, world};
use crate::common::scenes::fixture;
use glam::{DVec3, Vec3, Vec3Swizzles};
use std::collections::{BTreeMap, BTreeSet};
use umbrage::io::{ReadSettings, read_lit, read_scene, write_glb};
use umbrage::lit_scene::{LitMesh, LitScene};
use umbrage::pipeline::{Solution, World};
use umbrage::radiosity::Bounces;
use umbrage::scene::{FaceId, Scene};
use umbrage::settings::Settings;

/// Scenes with shared edges, contacts, covered parts and holes.
const SCENES: [&str; 5] = [
    "box-on-table",
    "wall-piercing-floor",
    "emitter-with-hole",
    "two-emitters",
    "furnace-l-room-r50",
];

/// A position as the file holds it.
type Key = [u32; 3];

fn key(p: DVec3) -> Key {
    // Adding zero makes one of both zeros.
    (p.as_vec3() + Vec3::ZERO).to_array().map(f32::to_bits)
}

fn each(check: impl Fn(&str, &World, &Solution, &LitScene)) {
    for name in SCENES {
        let world = world(name);
        let solution = bake(&world, 0.03, Bounces::Count(0));
        check(name, &world, &solution, &solution.lit_scene());
    }
}

fn corners(mesh: &LitMesh, t: [u32; 3]) -> [DVec3; 3] {
    t.map(|i| mesh.positions[i as usize])
}

#[test]
fn light_and_positions_are_numbers() {
    each(|name, _, _, lit| {
        for mesh in &lit.meshes {
            assert_eq!(mesh.positions.len(), mesh.irradiance.len(), "{name}");
            let is_good = |e: &DVec3| e.is_finite() && e.min_element() >= 0.0;
            assert!(mesh.positions.iter().all(|p| p.is_finite()), "{name}");
            assert!(mesh.irradiance.iter().all(|e| is_good(&e.0.0)), "{name}");
        }
    });
}

#[test]
fn every_triangle_keeps_its_area_in_single_precision() {
    each(|name, _, _, lit| {
        for mesh in &lit.meshes {
            for &t in &mesh.triangles {
                let [a, b, c] = corners(mesh, t).map(|p| p.as_vec3().as_dvec3());
                let n = (b - a).cross(c - a);
                assert!(
                    n.dot(mesh.normal) > 0.0,
                    "{name}, face {}: a triangle of area {:e} at {a}, {b}, {c}",
                    mesh.face,
                    n.dot(mesh.normal) / 2.0
                );
            }
        }
    });
}

#[test]
fn triangles_fill_their_face_exactly() {
    each(|name, world, solution, lit| {
        for mesh in &lit.meshes {
            let face = &world.scene.faces[FaceId(mesh.face)];
            let receiver = solution
                .receivers
                .iter()
                .find(|r| r.domain.face.0 == mesh.face && r.domain.normal == mesh.normal)
                .expect("every mesh has its receiver");
            let covers = receiver.lines.covers.iter();
            let covered: f64 = covers.map(|&c| world.scene.faces[c].area).sum();
            let found: f64 = mesh
                .triangles
                .iter()
                .map(|&t| {
                    let [a, b, c] = corners(mesh, t);
                    (b - a).cross(c - a).dot(mesh.normal) / 2.0
                })
                .sum();
            let expected = face.area - covered;
            assert!(
                (found - expected).abs() <= 1e-6 * face.area,
                "{name}, face {}: {found} m² of {expected}",
                mesh.face
            );
        }
    });
}

/// Directed edges that have no opposite in their own mesh.
fn border(mesh: &LitMesh) -> Vec<[DVec3; 2]> {
    let mut uses: BTreeMap<[Key; 2], (i32, [DVec3; 2])> = BTreeMap::new();
    for &t in &mesh.triangles {
        let p = corners(mesh, t);
        for k in 0..3 {
            let ends = [p[k], p[(k + 1) % 3]];
            let [a, b] = ends.map(key);
            uses.entry([a, b]).or_insert((0, ends)).0 += 1;
            uses.entry([b, a]).or_insert((0, [ends[1], ends[0]])).0 -= 1;
        }
    }
    let alone = uses.into_values().filter(|u| u.0 > 0);
    alone.map(|u| u.1).collect()
}

/// True when both ends lie on the segment `a`–`b`.
fn lie_on([p, q]: [DVec3; 2], [a, b]: [DVec3; 2], tolerance: f64) -> bool {
    [p, q].iter().all(|&x| {
        let t = ((x - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        x.distance(a.lerp(b, t)) <= tolerance
    })
}

fn is_on_an_edge_of(scene: &Scene, face: u32, ends: [DVec3; 2]) -> bool {
    let edges = scene.faces[FaceId(face)].loop_edges.iter().flatten();
    edges.into_iter().any(|&e| {
        let segment = scene.edges[e].ends.map(|v| scene.vertices[v]);
        lie_on(ends, segment, scene.weld_distance)
    })
}

#[test]
fn meshes_end_only_at_the_edges_of_their_faces() {
    each(|name, world, solution, lit| {
        let scene = &world.scene;
        for mesh in &lit.meshes {
            let receiver = solution
                .receivers
                .iter()
                .find(|r| r.domain.face.0 == mesh.face && r.domain.normal == mesh.normal)
                .expect("every mesh has its receiver");
            for ends in border(mesh) {
                let covers = receiver.lines.covers.iter();
                assert!(
                    is_on_an_edge_of(scene, mesh.face, ends)
                        || covers
                            .into_iter()
                            .any(|c| is_on_an_edge_of(scene, c.0, ends)),
                    "{name}, face {}: a crack along {ends:?}",
                    mesh.face
                );
            }
        }
    });
}

#[test]
fn neighbours_share_their_vertices() {
    let mut shared = 0;
    for name in SCENES {
        let world = world(name);
        let lit = bake(&world, 0.03, Bounces::Count(0)).lit_scene();
        let scene = &world.scene;
        // Pieces of mesh borders along each edge of the scene, by mesh.
        for edge in scene.edges.ids() {
            let segment = scene.edges[edge].ends.map(|v| scene.vertices[v]);
            let mut pieces: Vec<BTreeSet<[Key; 2]>> = Vec::new();
            for mesh in &lit.meshes {
                let is_user = scene.edges[edge].uses.iter().any(|u| u.face.0 == mesh.face);
                if !is_user {
                    continue;
                }
                let found = border(mesh)
                    .into_iter()
                    .filter(|&ends| lie_on(ends, segment, scene.weld_distance))
                    .map(|ends| {
                        let mut pair = ends.map(key);
                        pair.sort_unstable();
                        pair
                    });
                pieces.push(found.collect());
            }
            for two in pieces.windows(2) {
                assert_eq!(two[0], two[1], "{name}: a T-junction along {segment:?}");
                shared += two[0].len();
            }
        }
    }
    assert!(shared > 100, "only {shared} pieces were compared");
}

/// True inside the footprint of the box without bottom on the table of `box-on-table`.
fn is_in_open_box(p: DVec3) -> bool {
    let footprint = [
        [-0.527_099_609_375, 0.016_311_645_507_812_5],
        [-0.250_778_198_242_187_5, -0.100_524_902_343_75],
        [-0.172_897_338_867_187_5, 0.083_694_458_007_812_5],
        [-0.449_218_75, 0.200_515_747_070_312_5],
    ]
    .map(glam::DVec2::from);
    (0..4).all(|i| {
        let (a, b) = (footprint[i], footprint[(i + 1) % 4]);
        (b - a).perp_dot(p.xz() - a) > 0.0
    })
}

#[test]
fn no_light_leaks_across_a_contact_line() {
    let world = world("box-on-table");
    // Shares of the hemisphere are differences of angles: what nothing is left of may be a rounding.
    for (bounces, dark_enough) in [(Bounces::Count(0), 0.0), (Bounces::All, 1e-15)] {
        let lit = bake(&world, 0.05, bounces).lit_scene();
        let (mut dark, mut area) = (0, 0.0);
        // Vertices of the table on the outline of the box: dark from inside, lit from outside somewhere.
        let (mut inside, mut outside) = (BTreeSet::new(), BTreeSet::new());
        for mesh in lit.meshes.iter().filter(|m| m.normal.y > 0.9) {
            for &t in &mesh.triangles {
                let p = corners(mesh, t);
                let middle = p.iter().sum::<DVec3>() / 3.0 + lit.origin;
                if (middle.y - 0.75).abs() > 1e-6 {
                    continue;
                }
                if is_in_open_box(middle) {
                    dark += 1;
                    area += (p[1] - p[0]).cross(p[2] - p[0]).length() / 2.0;
                    inside.extend(p.map(key));
                    for i in t {
                        let e = mesh.irradiance[i as usize];
                        assert!(
                            e.0.0.max_element() <= dark_enough,
                            "{e:?} under the box, {bounces:?}"
                        );
                    }
                } else {
                    let lit = t.iter().zip(p);
                    let lit = lit.filter(|(i, _)| !mesh.irradiance[**i as usize].0.is_black());
                    outside.extend(lit.map(|(_, p)| key(p)));
                }
            }
        }
        assert!(dark > 0, "the table has no elements under the box");
        assert!((area - 0.06).abs() < 1e-4, "{area} m² under the box");
        let jumps = inside.intersection(&outside).count();
        assert!(
            jumps >= 4,
            "the light jumps at {jumps} vertices, {bounces:?}"
        );
    }
}

/// Coordinates as land surveyors use them: far more digits before the point than single precision has.
#[test]
fn a_scene_far_off_stands_in_the_file_where_it_stood() {
    let away = DVec3::new(4_500_000.3, 120.7, -560_000.1);
    let path = fixture("square-over-square");
    let mut raw = read_scene(&path, &ReadSettings::default()).expect("a fixture");
    raw.positions.iter_mut().for_each(|p| *p += away);
    let settings = Settings {
        error: 0.1,
        bounces: Bounces::Count(0),
        ..Settings::default()
    };
    let baked = umbrage::bake(&raw, &settings).expect("a bake");
    let model = read_lit("far.glb", &write_glb(&baked.scene)).expect("our own file");
    let shown = || model.parts.iter().flat_map(|part| &part.positions);
    let size = {
        let [low, high] = model.bounds().expect("surfaces");
        low.distance(high)
    };
    // Each corner of the input is there, to single precision of the scene's size.
    for p in &raw.positions {
        let nearest = shown()
            .map(|q| q.distance(*p))
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < f64::from(f32::EPSILON) * size, "{nearest} m off");
    }
}
