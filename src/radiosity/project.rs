//! Brings the direct light of the display mesh to the solve mesh without losing power.

use super::SolveMesh;
use crate::quantity::Irradiance;
use glam::DVec2;

/// A bit of light on a solve face.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Index of the solve face.
    pub face: u32,
    /// Where, frame coordinates, metres.
    pub point: DVec2,
    /// For how much area it speaks, m².
    pub area: f64,
    /// The light, W/m².
    pub irradiance: Irradiance,
}

/// Nodal direct irradiance on the solve mesh: each sample is shared among the corners of its element by the linear basis
/// (lumped L² projection), so that `Σ mass · g` is the power of all samples. A site that no sample reaches takes its
/// value from `fallback`.
pub fn project(
    mesh: &SolveMesh,
    samples: impl Iterator<Item = LightSample>,
    mut fallback: impl FnMut(usize, usize) -> Irradiance,
) -> Vec<Irradiance> {
    let mut mass = vec![0.0; mesh.site_count()];
    let mut sum = vec![Irradiance::ZERO; mesh.site_count()];
    for sample in samples {
        let face = &mesh.faces[sample.face as usize];
        if let Some((e, weights)) = face.locate(sample.point) {
            for (&s, w) in face.mesh.sites[e].iter().zip(weights) {
                let site = face.first_site + s as usize;
                mass[site] += w * sample.area;
                sum[site] += sample.irradiance * (w * sample.area);
            }
        }
    }
    for (f, face) in mesh.faces.iter().enumerate() {
        for s in 0..face.mesh.site_vertices.len() {
            let site = face.first_site + s;
            sum[site] = if mass[site] > 0.0 {
                sum[site] * (1.0 / mass[site])
            } else {
                fallback(f, s)
            };
        }
    }
    sum
}
