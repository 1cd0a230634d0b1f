//! Light between faces: piecewise-linear collocation on a mesh coarser than the displayed one.
//!
//! `H_i = Σ_j K_ij R_j`, `R_j = ρ_j (g_j + H_j)`: `H` is the indirect irradiance at the sites of the solve mesh, `R` the
//! reflected radiosity, `g` the direct irradiance projected from the display mesh. `K_ij` is the exact form factor of what
//! site `i` sees of the elements around site `j`, split by the linear basis, so that the rows of a closed scene sum to 1.
//! `H` at a site is the mean of the gathered light around it, so that no power is lost between the sites.
//!
//! Papers: Lischinski, Tampieri & Greenberg, *Combining hierarchical radiosity and discontinuity meshing* (1993), for
//! solving coarsely and displaying finely; Atkinson & Chien (1998) for collocation of the occluded equation.

mod field;
mod field_face;
mod gather;
mod locator;
mod project;
mod reach;
mod solve;
mod solve_mesh;

pub use field::IndirectField;
pub use gather::{Gatherer, Row};
pub use project::{LightSample, project};
pub use reach::reached;
pub use solve::{Bounces, Gathered, SolveReport, Transport};
pub use solve_mesh::{MANY_SIDES, SolveFace, SolveMesh};
