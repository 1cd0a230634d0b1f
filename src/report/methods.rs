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

/// A way to solve for the light between surfaces.
#[derive(Clone, Copy)]
pub struct SolveMethod {
    /// Name in tables.
    pub name: &'static str,
    /// Chooses it.
    pub choose: fn(&mut Settings),
}

/// Ways to solve on the same links, and with constant cells; the first is the program's own.
pub const SOLVE_METHODS: [SolveMethod; 8] = [
    SolveMethod {
        name: "hierarchical",
        choose: |_| {},
    },
    SolveMethod {
        name: "jacobi",
        choose: |settings| settings.solver = Solver::Jacobi,
    },
    SolveMethod {
        name: "gauss-seidel",
        choose: |settings| settings.solver = Solver::GaussSeidel,
    },
    SolveMethod {
        name: "sor",
        choose: |settings| settings.solver = Solver::Sor,
    },
    SolveMethod {
        name: "progressive",
        choose: |settings| settings.solver = Solver::Progressive,
    },
    SolveMethod {
        name: "gmres",
        choose: |settings| settings.solver = Solver::Gmres,
    },
    SolveMethod {
        name: "lu",
        choose: |settings| settings.solver = Solver::Lu,
    },
    SolveMethod {
        name: "constant-cells",
        choose: |settings| settings.basis = radiosity::Basis::Constant,
    },
];
