//! The source side of the transport: every lit side as a tree of triangles, each halved where its light asks for it.
//!
//! ```text
//!        c               the longest edge ab is halved at m:
//!       /|\              children (a, m, c) and (m, b, c);
//!      / | \             a cell knows its light as a linear function
//!     /  |  \            (the L² projection, so that power and first moments
//!    a───m───b           are kept) and how far the light departs from it
//! ```
//!
//! A receiver far away, or light that is nearly linear, takes a cell as it is; else it looks at the children
//! (Hanrahan, Salzman & Aupperle 91; linear bases as in Gortler, Schröder, Cohen & Hanrahan 93).

use super::greatest::Greatest;
use super::held::Held;
use super::locator::Locator;
use super::{Basis, SolveFace};
use crate::form_factor::RADON;
use crate::quantity::{Radiosity, Rgb};
use crate::scene::FaceSide;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::sync::Arc;

/// A cell without children.
const LEAF: u32 = u32::MAX;

/// Halvings of a root at most: each halves the area, so that a leaf is then 2⁻¹² of the side of its root.
const MAX_DEPTH: u32 = 24;

/// Cells follow the light until it departs from linear by less than this many times the permitted error: what departs is
/// weighed by the cell's form factor before anyone sees it.
const FOLLOW_SHARE: f64 = 4.0;

/// What departs may make up this share of the permitted error where it has been seen to weigh most.
const EXPOSED_SHARE: f64 = 0.5;

/// A triangle of a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Corners, counter-clockwise seen from the lit side, metres.
    pub(super) corners: [DVec3; 3],
    /// The same in frame coordinates, metres.
    pub(super) flat: [DVec2; 3],
    pub(super) centre: DVec3,
    pub(super) area: f64,
    /// Distance of the farthest corner from the centre, metres.
    pub(super) radius: f64,
    /// Square of the longest edge, m².
    pub(super) width_squared: f64,
    /// The first of two children, or [`LEAF`].
    child: u32,
    /// The edge that the children share the halves of: from this corner to the next.
    halved: u8,
    depth: u8,
}

/// The trees of one side of one face; parents come before their children. Copies share all of it until one of them grows.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceCells {
    pub(super) cells: Arc<Vec<Cell>>,
    /// The first so many cells are roots.
    pub(super) roots: u32,
    root_locator: Locator,
    /// The first so many are as wide as the spacing of the solve mesh asks for; the light has asked for the others.
    pub(super) coarse: usize,
    /// For each cell the greatest weight that what is not linear about its light had anywhere: form factor times square of
    /// its width over its distance.
    exposure: Arc<Vec<Greatest>>,
    /// What the cells know of their light.
    pub(super) basis: Basis,
}

/// The light that one cell sends out: linear between the corners.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellLight {
    /// Values at the corners.
    pub(super) corners: [Radiosity; 3],
    /// RMS distance of the light from the linear function, mean over the channels, W/m².
    pub(super) deviation: f64,
    /// Mean square of the light over the cell and the channels, W²/m⁴.
    square: f64,
}

/// The light of all cells of a face, and what of it is the same for all.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceLight {
    pub(super) cells: Vec<CellLight>,
    /// Mean over the face.
    pub(super) mean: Radiosity,
    /// The largest value at any corner of any cell, of any channel, W/m².
    pub(super) largest: f64,
}

impl Cell {
    fn new(flat: [DVec2; 3], face: &SolveFace, depth: u8) -> Self {
        let corners = flat.map(|p| face.domain.frame.to_space(p));
        let lengths = [0, 1, 2].map(|k| flat[k].distance_squared(flat[(k + 1) % 3]));
        let halved = (0..3)
            .max_by(|&i, &j| lengths[i].total_cmp(&lengths[j]))
            .expect("three edges");
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        Self {
            corners,
            flat,
            centre,
            radius: corners
                .map(|c| c.distance_squared(centre))
                .into_iter()
                .fold(0.0, f64::max)
                .sqrt(),
            area: 0.5 * (flat[1] - flat[0]).perp_dot(flat[2] - flat[0]).abs(),
            width_squared: lengths[halved],
            child: LEAF,
            halved: halved as u8,
            depth,
        }
    }

