//! What is known to stand between a piece of a face and the emitters hides nothing that is seen, and leaves out nothing that
//! hides.

use crate::common::library::{receiver_sides, world_of, world_of_mesh, world_of_raw};
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use crate::common::scenes::{fixture_names, shared_scene};
use crate::nasty::generator::{Nasty, nasty_scene};
use glam::DVec3;
use umbrage::direct::{DirectLight, Vantage};
use umbrage::geom::Plane;
use umbrage::io::{ReadSettings, read_scene};
use umbrage::pipeline::World;
use umbrage::scene::FaceSide;
use umbrage::visibility::{Scratch, Target, Viewpoint};

/// Light agrees to this share of what there would be if nothing hid it: what is proven hidden may be cut away by rounding.
const ROUND_OFF: f64 = 1e-9;

/// What was looked at.
#[derive(Default, Debug)]
struct Seen {
    looks: usize,
    /// Emitters before pieces, and those that cannot be seen from there.
    emitters: usize,
    hidden: usize,
}

/// Holds looks from random triangles on up to `most` sides, and from parts of them, against the exact light.
fn check(what: &str, world: &World, most: usize, rng: &mut Rng, seen: &mut Seen) {
    let scene = &world.scene;
    let light = DirectLight::new(scene, &world.blockers);
    let sides = receiver_sides(scene);
    let around = light.vantages_of_sides(scene, &sides);
    for _ in 0..most.min(4 * sides.len()) {
        let number = rng.below(sides.len());
        let (face, side) = sides[number];
        let triangles = &scene.faces[face].triangles;
        let triangle = triangles[rng.below(triangles.len())];
        let frame = scene.faces[face].frame;
        let mut corners = triangle.map(|v| frame.to_space(frame.to_plane(scene.vertices[v])));
        if side == FaceSide::Back {
            corners.reverse();
        }
        let plane = Plane::new(frame.origin, scene.normal(face, side));
        let vantage_of = |corners: &[DVec3], around: Option<&Vantage>| {
            light.vantage(Target { corners, plane }, around)
        };
        compare(what, &light, &around[number], corners, plane, rng, seen);
        let whole = vantage_of(&corners, None);
        compare(what, &light, &whole, corners, plane, rng, seen);
        let known = vantage_of(&corners, Some(&around[number]));
        compare(what, &light, &known, corners, plane, rng, seen);
        let at = rng.below(3);
        let [a, b, c] = [0, 1, 2].map(|i| corners[(at + i) % 3]);
        let part = [
            a,
            a.lerp(b, rng.range(0.1, 0.9)),
            a.lerp(c, rng.range(0.1, 0.9)),
        ];
        let vantage = vantage_of(&part, Some(&whole));
        compare(what, &light, &vantage, part, plane, rng, seen);
    }
}

fn compare(
    what: &str,
    light: &DirectLight,
    vantage: &Vantage,
    [a, b, c]: [DVec3; 3],
    plane: Plane,
    rng: &mut Rng,
    seen: &mut Seen,
) {
    let mut scratch = Scratch::default();
    let exitances = light.polygons.iter().map(|p| p.exitance.0.mean());
    // What is in the plane of a lamp or below the horizon but for round-off sees that much of it.
    let brightest = exitances.fold(0.0, f64::max);
    seen.emitters += light.polygons.len();
    seen.hidden += light.polygons.len() - vantage.count();
    for _ in 0..4 {
        let (u, v) = (rng.unit().sqrt(), rng.unit());
        let view = Viewpoint::new(
            a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v),
            plane.normal,
        );
        let exact = light.irradiance(&view, &mut scratch).mean();
        let open = light.unoccluded(&view, &mut scratch).mean();
        let found = light.look_within(&view, Some(vantage), 0.0, &mut scratch);
        let error = (found.light.mean() - exact).abs();
        assert!(
            error <= ROUND_OFF * open + f64::EPSILON * brightest,
            "{what}: {} for {exact} at {:?}, {open} if nothing hid it",
            found.light.mean(),
            view.position
        );
        seen.looks += 1;
    }
}

#[test]
fn vantages_see_what_is_seen_in_all_fixtures() {
    let (mut rng, mut seen) = (Rng::new(3), Seen::default());
    for name in fixture_names() {
        check(&name, &world_of(&name), 60, &mut rng, &mut seen);
    }
    assert!(
        seen.looks > 1000 && seen.hidden > seen.emitters / 50,
        "{seen:?}"
    );
}

#[test]
fn vantages_see_what_is_seen_in_nasty_scenes() {
    let mut seen = Seen::default();
    for seed in 500..540 {
        for nasty in Nasty::ALL {
            let mut rng = Rng::new(seed);
            let world = world_of_raw(&nasty_scene(nasty, &mut rng));
            check(
                &format!("{nasty:?} {seed}"),
                &world,
                20,
                &mut rng,
                &mut seen,
            );
        }
    }
    assert!(
        seen.looks > 10_000 && seen.hidden > seen.emitters / 50,
        "{seen:?}"
    );
}

#[test]
fn vantages_see_what_is_seen_in_a_level_of_many_rooms() {
    let mut rng = Rng::new(8);
    for name in ["freedoom-e2m2/freedoom-e2m2.obj", "fzk-haus/fzk-haus.obj"] {
        let Some(path) = shared_scene(name) else {
            return;
        };
        let world = world_of_raw(&read_scene(&path, &ReadSettings::default()).expect("a scene"));
        let mut seen = Seen::default();
        check(name, &world, 150, &mut rng, &mut seen);
        assert!(seen.hidden > seen.emitters / 2, "{name}: {seen:?}");
    }
}

/// A folded screen before a lamp, without the leaves listed in `missing`: no leaf hides the lamp alone.
fn folded_screen(missing: &[usize]) -> World {
    let mut mesh = ObjMesh::default();
    mesh.add(&rectangle([-5.0, 5.0], 0.0, 6.0), 0.5, 0.0);
    let mut lamp = rectangle([2.0, 3.0], 2.0, 1.0);
    lamp.reverse();
    mesh.add(&lamp, 0.5, 1.0);
    for leaf in (0..4).filter(|leaf| !missing.contains(leaf)) {
        let [from, to] = [leaf, leaf + 1].map(|k| [0.3 * (k % 2) as f64, 3.0 * k as f64 - 6.0]);
        let mut corners =
            [(from, 0.0), (to, 0.0), (to, 3.0), (from, 3.0)].map(|([x, z], y)| [x, y, z]);
        // Which side is the front makes no difference.
        if leaf == 2 {
            corners.reverse();
        }
        mesh.add(&corners, 0.5, 0.0);
    }
    world_of_mesh("screen", &mesh)
}

/// A horizontal rectangle that looks up, as deep to either side.
fn rectangle([from, to]: [f64; 2], y: f64, depth: f64) -> [[f64; 3]; 4] {
    [[from, depth], [to, depth], [to, -depth], [from, -depth]].map(|[x, z]| [x, y, z])
}

#[test]
fn the_leaves_of_a_screen_hide_as_one_but_not_without_one_of_them() {
    let corners = rectangle([-4.0, -3.0], 0.0, 1.0).map(DVec3::from);
    for (missing, seen) in [(&[][..], 0), (&[0, 3], 0), (&[1], 1), (&[2], 1)] {
        let world = folded_screen(missing);
        let light = DirectLight::new(&world.scene, &world.blockers);
        let piece = Target {
            corners: &corners,
            plane: Plane::new(DVec3::ZERO, DVec3::Y),
        };
        let vantage = light.vantage(piece, None);
        assert_eq!(vantage.count(), seen, "without leaves {missing:?}");
    }
}
