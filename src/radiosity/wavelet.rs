//! Wavelets over halved triangles: a basis of the light of a tree in which what is small can be left out.
//!
//! What is linear on both halves of a cell is linear on the cell, three functions, or at right angles to all that is: three
//! wavelets (multiwavelets after Alpert 1993; Gortler, Schröder, Cohen & Hanrahan, *Wavelet radiosity*, 1993). The linear
//! functions on the roots and the wavelets of all cells that are halved tell the light of the leaves, no more and no less.
//!
//! ```text
//!         c              values at the corners of both halves:
//!        /|\
//!       / | \            at        a     m     c  |  m     b     c
//!      /  |  \           ψ₁ / √6   1    −1     0  | −1     1     0
//!     a───m───b          ψ₂ / √6   0     1    −1  | −1     0     1
//!                        ψ₃ / √3   1    −1    −1  |  1    −1     1
//! ```
//!
//! As the middle of an edge stays the middle under every affine map, these are the same for cells of all shapes: orthonormal
//! in the mean over the cell, with means and first moments of zero, and at right angles across all cells. So the
//! coefficients of a cell are the RMS over it of what they tell, and the squares of those that are left out sum to the
//! squared error, weighed by area.
//!
//! A node takes from a wavelet `∫ ψ G V`, which vanishes where the kernel is linear over the cell: from afar, in full view.
//! There its link is left out (see [`Wavelets::compressed`]).

use super::cells::{FaceCells, FaceLight};
use super::clusters::Sources;
use super::solvers::{Corners, Link};
use super::{SolveFace, SolveMesh};
use glam::DVec3;
use std::collections::BTreeMap;

/// Scales that make the mean square of each wavelet 1.
const SQRT_3: f64 = 1.732_050_807_568_877_2;
const SQRT_6: f64 = 2.449_489_742_783_178;

/// The linear function over a cell that is nearest to those over its halves, in the mean square.
///
/// Over `(a, m, c)` the basis function of `a` is that of `a` and half that of `m`; likewise on the other side. The mass matrix
/// of the linear basis is `(1 + δ)/12`, its inverse `12 δ − 3`.
pub(super) fn projected(left: Corners, right: Corners, order: [u8; 3]) -> Corners {
    let moments = |t: Corners| {
        let sum = t[0] + t[1] + t[2];
        t.map(|x| (x + sum) * (1.0 / 12.0))
    };
    let ([la, lm, lc], [rm, rb, rc]) = (moments(left), moments(right));
    let halved = [la + (lm + rm) * 0.5, rb + (lm + rm) * 0.5, lc + rc].map(|m| m * 0.5);
    let sum = halved[0] + halved[1] + halved[2];
    let mut corners = [DVec3::ZERO; 3];
    for (k, m) in order.into_iter().zip(halved) {
        corners[k as usize] = m * 12.0 - sum * 3.0;
    }
    corners
}

/// The coefficients of the wavelets: what the halves have that [`projected`] does not tell.
pub(super) fn details(left: Corners, right: Corners) -> Corners {
    let [rm, rb, rc] = right;
    // What is alike on both sides, and what is opposite.
    let mirrored = [rb, rm, rc];
    let even = [0, 1].map(|k| (left[k] + mirrored[k]) * 0.5);
    let odd = [0, 1, 2].map(|k| (left[k] - mirrored[k]) * 0.5);
    [
        (even[0] - even[1]) * (SQRT_6 / 12.0),
        (odd[1] - odd[2]) * (SQRT_6 / 12.0),
        (odd[1] + odd[2]) * (-SQRT_3 / 6.0),
    ]
}

/// The halves again, from the linear function and the coefficients of the wavelets.
pub(super) fn halves(whole: Corners, details: Corners, order: [u8; 3]) -> [Corners; 2] {
    let [a, b, c] = order.map(|k| whole[k as usize]);
    let m = (a + b) * 0.5;
    let [first, second, third] = [
        details[0] * SQRT_6,
        details[1] * SQRT_6,
        details[2] * SQRT_3,
    ];
    [
        [
            a + first + third,
            m - first + second - third,
            c - second - third,
        ],
        [
            m - first - second + third,
            b + first - third,
            c + second + third,
        ],
    ]
}

