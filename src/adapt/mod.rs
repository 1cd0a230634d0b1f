//! Chooses the display mesh from the error asked for.
//!
//! Every receiver starts from its outline, its contact lines and a coarse lattice. The exact direct light at edge
//! midpoints, at element centres and where candidate lines cross tells how far linear interpolation is off. Elements that
//! matter most for the error over all surfaces are marked (Dörfler 1996); a marked element gets the line that breaks most
//! inside it, or is divided where it fails most. Between the passes diagonals are turned along the light (Dyn, Levin &
//! Rippa 1990), and the values are fitted to it (Kavan, Bargteil & Sloan 2011). When the estimated error is the one asked
//! for, points that are not worth their elements are removed, and what that costs is bought where it is cheaper.

mod breaks;
mod fit;
mod flip;
mod misfit;
mod mix;
mod receiver;
mod room;
mod samples;
#[cfg(test)]
mod tests;
mod thin;
mod vantages;

pub use receiver::Receiver;
use room::Room;
use thin::Removable;

use crate::budget::Meter;
use crate::direct::DirectLight;
use crate::mesh::MeshError;
use crate::radiosity::IndirectField;
use rayon::prelude::*;

/// What display meshes follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Meshing {
    /// Contact lines, the lines that matter, and the error.
    #[default]
    Discontinuity,
    /// The error alone: for comparison.
    Adaptive,
    /// Nothing: a lattice, as fine everywhere as the error asked for needs, with the exact light at its points. For comparison.
    Uniform,
}

/// Where the light at a point comes from.
#[derive(Clone, Copy)]
pub struct Illumination<'a> {
    /// Straight from the emitters, exact.
    pub direct: &'a DirectLight<'a>,
    /// What the direct light may be off by at a point of a face that is not minor, W/m²: 0 where it is to be exact.
    pub tolerance: f64,
    /// By way of other faces, once it is known.
    pub indirect: Option<&'a IndirectField<'a>>,
}

/// Share of the permitted squared error that may stay in unmarked elements.
///
/// Near 1 each pass does the least and many passes follow; near 0 everything is refined at once and the mesh gets finer
/// than asked.
const UNMARKED_SHARE: f64 = 0.75;

/// A marked element loses about this share of its squared error; no more are marked than that brings the total to …
const GAIN_SHARE: f64 = 0.7;

/// … this share of what is permitted.
const AIM_SHARE: f64 = 0.97;

/// A mesh that needs more passes than this is beyond what bisection can do in the grid's 2²⁵ pixels.
const MAX_PASSES: usize = 64;

/// How often points are removed at most. The first time saves a fifth of the elements.
const THINNINGS: usize = 3;

/// The same where more light is to come: they are removed again when it has.
const EARLY_THINNINGS: usize = 1;

/// Points are removed again only where the last time has left at most this share of the elements for the same error: in
/// dappled light what is removed is bought back.
const THINNED_SHARE: f64 = 0.9;

/// A point goes when its removal costs at most this share of what the mean point is worth.
///
/// The squared error falls with the square of the number of elements, so that of N elements, two a point, one point is
/// worth 4/N of it.
const THIN_SHARE: f64 = 0.5;

/// Dividing an element adds a point, and so two elements; a line adds more.
const ELEMENTS_A_MARK: usize = 2;

/// How often a mesh that may have no more elements gives up those that are worth little for others.
const SQUEEZES: usize = 2;

/// A uniform mesh stops at this many elements, whatever its error: without lines it may never get there.
const MOST_UNIFORM: usize = 250_000;

/// The next uniform mesh has between this and half of the spacing of the last one.
const LEAST_STEP: f64 = 0.9;

/// Of two uniform meshes the next has at least so many times the elements of the last.
const UNIFORM_GROWTH: f64 = 1.0 / (LEAST_STEP * LEAST_STEP);

/// What the adaptation did.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct AdaptReport {
    /// Passes over all receivers.
    pub passes: usize,
    /// Exact evaluations of direct light.
    pub evaluations: usize,
    /// Points removed because they were not worth their elements.
    pub removed: usize,
    /// Estimated RMS error over the lit surfaces, W/m².
    pub estimated_rms: f64,
}

