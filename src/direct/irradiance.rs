//! Lambert's formula: the form factor of a polygon at a point.

use glam::DVec3;
use std::f64::consts::TAU;

/// The share of the power leaving a small patch at the origin with unit normal `n` that reaches a polygon (0…1);
/// equally, its irradiance from that polygon in units of the polygon's exitance.
///
/// Exact for a polygon wholly above the horizon (Lambert 1760): `F = 1/2π · Σ θᵢ n·Γᵢ`, with `θᵢ` the angle that edge `i`
/// subtends and `Γᵢ` the unit normal of the plane through the origin and that edge. The corners turn counter-clockwise
/// seen from the origin; loops may be simply concatenated edge by edge. Occlusion is the caller's business.
pub fn form_factor_of_directions(n: DVec3, corners: &[DVec3]) -> f64 {
    let Some(&last) = corners.last() else {
        return 0.0;
    };
    let (mut sum, mut a) = (0.0, last);
    for &b in corners {
        sum += edge_term(n, a, b);
        a = b;
    }
    sum / TAU
}

/// The term `θ n·Γ` of the edge from direction `a` to direction `b`; the opposite edge has its negative, to the last bit.
pub fn edge_term(n: DVec3, a: DVec3, b: DVec3) -> f64 {
    let cross = b.cross(a);
    let sine = cross.length();
    // A corner at the viewpoint, or an edge towards it, subtends nothing.
    if sine > 0.0 {
        sine.atan2(a.dot(b)) / sine * n.dot(cross)
    } else {
        0.0
    }
}

/// [`form_factor_of_directions`] for corners in space, seen from `p`.
pub fn form_factor(p: DVec3, n: DVec3, corners: &[DVec3]) -> f64 {
    let directions: smallvec::SmallVec<[DVec3; 8]> = corners.iter().map(|&c| c - p).collect();
    form_factor_of_directions(n, &directions)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_square_above(x: f64, y: f64, h: f64) -> [DVec3; 4] {
        // Counter-clockwise seen from below.
        [
            DVec3::new(x, y, h),
            DVec3::new(x, y + 1.0, h),
            DVec3::new(x + 1.0, y + 1.0, h),
            DVec3::new(x + 1.0, y, h),
        ]
    }

    #[test]
    fn point_below_a_corner_and_the_centre_of_a_square() {
        let f = |x, y| form_factor(DVec3::ZERO, DVec3::Z, &unit_square_above(x, y, 1.0));
        assert!((f(0.0, 0.0) - 0.138_531_606_0).abs() < 5e-11);
        assert!((f(-0.5, -0.5) - 0.239_456_470_5).abs() < 5e-11);
    }
}