/// What a node takes from a cell and from its wavelets when it takes `left` and `right` from the corners of its halves.
fn raised(left: [f64; 3], right: [f64; 3], order: [usize; 3]) -> [[f64; 3]; 2] {
    let ([la, lm, lc], [rm, rb, rc]) = (left, right);
    let middle = 0.5 * (lm + rm);
    let mut whole = [0.0; 3];
    for (k, w) in order.into_iter().zip([la + middle, rb + middle, lc + rc]) {
        whole[k] = w;
    }
    let details = [
        SQRT_6 * ((la - lm) + (rb - rm)),
        SQRT_6 * ((lm - lc) - (rm - rc)),
        SQRT_3 * ((la - lm - lc) - (rb - rm - rc)),
    ];
    [whole, details]
}

/// What is left out of light told by wavelets.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Compression {
    /// Functions that tell the light of a channel: three on each root, and three wavelets on each cell that is halved.
    pub functions: usize,
    /// Of these, wavelets with which no node is linked.
    pub dropped_functions: usize,
    /// RMS over all faces of the light that these would tell, in parts of that of all light.
    pub dropped_light: f64,
    /// Links with the wavelets of a cell that were left out: not among the links that are counted.
    pub dropped_links: usize,
}

/// The wavelets of all trees, for rows of links to be compressed.
///
/// Those of a cell have the number of its first child, which tells nothing else in this basis; the roots keep theirs.
pub(super) struct Wavelets<'w> {
    trees: &'w [FaceCells],
    first_cell: &'w [usize],
    /// For each cell its parent; itself for a root.
    parents: Vec<u32>,
    /// What the wavelets of each number may tell at most (RMS over their cell), W/m².
    sizes: Vec<f64>,
    /// What all that a node does without may make up, W/m².
    permitted: f64,
}

impl<'w> Wavelets<'w> {
    /// For light as in `sources`, with up to what is said there on top of it.
    pub(super) fn new(
        mesh: &SolveMesh,
        trees: &'w [FaceCells],
        first_cell: &'w [usize],
        sources: &Sources,
        permitted: f64,
    ) -> Self {
        let (mut parents, mut sizes) = (Vec::new(), Vec::new());
        for (f, tree) in trees.iter().enumerate() {
            let first = first_cell[f];
            let on_top = on_top(&mesh.faces[f], sources);
            parents.extend((first..).take(tree.cells.len()).map(|c| c as u32));
            sizes.resize(first + tree.cells.len(), 0.0);
            for (c, child) in halved(tree) {
                parents[first + child] = (first + c) as u32;
                parents[first + child + 1] = (first + c) as u32;
                sizes[first + child] = size(&sources.faces[f], child) + on_top;
            }
        }
        Self {
            trees,
            first_cell,
            parents,
            sizes,
            permitted,
        }
    }

    /// Numbers given: as many as there are cells.
    pub(super) fn count(&self) -> usize {
        self.sizes.len()
    }

    /// The same row in this basis, and how many links with wavelets were left out of it: the smallest, as long as all that
    /// they may bring stays below what is permitted.
    pub(super) fn compressed(&self, row: impl Iterator<Item = Link>) -> (Vec<Link>, usize) {
        let mut open: BTreeMap<u32, [f64; 3]> = row.map(|l| (l.cell, l.weights)).collect();
        let (mut links, mut wavelets) = (Vec::new(), Vec::new());
        // Children come after their parents: the last one is done when it is its turn.
        while let Some((cell, weights)) = open.pop_last() {
            let parent = self.parents[cell as usize];
            if parent == cell {
                links.push(Link { cell, weights });
                continue;
            }
            let (order, first) = self.halving(parent);
            let [left, right] = if cell == first {
                [weights, [0.0; 3]]
            } else {
                [open.remove(&first).unwrap_or_default(), weights]
            };
            let [whole, details] = raised(left, right, order);
            let sum = open.entry(parent).or_default();
            (0..3).for_each(|k| sum[k] += whole[k]);
            wavelets.push(Link {
                cell: first,
                weights: details,
            });
        }
        let all = wavelets.len();
        let kept = self.worth(wavelets);
        let dropped = all - kept.len();
        links.extend(kept);
        links.sort_unstable_by_key(|l| l.cell);
        links.shrink_to_fit();
        (links, dropped)
    }

