//! An even set of rays over the hemisphere: what tells a point of all that is neither bright nor small.

use crate::geom::even_point;
use crate::quantity::Irradiance;
use crate::scene::{FaceId, FaceSide};
use crate::visibility::{Blockers, Viewpoint};
use glam::DVec3;
use std::f64::consts::TAU;
use std::ops::Range;

/// Rays of a sweep. What they do not tell well enough is cut, so that their number trades rays for cutting: in rooms of 4 500
/// and 31 000 triangles a gather costs about the same from 128 to 512 rays, and 1.7 to 3 times as much with 4 096.
pub(super) const RAYS: u32 = 256;

/// And no more, however much they differ.
const MOST_RAYS: u32 = 16 * RAYS;

/// And no fewer, however faint all light is: what they disagree by is to be known.
const FEWEST_RAYS: f64 = 64.0;

/// Runs of rays, one after the other, that are compared.
pub(super) const RUNS: usize = 4;

/// Rays for a `part` of the `whole` of the light (both W) that is to be right to as much as that: what they are wrong by falls in
/// proportion to the light, and about what is large with the power ¾ of their number ([`Sweep::noise_of`]).
pub(super) fn rays_for(part: f64, whole: f64) -> u32 {
    let share = if whole > 0.0 { part / whole } else { 0.0 };
    let most = f64::from(RAYS);
    (most * share.powf(4.0 / 3.0)).clamp(FEWEST_RAYS, most) as u32
}

/// When the rays will not do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweep {
    /// A side about which they may be wrong by more than this (W/m²) is cut exactly.
    pub(super) noise: f64,
    /// About all that is left to them together they may be wrong by so much, W/m²: there are more of them until they are not.
    pub(super) together: f64,
    /// Their number at first.
    pub(super) rays: u32,
}

impl Sweep {
    /// By how much the rays may be wrong about a source of radiosity up to `brightest` whose light makes up to `arriving` of
    /// irradiance (both W/m²).
    ///
    /// Random rays would be wrong by `B √(F/N)`; of an even set only those along the outline are open to chance, `√(N F)` of
    /// them.
    fn noise_of(brightest: f64, arriving: f64, rays: u32) -> f64 {
        if brightest <= 0.0 {
            return 0.0;
        }
        let rays = f64::from(rays);
        let meeting = rays * (arriving / brightest).min(1.0);
        brightest / rays * (meeting / (1.0 + meeting).sqrt()).sqrt()
    }

    /// Whether the rays will do for such a source.
    pub(super) fn is_enough(self, brightest: f64, arriving: f64) -> bool {
        Self::noise_of(brightest, arriving, self.rays) <= self.noise
    }

    /// Whether so many rays are to be followed by as many more.
    pub(super) fn goes_on(self, runs: &Runs, rays: u32) -> bool {
        rays < MOST_RAYS && runs.noise(rays) > self.together
    }
}

/// What rays have met of the light: the sums over [`RUNS`] runs of as many rays each, one after the other.
///
/// Every run of the set is even by itself, so that how far they are apart tells how far they are off; sides that are each too
/// faint to be cut may be many.
#[derive(Default)]
pub(super) struct Runs {
    pub(super) sums: [Irradiance; RUNS],
}

impl Runs {
    /// Makes one of every two runs; the others are empty then.
    pub(super) fn join(&mut self) {
        for i in 0..RUNS {
            self.sums[i] = match self.sums.get(2 * i..2 * i + 2) {
                Some(two) => two[0] + two[1],
                None => Irradiance::ZERO,
            };
        }
    }

    /// By how much the mean over all of so many rays may be wrong (rms over the channels, W/m²).
    pub(super) fn noise(&self, rays: u32) -> f64 {
        let runs = RUNS as f64;
        let mean = self.sums.iter().fold(Irradiance::ZERO, |m, &s| m + s) * (1.0 / runs);
        let squares: f64 = self.sums.iter().map(|&s| (s - mean).0.mean_square()).sum();
        let of_one = (squares / (runs - 1.0)).sqrt() * runs / f64::from(rays);
        // Even rays fall off with the power ¾ of their number, as in `noise_of`.
        of_one / runs.powf(0.75)
    }
}

/// The sides that these rays of an even set from `view` meet, and where, metres.
pub(crate) fn met<'b>(
    blockers: &'b Blockers,
    view: &'b Viewpoint,
    rays: Range<u32>,
) -> impl Iterator<Item = (FaceId, FaceSide, DVec3)> + 'b {
    // Nothing within the weld distance of the viewpoint is seen: that is the surface it lies on.
    let start = blockers.weld_distance();
    rays.filter_map(move |i| {
        let along = direction(view.horizon.normal, i);
        let hit = blockers
            .rays()
            .nearest(view.position, along, start, f64::INFINITY)?;
        let side = if hit.is_front {
            FaceSide::Front
        } else {
            FaceSide::Back
        };
        let point = view.position + along * hit.t;
        Some((blockers.ray_owner(hit.triangle), side, point))
    })
}

