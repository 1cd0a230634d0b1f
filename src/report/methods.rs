//! What is compared: ways to mesh, elements, ways to solve. A new one is a new row.

use crate::adapt::Meshing;
use crate::radiosity::{self, Solver};
use crate::settings::Settings;

/// A way to mesh.
#[derive(Clone, Copy, Debug)]
pub struct MeshMethod {
    /// Name in tables and plots.
    pub name: &'static str,
    /// What the display mesh follows.
    pub meshing: Meshing,
}

/// All ways to mesh; the last is the program's own.
pub const MESH_METHODS: [MeshMethod; 3] = [
    MeshMethod {
        name: "uniform",
        meshing: Meshing::Uniform,
    },
    MeshMethod {
        name: "adaptive",
        meshing: Meshing::Adaptive,
    },
    MeshMethod {
        name: "discontinuity",
        meshing: Meshing::Discontinuity,
    },
];

/// What an element shows of the light over it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// The light at its middle, all over.
    Constant,
    /// The light at its corners, interpolated.
    Linear,
}

/// All bases.
pub const BASES: [(&str, Basis); 2] = [("constant", Basis::Constant), ("linear", Basis::Linear)];

/// A way to solve for the light between surfaces: a solver, or what its cells hold.
#[derive(Clone, Copy)]
pub struct SolveMethod {
    /// Name in tables.
    pub name: &'static str,
    /// Solves the links.
    pub solver: Solver,
    /// What a cell of the solution holds.
    pub cells: radiosity::Basis,
}

impl SolveMethod {
    const fn with(solver: Solver) -> Self {
        Self {
            name: solver.name(),
            solver,
            cells: radiosity::Basis::Linear,
        }
    }

    /// Has a bake solve this way.
    pub fn choose(&self, settings: &mut Settings) {
        settings.solver = self.solver;
        settings.basis = self.cells;
    }
}

/// Every solver, the program's own first, all on the same links but for shooting, which refines its own; and at last the
/// first one with cells in the other bases.
pub const SOLVE_METHODS: [SolveMethod; Solver::ALL.len() + 2] = {
    let own = SolveMethod::with(Solver::ALL[0]);
    let constant_cells = SolveMethod {
        name: "constant-cells",
        cells: radiosity::Basis::Constant,
        ..own
    };
    let wavelet_cells = SolveMethod {
        name: "wavelet-cells",
        cells: radiosity::Basis::Wavelet,
        ..own
    };
    let mut all = [own; Solver::ALL.len() + 2];
    let mut i = 0;
    while i < Solver::ALL.len() {
        all[i] = SolveMethod::with(Solver::ALL[i]);
        i += 1;
    }
    all[i] = constant_cells;
    all[i + 1] = wavelet_cells;
    all
};
