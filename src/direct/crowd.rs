//! Light through a crowd: past the leaves of a plant an emitter is looked at by rays, as many as the light there asks for.
//!
//! Cutting costs more than in proportion to what is in the way. Behind ten thousands of triangles a single look takes
//! hundreds of milliseconds, and what it finds is a sum of thousands of splinters that the next point along does not share.
//! The share of even rays that come through is as good there, and its doubt is known.

use super::DirectLight;
use super::emitters::{EmitterPolygon, visible_factor_among};
use super::many::Prospect;
use super::punctual::irradiance_by;
use super::vantage::Vantage;
use crate::quantity::Irradiance;
use crate::scene::PunctualLight;
use crate::visibility::{Blockers, Scratch, Screening, Viewpoint};
use std::sync::atomic::Ordering;

/// Past more screens than this rays are cheaper: in a house of 260 000 triangles cutting 1 000 of them takes 0.4 ms, 4 000
/// 1 ms, 20 000 10 ms and 60 000 100 ms, finding them apart; 1 000 rays take 1 ms. With a limit of 4 000 the display mesh of
/// that house took 4.6 times as long.
const CROWD: usize = 1024;

/// Share of an emitter that may be left of it by rounding when it is hidden: slivers as wide as a few thousand roundings.
const CUTTING_ROUNDOFF: f64 = 4096.0 * f64::EPSILON;

/// Rays at first, and at most. Through leaves 512 even rays were off by .007 of the emitter (rms of 1590 looks), 1024 by .006.
const FIRST: u32 = 64;
const MOST: u32 = 512;

/// Even rays are off by less than as many random ones: in those looks by .8 of it from 64 or 128, by .4 from 512.
const EVEN_SHARE: f64 = 0.8;

/// The form factor of what is seen of one polygon.
#[derive(Clone, Copy, Default)]
pub(super) struct Factor {
    pub(super) value: f64,
    /// Whether it was cut, and not looked at by rays past a crowd.
    pub(super) is_exact: bool,
}

/// The direct light at one point.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Irradiance, W/m².
    pub light: Irradiance,
    /// Whether no emitter was looked at past a crowd.
    pub is_exact: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            light: Irradiance::ZERO,
            is_exact: true,
        }
    }
}

impl Look {
    pub(super) fn add(&mut self, polygon: &EmitterPolygon, factor: Factor) {
        self.light += Irradiance(polygon.exitance.0 * factor.value);
        self.is_exact &= factor.is_exact;
    }
}

impl DirectLight<'_> {
    /// The form factor of what `view` sees of a polygon; behind a crowd of blockers off by about `doubt` (standard deviation).
    ///
    /// Other rays are another sequence: two looks with the same are wrong in the same way.
    pub(super) fn factor_within(
        &self,
        doubt: f64,
        sequence: u32,
        prospect: &Prospect,
        view: &Viewpoint,
        scratch: &mut Scratch,
    ) -> Factor {
        let (polygon, open) = (prospect.polygon, prospect.factor);
        let blockers = self.blockers;
        let screening = match prospect.screens {
            Some(screens) => Screening::Known(screens),
            None if doubt > 0.0 => Screening::AtMost(CROWD),
            None => Screening::AtMost(usize::MAX),
        };
        let cut = visible_factor_among(screening, open, polygon, blockers, view, scratch);
        if let Some(value) = cut {
            let is_exact = true;
            return Factor { value, is_exact };
        }
        self.looks_by_rays.fetch_add(1, Ordering::Relaxed);
        Factor {
            value: open * share_by_rays(doubt / open, sequence, polygon, blockers, view),
            is_exact: false,
        }
    }

    /// How often a crowd of blockers stood before an emitter, and rays were used.
    pub fn looks_by_rays(&self) -> usize {
        self.looks_by_rays.load(Ordering::Relaxed)
    }

    /// Irradiance at `view` straight from all emitters, W/m²: exact, but for each that is looked at past a crowd of blockers
    /// off by about `tolerance` (standard deviation, W/m², mean of the channels). Rays of another `sequence` (of which there
    /// are 2²³) are wrong in another way.
    pub fn look_past_crowds(
        &self,
        view: &Viewpoint,
        tolerance: f64,
        sequence: u32,
        scratch: &mut Scratch,
    ) -> Look {
        let mut look = Look::default();
        for p in self.prospects(view, None, scratch) {
            let doubt = tolerance / p.polygon.exitance.0.mean();
            let factor = self.factor_within(doubt, sequence, &p, view, scratch);
            look.add(p.polygon, factor);
        }
        for light in &self.lights {
            look.light += irradiance_by(light, self.blockers, view);
        }
        look
    }

    /// Whether `view` sees any of the emitters, or of a light; behind a crowd of blockers, whether the first rays do. `vantage`
    /// is as in [`DirectLight::look_within`].
    pub fn is_seen(
        &self,
        view: &Viewpoint,
        vantage: Option<&Vantage>,
        scratch: &mut Scratch,
    ) -> bool {
        let prospects = self.prospects(view, vantage, scratch);
        let mut shows = |p: &Prospect| {
            let doubt = p.factor / f64::from(FIRST);
            let found = self.factor_within(doubt, 0, p, view, scratch);
            // What the cutting of cones leaves of a hidden emitter is no light.
            found.value > p.factor * CUTTING_ROUNDOFF
        };
        let is_lit = |l: &PunctualLight| irradiance_by(l, self.blockers, view).mean() > 0.0;
        prospects.iter().any(&mut shows) || self.lights.iter().any(is_lit)
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
        let random = (likely * (1.0 - likely) / n).sqrt();
        if rays >= MOST || EVEN_SHARE * random <= doubt {
            return share;
        }
        next = 2 * rays;
    }
}
