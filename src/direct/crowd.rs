//! Light through a crowd: past the leaves of a plant an emitter is looked at by rays, as many as the light there asks for.
//!
//! Cutting costs more than in proportion to what is in the way. Behind ten thousands of triangles a single look takes
//! hundreds of milliseconds, and what it finds is a sum of thousands of splinters that the next point along does not share.
//! The share of even rays that come through is as good there, and its doubt is known.

use super::DirectLight;
use super::emitters::{EmitterPolygon, unoccluded_factor, visible_factor_past_few};
use super::punctual::irradiance_by;
use crate::quantity::Irradiance;
use crate::scene::PunctualLight;
use crate::visibility::{Blockers, Scratch, Viewpoint};
use std::sync::atomic::Ordering;

/// Past more screens than this rays are cheaper: in a house of 260 000 triangles cutting 1 000 of them takes 0.4 ms, 4 000
/// 1 ms, 20 000 10 ms and 60 000 100 ms, finding them apart; 1 000 rays take 1 ms. With a limit of 4 000 the display mesh of
/// that house took 4.6 times as long.
const CROWD: usize = 1024;

/// Share of an emitter that may be left of it by rounding when it is hidden: slivers as wide as a few thousand roundings.
const CUTTING_ROUNDOFF: f64 = 4096.0 * f64::EPSILON;

/// Rays at first, and at most.
const FIRST: u32 = 64;
const MOST: u32 = 1024;

impl DirectLight<'_> {
    /// The form factor of what `view` sees of a polygon; behind a crowd of blockers off by about `doubt` (standard deviation).
    ///
    /// Other rays are another sequence: two looks with the same are wrong in the same way.
    pub(super) fn factor_within(
        &self,
        doubt: f64,
        sequence: u32,
        polygon: &EmitterPolygon,
        view: &Viewpoint,
        scratch: &mut Scratch,
    ) -> f64 {
        let blockers = self.blockers;
        let most = if doubt > 0.0 { CROWD } else { usize::MAX };
        visible_factor_past_few(most, polygon, blockers, view, scratch).unwrap_or_else(|| {
            self.looks_by_rays.fetch_add(1, Ordering::Relaxed);
            let factor = unoccluded_factor(polygon, blockers, view, scratch);
            factor * share_by_rays(doubt / factor, sequence, polygon, blockers, view)
        })
    }

    /// How often a crowd of blockers stood before an emitter, and rays were used.
    pub fn looks_by_rays(&self) -> usize {
        self.looks_by_rays.load(Ordering::Relaxed)
    }

    /// Irradiance at `view` straight from all emitters, W/m²: exact, but for each that is looked at past a crowd of blockers
    /// off by about `tolerance` (standard deviation, W/m², mean of the channels). Rays of another `sequence` (of which there
    /// are 2²²) are wrong in another way.
    pub fn irradiance_past_crowds(
        &self,
        view: &Viewpoint,
        tolerance: f64,
        sequence: u32,
        scratch: &mut Scratch,
    ) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for polygon in &self.polygons {
            let doubt = tolerance / polygon.exitance.0.mean();
            let factor = self.factor_within(doubt, sequence, polygon, view, scratch);
            sum += Irradiance(polygon.exitance.0 * factor.max(0.0));
        }
        for light in &self.lights {
            sum += irradiance_by(light, self.blockers, view);
        }
        sum
    }

    /// Whether `view` sees any of the emitters, or of a light; behind a crowd of blockers, whether the first rays do.
    pub fn is_seen(&self, view: &Viewpoint, scratch: &mut Scratch) -> bool {
        let shows = |polygon: &EmitterPolygon| {
            let open = unoccluded_factor(polygon, self.blockers, view, scratch);
            let doubt = open / f64::from(FIRST);
            // What the cutting of cones leaves of a hidden emitter is no light.
            open > 0.0
                && self.factor_within(doubt, 0, polygon, view, scratch) > open * CUTTING_ROUNDOFF
        };
        let is_lit = |l: &PunctualLight| irradiance_by(l, self.blockers, view).mean() > 0.0;
        self.polygons.iter().any(shows) || self.lights.iter().any(is_lit)
    }
}

/// The share of a polygon's light that reaches `view`, 0…1, off by about `doubt`.
fn share_by_rays(
    doubt: f64,
    sequence: u32,
    polygon: &EmitterPolygon,
    blockers: &Blockers,
    view: &Viewpoint,
) -> f64 {
    let (mut seen, mut all, mut rays) = (0.0, 0.0, 0);
    let mut next = FIRST;
    loop {
        let numbers = |i: u32| sequence.wrapping_mul(MOST).wrapping_add(i);
        let more = numbers(rays)..numbers(next);
        let [s, a] = blockers.seen_by_rays(view, polygon.target(), polygon.face, more);
        (seen, all) = (seen + s, all + a);
        rays = next;
        if all <= 0.0 {
            return 0.0;
        }
        let (share, n) = (seen / all, f64::from(rays));
        // All rays alike do not prove that the next one is, too (Laplace's rule of succession).
        let likely = (share * n + 1.0) / (n + 2.0);
        if rays >= MOST || (likely * (1.0 - likely) / n).sqrt() <= doubt {
            return share;
        }
        next = 2 * rays;
    }
}
