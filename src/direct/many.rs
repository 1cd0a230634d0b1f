//! Light from many emitters at a point, each only as finely as it matters there.
//!
//! What an emitter would give if nothing hid it bounds what it gives. The weakest, as many as leave no more doubt than the
//! result may be off by, are seen or not as one ray to their middle tells; the others are cut exactly. The mistakes of rays
//! to many emitters add like random steps: the triangles of a bulb are as many samples of it.

use super::DirectLight;
use super::crowd::{Factor, Look};
use super::emitters::{EmitterPolygon, unoccluded_factor};
use super::punctual::irradiance_by;
use super::vantage::Vantage;
use crate::geom::Plane;
use crate::quantity::Irradiance;
use crate::scene::PunctualLight;
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;
use smallvec::SmallVec;

/// Up to so many emitters are always cut exactly: that is soon done, and leaves no step where a ray begins to miss.
const FEW: usize = 32;

/// The parts of an emitter whose form factor is larger than this give very different light, each for its area: one of them does
/// not speak for all. Behind a crowd of blockers it is known to a tenth.
const NEAR: f64 = 0.05;
const NEAR_DOUBT: f64 = 0.1;

/// Rays to emitters that are far, at most: one path among thousands is off by more than they are.
const MOST_ASKED: usize = 16;

/// What one ray tells of an emitter of which the share f is seen is off by √(f (1 − f)) of its light (rms, over where the ray
/// may go): half at most.
const RAY_DOUBT: f64 = 0.5;

/// So many emitters are kept track of without allocating.
const USUAL: usize = 32;

/// What an emitter may give at one point.
pub(super) struct Prospect<'e> {
    /// The number of its polygon.
    pub(super) number: u32,
    pub(super) polygon: &'e EmitterPolygon,
    /// Its form factor if nothing hid it.
    pub(super) factor: f64,
    /// What it gives then, mean of the channels, W/m².
    pub(super) light: f64,
    /// The screens that may hide it, if these are known.
    pub(super) screens: Option<&'e [u32]>,
}

