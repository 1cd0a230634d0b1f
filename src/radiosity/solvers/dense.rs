//! Inversion: the whole matrix, decomposed once. The reference for small scenes; nothing is iterated but one refinement.

use super::{Corners, Outcome, Problem, Solver, System, share};
use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Unknowns at most: the matrix and its factors then take 2 × 200 MB, and 40 · 10⁹ operations.
const MOST_UNKNOWNS: usize = 5000;

/// The dense solver is for small scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{unknowns} unknowns are too many for a dense matrix (limit {MOST_UNKNOWNS})")]
pub struct TooManyUnknowns {
    /// So many.
    pub unknowns: usize,
}

/// Whether a matrix of so many unknowns is small enough.
///
/// # Errors
/// When it is not.
pub(in crate::radiosity) fn check(unknowns: usize) -> Result<(), TooManyUnknowns> {
    match unknowns <= MOST_UNKNOWNS {
        true => Ok(()),
        false => Err(TooManyUnknowns { unknowns }),
    }
}

/// Solves by LU decomposition with partial pivoting, one for each different set of reflectances among the channels.
pub(super) fn solve(problem: &Problem) -> Result<Outcome, TooManyUnknowns> {
    let system = problem.system;
    let n = system.len();
    check(n)?;
    let mut outcome = Outcome::dark(problem, Solver::Lu);
    let form_factors = columns(system);
    let mut factors: Vec<(Vec<f64>, _)> = Vec::new();
    let of_channel = [0, 1, 2].map(|channel| {
        let reflectances: Vec<f64> = system
            .blocks
            .iter()
            .flat_map(|b| b.nodes.clone().map(|_| b.reflectance[channel]))
            .collect();
        let known = factors.iter().position(|f| f.0 == reflectances);
        known.unwrap_or_else(|| {
            let matrix = DMatrix::from_fn(n, n, |i, j| {
                f64::from(u8::from(i == j)) - form_factors[j][i] * reflectances[j]
            });
            factors.push((reflectances, matrix.lu()));
            factors.len() - 1
        })
    });
    // The second time for what rounding left of the first.
    for _ in 0..2 {
        let (residual, _) = problem.residual(&outcome.x);
        for (channel, &of) in of_channel.iter().enumerate() {
            let mut b = DVector::from_iterator(n, residual.iter().map(|r| r[channel]));
            if factors[of].1.solve_mut(&mut b) {
                for (x, b) in outcome.x.iter_mut().zip(b.iter()) {
                    x[channel] += b;
                }
            }
        }
        let (left, largest) = problem.residual(&outcome.x);
        outcome
            .residuals
            .push(share(problem.reflected(&left), largest));
    }
    let last = outcome.residuals.last();
    outcome.is_settled = last.is_some_and(|&left| left <= problem.goal());
    Ok(outcome)
}

/// For each node what all nodes receive of its light if everything were white: the columns of `T` without reflectances.
fn columns(system: &System) -> Vec<Vec<f64>> {
    let (white, runs) = (system.white(), system.runs());
    let nodes: Vec<(usize, usize)> = (0..white.blocks.len())
        .flat_map(|b| white.blocks[b].nodes.clone().map(move |i| (b, i)))
        .collect();
    nodes
        .par_iter()
        .map_init(
            || vec![DVec3::ZERO; white.len()],
            |unit, &(b, i)| {
                let cells = white.blocks[b].cells.clone();
                let mut light: Vec<Corners> = vec![[DVec3::ZERO; 3]; cells.len()];
                unit[i] = DVec3::ONE;
                white.send(b, unit, None, &mut light);
                unit[i] = DVec3::ZERO;
                let mut column = vec![0.0; white.len()];
                for run in &runs[b] {
                    column[run.node as usize] += white.gather_from(run, cells.start, &light).x;
                }
                column
            },
        )
        .collect()
}
