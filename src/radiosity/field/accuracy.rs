//! How good a gather has to be.

use super::super::clusters::Sources;
use super::super::gather::Oracle;
use super::super::sweep::Sweep;
use crate::radiosity::SolveMesh;

/// Shares of the permitted error that one link may miss by what is not linear about a cell, and one ray by what stands
/// between (where rays are used at all). The mistakes of many add like random steps.
pub(super) const LINK_SHARE: f64 = 0.2;
const RAY_SHARE: f64 = 0.2;

/// How good a gather is: what is not linear about cells right to `link`, what rays say to `ray`, W/m².
#[derive(Clone, Copy)]
pub(super) struct Accuracy {
    pub(super) link: f64,
    pub(super) ray: f64,
    /// Rays of an even set at first, where there are such.
    pub(super) sweep: u32,
}

impl Accuracy {
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            link: self.link * factor,
            ray: self.ray * factor,
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
            rays: accuracy.sweep,
        }),
    }
}
