//! The light that arrives at the surfaces of a lit model, from what its file holds.

use super::{LitModel, LitPart};
use crate::bad_input::BadInput;
use crate::quantity::{Irradiance, Rgb};
use std::f64::consts::PI;

impl LitModel {
    /// Irradiance at vertex `i` of `part`, W/m²; none in a model that does not state its exposure.
    ///
    /// `E = π COLOR_0 / exposure` channel by channel. Where `COLOR_0` has come to its end (1), and at emitters, it is
    /// `(B − M) / ρ` from `_RADIOSITY`; a channel that is clamped and reflects nothing is as bright as the file can say.
    pub fn irradiance(&self, part: &LitPart, i: usize) -> Option<Irradiance> {
        let exposure = self.exposure.filter(|&e| e > 0.0)?;
        let colour = part.colours[i].to_array();
        let radiosity = part.radiosities.get(i).map(|b| b.0.to_array());
        let emitter = part.emitter;
        let reflectance = emitter.map_or(part.base_colour, |e| e.reflectance);
        let (rho, emitted) = (
            reflectance.to_array(),
            emitter.map_or([0.0; 3], |e| e.exitance.0.to_array()),
        );
        let channel = |c: usize| match radiosity {
            Some(b) if (emitter.is_some() || colour[c] >= 1.0) && rho[c] > 0.0 => {
                ((b[c] - emitted[c]) / rho[c]).max(0.0)
            }
            _ if emitter.is_some() => 0.0,
            _ => PI * colour[c] / exposure,
        };
        let [r, g, b] = [0, 1, 2].map(channel);
        Some(Irradiance(Rgb::new(r, g, b)))
    }

    /// Refuses a model from which no irradiance can be read.
    pub(super) fn check_irradiance(&self) -> Result<(), BadInput> {
        match self.exposure {
            Some(e) if e > 0.0 => Ok(()),
            _ => Err(BadInput::new(
                &self.source,
                "does not state its exposure, so its colours are no light in W/m²",
                "bake it again with umbrage",
            )),
        }
    }

    /// Irradiance and area (m²) of every triangle that does not emit: the mean of its corners.
    pub fn triangle_light(&self) -> Vec<(Irradiance, f64)> {
        let parts = self.parts.iter().filter(|part| part.emitter.is_none());
        parts
            .flat_map(|part| {
                part.triangles.iter().filter_map(|corners| {
                    let [a, b, c] = corners.map(|i| part.positions[i as usize]);
                    let mut sum = Irradiance::ZERO;
                    for &i in corners {
                        sum += self.irradiance(part, i as usize)?;
                    }
                    Some((sum * (1.0 / 3.0), 0.5 * (b - a).cross(c - a).length()))
                })
            })
            .collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::quantity::{Exitance, Radiosity};
    use crate::render::EmitterSide;

    /// A few roundings of irradiances of tens of W/m².
    const ROUNDOFF: f64 = 1e-12;

    #[test]
    fn light_beyond_the_end_of_the_colours_comes_from_the_radiosity() {
        let light = Irradiance(Rgb::new(1.0, 40.0, 3.0));
        let rho = Rgb::new(0.5, 0.25, 0.0);
        let exposure = 0.5;
        let part = LitPart {
            base_colour: rho,
            colours: vec![Rgb((light.0.0 * (exposure / PI)).min(glam::DVec3::ONE))],
            radiosities: vec![Radiosity(light.0 * rho)],
            ..LitPart::default()
        };
        let model = LitModel {
            exposure: Some(exposure),
            ..LitModel::default()
        };
        let found = model.irradiance(&part, 0).unwrap();
        assert!((found.0.0 - light.0.0).abs().max_element() < ROUNDOFF);

        // The same surface as an emitter: what it emits is no light that arrives.
        let exitance = Exitance(Rgb::grey(7.0));
        let emitter = LitPart {
            radiosities: vec![Radiosity::leaving(exitance, rho, light)],
            emitter: Some(EmitterSide {
                exitance,
                reflectance: rho,
            }),
            ..part
        };
        let found = model.irradiance(&emitter, 0).unwrap().0.to_array();
        assert!(
            (found[1] - 40.0).abs() < ROUNDOFF && found[2] == 0.0,
            "{found:?}"
        );
        assert!(LitModel::default().irradiance(&emitter, 0).is_none());
    }
}
