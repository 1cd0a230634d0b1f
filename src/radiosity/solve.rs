//! The linear system and its solution by Gauss–Seidel sweeps.
//!
//! Unknown is the indirect irradiance at the nodes: the corners and edge midpoints of the solve mesh; between them it is
//! quadratic. A sweep gathers it from the cells, face by face, and projects what the face then reflects, direct light and
//! all, onto the face's own cells: no power is lost between the nodes.

use super::cells::{CellLight, FaceCells, FaceLight, RADON};
use super::gather::Oracle;
use super::nodes::{FaceNodes, NodalField};
use super::{Gatherer, SolveFace, SolveMesh};
use crate::quantity::{Irradiance, Radiosity, Rgb};
use crate::visibility::{Blockers, Viewpoint};
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
    /// Nodes: unknowns a channel.
    pub nodes: usize,
    /// Elements of the solve mesh.
    pub elements: usize,
    /// Cells that send light.
    pub cells: usize,
    /// Links from a node to a cell.
    pub links: usize,
    /// Largest change of the light in each sweep, relative to the largest radiosity.
    pub residuals: Vec<f64>,
}

/// A Gauss–Seidel run that needs more sweeps than this has ρ above 0.999; Krylov methods are for that.
const MAX_SWEEPS: usize = 20_000;

/// What one node sees: cells (numbered through all faces) and the weights of the light at their corners.
type Row = Vec<(u32, [f64; 3])>;

/// The nodes that the light of one leaf depends on.
struct Leaf {
    cell: u32,
    /// Weights of the indirect irradiance at the nodes for the light at the three corners, before reflection.
    nodes: Vec<(u32, [f64; 3])>,
}

/// The links of a solve mesh.
pub(super) struct Transport {
    /// The cells that it links.
    trees: Vec<FaceCells>,
    nodes: Vec<FaceNodes>,
    rows: Vec<Row>,
    /// By face.
    leaves: Vec<Vec<Leaf>>,
    /// Number of the first cell of each face.
    first_cell: Vec<u32>,
}

impl Transport {
    /// Links every node with the cells it takes light from, in parallel; the nodes of faces for which `rays` gives a number
    /// by so many rays.
    pub(super) fn new(
        mesh: &SolveMesh,
        trees: &[FaceCells],
        blockers: &Blockers,
        oracle: &Oracle,
        rays: impl Fn(&SolveFace) -> Option<u32> + Sync,
    ) -> Self {
        let mut views: Vec<Viewpoint> = Vec::new();
        let nodes: Vec<FaceNodes> = mesh
            .faces
            .iter()
            .map(|face| FaceNodes::new(face, blockers.weld_distance(), &mut views))
            .collect();
        let mut first_cell = Vec::with_capacity(trees.len());
        let mut count = 0;
        for tree in trees {
            first_cell.push(count);
            count += tree.cells.len() as u32;
        }
        let owner: Vec<&SolveFace> = mesh
            .faces
            .iter()
            .zip(&nodes)
            .flat_map(|(face, nodes)| nodes.range.clone().map(move |_| face))
            .collect();
        let rows = views
            .par_iter()
            .zip(&owner)
            .map_init(
                || Gatherer::new(mesh, trees, blockers),
                |gatherer, (view, face)| {
                    let mut row = Row::new();
                    let mut sink = |f: usize, c: usize, w| row.push((first_cell[f] + c as u32, w));
                    match rays(face) {
                        Some(n) => gatherer.visit_by_rays(view, face.domain.face, n, &mut sink),
                        None => gatherer.visit(view, oracle, &mut sink),
                    }
                    row
                },
            )
            .collect();
        let leaves = mesh
            .faces
            .par_iter()
            .zip(trees)
            .zip(&nodes)
            .map(|((face, tree), nodes)| {
                tree.leaves()
                    .map(|c| Leaf {
                        cell: c as u32,
                        nodes: leaf_nodes(face, tree, nodes, c),
                    })
                    .collect()
            })
            .collect();
        Self {
            trees: trees.to_vec(),
            nodes,
            rows,
            leaves,
            first_cell,
        }
    }

    /// Number of nodes.
    pub(super) fn node_count(&self) -> usize {
        self.rows.len()
    }

