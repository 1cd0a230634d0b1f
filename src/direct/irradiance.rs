//! Lambert's formula: the form factor of a polygon at a point.

use glam::DVec3;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI, TAU};

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
        angle(sine, a.dot(b)) / sine * n.dot(cross)
    } else {
        0.0
    }
}

/// Of an angle up to an eighth of a turn the nearest of these, each π/16 from the next, is taken off: their cosines and sines.
const NEAR: [[f64; 2]; 5] = [
    [1.0, 0.0],
    [0.980_785_280_403_230_4, 0.195_090_322_016_128_27],
    [0.923_879_532_511_286_7, 0.382_683_432_365_089_8],
    [0.831_469_612_302_545_2, 0.555_570_233_019_602_2],
    [FRAC_1_SQRT_2, FRAC_1_SQRT_2],
];

/// Tangents halfway between them: of π/32, 3π/32, 5π/32 and 7π/32.
const HALFWAY: [f64; 4] = [
    0.098_491_403_357_164_25,
    0.303_346_683_607_342_4,
    0.534_511_135_950_791_6,
    0.820_678_790_828_660_3,
];

/// The angle in the plane with this sine and cosine times any length, 0…π; the sine is positive.
///
/// What is left after the nearest angle is taken off is below π/32, and nine terms of the series of its arc tangent leave
/// less than 10⁻¹⁹ of it: as exact as the library's `atan2` to four roundings, in less time.
fn angle(sine: f64, cosine: f64) -> f64 {
    let across = cosine.abs();
    let (less, more) = (sine.min(across), sine.max(across));
    let near = HALFWAY
        .iter()
        .map(|t| usize::from(less > more * t))
        .sum::<usize>();
    let [c, s] = NEAR[near];
    let t = (less * c - more * s) / (more * c + less * s);
    let q = t * t;
    let (q2, q4) = (q * q, q * q * q * q);
    let low = (1.0 - q * (1.0 / 3.0)) + q2 * (1.0 / 5.0 - q * (1.0 / 7.0));
    let high =
        (1.0 / 9.0 - q * (1.0 / 11.0)) + q2 * (1.0 / 13.0 - q * (1.0 / 15.0) + q2 * (1.0 / 17.0));
    let eighth = near as f64 * (PI / 16.0) + t * (low + q4 * high);
    let quarter = match sine > across {
        true => FRAC_PI_2 - eighth,
        false => eighth,
    };
    match cosine < 0.0 {
        true => PI - quarter,
        false => quarter,
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
    fn angles_are_those_of_the_library() {
        let steps = 100_000;
        for i in 1..steps {
            let x = PI * f64::from(i) / f64::from(steps);
            let (sine, cosine) = (3.0 * x.sin(), 3.0 * x.cos());
            let expected = sine.atan2(cosine);
            let off = (angle(sine, cosine) - expected).abs();
            assert!(off <= 4.0 * f64::EPSILON * expected, "{x}: {off}");
        }
        assert_eq!(angle(1e-300, 2.0), 5e-301);
        assert_eq!(angle(1e-300, -2.0), PI);
        assert_eq!(angle(2.0, 0.0), FRAC_PI_2);
        assert!((angle(1e-300, 1e-300) - PI / 4.0).abs() <= f64::EPSILON);
    }

    #[test]
    fn point_below_a_corner_and_the_centre_of_a_square() {
        let f = |x, y| form_factor(DVec3::ZERO, DVec3::Z, &unit_square_above(x, y, 1.0));
        assert!((f(0.0, 0.0) - 0.138_531_606_0).abs() < 5e-11);
        assert!((f(-0.5, -0.5) - 0.239_456_470_5).abs() < 5e-11);
    }
}
