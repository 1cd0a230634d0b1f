//! Progressive refinement (Cohen, Chen, Wallace & Greenberg 1988), a relaxation after Southwell (1940): the face with the
//! most power that has not been sent sends it along all its links, and the faces that it reaches have so much more to send.
//!
//! Links may become finer while light is shot ([`super::super::field`] has them follow it): what has arrived stays, and
//! what the finer links find out about it is unsent.
//!
//! The first shots bring most of the light. For a preview after some of them, the *ambient* estimate stands for the rest:
//! what is unsent, spread evenly over all faces, and all its further bounces.

use super::relaxation::MAX_SWEEPS;
use super::system::Run;
use super::{Corners, Outcome, Problem, Solver, share};
use glam::DVec3;

/// Shots at most: so many for each face, as many as sweeps of the other methods.
const MOST_ROUNDS: usize = MAX_SWEEPS;

/// When enough has been sent.
#[derive(Clone, Copy, Debug)]
pub(in crate::radiosity) enum Until {
    /// What is unsent is below the tolerance.
    Settled,
    /// What nodes have not received yet is estimated below this on average, W/m² (any channel).
    Ambient(f64),
    /// After so many shots.
    #[cfg(test)]
    Shots(usize),
}

/// Sends light until there is enough of it, from darkness or from what has `arrived` at the nodes by other links; and the
/// ambient estimate of what is left then, which is not part of the outcome (irradiance at all nodes, W/m²).
pub(in crate::radiosity) fn solve(
    problem: &Problem,
    arrived: Option<Vec<DVec3>>,
    until: Until,
) -> (Outcome, DVec3) {
    let mut state = Unsent::new(problem);
    let mut outcome = Outcome::dark(problem, Solver::Progressive);
    if let Some(mut x) = arrived {
        state.resume(&mut x);
        outcome.x = x;
    }
    let goal = problem.goal();
    let faces = problem.system.blocks.len();
    let most = match until {
        #[cfg(test)]
        Until::Shots(most) => most,
        _ => faces.saturating_mul(MOST_ROUNDS),
    };
    while outcome.shots < most {
        let Some(b) = state.brightest() else {
            outcome.is_settled = true;
            break;
        };
        state.shoot(b, &mut outcome.x);
        outcome.shots += 1;
        // As dear as a sweep: time to see what is left.
        if outcome.shots.is_multiple_of(faces) {
            let left = state.left(&outcome.x);
            outcome.residuals.push(left);
            outcome.is_settled = left <= goal && state.is_all_direct_sent();
            let is_enough = match until {
                Until::Ambient(limit) => state.ambient().abs().max_element() <= limit,
                _ => false,
            };
            if outcome.is_settled || is_enough {
                break;
            }
        }
    }
    (outcome, state.ambient())
}

/// What is still to be sent.
struct Unsent<'p> {
    problem: &'p Problem<'p>,
    /// By source block.
    runs: Vec<Vec<Run>>,
    /// Irradiance at the nodes that has not been reflected yet.
    arrived: Vec<DVec3>,
    /// Blocks whose direct light has been sent.
    is_direct_sent: Vec<bool>,
    /// Unsent power of each block, W, mean of the channels; signs are left out.
    power: Vec<f64>,
    /// Block and reach (m²) of each node.
    nodes: Vec<(u32, f64)>,
}

impl<'p> Unsent<'p> {
    fn new(problem: &'p Problem) -> Self {
        let system = problem.system;
        let mut nodes = vec![(0, 0.0); system.len()];
        let mut power = Vec::with_capacity(system.blocks.len());
        for (b, block) in system.blocks.iter().enumerate() {
            let mut direct = 0.0;
            for leaf in &block.leaves {
                let corners = problem.direct[block.cells.start + leaf.cell as usize];
                direct += mean_of(&corners) * leaf.area;
                for (node, weights) in &leaf.nodes {
                    let share = weights.iter().map(|w| w.abs()).sum::<f64>() / 3.0;
                    nodes[*node as usize].1 += share * leaf.area;
                }
            }
            for node in block.nodes.clone() {
                nodes[node].0 = b as u32;
            }
            power.push(direct);
        }
        Self {
            problem,
            runs: system.runs(),
            arrived: vec![DVec3::ZERO; system.len()],
            is_direct_sent: power.iter().map(|&p| p <= 0.0).collect(),
            power,
            nodes,
        }
    }

