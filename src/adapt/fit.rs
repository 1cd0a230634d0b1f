//! Values at the sites that fit the light best, instead of interpolating it.
//!
//! Where light is convex its linear interpolation lies above it everywhere. The best values in the mean square differ from
//! the light at the sites by δ with `M δ = r`: the mass matrix `M = ∫ φᵢ φⱼ` of the linear hat functions φ, and the moments
//! `r = ∫ (E − I E) φᵢ` of the interpolation error, which the samples of the refinement tell.
//!
//! Papers: L. Kavan, A. W. Bargteil & P.-P. Sloan, *Least squares vertex baking*, 2011; for the condition of M: A. J. Wathen,
//! *Realistic eigenvalue bounds for the Galerkin mass matrix*, 1987. Unlike Kavan we do not smooth: our meshes follow the
//! light. Black stays black, and no value becomes negative.

use super::misfit::Misfit;
use crate::mesh::ReceiverMesh;
use crate::quantity::Irradiance;

/// Conjugate gradients: scaled by its diagonal M has its eigenvalues between ½ and 2, so that each step divides the error by
/// three; after these it is far below the misfit.
const STEPS: usize = 8;

/// Shares of a triangle's area in its mass matrix: on the diagonal and beside it.
const DIAGONAL: f64 = 1.0 / 6.0;
const BESIDE: f64 = 1.0 / 12.0;

/// What to add to the interpolated `values` at the sites so that the mean square error is least, W/m².
pub(super) fn fit(
    mesh: &ReceiverMesh,
    values: &[Irradiance],
    misfits: &[Misfit],
) -> Vec<Irradiance> {
    let mut diagonal = vec![0.0; values.len()];
    let mut rest = vec![Irradiance::ZERO; values.len()];
    for (e, sites) in mesh.sites.iter().enumerate() {
        let area = mesh.area(e);
        for (s, moment) in sites.iter().zip(misfits[e].moments()) {
            diagonal[*s as usize] += area * DIAGONAL;
            rest[*s as usize] += moment * area;
        }
    }
    // Where no light arrives none is shown: these values are known, not sought.
    let scale: Vec<f64> = values
        .iter()
        .zip(&diagonal)
        .map(|(v, &d)| if v.0.is_black() { 0.0 } else { 1.0 / d })
        .collect();
    let mut added = solve(mesh, &scale, rest);
    for (a, v) in added.iter_mut().zip(values) {
        a.0.0 = a.0.0.max(-v.0.0);
    }
    added
}

/// Conjugate gradients with the inverse diagonal `scale`; where that is zero, so is the result.
fn solve(mesh: &ReceiverMesh, scale: &[f64], mut rest: Vec<Irradiance>) -> Vec<Irradiance> {
    let scaled = |x: &[Irradiance]| -> Vec<Irradiance> {
        x.iter().zip(scale).map(|(&x, &s)| x * s).collect()
    };
    let mut added = vec![Irradiance::ZERO; rest.len()];
    let mut direction = scaled(&rest);
    let mut size = dot(&rest, &direction);
    for _ in 0..STEPS {
        let image = mass_times(mesh, &direction);
        let bend = dot(&direction, &image);
        if bend <= 0.0 {
            break;
        }
        for s in 0..rest.len() {
            added[s] += direction[s] * (size / bend);
            rest[s] += image[s] * (-size / bend);
        }
        let next = scaled(&rest);
        let next_size = dot(&rest, &next);
        for (d, n) in direction.iter_mut().zip(next) {
            *d = n + *d * (next_size / size);
        }
        size = next_size;
    }
    added
}

fn mass_times(mesh: &ReceiverMesh, x: &[Irradiance]) -> Vec<Irradiance> {
    let mut product = vec![Irradiance::ZERO; x.len()];
    for (e, sites) in mesh.sites.iter().enumerate() {
        let at = sites.map(|s| x[s as usize]);
        let all = (at[0] + at[1] + at[2]) * BESIDE;
        let area = mesh.area(e);
        for k in 0..3 {
            product[sites[k] as usize] += (all + at[k] * (DIAGONAL - BESIDE)) * area;
        }
    }
    product
}

fn dot(a: &[Irradiance], b: &[Irradiance]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x.0.0.dot(y.0.0)).sum()
}
