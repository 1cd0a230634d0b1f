//! The nodes of one face: where the solution gathers light, and the quadratic function between them.

use super::SolveFace;
use crate::mesh::{Inset, barycentric};
use crate::quantity::Irradiance;
use crate::visibility::Viewpoint;
use glam::DVec2;
use smallvec::SmallVec;
use std::ops::Range;

/// Values at the borders of faces are taken this share of the way to the middle of the element inside. A trim, a bevel or a gap of
/// a few millimetres there makes the light right at the edge another than that of the face, of which a whole element beside it
/// would have a share. From none to a thirtieth the fields of five scenes took more gathers to be as good.
const INSET_SHARE: f64 = 1.0 / 16.0;

/// How far inside the values at borders are taken for positions welded within `weld_distance`, metres.
pub(super) fn inset(weld_distance: f64) -> Inset {
    Inset::share(INSET_SHARE, weld_distance)
}

/// The nodes of one face.
pub(super) struct FaceNodes {
    /// Its nodes among all nodes.
    pub(super) range: Range<usize>,
    places: Places,
}

/// Where the nodes of a face are.
enum Places {
    /// Few, evenly spread: their mean holds for the whole face.
    Whole,
    /// At the sites of its mesh and at the midpoints of its elements' edges: quadratic in between.
    Quadratic {
        sites: Vec<u32>,
        middles: Vec<[u32; 3]>,
    },
    /// One for each of these elements of its own, frame coordinates: constant over it.
    Elements(Vec<[DVec2; 3]>),
}

impl FaceNodes {
    /// Numbers the nodes of `face` and appends their viewpoints.
    pub(super) fn new(face: &SolveFace, inset: Inset, views: &mut Vec<Viewpoint>) -> Self {
        let mesh = &face.mesh;
        let n = mesh.site_vertices.len();
        let first = views.len();
        if face.is_small {
            views.extend(face.spread_points().map(|p| face.view(p)));
            return Self {
                range: first..views.len(),
                places: Places::Whole,
            };
        }
        let places = mesh.places(inset).into_iter();
        views.extend(places.map(|place| face.view(place.point)));
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
                            middle = mesh.inset(e, middle, inset);
                        }
                        views.push(face.view(middle));
                    }
                }
            }
        }
        Self {
            range: first..views.len(),
            places: Places::Quadratic {
                sites: (0..n).map(|s| (first + s) as u32).collect(),
                middles,
            },
        }
    }

    /// Nodes from number `first`, one for each of the triangles `elements`; or for all of them together.
    pub(super) fn of_elements(elements: Vec<[DVec2; 3]>, is_one: bool, first: usize) -> Self {
        let (count, places) = match is_one {
            true => (1, Places::Whole),
            false => (elements.len(), Places::Elements(elements)),
        };
        Self {
            range: first..first + count,
            places,
        }
    }

    /// The nodes and weights that give the field at frame coordinates `p`.
    pub(super) fn weights(&self, face: &SolveFace, p: DVec2) -> SmallVec<[(u32, f64); 6]> {
        let first = self.range.start as u32;
        let (sites, middles) = match &self.places {
            Places::Whole => {
                let share = 1.0 / self.range.len() as f64;
                return self.range.clone().map(|i| (i as u32, share)).collect();
            }
            Places::Elements(elements) => {
                // Outside all of them the one that comes nearest.
                let depth = |t: &[DVec2; 3]| barycentric(*t, p).into_iter().fold(1.0, f64::min);
                let deepest = (0..elements.len())
                    .max_by(|&a, &b| depth(&elements[a]).total_cmp(&depth(&elements[b])));
                return deepest
                    .map(|e| (first + e as u32, 1.0))
                    .into_iter()
                    .collect();
            }
            Places::Quadratic { sites, middles } => (sites, middles),
        };
        let Some((e, b)) = face.locate(p) else {
            return SmallVec::new();
        };
        let sites = face.mesh.sites[e].map(|s| sites[s as usize]);
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

/// Values at all nodes, and what lies between.
#[derive(Clone, Copy)]
pub(super) struct NodalField<'t> {
    pub(super) nodes: &'t [FaceNodes],
    pub(super) values: &'t [Irradiance],
}

impl NodalField<'_> {
    /// The node at local site `s` of solve face `f`; none when all sites of the face share one node.
    pub(super) fn node_at_site(&self, f: usize, s: usize) -> Option<u32> {
        match &self.nodes[f].places {
            Places::Quadratic { sites, .. } => Some(sites[s]),
            Places::Elements(_) | Places::Whole => None,
        }
    }

    /// Mean of the nodes of solve face `f`, and what they tell of the variance over the face (mean of the channels).
    pub(super) fn mean_and_variance(&self, f: usize) -> (Irradiance, f64) {
        let values = &self.values[self.nodes[f].range.clone()];
        let mut sum = Irradiance::ZERO;
        for &v in values {
            sum += v;
        }
        let mean = sum * (1.0 / values.len() as f64);
        let squares: f64 = values.iter().map(|&v| (v - mean).0.mean_square()).sum();
        (mean, squares / (values.len() as f64 - 1.0).max(1.0))
    }

    /// The nodes at the midpoints of the edges of element `e` of solve face `f`; none when all sites of the face share one node.
    pub(super) fn nodes_at_middles(&self, f: usize, e: usize) -> Option<[u32; 3]> {
        match &self.nodes[f].places {
            Places::Quadratic { middles, .. } => Some(middles[e]),
            Places::Elements(_) | Places::Whole => None,
        }
    }

    /// Whether all sites of solve face `f` share one value.
    pub(super) fn is_uniform(&self, f: usize) -> bool {
        !matches!(self.nodes[f].places, Places::Quadratic { .. })
    }

    /// The greatest at the nodes that tell of frame coordinates `p` of `face`, which is solve face `f`: RMS of the channels, W/m².
    pub(super) fn greatest(&self, face: &SolveFace, f: usize, p: DVec2) -> f64 {
        let squares = self.nodes[f].weights(face, p).into_iter();
        let squares = squares.map(|(node, _)| self.values[node as usize].0.mean_square());
        squares.fold(0.0, f64::max).sqrt()
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
