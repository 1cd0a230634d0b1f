//! Which solver for which scene.

use super::relaxation::{CUSTOMARY, MAX_SWEEPS, NONE, Sweeps, sweeps_to_come};
use super::shooting::Until;
use super::system::LARGEST_CONTRACTION;
use super::{
    Outcome, Problem, Solver, TooManyUnknowns, dense, gmres, jacobi, relaxation, shooting,
};

/// After so many Gauss–Seidel sweeps their changes tell by what factor they shrink.
const PROBE_SWEEPS: usize = 4;

/// With more sweeps than this to come, GMRES is worth its vectors: it needs a few tens of steps for what they do, each as
/// dear as one of them.
const MANY_SWEEPS: f64 = 30.0;

/// Solves `problem` as it was asked for.
///
/// # Errors
/// [`TooManyUnknowns`] of the dense solver.
pub(in crate::radiosity) fn solve(
    problem: &Problem,
    solver: Solver,
) -> Result<Outcome, TooManyUnknowns> {
    let dark = |method| Outcome::dark(problem, method);
    let mut outcome = match solver {
        Solver::Hierarchical => by_scene(problem),
        Solver::Jacobi => jacobi::solve(problem),
        Solver::GaussSeidel => relaxation::solve(problem, dark(solver), NONE),
        Solver::Sor => relaxation::solve(problem, dark(solver), CUSTOMARY),
        Solver::Progressive => shooting::solve(problem, None, Until::Settled).0,
        Solver::Gmres => gmres::solve(problem, dark(solver)),
        Solver::Lu => dense::solve(problem)?,
    };
    // Light that is lost more slowly than the rows are exact is made of their rounding.
    let sent = problem.direct.iter().flatten();
    let sent = sent.map(|c| c.abs().max_element()).fold(0.0, f64::max);
    let most = sent / (1.0 - LARGEST_CONTRACTION);
    outcome.is_settled &= problem.reflected(&outcome.x) <= most;
    Ok(outcome)
}

/// Gauss–Seidel as long as it promises to end soon, then GMRES from where it has come to.
fn by_scene(problem: &Problem) -> Outcome {
    let mut outcome = Outcome::dark(problem, Solver::GaussSeidel);
    let mut sweeps = Sweeps::new(problem, NONE);
    while outcome.residuals.len() < MAX_SWEEPS {
        if sweeps.step(&mut outcome) {
            break;
        }
        let n = outcome.residuals.len();
        if n < PROBE_SWEEPS {
            continue;
        }
        let [before, change] = [outcome.residuals[n - 2], outcome.residuals[n - 1]];
        let q = change / before;
        let to_come = sweeps_to_come(change, q, problem.tolerance);
        if to_come > MANY_SWEEPS {
            outcome.method = Solver::Gmres;
            outcome.reason = reason(q, to_come);
            return gmres::solve(problem, outcome);
        }
    }
    outcome.reason = match outcome.residuals[..] {
        [.., before, change] if before > 0.0 && change > 0.0 => format!(
            "each sweep leaves {:.0} % of the change before it: few are enough",
            100.0 * change / before
        ),
        _ => "light between surfaces comes back once at most".to_owned(),
    };
    outcome
}

fn reason(q: f64, to_come: f64) -> String {
    let percent = 100.0 * q;
    let many = if to_come <= MAX_SWEEPS as f64 {
        format!("some {to_come:.0} more")
    } else {
        format!("more than {MAX_SWEEPS}")
    };
    format!(
        "each Gauss-Seidel sweep leaves {percent:.2} % of the change before it, {many} would be needed"
    )
}
