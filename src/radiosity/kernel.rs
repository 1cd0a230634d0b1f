//! The form factor of a visible piece of a cell, split by the linear basis of the cell.

use crate::direct::form_factor_of_directions;
use crate::form_factor::RADON;
use glam::DVec3;
use std::f64::consts::TAU;

/// A triangle wider than this many times its distance is divided before the quadrature reads the kernel over it: for
/// narrower ones the ratios of Radon's rule are right to a per cent.
const WIDE: f64 = 1.5;

/// Divisions at most: each halves the width, so that the last ones matter for 4⁻⁶ of the cell.
const MAX_DIVISIONS: u32 = 6;

/// Radon's rule, of degree five, is off by up to so many times the bound of the form factor times the sixth power of the width
/// over the distance, as long as this is below one.
const FAR_ERROR: f64 = 0.02;

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

/// Adds `∫ λₖ G dA` over the triangle `t`, seen from a surface with unit normal `n` and wholly above its horizon, to `sum`;
/// `is_far` as [`is_far`] tells of it or of what it is a part of.
pub(super) fn add_triangle(n: DVec3, t: [Corner; 3], is_far: bool, sum: &mut [f64; 3]) {
    match is_far {
        true => split_far(n, t, sum),
        false => split(n, t, 0, sum),
    }
}

/// The form factor is Lambert's; only its division among the basis functions is a quadrature, `F · Σ w G λ / Σ w G`, so that
/// the three parts always sum to `F`.
fn split(n: DVec3, t: [Corner; 3], depth: u32, sum: &mut [f64; 3]) {
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
    let mut parts = kernel_moments(n, d);
    let mut total: f64 = parts.iter().sum();
    if total <= 0.0 || !total.is_finite() {
        (total, parts) = (1.0, [1.0 / 3.0; 3]);
    }
    add(t, parts.map(|part| f * part / total), sum);
}

/// Radon's rule alone, without a form factor in closed form.
fn split_far(n: DVec3, t: [Corner; 3], sum: &mut [f64; 3]) {
    let [a, b, c] = t.map(|c| c.direction);
    // Six times the volume between the triangle and the viewpoint is twice the area times the height of the viewpoint above
    // its plane, which is the cosine at the source times the distance everywhere.
    let scale = a.dot(b.cross(c)).abs() / TAU;
    let parts = kernel_moments(n, [a, b, c]);
    add(t, parts.map(|part| scale * part), sum);
}

/// Whether Radon's rule alone tells what a cell sends, or any part of it: light of `rms` W/m² with a form factor of at most
/// `form_factor`, right to `permitted` W/m², where `spread` is the square of its width over its distance.
pub(super) fn is_far(spread: f64, form_factor: f64, rms: f64, permitted: f64) -> bool {
    spread < 1.0 && FAR_ERROR * spread.powi(3) * form_factor * rms <= permitted
}

/// `∫ λₖ cos θ / r⁴ dA` over a triangle of directions, divided by its area, by Radon's rule: the cosine at the source and the
/// distance that are missing are the height of the viewpoint above its plane, the same for all points.
fn kernel_moments(n: DVec3, d: [DVec3; 3]) -> [f64; 3] {
    let mut parts = [0.0; 3];
    for (w, weight) in RADON {
        let y = d[0] * w[0] + d[1] * w[1] + d[2] * w[2];
        let squared = y.length_squared();
        let g = weight * n.dot(y).max(0.0) / (squared * squared);
        for k in 0..3 {
            parts[k] += g * w[k];
        }
    }
    parts
}

/// Adds what falls on the basis functions of the corners of `t` to those of the cell.
fn add(t: [Corner; 3], parts: [f64; 3], sum: &mut [f64; 3]) {
    for (corner, part) in t.iter().zip(parts) {
        for (s, b) in sum.iter_mut().zip(corner.basis) {
            *s += part * b;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::even_point;

    #[test]
    fn far_triangles_are_told_by_radons_rule_as_well_as_it_says() {
        let n = DVec3::Z;
        let mut count = 0;
        for i in 0..20_000 {
            // Corners around a middle one away from the viewpoint, as spread out as chance will have it.
            let [p, q, r, s] = [0, 1, 2, 3].map(|k| even_point(4 * i + k));
            let middle = DVec3::new(p.x - 0.5, p.y - 0.5, q.x).normalize_or(n);
            let size = 0.05 * 20.0_f64.powf(q.y);
            let away = |x: f64, y: f64, z: f64| middle + size * (DVec3::new(x, y, z) - 0.5);
            let mut t = [
                away(r.x, r.y, s.x),
                away(s.y, p.x, r.x),
                away(p.y, s.x, q.x),
            ];
            if t.iter().any(|d| n.dot(*d) < 0.0) {
                continue;
            }
            if form_factor_of_directions(n, &t) < 0.0 {
                t.swap(1, 2);
            }
            let centre = (t[0] + t[1] + t[2]) / 3.0;
            let radius = t
                .map(|d| d.distance(centre))
                .into_iter()
                .fold(0.0, f64::max);
            let width = (0..3)
                .map(|k| t[k].distance(t[(k + 1) % 3]))
                .fold(0.0, f64::max);
            let normal = (t[1] - t[0]).cross(t[2] - t[0]);
            let across = normal.normalize_or_zero().dot(t[0]).abs();
            // As a walk looks at cells.
            let nearest = (centre.length() - radius).max(across);
            let spread = (width / nearest).powi(2);
            if nearest <= 0.0 || spread >= 1.0 {
                continue;
            }
            let highest = t.iter().map(|d| n.dot(*d)).fold(0.0, f64::max);
            let cosines = (highest / nearest).min(1.0) * (across / nearest);
            let bound =
                0.5 * normal.length() * cosines / (std::f64::consts::PI * nearest * nearest);
            let (mut known, mut found) = ([0.0; 3], [0.0; 3]);
            split(n, cell_corners(t), 0, &mut known);
            split_far(n, cell_corners(t), &mut found);
            let off = (known.iter().sum::<f64>() - found.iter().sum::<f64>()).abs();
            // Below the round-off of three angles the closed form says nothing.
            let roundoff = 16.0 * f64::EPSILON;
            assert!(
                off <= FAR_ERROR * spread.powi(3) * bound + roundoff,
                "{off} of {bound} at a spread of {spread}"
            );
            count += 1;
        }
        assert!(count > 5000, "{count}");
    }
}
