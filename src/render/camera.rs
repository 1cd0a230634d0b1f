//! Which camera takes the picture.

use super::LitModel;
use crate::bad_input::BadInput;
use crate::scene::Camera;
use glam::DVec3;
use std::f64::consts::PI;

/// Vertical field of view of a camera that nobody stated, radians: 40°, a portrait lens rather than a wide one.
const DEFAULT_FOV_RAD: f64 = 40.0 * PI / 180.0;

/// Empty space around a framed model, as a factor of its distance.
const MARGIN: f64 = 1.05;

/// What the user said about the camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CameraChoice {
    /// Nothing: the first camera of the file; without any, the model from its front.
    #[default]
    Auto,
    /// A camera of the file by name or, where no camera has that name, by its index from 0.
    Named(String),
    /// A view of the user's own, in world coordinates.
    LookAt {
        /// Where it stands, metres.
        eye: DVec3,
        /// What stands in the middle of the picture, metres.
        target: DVec3,
        /// Which way is up in the picture; +y where not stated, or −z when looking straight up or down.
        up: Option<DVec3>,
        /// Vertical field of view, radians; 40° where not stated.
        vertical_fov_rad: Option<f64>,
    },
}

/// The camera that `choice` means for `model`, in a picture of `aspect` (width over height).
///
/// Without a choice and without cameras the model is seen from its front, which glTF lays on +z: the camera looks along −z
/// at the middle of the box around all vertices, from where its nearest side fits the picture.
pub fn choose_camera(
    choice: &CameraChoice,
    model: &LitModel,
    aspect: f64,
) -> Result<Camera, BadInput> {
    match choice {
        CameraChoice::Auto => match model.cameras.first() {
            Some(camera) => Ok(camera.clone()),
            None => frame(model, aspect),
        },
        CameraChoice::Named(name) => named(name, model),
        &CameraChoice::LookAt {
            eye,
            target,
            up,
            vertical_fov_rad,
        } => look_at(eye, target, up, vertical_fov_rad.unwrap_or(DEFAULT_FOV_RAD)),
    }
}

fn named(name: &str, model: &LitModel) -> Result<Camera, BadInput> {
    let by_name = model.cameras.iter().find(|camera| camera.name == name);
    let by_index = || model.cameras.get(name.parse::<usize>().ok()?);
    by_name.or_else(by_index).cloned().ok_or_else(|| {
        let names: Vec<_> = model.cameras.iter().map(|c| c.name.as_str()).collect();
        let remedy = if names.is_empty() {
            String::from("the file has no cameras; give --eye and --target")
        } else {
            format!("choose one of: {}", names.join(", "))
        };
        BadInput::new(&model.source, format!("has no camera '{name}'"), remedy)
    })
}

fn look_at(
    eye: DVec3,
    target: DVec3,
    up: Option<DVec3>,
    vertical_fov_rad: f64,
) -> Result<Camera, BadInput> {
    let bad = |what: &str, remedy: &str| BadInput::new("camera", what, remedy);
    if !(eye.is_finite() && target.is_finite()) {
        return Err(bad(
            "eye or target is not a finite point",
            "give three finite numbers for each",
        ));
    }
    if !(vertical_fov_rad > 0.0 && vertical_fov_rad < PI) {
        let what = format!("the field of view is {:.4}°", vertical_fov_rad.to_degrees());
        return Err(bad(&what, "give an angle between 0° and 180°"));
    }
    let forward = (target - eye)
        .try_normalize()
        .ok_or_else(|| bad("eye and target are the same point", "move one of them"))?;
    let upright = |up: DVec3| {
        Some(
            forward
                .cross(up.try_normalize()?)
                .try_normalize()?
                .cross(forward),
        )
    };
    let up = match up {
        Some(up) => upright(up).ok_or_else(|| {
            bad(
                "up is zero or along the view",
                "give a direction across the view",
            )
        })?,
        None => upright(DVec3::Y)
            .or_else(|| upright(DVec3::NEG_Z))
            .expect("no direction runs along both y and z"),
    };
    Ok(Camera {
        name: String::from("view"),
        eye,
        forward,
        up: up.normalize(),
        vertical_fov_rad,
        aspect: None,
    })
}

