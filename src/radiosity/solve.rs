//! The linear system of a solve mesh: its links, and its solution by the solver asked for.
//!
//! Unknown is the indirect irradiance at the nodes: the corners and edge midpoints of the solve mesh; between them it is
//! quadratic. It is gathered from the cells, face by face, and what the face then reflects, direct light and all, is projected
//! onto the face's own cells: no power is lost between the nodes.

use super::cells::{CellLight, FaceCells, FaceLight};
use super::field_face::CellLink;
use super::gather::Oracle;
use super::held::Held;
use super::nodes::{FaceNodes, NodalField};
use super::rows::Rows;
use super::solvers::{self, Block, Corners, Leaf, Outcome, Parent, Problem, Row, System, Until};
use super::wavelet::{Compression, Wavelets, left_out};
use super::{Basis, SolveFace, SolveMesh, Solver, TooManyUnknowns};
use crate::form_factor::RADON;
use crate::quantity::{Irradiance, Radiosity, Rgb};
use crate::visibility::Blockers;
use glam::DVec3;
use rayon::prelude::*;

/// How often light is reflected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounces {
    /// Exactly so many times.
    Count(u32),
    /// Until nothing changes.
    All,
}

/// How the solution was reached.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct SolveReport {
    /// The solver that was at work.
    pub method: &'static str,
    /// Why that one.
    pub reason: String,
    /// Nodes: unknowns a channel.
    pub nodes: usize,
    /// Elements of the solve mesh.
    pub elements: usize,
    /// Cells that send light.
    pub cells: usize,
    /// Links from a node to a cell.
    pub links: usize,
    /// After each sweep or step what it changed or left, relative to the largest radiosity.
    pub residuals: Vec<f64>,
    /// What one more bounce changes in the end, relative to the largest radiosity.
    pub residual: f64,
    /// Times that a face has sent its light, where that was done one by one.
    pub shots: usize,
    /// Whether the iteration has come within what was permitted.
    pub is_settled: bool,
    /// What was left out, in the basis of wavelets.
    pub wavelets: Option<Compression>,
}

/// The cells that nodes are linked with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Linking {
    /// The largest that are good enough.
    #[default]
    Hierarchical,
    /// The smallest: no hierarchy, for comparison.
    Leaves,
}

/// How a system is to be solved.
#[derive(Clone, Copy)]
pub(super) struct Method {
    pub(super) solver: Solver,
    pub(super) bounces: Bounces,
    /// Permitted error, relative to the largest radiosity.
    pub(super) tolerance: f64,
}

/// A solution.
pub(super) struct Solved {
    /// Indirect irradiance at the nodes.
    pub(super) values: Vec<Irradiance>,
    pub(super) report: SolveReport,
    /// What the cells send in the end.
    sent: Vec<Corners>,
}

/// The links of a solve mesh.
pub(super) struct Transport {
    /// The cells that it links.
    trees: Vec<FaceCells>,
    nodes: Vec<FaceNodes>,
    /// In the basis of wavelets, those that it links.
    wavelets: Option<Linked>,
    system: System,
}

/// Wavelets that any node is linked with.
struct Linked {
    /// By number.
    is_linked: Vec<bool>,
    /// Links that were left out.
    dropped: usize,
}

/// All rows in the basis of wavelets, and what is left of these.
fn compressed(wavelets: &Wavelets, rows: Vec<Row>) -> (Vec<Row>, Linked) {
    let rows: Vec<(Row, usize)> = rows
        .into_par_iter()
        .map(|row| {
            let (links, dropped) = wavelets.compressed(row.links());
            (Row::exact(links), dropped)
        })
        .collect();
    let mut linked = Linked {
        is_linked: vec![false; wavelets.count()],
        dropped: rows.iter().map(|row| row.1).sum(),
    };
    for link in rows.iter().flat_map(|row| row.0.links()) {
        linked.is_linked[link.cell as usize] = true;
    }
    (rows.into_iter().map(|row| row.0).collect(), linked)
}