    /// Solves for the indirect irradiance at the nodes, given in `light` what the cells send without it.
    ///
    /// Sweeps go face by face and end when the error that is left, extrapolated from the last two changes, is below
    /// `tolerance` (relative to the largest radiosity). `light` then holds what the cells send in the end; the cells may
    /// have got children since they were linked, which are left alone.
    pub(super) fn solve(
        &self,
        mesh: &SolveMesh,
        light: &mut [FaceLight],
        bounces: Bounces,
        tolerance: f64,
    ) -> (Vec<Irradiance>, SolveReport) {
        let direct: Vec<Vec<CellLight>> = light.iter().map(|l| l.cells.clone()).collect();
        let mut values = vec![Irradiance::ZERO; self.rows.len()];
        let mut report = SolveReport {
            nodes: self.rows.len(),
            elements: mesh.element_count(),
            cells: self.trees.iter().map(|t| t.cells.len()).sum(),
            links: self.rows.iter().map(Vec::len).sum(),
            residuals: Vec::new(),
        };
        let sweeps = match bounces {
            // The final gather adds one bounce to those in the light of the cells.
            Bounces::Count(n) => n.saturating_sub(1) as usize,
            Bounces::All => MAX_SWEEPS,
        };
        for _ in 0..sweeps {
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            if bounces != Bounces::All {
                // Gauss–Seidel reads what this sweep has already updated; counted bounces must not.
                values = self.gather_all(light);
            }
            for f in 0..self.nodes.len() {
                let reflectance = mesh.faces[f].reflectance;
                if bounces == Bounces::All {
                    for i in self.nodes[f].range.clone() {
                        let new = self.gather(i, light);
                        let step = reflectance * (new - values[i]).0;
                        change = change.max(step.0.abs().max_element());
                        values[i] = new;
                    }
                }
                self.reflect(f, reflectance, &direct[f], &values, light);
                largest = largest.max(light[f].largest);
            }
            let relative = if largest > 0.0 { change / largest } else { 0.0 };
            let previous = report.residuals.last().copied();
            if bounces == Bounces::All {
                report.residuals.push(relative);
                if is_settled(relative, previous, tolerance) {
                    break;
                }
            }
        }
        (self.gather_all(light), report)
    }

    /// The values at the nodes as a field over the faces of `mesh`.
    pub(super) fn field<'t>(&'t self, values: &'t [Irradiance]) -> NodalField<'t> {
        NodalField {
            nodes: &self.nodes,
            values,
        }
    }

    /// What the cells of face `f` send when `values` arrives at the nodes.
    fn reflect(
        &self,
        f: usize,
        reflectance: Rgb,
        direct: &[CellLight],
        values: &[Irradiance],
        light: &mut [FaceLight],
    ) {
        for leaf in &self.leaves[f] {
            let mut corners = direct[leaf.cell as usize].corners;
            for &(node, weights) in &leaf.nodes {
                let arriving = reflectance * values[node as usize].0;
                for (corner, w) in corners.iter_mut().zip(weights) {
                    *corner += Radiosity(arriving * w);
                }
            }
            light[f].cells[leaf.cell as usize] = CellLight::linear(corners);
        }
        light[f].pull(&self.trees[f]);
    }

    fn gather(&self, node: usize, light: &[FaceLight]) -> Irradiance {
        let mut sum = Rgb::BLACK;
        let mut f = 0;
        for &(cell, weights) in &self.rows[node] {
            while f + 1 < self.first_cell.len() && self.first_cell[f + 1] <= cell {
                f += 1;
            }
            let corners = &light[f].cells[(cell - self.first_cell[f]) as usize].corners;
            for (b, w) in corners.iter().zip(weights) {
                sum += b.0 * w;
            }
        }
        Irradiance(sum)
    }

    /// Indirect irradiance at all nodes from what the cells send.
    pub(super) fn gather_all(&self, light: &[FaceLight]) -> Vec<Irradiance> {
        (0..self.rows.len())
            .into_par_iter()
            .map(|i| self.gather(i, light))
            .collect()
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

/// Changes shrink geometrically by some q: what is left after the last is change · q / (1 − q).
fn is_settled(change: f64, previous: Option<f64>, tolerance: f64) -> bool {
    match previous {
        _ if change == 0.0 => true,
        Some(previous) if change < previous => {
            let q = change / previous;
            change * q / (1.0 - q) <= tolerance
        }
        _ => false,
    }
}
