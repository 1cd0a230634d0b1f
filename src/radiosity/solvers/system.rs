//! The linear system `H = h + T H`: nodes that gather from cells, cells that send what the nodes receive.
//!
//! `T` is *reflect* (from the nodes of a face to its smallest cells), *pull* (from those to the larger ones, by the two-scale
//! relation of the basis) and *gather* (from cells of all sizes, or from wavelets, to the nodes of other faces). Nothing here
//! knows geometry.

use super::super::Basis;
use super::super::wavelet::{details, halves, projected};
use super::row::{Link, Row};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// The light at the three corners of a cell, W/m² in three channels.
pub(in crate::radiosity) type Corners = [DVec3; 3];

/// A cell without children.
#[derive(Clone, Debug)]
pub(in crate::radiosity) struct Leaf {
    /// Number within its block.
    pub(in crate::radiosity) cell: u32,
    /// Area, m².
    pub(in crate::radiosity) area: f64,
    /// Weights of the irradiance at the nodes for the light at the three corners, before reflection.
    pub(in crate::radiosity) nodes: Vec<(u32, [f64; 3])>,
}

/// A cell with two children, which follow each other.
#[derive(Clone, Copy, Debug)]
pub(in crate::radiosity) struct Parent {
    /// Numbers within its block.
    pub(in crate::radiosity) cell: u32,
    pub(in crate::radiosity) child: u32,
    /// Its corners a, b, c, of which the children are (a, m, c) and (m, b, c), m the middle of a and b.
    pub(in crate::radiosity) order: [u8; 3],
}

/// The nodes and cells of one side of one face. They do not see each other.
#[derive(Clone, Debug)]
pub(in crate::radiosity) struct Block {
    pub(in crate::radiosity) nodes: Range<usize>,
    pub(in crate::radiosity) cells: Range<usize>,
    /// Diffuse reflectance by channel.
    pub(in crate::radiosity) reflectance: DVec3,
    pub(in crate::radiosity) leaves: Vec<Leaf>,
    /// From the smallest to the largest.
    pub(in crate::radiosity) parents: Vec<Parent>,
}

/// Links of one node with cells of one block.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) node: u32,
    /// Among the links of the node.
    pub(super) links: Range<usize>,
}

/// Blocks and the links between them.
#[derive(Clone, Debug)]
pub(in crate::radiosity) struct System {
    basis: Basis,
    pub(super) blocks: Vec<Block>,
    /// The links of each node, shared by copies.
    rows: Arc<Vec<Row>>,
    cells: usize,
}

impl System {
    /// `rows` are the links of each node in the order of the nodes.
    pub(in crate::radiosity) fn new(basis: Basis, blocks: Vec<Block>, rows: Vec<Row>) -> Self {
        Self {
            basis,
            cells: blocks.last().map_or(0, |b| b.cells.end),
            blocks,
            rows: Arc::new(rows),
        }
    }

    /// From now on those leaves of block `b` for which `is_held` (by cell) send nothing of what its nodes receive.
    pub(in crate::radiosity) fn hold(&mut self, b: usize, is_held: &[bool]) {
        for leaf in &mut self.blocks[b].leaves {
            if is_held[leaf.cell as usize] {
                leaf.nodes.clear();
            }
        }
    }

    /// The blocks, in the order of their nodes and cells.
    pub(in crate::radiosity) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Number of nodes: unknowns a channel.
    pub(in crate::radiosity) fn len(&self) -> usize {
        self.rows.len()
    }

