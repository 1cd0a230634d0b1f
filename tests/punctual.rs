//! Lights without a surface: their light on paper, their shadows by projection and by search, and baked.

mod baked;

use crate::common::library::{
    all_lines, distance_to_segment, raw_of_mesh, receiver_sides, world_of_raw,
};
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use crate::lines::cities::add_box;
use glam::DVec3;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{
    Discontinuity, DiscontinuityOrder, LineMap, LineTolerance, find_lines,
};
use umbrage::pipeline::World;
use umbrage::quantity::Rgb;
use umbrage::scene::{FaceId, FaceSide, PunctualKind, PunctualLight};
use umbrage::visibility::{Scratch, Viewpoint};

/// Relative: a few roundings.
const ROUND_OFF: f64 = 1e-12;

/// Where the light jumps is found to this share of the way.
const BISECTED: f64 = 1e-10;

fn point(at: [f64; 3], intensity: f64) -> PunctualLight {
    PunctualLight {
        name: "light".to_owned(),
        kind: PunctualKind::Point,
        position: at.into(),
        direction: DVec3::NEG_Z,
        intensity: Rgb::grey(intensity),
        range: None,
    }
}

fn spot(at: [f64; 3], towards: [f64; 3], angles: [f64; 2], intensity: f64) -> PunctualLight {
    PunctualLight {
        kind: PunctualKind::Spot {
            inner_angle_rad: angles[0],
            outer_angle_rad: angles[1],
        },
        direction: (DVec3::from(towards) - DVec3::from(at)).normalize(),
        ..point(at, intensity)
    }
}

fn sun(direction: [f64; 3], irradiance: f64) -> PunctualLight {
    PunctualLight {
        kind: PunctualKind::Directional,
        direction: DVec3::from(direction).normalize(),
        ..point([0.0; 3], irradiance)
    }
}

fn rectangle(mesh: &mut ObjMesh, low: [f64; 2], high: [f64; 2], y: f64) {
    let corners = [
        [low[0], y, high[1]],
        [high[0], y, high[1]],
        [high[0], y, low[1]],
        [low[0], y, low[1]],
    ];
    mesh.add(&corners, 0.5, 0.0);
}

/// A floor of 6 × 6 m with a square of 1 m² half a metre above its middle.
fn square_over_floor() -> ObjMesh {
    let mut mesh = ObjMesh::default();
    rectangle(&mut mesh, [-3.0, -3.0], [3.0, 3.0], 0.0);
    rectangle(&mut mesh, [-0.5, -0.5], [0.5, 0.5], 0.5);
    mesh
}

/// A floor with boxes on it and beside each other, and a sheet that leans.
fn boxes() -> ObjMesh {
    let mut mesh = ObjMesh::default();
    rectangle(&mut mesh, [-3.0, -3.0], [3.0, 3.0], 0.0);
    add_box(&mut mesh, [-1.5, 0.0, -1.0], [-0.5, 1.0, 0.25], false);
    add_box(&mut mesh, [0.5, 0.0, -0.5], [1.0, 1.5, 0.5], false);
    let sheet = [
        [0.0, 0.3, 1.5],
        [1.4, 0.9, 1.2],
        [1.1, 1.7, 2.0],
        [-0.3, 1.1, 2.3],
    ];
    mesh.add(&sheet, 0.5, 0.0);
    mesh
}

fn world(mesh: &ObjMesh, lights: Vec<PunctualLight>) -> World {
    let mut raw = raw_of_mesh("lights", mesh);
    raw.lights = lights;
    world_of_raw(&raw)
}

fn lines(world: &World) -> LineMap {
    let light = DirectLight::new(&world.scene, &world.blockers);
    find_lines(&world.scene, &light, LineTolerance::default())
}

/// Direct irradiance on the floor, the first face, at a point of the scene's own coordinates.
fn on_floor(world: &World, x: f64, z: f64) -> f64 {
    let light = DirectLight::new(&world.scene, &world.blockers);
    let p = DVec3::new(x, 0.0, z) - world.scene.origin;
    let e = light.irradiance(&Viewpoint::new(p, DVec3::Y), &mut Scratch::default());
    e.mean()
}

/// The jumps of the value on the floor, in the scene's own coordinates.
fn floor_shadows(world: &World) -> Vec<[DVec3; 2]> {
    let lines = lines(world);
    let contacts = &lines.of(FaceId(0), FaceSide::Front).contacts;
    let ends = contacts.iter().map(|l| l.ends);
    ends.map(|e| e.map(|p| p + world.scene.origin)).collect()
}

