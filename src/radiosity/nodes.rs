//! The nodes of one face: where the solution gathers light, and the quadratic function between them.

use super::SolveFace;
use crate::quantity::Irradiance;
use crate::visibility::Viewpoint;
use glam::DVec2;
use smallvec::{SmallVec, smallvec};
use std::ops::Range;

/// The nodes of one face.
pub(super) struct FaceNodes {
    /// Its nodes among all nodes.
    pub(super) range: Range<usize>,
    /// For each site of its mesh, the node there.
    pub(super) sites: Vec<u32>,
    /// For each element the nodes at its edges' midpoints; none when the whole face has one node.
    pub(super) middles: Option<Vec<[u32; 3]>>,
}

impl FaceNodes {
    /// Numbers the nodes of `face` and appends their viewpoints.
    pub(super) fn new(face: &SolveFace, weld_distance: f64, views: &mut Vec<Viewpoint>) -> Self {
        let mesh = &face.mesh;
        let n = mesh.site_vertices.len();
        let first = views.len();
        if face.is_small {
            views.push(Viewpoint::new(face.middle_point, face.domain.normal));
            return Self {
                range: first..first + 1,
                sites: vec![first as u32; n],
                middles: None,
            };
        }
        views.extend((0..n).map(|s| face.site_view(s)));
        let mut middles = vec![[0; 3]; mesh.elements.len()];
        for e in 0..mesh.elements.len() {
            for k in 0..3 {
                // An edge between two elements has one midpoint; on a contact line each side has its own.
                let other = mesh.neighbours[e][k].filter(|_| !mesh.is_barrier(e, k));
                match other {
                    Some(o) if (o as usize) < e => {
                        let back = (0..3)
                            .find(|&j| mesh.neighbours[o as usize][j] == Some(e as u32))
                            .expect("neighbours are mutual");
                        middles[e][k] = middles[o as usize][back];
                    }
                    _ => {
                        middles[e][k] = views.len() as u32;
                        let p = mesh.corners(e);
                        let mut middle = p[k].midpoint(p[(k + 1) % 3]);
                        if mesh.is_barrier(e, k) {
                            middle = mesh.inset(e, middle, weld_distance);
                        }
                        views.push(face.view(middle));
                    }
                }
            }
        }
        Self {
            range: first..views.len(),
            sites: (0..n).map(|s| (first + s) as u32).collect(),
            middles: Some(middles),
        }
    }

    /// The nodes and weights that give the quadratic field at frame coordinates `p`.
    pub(super) fn weights(&self, face: &SolveFace, p: DVec2) -> SmallVec<[(u32, f64); 6]> {
        let Some((e, b)) = face.locate(p) else {
            return SmallVec::new();
        };
        let sites = face.mesh.sites[e].map(|s| self.sites[s as usize]);
        let Some(middles) = &self.middles else {
            return smallvec![(sites[0], 1.0)];
        };
        let mut weights = SmallVec::new();
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            // λ (2λ − 1) at a corner, 4 λ λ' at a midpoint.
            weights.push((sites[k], b[k] * (b[k] - b[i] - b[j])));
            weights.push((middles[e][k], 4.0 * b[k] * b[i]));
        }
        weights
    }
}

/// Values at all nodes, quadratic in between.
#[derive(Clone, Copy)]
pub(super) struct NodalField<'t> {
    pub(super) nodes: &'t [FaceNodes],
    pub(super) values: &'t [Irradiance],
}

impl NodalField<'_> {
    /// At local site `s` of solve face `f`.
    pub(super) fn at_site(&self, f: usize, s: usize) -> Irradiance {
        self.values[self.nodes[f].sites[s] as usize]
    }

    /// At the midpoints of the edges of element `e` of solve face `f`; none when all sites of the face share one node.
    pub(super) fn at_middles(&self, f: usize, e: usize) -> Option<[Irradiance; 3]> {
        let middles = self.nodes[f].middles.as_ref()?;
        Some(middles[e].map(|r| self.values[r as usize]))
    }

    /// At frame coordinates `p` of `face`, which is solve face `f`.
    pub(super) fn at(&self, face: &SolveFace, f: usize, p: DVec2) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for (node, weight) in self.nodes[f].weights(face, p) {
            sum += self.values[node as usize] * weight;
        }
        sum
    }
}
