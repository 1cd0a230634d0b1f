//! How good a gather has to be.

use super::super::clusters::Sources;
use super::super::gather::Oracle;
use super::super::sweep::Sweep;
use crate::radiosity::SolveMesh;

/// Shares of the permitted error that one link may miss by what is not linear about a cell, and one ray by what stands
/// between (where rays are used at all). The mistakes of many add like random steps.
pub(super) const LINK_SHARE: f64 = 0.2;
const RAY_SHARE: f64 = 0.2;

/// Share of the permitted error that rays may be wrong by together at a point that is shown.
const TOGETHER_SHARE: f64 = 0.4;

/// The same for one of a few corrections, each of which adds its own.
const CORRECTION_TOGETHER: f64 = 0.5 * TOGETHER_SHARE;

/// A correction is small: its gathers may be so much less accurate.
const CORRECTION_ACCURACY: f64 = 2.0;

/// The mistakes of rays about one thing at a point that is shown may be so many times as large: what comes back of them is a mean
/// over many, and they are small beside what interpolation misses. In two rooms of 3 000 and 5 000 triangles gathers took .6 of
/// the time for the same error at as many points.
const SHOWN_RAYS: f64 = 4.0;

/// How good a gather is: what is not linear about cells right to `link`, what rays say to `ray`, W/m².
#[derive(Clone, Copy)]
pub(super) struct Accuracy {
    pub(super) link: f64,
    pub(super) ray: f64,
    /// What all rays of an even set may be wrong by together, W/m².
    pub(super) together: f64,
    /// Rays of an even set at first, where there are such.
    pub(super) sweep: u32,
}

/// What a gather that others are judged by is asked for beyond that.
const REFERENCE_SHARE: f64 = 0.25;

impl Accuracy {
    /// What others are judged by, where this is enough for light that is reflected on.
    pub(super) fn reference(self) -> Self {
        let together = TOGETHER_SHARE * self.ray;
        Self { together, ..self }.times(REFERENCE_SHARE)
    }

    /// What is enough at a point that is shown, where this is enough for light that is reflected on.
    pub(super) fn shown(self) -> Self {
        Self {
            together: TOGETHER_SHARE * self.ray,
            ray: SHOWN_RAYS * self.ray,
            ..self
        }
    }

    /// What is enough of a correction of it, by so many rays at first.
    pub(super) fn correcting(self, rays: u32) -> Self {
        Self {
            together: CORRECTION_TOGETHER * self.ray,
            sweep: rays,
            ..self.times(CORRECTION_ACCURACY)
        }
    }

    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            link: self.link * factor,
            ray: self.ray * factor,
            together: self.together * factor,
            ..self
        }
    }
}

/// How good a row or gather from `sources` has to be.
pub(super) fn oracle<'s>(mesh: &SolveMesh, sources: &'s Sources, accuracy: Accuracy) -> Oracle<'s> {
    let is_crowded = mesh.is_crowded();
    let ray = RAY_SHARE * accuracy.ray;
    Oracle {
        sources,
        link: LINK_SHARE * accuracy.link,
        ray: if is_crowded { ray } else { 0.0 },
        sweep: (is_crowded && ray > 0.0).then_some(Sweep {
            noise: ray,
            together: accuracy.together,
            rays: accuracy.sweep,
        }),
    }
}