/// Direction `i` of a cosine-distributed set over the hemisphere about `n`.
fn direction(n: DVec3, i: u32) -> DVec3 {
    let point = even_point(i);
    let (sin, cos) = (TAU * point.y).sin_cos();
    let u = n.any_orthonormal_vector();
    let v = n.cross(u);
    (u * cos + v * sin) * point.x.sqrt() + n * (1.0 - point.x).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Rgb;

    #[test]
    fn the_less_light_the_fewer_rays() {
        assert_eq!([2.0, 6.0].map(|part| rays_for(part, 2.0)), [RAYS; 2]);
        let rays = rays_for(1.0, 2.0);
        assert!(rays < RAYS / 2);
        let [all, half] = [(1.0, RAYS), (0.5, rays)]
            .map(|(light, rays)| Sweep::noise_of(light, 0.3 * light, rays));
        assert!((half / all - 1.0).abs() < 0.02, "{half} of {all}");
        assert_eq!(rays_for(0.0, 0.0), FEWEST_RAYS as u32);
    }

    #[test]
    fn runs_that_are_apart_tell_how_far_all_are_off() {
        let (mut off, mut told) = (0.0, 0.0);
        for rays in [64, 256, 1024] {
            for k in 1..100 {
                let a = f64::from(k) / 100.0 * std::f64::consts::FRAC_PI_2;
                let known = 0.5 * (1.0 - a.sin());
                let mut runs = Runs::default();
                let run = rays / RUNS as u32;
                let mut before = 0.0;
                for (sum, rays) in runs.sums.iter_mut().zip((1..).map(|i| i * run)) {
                    let met = lune(a, rays) * f64::from(rays);
                    *sum = Irradiance(Rgb::grey(met - before));
                    before = met;
                }
                off += (lune(a, rays) - known).powi(2);
                told += runs.noise(rays).powi(2);
            }
        }
        let ratio = f64::sqrt(told / off);
        assert!((0.5..2.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn rays_go_on_until_they_agree_or_are_too_many() {
        let sums = |of: [f64; RUNS]| of.map(|s| Irradiance(Rgb::grey(s)));
        let mut runs = Runs {
            sums: sums([10.0, 14.0, 12.0, 20.0]),
        };
        let sweep = |together: f64| Sweep {
            noise: 1.0,
            together,
            rays: RAYS,
        };
        let noise = runs.noise(RAYS);
        assert!(sweep(0.9 * noise).goes_on(&runs, RAYS));
        assert!(!sweep(1.1 * noise).goes_on(&runs, RAYS));
        assert!(!sweep(0.0).goes_on(&runs, MOST_RAYS));
        assert!(!sweep(f64::INFINITY).goes_on(&runs, RAYS));
        runs.join();
        assert_eq!(runs.sums, sums([24.0, 32.0, 0.0, 0.0]));
    }

    /// Share of the rays that meet the disc of form factor `f` around the normal: `sin² θ ≤ f`.
    fn disc(f: f64, rays: u32) -> f64 {
        let inside = (0..rays).filter(|&i| direction(DVec3::Z, i).truncate().length_squared() <= f);
        inside.count() as f64 / f64::from(rays)
    }

    /// The form factor of a half-disc of directions on one side of a plane at `a` radians from the zenith, a shape that no
    /// coordinate of the sequence is aligned with.
    fn lune(a: f64, rays: u32) -> f64 {
        let cut = DVec3::new(a.cos() * 0.6, a.cos() * 0.8, -a.sin());
        let inside = (0..rays).filter(|&i| direction(DVec3::Z, i).dot(cut) > 0.0);
        inside.count() as f64 / f64::from(rays)
    }

    #[test]
    fn even_rays_are_wrong_by_no_more_than_they_say() {
        let (mut worst, mut squares, mut count) = (0.0_f64, 0.0, 0.0);
        for rays in [128, 512, 2048, 8192] {
            for k in 1..100 {
                let f = f64::from(k) / 100.0;
                // Form factor of what lies beyond a plane through the horizon's diameter: (1 − sin a) / 2.
                let a = f64::from(k) / 100.0 * std::f64::consts::FRAC_PI_2;
                let beyond = 0.5 * (1.0 - a.sin());
                for (found, known) in [(disc(f, rays), f), (lune(a, rays), beyond)] {
                    let off = (found - known).abs() / Sweep::noise_of(1.0, known, rays);
                    worst = worst.max(off);
                    squares += off * off;
                    count += 1.0;
                }
            }
        }
        // A standard deviation, not a bound; the sequence is better than that on most.
        assert!(worst < 3.0, "{worst}");
        let rms = f64::sqrt(squares / count);
        assert!((0.1..1.0).contains(&rms), "{rms}");
    }
}
