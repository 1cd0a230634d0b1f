//! Random polygons between an emitter and a floor: every break lies on a line, and across every line there is a break.

use super::check_no_line_is_missed;
use super::precision;
use super::recall::{NEAR, breaks, is_confirmed, is_on_outline, random_chord};
use crate::common::events::Events;
use crate::common::library::{
    all_lines, distance_to_segment, moved, receiver_sides, size_of_face, world_of_mesh,
};
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use glam::DVec3;
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{Discontinuity, LineTolerance, find_lines};
use umbrage::pipeline::World;
use umbrage::scene::{FaceId, FaceSide};

/// Breaks that lie on lines, of all breaks.
const RECALL_BY_COUNT: f64 = 0.995;

/// The same with each break weighed by how much jumps.
const RECALL_BY_JUMP: f64 = 0.9999;

/// Lines across which there is a break, of all lines.
const PRECISION: f64 = 0.98;

/// Pairs of neighbouring points whose outlines are compared in each scene.
const OUTLINE_PAIRS: usize = 400;

/// Lines whose predicted break is smaller, relative to what the emitter gives there, are too weak to be seen.
const FLOOR: f64 = 0.0025;

/// A convex polygon of 3 to 5 corners around `centre` in a random plane.
fn polygon(rng: &mut Rng, centre: DVec3, radius: f64) -> Vec<[f64; 3]> {
    let normal = DVec3::from([0; 3].map(|_| rng.range(-1.0, 1.0))).normalize();
    let (u, v) = normal.any_orthonormal_pair();
    let corners = 3 + rng.below(3);
    let start = rng.range(0.0, std::f64::consts::TAU);
    (0..corners)
        .map(|i| {
            // Corners on a circle, each within the middle of its own sector: convex, and never close to each other.
            let turn = (i as f64 + rng.range(-0.3, 0.3)) / corners as f64;
            let angle = start + std::f64::consts::TAU * turn;
            (centre + (u * angle.cos() + v * angle.sin()) * radius).to_array()
        })
        .collect()
}

/// A floor of 8 m, a lamp of about a metre 4 m above it, and blockers that float between them.
fn scene(seed: u64, blockers: usize) -> (World, ObjMesh) {
    let mut rng = Rng::new(seed);
    let mut mesh = ObjMesh::default();
    let corner = |x: f64, z: f64| [x, 0.0, z];
    let floor = [
        corner(-4.0, 4.0),
        corner(4.0, 4.0),
        corner(4.0, -4.0),
        corner(-4.0, -4.0),
    ];
    mesh.add(&floor, 0.5, 0.0);
    let (turn, size) = (rng.range(0.0, 1.5), rng.range(0.4, 1.0));
    let lamp: Vec<[f64; 3]> = (0..4)
        .map(|i| {
            let angle = turn + f64::from(i) * std::f64::consts::FRAC_PI_2;
            [
                size * angle.cos(),
                4.0 + 0.3 * size * angle.sin(),
                size * angle.sin(),
            ]
        })
        .collect();
    // Clockwise seen from above, where sines run towards +z: it shines downwards.
    mesh.add(&lamp, 0.0, 1.0);
    let scale = (5.0 / blockers as f64).sqrt();
    for _ in 0..blockers {
        let centre = DVec3::new(
            rng.range(-1.2, 1.2),
            rng.range(0.8, 3.0),
            rng.range(-1.2, 1.2),
        );
        let radius = rng.range(0.3, 0.9) * scale;
        let corners = polygon(&mut rng, centre, radius);
        mesh.add(&corners, 0.5, 0.0);
    }
    let world = world_of_mesh(&format!("polygons {seed}"), &mesh);
    let mesh = moved(mesh, &world.scene);
    (world, mesh)
}

/// What became of the breaks, or of the lines.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    all: usize,
    missed: usize,
    jump: f64,
    missed_jump: f64,
}

impl Count {
    fn add(&mut self, is_missed: bool, jump: f64) {
        self.all += 1;
        self.jump += jump;
        if is_missed {
            self.missed += 1;
            self.missed_jump += jump;
        }
    }
}

/// The floor is the widest face; only there so many blockers leave light to look at.
fn floor_of(world: &World) -> (FaceId, FaceSide) {
    let sides = receiver_sides(&world.scene).into_iter();
    let front = sides.filter(|(_, side)| *side == FaceSide::Front);
    let area = |f: FaceId| world.scene.faces[f].area;
    front
        .max_by(|a, b| area(a.0).total_cmp(&area(b.0)))
        .expect("there is a floor")
}

