//! Elements that are off by too much: meshed anew with their long edges halved, and nothing gathered twice but for
//! borders, where what was taken beside a large element may lie in the middle of a small one.

use super::super::SolveFace;
use super::super::locator::Locator;
use super::{FieldFace, Gathered, Inherited, Knowledge};
use crate::mesh::{GridPoint, Inset, MeshError, ReceiverMesh};
use crate::quantity::Irradiance;
use glam::DVec2;
use std::collections::HashMap;

/// Edges shorter than this share of the longest one of an element stay whole when it is divided (Rivara 1984 halves the longest
/// alone): in a strip light varies along it, and small steps buy what is needed and no more. When all edges were halved, Cornell
/// boxes and blinds took 1.1 to 1.4 times as many gathers to be as good.
const LONG_SHARE: f64 = 0.8;

/// An element whose longest edge is shorter than this many pixels is not divided.
const SMALLEST_EDGE_PX: f64 = 64.0;

impl Inherited {
    /// With this value at the middle of edge `k`.
    fn with(mut self, k: usize, value: Irradiance) -> Self {
        self.middles[k] = value;
        self
    }
}

/// The vertices of element `e`.
fn vertices(mesh: &ReceiverMesh, e: usize) -> [GridPoint; 3] {
    let corners: [u32; 3] = mesh.elements[e];
    corners.map(|v| mesh.vertices[v as usize])
}

impl FieldFace {
    /// Meshes anew with the edges of the given elements (ascending) halved.
    pub(super) fn divide(
        &mut self,
        face: &SolveFace,
        elements: &[usize],
        inset: Inset,
        ask: &mut impl FnMut(DVec2) -> Gathered,
    ) -> Result<(), MeshError> {
        if !self.halve_edges(face, elements) {
            return Ok(());
        }
        let mesh = face.domain.mesh(&[], &self.vertices)?;
        let old: HashMap<[GridPoint; 3], Knowledge> = (0..self.known.len())
            .map(|e| (vertices(&self.mesh, e), self.known[e]))
            .collect();
        let heirs = self.heirs(&mesh, &old, inset);
        let known: Vec<Knowledge> = (0..mesh.elements.len())
            .map(|e| {
                let same = old.get(&vertices(&mesh, e)).copied();
                same.unwrap_or_else(|| self.foreknown(&mesh, e, heirs[e], inset))
            })
            .collect();
        let places = mesh.places(inset);
        let kept: Vec<Option<u32>> = places
            .iter()
            .enumerate()
            .map(|(s, place)| {
                let v = mesh.site_vertices[s] as usize;
                let g = mesh.vertices[v];
                let known = self.known_point(place.point, (2 * g.x, 2 * g.y), mesh.is_limit[s])?;
                // What was taken in the middle of what is now an element says nothing of its border.
                let step = self.points[known as usize].place.distance(mesh.plane[v]);
                inset.accepts(step, place.middle).then_some(known)
            })
            .collect();
        self.locator = Locator::new(&mesh);
        self.mesh = mesh;
        self.known = known;
        self.sites = kept
            .into_iter()
            .zip(&places)
            .enumerate()
            .map(|(s, (kept, place))| kept.unwrap_or_else(|| self.fill_site(s, place.point, ask)))
            .collect();
        Ok(())
    }

    /// Puts vertices into the middles of the edges of `elements`; tells whether there was any to put.
    fn halve_edges(&mut self, face: &SolveFace, elements: &[usize]) -> bool {
        let grid = &face.domain.grid;
        if self.vertices.is_empty() {
            self.vertices.clone_from(&self.mesh.vertices);
        }
        let before = self.vertices.len();
        for &e in elements {
            let p = self.mesh.corners(e);
            let length = |k: usize| p[k].distance(p[(k + 1) % 3]);
            let longest = length(0).max(length(1)).max(length(2));
            let shortest = (LONG_SHARE * longest).max(SMALLEST_EDGE_PX * grid.pixel_size());
            for k in 0..3 {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                if length(k) > shortest {
                    let g = grid.snap(a.midpoint(b));
                    // Rounded to the grid it is, for all that matters, the point whose value is known.
                    if let Some(&point) = self.gathered.get(&self.key(e, k)) {
                        self.gathered.insert((2 * g.x, 2 * g.y), point);
                    }
                    self.vertices.push(g);
                }
            }
        }
        self.vertices.sort_unstable();
        self.vertices.dedup();
        self.vertices.len() > before
    }

