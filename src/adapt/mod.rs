//! Chooses the display mesh from the error asked for.
//!
//! Every receiver starts from its outline, its contact lines and a coarse lattice. The exact direct light at edge
//! midpoints, at element centres and where candidate lines cross tells how far linear interpolation is off. Elements that
//! matter most for the error over all surfaces are marked (Dörfler 1996); a marked element gets the lines that really break
//! inside it, or is bisected. The work ends when the estimated error is the one asked for.

mod error;
mod receiver;

pub use receiver::Receiver;

use crate::direct::DirectLight;
use crate::mesh::MeshError;
use crate::radiosity::IndirectField;
use rayon::prelude::*;

/// Where the light at a point comes from.
#[derive(Clone, Copy)]
pub struct Illumination<'a> {
    /// Straight from the emitters, exact.
    pub direct: &'a DirectLight<'a>,
    /// By way of other faces, once it is known.
    pub indirect: Option<&'a IndirectField<'a>>,
}

/// Share of the permitted squared error that may stay in unmarked elements.
///
/// Near 1 each pass does the least and many passes follow; near 0 everything is refined at once and the mesh gets finer
/// than asked. At ½ the final error lies between 0.7 and 1 of the one asked for.
const UNMARKED_SHARE: f64 = 0.5;

/// A mesh that needs more passes than this is beyond what bisection can do in the grid's 2²⁵ pixels.
const MAX_PASSES: usize = 48;

/// What the adaptation did.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct AdaptReport {
    /// Passes over all receivers.
    pub passes: usize,
    /// Exact evaluations of direct light.
    pub evaluations: usize,
    /// Estimated RMS interpolation error over the lit surfaces, W/m².
    pub estimated_rms: f64,
}

impl AdaptReport {
    /// Adds the work of a later round; its estimate replaces the earlier one.
    pub fn add(&mut self, later: &Self) {
        self.passes += later.passes;
        self.evaluations = later.evaluations;
        self.estimated_rms = later.estimated_rms;
    }
}

/// Refines the lit `receivers` until the RMS interpolation error of the light is estimated below `error` times its mean,
/// both over the lit surfaces. `mean_besides` (W/m²) is added to the mean: light that comes later.
///
/// # Errors
/// [`MeshError`]: our own bug.
pub fn refine(
    receivers: &mut [Receiver],
    light: &Illumination,
    error: f64,
    mean_besides: f64,
    mut progress: impl FnMut(f64),
) -> Result<AdaptReport, MeshError> {
    let mut report = AdaptReport::default();
    receivers
        .par_iter_mut()
        .try_for_each(|r| r.update_mesh(light))?;
    while report.passes < MAX_PASSES {
        let (mut power, mut area) = (0.0, 0.0);
        for r in receivers.iter().filter(|r| r.is_lit) {
            power += r.power().mean();
            area += r.area();
        }
        if area <= 0.0 {
            break;
        }
        let target = error * (power / area + mean_besides);
        receivers
            .par_iter_mut()
            .for_each(|r| r.update_errors(light, target));
        let mut squares: Vec<f64> = receivers.iter().flat_map(Receiver::open_errors).collect();
        squares.sort_unstable_by(f64::total_cmp);
        let settled: f64 = receivers.iter().map(Receiver::settled_error).sum();
        let total: f64 = squares.iter().sum::<f64>() + settled;
        let allowed = target * target * area;
        report.passes += 1;
        report.estimated_rms = (total / area).sqrt();
        progress((target / report.estimated_rms).min(1.0));
        if total <= allowed || squares.is_empty() {
            break;
        }
        let mut unmarked = 0.0;
        let limit = squares
            .iter()
            .find(|&&s| {
                unmarked += s;
                unmarked > UNMARKED_SHARE * allowed
            })
            .copied()
            .unwrap_or(f64::INFINITY);
        receivers.par_iter_mut().try_for_each(|r| {
            r.refine(light, limit, target);
            r.update_mesh(light)
        })?;
    }
    report.evaluations = receivers.iter().map(Receiver::evaluations).sum();
    Ok(report)
}
