//! Facets that stand for a curved surface: lit as the surface is, and not to be seen.

use crate::common::library::world_of_raw;
use crate::common::reference::lambert;
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use umbrage::lit_scene::{LitMesh, LitScene};
use umbrage::pipeline::light;
use umbrage::quantity::{Radiance, Rgb};
use umbrage::radiosity::Bounces;
use umbrage::scene::{Material, RawPolygon, RawScene, Scene};
use umbrage::settings::Settings;

/// Corners of the lamp, which faces down on the origin; exitance 1 W/m².
const LAMP: [[f64; 3]; 4] = [
    [-1.0, 4.0, -0.5],
    [1.5, 4.0, -0.5],
    [1.5, 4.0, 1.0],
    [-1.0, 4.0, 1.0],
];

fn lamp() -> [DVec3; 4] {
    LAMP.map(DVec3::from)
}

/// A scene of the lamp alone.
fn lamp_scene() -> RawScene {
    let matte = |name: &str, reflectance, radiance| Material {
        name: name.to_owned(),
        reflectance: Rgb::grey(reflectance),
        emission: Radiance(Rgb::grey(radiance)),
        ..Material::default()
    };
    let mut raw = RawScene {
        source: "curved".to_owned(),
        materials: vec![matte("clay", 0.5, 0.0), matte("lamp", 0.0, 1.0 / PI)],
        groups: vec!["body".to_owned(), "lamp".to_owned()],
        ..RawScene::default()
    };
    push(&mut raw, &lamp().map(|p| (p, DVec3::ZERO)), 1);
    raw
}

fn push(raw: &mut RawScene, corners: &[(DVec3, DVec3)], group: u32) {
    let first = raw.positions.len() as u32;
    raw.positions.extend(corners.iter().map(|c| c.0));
    raw.normals.extend(corners.iter().map(|c| c.1));
    raw.polygons.push(RawPolygon {
        corners: (first..raw.positions.len() as u32).collect(),
        material: group,
        group,
    });
}

/// A unit sphere around the origin of 8 · 4^`levels` triangles, with its normals, below the lamp.
fn sphere(levels: u32) -> RawScene {
    let mut triangles = Vec::new();
    for x in [DVec3::X, DVec3::NEG_X] {
        for y in [DVec3::Y, DVec3::NEG_Y] {
            for z in [DVec3::Z, DVec3::NEG_Z] {
                let outward = x.cross(y).dot(z) > 0.0;
                triangles.push(if outward { [x, y, z] } else { [x, z, y] });
            }
        }
    }
    for _ in 0..levels {
        let parts = |[a, b, c]: [DVec3; 3]| {
            let middle = |p: DVec3, q: DVec3| (p + q).normalize();
            let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        };
        triangles = triangles.into_iter().flat_map(parts).collect();
    }
    let mut raw = lamp_scene();
    for t in triangles {
        push(&mut raw, &t.map(|p| (p, p)), 0);
    }
    raw
}

/// The irradiance of the true surface at `p` with normal `n` when nothing but its own horizon hides the lamp: Lambert's
/// formula for the part of the lamp above the tangent plane.
fn of_true_surface(p: DVec3, n: DVec3) -> f64 {
    let corners = lamp();
    let height = |c: DVec3| n.dot(c - p);
    let mut above = Vec::new();
    for (i, &b) in corners.iter().enumerate() {
        let a = corners[(i + 3) % 4];
        if (height(a) < 0.0) != (height(b) < 0.0) {
            above.push(a.lerp(b, height(a) / (height(a) - height(b))));
        }
        if height(b) >= 0.0 {
            above.push(b);
        }
    }
    if above.len() < 3 {
        return 0.0;
    }
    let directions: Vec<DVec3> = above.iter().map(|c| *c - p).collect();
    lambert(n, &directions) / PI
}

fn bake(raw: &RawScene, bounces: Bounces) -> (Scene, LitScene) {
    let settings = Settings {
        error: 0.02,
        bounces,
        ..Settings::default()
    };
    let world = world_of_raw(raw);
    let solution = light(&world, &settings, &mut |_| {}).expect("a bake");
    let lit = solution.lit_scene();
    (world.scene, lit)
}

fn body(lit: &LitScene) -> impl Iterator<Item = &LitMesh> {
    lit.meshes.iter().filter(|mesh| mesh.group == 0)
}