    /// What element `e` of a finer mesh starts from.
    fn foreknown(
        &self,
        finer: &ReceiverMesh,
        e: usize,
        inherited: Option<Inherited>,
        inset: Inset,
    ) -> Knowledge {
        let [a, b, c] = vertices(finer, e);
        let p = finer.corners(e);
        let middle = |k: usize, a: GridPoint, b: GridPoint| {
            let inside = finer.inset(e, p[k].midpoint(p[(k + 1) % 3]), inset);
            self.known_point(inside, (a.x + b.x, a.y + b.y), finer.is_barrier(e, k))
        };
        let mut new = Knowledge {
            middles: [middle(0, a, b), middle(1, b, c), middle(2, c, a)],
            centre: None,
            inherited,
        };
        new.settle();
        new
    }

    /// The point at a vertex or edge midpoint with doubled grid coordinates `key`, if it has been gathered. On a border that
    /// of the element which holds `inside`: it tells the sides apart.
    fn known_point(&self, inside: DVec2, key: (i64, i64), is_on_border: bool) -> Option<u32> {
        if !is_on_border {
            return self.gathered.get(&key).copied();
        }
        let (e, _) = self.locator.locate(&self.mesh, inside)?;
        // A midpoint that became a vertex has been rounded to the grid.
        let is_it = |(x, y): (i64, i64)| (x - key.0).abs() <= 1 && (y - key.1).abs() <= 1;
        (0..3).find_map(|k| {
            let site = self.mesh.sites[e][k] as usize;
            if is_it(self.site_key(site)) {
                return Some(self.sites[site]);
            }
            self.known[e].middles[k].filter(|_| is_it(self.key(e, k)))
        })
    }

    /// What the elements of a finer mesh inherit, but for the `old` ones that are still there.
    fn heirs(
        &self,
        finer: &ReceiverMesh,
        old: &HashMap<[GridPoint; 3], Knowledge>,
        inset: Inset,
    ) -> Vec<Option<Inherited>> {
        let mut heirs: Vec<Option<Inherited>> = (0..finer.elements.len())
            .map(|e| match old.contains_key(&vertices(finer, e)) {
                true => None,
                false => self.bequeath(finer, e, inset),
            })
            .collect();
        join(&mut heirs, finer);
        heirs
    }

    /// What this mesh knows of element `e` of a finer one, where it interpolates quadratically. As long as nothing is gathered
    /// there the new element shows what the old ones did, and is as far off.
    fn bequeath(&self, finer: &ReceiverMesh, e: usize, inset: Inset) -> Option<Inherited> {
        let (parent, _) = self.locator.locate(&self.mesh, finer.centre(e))?;
        if (0..3).any(|k| self.at_middle(parent, k).is_none()) {
            return None;
        }
        // The new element may reach beyond the old one that holds its centre, whose curve and error say nothing of what is
        // there.
        let p = finer.corners(e);
        let middles = [0, 1, 2].map(|k| {
            let middle = p[k].midpoint(p[(k + 1) % 3]);
            finer.inset(e, middle, inset)
        });
        let around = middles
            .iter()
            .filter_map(|&m| self.locator.locate(&self.mesh, m));
        let error = around
            .map(|(old, _)| old)
            .chain([parent])
            .map(|old| self.error(old) / self.mesh.area(old))
            .fold(0.0, f64::max);
        Some(Inherited {
            middles: middles.map(|m| self.at(m)),
            error,
        })
    }
}

/// Gives neighbours that inherit different values for the edge between them the mean of both: the field has no jumps but on
/// borders of the values.
fn join(heirs: &mut [Option<Inherited>], mesh: &ReceiverMesh) {
    for e in 0..heirs.len() {
        for k in 0..3 {
            let Some(f) = mesh.neighbours[e][k].map(|f| f as usize).filter(|&f| f > e) else {
                continue;
            };
            let back = (0..3).find(|&j| mesh.neighbours[f][j] == Some(e as u32));
            let (Some(j), false) = (back, mesh.is_barrier(e, k)) else {
                continue;
            };
            if let (Some(a), Some(b)) = (heirs[e], heirs[f]) {
                let mean = (a.middles[k] + b.middles[j]) * 0.5;
                heirs[e] = Some(a.with(k, mean));
                heirs[f] = Some(b.with(j, mean));
            }
        }
    }
}
