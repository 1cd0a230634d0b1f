//! Files: scenes in, lit scenes and pictures out.
//!
//! [`read_scene`] makes a [`RawScene`] of a scene file: metres, right-handed, y up, nothing repaired.
//! The readers drop what cannot carry light (points, lines) and say so in [`RawScene::warnings`]; what would change the
//! light silently (a reflectance above 1, a position that is not a number) is a [`BadInput`] that names the place.

mod atomic;
pub mod builtin;
mod face_svg;
mod factor_table;
mod glb;
mod gltf_data;
mod gltf_lines;
mod gltf_read;
mod gltf_write;
mod line_table;
mod lit_read;
mod obj;
mod png;
mod sensor_list;
mod units;

pub use atomic::{remove_unfinished, write_atomically};
pub use face_svg::face_svg;
pub use factor_table::form_factors_csv;
pub use gltf_lines::{LineSet, write_lines_glb};
pub use gltf_write::write_glb;
pub use line_table::{candidates_csv, cause_name, lines_csv};
pub use lit_read::read_lit;
pub use png::{read_png, write_png};
pub use sensor_list::{SensorList, read_sensors, readings_csv};
pub use units::{Unit, UpAxis};

use crate::bad_input::BadInput;
use crate::quantity::Rgb;
use crate::scene::{Material, RawScene};
use std::path::Path;

/// How a file's numbers become metres with y up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadSettings {
    /// Length of one unit of an OBJ file; metres when not given. glTF is in metres by its own standard.
    pub unit: Option<Unit>,
    /// The axis that points up in the file.
    pub up: UpAxis,
}

/// Channels of the reflectance of a surface whose material the file does not state.
const DEFAULT_REFLECTANCE: f64 = 0.5;

/// The scene in the `.obj`, `.gltf` or `.glb` file at `path`.
pub fn read_scene(path: &Path, settings: &ReadSettings) -> Result<RawScene, BadInput> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let scene = match extension.to_ascii_lowercase().as_str() {
        "obj" => obj::read(path, settings)?,
        "gltf" | "glb" => gltf_read::read(path, settings)?,
        _ => {
            return Err(BadInput::new(
                place_of(path),
                format!("unknown kind of scene file: extension \"{extension}\""),
                "give a .obj, .gltf or .glb file",
            ));
        }
    };
    if scene.polygons.is_empty() {
        return Err(BadInput::new(
            place_of(path),
            "no faces",
            "export the scene with its polygons (points and lines carry no light)",
        ));
    }
    Ok(scene)
}

/// The path as the user typed it.
fn place_of(path: &Path) -> String {
    path.display().to_string()
}

/// All bytes of a file.
fn read_file(path: &Path) -> Result<Vec<u8>, BadInput> {
    std::fs::read(path).map_err(|error| {
        BadInput::new(
            place_of(path),
            format!("cannot be read: {error}"),
            "check the path and the permissions",
        )
    })
}

/// Refuses a material whose numbers no surface can have.
fn check_material(place: &str, material: &Material) -> Result<(), BadInput> {
    let name = &material.name;
    let reflectance = material.reflectance.to_array();
    if !reflectance
        .iter()
        .all(|&channel| (0.0..=1.0).contains(&channel))
    {
        return Err(BadInput::new(
            place,
            format!("material \"{name}\" has reflectance {reflectance:?}, outside 0…1"),
            "bring its diffuse colour (Kd, baseColorFactor) into 0…1",
        ));
    }
    let emission = material.emission.0.to_array();
    if !emission
        .iter()
        .all(|channel| channel.is_finite() && *channel >= 0.0)
    {
        return Err(BadInput::new(
            place,
            format!(
                "material \"{name}\" emits {emission:?} W/(m² sr), which is negative or not finite"
            ),
            "give an emission (Ke, emissiveFactor × emissiveStrength) of 0 or more",
        ));
    }
    Ok(())
}

/// The material of surfaces for which the file defines none.
fn default_material(name: &str, reflects_back: bool) -> Material {
    Material {
        name: name.to_owned(),
        reflectance: Rgb::grey(DEFAULT_REFLECTANCE),
        reflects_back,
        ..Material::default()
    }
}

/// An index into a list of at most 2³² items, as [`RawScene`] stores it.
fn index_u32(index: usize, place: &str) -> Result<u32, BadInput> {
    u32::try_from(index).map_err(|_| {
        BadInput::new(
            place,
            "more than 4 294 967 295 positions or materials",
            "split the scene",
        )
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;
