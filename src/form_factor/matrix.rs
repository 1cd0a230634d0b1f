//! The form factors between all sides of a scene.

use super::{FormFactor, Patch, past};
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::Blockers;
use rayon::prelude::*;

/// What every side of a scene exchanges with every other: `k²` numbers for `k` sides.
#[derive(Clone, Debug)]
pub struct FormFactors {
    /// The sides: all fronts, and the backs that reflect.
    pub sides: Vec<(FaceId, FaceSide)>,
    /// Their areas, m².
    pub areas: Vec<f64>,
    /// `A_i F_ij` and its error, m²; row by row, and symmetric.
    exchanges: Vec<[f64; 2]>,
    /// Whether all errors are proven.
    is_proven: bool,
}

impl FormFactors {
    /// Of all sides of `scene`, each pair as by [`past`] with the given tolerance.
    pub fn new(scene: &Scene, blockers: &Blockers, tolerance: f64) -> Self {
        let sides: Vec<(FaceId, FaceSide)> = scene
            .faces
            .ids()
            .flat_map(|f| [FaceSide::Front, FaceSide::Back].map(|side| (f, side)))
            .filter(|&(f, side)| scene.receives(f, side))
            .collect();
        let patches: Vec<Vec<Patch>> = sides
            .iter()
            .map(|&(f, side)| Patch::of_side(scene, f, side))
            .collect();
        let n = sides.len();
        let pairs: Vec<(usize, usize)> = (0..n)
            .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
            .collect();
        let found: Vec<([f64; 2], bool)> = pairs
            .par_iter()
            .map(|&(i, j)| exchange(&patches[i], &patches[j], blockers, tolerance))
            .collect();
        let mut all = Self {
            areas: sides.iter().map(|&(f, _)| scene.faces[f].area).collect(),
            exchanges: vec![[0.0; 2]; n * n],
            is_proven: found.iter().all(|f| f.1),
            sides,
        };
        for ((i, j), (exchange, _)) in pairs.into_iter().zip(found) {
            all.exchanges[i * n + j] = exchange;
            all.exchanges[j * n + i] = exchange;
        }
        all
    }

    /// The share of the light leaving side `i` that arrives at side `j`.
    pub fn get(&self, i: usize, j: usize) -> FormFactor {
        let [area, error] = self.exchanges[i * self.sides.len() + j];
        FormFactor {
            value: area / self.areas[i],
            error: error / self.areas[i],
            is_proven: self.is_proven,
        }
    }

    /// The share of the light leaving side `i` that arrives anywhere: 1 in a closed scene, less where light escapes.
    pub fn row_sum(&self, i: usize) -> FormFactor {
        let n = self.sides.len();
        let row = &self.exchanges[i * n..(i + 1) * n];
        FormFactor {
            value: row.iter().map(|e| e[0]).sum::<f64>() / self.areas[i],
            error: row.iter().map(|e| e[1]).sum::<f64>() / self.areas[i],
            is_proven: self.is_proven,
        }
    }
}

/// Sum over the pieces of two sides: m², its error, and whether that is proven.
fn exchange(from: &[Patch], to: &[Patch], blockers: &Blockers, tolerance: f64) -> ([f64; 2], bool) {
    let (mut sum, mut is_proven) = ([0.0; 2], true);
    for a in from {
        for b in to {
            let found = past(a, b, blockers, tolerance);
            sum[0] += found.area;
            sum[1] += found.error;
            is_proven &= found.is_proven;
        }
    }
    (sum, is_proven)
}
