//! The opaque world as convex polygons in a tree.

use super::screen::Screens;
use super::{BoxTree, RayCaster, Region};
use crate::geom::{Plane, bounds};
use crate::scene::{EdgeId, FaceId, Scene, VertexId};
use glam::DVec3;
use std::ops::Range;
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

/// An edge of a part.
#[derive(Clone, Copy)]
struct PartEdge {
    part: u32,
    /// Which of its corners it starts from.
    corner: u32,
}

/// Every opaque face of a scene as convex parts.
pub struct Blockers {
    /// No two have the same: what is remembered of one is not taken for another's.
    id: u64,
    parts: Vec<Part>,
    /// The first part of each face, and the number of all parts.
    first_part: Vec<u32>,
    positions: Vec<DVec3>,
    vertices: Vec<VertexId>,
    /// The scene edge from each corner to the next, or none on a diagonal between two parts of one face.
    edges: Vec<Option<EdgeId>>,
    /// Each edge of a part, by the number of the corner that it starts from; those with the same ends together.
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
        let mut first_part = Vec::with_capacity(scene.faces.len() + 1);
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
        first_part.push(parts.len() as u32);
        let tree = BoxTree::new(parts.iter().map(|p: &Part| {
            let corners = &positions[p.first as usize..(p.first + p.count) as usize];
            bounds(corners.iter().copied())
        }));
        let mut part_edges: Vec<PartEdge> = (0u32..)
            .zip(&parts)
            .flat_map(|(part, p)| (0..p.count).map(move |corner| PartEdge { part, corner }))
            .collect();
        part_edges.sort_unstable_by_key(|&e| {
            let [a, b] = ends_of(&vertices[parts[e.part as usize].range()], e.corner as usize);
            ([a.min(b), a.max(b)], e.part, e.corner)
        });
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
            first_part,
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

    /// Indices of the parts of a face.
    pub(super) fn parts_of(&self, face: FaceId) -> Range<u32> {
        let face = face.0 as usize;
        self.first_part[face]..self.first_part[face + 1]
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
        let ends_of = |e: &PartEdge| ends_of(self.vertices(self.part(e.part)), e.corner as usize);
        let sorted = |[a, b]: [VertexId; 2]| [a.min(b), a.max(b)];
        let own = ends_of(&PartEdge {
            part,
            corner: i as u32,
        });
        let first = self
            .part_edges
            .partition_point(|e| sorted(ends_of(e)) < sorted(own));
        let rest = self.part_edges[first..].iter();
        rest.map(move |e| (e.part, ends_of(e)))
            .take_while(move |&(_, ends)| sorted(ends) == sorted(own))
            .filter(move |&(other, _)| other != part)
            .map(move |(other, ends)| (other, ends == own))
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

    /// True when the boxes of more than `most` parts meet `region`.
    pub fn are_more_than(&self, most: usize, region: &Region) -> bool {
        let mut count = 0;
        if most < self.parts.len() {
            self.query_while(region, |_| {
                count += 1;
                count <= most
            });
        }
        count > most
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

/// The ends of the edge from corner `i` of a part with these vertices to the next.
fn ends_of(part: &[VertexId], i: usize) -> [VertexId; 2] {
    [part[i], part[(i + 1) % part.len()]]
}

impl Part {
    fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}
