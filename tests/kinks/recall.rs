//! Every break lies on a line.

use super::{check_no_line_is_missed, search};
use crate::common::events::Events;
use crate::common::kinks::{Kink, KinkSettings, find_kinks};
use crate::common::library::{
    all_lines, distance_to_segment, local_mesh, receiver_sides, size_of_face, world_of,
};
use crate::common::reference::pairs;
use crate::common::rng::Rng;
use crate::common::scenes::SHADOW_SCENES;
use glam::DVec3;
use umbrage::direct::DirectLight;
use umbrage::scene::{FaceId, FaceSide, Scene};
use umbrage::visibility::{Scratch, Viewpoint};

/// A line within this share of the face's size is the break's line.
pub(super) const NEAR: f64 = 1e-3;

/// A critical surface within this share of the face's size of a missed break is named with it.
const ON_SURFACE: f64 = 1e-6;

/// Pairs of neighbouring points whose outlines are compared in each scene.
const OUTLINE_PAIRS: usize = 2000;

/// A group of breaks too close to tell apart is looked at again from so many times its width.
const CLOSER_LOOK: f64 = 5.0;

/// Breaks that have to be found.
const RECALL: f64 = 0.995;

/// What became of the breaks.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    found: usize,
    missed: usize,
}

/// A chord of a convex part of a face, between random points of two of its sides.
pub(super) fn random_chord(scene: &Scene, face: FaceId, rng: &mut Rng) -> [DVec3; 2] {
    let f = &scene.faces[face];
    let part = &f.convex_parts[rng.below(f.convex_parts.len())];
    let n = part.len();
    let first = rng.below(n);
    let second = (first + 1 + rng.below(n - 1)) % n;
    [first, second].map(|i| {
        let (a, b) = (scene.vertices[part[i]], scene.vertices[part[(i + 1) % n]]);
        f.frame.to_space(f.frame.to_plane(a + (b - a) * rng.unit()))
    })
}

/// The breaks of the direct light along a chord, as points with their uncertainty in metres.
pub(super) fn breaks(
    light: &DirectLight,
    normal: DVec3,
    [a, b]: [DVec3; 2],
) -> Vec<(DVec3, f64, Kink)> {
    let scratch = std::cell::RefCell::new(Scratch::default());
    let at = |t: f64| {
        let view = Viewpoint::new(a + (b - a) * t, normal);
        light.irradiance(&view, &mut scratch.borrow_mut()).mean()
    };
    find_kinks(&at, (0.0, 1.0), &KinkSettings::default())
        .into_iter()
        .map(|k| (a + (b - a) * k.t, k.uncertainty * a.distance(b), k))
        .collect()
}

pub(super) fn is_on_outline(scene: &Scene, face: FaceId, p: DVec3, tolerance: f64) -> bool {
    scene.faces[face].loops.iter().any(|points| {
        pairs(points).any(|(v, w)| {
            distance_to_segment(p, [scene.vertices[v], scene.vertices[w]]) <= tolerance
        })
    })
}

/// Follows `chords` random chords on each side of each face, and says what is missed.
fn count(name: &str, chords: usize, rng: &mut Rng) -> Count {
    let world = world_of(name);
    let scene = &world.scene;
    let light = DirectLight::new(scene, &world.blockers);
    let lines = search(&world);
    check_no_line_is_missed(name, scene, &light, &lines, OUTLINE_PAIRS);
    let events = Events::new(&local_mesh(name, scene));
    let mut count = Count::default();
    for (face, side) in receiver_sides(scene) {
        let size = size_of_face(scene, face);
        let normal = scene.normal(face, side);
        let on_side = lines.of(face, side);
        for _ in 0..chords {
            let chord = random_chord(scene, face, rng);
            for (p, uncertainty, kink) in breaks(&light, normal, chord) {
                let near = NEAR * size + uncertainty;
                if all_lines(on_side).any(|l| distance_to_segment(p, l.ends) <= near)
                    || is_on_outline(scene, face, p, near)
                {
                    count.found += 1;
                    continue;
                }
                if !is_confirmed(&light, normal, chord, (p, uncertainty), kink) {
                    continue;
                }
                let along = (chord[1] - chord[0]).normalize();
                let surface = events.through(p, along, ON_SURFACE * size + uncertainty);
                count.missed += 1;
                report(name, scene, (face, side), p, kink, surface);
            }
        }
    }
    count
}

/// False when a closer look at a group of breaks finds none: then a fit of the finder's went astray.
pub(super) fn is_confirmed(
    light: &DirectLight,
    normal: DVec3,
    [a, b]: [DVec3; 2],
    (p, uncertainty): (DVec3, f64),
    kink: Kink,
) -> bool {
    // The group stands off the middle, where no piece ends.
    let reach = CLOSER_LOOK * uncertainty * (b - a).normalize();
    kink.order.is_some() || !breaks(light, normal, [p - reach, p + 0.87 * reach]).is_empty()
}

fn report(
    name: &str,
    scene: &Scene,
    (face, side): (FaceId, FaceSide),
    p: DVec3,
    kink: Kink,
    surface: Option<crate::common::events::Surface>,
) {
    let object = &scene.groups[scene.faces[face].group as usize];
    let at = p + scene.origin;
    eprintln!(
        "{name}: missed a break of order {:?} at {at:?} on the {side:?} of {face:?} ({object}), \
         surface {surface:?}, jumps {:?}, ± {:.1e}",
        kink.order, kink.jumps, kink.uncertainty
    );
}

fn recall(chords: usize) {
    let mut rng = Rng::new(29);
    let mut sum = Count::default();
    for name in SHADOW_SCENES {
        let c = count(name, chords, &mut rng);
        eprintln!("{name}: {c:?}");
        sum.found += c.found;
        sum.missed += c.missed;
    }
    let share = sum.found as f64 / (sum.found + sum.missed) as f64;
    eprintln!("{sum:?}: recall {share:.4}");
    assert!(share >= RECALL, "{sum:?}: recall {share:.4}");
    // Without breaks nothing was tested.
    assert!(sum.found > 10 * chords, "{sum:?}");
}

#[test]
fn breaks_lie_on_lines() {
    recall(3);
}

#[test]
#[ignore = "takes minutes"]
fn breaks_lie_on_lines_along_many_chords() {
    recall(60);
}
