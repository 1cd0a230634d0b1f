//! The error of the light at every vertex, estimated from what the solution leaves over.

use super::Solution;
use super::indirect::Shown;
use crate::adapt::Receiver;
use crate::radiosity::SolutionError;
use rayon::prelude::*;

/// The estimated error at the vertices, in numbers; all relative to the mean irradiance, RMS over the lit surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ErrorEstimate {
    /// All parts together (they add in squares).
    pub relative_rms: f64,
    /// The largest at any vertex.
    pub relative_max: f64,
    /// Of the solution: the error equation with the residual as its source.
    pub relative_rms_solution: f64,
    /// Of interpolating the indirect light between the points where it was gathered.
    pub relative_rms_field: f64,
    /// Of interpolating over the display mesh.
    pub relative_rms_mesh: f64,
}

/// Estimated errors of one receiver's sites, W/m²: solution, field, mesh.
type Parts = [Vec<f64>; 3];

/// For each receiver the estimated error at its sites (W/m²), and the figures.
pub(super) fn estimate(solution: &Solution) -> (Vec<Vec<f64>>, ErrorEstimate) {
    let error = solution.indirect.as_ref().map(|field| {
        let shown = Shown::new(&solution.receivers, field.mesh().faces.len());
        field.solution_error(|_, f, p| shown.direct(f, p))
    });
    let parts: Vec<Parts> = solution
        .receivers
        .par_iter()
        .map(|r| parts_of(solution, error.as_ref(), r))
        .collect();
    let all: Vec<Vec<f64>> = parts
        .iter()
        .map(|[a, b, c]| {
            let both = a.iter().zip(b).zip(c);
            both.map(|((a, b), c)| a.hypot(*b).hypot(*c)).collect()
        })
        .collect();
    let mean = solution.summary.measured.mean;
    let relative = |x: f64| if mean > 0.0 { x / mean } else { 0.0 };
    let rms = |k: usize| {
        relative(rms(
            &solution.receivers,
            &parts.iter().map(|p| &p[k]).collect::<Vec<_>>(),
        ))
    };
    let figures = ErrorEstimate {
        relative_rms: relative(self::rms(
            &solution.receivers,
            &all.iter().collect::<Vec<_>>(),
        )),
        relative_max: relative(all.iter().flatten().copied().fold(0.0, f64::max)),
        relative_rms_solution: rms(0),
        relative_rms_field: rms(1),
        relative_rms_mesh: rms(2),
    };
    (all, figures)
}

fn parts_of(solution: &Solution, error: Option<&SolutionError>, r: &Receiver) -> Parts {
    let sites = r.mesh.site_points.iter();
    let (mut of_solution, mut of_field) = (vec![0.0; sites.len()], vec![0.0; sites.len()]);
    if let (Some(field), Some(error), Some(f)) = (&solution.indirect, error, r.solve_face) {
        for (s, &p) in sites.enumerate() {
            let missing = field.solution_error_at(error, f, p);
            of_solution[s] = missing.0.mean_square().sqrt();
            of_field[s] = field.interpolation_error_at(f, p);
        }
    }
    [of_solution, of_field, r.interpolation_errors()]
}

/// Over the area of all lit elements, each with the mean square of its corners.
fn rms(receivers: &[Receiver], values: &[&Vec<f64>]) -> f64 {
    let (mut squares, mut area) = (0.0, 0.0);
    for (r, values) in receivers.iter().zip(values).filter(|(r, _)| r.is_lit) {
        for (e, sites) in r.mesh.sites.iter().enumerate() {
            let a = r.mesh.area(e);
            let square: f64 = sites.iter().map(|&s| values[s as usize].powi(2)).sum();
            squares += a * square / 3.0;
            area += a;
        }
    }
    if area > 0.0 {
        (squares / area).sqrt()
    } else {
        0.0
    }
}