impl Transport {
    /// Links every node with the cells it takes light from, in parallel; the nodes of faces for which `rays` gives a number
    /// by so many rays.
    pub(super) fn new(
        mesh: &SolveMesh,
        trees: &[FaceCells],
        blockers: &Blockers,
        oracle: &Oracle,
        basis: Basis,
        rays: impl Fn(&SolveFace) -> Option<u32> + Sync,
    ) -> Self {
        let first_cell = first_cells(trees);
        let rows = Rows {
            mesh,
            trees,
            blockers,
            oracle,
            first_cell: &first_cell,
        };
        let (nodes, rows) = match basis {
            Basis::Linear | Basis::Wavelet => rows.of_points(rays),
            Basis::Constant => rows.of_elements(rays),
        };
        let (rows, wavelets) = match basis {
            Basis::Wavelet => {
                let (sources, permitted) = (oracle.sources, oracle.link);
                let wavelets = Wavelets::new(mesh, trees, &first_cell, sources, permitted);
                let (rows, linked) = compressed(&wavelets, rows);
                (rows, Some(linked))
            }
            Basis::Linear | Basis::Constant => (rows, None),
        };
        let blocks = (0..mesh.faces.len())
            .into_par_iter()
            .map(|f| block(&mesh.faces[f], &trees[f], &nodes[f], first_cell[f]))
            .collect();
        Self {
            trees: trees.to_vec(),
            nodes,
            wavelets,
            system: System::new(basis, blocks, rows),
        }
    }

    /// Number of nodes.
    pub(super) fn node_count(&self) -> usize {
        self.system.len()
    }

    /// The links of a node.
    pub(super) fn links(&self, node: u32) -> impl Iterator<Item = CellLink> + '_ {
        let blocks = self.system.blocks();
        self.system.links(node as usize).map(move |link| {
            let cell = link.cell as usize;
            let f = blocks.partition_point(|b| b.cells.end <= cell);
            CellLink::new(f, cell - blocks[f].cells.start, link.weights)
        })
    }

    /// Solves for the indirect irradiance at the nodes, given in `light` what the cells send without it.
    ///
    /// # Errors
    /// [`TooManyUnknowns`] of the dense solver.
    pub(super) fn solve(
        &self,
        mesh: &SolveMesh,
        light: &[FaceLight],
        method: Method,
    ) -> Result<Solved, TooManyUnknowns> {
        let direct = self.corners(light);
        let problem = Problem {
            system: &self.system,
            direct: &direct,
            tolerance: method.tolerance,
        };
        let outcome = match method.bounces {
            // The final gather adds one bounce to those in the light of the cells.
            Bounces::Count(n) => solvers::bounces(&problem, n.saturating_sub(1) as usize),
            Bounces::All => solvers::solve(&problem, method.solver)?,
        };
        Ok(self.solved(mesh, &problem, outcome))
    }

    /// Shoots light on top of what has `arrived` at the nodes; and what they have not received yet, on average (W/m², the
    /// largest channel).
    pub(super) fn shoot(
        &self,
        mesh: &SolveMesh,
        light: &[FaceLight],
        tolerance: f64,
        arrived: Option<&[Irradiance]>,
        until: Until,
    ) -> (Solved, f64) {
        let direct = self.corners(light);
        let problem = Problem {
            system: &self.system,
            direct: &direct,
            tolerance,
        };
        let arrived = arrived.map(|x| x.iter().map(|e| e.0.0).collect());
        let (outcome, left) = solvers::shoot(&problem, arrived, until);
        let left = left.abs().max_element();
        (self.solved(mesh, &problem, outcome), left)
    }

    fn solved(&self, mesh: &SolveMesh, problem: &Problem, outcome: Outcome) -> Solved {
        let (told, largest) = self.system.light_of(&outcome.x, Some(problem.direct));
        let values = self.system.gather_all(&told);
        let residual = problem.change(&values, &outcome.x, largest);
        let wavelets = self.wavelets.as_ref();
        let wavelets = wavelets.map(|w| left_out(&self.trees, &told, &w.is_linked, w.dropped));
        Solved {
            report: SolveReport {
                wavelets,
                ..self.report(mesh, outcome, residual)
            },
            values: values.into_iter().map(irradiance).collect(),
            sent: self.system.sent(told),
        }
    }

    /// Makes `light` what the cells send in the end; the cells may have got children since they were linked, which are left
    /// alone.
    pub(super) fn take_over(&self, solved: &Solved, light: &mut [FaceLight]) {
        for ((light, tree), block) in light.iter_mut().zip(&self.trees).zip(self.system.blocks()) {
            for leaf in &block.leaves {
                let corners = solved.sent[block.cells.start + leaf.cell as usize];
                light.cells[leaf.cell as usize] = CellLight::linear(corners.map(radiosity));
            }
            light.pull(tree);
        }
    }

    fn report(&self, mesh: &SolveMesh, outcome: Outcome, residual: f64) -> SolveReport {
        SolveReport {
            method: outcome.method.name(),
            reason: outcome.reason,
            nodes: self.system.len(),
            elements: mesh.element_count(),
            cells: self.system.cell_count(),
            links: self.system.link_count(),
            residuals: outcome.residuals,
            residual,
            shots: outcome.shots,
            is_settled: outcome.is_settled && residual.is_finite(),
            wavelets: None,
        }
    }

    /// From now on what is `held` of face number `f` sends nothing of what it receives from others.
    pub(super) fn hold(&mut self, f: usize, held: &Held) {
        if held.any() {
            self.system.hold(f, &held.cells(&self.trees[f]));
        }
    }

    /// The values at the nodes as a field over the faces of `mesh`.
    pub(super) fn field<'t>(&'t self, values: &'t [Irradiance]) -> NodalField<'t> {
        NodalField {
            nodes: &self.nodes,
            values,
        }
    }

    /// The light of all cells that are linked, in one list.
    fn corners(&self, light: &[FaceLight]) -> Vec<Corners> {
        let blocks = self.system.blocks().iter().zip(light);
        blocks
            .flat_map(|(block, light)| &light.cells[..block.cells.len()])
            .map(|cell| cell.corners.map(|c| c.0.0))
            .collect()
    }

    /// Indirect irradiance at all nodes from what the cells send.
    pub(super) fn gather_all(&self, light: &[FaceLight]) -> Vec<Irradiance> {
        let told = self.system.told(&self.corners(light));
        let values = self.system.gather_all(&told);
        values.into_iter().map(irradiance).collect()
    }
}

