//! The indirect light on one side of one face.

mod division;
mod estimate;
mod points;

pub(super) use points::{CellLink, Gathered, Point, Source, merged};

use super::SolveFace;
use super::locator::Locator;
use super::nodes::NodalField;
use crate::mesh::{GridPoint, Inset, MeshError, ReceiverMesh};
use crate::quantity::{Irradiance, Rgb};
use crate::visibility::Viewpoint;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// What is known of one element.
#[derive(Clone, Copy, Debug, Default)]
struct Knowledge {
    /// Points at the midpoints of its edges, where gathered.
    middles: [Option<u32>; 3],
    /// Error found in its middle (mean square), once gathered there.
    centre: Option<f64>,
    /// What a coarser element told of it, until it is gathered.
    inherited: Option<Inherited>,
}

impl Knowledge {
    /// Forgets what was inherited where all is gathered.
    fn settle(&mut self) {
        if self.middles.iter().all(Option::is_some) {
            self.inherited = None;
        }
    }
}

/// What is known of an element from the one that was divided into it.
#[derive(Clone, Copy, Debug)]
struct Inherited {
    /// Values at the midpoints of its edges.
    middles: [Irradiance; 3],
    /// Expected error (mean square).
    error: f64,
}

/// The one value of a small face.
#[derive(Clone, Copy, Debug)]
struct Uniform {
    /// Mean of the points of the face.
    value: Irradiance,
    /// What these tell of the variance over the face, (W/m²)².
    variance: f64,
}

/// Values on one side of a face.
pub(super) struct FieldFace {
    /// Those of the solution until elements are divided: most faces never are.
    mesh: Arc<ReceiverMesh>,
    locator: Locator,
    /// As long as the whole face has one value; nothing else is known then.
    uniform: Option<Uniform>,
    /// All that have been gathered.
    points: Vec<Point>,
    /// The point of each site.
    sites: Vec<u32>,
    /// Of each element.
    known: Vec<Knowledge>,
    /// All vertices of the mesh, once elements have been divided.
    vertices: Vec<GridPoint>,
    /// Points at vertices and edge midpoints that are on no border, by doubled grid coordinates.
    gathered: HashMap<(i64, i64), u32>,
}

impl FieldFace {
    /// Starts from what the solution has gathered on solve face number `f`: from where at each of its nodes `source` tells.
    pub(super) fn new(
        face: &SolveFace,
        f: usize,
        solution: &NodalField,
        inset: Inset,
        source: impl Fn(u32) -> Source,
    ) -> Self {
        let mut field = Self {
            mesh: Arc::clone(&face.mesh),
            locator: face.locator.clone(),
            uniform: None,
            points: Vec::new(),
            sites: Vec::new(),
            known: Vec::new(),
            vertices: Vec::new(),
            gathered: HashMap::new(),
        };
        if solution.is_uniform(f) {
            let (value, variance) = solution.mean_and_variance(f);
            field.uniform = Some(Uniform { value, variance });
        } else {
            field.take_over(face, f, solution, inset, source);
        }
        field
    }

    /// Takes over the nodes at sites and midpoints.
    fn take_over(
        &mut self,
        face: &SolveFace,
        f: usize,
        solution: &NodalField,
        inset: Inset,
        source: impl Fn(u32) -> Source,
    ) {
        let mesh = &face.mesh;
        let first = solution.nodes[f].range.start as u32;
        let nodes = solution.nodes[f].range.clone();
        self.points = nodes
            .map(|node| Point {
                place: DVec2::ZERO,
                value: solution.values[node],
                source: source(node as u32),
            })
            .collect();
        for (s, place) in mesh.places(inset).into_iter().enumerate() {
            let node = solution.node_at_site(f, s).expect("a face with nodes");
            self.points[(node - first) as usize].place = place.point;
            self.sites.push(node - first);
            if !mesh.is_limit[s] {
                self.gathered.insert(self.site_key(s), node - first);
            }
        }
        self.known = vec![Knowledge::default(); mesh.elements.len()];
        for e in 0..mesh.elements.len() {
            let nodes = solution.nodes_at_middles(f, e).expect("a face with nodes");
            for (k, node) in nodes.into_iter().enumerate() {
                let point = node - first;
                self.known[e].middles[k] = Some(point);
                self.points[point as usize].place = self.middle(e, k, inset);
                if !mesh.is_barrier(e, k) {
                    self.gathered.insert(self.key(e, k), point);
                }
            }
        }
    }

