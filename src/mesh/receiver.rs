//! The element mesh of one side of one face.

use super::domain::EdgeSource;
use super::{GridPoint, Inset};
use crate::scene::{EdgeId, VertexId};
use glam::DVec2;
use smallvec::SmallVec;

/// Where a mesh vertex comes from; equal origins are equal points, on every face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VertexOrigin {
    /// Inside the face.
    Inner,
    /// A vertex of the scene.
    Corner(VertexId),
    /// A point of an edge of the scene, `ends[0] + t (ends[1] − ends[0])`.
    OnEdge(EdgeId, f64),
}

/// Triangles along the lines of one side of one face.
///
/// Element `e` has corners `elements[e]` (vertices, counter-clockwise in the face's frame) and values at the sites
/// `sites[e]`: a vertex has one site, on contact lines and on the outline one for each sector of elements around it.
#[derive(Clone, Debug, Default)]
pub struct ReceiverMesh {
    /// Vertices on the face's grid.
    pub vertices: Vec<GridPoint>,
    /// The same in frame coordinates, metres.
    pub plane: Vec<DVec2>,
    /// Where each vertex comes from.
    pub origins: Vec<VertexOrigin>,
    /// Corners of each element.
    pub elements: Vec<[u32; 3]>,
    /// Value sites at these corners.
    pub sites: Vec<[u32; 3]>,
    /// Element across edge `k` (from corner `k` to corner `k + 1`).
    pub neighbours: Vec<[Option<u32>; 3]>,
    /// Index into `labels` for edge `k`, where it lies on a line.
    pub edges: Vec<[Option<u32>; 3]>,
    /// What the labelled edges lie on, most on one thing.
    pub labels: Vec<SmallVec<[EdgeSource; 2]>>,
    /// Vertex of each site.
    pub site_vertices: Vec<u32>,
    /// Where the value of each site is taken, frame coordinates, metres: at the vertex, or just inside the site's sector
    /// where the value is a one-sided limit.
    pub site_points: Vec<DVec2>,
    /// Whether a site's value is such a limit.
    pub is_limit: Vec<bool>,
}

/// Where the value of a site is taken.
pub(crate) struct Place {
    /// Frame coordinates, metres.
    pub(crate) point: DVec2,
    /// How far from the site the middle of the element is in which that lies; infinite where it is taken at the vertex.
    pub(crate) middle: f64,
}

impl ReceiverMesh {
    /// Gives back memory that was held for more elements: the meshes of hundreds of thousands of faces are of one or two.
    pub(super) fn compact(&mut self) {
        self.vertices.shrink_to_fit();
        self.plane.shrink_to_fit();
        self.origins.shrink_to_fit();
        self.elements.shrink_to_fit();
        self.sites.shrink_to_fit();
        self.neighbours.shrink_to_fit();
        self.edges.shrink_to_fit();
        self.labels.shrink_to_fit();
        self.site_vertices.shrink_to_fit();
        self.site_points.shrink_to_fit();
        self.is_limit.shrink_to_fit();
    }

    /// Corners of element `e` in frame coordinates, metres.
    pub fn corners(&self, e: usize) -> [DVec2; 3] {
        self.elements[e].map(|v| self.plane[v as usize])
    }

