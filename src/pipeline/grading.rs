//! Along which edges the solution needs a finer mesh: concave ones that light from the other face crosses.
//!
//! ```text
//!      g │  α        On f, at the edge, g fills (1 + cos α)/2 of the sky, and the light that it sends
//!        │           from there goes like r^γ. Where that light is less than the error asked for,
//!        └──── f     an even mesh will do.
//! ```

use super::guess::Guess;
use super::indirect::Rooms;
use crate::direct::DirectLight;
use crate::mesh::FaceDomain;
use crate::scene::{EdgeId, FaceId, FaceSide};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;
use std::sync::Arc;

/// Directions of two faces that are parallel but for round-off have a sine of a few roundings.
const FLAT_SINE: f64 = 16.0 * f64::EPSILON;

/// The light is looked at in the middles of so many equal parts of an edge.
const STATIONS: u32 = 3;

/// A viewpoint beside an edge stands so many weld distances from it.
const BESIDE_IN_WELD_DISTANCES: f64 = 4.0;

/// A side of another face, in front of the one at hand, along their common edge.
struct Neighbour {
    face: FaceId,
    side: FaceSide,
    /// Its share of the sky at the edge, 0…1.
    share: f64,
    /// From the edge into the face, unit.
    inwards: DVec3,
}

impl Rooms<'_> {
    /// Whether more than `permitted` (W/m², largest channel) comes from the other faces along `edge` at that edge.
    pub(super) fn is_edge_lit(
        &self,
        domain: &FaceDomain,
        edge: EdgeId,
        direct: &DirectLight,
        guess: Guess,
        permitted: f64,
    ) -> bool {
        let scene = self.scene;
        let ends = scene.edges[edge].ends.map(|v| scene.vertices[v]);
        let mut scratch = Scratch::default();
        self.neighbours(domain, edge).into_iter().any(|g| {
            let sent = scene.faces[g.face].reflectance.0.max_element() * g.share;
            let normal = scene.normal(g.face, g.side);
            let beside = g.inwards * (BESIDE_IN_WELD_DISTANCES * scene.weld_distance);
            sent * guess.indirect > permitted
                || (0..STATIONS).any(|i| {
                    let t = (f64::from(i) + 0.5) / f64::from(STATIONS);
                    let view = Viewpoint::new(ends[0].lerp(ends[1], t) + beside, normal);
                    let arriving = direct.irradiance(&view, &mut scratch).0.0.max_element();
                    sent * (arriving + guess.indirect) > permitted
                })
        })
    }

    /// The lit sides that stand in front of `domain` along `edge`. Edges inside of a curved surface have none.
    fn neighbours(&self, domain: &FaceDomain, edge: EdgeId) -> Vec<Neighbour> {
        let scene = self.scene;
        let edge = &scene.edges[edge];
        let along =
            (scene.vertices[edge.ends[1]] - scene.vertices[edge.ends[0]]).normalize_or_zero();
        // A face lies to the left of its loop, seen from its front.
        let inwards = |face: FaceId, is_forward: bool| {
            let sign = if is_forward { 1.0 } else { -1.0 };
            scene.faces[face].frame.n.cross(along) * sign
        };
        let Some(own) = edge.uses.iter().find(|u| u.face == domain.face) else {
            return Vec::new();
        };
        let own = inwards(own.face, own.is_forward);
        let others = edge.uses.iter().filter(|u| u.face != domain.face);
        let others = others.filter(|_| !edge.is_smooth).map(|u| {
            let into = inwards(u.face, u.is_forward);
            let is_front = scene.faces[u.face].frame.n.dot(own) > 0.0;
            Neighbour {
                face: u.face,
                side: if is_front {
                    FaceSide::Front
                } else {
                    FaceSide::Back
                },
                share: 0.5 * (1.0 + own.dot(into)),
                inwards: into,
            }
        });
        others
            .filter(|g| domain.normal.dot(g.inwards) > FLAT_SINE)
            .filter(|g| {
                let key = |d: &Arc<FaceDomain>| (d.face, d.side);
                let found = self.domains.binary_search_by_key(&(g.face, g.side), key);
                found.is_ok()
            })
            .collect()
    }
}
