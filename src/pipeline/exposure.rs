//! From W/m² to colours between 0 and 1.

use crate::lit_scene::LitMesh;
use crate::settings::Exposure;
use std::f64::consts::PI;

/// Share of the lit area that may saturate under automatic exposure.
const SATURATED_SHARE: f64 = 0.01;

/// The factor of `COLOR_0 = E/π × exposure`, 1/(W m⁻² sr⁻¹).
pub(super) fn exposure(meshes: &[LitMesh], setting: Exposure) -> f64 {
    match setting {
        Exposure::Ev(ev) => ev.exp2(),
        Exposure::Auto => {
            // The area-weighted quantile of the brightest channel at elements' middles. Emitters show their own light.
            let mut values: Vec<(f64, f64)> = Vec::new();
            for m in meshes.iter().filter(|m| m.exitance.0.is_black()) {
                for t in &m.triangles {
                    let [a, b, c] = t.map(|i| m.positions[i as usize]);
                    let area = 0.5 * (b - a).cross(c - a).length();
                    let e = t
                        .iter()
                        .map(|&i| m.irradiance[i as usize].0.0.max_element())
                        .sum::<f64>()
                        / 3.0;
                    if e > 0.0 {
                        values.push((e, area));
                    }
                }
            }
            values.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
            let total: f64 = values.iter().map(|v| v.1).sum();
            let mut brighter = 0.0;
            values
                .iter()
                .find(|v| {
                    brighter += v.1;
                    brighter >= SATURATED_SHARE * total
                })
                .map_or(1.0, |v| PI / v.0)
        }
    }
}
