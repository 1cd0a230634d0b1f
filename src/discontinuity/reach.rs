//! How far from an emitter its lines can matter.
//!
//! A face of area A that leaves M gives at most `M A / (π d²)` at a distance d from it, whichever way both look. Lines break by
//! no more than that, so beyond the distance at which it falls below what matters none need be looked for; and what
//! stands there throws its shadows only farther away. In scenes with hundreds of small lamps most edges are far from most.

use crate::quantity::Exitance;
use crate::scene::{EmitterId, IdVec, Scene};
use glam::DVec3;
use std::f64::consts::PI;

/// An emitter from afar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    /// Of its corners.
    pub(super) middle: DVec3,
    /// Distance of the farthest corner from the middle, metres.
    pub(super) radius: f64,
    /// Exitance times area over π, W: over the square of a distance the most that it gives there.
    pub(super) power: f64,
}

/// A ball for each emitter: no line that matters starts outside of it.
pub(super) struct Reach {
    pub(super) lamps: IdVec<EmitterId, Lamp>,
    /// Lines that break by less than this do not matter, W/m².
    least: f64,
}

impl Reach {
    /// The balls for lines that break by at least `least`, W/m².
    pub(super) fn new(scene: &Scene, least: f64) -> Self {
        let lamps: Vec<Lamp> = scene
            .emitters
            .iter()
            .map(|(_, e)| {
                let face = &scene.faces[e.face];
                let corners = || face.loops.iter().flatten().map(|&v| scene.vertices[v]);
                let middle = corners().sum::<DVec3>() / corners().count() as f64;
                Lamp {
                    middle,
                    radius: corners().map(|p| p.distance(middle)).fold(0.0, f64::max),
                    power: Exitance::from_radiance(face.emission).0.mean() * face.area / PI,
                }
            })
            .collect();
        Self {
            lamps: IdVec::from(lamps),
            least,
        }
    }

    /// False when the convex hull of `points` certainly lies outside of the emitter's ball: that of an edge or a face.
    pub(super) fn holds(&self, emitter: EmitterId, points: &[DVec3]) -> bool {
        let lamp = self.lamps[emitter];
        let reach = lamp.radius + (lamp.power / self.least).sqrt();
        reach.is_infinite() || lamp.distance(points) <= reach
    }
}

impl Lamp {
    /// Distance of the middle from the box around `points`, metres: no more than from anything between them.
    pub(super) fn distance(&self, points: &[DVec3]) -> f64 {
        let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        self.middle.distance(self.middle.clamp(low, high))
    }
}
