//! Gauss–Seidel and SOR: face by face, each from the newest light.
//!
//! A sweep gathers the light at the nodes of a face and lets the face reflect it at once, before the next face gathers. A
//! factor ω enlarges each change (successive over-relaxation, Young 1950): where light comes back again and again all changes
//! have one sign, and somewhat more than Gauss–Seidel's is nearer to the end. 1.1 is customary for radiosity; much above it
//! overshoots scenes that need few sweeps anyway.

use super::{Corners, Outcome, Problem, share};

/// A run that needs more sweeps than this has ρ above 0.9999; Krylov methods are for that.
pub(super) const MAX_SWEEPS: usize = 200_000;

/// ω of Gauss–Seidel, and of SOR.
pub(super) const NONE: f64 = 1.0;
pub(super) const CUSTOMARY: f64 = 1.1;

/// The light in the middle of a run.
pub(super) struct Sweeps<'p> {
    problem: &'p Problem<'p>,
    /// What links take from the cells now.
    light: Vec<Corners>,
    factor: f64,
}

impl<'p> Sweeps<'p> {
    /// Begins in darkness.
    pub(super) fn new(problem: &'p Problem, factor: f64) -> Self {
        Self {
            problem,
            light: problem.system.told(problem.direct),
            factor,
        }
    }

    /// One sweep: changes `x`, notes what it has changed, and tells whether that is the end.
    pub(super) fn step(&mut self, outcome: &mut Outcome) -> bool {
        let system = self.problem.system;
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for (b, block) in system.blocks.iter().enumerate() {
            for node in block.nodes.clone() {
                let old = outcome.x[node];
                let step = (system.gather(node, &self.light) - old) * self.factor;
                outcome.x[node] = old + step;
                change = change.max((block.reflectance * step).abs().max_element());
            }
            let cells = &mut self.light[block.cells.clone()];
            largest = largest.max(system.send(b, &outcome.x, Some(self.problem.direct), cells));
        }
        let relative = share(change, largest);
        let previous = outcome.residuals.last().copied();
        outcome.residuals.push(relative);
        outcome.is_settled = is_settled(relative, previous, self.problem.tolerance);
        outcome.is_settled
    }

    /// Sweeps until nothing changes.
    pub(super) fn run(&mut self, outcome: &mut Outcome) {
        for _ in 0..MAX_SWEEPS {
            if self.step(outcome) {
                break;
            }
        }
    }
}

/// Sweeps until the error that is left is below the tolerance, with `factor` (ω).
pub(super) fn solve(problem: &Problem, mut outcome: Outcome, factor: f64) -> Outcome {
    Sweeps::new(problem, factor).run(&mut outcome);
    outcome
}

/// Changes shrink geometrically by some q: what is left after the last is change · q / (1 − q).
pub(super) fn is_settled(change: f64, previous: Option<f64>, tolerance: f64) -> bool {
    match previous {
        _ if change == 0.0 => true,
        Some(previous) if change < previous => {
            let q = change / previous;
            change * q / (1.0 - q) <= tolerance
        }
        _ => false,
    }
}

/// Sweeps until changes that shrink by `q` each time, the last of them `change`, leave less than `tolerance`.
pub(super) fn sweeps_to_come(change: f64, q: f64, tolerance: f64) -> f64 {
    if change <= 0.0 || q <= 0.0 {
        return 0.0;
    }
    if q >= 1.0 {
        return f64::INFINITY;
    }
    ((tolerance * (1.0 - q) / (change * q)).ln() / q.ln()).max(0.0)
}