    /// The links of a node.
    pub(in crate::radiosity) fn links(&self, node: usize) -> impl Iterator<Item = Link> + '_ {
        self.rows[node].links()
    }

    /// Number of links.
    pub(in crate::radiosity) fn link_count(&self) -> usize {
        self.rows.iter().map(Row::len).sum()
    }

    /// Number of cells.
    pub(in crate::radiosity) fn cell_count(&self) -> usize {
        self.cells
    }

    /// The links by the block that they take light from: the transposed matrix.
    pub(super) fn runs(&self) -> Vec<Vec<Run>> {
        let mut runs: Vec<Vec<Run>> = vec![Vec::new(); self.blocks.len()];
        for (node, row) in self.rows.iter().enumerate() {
            let mut first = 0;
            while first < row.len() {
                let cell = row.link(first).cell as usize;
                let b = self.blocks.partition_point(|b| b.cells.end <= cell);
                let cells = &self.blocks[b].cells;
                let count = (first..row.len())
                    .take_while(|&i| cells.contains(&(row.link(i).cell as usize)))
                    .count();
                runs[b].push(Run {
                    node: node as u32,
                    links: first..first + count,
                });
                first += count;
            }
        }
        runs
    }

    /// The largest reflectance of any block and channel.
    pub(super) fn largest_reflectance(&self) -> f64 {
        let all = self.blocks.iter().map(|b| b.reflectance.max_element());
        all.fold(0.0, f64::max)
    }

    /// The same links between blocks that reflect everything.
    pub(super) fn white(&self) -> Self {
        let mut white = self.clone();
        for block in &mut white.blocks {
            block.reflectance = DVec3::ONE;
        }
        white
    }

    /// What comes by the links of `run` from the cells of its block that send `light`, the first of which has number `first`.
    pub(super) fn gather_from(&self, run: &Run, first: usize, light: &[Corners]) -> DVec3 {
        self.rows[run.node as usize].gather(run.links.clone(), first, light)
    }

    /// What arrives at a node from cells that send `light`.
    pub(super) fn gather(&self, node: usize, light: &[Corners]) -> DVec3 {
        let row = &self.rows[node];
        row.gather(0..row.len(), 0, light)
    }

    /// What arrives at every node.
    pub(in crate::radiosity) fn gather_all(&self, light: &[Corners]) -> Vec<DVec3> {
        (0..self.len())
            .into_par_iter()
            .map(|i| self.gather(i, light))
            .collect()
    }

    /// Writes to `light` (the cells of block `b` alone) what links take from them when `x` arrives at all nodes, on top of
    /// `direct`; returns the largest absolute value that they send.
    pub(super) fn send(
        &self,
        b: usize,
        x: &[DVec3],
        direct: Option<&[Corners]>,
        light: &mut [Corners],
    ) -> f64 {
        let largest = self.reflect(b, x, direct, light);
        self.pull(b, light);
        largest
    }

    /// The same for the smallest cells alone, and what these send themselves.
    pub(super) fn reflect(
        &self,
        b: usize,
        x: &[DVec3],
        direct: Option<&[Corners]>,
        light: &mut [Corners],
    ) -> f64 {
        let block = &self.blocks[b];
        let mut largest = 0.0_f64;
        for leaf in &block.leaves {
            let cell = leaf.cell as usize;
            let mut corners = direct.map_or([DVec3::ZERO; 3], |d| d[block.cells.start + cell]);
            for &(node, weights) in &leaf.nodes {
                let arriving = block.reflectance * x[node as usize];
                for (corner, w) in corners.iter_mut().zip(weights) {
                    *corner += arriving * w;
                }
            }
            for corner in corners {
                largest = largest.max(corner.abs().max_element());
            }
            light[cell] = corners;
        }
        largest
    }

    /// Gives the larger cells of block `b` what its smallest ones send; wavelets take the place of the smaller ones.
    fn pull(&self, b: usize, light: &mut [Corners]) {
        for parent in &self.blocks[b].parents {
            let child = parent.child as usize;
            let [left, right] = [light[child], light[child + 1]];
            light[parent.cell as usize] = match self.basis {
                Basis::Linear | Basis::Wavelet => projected(left, right, parent.order),
                // The halves have equal areas.
                Basis::Constant => [(left[0] + right[0]) * 0.5; 3],
            };
            if self.basis == Basis::Wavelet {
                light[child] = details(left, right);
                light[child + 1] = [DVec3::ZERO; 3];
            }
        }
    }

    /// What links take light from when all cells send `light`: the same, but for the basis of wavelets.
    pub(in crate::radiosity) fn told(&self, light: &[Corners]) -> Vec<Corners> {
        let mut told = light.to_vec();
        if self.basis == Basis::Wavelet {
            for (b, block) in self.blocks.iter().enumerate() {
                self.pull(b, &mut told[block.cells.clone()]);
            }
        }
        told
    }

    /// What cells send, from what links take light from.
    pub(in crate::radiosity) fn sent(&self, mut told: Vec<Corners>) -> Vec<Corners> {
        if self.basis == Basis::Wavelet {
            for block in &self.blocks {
                let light = &mut told[block.cells.clone()];
                for parent in block.parents.iter().rev() {
                    let (whole, child) = (light[parent.cell as usize], parent.child as usize);
                    let [left, right] = halves(whole, light[child], parent.order);
                    (light[child], light[child + 1]) = (left, right);
                }
            }
        }
        told
    }

    /// What links take from all cells when `x` arrives at the nodes, on top of `direct`; and the largest absolute value that
    /// cells send.
    pub(in crate::radiosity) fn light_of(
        &self,
        x: &[DVec3],
        direct: Option<&[Corners]>,
    ) -> (Vec<Corners>, f64) {
        let parts: Vec<(Vec<Corners>, f64)> = (0..self.blocks.len())
            .into_par_iter()
            .map(|b| {
                let mut light = vec![[DVec3::ZERO; 3]; self.blocks[b].cells.len()];
                let largest = self.send(b, x, direct, &mut light);
                (light, largest)
            })
            .collect();
        let largest = parts.iter().map(|p| p.1).fold(0.0, f64::max);
        let light: Vec<Vec<Corners>> = parts.into_iter().map(|p| p.0).collect();
        (light.concat(), largest)
    }

    /// `T x`.
    pub(super) fn apply(&self, x: &[DVec3]) -> Vec<DVec3> {
        self.gather_all(&self.light_of(x, None).0)
    }

    /// A bound of the share of the light that comes back (0…1): the largest row sum of `T`, by which its powers shrink at
    /// least in the maximum norm, as all its entries are form factors times reflectances.
    pub(super) fn contraction(&self) -> f64 {
        let back = self.apply(&vec![DVec3::ONE; self.len()]);
        let most = back.iter().map(|x| x.max_element()).fold(0.0, f64::max);
        most.min(LARGEST_CONTRACTION)
    }
}

/// Row sums are right to 10⁻⁷ (round-off of cutting): what they say of light that is lost more slowly than ten times that
/// is noise.
pub(super) const LARGEST_CONTRACTION: f64 = 1.0 - 1e-6;
