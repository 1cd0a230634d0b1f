//! The scene as the file said it: polygons over positions, nothing repaired yet.

use crate::quantity::{Radiance, Rgb};
use crate::warning::Warning;
use glam::DVec3;

/// What a reader hands over. Positions are metres, right-handed, y up.
#[derive(Clone, Debug, Default)]
pub struct RawScene {
    /// Name for messages and outputs: the file's path as the user typed it.
    pub source: String,
    /// All positions, in the order of the file.
    pub positions: Vec<DVec3>,
    /// All polygons, in the order of the file.
    pub polygons: Vec<RawPolygon>,
    /// Materials; every `RawPolygon::material` is an index into this.
    pub materials: Vec<Material>,
    /// Object, group or node names; every `RawPolygon::group` is an index into this.
    pub groups: Vec<String>,
    /// Cameras of the file.
    pub cameras: Vec<Camera>,
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
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Diffuse reflectance ρ, 0…1 a channel.
    pub reflectance: Rgb,
    /// Emitted radiance, W/(m² sr).
    pub emission: Radiance,
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
