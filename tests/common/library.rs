//! The library's own world of a test scene, and the same scene for the references.

use super::obj_lite::{ObjMesh, Polygon, Surface};
use super::rng::Rng;
use super::scenes::{fixture, fixtures, read_fixture};
use glam::{DVec2, DVec3};
use std::path::PathBuf;
use umbrage::discontinuity::{Discontinuity, FaceLines};
use umbrage::io::{ReadSettings, read_scene};
use umbrage::pipeline::World;
use umbrage::quantity::{Radiance, Rgb};
use umbrage::scene::{FaceId, FaceSide, Material, RawPolygon, RawScene, Scene};
use umbrage::settings::Settings;

/// A scene of our own, cleaned as for a bake.
pub(crate) fn world_of(name: &str) -> World {
    let raw = read_scene(&fixture(name), &ReadSettings::default());
    world_of_raw(&raw.unwrap_or_else(|e| panic!("{name}: {e}")))
}

/// A scene of `fixtures/regressions`, cleaned as for a bake.
pub(crate) fn regression_world(name: &str) -> World {
    let raw = read_scene(&regression(name), &ReadSettings::default());
    world_of_raw(&raw.unwrap_or_else(|e| panic!("{name}: {e}")))
}

fn regression(name: &str) -> PathBuf {
    let directory = fixtures().join("regressions").join(name);
    directory.join(name).with_extension("obj")
}

/// The polygons of a scene of `fixtures/regressions` in the local coordinates of its world.
pub(crate) fn mesh_of_regression(name: &str, scene: &Scene) -> ObjMesh {
    moved(ObjMesh::read(&regression(name)), scene)
}

/// A scene, cleaned as for a bake.
pub(crate) fn world_of_raw(raw: &RawScene) -> World {
    World::new(raw, &Settings::default()).unwrap_or_else(|e| panic!("{}: {e}", raw.source))
}

/// A scene that a test made up, cleaned as for a bake: both sides reflect, fronts emit.
pub(crate) fn world_of_mesh(name: &str, mesh: &ObjMesh) -> World {
    world_of_raw(&raw_of_mesh(name, mesh))
}

/// A scene that a test made up, as a reader would hand it over: both sides reflect, fronts emit.
pub(crate) fn raw_of_mesh(name: &str, mesh: &ObjMesh) -> RawScene {
    let mut raw = RawScene {
        source: name.to_owned(),
        groups: vec![name.to_owned()],
        ..RawScene::default()
    };
    for surface in &mesh.surfaces {
        raw.materials.push(Material {
            name: surface.name.clone(),
            reflectance: Rgb(surface.kd),
            emission: Radiance(Rgb(surface.ke)),
            reflects_back: true,
            ..Material::default()
        });
    }
    let index = |i: usize| u32::try_from(i).expect("a test makes small scenes");
    for polygon in &mesh.polygons {
        let first = index(raw.positions.len());
        raw.positions.extend(&polygon.corners);
        raw.polygons.push(RawPolygon {
            corners: (first..index(raw.positions.len())).collect(),
            material: index(polygon.surface),
            group: 0,
        });
    }
    raw
}

/// The triangles of a cleaned scene in its local coordinates, for references that trace rays.
pub(crate) fn mesh_of_scene(scene: &Scene) -> ObjMesh {
    let mut mesh = ObjMesh::default();
    for (_, face) in scene.faces.iter() {
        mesh.surfaces.push(Surface {
            name: String::new(),
            kd: face.reflectance.0,
            ke: face.emission.0.0,
        });
        for t in &face.triangles {
            mesh.polygons.push(Polygon {
                corners: t.map(|v| scene.vertices[v]).to_vec(),
                surface: mesh.surfaces.len() - 1,
                object: String::new(),
            });
        }
    }
    mesh
}

/// The polygons of a scene of our own in the local coordinates of its world.
pub(crate) fn local_mesh(name: &str, scene: &Scene) -> ObjMesh {
    moved(read_fixture(name), scene)
}

/// A mesh in the local coordinates of its world.
pub(crate) fn moved(mut mesh: ObjMesh, scene: &Scene) -> ObjMesh {
    for corner in mesh.polygons.iter_mut().flat_map(|p| &mut p.corners) {
        *corner -= scene.origin;
    }
    mesh
}

/// Every side of every face that may receive light.
pub(crate) fn receiver_sides(scene: &Scene) -> Vec<(FaceId, FaceSide)> {
    let sides = |f| [FaceSide::Front, FaceSide::Back].map(|side| (f, side));
    let all = scene.faces.ids().flat_map(sides);
    all.filter(|&(f, side)| scene.receives(f, side)).collect()
}

/// The faces of an object of the file, in the order of the file.
pub(crate) fn faces_of(scene: &Scene, object: &str) -> Vec<FaceId> {
    let is_of = |f: &FaceId| scene.groups[scene.faces[*f].group as usize] == object;
    let faces: Vec<FaceId> = scene.faces.ids().filter(is_of).collect();
    assert!(!faces.is_empty(), "no object {object}");
    faces
}

/// A random point of a face, uniform over its area.
pub(crate) fn random_point(scene: &Scene, face: FaceId, rng: &mut Rng) -> DVec3 {
    let triangles = &scene.faces[face].triangles;
    let corners = |t: [_; 3]| t.map(|v| scene.vertices[v]);
    let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
    let total: f64 = triangles.iter().map(|&t| area(corners(t))).sum();
    let mut rest = rng.range(0.0, total);
    let mut chosen = corners(triangles[0]);
    for &t in triangles {
        chosen = corners(t);
        rest -= area(chosen);
        if rest <= 0.0 {
            break;
        }
    }
    let (mut u, mut v) = (rng.unit(), rng.unit());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    let [a, b, c] = chosen;
    let frame = &scene.faces[face].frame;
    frame.to_space(frame.to_plane(a + (b - a) * u + (c - a) * v))
}
/// All lines on one side of a face.
pub(crate) fn all_lines(lines: &FaceLines) -> impl Iterator<Item = &Discontinuity> {
    lines.contacts.iter().chain(&lines.candidates)
}

/// Distance of a point from a segment.
pub(crate) fn distance_to_segment(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
    p.distance(a + d * t)
}

/// Length of the diagonal of the box around a face's outline, metres.
pub(crate) fn size_of_face(scene: &Scene, face: FaceId) -> f64 {
    let (low, high): (DVec2, DVec2) = scene.faces[face].outline.bounds();
    low.distance(high)
}
