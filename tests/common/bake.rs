//! Scenes through the whole pipeline, and random points on what comes out.

use super::rng::Rng;
use super::scenes::fixture;
use glam::DVec2;
use std::path::Path;
use umbrage::io::{ReadSettings, read_scene};
use umbrage::pipeline::{Solution, World, light};
use umbrage::radiosity::Bounces;
use umbrage::scene::RawScene;
use umbrage::settings::Settings;
use umbrage::visibility::Viewpoint;

/// A scene of our own as the library reads it.
pub(crate) fn raw(name: &str) -> RawScene {
    raw_at(&fixture(name))
}

/// A scene file as the library reads it.
pub(crate) fn raw_at(path: &Path) -> RawScene {
    read_scene(path, &ReadSettings::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// A scene of our own, cleaned.
pub(crate) fn world(name: &str) -> World {
    clean(&raw(name))
}

/// A scene, cleaned with the default tolerances.
pub(crate) fn clean(raw: &RawScene) -> World {
    World::new(raw, &Settings::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The settings of a bake to the relative error `error`.
pub(crate) fn settings(error: f64, bounces: Bounces) -> Settings {
    Settings {
        error,
        bounces,
        ..Settings::default()
    }
}

/// Lights `world` to the relative error `error`.
pub(crate) fn bake(world: &World, error: f64, bounces: Bounces) -> Solution<'_> {
    light(world, &settings(error, bounces), &mut |_| {}).unwrap_or_else(|e| panic!("{e}"))
}

/// A point of a display mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    /// Index of the receiver.
    pub(crate) receiver: usize,
    /// Element of its mesh.
    pub(crate) element: usize,
    /// Barycentric coordinates there.
    pub(crate) weights: [f64; 3],
    /// The same in the face's frame, metres.
    pub(crate) plane: DVec2,
}

impl SurfacePoint {
    /// Seen from the lit side.
    pub(crate) fn view(&self, solution: &Solution) -> Viewpoint {
        solution.receivers[self.receiver].view(self.plane)
    }
}

/// `count` points, uniform by area over the lit sides: the `i`-th lies in the `i`-th of `count` equal shares of the area.
///
/// Another generator and another order than the library's own measurement has.
pub(crate) fn surface_points(solution: &Solution, count: usize, seed: u64) -> Vec<SurfacePoint> {
    let mut sums = Vec::new();
    let mut sum = 0.0;
    for (r, receiver) in solution.receivers.iter().enumerate() {
        for e in (0..receiver.mesh.elements.len()).filter(|_| receiver.is_lit) {
            sum += receiver.mesh.area(e);
            sums.push((sum, r, e));
        }
    }
    assert!(!sums.is_empty(), "nothing is lit");
    let mut rng = Rng::new(seed);
    (0..count)
        .map(|i| {
            let at = sum * (i as f64 + rng.unit()) / count as f64;
            let k = sums.partition_point(|s| s.0 <= at).min(sums.len() - 1);
            let (_, receiver, element) = sums[k];
            let (mut a, mut b) = (rng.unit(), rng.unit());
            if a + b > 1.0 {
                (a, b) = (1.0 - a, 1.0 - b);
            }
            let weights = [1.0 - a - b, a, b];
            let corners = solution.receivers[receiver].mesh.corners(element);
            let plane = corners.iter().zip(weights).map(|(&c, w)| c * w).sum();
            SurfacePoint {
                receiver,
                element,
                weights,
                plane,
            }
        })
        .collect()
}