    /// Area of element `e`, m².
    pub fn area(&self, e: usize) -> f64 {
        let [a, b, c] = self.corners(e);
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Middle of element `e`, metres.
    pub fn centre(&self, e: usize) -> DVec2 {
        self.corners(e).iter().sum::<DVec2>() / 3.0
    }

    /// True when values may differ across edge `k` of element `e`.
    pub fn is_barrier(&self, e: usize, k: usize) -> bool {
        self.edges[e][k].is_some_and(|l| {
            self.labels[l as usize]
                .iter()
                .any(|s| !matches!(s, EdgeSource::Line(_)))
        })
    }

    /// `p` on the border of element `e`, moved into the element.
    pub fn inset(&self, e: usize, p: DVec2, inset: Inset) -> DVec2 {
        let d = self.centre(e) - p;
        let length = d.length();
        if length > 0.0 {
            p + d * (inset.step(length) / length)
        } else {
            p
        }
    }

    /// Replaces the diagonal of the quadrilateral of elements `e` and `f`, their edges `k` and `m`, by the other one.
    ///
    /// ```text
    ///        c                    c
    ///      ╱ e ╲                ╱ │ ╲
    ///    a ───── b     →      a e │ f b
    ///      ╲ f ╱                ╲ │ ╱
    ///        d                    d
    /// ```
    ///
    /// The quadrilateral must be strictly convex and its diagonal without label.
    pub(crate) fn flip(&mut self, e: usize, k: usize, f: usize, m: usize) {
        let (k1, k2, m1, m2) = ((k + 1) % 3, (k + 2) % 3, (m + 1) % 3, (m + 2) % 3);
        let corners = |of: &[[u32; 3]]| {
            let [a, b, c, d] = [of[e][k], of[e][k1], of[e][k2], of[f][m2]];
            [[a, d, c], [d, b, c]]
        };
        let (elements, sites) = (corners(&self.elements), corners(&self.sites));
        // Across a → d, c → a and d → b, b → c; the new diagonal has no label.
        let around = |of: &[[Option<u32>; 3]], both: [Option<u32>; 2]| {
            let [ad, ca, db, bc] = [of[f][m1], of[e][k2], of[f][m2], of[e][k1]];
            [[ad, both[1], ca], [db, bc, both[0]]]
        };
        let neighbours = around(&self.neighbours, [Some(e as u32), Some(f as u32)]);
        let edges = around(&self.edges, [None, None]);
        for (outer, from, to) in [(neighbours[0][0], f, e), (neighbours[1][1], e, f)] {
            if let Some(n) = outer {
                for back in &mut self.neighbours[n as usize] {
                    if *back == Some(from as u32) {
                        *back = Some(to as u32);
                    }
                }
            }
        }
        for (t, i) in [(e, 0), (f, 1)] {
            // The smallest corner first, as everywhere.
            let first = (0..3)
                .min_by_key(|&c| elements[i][c])
                .expect("three corners");
            let turn = |of: [u32; 3]| [0, 1, 2].map(|c| of[(c + first) % 3]);
            let turned = |of: [Option<u32>; 3]| [0, 1, 2].map(|c| of[(c + first) % 3]);
            self.elements[t] = turn(elements[i]);
            self.sites[t] = turn(sites[i]);
            self.neighbours[t] = turned(neighbours[i]);
            self.edges[t] = turned(edges[i]);
        }
    }

    /// Puts each site where its value is taken: on a barrier that is a one-sided limit.
    pub(super) fn place_sites(&mut self, inset: Inset) {
        let mut on_barrier = vec![false; self.vertices.len()];
        for (e, corners) in self.elements.iter().enumerate() {
            for k in 0..3 {
                if self.is_barrier(e, k) {
                    on_barrier[corners[k] as usize] = true;
                    on_barrier[corners[(k + 1) % 3] as usize] = true;
                }
            }
        }
        self.is_limit = self
            .site_vertices
            .iter()
            .map(|&v| on_barrier[v as usize])
            .collect();
        let places = self.places(inset);
        self.site_points = places.into_iter().map(|place| place.point).collect();
    }

    /// Where the values of all sites are taken: at their vertices, or inside the widest element of the sector.
    pub(crate) fn places(&self, inset: Inset) -> Vec<Place> {
        let mut widest: Vec<Option<(f64, usize)>> = vec![None; self.site_vertices.len()];
        for (e, sites) in self.sites.iter().enumerate() {
            let p = self.corners(e);
            for k in 0..3 {
                let angle = (p[(k + 1) % 3] - p[k])
                    .angle_to(p[(k + 2) % 3] - p[k])
                    .abs();
                let best = &mut widest[sites[k] as usize];
                if best.is_none_or(|(a, _)| angle > a) {
                    *best = Some((angle, e));
                }
            }
        }
        let place = |s: usize| {
            let p = self.plane[self.site_vertices[s] as usize];
            match widest[s] {
                Some((_, e)) if self.is_limit[s] => Place {
                    point: self.inset(e, p, inset),
                    middle: self.centre(e).distance(p),
                },
                _ => Place {
                    point: p,
                    middle: f64::INFINITY,
                },
            }
        };
        (0..self.site_vertices.len()).map(place).collect()
    }
}

/// Barycentric coordinates of `p` in the triangle `t`.
pub fn barycentric(t: [DVec2; 3], p: DVec2) -> [f64; 3] {
    let (u, v, w) = (t[1] - t[0], t[2] - t[0], p - t[0]);
    let area = u.perp_dot(v);
    let (b, c) = (w.perp_dot(v) / area, u.perp_dot(w) / area);
    [1.0 - b - c, b, c]
}