/// The whole of `model` from +z.
fn frame(model: &LitModel, aspect: f64) -> Result<Camera, BadInput> {
    let bounds = model.bounds().ok_or_else(|| {
        BadInput::new(
            &model.source,
            "holds nothing to look at",
            "bake a scene with surfaces, or give --eye and --target",
        )
    })?;
    frame_box(bounds, aspect)
}

/// A camera that sees the whole of a box, by its corners (metres), from +z.
///
/// # Errors
/// When a corner is not finite.
pub fn frame_box([low, high]: [DVec3; 2], aspect: f64) -> Result<Camera, BadInput> {
    let (middle, half) = (low.midpoint(high), (high - low) / 2.0);
    let slope = (DEFAULT_FOV_RAD / 2.0).tan();
    let away = (half.y / slope).max(half.x / (slope * aspect)) * MARGIN;
    // A model without width or height is a line towards the camera: step back by its length, or by a metre.
    let away = if away > 0.0 { away } else { half.z.max(1.0) };
    let eye = middle + DVec3::Z * (half.z + away);
    look_at(eye, eye - DVec3::Z, None, DEFAULT_FOV_RAD)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::render::LitPart;

    fn model() -> LitModel {
        let part = LitPart {
            positions: vec![DVec3::new(-2.0, -1.0, -1.0), DVec3::new(2.0, 1.0, 3.0)],
            ..Default::default()
        };
        LitModel {
            parts: vec![part],
            ..Default::default()
        }
    }

    fn camera(name: &str) -> Camera {
        let view = look_at(DVec3::ZERO, DVec3::X, None, 1.0).unwrap();
        Camera {
            name: name.to_owned(),
            ..view
        }
    }

    #[test]
    fn a_model_without_cameras_is_framed_from_its_front() {
        for aspect in [0.5, 1.0, 4.0] {
            let found = choose_camera(&CameraChoice::Auto, &model(), aspect).unwrap();
            assert_eq!((found.forward, found.up), (DVec3::NEG_Z, DVec3::Y));
            let slope = (found.vertical_fov_rad / 2.0).tan() * (found.eye.z - 3.0);
            // The nearest side fits, with the margin to spare in the tighter direction.
            let fill = (1.0 / slope).max(2.0 / (slope * aspect));
            assert!((fill - 1.0 / MARGIN).abs() < 1e-12, "{fill}");
        }
    }

    #[test]
    fn names_go_before_indices_and_a_wrong_one_lists_the_rest() {
        let mut model = model();
        model.cameras = vec![camera("door"), camera("0")];
        let choose = |text: &str| choose_camera(&CameraChoice::Named(text.into()), &model, 1.0);
        assert_eq!(choose("0").unwrap().name, "0");
        assert_eq!(choose("1").unwrap().name, "0");
        assert_eq!(choose("door").unwrap().name, "door");
        assert!(choose("roof").unwrap_err().remedy.ends_with("door, 0"));
        let first = choose_camera(&CameraChoice::Auto, &model, 1.0).unwrap();
        assert_eq!(first.name, "door");
    }

    #[test]
    fn looking_straight_down_needs_no_up() {
        let down = look_at(DVec3::Y, DVec3::ZERO, None, 1.0).unwrap();
        assert_eq!(down.up, DVec3::NEG_Z);
    }

    #[test]
    fn views_that_show_nothing_are_refused() {
        let up = Some(DVec3::X);
        assert!(look_at(DVec3::X, DVec3::X, None, 1.0).is_err());
        assert!(look_at(DVec3::X, DVec3::ZERO, up, 1.0).is_err());
        assert!(look_at(DVec3::X, DVec3::ZERO, None, 4.0).is_err());
        assert!(look_at(DVec3::NAN, DVec3::ZERO, None, 1.0).is_err());
        let empty = LitModel::default();
        assert!(choose_camera(&CameraChoice::Auto, &empty, 1.0).is_err());
    }
}
