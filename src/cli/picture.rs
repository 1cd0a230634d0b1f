//! The picture of a lit model in the size and from the camera that were asked for.

use super::options::PictureSize;
use umbrage::bad_input::BadInput;
use umbrage::render::{
    CameraChoice, ColourScale, LitModel, Picture, RenderSettings, choose_camera, render,
    render_false_colour, with_legend,
};

/// The longer side of a picture whose size nobody stated, pixels.
const DEFAULT_SIZE: u32 = 512;

/// Where a vertical field of view comes from.
#[derive(Clone, Copy, Debug)]
pub(super) enum FieldOfView {
    /// The angle itself, radians.
    Vertical(f64),
    /// The angle from left to right, radians.
    Horizontal(f64),
}

/// How else a picture is taken.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lens {
    /// Instead of the camera's own.
    pub(super) field_of_view: Option<FieldOfView>,
    /// Rays along each side of a pixel.
    pub(super) supersample: Option<u32>,
}

/// The picture of `model`, in false colours with their scale below it when one is given. Without a size it has 512 pixels along its longer side, in the camera's own shape.
pub(super) fn take(
    model: &LitModel,
    choice: &CameraChoice,
    size: Option<PictureSize>,
    lens: Option<Lens>,
    false_colours: Option<&ColourScale>,
) -> Result<Picture, BadInput> {
    let shape = |s: PictureSize| f64::from(s.width) / f64::from(s.height);
    let mut camera = choose_camera(choice, model, size.map_or(1.0, shape))?;
    let size = size.unwrap_or_else(|| default_size(camera.aspect.unwrap_or(1.0)));
    let lens = lens.unwrap_or_default();
    match lens.field_of_view {
        Some(FieldOfView::Vertical(angle)) => camera.vertical_fov_rad = angle,
        Some(FieldOfView::Horizontal(angle)) => {
            camera.vertical_fov_rad = 2.0 * ((angle / 2.0).tan() / shape(size)).atan();
        }
        None => {}
    }
    let mut settings = RenderSettings::new(size.width, size.height, camera);
    if let Some(n) = lens.supersample {
        settings.supersample = n;
    }
    match false_colours {
        None => Ok(render(model, &settings)?.to_srgb()),
        Some(scale) => {
            let image = render_false_colour(model, &settings, scale)?;
            Ok(with_legend(&image.to_srgb(), scale))
        }
    }
}

fn default_size(aspect: f64) -> PictureSize {
    let shorter = |share: f64| (f64::from(DEFAULT_SIZE) * share).round().max(1.0) as u32;
    if aspect >= 1.0 {
        PictureSize {
            width: DEFAULT_SIZE,
            height: shorter(1.0 / aspect),
        }
    } else {
        PictureSize {
            width: shorter(aspect),
            height: DEFAULT_SIZE,
        }
    }
}
