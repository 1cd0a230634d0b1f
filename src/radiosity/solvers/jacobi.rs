//! All nodes at once from the light before: each step follows the light for one bounce more.

use super::relaxation::{MAX_SWEEPS, is_settled};
use super::{Outcome, Problem, Solver, share};
use glam::DVec3;

/// Steps until the error that is left, extrapolated from the last two changes, is below the tolerance.
pub(super) fn solve(problem: &Problem) -> Outcome {
    let mut outcome = Outcome::dark(problem, Solver::Jacobi);
    for _ in 0..MAX_SWEEPS {
        let (change, largest) = problem.residual(&outcome.x);
        let relative = share(problem.reflected(&change), largest);
        add(&mut outcome.x, &change);
        let previous = outcome.residuals.last().copied();
        outcome.residuals.push(relative);
        if is_settled(relative, previous, problem.tolerance) {
            outcome.is_settled = true;
            break;
        }
    }
    outcome
}

/// Exactly so many steps from darkness: light that has been reflected `count` times at most is followed.
pub(in crate::radiosity) fn bounces(problem: &Problem, count: usize) -> Outcome {
    let mut outcome = Outcome::dark(problem, Solver::Jacobi);
    outcome.reason = "counted bounces are followed one by one".to_owned();
    outcome.is_settled = true;
    for _ in 0..count {
        let (change, largest) = problem.residual(&outcome.x);
        let relative = share(problem.reflected(&change), largest);
        outcome.residuals.push(relative);
        add(&mut outcome.x, &change);
    }
    outcome
}

fn add(x: &mut [DVec3], change: &[DVec3]) {
    for (x, c) in x.iter_mut().zip(change) {
        *x += *c;
    }
}