    /// Those of the links with wavelets that a node cannot do without.
    fn worth(&self, mut wavelets: Vec<Link>) -> Vec<Link> {
        // A scalar product is at most the product of the lengths.
        let brings = |l: &Link| {
            let square: f64 = l.weights.iter().map(|w| w * w).sum();
            square.sqrt() * self.sizes[l.cell as usize]
        };
        wavelets.sort_unstable_by(|a, b| {
            let order = brings(a).total_cmp(&brings(b));
            order.then(a.cell.cmp(&b.cell))
        });
        let mut sum = 0.0;
        let needed = wavelets.iter().position(|l| {
            sum += brings(l);
            sum > self.permitted
        });
        wavelets.split_off(needed.unwrap_or(wavelets.len()))
    }

    /// The corners of a cell in the order of its halves, and the number of its first child.
    fn halving(&self, cell: u32) -> ([usize; 3], u32) {
        let f = self.first_cell.partition_point(|&n| n <= cell as usize) - 1;
        let first = self.first_cell[f];
        let cell = &self.trees[f].cells[cell as usize - first];
        let child = cell.first_child().expect("a parent is halved");
        (cell.order(), (first + child) as u32)
    }
}

/// Counts what `is_linked` (by number) leaves out of light with these coefficients.
pub(super) fn left_out(
    trees: &[FaceCells],
    coefficients: &[Corners],
    is_linked: &[bool],
    dropped_links: usize,
) -> Compression {
    let mut found = Compression {
        dropped_links,
        ..Compression::default()
    };
    let (mut first, mut all, mut lost) = (0, 0.0, 0.0);
    for tree in trees {
        let roots = tree.roots as usize;
        found.functions += 3 * roots;
        for (cell, corners) in tree.cells[..roots].iter().zip(&coefficients[first..]) {
            all += cell.area * mean_square(corners);
        }
        for (c, child) in halved(tree) {
            let details = coefficients[first + child];
            let square: f64 = details.iter().map(|d| d.length_squared()).sum();
            found.functions += 3;
            all += tree.cells[c].area * square;
            if !is_linked[first + child] {
                found.dropped_functions += 3;
                lost += tree.cells[c].area * square;
            }
        }
        first += tree.cells.len();
    }
    if all > 0.0 {
        found.dropped_light = f64::sqrt(lost / all);
    }
    found
}

/// The cells that are halved, each with its first child.
fn halved(tree: &FaceCells) -> impl Iterator<Item = (usize, usize)> + '_ {
    let cells = tree.cells.iter().enumerate();
    cells.filter_map(|(c, cell)| Some((c, cell.first_child()?)))
}

/// RMS over a cell and the channels of what the wavelets tell which are numbered as its `child`, W/m².
fn size(light: &FaceLight, child: usize) -> f64 {
    let [left, right] = [0, 1].map(|k| light.cells[child + k].corners.map(|c| c.0.0));
    let squares = details(left, right).map(|d| d.length_squared() / 3.0);
    squares.iter().sum::<f64>().sqrt()
}

/// What may come on top of the light of `face`: RMS distance from a linear function, W/m².
fn on_top(face: &SolveFace, sources: &Sources) -> f64 {
    sources.ambient * face.reflectance.0.max_element()
}

/// Of a linear function, summed over the channels.
fn mean_square(corners: &Corners) -> f64 {
    let sum = corners[0] + corners[1] + corners[2];
    let squares: f64 = corners.iter().map(|c| c.length_squared()).sum();
    (sum.length_squared() + squares) / 12.0
}

#[cfg(test)]
mod tests;
