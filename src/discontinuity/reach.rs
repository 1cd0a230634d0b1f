//! How far from an emitter its lines can matter.
//!
//! A face of area A that leaves M gives at most `M A / (π d²)` at a distance d from it, whichever way both look. Lines break by
//! no more than that, so beyond the distance at which it falls below what matters none need be looked for; and what
//! stands there throws its shadows only farther away. In scenes with hundreds of small lamps most edges are far from most:
//! the trees of things and of lamps tell which are not.

use crate::geom::bounds;
use crate::quantity::Exitance;
use crate::scene::{EmitterId, IdVec, Scene};
use crate::visibility::{BoxTree, Region};
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

    /// The radius of the emitter's ball around its middle, metres; infinite when everything matters.
    pub(super) fn radius(&self, emitter: EmitterId) -> f64 {
        let lamp = self.lamps[emitter];
        lamp.radius + (lamp.power / self.least).sqrt()
    }

    /// False when the convex hull of `points` certainly lies outside of the emitter's ball: that of an edge or a face.
    pub(super) fn holds(&self, emitter: EmitterId, points: &[DVec3]) -> bool {
        let radius = self.radius(emitter);
        radius.is_infinite() || self.lamps[emitter].distance(points) <= radius
    }
}

/// The emitters as balls of their own radii, in a tree: of hundreds few are near.
pub(super) struct Balls {
    tree: BoxTree,
}

impl Balls {
    /// `radius` tells how far from the middle of an emitter it is near, metres.
    pub(super) fn new(scene: &Scene, reach: &Reach, radius: impl Fn(EmitterId) -> f64) -> Self {
        // The tree wants finite boxes.
        let (low, high) = bounds(scene.vertices.as_slice().iter().copied());
        let boxes = reach.lamps.iter().map(|(id, lamp)| {
            let radius = DVec3::splat(radius(id));
            (
                (lamp.middle - radius).max(low),
                (lamp.middle + radius).min(high),
            )
        });
        Self {
            tree: BoxTree::new(boxes),
        }
    }

    /// The emitters that the box around `points` may be near to, ascending.
    pub(super) fn around(&self, points: &[DVec3]) -> Vec<EmitterId> {
        let region = Region {
            planes: [].into_iter().collect(),
            bounds: bounds(points.iter().copied()),
        };
        let mut near = Vec::new();
        self.tree.query(&region, |i| near.push(EmitterId(i)));
        near.sort_unstable();
        near
    }
}

impl Lamp {
    /// Distance of the middle from the box around `points`, metres: no more than from anything between them.
    pub(super) fn distance(&self, points: &[DVec3]) -> f64 {
        let (low, high) = bounds(points.iter().copied());
        self.middle.distance(self.middle.clamp(low, high))
    }
}
