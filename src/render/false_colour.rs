//! Pictures of the light that arrives, as colours.

use super::{
    ColourScale, Image, LitModel, LitPart, MAX_SIZE, MAX_SUPERSAMPLE, RenderSettings, render,
    srgb_decode,
};
use crate::bad_input::BadInput;
use crate::quantity::{Irradiance, Rgb};
use glam::DVec3;

/// The picture of `model` with the light that arrives at its surfaces as colours of `scale`; emitters and what lies beside
/// the model are black.
///
/// Each ray has a colour of its own and a pixel is their mean: the mean of the light on both sides of an edge would be a
/// light that is nowhere. Pictures near the largest size get fewer rays a pixel than asked for.
///
/// # Errors
/// When the model does not tell its irradiance ([`LitModel::irradiance`]), or the settings ask for too much.
pub fn render_false_colour(
    model: &LitModel,
    settings: &RenderSettings,
    scale: &ColourScale,
) -> Result<Image, BadInput> {
    model.check_irradiance()?;
    if !(1..=MAX_SUPERSAMPLE).contains(&settings.supersample) {
        // Refused in the same words as for any picture.
        return render(model, settings);
    }
    let most = MAX_SIZE / settings.width.max(settings.height).max(1);
    let n = settings.supersample.min(most).max(1);
    // One ray at the middle of each of n × n parts of a pixel is one at the middle of each pixel of a larger picture.
    let fine = RenderSettings {
        width: settings.width * n,
        height: settings.height * n,
        supersample: 1,
        background: NOTHING,
        ..settings.clone()
    };
    let light = render(&as_light(model), &fine)?;
    let colour = |x: u32, y: u32| {
        let light = light.pixels[(y * fine.width + x) as usize];
        if !light.is_finite() {
            return Rgb::BLACK;
        }
        let colour = scale.colour(Irradiance(light));
        let channels = colour.map(|c| srgb_decode(f64::from(c) / 255.0));
        Rgb(DVec3::from_array(channels))
    };
    let mut pixels = Vec::with_capacity((settings.width * settings.height) as usize);
    for y in 0..settings.height {
        for x in 0..settings.width {
            let mut sum = Rgb::BLACK;
            for part in 0..n * n {
                sum += colour(x * n + part % n, y * n + part / n);
            }
            pixels.push(sum * (1.0 / f64::from(n * n)));
        }
    }
    Ok(Image {
        width: settings.width,
        height: settings.height,
        pixels,
    })
}

/// What stands where no light is shown.
const NOTHING: Rgb = Rgb::grey(f64::NAN);

/// A model whose colours are the irradiance, W/m².
fn as_light(model: &LitModel) -> LitModel {
    let parts = model.parts.iter().map(|part| {
        let light = |i| match part.emitter {
            Some(_) => NOTHING,
            None => model.irradiance(part, i).map_or(NOTHING, |e| e.0),
        };
        LitPart {
            base_colour: Rgb::grey(1.0),
            is_double_sided: part.is_double_sided,
            positions: part.positions.clone(),
            normals: part.normals.clone(),
            colours: (0..part.positions.len()).map(light).collect(),
            triangles: part.triangles.clone(),
            ..LitPart::default()
        }
    });
    LitModel {
        source: model.source.clone(),
        parts: parts.collect(),
        ..LitModel::default()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::render::{CameraChoice, EmitterSide, LightUnit, choose_camera, false_colour};
    use std::f64::consts::PI;

    #[test]
    fn light_has_its_colour_and_emitters_and_nothing_are_black() {
        // Two squares side by side in front of the camera: 1 W/m² on the left one, a lamp on the right.
        let square = |x: f64| LitPart {
            positions: [(x, 0.0), (x + 1.0, 0.0), (x + 1.0, 1.0), (x, 1.0)]
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .to_vec(),
            normals: vec![DVec3::Z; 4],
            base_colour: Rgb::grey(0.3),
            colours: vec![Rgb::grey(0.5 / PI); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..LitPart::default()
        };
        let lamp = LitPart {
            emitter: Some(EmitterSide::default()),
            ..square(0.0)
        };
        let model = LitModel {
            parts: vec![square(-1.0), lamp],
            exposure: Some(0.5),
            ..LitModel::default()
        };
        let camera = choose_camera(&CameraChoice::Auto, &model, 2.0).unwrap();
        let settings = RenderSettings::new(40, 20, camera);
        let unit = LightUnit::WattsPerSquareMetre;
        let scale = ColourScale { unit, top: 2.0 };
        let found = render_false_colour(&model, &settings, &scale)
            .unwrap()
            .to_srgb();
        let at = |x: usize, y: usize| found.pixels[y * 40 + x];
        assert_eq!(at(10, 10), false_colour(0.5));
        assert_eq!((at(30, 10), at(0, 0)), ([0; 3], [0; 3]));
        let many = RenderSettings {
            supersample: 17,
            ..settings.clone()
        };
        assert!(render_false_colour(&model, &many, &scale).is_err());
        // Without an exposure colours are no light.
        let unknown = LitModel {
            exposure: None,
            ..model
        };
        assert!(render_false_colour(&unknown, &settings, &scale).is_err());
    }
}
