//! The form factor of a visible piece of a cell, split by the linear basis of the cell.

use crate::direct::form_factor_of_directions;
use crate::form_factor::RADON;
use glam::DVec3;

/// A triangle wider than this many times its distance is divided before the quadrature reads the kernel over it: for
/// narrower ones the ratios of Radon's rule are right to a per cent.
const WIDE: f64 = 1.5;

/// Divisions at most: each halves the width, so that the last ones matter for 4⁻⁶ of the cell.
const MAX_DIVISIONS: u32 = 6;

/// A corner of a piece: its direction from the viewpoint (metres) and the basis functions of the cell there.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) direction: DVec3,
    pub(super) basis: [f64; 3],
}

impl Corner {
    fn middle(self, other: Self) -> Self {
        Self {
            direction: 0.5 * (self.direction + other.direction),
            basis: [0, 1, 2].map(|k| 0.5 * (self.basis[k] + other.basis[k])),
        }
    }
}

/// The corners of a cell, at which one basis function each is 1.
pub(super) fn cell_corners(directions: [DVec3; 3]) -> [Corner; 3] {
    [0, 1, 2].map(|k| {
        let mut basis = [0.0; 3];
        basis[k] = 1.0;
        Corner {
            direction: directions[k],
            basis,
        }
    })
}

/// Adds `∫ λₖ G dA` over the triangle `t`, seen from a surface with unit normal `n` and wholly above its horizon, to `sum`.
///
/// The form factor is Lambert's; only its division among the basis functions is a quadrature, `F · Σ w G λ / Σ w G`, so that
/// the three parts always sum to `F`.
pub(super) fn split(n: DVec3, t: [Corner; 3], depth: u32, sum: &mut [f64; 3]) {
    let d = t.map(|c| c.direction);
    let middle = (d[0] + d[1] + d[2]) / 3.0;
    let width = d[0]
        .distance_squared(d[1])
        .max(d[1].distance_squared(d[2]))
        .max(d[2].distance_squared(d[0]));
    if depth < MAX_DIVISIONS && width > WIDE * WIDE * middle.length_squared() {
        let m = [t[0].middle(t[1]), t[1].middle(t[2]), t[2].middle(t[0])];
        for part in [
            [t[0], m[0], m[2]],
            [m[0], t[1], m[1]],
            [m[2], m[1], t[2]],
            m,
        ] {
            split(n, part, depth + 1, sum);
        }
        return;
    }
    let f = form_factor_of_directions(n, &d);
    let (mut total, mut parts) = (0.0, [0.0; 3]);
    for (w, weight) in RADON {
        let y = d[0] * w[0] + d[1] * w[1] + d[2] * w[2];
        let squared = y.length_squared();
        // The cosine at the source and the distance: its plane's height is the same for all points.
        let g = weight * n.dot(y).max(0.0) / (squared * squared);
        total += g;
        for k in 0..3 {
            parts[k] += g * w[k];
        }
    }
    if total <= 0.0 || !total.is_finite() {
        (total, parts) = (1.0, [1.0 / 3.0; 3]);
    }
    for (corner, part) in t.iter().zip(parts) {
        for (s, b) in sum.iter_mut().zip(corner.basis) {
            *s += f * part / total * b;
        }
    }
}

/// The basis functions of the triangle with corners `t` at points of its plane (directions from one viewpoint).
pub(super) struct Basis {
    corner: DVec3,
    /// Gradients of the second and third function.
    gradients: [DVec3; 2],
}

impl Basis {
    pub(super) fn new(t: [DVec3; 3]) -> Self {
        let (u, v) = (t[1] - t[0], t[2] - t[0]);
        let n = u.cross(v);
        let scale = 1.0 / n.length_squared();
        Self {
            corner: t[0],
            gradients: [v.cross(n) * scale, n.cross(u) * scale],
        }
    }

    pub(super) fn at(&self, direction: DVec3) -> [f64; 3] {
        let [b, c] = self.gradients.map(|g| g.dot(direction - self.corner));
        [1.0 - b - c, b, c]
    }
}