    /// The first of the two children; none of a leaf.
    pub(super) fn first_child(&self) -> Option<usize> {
        (self.child != LEAF).then_some(self.child as usize)
    }

    /// The corners of the two halves: `(a, m, c)` and `(m, b, c)`.
    fn halves(&self) -> [[DVec2; 3]; 2] {
        let [a, b, c] = self.order().map(|k| self.flat[k]);
        let m = a.midpoint(b);
        [[a, m, c], [m, b, c]]
    }

    /// Corners in the order of the children: the halved edge first.
    pub(super) fn order(&self) -> [usize; 3] {
        let k = self.halved as usize;
        [k, (k + 1) % 3, (k + 2) % 3]
    }

    /// The point with barycentric coordinates `w`, frame coordinates.
    pub(super) fn at(&self, w: [f64; 3]) -> DVec2 {
        self.flat[0] * w[0] + self.flat[1] * w[1] + self.flat[2] * w[2]
    }
}

impl FaceCells {
    /// The constrained Delaunay triangles of the face between its outline and contact lines, halved until none is wider
    /// than `width` (metres).
    pub(super) fn new(face: &SolveFace, width: f64, basis: Basis) -> Self {
        let order: [usize; 3] = if face.domain.side == FaceSide::Front {
            [0, 1, 2]
        } else {
            [0, 2, 1]
        };
        let cells: Vec<Cell> = (0..face.roots.len())
            .map(|e| Cell::new(order.map(|k| face.roots[e][k]), face, 0))
            .collect();
        let mut tree = Self {
            roots: cells.len() as u32,
            root_locator: Locator::of(cells.len(), |c| cells[c].flat),
            coarse: 0,
            basis,
            exposure: Arc::new(vec![Greatest::default(); cells.len()]),
            cells: Arc::new(cells),
        };
        let mut i = 0;
        while i < tree.cells.len() {
            if tree.cells[i].width_squared > width * width {
                tree.halve(face, i);
            }
            i += 1;
        }
        tree.coarse = tree.cells.len();
        tree
    }

    /// Gives a leaf its children, unless it is too deep for that.
    fn halve(&mut self, face: &SolveFace, i: usize) -> bool {
        let parent = self.cells[i];
        if u32::from(parent.depth) >= MAX_DEPTH {
            return false;
        }
        let cells = Arc::make_mut(&mut self.cells);
        let exposure = Arc::make_mut(&mut self.exposure);
        cells[i].child = cells.len() as u32;
        for flat in parent.halves() {
            cells.push(Cell::new(flat, face, parent.depth + 1));
            exposure.push(exposure[i].clone());
        }
        true
    }

    /// Takes note of the weight that what is not linear about leaf `i` has at some point.
    pub(super) fn expose(&self, i: usize, weight: f64) {
        self.exposure[i].note(weight);
    }

    /// Samples the light on all leaves and halves those where it departs from a linear function by more than `limits` allow.
    pub(super) fn follow(
        &mut self,
        face: &SolveFace,
        limits: FollowLimits,
        light: impl Fn(DVec2) -> Radiosity,
    ) -> FaceLight {
        let mut found = FaceLight::default();
        let mut i = 0;
        while i < self.cells.len() {
            let cell = self.cells[i];
            let mut value = CellLight::default();
            if cell.child == LEAF {
                value = CellLight::sampled(|w| light(cell.at(w))).told_by(self.basis);
                if value.deviation > limits.deviation(self.exposure[i].get())
                    && cell.width_squared > limits.smallest * limits.smallest
                    && self.halve(face, i)
                {
                    value = CellLight::default();
                }
            }
            found.cells.push(value);
            i += 1;
        }
        found.pull(self);
        found
    }

    /// The root that holds `p` (frame coordinates), or the one that comes nearest; none when the face has no area.
    pub(super) fn root_at(&self, p: DVec2) -> Option<usize> {
        let flat = |c: usize| self.cells[c].flat;
        let found = self.root_locator.find(self.roots as usize, flat, p);
        found.map(|(root, _)| root)
    }

