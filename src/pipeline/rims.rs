//! Where surfaces hang closely over others: along the projection of their rims the indirect light breaks off within about
//! their distance, which points further apart than that would not see.
//!
//! ```text
//!      ───────lamp───────
//!      │ distance       │      on the ceiling above: dark between the
//!   ───┴────ceiling─────┴───   projected rims, lit outside of them
//! ```

use super::indirect::Rooms;
use crate::scene::{Edge, FaceId, FaceSide};
use glam::DVec3;
use std::collections::BTreeMap;

/// A surface nearer than this share of the solve mesh's spacing is close: from farther away the mesh can follow the light.
const CLOSE_SHARE: f64 = 0.25;

/// Shorter rims than this share of the spacing are left to the refinement of the field.
const LONG_SHARE: f64 = 0.5;

/// A surface that is seen from the rim at more than 60° from its normal is not under it.
const LEAST_COSINE: f64 = 0.5;

/// A rim, its ends in space, metres.
pub(super) type Rim = [DVec3; 2];

impl Rooms<'_> {
    /// For each side the rims that hang closely over it, on a solve mesh with points `spacing` metres apart.
    pub(super) fn rims(&self, spacing: f64) -> BTreeMap<(FaceId, FaceSide), Vec<Rim>> {
        let scene = self.scene;
        let mut found: BTreeMap<_, Vec<Rim>> = BTreeMap::new();
        for edge in scene.edges.as_slice().iter().filter(|e| !e.is_smooth) {
            let ends = edge.ends.map(|v| scene.vertices[v]);
            if ends[0].distance(ends[1]) < LONG_SHARE * spacing {
                continue;
            }
            for key in self.under(edge, ends[0].midpoint(ends[1]), CLOSE_SHARE * spacing) {
                let rims = found.entry(key).or_default();
                if !rims.contains(&ends) {
                    rims.push(ends);
                }
            }
        }
        found
    }

    /// The sides within `reach` of the `middle` of an edge, along the normals of its faces.
    fn under(
        &self,
        edge: &Edge,
        middle: DVec3,
        reach: f64,
    ) -> impl Iterator<Item = (FaceId, FaceSide)> + '_ {
        let scene = self.scene;
        let own: Vec<FaceId> = edge.uses.iter().map(|u| u.face).collect();
        let normals: Vec<DVec3> = own.iter().map(|&f| scene.faces[f].frame.n).collect();
        normals
            .into_iter()
            .flat_map(|n| [n, -n])
            .filter_map(move |direction| {
                let rays = self.blockers.rays();
                let hit = rays.nearest_where(middle, direction, 0.0, reach, |h| {
                    let face = self.blockers.ray_owner(h.triangle);
                    let plane = scene.faces[face].frame.plane();
                    // What the edge touches is no rim over it.
                    !own.contains(&face) && plane.distance(middle).abs() > scene.weld_distance
                })?;
                let face = self.blockers.ray_owner(hit.triangle);
                let side = match hit.is_front {
                    true => FaceSide::Front,
                    false => FaceSide::Back,
                };
                let cosine = scene.faces[face].frame.n.dot(direction).abs();
                (cosine >= LEAST_COSINE).then_some((face, side))
            })
    }
}