    /// Area of the elements, m².
    pub(super) fn area(&self) -> f64 {
        (0..self.mesh.elements.len())
            .map(|e| self.mesh.area(e))
            .sum()
    }

    /// Links that its points remember.
    pub(super) fn link_count(&self) -> usize {
        self.points.iter().map(|p| p.source.len()).sum()
    }

    /// Integral over the elements, linear between the corners, W.
    pub(super) fn power(&self) -> Irradiance {
        if let Some(uniform) = self.uniform {
            return uniform.value * self.area();
        }
        let mut sum = Irradiance::ZERO;
        for e in 0..self.mesh.elements.len() {
            for value in self.corners(e) {
                sum += value * (self.mesh.area(e) / 3.0);
            }
        }
        sum
    }

    /// Spends gathers on everything whose error is at least `limit`; returns how many.
    pub(super) fn buy(
        &mut self,
        face: &SolveFace,
        limit: f64,
        inset: Inset,
        mut gather: impl FnMut(&Viewpoint) -> Gathered,
    ) -> Result<usize, MeshError> {
        let mut count = 0;
        let mut ask = |p: DVec2| {
            count += 1;
            gather(&face.view(p))
        };
        if let Some(uniform) = self.uniform {
            if self.errors().iter().any(|&e| e >= limit) {
                self.uniform = None;
                self.known = vec![Knowledge::default(); self.mesh.elements.len()];
                let places = self.mesh.places(inset).into_iter().enumerate();
                self.sites = places
                    .map(|(s, place)| self.fill_site(s, place.point, &mut ask))
                    .collect();
                self.inherit(uniform);
            }
            return Ok(count);
        }
        let mut divided = Vec::new();
        let marked: Vec<usize> = (0..self.known.len())
            .filter(|&e| self.error(e) >= limit)
            .collect();
        for e in marked {
            if self.known[e].middles.iter().any(Option::is_none) {
                self.fill_middles(e, inset, &mut ask);
            } else if self.known[e].centre.is_none() {
                let middle = self.mesh.centre(e);
                let third = 1.0 / 3.0;
                let off = ask(middle).value - self.interpolate(e, [third; 3]);
                self.known[e].centre = Some(off.0.mean_square());
            } else {
                divided.push(e);
            }
        }
        if !divided.is_empty() {
            self.divide(face, &divided, inset, &mut ask)?;
        }
        Ok(count)
    }

    /// Takes the mean that the whole face had for what its elements have, where the corners alone tell another one: light that
    /// falls between them.
    fn inherit(&mut self, uniform: Uniform) {
        let area = self.area();
        let more = uniform.value - self.power() * area.recip();
        let off = more.0.mean_square();
        if area <= 0.0 || off <= uniform.unseen() {
            return;
        }
        for e in 0..self.known.len() {
            let c = self.corners(e);
            let middles = [0, 1, 2].map(|k| (c[k] + c[(k + 1) % 3]) * 0.5 + more);
            let error = off.max(self.error(e) / self.mesh.area(e));
            self.known[e].inherited = Some(Inherited { middles, error });
        }
    }

    /// Gathers at `p`.
    fn fill(&mut self, p: DVec2, ask: &mut impl FnMut(DVec2) -> Gathered) -> u32 {
        let Gathered { value, source } = ask(p);
        self.points.push(Point {
            place: p,
            value,
            source,
        });
        self.points.len() as u32 - 1
    }

    /// The point of site `s`, gathered at `p` if need be; one on a border always.
    fn fill_site(&mut self, s: usize, p: DVec2, ask: &mut impl FnMut(DVec2) -> Gathered) -> u32 {
        if self.mesh.is_limit[s] {
            return self.fill(p, ask);
        }
        let key = self.site_key(s);
        if let Some(&point) = self.gathered.get(&key) {
            return point;
        }
        let point = self.fill(p, ask);
        self.gathered.insert(key, point);
        point
    }

    /// Adds `more(point)` to the value of every point, and `coarse(frame coordinates)` where the whole face has one value;
    /// returns the integral of its square over the face.
    pub(super) fn add(
        &mut self,
        face: &SolveFace,
        coarse: impl Fn(DVec2) -> Irradiance,
        mut more: impl FnMut(&mut Point) -> Irradiance,
    ) -> f64 {
        let area = self.area();
        if let Some(uniform) = &mut self.uniform {
            let all = coarse(face.domain.frame.to_plane(face.middle_point));
            uniform.value += all;
            return area * all.0.mean_square();
        }
        let mut add = |point: &mut Point| {
            let amount = more(point);
            point.value += amount;
            amount
        };
        let added: Vec<Irradiance> = self.points.iter_mut().map(&mut add).collect();
        let mut square = 0.0;
        for (e, known) in self.known.iter_mut().enumerate() {
            let corners = self.mesh.sites[e].map(|s| added[self.sites[s as usize] as usize]);
            if let Some(inherited) = &mut known.inherited {
                for k in 0..3 {
                    inherited.middles[k] += (corners[k] + corners[(k + 1) % 3]) * 0.5;
                }
            }
            let sum: f64 = corners.iter().map(|c| c.0.mean_square()).sum();
            square += self.mesh.area(e) * sum / 3.0;
        }
        square
    }

