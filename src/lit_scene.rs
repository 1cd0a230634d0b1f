//! The result: meshes with light at their vertices, ready to be written or drawn.

use crate::quantity::{Exitance, Irradiance, Radiosity};
use crate::scene::{Camera, Material};
use glam::DVec3;

/// A lit scene. Positions are metres relative to `origin`.
#[derive(Clone, Debug, Default)]
pub struct LitScene {
    /// World position of the local origin, metres.
    pub origin: DVec3,
    /// Materials of the source scene.
    pub materials: Vec<Material>,
    /// Object or node names of the source scene.
    pub groups: Vec<String>,
    /// Cameras of the source scene, in world coordinates.
    pub cameras: Vec<Camera>,
    /// One mesh for each lit side of each face.
    pub meshes: Vec<LitMesh>,
    /// `COLOR_0 = E / π × exposure`, clamped to 1: 1/(W m⁻² sr⁻¹).
    pub exposure: f64,
    /// What to put beside the light in the file: settings, measured error, unit.
    pub extras: serde_json::Value,
}

/// The lit mesh of one side of one face.
#[derive(Clone, Debug, Default)]
pub struct LitMesh {
    /// Index into [`LitScene::groups`].
    pub group: u32,
    /// Index into [`LitScene::materials`].
    pub material: u32,
    /// Face of the cleaned scene, for messages and picking.
    pub face: u32,
    /// Unit normal of the lit side.
    pub normal: DVec3,
    /// Vertex positions, metres, local. Vertices on D0 lines appear once a side.
    pub positions: Vec<DVec3>,
    /// Counter-clockwise seen from the lit side.
    pub triangles: Vec<[u32; 3]>,
    /// Irradiance at each vertex, W/m².
    pub irradiance: Vec<Irradiance>,
    /// What this side emits, W/m².
    pub exitance: Exitance,
}

impl LitMesh {
    /// `B = M + ρ E` at vertex `i`.
    pub fn radiosity(&self, material: &Material, i: usize) -> Radiosity {
        Radiosity::leaving(self.exitance, material.reflectance, self.irradiance[i])
    }
}
