//! Pictures of a lit model, as an unlit glTF viewer shows it: `baseColor × COLOR_0`, fronts only, no light computed.

mod camera;
mod colour_map;
mod false_colour;
mod glyphs;
mod image;
mod irradiance;
mod legend;
mod raster;
mod raycast;
mod surface;

pub use crate::texture::{srgb_decode, srgb_encode};
pub use camera::{CameraChoice, choose_camera, frame_box};
pub use colour_map::{COLOUR_MAP, ColourScale, LightUnit, false_colour, round_top};
pub use false_colour::render_false_colour;
pub use image::{Image, Picture};
pub use legend::{LEGEND_HEIGHT, with_legend};
pub use raycast::{MAX_SIZE, MAX_SUPERSAMPLE, RenderSettings, render};

use crate::quantity::{Exitance, Radiosity, Rgb};
use crate::scene::Camera;
use crate::texture::Texture;
use glam::{DVec2, DVec3};

/// What a lit glTF holds, in world coordinates (metres).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LitModel {
    /// Name for messages: the file's path as the user typed it.
    pub source: String,
    /// One part for each primitive of each node.
    pub parts: Vec<LitPart>,
    /// Textures of the parts.
    pub textures: Vec<Texture>,
    /// Perspective cameras.
    pub cameras: Vec<Camera>,
    /// `COLOR_0` for each W/(m² sr), where the file states it.
    pub exposure: Option<f64>,
    /// What else the file says beside its light: settings, measured error.
    pub extras: serde_json::Value,
}

/// Triangles that share a material. All vertex lists have the length of `positions`; triangles name vertices of theirs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LitPart {
    /// Name of the node.
    pub node: String,
    /// Name of the material.
    pub material: String,
    /// Linear base colour, 0…1.
    pub base_colour: Rgb,
    /// Index into [`LitModel::textures`]; its texels multiply the base colour.
    pub texture: Option<u32>,
    /// Texels whose opacity (0…1) is below this are looked through.
    pub cut_off: Option<f64>,
    /// Whether the back is drawn as the front is.
    pub is_double_sided: bool,
    /// Vertex positions, metres, world.
    pub positions: Vec<DVec3>,
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Texture coordinates; empty without a texture.
    pub uvs: Vec<DVec2>,
    /// Linear `COLOR_0`, 0…1.
    pub colours: Vec<Rgb>,
    /// `_RADIOSITY`, W/m², unclamped; empty when the file has none.
    pub radiosities: Vec<Radiosity>,
    /// Counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// What the surface emits and reflects, where it emits.
    pub emitter: Option<EmitterSide>,
}

/// A side that emits: `COLOR_0` of its part shows what it emits and what it reflects together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EmitterSide {
    /// W/m².
    pub exitance: Exitance,
    /// Diffuse reflectance, 0…1.
    pub reflectance: Rgb,
}

impl LitModel {
    /// Corners of the box around all vertices, or none without any.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let all = || self.parts.iter().flat_map(|part| &part.positions).copied();
        Some([all().reduce(DVec3::min)?, all().reduce(DVec3::max)?])
    }
}