/// RMS over the triangles' corners and middles of shown less true irradiance, over the largest true one.
fn error(lit: &LitScene, surface: impl Fn(DVec3) -> (DVec3, DVec3)) -> f64 {
    let (mut sum, mut count, mut largest) = (0.0, 0.0, 0.0_f64);
    for mesh in body(lit) {
        for t in &mesh.triangles {
            let corners = t.map(|v| v as usize);
            let points = corners.map(|v| mesh.positions[v] + lit.origin);
            let values = corners.map(|v| mesh.irradiance[v].mean());
            let middle = points.iter().sum::<DVec3>() / 3.0;
            let mean = values.iter().sum::<f64>() / 3.0;
            for (p, shown) in points.iter().zip(values).chain([(&middle, mean)]) {
                let (on_surface, normal) = surface(*p);
                let wanted = of_true_surface(on_surface, normal);
                sum += (shown - wanted).powi(2);
                count += 1.0;
                largest = largest.max(wanted);
            }
        }
    }
    (sum / count).sqrt() / largest
}

#[test]
fn a_sphere_gets_its_own_light_the_better_the_finer_its_facets() {
    let errors = [2, 3].map(|levels| {
        let (scene, lit) = bake(&sphere(levels), Bounces::Count(0));
        let facets = 8 * 4_usize.pow(levels);
        assert_eq!(scene.faces.len(), facets + 1);
        let smooth = scene.edges.iter().filter(|(_, e)| e.is_smooth).count();
        assert_eq!(
            smooth,
            facets * 3 / 2,
            "every edge of the sphere is inside it"
        );
        error(&lit, |p| (p.normalize(), p.normalize()))
    });
    assert!(errors[0] < 0.03, "{errors:?}");
    assert!(errors[1] < 0.5 * errors[0], "{errors:?}");
}

/// The same without normals: facets show, and their light is far from the sphere's.
#[test]
fn without_normals_the_facets_are_flat() {
    let mut raw = sphere(2);
    raw.normals.clear();
    let (scene, lit) = bake(&raw, Bounces::Count(0));
    assert!(scene.edges.iter().all(|(_, e)| !e.is_smooth));
    assert!(body(&lit).all(|mesh| mesh.normals.is_empty()));
    assert!(error(&lit, |p| (p.normalize(), p.normalize())) > 0.05);
}

/// Largest differences of irradiance and of normals between vertices in one place.
fn jumps(lit: &LitScene) -> (f64, f64) {
    let mut at: BTreeMap<[u32; 3], Vec<(f64, DVec3)>> = BTreeMap::new();
    for mesh in body(lit) {
        for (i, p) in mesh.positions.iter().enumerate() {
            let key = p.as_vec3().to_array().map(|x| (x + 0.0).to_bits());
            at.entry(key)
                .or_default()
                .push((mesh.irradiance[i].mean(), mesh.normal_at(i)));
        }
    }
    let mut largest = (0.0_f64, 0.0_f64);
    for together in at.values() {
        for (e, n) in together {
            largest.0 = largest.0.max((e - together[0].0).abs());
            largest.1 = largest.1.max(n.distance(together[0].1));
        }
    }
    largest
}

#[test]
fn no_facet_of_a_sphere_shows_even_in_bounced_light() {
    let mut raw = sphere(2);
    let floor = [
        [-3.0, -1.2, 3.0],
        [3.0, -1.2, 3.0],
        [3.0, -1.2, -3.0],
        [-3.0, -1.2, -3.0],
    ];
    push(&mut raw, &floor.map(|p| (DVec3::from(p), DVec3::Y)), 1);
    raw.polygons.last_mut().expect("the floor").material = 0;
    for bounces in [Bounces::Count(0), Bounces::All] {
        let (_, lit) = bake(&raw, bounces);
        assert_eq!(jumps(&lit), (0.0, 0.0), "{bounces:?}");
    }
}

/// An open cylinder of `n` quads, its axis along z through the origin, its radius 1, with normals or without.
fn cylinder(n: u32, in_triangles: bool) -> RawScene {
    let at = |i: u32, z: f64| {
        let angle = TAU * f64::from(i) / f64::from(n);
        let normal = DVec3::new(angle.cos(), angle.sin(), 0.0);
        (normal + DVec3::Z * z, normal)
    };
    let mut raw = lamp_scene();
    for i in 0..n {
        let j = (i + 1) % n;
        let quad = [at(i, -1.0), at(j, -1.0), at(j, 1.0), at(i, 1.0)];
        if in_triangles {
            push(&mut raw, &[quad[0], quad[1], quad[2]], 0);
            push(&mut raw, &[quad[0], quad[2], quad[3]], 0);
        } else {
            push(&mut raw, &quad, 0);
        }
    }
    raw
}

