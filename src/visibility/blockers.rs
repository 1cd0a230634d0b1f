//! The opaque world as convex polygons in a tree.

use super::screen::Screens;
use super::{BoxTree, RayCaster, Region};
use crate::geom::Plane;
use crate::scene::{EdgeId, FaceId, Scene, VertexId};
use glam::DVec3;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts the worlds of this process.
static NEXT_ID: AtomicU64 = AtomicU64::new(0);

/// One convex piece of a face.
#[derive(Clone, Debug)]
pub struct Part {
    /// The face it is a piece of.
    pub face: FaceId,
    /// Its plane, the normal towards the front of the face.
    pub plane: Plane,
    first: u32,
    count: u32,
}

type PartEdge = ([VertexId; 2], bool, u32);

/// Every opaque face of a scene as convex parts.
pub struct Blockers {
    /// No two have the same: what is remembered of one is not taken for another's.
    id: u64,
    parts: Vec<Part>,
    positions: Vec<DVec3>,
    vertices: Vec<VertexId>,
    /// The scene edge from each corner to the next, or none on a diagonal between two parts of one face.
    edges: Vec<Option<EdgeId>>,
    /// For each edge of a part its ends in ascending order, whether it runs from the first to the second, and the part;
    /// ascending.
    part_edges: Vec<PartEdge>,
    tree: BoxTree,
    /// The same as convex solids where they are such.
    pub(super) screens: Screens,
    rays: RayCaster,
    ray_owners: Vec<FaceId>,
    weld_distance: f64,
    roundoff: f64,
}

impl Blockers {
    /// Collects the convex parts of all faces.
    pub fn new(scene: &Scene) -> Self {
        let (mut parts, mut positions, mut vertices, mut edges) = (vec![], vec![], vec![], vec![]);
        let mut first_part = Vec::with_capacity(scene.faces.len());
        for (id, face) in scene.faces.iter() {
            first_part.push(parts.len() as u32);
            let mut rim: Vec<([VertexId; 2], EdgeId)> = face
                .loop_edges
                .iter()
                .flatten()
                .map(|&e| (scene.edges[e].ends, e))
                .collect();
            rim.sort_unstable();
            for part in &face.convex_parts {
                parts.push(Part {
                    face: id,
                    plane: face.frame.plane(),
                    first: u32::try_from(positions.len()).expect("fewer than 2³² corners"),
                    count: u32::try_from(part.len()).expect("fewer than 2³² corners"),
                });
                for (i, &a) in part.iter().enumerate() {
                    let b = part[(i + 1) % part.len()];
                    let ends = [a.min(b), a.max(b)];
                    positions.push(scene.vertices[a]);
                    vertices.push(a);
                    edges.push(
                        rim.binary_search_by_key(&ends, |r| r.0)
                            .ok()
                            .map(|k| rim[k].1),
                    );
                }
            }
        }
        let tree = BoxTree::new(parts.iter().map(|p: &Part| {
            let corners = &positions[p.first as usize..(p.first + p.count) as usize];
            corners
                .iter()
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &c| {
                    (lo.min(c), hi.max(c))
                })
        }));
        let mut part_edges = Vec::with_capacity(vertices.len());
        for (i, part) in (0u32..).zip(&parts) {
            let loop_ = &vertices[part.range()];
            for (k, &a) in loop_.iter().enumerate() {
                let b = loop_[(k + 1) % loop_.len()];
                part_edges.push(([a.min(b), a.max(b)], a < b, i));
            }
        }
        part_edges.sort_unstable();
        let (mut triangles, mut ray_owners) = (Vec::new(), Vec::new());
        for (id, face) in scene.faces.iter() {
            for t in &face.triangles {
                triangles.push(t.map(|v| scene.vertices[v]));
                ray_owners.push(id);
            }
        }
        // A plane's offset and a point's distance from it are each a dot product of three terms of at most the
        // scene's diagonal: fewer than 8 roundings.
        let roundoff = 8.0 * f64::EPSILON * scene.diagonal;
        Self {
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            screens: Screens::new(scene, &first_part, parts.len(), roundoff, |i| {
                let p: &Part = &parts[i as usize];
                &positions[p.range()]
            }),
            rays: RayCaster::new(&triangles),
            ray_owners,
            parts,
            positions,
            vertices,
            edges,
            part_edges,
            tree,
            weld_distance: scene.weld_distance,
            roundoff,
        }
    }

    pub(super) fn id(&self) -> u64 {
        self.id
    }

    /// All parts.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// One part.
    pub fn part(&self, index: u32) -> &Part {
        &self.parts[index as usize]
    }

    /// Corners of a part, counter-clockwise seen from the front of its face, metres.
    pub fn corners(&self, part: &Part) -> &[DVec3] {
        &self.positions[part.range()]
    }

    /// Vertices of a part.
    pub fn vertices(&self, part: &Part) -> &[VertexId] {
        &self.vertices[part.range()]
    }

    /// Scene edges from each corner of a part to the next; none where the part borders on another part of its face.
    pub fn edges(&self, part: &Part) -> &[Option<EdgeId>] {
        &self.edges[part.range()]
    }

    /// The parts on the other side of the edge from corner `i` of a part to the next, each with whether its front is turned to the
    /// back of that one's.
    pub(super) fn beside(&self, part: u32, i: usize) -> impl Iterator<Item = (u32, bool)> {
        let of = self.vertices(self.part(part));
        let (a, b) = (of[i], of[(i + 1) % of.len()]);
        let (ends, is_ascending) = ([a.min(b), a.max(b)], a < b);
        let first = self.part_edges.partition_point(|e| e.0 < ends);
        let same = self.part_edges[first..]
            .iter()
            .take_while(move |e| e.0 == ends);
        same.filter(move |e| e.2 != part)
            .map(move |e| (e.2, e.1 == is_ascending))
    }

    /// The part of `face` that the straight line between two points crosses.
    pub(super) fn part_across(&self, face: FaceId, [a, b]: [DVec3; 2]) -> Option<u32> {
        let mut parts = self.parts_of(face);
        let plane = self.part(parts.start).plane;
        let (from, to) = (plane.distance(a), plane.distance(b));
        let x = a.lerp(b, from / (from - to));
        parts.find(|&i| {
            let corners = self.corners(self.part(i));
            (0..corners.len()).all(|k| {
                let (p, q) = (corners[k], corners[(k + 1) % corners.len()]);
                plane.normal.dot((q - p).cross(x - p)) >= 0.0
            })
        })
    }

    /// Calls `visit` with the index of each part whose box meets `region`.
    pub fn query(&self, region: &Region, visit: impl FnMut(u32)) {
        self.tree.query(region, visit);
    }

    /// As [`Self::query`], until `visit` returns false.
    pub fn query_while(&self, region: &Region, visit: impl FnMut(u32) -> bool) {
        self.tree.query_while(region, visit);
    }

    /// Rays against all faces, as triangles.
    pub fn rays(&self) -> &RayCaster {
        &self.rays
    }

    /// The face that triangle `t` of [`Blockers::rays`] is a piece of.
    pub fn ray_owner(&self, t: u32) -> FaceId {
        self.ray_owners[t as usize]
    }

    /// Below this distance two points are the same point, metres.
    pub fn weld_distance(&self) -> f64 {
        self.weld_distance
    }

    /// Bound of the rounding error of a point's distance from a plane, metres.
    pub fn roundoff(&self) -> f64 {
        self.roundoff
    }
}

impl Part {
    fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}
