//! A vertex as light sees it that passes: which directions through it leave a gap beside the faces that meet there.
//!
//! Seen along a ray each face that meets at the vertex fills a sector. Light grazes the vertex when some directions
//! around it are filled and others are not; where the sectors close the circle, the ray ends at the vertex.
//!
//! ```text
//!      grazed   \ ▒▒ face         closed   ▒▒│▒▒ two faces,
//!       here →   v▒▒▒                      ──v──  a third
//!               / ▒▒                       ▒▒▒▒▒
//! ```

use crate::scene::{FaceId, IdVec, Scene, VertexId};
use crate::visibility::{Blockers, Region};
use glam::DVec3;
use std::f64::consts::TAU;

/// One face at a vertex.
#[derive(Clone, Copy, Debug)]
struct Corner {
    normal: DVec3,
    /// Seen from the front the face fills the turn from `next` counter-clockwise to `previous`.
    next: DVec3,
    previous: DVec3,
}

/// The faces at every vertex.
pub(super) struct Corners {
    corners: IdVec<VertexId, Vec<Corner>>,
    /// The vertices that touch the inside of a face that does not end there.
    is_covered: IdVec<VertexId, bool>,
}

impl Corners {
    /// Collects the corners of all loops.
    pub(super) fn new(scene: &Scene, blockers: &Blockers) -> Self {
        let mut corners = IdVec::from(vec![Vec::new(); scene.vertices.len()]);
        let mut faces_at = IdVec::from(vec![Vec::new(); scene.vertices.len()]);
        for (id, face) in scene.faces.iter() {
            for points in &face.loops {
                let n = points.len();
                for (i, &v) in points.iter().enumerate() {
                    let to = |w: VertexId| scene.vertices[w] - scene.vertices[v];
                    corners[v].push(Corner {
                        normal: face.frame.n,
                        next: to(points[(i + 1) % n]),
                        previous: to(points[(i + n - 1) % n]),
                    });
                    faces_at[v].push(id);
                }
            }
        }
        let is_covered: Vec<bool> = scene
            .vertices
            .iter()
            .map(|(v, &p)| is_inside_another_face(scene, blockers, p, &faces_at[v]))
            .collect();
        Self {
            corners,
            is_covered: IdVec::from(is_covered),
        }
    }

    /// True when the vertex lies in the inside of a face: no ray passes it.
    pub(super) fn is_covered(&self, vertex: VertexId) -> bool {
        self.is_covered[vertex]
    }

    /// True when no face ends at the vertex.
    pub(super) fn is_unused(&self, vertex: VertexId) -> bool {
        self.corners[vertex].is_empty()
    }

    /// True when a ray that passes the vertex in this direction grazes the faces there: they leave a gap around it.
    pub(super) fn is_grazed(&self, vertex: VertexId, direction: DVec3) -> bool {
        let (right, up) = direction.normalize().any_orthonormal_pair();
        let angle = |d: DVec3| d.dot(up).atan2(d.dot(right));
        // The pair and the direction are right-handed: faces that face along the ray keep their turn.
        let mut sectors: Vec<(f64, f64)> = Vec::with_capacity(self.corners[vertex].len());
        for c in &self.corners[vertex] {
            let facing = c.normal.dot(direction);
            let (from, to) = match facing.partial_cmp(&0.0) {
                Some(std::cmp::Ordering::Greater) => (angle(c.next), angle(c.previous)),
                Some(std::cmp::Ordering::Less) => (angle(c.previous), angle(c.next)),
                // Edge-on it fills nothing.
                _ => continue,
            };
            if from <= to {
                sectors.push((from, to));
            } else {
                sectors.push((from, TAU));
                sectors.push((-TAU, to));
            }
        }
        if sectors.is_empty() {
            return false;
        }
        sectors.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        // Neighbours share an edge and thus the angle, bit by bit. Angles run from −π to π.
        let mut filled = -TAU;
        for &(from, to) in &sectors {
            let is_gap = from > filled && filled > -TAU;
            if is_gap {
                return true;
            }
            filled = filled.max(to);
        }
        !(filled >= TAU && sectors[0].0 <= -TAU)
    }

    /// False when no ray from the vertex towards the convex polygon `target` grazes the faces there.
    pub(super) fn may_be_grazed_towards(
        &self,
        vertex: VertexId,
        position: DVec3,
        target: &[DVec3],
    ) -> bool {
        // The faces' planes part the directions; where none parts the target, one direction speaks for all.
        let is_parted = self.corners[vertex].iter().any(|c| {
            let heights = || target.iter().map(|&p| c.normal.dot(p - position));
            heights().any(|h| h >= 0.0) && heights().any(|h| h <= 0.0)
        });
        let middle = target.iter().sum::<DVec3>() / target.len() as f64;
        is_parted || self.is_grazed(vertex, position - middle)
    }

    /// Where on the segment from `a` to `b` (0…1) the faces at a vertex are seen edge-on, sorted, with both ends.
    pub(super) fn changes(
        &self,
        vertex: VertexId,
        position: DVec3,
        [a, b]: [DVec3; 2],
    ) -> Vec<f64> {
        let mut at = vec![0.0, 1.0];
        for c in &self.corners[vertex] {
            let (da, db) = (c.normal.dot(a - position), c.normal.dot(b - position));
            if da * db < 0.0 {
                at.push(da / (da - db));
            }
        }
        at.sort_unstable_by(f64::total_cmp);
        at.dedup();
        at
    }
}

/// True when `p` lies within the weld distance of a face, farther than that from its outline, and the face is none of `own`.
fn is_inside_another_face(scene: &Scene, blockers: &Blockers, p: DVec3, own: &[FaceId]) -> bool {
    let tol = blockers.weld_distance();
    let region = Region {
        planes: [].into_iter().collect(),
        bounds: (p - DVec3::splat(tol), p + DVec3::splat(tol)),
    };
    let mut is_inside = false;
    blockers.query(&region, |i| {
        let part = blockers.part(i);
        if is_inside || own.contains(&part.face) || part.plane.distance(p).abs() > tol {
            return;
        }
        let face = &scene.faces[part.face];
        let q = face.frame.to_plane(p);
        is_inside = face.outline.contains(q) && face.outline.distance_to_outline(q) > tol;
    });
    is_inside
}
