//! What the world is: welded vertices, edges with their faces, maximal planar faces, emitters.
//!
//! A [`RawScene`] is what a file said; [`clean`] alone turns it into a [`Scene`], whose invariants the rest relies on.
//! Coordinates are metres relative to [`Scene::origin`], so that a scene far from the world's origin loses no digits.

mod adjacency;
mod clean;
mod ids;
mod invariants;
mod pattern;
mod raw;
mod size;

pub use clean::{CleanReport, CleanSettings, clean};
pub use ids::{EdgeId, EmitterId, FaceId, IdVec, VertexId};
pub use pattern::Pattern;
pub use raw::{Camera, Material, PunctualKind, PunctualLight, RawPolygon, RawScene};
pub(crate) use size::MINOR_SHARE;
pub use size::Size;

use crate::geom::{AffineMap, PlaneFrame, Polygon2};
use crate::quantity::{Radiance, Rgb};
use crate::texture::Texture;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// The cleaned world.
///
/// Invariants: ids are dense; no two vertices lie within the weld distance of each other; no vertex lies within half the
/// weld distance of the interior of an edge; each face is planar within the planarity tolerance, has positive area, and
/// its loops are simple and pass through every vertex that lies on them; every edge lists each face that runs along it.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name for messages: the file's path as the user typed it.
    pub source: String,
    /// World position of the local origin, metres: world = origin + local.
    pub origin: DVec3,
    /// Welded positions, metres, local.
    pub vertices: IdVec<VertexId, DVec3>,
    /// Edges between them.
    pub edges: IdVec<EdgeId, Edge>,
    /// Maximal planar faces.
    pub faces: IdVec<FaceId, Face>,
    /// Emitting sides of faces.
    pub emitters: IdVec<EmitterId, Emitter>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures of the materials.
    pub textures: Vec<Texture>,
    /// Object or node names.
    pub groups: Vec<String>,
    /// Cameras, in world coordinates.
    pub cameras: Vec<Camera>,
    /// Lights without a surface, local.
    pub lights: Vec<PunctualLight>,
    /// Below this distance two points are the same point, metres.
    pub weld_distance: f64,
    /// Length of the diagonal of the box around all vertices, metres.
    pub diagonal: f64,
}

/// An edge of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Its ends; the first has the lower id.
    pub ends: [VertexId; 2],
    /// Every face that runs along it.
    pub uses: Vec<EdgeUse>,
    /// Whether it only divides one surface: two faces run along it, facets of a curved one with one shading normal at each
    /// of its ends, or both in one plane. It is no crease, neither to the eye nor to the light.
    pub is_smooth: bool,
}

/// One face along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeUse {
    /// The face.
    pub face: FaceId,
    /// Whether the face's loop runs from `ends[0]` to `ends[1]`; its inside lies to the left, seen from its front.
    pub is_forward: bool,
}

/// A maximal planar face.
#[derive(Clone, Debug)]
pub struct Face {
    /// Its plane; `n` points to the front.
    pub frame: PlaneFrame,
    /// Vertices of each loop: the first is the outline, counter-clockwise seen from the front, the others are holes.
    pub loops: Vec<Vec<VertexId>>,
    /// The edge from each loop vertex to the next, in the same layout as `loops`.
    pub loop_edges: Vec<Vec<EdgeId>>,
    /// The loops in the coordinates of `frame`.
    pub outline: Polygon2,
    /// A triangulation without new vertices, each counter-clockwise seen from the front.
    pub triangles: Vec<[VertexId; 3]>,
    /// The face as convex pieces without new vertices, each counter-clockwise seen from the front.
    pub convex_parts: Vec<Vec<VertexId>>,
    /// Area, m².
    pub area: f64,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::groups`].
    pub group: u32,
    /// Texture coordinates at each point (local coordinates), where the material has a texture.
    pub uv: Option<AffineMap<2>>,
    /// The normal of the curved surface that the face stands for, before it is brought to unit length; none where the
    /// face is meant to be flat.
    pub shading: Option<AffineMap<3>>,
    /// Mean diffuse reflectance, 0…1 a channel: of the material, with the part of its texture that the face shows.
    pub reflectance: Rgb,
    /// The same place by place, where the texture shows other colours at other places.
    pub pattern: Option<Arc<Pattern>>,
    /// Mean emitted radiance, W/(m² sr), likewise.
    pub emission: Radiance,
}

impl Face {
    /// Whether it emits and reflects nothing: what falls on it is never seen.
    pub fn is_pure_emitter(&self) -> bool {
        !self.emission.0.is_black() && self.reflectance.is_black()
    }

    /// Unit normal by which the front is shaded at local point `p`: that of the curved surface where there is one.
    pub fn shading_normal(&self, p: DVec3) -> DVec3 {
        let curved = self
            .shading
            .and_then(|map| DVec3::from(map.at(p)).try_normalize());
        curved.unwrap_or(self.frame.n)
    }

    /// Texture coordinates at local point `p`, where the face has any.
    pub fn uv_at(&self, p: DVec3) -> Option<DVec2> {
        self.uv.map(|map| DVec2::from(map.at(p)))
    }
}

/// The two sides of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FaceSide {
    /// The side from which the outline is counter-clockwise.
    Front,
    /// The other one.
    Back,
}

impl FaceSide {
    /// +1 for the front, −1 for the back.
    pub fn sign(self) -> f64 {
        match self {
            Self::Front => 1.0,
            Self::Back => -1.0,
        }
    }
}

/// One emitting side of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emitter {
    /// The face.
    pub face: FaceId,
    /// The side that shines.
    pub side: FaceSide,
}

impl Scene {
    /// Material of a face.
    pub fn material_of(&self, face: FaceId) -> &Material {
        &self.materials[self.faces[face].material as usize]
    }

    /// Unit normal of a side of a face, pointing away from it.
    pub fn normal(&self, face: FaceId, side: FaceSide) -> DVec3 {
        self.faces[face].frame.n * side.sign()
    }

    /// True when the side reflects light, so that it has to be lit.
    pub fn receives(&self, face: FaceId, side: FaceSide) -> bool {
        side == FaceSide::Front || self.material_of(face).reflects_back
    }
}
