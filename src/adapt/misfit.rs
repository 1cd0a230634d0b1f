//! How far linear interpolation over one element is off.

use crate::quantity::Irradiance;
use std::ops::Add;

/// Light minus its linear interpolation over one element, as far as the samples tell: with barycentric coordinates λ,
/// `4 Σ mₖ λₖ λₖ₊₁ + 27 b λ₀ λ₁ λ₂`, which is exact for quadratics.
///
/// All means below follow from `∫ λ₀ᵃ λ₁ᵇ λ₂ᶜ = 2A a! b! c! / (a + b + c + 2)!`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Misfit {
    /// m: at the middle of each edge, W/m².
    pub(super) edges: [Irradiance; 3],
    /// b: at the centre, beyond what the middles of the edges explain, W/m².
    bubble: Irradiance,
}

fn dot(a: Irradiance, b: Irradiance) -> f64 {
    a.0.0.dot(b.0.0) / 3.0
}

/// Σ |xₖ|² + |Σ xₖ|², over the mean of the channels.
fn squares(x: &[Irradiance; 3]) -> f64 {
    let all = x[0] + x[1] + x[2];
    x.iter().map(|&x| dot(x, x)).sum::<f64>() + dot(all, all)
}

/// Mean square of a quadratic misfit with these values at the middles of the edges, after its mean is taken off:
/// about what the fit leaves of it, (W/m²)².
pub(super) fn unfitted(edges: [Irradiance; 3]) -> f64 {
    let mean = (edges[0] + edges[1] + edges[2]) * (1.0 / 3.0);
    4.0 / 45.0 * squares(&edges) - dot(mean, mean)
}

impl Misfit {
    /// From the differences at the edges' middles and at the centre.
    pub(super) fn new(edges: [Irradiance; 3], centre: Irradiance) -> Self {
        // At the centre each λ is ⅓.
        let explained = (edges[0] + edges[1] + edges[2]) * (4.0 / 9.0);
        Self {
            edges,
            bubble: centre - explained,
        }
    }

    /// Mean over the element of the misfit times each λ: what the hat functions see of it.
    pub(super) fn moments(&self) -> [Irradiance; 3] {
        let m = &self.edges;
        [0, 1, 2].map(|k| {
            // Edges k and k + 2 end at corner k, edge k + 1 is opposite.
            (m[k] + m[(k + 2) % 3]) * (2.0 / 15.0)
                + m[(k + 1) % 3] * (1.0 / 15.0)
                + self.bubble * (3.0 / 20.0)
        })
    }

    /// Mean square of the misfit less the linear function with values `added` at the corners, (W/m²)².
    pub(super) fn mean_square(&self, added: [Irradiance; 3]) -> f64 {
        let all = self.edges[0] + self.edges[1] + self.edges[2];
        let own = 4.0 / 45.0 * squares(&self.edges)
            + 12.0 / 35.0 * dot(self.bubble, all)
            + 81.0 / 280.0 * dot(self.bubble, self.bubble);
        let moments = self.moments();
        let crossed: f64 = (0..3).map(|k| dot(moments[k], added[k])).sum();
        // Rounding may leave less than nothing of a perfect fit.
        (own - 2.0 * crossed + squares(&added) / 12.0).max(0.0)
    }
}

impl Add for Misfit {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            edges: [0, 1, 2].map(|k| self.edges[k] + other.edges[k]),
            bubble: self.bubble + other.bubble,
        }
    }
}
