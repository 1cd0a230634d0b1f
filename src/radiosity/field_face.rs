//! The indirect light on one side of one face.

use super::SolveFace;
use super::elements::{Elements, Knowledge};
use super::nodes::NodalField;
use crate::mesh::{GridPoint, MeshError};
use crate::quantity::Irradiance;
use crate::visibility::Viewpoint;
use glam::DVec2;
use std::collections::HashMap;

/// A small face with one value may vary by about this share of it.
const UNIFORM_VARIATION: f64 = 0.3;

/// An element whose longest edge is shorter than this many pixels is not divided.
const SMALLEST_EDGE_PX: f64 = 64.0;

/// Values on one side of a face.
pub(super) struct FieldFace {
    elements: Elements,
    /// All values are one gather from the middle of the face.
    is_uniform: bool,
    /// Points that divide the elements, beside those of the solve mesh.
    points: Vec<GridPoint>,
    /// Values at vertices and edge midpoints where all sides agree, by doubled grid coordinates.
    gathered: HashMap<(i64, i64), Irradiance>,
}

impl FieldFace {
    /// Starts from what the solution has gathered on solve face number `f`.
    pub(super) fn new(face: &SolveFace, f: usize, solution: &NodalField) -> Self {
        let mesh = face.mesh.clone();
        let values = (0..mesh.site_vertices.len())
            .map(|s| solution.at_site(f, s))
            .collect();
        let middles: Vec<_> = (0..mesh.elements.len())
            .map(|e| solution.at_middles(f, e))
            .collect();
        let mut field = Self {
            points: mesh.vertices.clone(),
            is_uniform: middles.iter().any(Option::is_none),
            elements: Elements::new(mesh, values),
            gathered: HashMap::new(),
        };
        if !field.is_uniform {
            field.remember(&middles);
        }
        field
    }

    /// Takes over the values of sites and midpoints.
    fn remember(&mut self, middles: &[Option<[Irradiance; 3]>]) {
        let elements = &mut self.elements;
        for (s, &v) in elements.mesh.site_vertices.iter().enumerate() {
            if !elements.mesh.is_limit[s] {
                let g = elements.mesh.vertices[v as usize];
                self.gathered.insert((2 * g.x, 2 * g.y), elements.values[s]);
            }
        }
        for (e, middles) in middles.iter().enumerate() {
            elements.known[e].middles = [0, 1, 2].map(|k| middles.map(|m| m[k]));
            for k in 0..3 {
                if let (Some(m), false) = (middles, elements.mesh.is_barrier(e, k)) {
                    self.gathered.insert(elements.key(e, k), m[k]);
                }
            }
        }
    }

    /// Area of the elements, m².
    pub(super) fn area(&self) -> f64 {
        let mesh = &self.elements.mesh;
        (0..mesh.elements.len()).map(|e| mesh.area(e)).sum()
    }