    /// The child of cell `i` that lies on the side of `p` (frame coordinates); none of a leaf.
    pub(super) fn child_towards(&self, i: usize, p: DVec2) -> Option<usize> {
        let cell = &self.cells[i];
        let first = cell.first_child()?;
        let [a, b, c] = cell.order().map(|k| cell.flat[k]);
        let cut = a.midpoint(b) - c;
        let is_left = (cut.perp_dot(p - c) < 0.0) == (cut.perp_dot(a - c) < 0.0);
        Some(if is_left { first } else { first + 1 })
    }

    /// The triangles that the spacing of the solve mesh asks for, whatever the light has divided since.
    pub(super) fn elements(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.coarse).filter(|&i| {
            let child = self.cells[i].first_child();
            child.is_none_or(|c| c >= self.coarse)
        })
    }

    /// All leaves.
    pub(super) fn leaves(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.cells.len()).filter(|&i| self.cells[i].child == LEAF)
    }
}

impl CellLight {
    /// The projection of `light`, given by barycentric coordinates.
    pub(super) fn sampled(light: impl Fn([f64; 3]) -> Radiosity) -> Self {
        let mut moments = [Rgb::BLACK; 3];
        let mut square = 0.0;
        for (w, weight) in RADON {
            let b = light(w).0;
            for k in 0..3 {
                moments[k] += b * (w[k] * weight);
            }
            square += b.mean_square() * weight;
        }
        Self::from_moments(moments, square)
    }

    /// From the means of the light under each corner's basis function and of its square.
    pub(super) fn from_moments(moments: [Rgb; 3], square: f64) -> Self {
        // The mass matrix of the linear basis is (1 + δ)/12; its inverse 12 δ − 3.
        let sum = moments[0] + moments[1] + moments[2];
        let corners = moments.map(|m| Radiosity(m * 12.0 - sum * 3.0));
        let mut rest = square;
        for k in 0..3 {
            rest -= (corners[k].0 * moments[k]).mean();
        }
        Self {
            corners,
            deviation: rest.max(0.0).sqrt(),
            square,
        }
    }

    /// Means under each corner's basis function.
    fn moments(&self) -> [Rgb; 3] {
        let [a, b, c] = self.corners.map(|c| c.0);
        let sum = a + b + c;
        [a, b, c].map(|x| (x + sum) * (1.0 / 12.0))
    }

    /// Mean over the cell.
    pub(super) fn mean(&self) -> Radiosity {
        (self.corners[0] + self.corners[1] + self.corners[2]) * (1.0 / 3.0)
    }

    /// RMS over the cell and the channels, W/m².
    pub(super) fn rms(&self) -> f64 {
        self.square.max(0.0).sqrt()
    }

    /// Largest difference between corners, of any channel, W/m².
    pub(super) fn range(&self) -> f64 {
        let [a, b, c] = self.corners.map(|c| c.0.0);
        (a.max(b).max(c) - a.min(b).min(c)).max_element()
    }

    /// What `basis` can tell of it.
    fn told_by(self, basis: Basis) -> Self {
        match basis {
            Basis::Linear | Basis::Wavelet => self,
            Basis::Constant => {
                let mean = self.mean();
                let rest = self.square - mean.0.mean_square();
                Self {
                    corners: [mean; 3],
                    deviation: rest.max(0.0).sqrt(),
                    square: self.square,
                }
            }
        }
    }

    /// With other values at the corners, all of which the linear function tells.
    pub(super) fn linear(corners: [Radiosity; 3]) -> Self {
        let mut light = Self {
            corners,
            ..Self::default()
        };
        let moments = light.moments();
        for k in 0..3 {
            light.square += (corners[k].0 * moments[k]).mean();
        }
        light
    }
}

impl FaceLight {
    /// Projects the light of the children to their parents, from the leaves up (the two-scale relation of the linear basis).
    pub(super) fn pull(&mut self, tree: &FaceCells) {
        for i in (0..tree.cells.len()).rev() {
            let cell = &tree.cells[i];
            let Some(child) = cell.first_child() else {
                continue;
            };
            let [left, right] = [self.cells[child], self.cells[child + 1]];
            let ([la, lm, lc], [rm, rb, rc]) = (left.moments(), right.moments());
            // Over (a, m, c) the basis function of a is that of a and half that of m; likewise on the other side. The
            // halves have equal areas.
            let halved = [la + (lm + rm) * 0.5, rb + (lm + rm) * 0.5, lc + rc];
            let mut moments = [Rgb::BLACK; 3];
            for (k, m) in cell.order().into_iter().zip(halved) {
                moments[k] = m * 0.5;
            }
            let square = (left.square + right.square) * 0.5;
            self.cells[i] = CellLight::from_moments(moments, square).told_by(tree.basis);
        }
        self.summarise(tree);
    }

