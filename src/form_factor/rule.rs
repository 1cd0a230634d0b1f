//! Gauss's rule with a proven error for functions that are analytic around the interval.

/// Nodes of the rule.
const NODES: usize = 10;

/// The Gauss–Legendre rule with ten nodes on [−1, 1]: positive abscissae and their weights (Abramowitz & Stegun 1964, 25.4.30).
const GAUSS: [(f64, f64); NODES / 2] = [
    (0.148_874_338_981_631_21, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// The share of the way to the nearest singularity within which the integrand is bounded: nearer to it, it grows.
const DISC: f64 = 0.9;

/// `ln 1/(1 − DISC)`: the logarithm of a distance changes by at most this within the disc.
const LOGARITHM: f64 = std::f64::consts::LN_10;

/// Nodes on `[centre − half, centre + half]` and their weights.
pub(super) fn nodes(centre: f64, half: f64) -> impl Iterator<Item = (f64, f64)> {
    GAUSS
        .into_iter()
        .flat_map(move |(x, w)| [-x, x].map(|x| (centre + half * x, half * w)))
}

/// Bound of the rule's error on an interval of half-length `half`, per unit of length of the other line, for the logarithm
/// of the distance to points at least `distance` from the middle of the interval; infinite when they are too near.
///
/// As a function of the position `s` along the interval, taken complex, that logarithm is singular where `s` is as far from
/// the middle as the point is in space. In the disc of 0.9 times that radius it differs from its value in the middle by at
/// most `ln 10`, and for a function so bounded within the ellipse around the interval whose semi-axes sum to `e` half-lengths
/// the rule with `n` nodes is off by at most `64/15 · half · ln 10 · e^(−2n) / (1 − e⁻²)` (Trefethen, *Is Gauss quadrature
/// better than Clenshaw–Curtis?*, 2008, theorem 4.5).
pub(super) fn bound(half: f64, distance: f64) -> f64 {
    let axis = DISC * distance / half;
    if axis <= 1.0 {
        return f64::INFINITY;
    }
    let e = axis + (axis * axis - 1.0).sqrt();
    64.0 / 15.0 * half * LOGARITHM * e.powi(-2 * NODES as i32) / (1.0 - e.powi(-2))
}

/// Bound of `∫ |ln(r/r')| dt` over a straight line of length `length` when no point moves by more than `shift`.
///
/// Where `r > 2 shift` the logarithm is at most `2 ln 2 · shift/r`, and `1/r` integrates to at most `2 + 2 ln(length/2 shift)`.
/// The rest of the line is at most `4 shift` long; both distances are below `3 shift` there, and each of `ln(3 shift/r)` and
/// `ln(3 shift/r')` integrates to at most `4 (1 + ln 3/2) shift`.
pub(super) fn modulus(shift: f64, length: f64) -> f64 {
    use std::f64::consts::LN_2;
    if shift <= 0.0 {
        return 0.0;
    }
    let near = 8.0 * (1.0 + 1.5_f64.ln());
    let far = 4.0 * LN_2 * (1.0 + (length / (2.0 * shift)).ln().max(0.0));
    shift * (near + far)
}

/// Radon's rule of degree 5 for triangles (Radon 1948): barycentric coordinates and weights. Nodes at (6 ∓ √15)/21 from the
/// sides, weights (155 ∓ √15)/1200.
pub(crate) const RADON: [([f64; 3], f64); 7] = {
    const NEAR: f64 = 0.101_286_507_323_456_34;
    const FAR: f64 = 0.470_142_064_105_115_1;
    const NEAR_WEIGHT: f64 = 0.125_939_180_544_827_15;
    const FAR_WEIGHT: f64 = 0.132_394_152_788_506_2;
    [
        ([1.0 / 3.0; 3], 9.0 / 40.0),
        ([1.0 - 2.0 * NEAR, NEAR, NEAR], NEAR_WEIGHT),
        ([NEAR, 1.0 - 2.0 * NEAR, NEAR], NEAR_WEIGHT),
        ([NEAR, NEAR, 1.0 - 2.0 * NEAR], NEAR_WEIGHT),
        ([1.0 - 2.0 * FAR, FAR, FAR], FAR_WEIGHT),
        ([FAR, 1.0 - 2.0 * FAR, FAR], FAR_WEIGHT),
        ([FAR, FAR, 1.0 - 2.0 * FAR], FAR_WEIGHT),
    ]
};