/// Follows random chords of the floor and says which breaks lie on no line.
fn recall((world, mesh): &(World, ObjMesh), chords: usize, rng: &mut Rng, count: &mut Count) {
    let scene = &world.scene;
    let light = DirectLight::new(scene, &world.blockers);
    let lines = find_lines(scene, &light, LineTolerance::default());
    check_no_line_is_missed("random polygons", scene, &light, &lines, OUTLINE_PAIRS);
    let (face, side) = floor_of(world);
    let (size, normal) = (size_of_face(scene, face), scene.normal(face, side));
    for _ in 0..chords {
        let chord = random_chord(scene, face, rng);
        for (p, uncertainty, kink) in breaks(&light, normal, chord) {
            let near = NEAR * size + uncertainty;
            let is_found = all_lines(lines.of(face, side))
                .any(|l| distance_to_segment(p, l.ends) <= near)
                || is_on_outline(scene, face, p, near);
            let is_real = is_found || is_confirmed(&light, normal, chord, (p, uncertainty), kink);
            if !is_real {
                continue;
            }
            let jump = kink.order.map_or(0.0, |k| kink.jumps[usize::from(k)].abs());
            if !is_found {
                let (at, along) = (p + scene.origin, (chord[1] - chord[0]).normalize());
                let surface = Events::new(mesh).through(p, along, 1e-6 * size + uncertainty);
                eprintln!(
                    "{}: missed a break of order {:?} at {at:?}, surface {surface:?}, jumps {:?}, ± {:.1e}",
                    scene.source, kink.order, kink.jumps, kink.uncertainty
                );
            }
            count.add(!is_found, jump);
        }
    }
}

/// Looks at every `step`th line of the floor.
fn precision(world: &World, step: usize, count: &mut Count) {
    let scene = &world.scene;
    let light = DirectLight::new(scene, &world.blockers);
    let lines = find_lines(
        scene,
        &light,
        LineTolerance {
            floor: FLOOR,
            ..LineTolerance::default()
        },
    );
    let (face, side) = floor_of(world);
    let candidates: Vec<&Discontinuity> = all_lines(lines.of(face, side)).collect();
    for line in candidates.iter().step_by(step) {
        let is_break = precision::breaks(scene, &light, line);
        if !is_break {
            let [a, b] = line.ends.map(|p| p + scene.origin);
            eprintln!(
                "{}: no break across {:?} {:?} from {a} to {b}, {:?}, predicted {:.2e}",
                scene.source, line.order, line.kind, line.cause, line.jump
            );
        }
        count.add(!is_break, line.jump);
    }
}

/// Scenes of `blockers` polygons by turns; `chords` on the floor of each, and every `step`th of its lines.
fn check(seeds: std::ops::Range<u64>, blockers: &[usize], chords: usize, step: usize) {
    let (mut found, mut right) = (Count::default(), Count::default());
    let mut rng = Rng::new(31);
    for seed in seeds {
        let blockers = blockers[seed as usize % blockers.len()];
        let world = scene(seed, blockers);
        recall(&world, chords, &mut rng, &mut found);
        precision(&world.0, step, &mut right);
        eprintln!("{blockers} blockers: so far {found:?} {right:?}");
    }
    let share = |missed: f64, all: f64| 1.0 - missed / all;
    let by_count = share(found.missed as f64, found.all as f64);
    let by_jump = share(found.missed_jump, found.jump);
    let precision = share(right.missed as f64, right.all as f64);
    eprintln!("recall {by_count:.5} by count, {by_jump:.6} by jump; precision {precision:.4}");
    assert!(found.all > 20 && right.all > 20, "{found:?} {right:?}");
    assert!(by_count >= RECALL_BY_COUNT, "recall {by_count:.5} by count");
    assert!(by_jump >= RECALL_BY_JUMP, "recall {by_jump:.6} by jump");
    assert!(precision >= PRECISION, "precision {precision:.4}");
}

#[test]
fn breaks_among_random_polygons_lie_on_lines() {
    check(0..6, &[5, 8, 12], 1, 31);
}

#[test]
#[ignore = "takes minutes"]
fn breaks_among_many_random_polygons_lie_on_lines() {
    check(100..120, &[5, 10, 20, 40, 60], 4, 53);
}
