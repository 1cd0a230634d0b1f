//! How far from an emitter its lines can matter.
//!
//! A face of area A that leaves M gives at most `M A / (π d²)` at a distance d from it, whichever way both look. Lines break by
//! no more than that, so beyond the distance at which it falls below what matters none need be looked for; and what
//! stands there throws its shadows only farther away. In scenes with hundreds of small lamps most edges are far from most.

use crate::direct::DirectLight;
use crate::scene::{EmitterId, IdVec, Scene};
use glam::DVec3;
use std::f64::consts::PI;

/// A ball for each emitter: no line that matters starts outside of it.
pub(super) struct Reach(IdVec<EmitterId, (DVec3, f64)>);

impl Reach {
    /// The balls for lines that break by at least `least`, W/m².
    pub(super) fn new(scene: &Scene, light: &DirectLight, least: f64) -> Self {
        let balls: Vec<(DVec3, f64)> = scene
            .emitters
            .iter()
            .map(|(id, e)| {
                let face = &scene.faces[e.face];
                let corners = || face.loops.iter().flatten().map(|&v| scene.vertices[v]);
                let count = corners().count() as f64;
                let middle = corners().sum::<DVec3>() / count;
                let radius = corners().map(|p| p.distance(middle)).fold(0.0, f64::max);
                let own = light.polygons.iter().find(|p| p.emitter == id);
                let power = own.map_or(0.0, |p| p.exitance.0.mean()) * face.area;
                (middle, radius + (power / (PI * least)).sqrt())
            })
            .collect();
        Self(IdVec::from(balls))
    }

    /// False when the convex hull of `points` certainly lies outside of the emitter's ball: that of an edge or a face.
    pub(super) fn holds(&self, emitter: EmitterId, points: &[DVec3]) -> bool {
        let (middle, radius) = self.0[emitter];
        if radius.is_infinite() {
            return true;
        }
        let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        middle.distance_squared(middle.clamp(low, high)) <= radius * radius
    }
}