    /// No light on any cell of `tree`.
    pub(super) fn dark(tree: &FaceCells) -> Self {
        Self {
            cells: vec![CellLight::default(); tree.cells.len()],
            ..Self::default()
        }
    }

    /// Adds to every leaf that is not held the projection of `more(point)` (frame coordinates), and to the `change` of the light
    /// as well.
    pub(super) fn add(
        &mut self,
        change: &mut Self,
        tree: &FaceCells,
        held: &Held,
        more: impl Fn(DVec2) -> Radiosity,
    ) {
        let is_held = held.cells(tree);
        for i in tree.leaves().filter(|&i| !is_held[i]) {
            let added = CellLight::sampled(|w| more(tree.cells[i].at(w)));
            for now in [&mut self.cells[i], &mut change.cells[i]] {
                let both = [0, 1, 2].map(|k| now.corners[k] + added.corners[k]);
                *now = CellLight::linear(both).told_by(tree.basis);
            }
        }
        self.pull(tree);
        change.pull(tree);
    }

    /// What this light has over `old`, which may end at cells that have children in `tree`.
    pub(super) fn minus(&self, old: &Self, tree: &FaceCells) -> Self {
        let mut before: Vec<[Radiosity; 3]> = old.cells.iter().map(|c| c.corners).collect();
        before.resize(tree.cells.len(), [Radiosity::ZERO; 3]);
        let mut found = Self::default();
        for (i, cell) in tree.cells.iter().enumerate() {
            // Cells that are new take over what their parent's linear function says.
            if let Some(child) = cell.first_child()
                && child >= old.cells.len()
            {
                let [a, b, c] = cell.order().map(|k| before[i][k]);
                let m = (a + b) * 0.5;
                before[child] = [a, m, c];
                before[child + 1] = [m, b, c];
            }
            let [now, then] = [self.cells[i].corners, before[i]];
            found
                .cells
                .push(CellLight::linear([0, 1, 2].map(|k| now[k] - then[k])));
        }
        found.pull(tree);
        found
    }

    /// The square of the light of cell `c`, mean over the channels, integrated over the cell, W²/m².
    pub(super) fn square(&self, tree: &FaceCells, c: usize) -> f64 {
        tree.cells[c].area * self.cells[c].square
    }

    fn summarise(&mut self, tree: &FaceCells) {
        let (mut sum, mut area) = (Radiosity::ZERO, 0.0);
        for (cell, light) in tree.cells.iter().zip(&self.cells).take(tree.roots as usize) {
            sum += light.mean() * cell.area;
            area += cell.area;
        }
        self.mean = if area > 0.0 {
            sum * (1.0 / area)
        } else {
            Radiosity::ZERO
        };
        self.largest = tree
            .leaves()
            .flat_map(|i| self.cells[i].corners)
            .map(|b| b.0.0.abs().max_element())
            .fold(0.0, f64::max);
    }
}

/// How closely cells follow the light.
#[derive(Clone, Copy)]
pub(super) struct FollowLimits {
    /// Permitted error of a gather, W/m².
    pub(super) error: f64,
    /// Width below which no cell is halved, metres.
    pub(super) smallest: f64,
}

impl FollowLimits {
    /// Permitted departure from a linear function for a cell of the given exposure, W/m².
    fn deviation(self, exposure: f64) -> f64 {
        self.error * FOLLOW_SHARE.min(EXPOSED_SHARE / exposure)
    }
}

/// The trees of all sides, followed to the light that `light(face, point)` gives, W/m².
pub(super) fn follow_all(
    trees: &mut [FaceCells],
    faces: &[SolveFace],
    limits: FollowLimits,
    light: impl Fn(usize, DVec2) -> Radiosity + Sync,
) -> Vec<FaceLight> {
    trees
        .par_iter_mut()
        .zip(faces)
        .enumerate()
        .map(|(f, (tree, face))| tree.follow(face, limits, |p| light(f, p)))
        .collect()
}
