//! Light between faces: collocation on a mesh coarser than the displayed one, linked to trees of cells.
//!
//! `H(x) = Σ_c ∫_c G V R_c dA`, `R = ρ (g + H)`: `H` is the indirect irradiance at the nodes of the solve mesh (quadratic in
//! between), `g` the direct irradiance, `R` the reflected radiosity, linear on each cell. A node is linked to the largest
//! cells that are good enough for it; the form factors of what it sees of them are exact, so that those of a closed scene
//! sum to 1.
//!
//! Papers: Hanrahan, Salzman & Aupperle, *A rapid hierarchical radiosity algorithm* (1991), for linking at the level that the
//! error asks for; Lischinski, Tampieri & Greenberg, *Combining hierarchical radiosity and discontinuity meshing* (1993), for
//! solving coarsely and displaying finely; Atkinson & Chien (1998) for collocation of the occluded equation; Bekaert &
//! Willems (1996) for the residual as an estimate of the error.

mod basis;
mod cells;
mod clusters;
mod field;
mod field_face;
mod gather;
mod greatest;
mod held;
mod kernel;
mod locator;
mod nodes;
mod reach;
mod rows;
mod solve;
mod solve_mesh;
mod solvers;
mod sweep;
#[cfg(test)]
mod tests;
mod walk;
mod wavelet;

pub use basis::Basis;
pub use field::{IndirectField, Request, SolutionError};
pub use gather::Gatherer;
pub use locator::Locator;
pub use reach::reached;
pub use rows::check_size;
pub use solve::{Bounces, Linking, SolveReport};
pub(crate) use solve_mesh::loss;
pub use solve_mesh::{SolveFace, SolveMesh};
pub use solvers::{Solver, TooManyUnknowns};
pub(crate) use sweep::met;
pub use wavelet::Compression;