    /// Gathers at the midpoints of element `e`; a neighbour across an ordinary edge shares the value.
    fn fill_middles(&mut self, e: usize, inset: Inset, ask: &mut impl FnMut(DVec2) -> Gathered) {
        for k in 0..3 {
            if self.known[e].middles[k].is_some() {
                continue;
            }
            let point = self.fill(self.middle(e, k, inset), ask);
            self.known[e].middles[k] = Some(point);
            if self.mesh.is_barrier(e, k) {
                continue;
            }
            self.gathered.insert(self.key(e, k), point);
            if let Some(other) = self.mesh.neighbours[e][k] {
                let other = other as usize;
                for j in 0..3 {
                    if self.mesh.neighbours[other][j] == Some(e as u32) {
                        self.known[other].middles[j] = Some(point);
                        self.known[other].settle();
                    }
                }
            }
        }
        self.known[e].settle();
    }

    /// The midpoint of edge `k` of element `e`, on the element's side of a border.
    fn middle(&self, e: usize, k: usize, inset: Inset) -> DVec2 {
        let p = self.mesh.corners(e);
        let middle = p[k].midpoint(p[(k + 1) % 3]);
        match self.mesh.is_barrier(e, k) {
            true => self.mesh.inset(e, middle, inset),
            false => middle,
        }
    }

    /// Doubled grid coordinates of the midpoint of edge `k` of element `e`.
    fn key(&self, e: usize, k: usize) -> (i64, i64) {
        let corners = self.mesh.elements[e];
        let [a, b] = [corners[k], corners[(k + 1) % 3]].map(|v| self.mesh.vertices[v as usize]);
        (a.x + b.x, a.y + b.y)
    }

    /// Doubled grid coordinates of site `s`.
    fn site_key(&self, s: usize) -> (i64, i64) {
        let g = self.mesh.vertices[self.mesh.site_vertices[s] as usize];
        (2 * g.x, 2 * g.y)
    }

    fn value(&self, point: u32) -> Irradiance {
        self.points[point as usize].value
    }

    /// Values at the corners of element `e`.
    fn corners(&self, e: usize) -> [Irradiance; 3] {
        self.mesh.sites[e].map(|s| self.value(self.sites[s as usize]))
    }

    /// The value in the middle of edge `k` of element `e`, as far as one is known.
    fn at_middle(&self, e: usize, k: usize) -> Option<Irradiance> {
        let known = &self.known[e];
        let inherited = || known.inherited.map(|i| i.middles[k]);
        known.middles[k].map(|m| self.value(m)).or_else(inherited)
    }

    /// Quadratic interpolation over element `e`; linear along edges whose midpoint is not known.
    fn interpolate(&self, e: usize, b: [f64; 3]) -> Irradiance {
        let corners = self.corners(e);
        let mut sum = Irradiance::ZERO;
        for k in 0..3 {
            sum += corners[k] * b[k];
            if let Some(m) = self.at_middle(e, k) {
                let bend = m - (corners[k] + corners[(k + 1) % 3]) * 0.5;
                sum += bend * (4.0 * b[k] * b[(k + 1) % 3]);
            }
        }
        // Quadratic interpolation may dip below zero where light ends within an element.
        Irradiance(Rgb(sum.0.0.max(DVec3::ZERO)))
    }

    /// The field at frame coordinates `p`.
    pub(super) fn at(&self, p: DVec2) -> Irradiance {
        match (self.locator.locate(&self.mesh, p), self.uniform) {
            (Some(_), Some(uniform)) => uniform.value,
            (Some((e, b)), None) => self.interpolate(e, b),
            (None, _) => Irradiance::ZERO,
        }
    }
}

#[cfg(test)]
impl FieldFace {
    pub(super) fn points(&self) -> &[Point] {
        &self.points
    }

    pub(super) fn forget_links(&mut self) {
        for point in &mut self.points {
            point.source = Source::Forgotten;
        }
    }
}

#[cfg(test)]
mod tests;
