//! What a bake shows against what is there.

use crate::common::bake::{SurfacePoint, surface_points};
use rayon::prelude::*;
use umbrage::pipeline::Solution;
use umbrage::quantity::Irradiance;
use umbrage::radiosity::{Gatherer, IndirectField};
use umbrage::visibility::Scratch;

/// Errors relative to the mean irradiance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    /// RMS, against exact direct light and indirect light gathered from the finer solution.
    pub(super) rms: f64,
    /// The largest at any point, likewise.
    pub(super) max: f64,
    /// RMS of the direct part alone.
    pub(super) direct: f64,
    /// RMS against light gathered from the bake's own solution: interpolation over display mesh and indirect field.
    pub(super) interpolation: f64,
    /// RMS between both gathered values: the error of the solution, without that of any interpolation.
    pub(super) solution: f64,
}

/// Differences at one point: shown − exact, shown direct − exact direct, shown − own gather, own − finer gather; and the
/// exact light.
type Differences = [Irradiance; 5];

/// The buffers of one thread.
struct Tools<'a> {
    scratch: Scratch,
    own: Option<Gatherer<'a>>,
    finer: Option<Gatherer<'a>>,
}

impl Errors {
    /// Measures at `count` points; without a finer solution the bake's own counts as exact.
    pub(super) fn measure(
        solution: &Solution,
        fine: Option<&IndirectField>,
        count: usize,
        seed: u64,
    ) -> Self {
        let points = surface_points(solution, count, seed);
        let tools = || Tools {
            scratch: Scratch::default(),
            own: solution.indirect.as_ref().map(|f| f.gatherer()),
            finer: fine.map(IndirectField::gatherer),
        };
        let found: Vec<Differences> = points
            .par_iter()
            .map_init(tools, |tools, p| differences(solution, fine, p, tools))
            .collect();
        let n = found.len() as f64;
        let mean = found.iter().map(|d| d[4].mean()).sum::<f64>() / n;
        let rms = |k: usize| (found.iter().map(|d| d[k].0.mean_square()).sum::<f64>() / n).sqrt();
        let max = found
            .iter()
            .map(|d| d[0].0.0.abs().max_element())
            .fold(0.0, f64::max);
        Self {
            rms: rms(0) / mean,
            max: max / mean,
            direct: rms(1) / mean,
            interpolation: rms(2) / mean,
            solution: rms(3) / mean,
        }
    }
}

fn differences(
    solution: &Solution,
    fine: Option<&IndirectField>,
    p: &SurfacePoint,
    tools: &mut Tools,
) -> Differences {
    let receiver = &solution.receivers[p.receiver];
    let view = p.view(solution);
    let direct = solution.direct.irradiance(&view, &mut tools.scratch);
    let own = match (&solution.indirect, &mut tools.own) {
        (Some(field), Some(gatherer)) => field.gather(gatherer, &view),
        _ => Irradiance::ZERO,
    };
    let finer = match (fine, &mut tools.finer) {
        (Some(field), Some(gatherer)) => field.gather(gatherer, &view),
        _ => own,
    };
    let sites = receiver.mesh.sites[p.element].map(|s| receiver.direct[s as usize]);
    let mut shown_direct = Irradiance::ZERO;
    for (value, weight) in sites.into_iter().zip(p.weights) {
        shown_direct += value * weight;
    }
    let shown = receiver.shown(p.element, p.weights);
    [
        shown - (direct + finer),
        shown_direct - direct,
        shown - (direct + own),
        own - finer,
        direct + finer,
    ]
}
