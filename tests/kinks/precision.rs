//! Across every line there is a break.

use super::search;
use crate::common::kinks::{KinkSettings, find_kinks};
use crate::common::library::{receiver_sides, size_of_face, world_of};
use crate::common::scenes::SHADOW_SCENES;
use glam::{DVec2, DVec3};
use umbrage::direct::DirectLight;
use umbrage::discontinuity::{Discontinuity, DiscontinuityOrder, EventKind};
use umbrage::pipeline::light;
use umbrage::radiosity::Bounces;
use umbrage::scene::Scene;
use umbrage::settings::Settings;
use umbrage::visibility::{Scratch, Viewpoint};

/// Where on a line breaks are looked for.
const ALONG: [f64; 5] = [0.5, 0.271, 0.733, 0.089, 0.917];

/// How far to each side the light is looked at, over the face's size.
const REACHES: [f64; 3] = [0.05, 0.01, 0.002];

/// A break this near to the line is its own, over the reach.
const NEAR: f64 = 0.01;

/// Lines without a break, of those that display meshes hold.
const IDLE: f64 = 0.02;

/// Whether the light breaks at one of some points of a line: fits of both sides differ by more than their doubt.
pub(super) fn breaks(scene: &Scene, light: &DirectLight, line: &Discontinuity) -> bool {
    let normal = scene.normal(line.face, line.side);
    let [a, b] = line.ends;
    let across = (b - a).cross(normal).normalize();
    let scratch = std::cell::RefCell::new(Scratch::default());
    let size = size_of_face(scene, line.face);
    ALONG.iter().any(|&s| {
        REACHES.iter().any(|&reach| {
            let reach = reach * size;
            let middle = a.lerp(b, s);
            let at = |t: f64| {
                let view = Viewpoint::new(middle + across * t, normal);
                light.irradiance(&view, &mut scratch.borrow_mut()).mean()
            };
            // Off the middle: an even function would hide its break at the ends of pieces.
            let found = find_kinks(&at, (-reach, 0.93 * reach), &KinkSettings::default());
            let own = |k: &&crate::common::kinks::Kink| k.t.abs() <= NEAR * reach + k.uncertainty;
            found.iter().any(|k| own(&k))
        })
    })
}

/// All and idle lines of a kind.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    lines: usize,
    idle: usize,
}

impl Count {
    fn add(&mut self, breaks: bool) {
        self.lines += 1;
        self.idle += usize::from(!breaks);
    }

    fn share(self) -> f64 {
        self.idle as f64 / self.lines as f64
    }
}

fn report(name: &str, scene: &Scene, line: &Discontinuity) {
    let [a, b] = line.ends.map(|p| p + scene.origin);
    eprintln!(
        "{name}: no break across {:?} {:?} from {a} to {b} on the {:?} of {:?}, {:?}, predicted {:.2e}",
        line.order, line.kind, line.side, line.face, line.cause, line.jump
    );
}

#[test]
fn lines_that_meshes_hold_are_breaks() {
    let mut count = Count::default();
    for name in SHADOW_SCENES {
        let world = world_of(name);
        let settings = Settings {
            bounces: Bounces::Count(0),
            ..Settings::default()
        };
        let solution = light(&world, &settings, &mut |_| {}).expect("the scene can be lit");
        for receiver in &solution.receivers {
            for (i, _) in receiver.kept() {
                let line = &receiver.lines.candidates[i];
                let is_break = breaks(&world.scene, &solution.direct, line);
                if !is_break {
                    report(name, &world.scene, line);
                }
                count.add(is_break);
            }
        }
    }
    eprintln!("{count:?}");
    assert!(count.lines > SHADOW_SCENES.len(), "{count:?}");
    assert!(count.share() <= IDLE, "{count:?}");
}

#[test]
#[ignore = "prints measurements"]
fn measure_how_many_candidates_are_breaks() {
    let kinds = [
        EventKind::Ve,
        EventKind::Ev,
        EventKind::Horizon,
        EventKind::EdgeOn,
        EventKind::Nve,
        EventKind::Eee,
    ];
    for kind in kinds {
        for order in [DiscontinuityOrder::D1, DiscontinuityOrder::D2] {
            let mut count = Count::default();
            for name in SHADOW_SCENES {
                let world = world_of(name);
                let light = DirectLight::new(&world.scene, &world.blockers);
                let lines = search(&world);
                for (face, side) in receiver_sides(&world.scene) {
                    let of_kind = lines.of(face, side).candidates.iter();
                    for line in of_kind.filter(|l| l.kind == kind && l.order == order) {
                        let is_break = breaks(&world.scene, &light, line);
                        if !is_break {
                            report(name, &world.scene, line);
                        }
                        count.add(is_break);
                    }
                }
            }
            eprintln!("{kind:?} {order:?}: {count:?}");
        }
    }
}

#[test]
fn a_line_elsewhere_is_no_break() {
    let world = world_of("rotated-blocker");
    let light = DirectLight::new(&world.scene, &world.blockers);
    let lines = search(&world);
    let (face, side) = receiver_sides(&world.scene)[0];
    let mut line = lines.of(face, side).candidates[0].clone();
    assert!(breaks(&world.scene, &light, &line));
    // In the unshadowed part of the floor.
    let frame = world.scene.faces[face].frame;
    line.ends = [DVec2::new(2.7, 2.4), DVec2::new(2.4, 2.5)]
        .map(|p| frame.to_space(frame.to_plane(DVec3::ZERO) + p));
    assert!(!breaks(&world.scene, &light, &line));
}