impl DirectLight<'_> {
    /// Irradiance at `view` straight from all emitters, W/m², where they are many off by about `tolerance` (rms, W/m², mean
    /// of the channels), and by as much about each that is looked at past a crowd of blockers. Elsewhere it is that of
    /// [`DirectLight::irradiance`].
    ///
    /// `vantage` is that of a piece of the face on which `view` is, if there is one.
    pub fn look_within(
        &self,
        view: &Viewpoint,
        vantage: Option<&Vantage>,
        tolerance: f64,
        scratch: &mut Scratch,
    ) -> Look {
        let prospects = self.prospects(view, vantage, scratch);
        let found = self.factors(&prospects, tolerance, view, scratch);
        let mut look = Look::default();
        for (p, factor) in prospects.iter().zip(found) {
            look.add(p.polygon, factor);
        }
        for light in &self.lights {
            look.light += irradiance_by(light, self.blockers, view);
        }
        look
    }

    /// Whether `view` sees the middle of some emitter, or a light without a surface; `vantage` is as in
    /// [`DirectLight::look_within`].
    pub fn sees_a_middle(&self, view: &Viewpoint, vantage: Option<&Vantage>) -> bool {
        let shows = |p: &EmitterPolygon| {
            let middle = p.middle();
            let roundoff = self.blockers.roundoff();
            let is_faced = |plane: &Plane, point| plane.distance(point) > roundoff;
            is_faced(&p.plane, view.position)
                && is_faced(&view.horizon, middle)
                && self.blockers.sees(view, middle, p.face)
        };
        let is_lit = |l: &PunctualLight| irradiance_by(l, self.blockers, view).mean() > 0.0;
        let is_shown = match vantage {
            Some(vantage) => {
                let mut numbers = vantage.sights().map(|(n, _)| n as usize);
                numbers.any(|n| shows(&self.polygons[n]))
            }
            None => self.polygons.iter().any(shows),
        };
        is_shown || self.lights.iter().any(is_lit)
    }

    /// The irradiance at `view`, W/m², right in the mean over many views with rays of their own: each emitter is seen wholly or
    /// not, as one ray to point `ray` of an even set tells; what fills much of the sky is cut. Of more emitters than rays are worth
    /// those are asked that `choice` (0…1) falls on, in proportion to what they may give.
    pub fn by_rays(
        &self,
        view: &Viewpoint,
        ray: u32,
        choice: impl FnOnce() -> f64,
        scratch: &mut Scratch,
    ) -> Irradiance {
        let prospects = self.prospects(view, None, scratch);
        let is_far = |p: &&Prospect| p.factor <= NEAR;
        let (mut count, mut light) = (0, 0.0);
        for p in prospects.iter().filter(is_far) {
            count += 1;
            light += p.light;
        }
        // Rays as far apart in the light of one emitter after the other: each stands for so much of it.
        let step = light / MOST_ASKED as f64;
        let are_all_asked = count <= MOST_ASKED;
        let mut next = if are_all_asked { 0.0 } else { step * choice() };
        let (mut sum, mut before) = (Irradiance::ZERO, 0.0);
        for p in &prospects {
            let factor = if !is_far(&p) {
                let doubt = p.factor * NEAR_DOUBT;
                self.factor_within(doubt, ray, p, view, scratch).value
            } else {
                before += p.light;
                let worth = match are_all_asked {
                    true => 1.0,
                    false if next >= before => continue,
                    false => {
                        let rays = ((before - next) / step).ceil();
                        next += rays * step;
                        rays * step / p.light
                    }
                };
                worth * self.factor_by_ray(p, view, p.polygon.point(ray))
            };
            sum += Irradiance(p.polygon.exitance.0 * factor);
        }
        for light in &self.lights {
            sum += irradiance_by(light, self.blockers, view);
        }
        sum
    }

    /// The emitters that `view` would see if nothing hid them, but for those that it cannot see from its `vantage`.
    pub(super) fn prospects<'v>(
        &'v self,
        view: &Viewpoint,
        vantage: Option<&'v Vantage>,
        scratch: &mut Scratch,
    ) -> SmallVec<[Prospect<'v>; USUAL]> {
        let mut prospects = SmallVec::new();
        let mut add = |number: u32, screens| {
            let polygon = &self.polygons[number as usize];
            let factor = unoccluded_factor(polygon, self.blockers, view, scratch);
            let light = factor * polygon.exitance.0.mean();
            if light > 0.0 {
                prospects.push(Prospect {
                    number,
                    polygon,
                    factor,
                    light,
                    screens,
                });
            }
        };
        match vantage {
            Some(vantage) => vantage.sights().for_each(|(n, screens)| add(n, screens)),
            None => (0..self.polygons.len() as u32).for_each(|n| add(n, None)),
        }
        prospects
    }

    /// The form factors of what `view` sees of the emitters: of the weakest, about which rays together leave less doubt than
    /// `tolerance` (W/m²), as one ray to each tells.
    pub(super) fn factors(
        &self,
        prospects: &[Prospect],
        tolerance: f64,
        view: &Viewpoint,
        scratch: &mut Scratch,
    ) -> SmallVec<[Factor; USUAL]> {
        let weak = match self.polygons.len() <= FEW {
            true => 0.0,
            false => weakest(prospects.iter().map(|p| RAY_DOUBT * p.light), tolerance),
        };
        let mut factor = |p: &Prospect| {
            if RAY_DOUBT * p.light <= weak && p.screens.is_none_or(|s| !s.is_empty()) {
                return Factor {
                    value: self.factor_by_ray(p, view, p.polygon.middle()),
                    is_exact: true,
                };
            }
            let doubt = tolerance / p.polygon.exitance.0.mean();
            self.factor_within(doubt, 0, p, view, scratch)
        };
        prospects.iter().map(&mut factor).collect()
    }

    /// All of an emitter or nothing, as one ray to a point of it tells.
    fn factor_by_ray(&self, prospect: &Prospect, view: &Viewpoint, point: DVec3) -> f64 {
        match self.blockers.sees(view, point, prospect.polygon.face) {
            true => prospect.factor,
            false => 0.0,
        }
    }
}

/// The greatest of those doubts that are small: the squares of it and of all that are no greater have no larger sum than that
/// of `tolerance`. Zero when none is.
fn weakest(doubts: impl Iterator<Item = f64>, tolerance: f64) -> f64 {
    let mut doubts: SmallVec<[f64; USUAL]> = doubts.collect();
    doubts.sort_unstable_by(f64::total_cmp);
    let (mut sum, mut weak) = (0.0, 0.0);
    for equals in doubts.chunk_by(|a, b| a == b) {
        sum += equals.iter().map(|l| l * l).sum::<f64>();
        if sum > tolerance * tolerance {
            break;
        }
        weak = equals[0];
    }
    weak
}

#[cfg(test)]
mod tests {
    use super::weakest;

    #[test]
    fn the_weak_stay_below_the_tolerance_together_and_equals_are_treated_alike() {
        let lights = [4.0, 0.5, 1.0, 2.0, 1.0];
        let weak = |squared: f64| weakest(lights.into_iter(), squared.sqrt());
        assert_eq!(weak(0.2), 0.0);
        assert_eq!(weak(0.25), 0.5);
        // One of the equals would still fit.
        assert_eq!(weak(2.0), 0.5);
        assert_eq!(weak(2.25), 1.0);
        assert_eq!(weak(100.0), 4.0);
        assert_eq!(weakest(std::iter::empty(), 1.0), 0.0);
    }
}