#[test]
fn a_cylinder_keeps_its_rims_and_loses_its_facets() {
    for in_triangles in [false, true] {
        let (scene, lit) = bake(&cylinder(24, in_triangles), Bounces::Count(0));
        // Triangles of one facet merge, for one map of normals serves both.
        assert_eq!(scene.faces.len(), 25);
        let smooth = scene.edges.iter().filter(|(_, e)| e.is_smooth);
        assert_eq!(smooth.count(), 24);
        assert_eq!(jumps(&lit), (0.0, 0.0));
        let on_surface = |p: DVec3| {
            let normal = DVec3::new(p.x, p.y, 0.0).normalize();
            (normal + DVec3::Z * p.z, normal)
        };
        let error = error(&lit, on_surface);
        assert!(error < 0.02, "{error}");
    }
}

#[test]
fn normals_that_differ_make_a_crease() {
    // Each facet with its own normals, turned out at its ends: curved inside, creased between.
    let mut raw = cylinder(8, false);
    for polygon in raw.polygons.iter().filter(|p| p.group == 0) {
        let corners = polygon.corners.iter().map(|&c| c as usize);
        let middle: DVec3 = corners.clone().map(|c| raw.normals[c]).sum();
        for c in corners {
            raw.normals[c] = raw.normals[c].lerp(middle.normalize(), 0.5).normalize();
        }
    }
    let scene = world_of_raw(&raw).scene;
    assert!(scene.faces.iter().any(|(_, f)| f.shading.is_some()));
    assert!(scene.edges.iter().all(|(_, e)| !e.is_smooth));
}

/// A wall of two materials: its light does not change where the paint does.
#[test]
fn faces_in_one_plane_meet_in_one_light() {
    let corners = |x: [f64; 2], y: f64, is_up: bool| {
        let mut all = vec![
            DVec3::new(x[0], y, 1.0),
            DVec3::new(x[1], y, 1.0),
            DVec3::new(x[1], y, -1.0),
            DVec3::new(x[0], y, -1.0),
        ];
        if !is_up {
            all.reverse();
        }
        all
    };
    let material = |name: &str, reflectance, radiance| Material {
        name: name.to_owned(),
        reflectance: Rgb::grey(reflectance),
        emission: Radiance(Rgb::grey(radiance)),
        ..Material::default()
    };
    let mut raw = RawScene {
        source: "two paints".to_owned(),
        materials: vec![
            material("light", 0.8, 0.0),
            material("dark", 0.2, 0.0),
            material("lamp", 0.0, 5.0),
        ],
        groups: vec!["all".to_owned()],
        ..RawScene::default()
    };
    let parts = [
        corners([-2.0, 0.3], 0.0, true),
        corners([0.3, 2.0], 0.0, true),
        corners([-0.5, 0.7], 1.0, false),
    ];
    for (material, part) in parts.into_iter().enumerate() {
        let first = raw.positions.len() as u32;
        raw.positions.extend(part);
        raw.polygons.push(RawPolygon {
            corners: (first..first + 4).collect(),
            material: material as u32,
            group: 0,
        });
    }
    let (scene, lit) = bake(&raw, Bounces::Count(0));
    assert_eq!(scene.edges.iter().filter(|(_, e)| e.is_smooth).count(), 1);
    let on_seam = |mesh: &LitMesh| {
        let both = mesh.positions.iter().zip(&mesh.irradiance);
        let mut found: Vec<(f64, f64)> = both
            .filter(|(p, _)| ((*p + lit.origin).x - 0.3).abs() < 1e-9 && mesh.exitance.0.is_black())
            .map(|(p, e)| (p.z, e.mean()))
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    };
    let seams: Vec<_> = lit
        .meshes
        .iter()
        .map(on_seam)
        .filter(|s| !s.is_empty())
        .collect();
    assert_eq!(seams.len(), 2);
    assert!(seams[0].len() > 2 && seams[0] == seams[1], "{seams:?}");
}