impl AdaptReport {
    /// Adds the work of a later round; its estimate replaces the earlier one.
    pub fn add(&mut self, later: &Self) {
        self.passes += later.passes;
        self.removed += later.removed;
        self.evaluations = later.evaluations;
        self.estimated_rms = later.estimated_rms;
    }
}

/// The errors of all receivers.
struct Errors {
    /// RMS error that is permitted, W/m².
    target: f64,
    /// Squared error that is permitted, (W/m²)² m².
    allowed: f64,
    /// Squared error that there is.
    total: f64,
    /// Those of the elements that can be divided, ascending.
    squares: Vec<f64>,
}

impl Errors {
    /// Measures what is new; none when nothing is lit.
    fn measure(
        receivers: &mut [Receiver],
        light: &Illumination,
        error: f64,
        mean_besides: f64,
        is_fitted: bool,
    ) -> Option<(Self, f64)> {
        let (mut power, mut area) = (0.0, 0.0);
        for r in receivers.iter().filter(|r| r.is_lit) {
            power += r.power().mean();
            area += r.area();
        }
        if area <= 0.0 {
            return None;
        }
        let target = error * (power / area + mean_besides);
        receivers
            .par_iter_mut()
            .for_each(|r| r.update_errors(light, target, is_fitted));
        let mut squares: Vec<f64> = receivers.iter().flat_map(Receiver::open_errors).collect();
        squares.sort_unstable_by(f64::total_cmp);
        let settled: f64 = receivers.iter().map(Receiver::settled_error).sum();
        let total = squares.iter().sum::<f64>() + settled;
        let errors = Self {
            target,
            allowed: target * target * area,
            total,
            squares,
        };
        Some((errors, (total / area).sqrt()))
    }

    fn is_met(&self) -> bool {
        self.total <= self.allowed || self.squares.is_empty()
    }

    /// Elements with at least this squared error are marked: `most` at most. None when that is none.
    fn limit(&self, most: usize) -> Option<f64> {
        let worst = self
            .squares
            .len()
            .checked_sub(most.min(self.squares.len()))?;
        let least = *self.squares.get(worst)?;
        Some(self.enough().max(least))
    }

    /// Elements with at least this squared error have to be divided, no more.
    fn enough(&self) -> f64 {
        let mut unmarked = 0.0;
        let all = self.squares.iter().find(|&&s| {
            unmarked += s;
            unmarked > UNMARKED_SHARE * self.allowed
        });
        let mut marked = 0.0;
        let enough = self.squares.iter().rev().find(|&&s| {
            marked += s;
            GAIN_SHARE * marked >= self.total - AIM_SHARE * self.allowed
        });
        let all = all.copied().unwrap_or(f64::INFINITY);
        all.max(enough.copied().unwrap_or(0.0))
    }
}

/// Refines the lit `receivers` until the RMS error of the light that they show is estimated below `error` times its mean,
/// both over the lit surfaces, or until the budget is used up. `mean_besides` (W/m²) is added to the mean: light that comes
/// later, with which points are removed. `limit` is the squared error ((W/m²)² m²) below which elements were let be last, none
/// at first.
///
/// # Errors
/// [`MeshError`]: our own bug.
pub fn refine(
    receivers: &mut [Receiver],
    light: &Illumination,
    error: f64,
    mean_besides: f64,
    limit: &mut Option<f64>,
    meter: &Meter,
    mut progress: impl FnMut(f64),
) -> Result<AdaptReport, MeshError> {
    let mut report = AdaptReport::default();
    let most_thinnings = match mean_besides > 0.0 {
        true => EARLY_THINNINGS,
        false => THINNINGS,
    };
    let mut thinnings = 0;
    // Elements when the error was last met.
    let mut before = usize::MAX;
    let mut room = Room::new(meter);
    let mut squeezes = 0;
    update(receivers, light, *limit)?;
    while report.passes < MAX_PASSES {
        let found = Errors::measure(receivers, light, error, mean_besides, true);
        let Some((errors, rms)) = found else {
            break;
        };
        report.passes += 1;
        report.estimated_rms = rms;
        progress((errors.target / rms).min(1.0));
        if meter.is_used_up() {
            break;
        }
        if !errors.is_met() {
            let Some(least) = errors.limit(room.marks(receivers)) else {
                if squeezes == SQUEEZES || !room.is_limited() {
                    break;
                }
                squeezes += 1;
                // What costs little makes room for what matters more.
                let allowed = errors.total;
                let removed = thin_out(receivers, light, &Errors { allowed, ..errors }, false);
                report.removed += removed;
                if removed == 0 {
                    break;
                }
                update(receivers, light, *limit)?;
                room.reopen();
                continue;
            };
            // Lines are worth keeping at the error that comes of it, not at one that is out of reach.
            let target = errors.target.max(room.attainable(receivers, rms));
            *limit = Some(least);
            receivers.par_iter_mut().try_for_each(|r| {
                if meter.is_late() {
                    return Ok(());
                }
                r.refine(light, least, target);
                r.update_mesh(light, *limit)
            })?;
        } else if thinnings < most_thinnings && report.passes + 1 < MAX_PASSES {
            let count = errors.squares.len();
            if count as f64 > THINNED_SHARE * before as f64 {
                break;
            }
            before = count;
            thinnings += 1;
            let removed = thin_out(receivers, light, &errors, thinnings == THINNINGS);
            report.removed += removed;
            if removed == 0 {
                break;
            }
        } else {
            break;
        }
        update(receivers, light, *limit)?;
        if room.is_exceeded(receivers) {
            update(receivers, light, *limit)?;
        }
    }
    report.evaluations = receivers.iter().map(Receiver::evaluations).sum();
    Ok(report)
}

