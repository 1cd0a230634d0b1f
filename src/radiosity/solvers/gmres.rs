//! The generalised minimal residual (Saad & Schultz 1986), restarted: the combination of all bounces so far that leaves the
//! smallest residual.
//!
//! For ρ near 1 light dies so slowly that sweeps take thousands of steps; but it dies everywhere alike, and a few vectors
//! hold what that looks like. The three channels are three systems that share their products with `T`: every coefficient
//! below is three numbers. A channel that is done stops taking part (its vectors are zero).

use super::{Outcome, Problem, share};
use glam::DVec3;

/// Vectors that are kept: the memory of so many solutions.
const RESTART: usize = 40;

/// Steps at most. Beyond it the system has no solution: light that nothing absorbs.
const MAX_STEPS: usize = 1000;

/// Solves from where `outcome` has come to.
pub(super) fn solve(problem: &Problem, mut outcome: Outcome) -> Outcome {
    let goal = problem.goal();
    let mut steps = 0;
    while steps < MAX_STEPS {
        let (r, largest) = problem.residual(&outcome.x);
        let left = share(problem.reflected(&r), largest);
        if left <= goal || !left.is_finite() {
            outcome.is_settled = left.is_finite();
            break;
        }
        let done = cycle(problem, r, largest, goal, &mut outcome);
        steps += done;
    }
    outcome
}

/// One restart, until the residual is below `goal` (relative to the largest radiosity); returns its steps.
fn cycle(
    problem: &Problem,
    r: Vec<DVec3>,
    largest: f64,
    goal: f64,
    outcome: &mut Outcome,
) -> usize {
    let system = problem.system;
    let reflectance = system.largest_reflectance();
    let count = (system.len() as f64).sqrt();
    let mut small = Triangle::new(norm(&r));
    let mut vectors = vec![scaled(r, inverse(small.left[0]))];
    while small.columns.len() < RESTART {
        let j = small.columns.len();
        // (I − T) v, less what the vectors before hold of it (modified Gram–Schmidt).
        let mut w = system.apply(&vectors[j]);
        for (w, v) in w.iter_mut().zip(&vectors[j]) {
            *w = *v - *w;
        }
        let mut column = Vec::with_capacity(j + 2);
        for v in &vectors {
            let h = dot(v, &w);
            for (w, v) in w.iter_mut().zip(v) {
                *w -= *v * h;
            }
            column.push(h);
        }
        let length = norm(&w);
        column.push(length);
        small.add(column);
        // The change so far has the length of its coefficients; its largest value is at least their root mean square.
        let y = small.solved();
        let size = y.iter().map(|y| y.length_squared()).sum::<f64>().sqrt();
        let scale = largest.max(reflectance * size / count - largest);
        let left = small.left[j + 1].abs().max_element();
        let relative = share(reflectance * left, scale);
        outcome.residuals.push(relative);
        if relative <= goal || length == DVec3::ZERO {
            break;
        }
        vectors.push(scaled(w, small.going_on(length)));
    }
    let y = small.solved();
    for (v, y) in vectors.iter().zip(&y) {
        for (x, v) in outcome.x.iter_mut().zip(v) {
            *x += *v * *y;
        }
    }
    y.len()
}

/// The small least-squares problem, its matrix made triangular by Givens rotations as it grows.
struct Triangle {
    columns: Vec<Vec<DVec3>>,
    /// Cosines and sines.
    rotations: Vec<[DVec3; 2]>,
    /// The rotated right-hand side; its last entry is the residual.
    left: Vec<DVec3>,
}

/// A channel whose residual has come down by this factor in one cycle is at the end of what its vectors can tell: some
/// hundred roundings of the largest.
const EXHAUSTED: f64 = 1e-14;

impl Triangle {
    fn new(residual: DVec3) -> Self {
        Self {
            columns: Vec::new(),
            rotations: Vec::new(),
            left: vec![residual],
        }
    }

    fn add(&mut self, mut column: Vec<DVec3>) {
        let j = self.columns.len();
        for (i, &[c, s]) in self.rotations.iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            column[i] = c * a + s * b;
            column[i + 1] = c * b - s * a;
        }
        let (a, b) = (column[j], column[j + 1]);
        let length = (a * a + b * b).map(f64::sqrt);
        let (c, s) = (a * inverse(length), b * inverse(length));
        column[j] = length;
        column.truncate(j + 1);
        let g = self.left[j];
        self.left[j] = c * g;
        self.left.push(-s * g);
        self.rotations.push([c, s]);
        self.columns.push(column);
    }

    /// What the next vector is scaled with: nothing is left of channels that are done.
    fn going_on(&self, length: DVec3) -> DVec3 {
        let (first, last) = (self.start(), self.left[self.left.len() - 1].abs());
        let scale = inverse(length).to_array();
        let goes_on = [0, 1, 2].map(|k| last[k] > EXHAUSTED * first[k]);
        DVec3::from_array([0, 1, 2].map(|k| if goes_on[k] { scale[k] } else { 0.0 }))
    }

    /// The length of the residual at the start: rotations keep that of the right-hand side.
    fn start(&self) -> DVec3 {
        self.left
            .iter()
            .map(|g| *g * *g)
            .sum::<DVec3>()
            .map(f64::sqrt)
    }

    /// Coefficients of the vectors.
    fn solved(&self) -> Vec<DVec3> {
        let n = self.columns.len();
        let mut y = vec![DVec3::ZERO; n];
        for i in (0..n).rev() {
            let mut sum = self.left[i];
            for (column, y) in self.columns.iter().zip(&y).skip(i + 1) {
                sum -= column[i] * *y;
            }
            y[i] = sum * inverse(self.columns[i][i]);
        }
        y
    }
}

/// The inverse of each channel, nothing of nothing.
fn inverse(x: DVec3) -> DVec3 {
    x.map(|x| if x > 0.0 { 1.0 / x } else { 0.0 })
}

fn dot(a: &[DVec3], b: &[DVec3]) -> DVec3 {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}

fn norm(a: &[DVec3]) -> DVec3 {
    dot(a, a).map(f64::sqrt)
}

fn scaled(mut a: Vec<DVec3>, factor: DVec3) -> Vec<DVec3> {
    for a in &mut a {
        *a *= factor;
    }
    a
}
