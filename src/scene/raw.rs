//! The scene as the file said it: polygons over positions, nothing repaired yet.

use crate::quantity::{Radiance, Rgb};
use crate::texture::Texture;
use crate::warning::Warning;
use glam::{DVec2, DVec3};

/// What a reader hands over. Positions are metres, right-handed, y up.
#[derive(Clone, Debug, Default)]
pub struct RawScene {
    /// Name for messages and outputs: the file's path as the user typed it.
    pub source: String,
    /// All positions, in the order of the file.
    pub positions: Vec<DVec3>,
    /// Texture coordinates of each position, finite; empty where no surface has any. A position with several of them is
    /// listed several times.
    pub uvs: Vec<DVec2>,
    /// Shading normal of each position: a unit vector, or zero where the file states none; empty where it never does.
    /// Where these differ from a polygon's own normal, the polygon stands for a part of a curved surface.
    pub normals: Vec<DVec3>,
    /// All polygons, in the order of the file.
    pub polygons: Vec<RawPolygon>,
    /// Materials; every `RawPolygon::material` is an index into this.
    pub materials: Vec<Material>,
    /// Textures; every `Material::texture` is an index into this.
    pub textures: Vec<Texture>,
    /// Object, group or node names; every `RawPolygon::group` is an index into this.
    pub groups: Vec<String>,
    /// Cameras of the file.
    pub cameras: Vec<Camera>,
    /// Lights without a surface.
    pub lights: Vec<PunctualLight>,
    /// What the reader had to repair or drop.
    pub warnings: Vec<Warning>,
}

/// One polygon of the file: corners counter-clockwise seen from its front.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawPolygon {
    /// Indices into [`RawScene::positions`].
    pub corners: Vec<u32>,
    /// Index into [`RawScene::materials`].
    pub material: u32,
    /// Index into [`RawScene::groups`].
    pub group: u32,
}

/// A diffuse material as the light sees it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Diffuse reflectance ρ, 0…1 a channel; where there is a texture, the factor of its texels.
    pub reflectance: Rgb,
    /// Index into [`RawScene::textures`].
    pub texture: Option<u32>,
    /// Texels whose opacity (0…1) is below this are not there.
    pub cut_off: Option<f64>,
    /// Emitted radiance, W/(m² sr); where there is a texture for it, the factor of its texels.
    pub emission: Radiance,
    /// Index into [`RawScene::textures`] of the texture that the emission follows, by the coordinates of the other one.
    pub emission_texture: Option<u32>,
    /// Whether light passes as if the surface were not there.
    pub is_see_through: bool,
    /// Whether the back reflects (and receives) as the front does.
    pub reflects_back: bool,
    /// Whether the back emits as the front does.
    pub emits_back: bool,
}

impl Material {
    /// True when some channel emits.
    pub fn is_emitter(&self) -> bool {
        !self.emission.0.is_black()
    }
}

/// A camera of the file, in world coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the file.
    pub name: String,
    /// Where it stands, metres.
    pub eye: DVec3,
    /// Unit viewing direction.
    pub forward: DVec3,
    /// Unit up direction, at a right angle to `forward`.
    pub up: DVec3,
    /// Vertical field of view, radians.
    pub vertical_fov_rad: f64,
    /// Width over height, where the file states it.
    pub aspect: Option<f64>,
}

/// A light without a surface, in world coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct PunctualLight {
    /// Name in the file.
    pub name: String,
    /// How it shines.
    pub kind: PunctualKind,
    /// Where it stands, metres; no matter for a directional one.
    pub position: DVec3,
    /// Unit direction in which it shines; no matter for a point light.
    pub direction: DVec3,
    /// Colour times intensity: W/sr, of a directional light W/m² on a surface that faces it.
    pub intensity: Rgb,
    /// Beyond this distance, metres, the light may be left out.
    pub range: Option<f64>,
}

impl PunctualLight {
    /// The same in coordinates relative to `origin`.
    pub(super) fn seen_from(&self, origin: DVec3) -> Self {
        Self {
            position: self.position - origin,
            ..self.clone()
        }
    }
}

/// How a light without a surface shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualKind {
    /// The same in all directions.
    Point,
    /// In a cone around its direction: fully up to the inner angle, not at all beyond the outer one.
    Spot {
        /// Angle from the axis, radians.
        inner_angle_rad: f64,
        /// Angle from the axis, radians.
        outer_angle_rad: f64,
    },
    /// From infinitely far away.
    Directional,
}
