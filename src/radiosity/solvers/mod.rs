//! Ways to solve `H = h + T H`, all on the same links.
//!
//! | solver | a step is | papers |
//! |---|---|---|
//! | [`jacobi`] | a bounce: all nodes from the light before | |
//! | [`relaxation`] | Gauss–Seidel and SOR: face by face, each from the newest light | Cohen & Greenberg 1985 (gathering) |
//! | [`shooting`] | the face with the most light that is not yet sent sends it | Southwell 1940; Cohen, Chen, Wallace & Greenberg 1988 |
//! | [`gmres`] | the best combination of all bounces so far | Saad & Schultz 1986 |
//! | [`dense`] | inversion: LU with pivots, the reference for small scenes | Goral, Torrance, Greenberg & Battaile 1984 |
//!
//! The three channels are three systems with the same links. Sums are taken in a fixed order: the number of threads changes
//! no bit.

mod choice;
mod dense;
mod gmres;
mod jacobi;
mod relaxation;
mod row;
mod shooting;
mod system;
#[cfg(test)]
mod tests;

pub(super) use choice::solve;
pub use dense::TooManyUnknowns;
pub(super) use dense::check;
pub(super) use jacobi::bounces;
pub(super) use row::{Link, Row};
pub(super) use shooting::{Until, solve as shoot};
pub(super) use system::{Block, Corners, Leaf, Parent, System};

use crate::bad_input::BadInput;
use glam::DVec3;

/// A way to solve for the light between surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// Gauss–Seidel, and GMRES where that would need many sweeps.
    #[default]
    Hierarchical,
    /// Every node from the light before, all at once.
    Jacobi,
    /// Face by face, each from the newest light.
    GaussSeidel,
    /// Gauss–Seidel, each change enlarged by a tenth.
    Sor,
    /// Shooting: the most unsent power first.
    Progressive,
    /// The generalised minimal residual, restarted.
    Gmres,
    /// Dense inversion, for a few thousand unknowns.
    Lu,
}

impl Solver {
    /// All solvers, the default first.
    pub const ALL: [Self; 7] = [
        Self::Hierarchical,
        Self::Jacobi,
        Self::GaussSeidel,
        Self::Sor,
        Self::Progressive,
        Self::Gmres,
        Self::Lu,
    ];

    /// Its name for users.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hierarchical => "hierarchical",
            Self::Jacobi => "jacobi",
            Self::GaussSeidel => "gauss-seidel",
            Self::Sor => "sor",
            Self::Progressive => "progressive",
            Self::Gmres => "gmres",
            Self::Lu => "lu",
        }
    }
}

impl std::str::FromStr for Solver {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let found = Self::ALL.into_iter().find(|s| s.name() == text);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            BadInput::new(
                "--solver",
                format!("\"{text}\" is no solver"),
                format!("give one of {names}"),
            )
        })
    }
}

/// What is to be solved, and how well.
pub(super) struct Problem<'s> {
    pub(super) system: &'s System,
    /// What the cells send before any of it has come back.
    pub(super) direct: &'s [Corners],
    /// Permitted error of the solution, relative to the largest radiosity.
    pub(super) tolerance: f64,
}

/// How far a solver has come.
#[derive(Clone, Debug)]
pub(super) struct Outcome {
    /// Indirect irradiance at the nodes, W/m².
    pub(super) x: Vec<DVec3>,
    /// After each step: what it left to do, relative to the largest radiosity.
    pub(super) residuals: Vec<f64>,
    /// Whether the error that is left is estimated below the permitted one.
    pub(super) is_settled: bool,
    /// Times that a face has sent light, if it was done one by one.
    pub(super) shots: usize,
    /// The solver at work, and why it was chosen.
    pub(super) method: Solver,
    pub(super) reason: String,
}

impl Outcome {
    /// Darkness, asked of `method`.
    fn dark(problem: &Problem, method: Solver) -> Self {
        Self {
            x: vec![DVec3::ZERO; problem.system.len()],
            residuals: Vec::new(),
            is_settled: false,
            shots: 0,
            method,
            reason: "asked for".to_owned(),
        }
    }
}

/// A residual of so many roundings cannot be told from none.
const ROUNDOFF: f64 = 64.0 * f64::EPSILON;

impl Problem<'_> {
    /// The residual that is permitted, relative to the largest radiosity: an error is at most its residual over what is lost at
    /// each bounce.
    fn goal(&self) -> f64 {
        let loss = 1.0 - self.system.contraction();
        (self.tolerance * loss).max(ROUNDOFF)
    }

    /// The largest reflected value of `r` (given at the nodes) in any channel, W/m².
    fn reflected(&self, r: &[DVec3]) -> f64 {
        let mut largest = 0.0_f64;
        for block in &self.system.blocks {
            for node in block.nodes.clone() {
                largest = largest.max((block.reflectance * r[node]).abs().max_element());
            }
        }
        largest
    }

    /// The largest change of the light from `old` to `new` values at the nodes, relative to `largest`.
    pub(super) fn change(&self, new: &[DVec3], old: &[DVec3], largest: f64) -> f64 {
        let steps: Vec<DVec3> = new.iter().zip(old).map(|(a, b)| *a - *b).collect();
        share(self.reflected(&steps), largest)
    }

    /// What one more bounce would change: `h + T x − x`, and the largest radiosity of `x`.
    fn residual(&self, x: &[DVec3]) -> (Vec<DVec3>, f64) {
        let (light, largest) = self.system.light_of(x, Some(self.direct));
        let mut r = self.system.gather_all(&light);
        for (r, x) in r.iter_mut().zip(x) {
            *r -= *x;
        }
        (r, largest)
    }
}

/// `part` of `whole`; nothing of nothing is nothing.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { part }
}
