//! The result: meshes with light at their vertices, ready to be written or drawn.

use crate::quantity::{Exitance, Irradiance, Radiosity, Rgb};
use crate::scene::{Camera, Material};
use crate::texture::Texture;
use glam::{DVec2, DVec3};

/// A lit scene. Positions are metres relative to `origin`.
#[derive(Clone, Debug, Default)]
pub struct LitScene {
    /// World position of the local origin, metres.
    pub origin: DVec3,
    /// Materials of the source scene.
    pub materials: Vec<Material>,
    /// Textures that the materials name.
    pub textures: Vec<Texture>,
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
    /// Diffuse reflectance, 0…1 a channel: with a texture, its mean over the face.
    pub reflectance: Rgb,
    /// Vertex positions, metres, local. Vertices on D0 lines appear once a side.
    pub positions: Vec<DVec3>,
    /// Texture coordinates at each vertex; empty without a texture.
    pub uvs: Vec<DVec2>,
    /// Unit shading normal at each vertex; empty where it is `normal` everywhere.
    pub normals: Vec<DVec3>,
    /// Counter-clockwise seen from the lit side.
    pub triangles: Vec<[u32; 3]>,
    /// Irradiance at each vertex, W/m².
    pub irradiance: Vec<Irradiance>,
    /// Estimated error of the irradiance at each vertex, W/m²; empty unless it was asked for.
    pub errors: Vec<f64>,
    /// What this side emits, W/m².
    pub exitance: Exitance,
}

impl LitMesh {
    /// `B = M + ρ E` at vertex `i`.
    pub fn radiosity(&self, i: usize) -> Radiosity {
        Radiosity::leaving(self.exitance, self.reflectance, self.irradiance[i])
    }

    /// Unit shading normal at vertex `i`.
    pub fn normal_at(&self, i: usize) -> DVec3 {
        self.normals.get(i).copied().unwrap_or(self.normal)
    }
}