    /// Integral over the elements, linear between the corners, W.
    pub(super) fn power(&self) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for (e, sites) in self.elements.mesh.sites.iter().enumerate() {
            for &s in sites {
                sum += self.elements.values[s as usize] * (self.elements.mesh.area(e) / 3.0);
            }
        }
        sum
    }

    /// Estimated integrals of the squared error: of the whole face when it has one value, else of each element.
    pub(super) fn errors(&self) -> Vec<f64> {
        let elements = &self.elements;
        if self.is_uniform {
            let value = elements.values.first().map_or(0.0, |v| v.0.mean_square());
            return vec![self.area() * UNIFORM_VARIATION * UNIFORM_VARIATION * value];
        }
        (0..elements.known.len()).map(|e| self.error(e)).collect()
    }

    fn error(&self, e: usize) -> f64 {
        self.elements.mesh.area(e) * self.elements.error(e)
    }

    /// Estimated RMS error over the element that holds frame coordinates `p`, W/m².
    pub(super) fn error_at(&self, p: DVec2) -> f64 {
        match self.elements.at_with_error(p) {
            Some(_) if self.is_uniform => (self.errors()[0] / self.area()).sqrt(),
            Some((_, square)) => square.sqrt(),
            None => 0.0,
        }
    }

    /// Spends gathers on everything whose error is at least `limit`; returns how many.
    pub(super) fn buy(
        &mut self,
        face: &SolveFace,
        limit: f64,
        weld_distance: f64,
        mut gather: impl FnMut(&Viewpoint) -> Irradiance,
    ) -> Result<usize, MeshError> {
        let mut count = 0;
        let mut ask = |p: DVec2| {
            count += 1;
            gather(&face.view(p))
        };
        if self.is_uniform {
            if self.errors().iter().any(|&e| e >= limit) {
                self.is_uniform = false;
                self.fill_sites(None, &mut ask);
            }
            return Ok(count);
        }
        let mut divided = Vec::new();
        let marked: Vec<usize> = (0..self.elements.known.len())
            .filter(|&e| self.error(e) >= limit)
            .collect();
        for e in marked {
            let known = &self.elements.known[e];
            if known.middles.iter().any(Option::is_none) {
                self.fill_middles(e, weld_distance, &mut ask);
            } else if known.centre.is_none() && known.inherited.is_none() {
                let middle = self.elements.mesh.centre(e);
                let third = 1.0 / 3.0;
                let off = ask(middle) - self.elements.interpolate(e, [third; 3]);
                self.elements.known[e].centre = Some(off.0.mean_square());
            } else {
                divided.push(e);
            }
        }
        if !divided.is_empty() {
            self.divide(face, &divided, weld_distance, &mut ask)?;
        }
        Ok(count)
    }

    /// Gathers at the sites, except where `old` elements or others on this face know the value.
    fn fill_sites(&mut self, old: Option<&Elements>, ask: &mut impl FnMut(DVec2) -> Irradiance) {
        let elements = &mut self.elements;
        for s in 0..elements.values.len() {
            let g = elements.mesh.vertices[elements.mesh.site_vertices[s] as usize];
            let key = (2 * g.x, 2 * g.y);
            let p = elements.mesh.site_points[s];
            elements.values[s] = if elements.mesh.is_limit[s] {
                old.and_then(|old| old.gathered(p, key))
                    .unwrap_or_else(|| ask(p))
            } else {
                *self.gathered.entry(key).or_insert_with(|| ask(p))
            };
        }
    }

    /// Adds `more(viewpoint, frame coordinates)` to every value, and `coarse(frame coordinates)` where the whole face has one
    /// value; returns the integral of its square over the face.
    pub(super) fn add(
        &mut self,
        face: &SolveFace,
        weld_distance: f64,
        coarse: impl Fn(DVec2) -> Irradiance,
        mut more: impl FnMut(&Viewpoint, DVec2) -> Irradiance,
    ) -> f64 {
        if self.is_uniform {
            let all = coarse(face.domain.frame.to_plane(face.middle_point));
            self.elements.values.iter_mut().for_each(|v| *v += all);
            return self.area() * all.0.mean_square();
        }
        self.gathered.clear();
        let mut more = |p: DVec2| more(&face.view(p), p);
        let elements = &mut self.elements;
        let mut added = Vec::with_capacity(elements.values.len());
        for s in 0..elements.values.len() {
            let amount = more(elements.mesh.site_points[s]);
            added.push(amount);
            elements.values[s] += amount;
            if !elements.mesh.is_limit[s] {
                let g = elements.mesh.vertices[elements.mesh.site_vertices[s] as usize];
                self.gathered.insert((2 * g.x, 2 * g.y), elements.values[s]);
            }
        }
        for e in 0..elements.known.len() {
            for k in 0..3 {
                let [a, b] = [k, (k + 1) % 3].map(|c| added[elements.mesh.sites[e][c] as usize]);
                let mut shift = (a + b) * 0.5;
                if let Some(old) = elements.known[e].middles[k] {
                    let middle = elements.middle(e, k, weld_distance);
                    let new = if elements.mesh.is_barrier(e, k) {
                        old + more(middle)
                    } else {
                        let key = elements.key(e, k);
                        *self
                            .gathered
                            .entry(key)
                            .or_insert_with(|| old + more(middle))
                    };
                    elements.known[e].middles[k] = Some(new);
                    shift = new - old;
                }
                if let Some(foreseen) = &mut elements.known[e].foreseen[k] {
                    *foreseen += shift;
                }
            }
        }
        let mesh = &elements.mesh;
        (0..mesh.elements.len())
            .map(|e| {
                let squares = mesh.sites[e].map(|s| added[s as usize].0.mean_square());
                mesh.area(e) * squares.iter().sum::<f64>() / 3.0
            })
            .sum()
    }

    /// Gathers at the midpoints of element `e`; a neighbour across an ordinary edge shares the value.
    fn fill_middles(
        &mut self,
        e: usize,
        weld_distance: f64,
        ask: &mut impl FnMut(DVec2) -> Irradiance,
    ) {
        let elements = &mut self.elements;
        for k in 0..3 {
            if elements.known[e].middles[k].is_some() {
                continue;
            }
            let value = ask(elements.middle(e, k, weld_distance));
            elements.known[e].middles[k] = Some(value);
            if elements.mesh.is_barrier(e, k) {
                continue;
            }
            self.gathered.insert(elements.key(e, k), value);
            if let Some(other) = elements.mesh.neighbours[e][k] {
                let other = other as usize;
                for j in 0..3 {
                    if elements.mesh.neighbours[other][j] == Some(e as u32) {
                        elements.known[other].middles[j] = Some(value);
                    }
                }
            }
        }
    }

    /// Meshes anew with the edges of the given elements halved.
    fn divide(
        &mut self,
        face: &SolveFace,
        divided: &[usize],
        weld_distance: f64,
        ask: &mut impl FnMut(DVec2) -> Irradiance,
    ) -> Result<(), MeshError> {
        let grid = &face.domain.grid;
        let before = self.points.len();
        for &e in divided {
            let p = self.elements.mesh.corners(e);
            let is_bent = self.elements.bent_edges(e);
            for k in (0..3).filter(|&k| is_bent[k]) {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                if a.distance(b) > SMALLEST_EDGE_PX * grid.pixel_size() {
                    let g = grid.snap(a.midpoint(b));
                    // Rounded to the grid it is, for all that matters, the point whose value is known.
                    if let Some(&value) = self.gathered.get(&self.elements.key(e, k)) {
                        self.gathered.insert((2 * g.x, 2 * g.y), value);
                    }
                    self.points.push(g);
                }
            }
        }
        self.points.sort_unstable();
        self.points.dedup();
        if self.points.len() == before {
            return Ok(());
        }
        let mesh = face.domain.mesh(&[], &self.points)?;
        let values = vec![Irradiance::ZERO; mesh.site_vertices.len()];
        let old = std::mem::replace(&mut self.elements, Elements::new(mesh, values));
        self.fill_sites(Some(&old), ask);
        self.inherit(&old, weld_distance);
        Ok(())
    }

    /// Elements that have stayed keep what is known of them; the others learn what the `old` field was where they are.
    fn inherit(&mut self, old: &Elements, weld_distance: f64) {
        let corners = |of: &Elements, e: usize| {
            let vertices = of.mesh.elements[e];
            vertices.map(|v| of.mesh.vertices[v as usize])
        };
        let stayed: HashMap<[GridPoint; 3], Knowledge> = (0..old.known.len())
            .map(|e| (corners(old, e), old.known[e]))
            .collect();
        for e in 0..self.elements.known.len() {
            if let Some(&known) = stayed.get(&corners(&self.elements, e)) {
                self.elements.known[e] = known;
                continue;
            }
            let inherited = old.at_with_error(self.elements.mesh.centre(e));
            let mut known = Knowledge {
                inherited: inherited.map(|i| i.1),
                ..Knowledge::default()
            };
            for k in 0..3 {
                let key = self.elements.key(e, k);
                let middle = self.elements.middle(e, k, weld_distance);
                known.foreseen[k] = Some(old.at(middle));
                known.middles[k] = if self.elements.mesh.is_barrier(e, k) {
                    old.gathered(middle, key)
                } else {
                    self.gathered.get(&key).copied()
                };
            }
            self.elements.known[e] = known;
        }
    }

    /// The field at frame coordinates `p`.
    pub(super) fn at(&self, p: DVec2) -> Irradiance {
        self.elements.at(p)
    }
}
