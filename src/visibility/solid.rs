//! Convex solids: a box hides what its outline hides, and that is one cone instead of one for each of its faces.
//!
//! A solid is a set of faces joined along edges that, with a flat lid over each of its openings, bounds a convex body: a
//! box, a leg of a table that has no top and no bottom, a prism. Seen from outside, and not through an opening, the
//! outline runs along the edges between faces that are turned to the viewpoint and faces (or lids) that are not.
//!
//! ```text
//!         ______
//!        /     /|       turned to the viewpoint: front, top, right side;
//!       /_____/ |       its outline is the hexagon around them
//!       |     | |
//!       |_____|/
//! ```

use crate::geom::Plane;
use crate::scene::{EdgeId, FaceId, Scene, VertexId};
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::HashMap;

/// A solid has at most so many faces: beyond that it is worth more to know which part of it may be in the way.
const MOST_FACES: usize = 256;

/// A convex body bounded by faces and by lids over its openings.
pub(super) struct Solid {
    /// The faces' planes, normals outwards.
    faces: Vec<Plane>,
    /// Planes of the openings, normals outwards.
    lids: Vec<Plane>,
    pub(super) corners: Vec<DVec3>,
    edges: Vec<SolidEdge>,
    /// The convex parts that its faces are, in the order of `faces`.
    pub(super) parts: Vec<u32>,
}

/// An edge from one corner to another, counter-clockwise around the face `left` seen from outside.
struct SolidEdge {
    ends: [u32; 2],
    left: u32,
    /// The other face; none at an opening.
    right: Option<u32>,
}

/// Where a viewpoint stands to a solid.
pub(super) enum Stance {
    /// Outside; the outline (corners, counter-clockwise as seen from there) has been appended.
    Outside,
    /// Inside, on its surface, or in front of an opening.
    Elsewhere,
}

/// All solids of `scene` with more than one face; `first_part` is the number of the first convex part of each face.
pub(super) fn solids(scene: &Scene, first_part: &[u32], roundoff: f64) -> Vec<Solid> {
    let mut is_taken = vec![false; scene.faces.len()];
    let mut found = Vec::new();
    for face in scene.faces.ids() {
        if is_taken[face.0 as usize] {
            continue;
        }
        let joined = joined_faces(scene, face, &mut is_taken);
        if (2..=MOST_FACES).contains(&joined.len())
            && let Some(solid) = Solid::new(scene, &joined, first_part, roundoff)
        {
            found.push(solid);
        }
    }
    found
}

/// The faces that hang together with `first` along edges of exactly two faces, ascending.
fn joined_faces(scene: &Scene, first: FaceId, is_taken: &mut [bool]) -> Vec<FaceId> {
    is_taken[first.0 as usize] = true;
    let mut joined = vec![first];
    let mut next = 0;
    while let Some(&face) = joined.get(next) {
        next += 1;
        for &edge in scene.faces[face].loop_edges.iter().flatten() {
            if let [a, b] = scene.edges[edge].uses.as_slice() {
                for face in [a.face, b.face] {
                    if !is_taken[face.0 as usize] {
                        is_taken[face.0 as usize] = true;
                        joined.push(face);
                    }
                }
            }
        }
    }
    joined.sort_unstable();
    joined
}

impl Solid {
    /// None when the faces do not bound a convex body, or when their fronts look into it: such a room is seen from inside.
    fn new(scene: &Scene, joined: &[FaceId], first_part: &[u32], roundoff: f64) -> Option<Self> {
        let vertices = vertices_of(scene, joined);
        let corners: Vec<DVec3> = vertices.iter().map(|&v| scene.vertices[v]).collect();
        let mut solid = Self {
            faces: Vec::with_capacity(joined.len()),
            lids: Vec::new(),
            corners,
            edges: Vec::new(),
            parts: joined.iter().map(|f| first_part[f.0 as usize]).collect(),
        };
        let mut turned = 0;
        for &face in joined {
            let f = &scene.faces[face];
            if f.loops.len() != 1 || f.convex_parts.len() != 1 {
                return None;
            }
            let own = &f.loops[0];
            let others = || {
                let both = vertices.iter().zip(&solid.corners);
                both.filter(|(v, _)| !own.contains(v)).map(|(_, c)| *c)
            };
            let plane = f.frame.plane();
            let (mut lowest, mut highest) = (0.0_f64, 0.0_f64);
            for c in others() {
                lowest = lowest.min(plane.distance(c));
                highest = highest.max(plane.distance(c));
            }
            // All of the rest lies on one side, and not just in the plane itself.
            solid
                .faces
                .push(match (lowest < -roundoff, highest > roundoff) {
                    (true, false) => plane,
                    (false, true) => {
                        turned += 1;
                        Plane {
                            normal: -plane.normal,
                            offset: -plane.offset,
                        }
                    }
                    _ => return None,
                });
        }
        if turned == joined.len() {
            return None;
        }
        let rims = solid.take_edges(scene, joined, &vertices)?;
        for rim in &rims {
            let lid = solid.lid(rim, scene.weld_distance)?;
            solid.lids.push(lid);
        }
        Some(solid)
    }