/// Removes points that are not worth their elements: each costs little, or, at the end, all together no more than what
/// the error is better than permitted. Returns their number.
fn thin_out(
    receivers: &mut [Receiver],
    light: &Illumination,
    errors: &Errors,
    is_last: bool,
) -> usize {
    let found: Vec<Vec<Removable>> = receivers
        .par_iter_mut()
        .map(|r| r.removable(light))
        .collect();
    let mut most = THIN_SHARE * 4.0 * errors.allowed / errors.squares.len() as f64;
    if is_last {
        let mut losses: Vec<f64> = found.iter().flatten().map(|p| p.loss).collect();
        losses.sort_unstable_by(f64::total_cmp);
        let mut total = errors.total;
        let end = losses.iter().find(|&&l| {
            total += l;
            total > errors.allowed
        });
        most = most.min(end.copied().unwrap_or(f64::INFINITY));
    }
    let pairs = receivers.par_iter_mut().zip(&found);
    pairs.map(|(r, found)| r.remove(found, most)).sum()
}

fn update(
    receivers: &mut [Receiver],
    light: &Illumination,
    limit: Option<f64>,
) -> Result<(), MeshError> {
    receivers
        .par_iter_mut()
        .try_for_each(|r| r.update_mesh(light, limit))
}

/// Meshes all `receivers` by lattices of the same spacing, which starts at `spacing` (metres) and falls until the error is
/// as [`refine`] asks for, or until there are a quarter of a million elements.
///
/// # Errors
/// [`MeshError`]: our own bug.
pub fn refine_uniformly(
    receivers: &mut [Receiver],
    light: &Illumination,
    error: f64,
    mean_besides: f64,
    spacing: &mut f64,
    meter: &Meter,
    mut progress: impl FnMut(f64),
) -> Result<AdaptReport, MeshError> {
    let mut report = AdaptReport::default();
    loop {
        update(receivers, light, None)?;
        let found = Errors::measure(receivers, light, error, mean_besides, false);
        let Some((errors, rms)) = found else {
            break;
        };
        report.passes += 1;
        report.estimated_rms = rms;
        progress((errors.target / rms).min(1.0));
        let count = errors.squares.len() as f64;
        let most = MOST_UNIFORM as f64;
        let room = meter.most_elements() as f64;
        meter.lacks_elements(!errors.is_met() && count * UNIFORM_GROWTH > room);
        if errors.is_met() || count >= most || meter.reached().is_some() || meter.is_used_up() {
            break;
        }
        // Where the light is smooth the error falls with the square of the spacing.
        let step = (errors.target / rms).sqrt().clamp(0.5, LEAST_STEP);
        *spacing *= step.max((count / most.min(room)).sqrt());
        let spacing = *spacing;
        receivers.par_iter_mut().for_each(|r| r.seed(spacing));
    }
    report.evaluations = receivers.iter().map(Receiver::evaluations).sum();
    Ok(report)
}