#[test]
fn their_light_is_what_paper_says() {
    let at = [0.4, 2.0, -0.3];
    let (inner, outer) = (0.2, 0.7);
    let cases = [
        point(at, 3.0),
        spot(at, [0.6, 0.0, 0.1], [inner, outer], 3.0),
        sun([0.3, -1.0, 0.2], 3.0),
    ];
    let mut floor = ObjMesh::default();
    rectangle(&mut floor, [-3.0, -3.0], [3.0, 3.0], 0.0);
    let worlds = cases.clone().map(|light| world(&floor, vec![light]));
    let mut rng = Rng::new(5);
    for _ in 0..300 {
        let (x, z) = (rng.range(-3.0, 3.0), rng.range(-3.0, 3.0));
        let way = DVec3::from(at) - DVec3::new(x, 0.0, z);
        // E = I cos θ / r² = I h / r³.
        let from_point = 3.0 * way.y / way.length().powi(3);
        let cosine = -way.normalize().dot(cases[1].direction);
        let share = ((cosine - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
        let expected = [
            from_point,
            from_point * share * share,
            -3.0 * cases[2].direction.y,
        ];
        for (world, e) in worlds.iter().zip(expected) {
            let found = on_floor(world, x, z);
            assert!(
                (found - e).abs() <= ROUND_OFF * from_point.max(3.0),
                "{found} {e}"
            );
        }
    }
}

/// A square lamp of side s, radiance L, is a point of intensity L s² cos φ as s vanishes: off by O(s²).
#[test]
fn a_small_emitter_is_nearly_a_point() {
    let side = 1e-3;
    let mut mesh = square_over_floor();
    let lamp = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let corner = |(x, z): (f64, f64)| [0.2 + side * (x - 0.5), 2.0, 0.1 + side * (z - 0.5)];
    mesh.add(&lamp.map(corner), 0.0, 1.0 / (side * side));
    let emitter = world(&mesh, Vec::new());
    let light = world(&square_over_floor(), vec![point([0.2, 2.0, 0.1], 1.0)]);
    let mut lit = 0;
    let mut rng = Rng::new(6);
    for _ in 0..200 {
        let (x, z) = (rng.range(-3.0, 3.0), rng.range(-3.0, 3.0));
        let way = DVec3::new(0.2 - x, 2.0, 0.1 - z);
        let expected = on_floor(&light, x, z) * way.y / way.length();
        let found = on_floor(&emitter, x, z);
        // Some points lie in the penumbra, a thousandth of a metre wide.
        if (found - expected).abs() < 1e-5 * expected.max(1e-3) {
            lit += 1;
        }
    }
    assert!(lit >= 198, "{lit}");
}

/// The shadow of the square is its projection from the light on the floor.
#[test]
fn shadows_are_projections() {
    let at = DVec3::new(0.2, 1.5, -0.3);
    let way = DVec3::new(0.4, -1.0, 0.3);
    let from_point = |c: DVec3| at + (c - at) * (at.y / (at.y - c.y));
    let from_sun = |c: DVec3| c - way * (c.y / way.y);
    type Projection<'p> = &'p dyn Fn(DVec3) -> DVec3;
    let cases: [(PunctualLight, Projection); 3] = [
        (point(at.to_array(), 1.0), &from_point),
        (sun(way.to_array(), 1.0), &from_sun),
        // A cone so wide that all of the shadow lies in it.
        (
            spot(at.to_array(), [0.2, 0.0, -0.3], [1.0, 1.5], 1.0),
            &from_point,
        ),
    ];
    for (light, project) in cases {
        let kind = light.kind;
        let found = floor_shadows(&world(&square_over_floor(), vec![light]));
        assert_eq!(found.len(), 4, "{kind:?}: {found:?}");
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
        let corners = corners.map(|(x, z)| project(DVec3::new(x, 0.5, z)));
        for i in 0..4 {
            let edge = [corners[i], corners[(i + 1) % 4]];
            let off = |f: &[DVec3; 2]| {
                let d = |p: DVec3, q: DVec3| p.distance(q);
                (d(f[0], edge[0]) + d(f[1], edge[1])).min(d(f[0], edge[1]) + d(f[1], edge[0]))
            };
            let nearest = found.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest < ROUND_OFF * 10.0, "{kind:?}: {nearest:e}");
        }
    }
}

/// Outside the cone nothing is drawn, and its rim is.
#[test]
fn a_spot_draws_no_farther_than_it_shines() {
    let light = spot([0.6, 2.0, 0.0], [0.6, 0.0, 0.0], [0.1, 0.2], 1.0);
    let world = world(&square_over_floor(), vec![light]);
    // The spot's circle on the floor has a radius of 2 tan 0.2; the square covers part of it.
    let radius = 2.0 * 0.2_f64.tan();
    let shadows = floor_shadows(&world);
    assert!(!shadows.is_empty());
    for p in shadows.iter().flatten() {
        let off = DVec3::new(p.x - 0.6, 0.0, p.z).length();
        assert!(off <= radius * (1.0 + 1e-9), "{p}");
    }
    let lines = lines(&world);
    let rims = &lines.of(FaceId(0), FaceSide::Front).candidates;
    let of = |order| rims.iter().filter(move |l| l.order == order);
    for (order, angle) in [
        (DiscontinuityOrder::D1, 0.1_f64),
        (DiscontinuityOrder::D2, 0.2),
    ] {
        assert!(of(order).count() >= 4, "{order:?}");
        for p in of(order).flat_map(|l| l.ends) {
            let p = p + world.scene.origin;
            let off = DVec3::new(p.x - 0.6, 0.0, p.z).length();
            // Chords, cut where the face ends or not at all.
            let r = 2.0 * angle.tan();
            assert!((off - r).abs() < 2e-3 * r, "{order:?} {off} {r}");
        }
    }
}

fn value_lines(lines: &LineMap, world: &World) -> Vec<Discontinuity> {
    let sides = receiver_sides(&world.scene);
    let of_side = |&(f, s): &(FaceId, FaceSide)| all_lines(lines.of(f, s)).cloned().collect();
    let all: Vec<Vec<Discontinuity>> = sides.iter().map(of_side).collect();
    let jumps = |l: &Discontinuity| l.order == DiscontinuityOrder::D0;
    all.into_iter().flatten().filter(jumps).collect()
}

/// Along random segments of every face the light jumps where a line is, and nowhere else.
#[test]
fn every_jump_is_on_a_line_and_every_shadow_line_jumps() {
    let lights = [
        point([0.3, 2.2, -0.2], 1.0),
        spot([-0.9, 2.4, 1.1], [0.4, 0.0, 0.3], [0.5, 0.8], 1.0),
        sun([0.5, -1.0, 0.35], 1.0),
    ];
    for light in lights {
        let kind = light.kind;
        let world = world(&boxes(), vec![light]);
        let scene = &world.scene;
        let direct = DirectLight::new(scene, &world.blockers);
        let map = lines(&world);
        let lines = value_lines(&map, &world);
        let mut scratch = Scratch::default();
        let mut rng = Rng::new(8);
        let mut jumps = 0;
        for (face, side) in receiver_sides(scene) {
            let on_face: Vec<_> = lines
                .iter()
                .filter(|l| (l.face, l.side) == (face, side))
                .collect();
            let f = &scene.faces[face];
            for _ in 0..60 {
                let t = f.triangles[rng.below(f.triangles.len())].map(|v| scene.vertices[v]);
                let mut inside = || {
                    let (a, b) = (rng.range(0.01, 0.98), rng.unit());
                    t[0] + (t[1] - t[0]) * a * (1.0 - b) + (t[2] - t[0]) * a * b
                };
                let (from, to) = (inside(), inside());
                let mut at = |s: f64| {
                    let view = Viewpoint::new(from.lerp(to, s), scene.normal(face, side));
                    direct.irradiance(&view, &mut scratch).mean()
                };
                for k in 0..40 {
                    let (mut a, mut b) = (f64::from(k) / 40.0, f64::from(k + 1) / 40.0);
                    if (at(a) > 0.0) == (at(b) > 0.0) {
                        continue;
                    }
                    while b - a > BISECTED {
                        let m = 0.5 * (a + b);
                        if (at(m) > 0.0) == (at(a) > 0.0) {
                            a = m;
                        } else {
                            b = m;
                        }
                    }
                    // At a spot's rim the light fades out.
                    if at(a).max(at(b)) < 1e-6 {
                        continue;
                    }
                    jumps += 1;
                    let p = from.lerp(to, 0.5 * (a + b));
                    let off = on_face.iter().map(|l| distance_to_segment(p, l.ends));
                    let off = off.fold(f64::INFINITY, f64::min);
                    // What hides a point from within the weld distance of its face does not count.
                    assert!(
                        off < 4.0 * scene.weld_distance,
                        "{kind:?}: the light jumps {off:e} m off any line at {p}"
                    );
                }
            }
        }
        assert!(jumps > 25, "{kind:?}: {jumps} jumps");
        for line in lines
            .iter()
            .filter(|l| l.kind != umbrage::discontinuity::EventKind::Contact)
        {
            let normal = scene.normal(line.face, line.side);
            let [a, b] = line.ends;
            let across = normal.cross(b - a).normalize() * 1e-6;
            let mut at = |p| {
                direct
                    .irradiance(&Viewpoint::new(p, normal), &mut scratch)
                    .mean()
            };
            let middle = 0.5 * (a + b);
            let jump = (at(middle + across) - at(middle - across)).abs();
            assert!(jump > 0.0, "{kind:?}: no jump at {line:?}");
        }
    }
}