    /// Fills in the edges; returns the loops of those at openings, each counter-clockwise seen from inside.
    fn take_edges(
        &mut self,
        scene: &Scene,
        joined: &[FaceId],
        vertices: &[VertexId],
    ) -> Option<Vec<Vec<u32>>> {
        let mut of_edge: HashMap<EdgeId, usize> = HashMap::new();
        for (i, &face) in joined.iter().enumerate() {
            let f = &scene.faces[face];
            let is_turned = f.frame.n.dot(self.faces[i].normal) < 0.0;
            let own = &f.loops[0];
            for (k, &edge) in f.loop_edges[0].iter().enumerate() {
                if let Some(&e) = of_edge.get(&edge) {
                    // The second face along it; a third would make it something else than a surface.
                    let known: &mut SolidEdge = &mut self.edges[e];
                    if known.right.is_some() {
                        return None;
                    }
                    known.right = Some(i as u32);
                    continue;
                }
                let ends = [own[k], own[(k + 1) % own.len()]];
                let mut ends = ends.map(|v| {
                    vertices
                        .binary_search(&v)
                        .expect("all vertices of the faces are listed") as u32
                });
                if is_turned {
                    ends.reverse();
                }
                of_edge.insert(edge, self.edges.len());
                self.edges.push(SolidEdge {
                    ends,
                    left: i as u32,
                    right: None,
                });
            }
        }
        let open = self.edges.iter().filter(|e| e.right.is_none());
        loops(open.map(|e| e.ends), self.corners.len())
    }

    /// The lid over an opening; none when it is not flat to `tolerance` (metres) or the body not convex there.
    fn lid(&self, rim: &[u32], tolerance: f64) -> Option<Plane> {
        let corner = |k: usize| self.corners[rim[k % rim.len()] as usize];
        let middle = (0..rim.len()).map(corner).sum::<DVec3>() / rim.len() as f64;
        // The faces turn counter-clockwise around the outside, hence their free edges clockwise around the lid's.
        let area: DVec3 = (0..rim.len())
            .map(|k| (corner(k + 1) - middle).cross(corner(k) - middle))
            .sum();
        let plane = Plane::new(middle, area.try_normalize()?);
        let is_flat = (0..rim.len()).all(|k| plane.distance(corner(k)).abs() <= tolerance);
        let is_convex = self.corners.iter().all(|&c| plane.distance(c) <= tolerance);
        (is_flat && is_convex).then_some(plane)
    }

    /// Whether face number `k` is turned to `eye`.
    pub(super) fn is_front(&self, k: usize, eye: DVec3, roundoff: f64) -> bool {
        self.faces[k].distance(eye) > roundoff
    }

    /// Appends the outline as seen from `eye`. `roundoff` is how far in front of a face's plane a point must lie to be in
    /// front of it; points within `tolerance` of an opening's plane lie in it (metres).
    pub(super) fn outline(
        &self,
        eye: DVec3,
        roundoff: f64,
        tolerance: f64,
        out: &mut SmallVec<[DVec3; 8]>,
    ) -> Stance {
        if self.lids.iter().any(|l| l.distance(eye) > tolerance) {
            return Stance::Elsewhere;
        }
        let is_front: SmallVec<[bool; 16]> = self
            .faces
            .iter()
            .map(|p| p.distance(eye) > roundoff)
            .collect();
        if !is_front.contains(&true) {
            return Stance::Elsewhere;
        }
        let mut next: SmallVec<[u32; 32]> = SmallVec::from_elem(u32::MAX, self.corners.len());
        let (mut first, mut count) = (None, 0);
        for edge in &self.edges {
            let left = is_front[edge.left as usize];
            let right = edge.right.is_some_and(|r| is_front[r as usize]);
            if left == right {
                continue;
            }
            let [mut a, mut b] = edge.ends;
            if right {
                (a, b) = (b, a);
            }
            if next[a as usize] != u32::MAX {
                return Stance::Elsewhere;
            }
            next[a as usize] = b;
            first.get_or_insert(a);
            count += 1;
        }
        let Some(first) = first else {
            return Stance::Elsewhere;
        };
        let (mut at, mut walked) = (first, 0);
        while walked < count {
            out.push(self.corners[at as usize]);
            at = next[at as usize];
            walked += 1;
            if at == first || at == u32::MAX {
                break;
            }
        }
        // Rounding may have torn it where faces are seen edge-on.
        if at == first && walked == count && count >= 3 {
            Stance::Outside
        } else {
            out.clear();
            Stance::Elsewhere
        }
    }
}

fn vertices_of(scene: &Scene, faces: &[FaceId]) -> Vec<VertexId> {
    let mut vertices: Vec<VertexId> = faces
        .iter()
        .flat_map(|&f| scene.faces[f].loops.iter().flatten().copied())
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Joins directed edges to closed loops; none when they do not form such.
fn loops(edges: impl Iterator<Item = [u32; 2]>, corners: usize) -> Option<Vec<Vec<u32>>> {
    let mut next = vec![u32::MAX; corners];
    let mut left = 0;
    for [a, b] in edges {
        if next[a as usize] != u32::MAX {
            return None;
        }
        next[a as usize] = b;
        left += 1;
    }
    let mut found = Vec::new();
    for first in 0..corners {
        let mut rim = Vec::new();
        let mut at = first as u32;
        while next[at as usize] != u32::MAX {
            rim.push(at);
            at = std::mem::replace(&mut next[at as usize], u32::MAX);
            left -= 1;
        }
        if !rim.is_empty() {
            if at != first as u32 {
                return None;
            }
            found.push(rim);
        }
    }
    (left == 0).then_some(found)
}

#[cfg(test)]
mod tests;