    /// Goes on from what has arrived, `x`, as if it had been sent along these links: what they bring beyond it arrives now,
    /// and is unsent.
    fn resume(&mut self, x: &mut [DVec3]) {
        self.arrived = self.problem.residual(x).0;
        for (x, more) in x.iter_mut().zip(&self.arrived) {
            *x += more;
        }
        self.is_direct_sent.fill(true);
        self.power.fill(0.0);
        for (arrived, &(b, reach)) in self.arrived.iter().zip(&self.nodes) {
            let reflected = self.problem.system.blocks[b as usize].reflectance * arrived.abs();
            self.power[b as usize] += reach * reflected.element_sum() / 3.0;
        }
    }

    /// The block with the most unsent power, the first of equals; none when all is sent.
    fn brightest(&self) -> Option<usize> {
        let mut best = None;
        let mut most = 0.0;
        for (b, &power) in self.power.iter().enumerate() {
            if power > most {
                (best, most) = (Some(b), power);
            }
        }
        best
    }

    /// Block `b` sends what it has. `x` is all that has arrived.
    fn shoot(&mut self, b: usize, x: &mut [DVec3]) {
        let system = self.problem.system;
        let block = &system.blocks[b];
        let mut light = vec![[DVec3::ZERO; 3]; block.cells.len()];
        let direct = (!self.is_direct_sent[b]).then_some(self.problem.direct);
        system.send(b, &self.arrived, direct, &mut light);
        self.is_direct_sent[b] = true;
        self.power[b] = 0.0;
        for node in block.nodes.clone() {
            self.arrived[node] = DVec3::ZERO;
        }
        for run in &self.runs[b] {
            let node = run.node as usize;
            let more = system.gather_from(run, block.cells.start, &light);
            let (old, new) = (self.arrived[node], self.arrived[node] + more);
            x[node] += more;
            self.arrived[node] = new;
            let (other, reach) = self.nodes[node];
            let reflectance = system.blocks[other as usize].reflectance;
            let change = (reflectance * (new.abs() - old.abs())).element_sum() / 3.0;
            let power = &mut self.power[other as usize];
            *power = (*power + reach * change).max(0.0);
        }
    }

    /// The largest radiosity that has not been sent, relative to the largest of all.
    fn left(&self, x: &[DVec3]) -> f64 {
        let (_, largest) = self.problem.system.light_of(x, Some(self.problem.direct));
        share(self.problem.reflected(&self.arrived), largest)
    }

    fn is_all_direct_sent(&self) -> bool {
        self.is_direct_sent.iter().all(|&s| s)
    }

    /// What all nodes receive if the unsent light were everywhere alike: its mean over the faces, and that times the mean
    /// reflectance for each further bounce.
    fn ambient(&self) -> DVec3 {
        let system = self.problem.system;
        let (mut unsent, mut reflected, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for (b, block) in system.blocks.iter().enumerate() {
            let mut light = vec![[DVec3::ZERO; 3]; block.cells.len()];
            let direct = (!self.is_direct_sent[b]).then_some(self.problem.direct);
            system.reflect(b, &self.arrived, direct, &mut light);
            for leaf in &block.leaves {
                let [a, b, c] = light[leaf.cell as usize];
                unsent += (a + b + c) * (leaf.area / 3.0);
                reflected += block.reflectance * leaf.area;
                area += leaf.area;
            }
        }
        if area <= 0.0 {
            return DVec3::ZERO;
        }
        let (mean, kept) = (unsent / area, DVec3::ONE - reflected / area);
        DVec3::from_array([0, 1, 2].map(|k| share(mean[k], kept[k])))
    }
}

/// Mean of the absolute values, W/m².
fn mean_of(corners: &Corners) -> f64 {
    corners.iter().map(|c| c.abs().element_sum()).sum::<f64>() / 9.0
}