fn irradiance(x: DVec3) -> Irradiance {
    Irradiance(Rgb(x))
}

fn radiosity(x: DVec3) -> Radiosity {
    Radiosity(Rgb(x))
}

/// Number of the first cell of each tree.
fn first_cells(trees: &[FaceCells]) -> Vec<usize> {
    let mut count = 0;
    let mut first = Vec::with_capacity(trees.len());
    for tree in trees {
        first.push(count);
        count += tree.cells.len();
    }
    first
}

/// What the solvers need to know of a face: how the light at its nodes becomes that of its cells, from number `first`.
fn block(face: &SolveFace, tree: &FaceCells, nodes: &FaceNodes, first: usize) -> Block {
    let leaf = |c: usize| Leaf {
        cell: c as u32,
        area: tree.cells[c].area,
        nodes: leaf_nodes(face, tree, nodes, c),
    };
    let parents = (0..tree.cells.len()).rev().filter_map(|c| {
        let cell = &tree.cells[c];
        Some(Parent {
            cell: c as u32,
            child: cell.first_child()? as u32,
            order: cell.order().map(|k| k as u8),
        })
    });
    Block {
        nodes: nodes.range.clone(),
        cells: first..first + tree.cells.len(),
        reflectance: face.reflectance.0,
        leaves: tree.leaves().map(leaf).collect(),
        parents: parents.collect(),
    }
}

/// The nodes that the light of leaf `c` depends on: what the quadratic field gives at the nodes of Radon's rule, projected
/// to the linear basis of the leaf.
fn leaf_nodes(
    face: &SolveFace,
    tree: &FaceCells,
    nodes: &FaceNodes,
    c: usize,
) -> Vec<(u32, [f64; 3])> {
    let cell = &tree.cells[c];
    let mut found: Vec<(u32, [f64; 3])> = Vec::new();
    for (w, weight) in RADON {
        // The corner values are 12 m − 3 Σ m of the moments m.
        let shares = w.map(|x| weight * (12.0 * x - 3.0));
        for (node, amount) in nodes.weights(face, cell.at(w)) {
            if amount == 0.0 {
                continue;
            }
            match found.iter_mut().find(|x| x.0 == node) {
                Some((_, sum)) => (0..3).for_each(|k| sum[k] += amount * shares[k]),
                None => found.push((node, shares.map(|s| s * amount))),
            }
        }
    }
    found
}
