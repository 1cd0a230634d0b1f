//! The indirect light on one side of one face.

use super::SolveFace;
use super::locator::Locator;
use super::nodes::NodalField;
use crate::mesh::{GridPoint, MeshError, ReceiverMesh};
use crate::quantity::{Irradiance, Rgb};
use crate::visibility::Viewpoint;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// What the points of a small face do not tell of how it varies, as a share of its value.
const UNIFORM_VARIATION: f64 = 0.1;

/// Linear interpolation is off by at most this share of the range of the corners, unless light breaks inside.
const LINEAR_SHARE: f64 = 0.25;

/// Quadratic interpolation is off by about this share of what it adds to linear interpolation.
const QUADRATIC_SHARE: f64 = 0.2;

/// And by no less than this share of it, however good one gather in the middle finds it.
const PROBED_SHARE: f64 = 0.08;

/// Weight of the error found in the middle of an element: of the 7-point rule, corners and edge midpoints being exact.
const CENTRE_WEIGHT: f64 = 9.0 / 20.0;

/// The squared error of quadratic interpolation that is expected to be left when an element is halved: a 64th where light is
/// smooth, a quarter across a kink, and never less than gathers differ by. Fields of two rooms were off by 1.1 to 1.4 times
/// their estimate with this share, by 1.3 to 1.5 times with an eighth.
const HALVED_SHARE: f64 = 0.5;

/// An element whose longest edge is shorter than this many pixels is not divided.
const SMALLEST_EDGE_PX: f64 = 64.0;

/// What is known of one element.
#[derive(Clone, Copy, Debug, Default)]
struct Knowledge {
    /// Values at the midpoints of its edges, where gathered.
    middles: [Option<Irradiance>; 3],
    /// Error found in its middle (mean square), once gathered there.
    centre: Option<f64>,
    /// What a coarser element told of it, until it is gathered.
    inherited: Option<Inherited>,
}

impl Inherited {
    /// With this value at the middle of edge `k`.
    fn with(mut self, k: usize, value: Irradiance) -> Self {
        self.middles[k] = value;
        self
    }
}

impl Knowledge {
    /// Forgets what was inherited where all is gathered.
    fn settle(&mut self) {
        if self.middles.iter().all(Option::is_some) {
            self.inherited = None;
        }
    }

    /// The value at the middle of edge `k`, as far as one is known.
    fn middle(&self, k: usize) -> Option<Irradiance> {
        self.middles[k].or(self.inherited.map(|i| i.middles[k]))
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

/// Values on one side of a face.
pub(super) struct FieldFace {
    /// Those of the solution until elements are divided: most faces never are.
    mesh: Arc<ReceiverMesh>,
    locator: Arc<Locator>,
    values: Vec<Irradiance>,
    /// Of each element; empty where the whole face has one value.
    known: Vec<Knowledge>,
    /// All values are the mean of the points of a small face.
    is_uniform: bool,
    /// What these tell of the variance over the face, (W/m²)².
    variance: f64,
    /// All points of the mesh, once elements have been divided.
    points: Vec<GridPoint>,
    /// Values at vertices and edge midpoints, by doubled grid coordinates.
    gathered: HashMap<(i64, i64), Irradiance>,
}

impl FieldFace {
    /// Starts from what the solution has gathered on solve face number `f`.
    pub(super) fn new(face: &SolveFace, f: usize, solution: &NodalField) -> Self {
        let mesh = Arc::clone(&face.mesh);
        let values = (0..mesh.site_vertices.len())
            .map(|s| solution.at_site(f, s))
            .collect();
        let middles: Vec<_> = (0..mesh.elements.len())
            .map(|e| solution.at_middles(f, e))
            .collect();
        let mut field = Self {
            locator: Arc::clone(&face.locator),
            known: Vec::new(),
            points: Vec::new(),
            is_uniform: middles.iter().any(Option::is_none),
            variance: solution.mean_and_variance(f).1,
            mesh,
            values,
            gathered: HashMap::new(),
        };
        if !field.is_uniform {
            field.known = vec![Knowledge::default(); field.mesh.elements.len()];
            field.remember(&middles);
        }
        field
    }

    /// Takes over the values of sites and midpoints.
    fn remember(&mut self, middles: &[Option<[Irradiance; 3]>]) {
        for (s, &v) in self.mesh.site_vertices.iter().enumerate() {
            if !self.mesh.is_limit[s] {
                let g = self.mesh.vertices[v as usize];
                self.gathered.insert((2 * g.x, 2 * g.y), self.values[s]);
            }
        }
        for (e, middles) in middles.iter().enumerate() {
            self.known[e].middles = [0, 1, 2].map(|k| middles.map(|m| m[k]));
            for k in 0..3 {
                if let (Some(m), false) = (middles, self.mesh.is_barrier(e, k)) {
                    self.gathered.insert(self.key(e, k), m[k]);
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

    /// Integral over the elements, linear between the corners, W.
    pub(super) fn power(&self) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for (e, sites) in self.mesh.sites.iter().enumerate() {
            for &s in sites {
                sum += self.values[s as usize] * (self.mesh.area(e) / 3.0);
            }
        }
        sum
    }

    /// Estimated integrals of the squared error: of the whole face when it has one value, else of each element.
    pub(super) fn errors(&self) -> Vec<f64> {
        if self.is_uniform {
            let value = self.values.first().map_or(0.0, |v| v.0.mean_square());
            let unseen = UNIFORM_VARIATION * UNIFORM_VARIATION * value;
            return vec![self.area() * (self.variance + unseen)];
        }
        (0..self.known.len()).map(|e| self.error(e)).collect()
    }

    fn error(&self, e: usize) -> f64 {
        let known = &self.known[e];
        if let Some(inherited) = known.inherited {
            return self.mesh.area(e) * inherited.error;
        }
        let corners = self.mesh.sites[e].map(|s| self.values[s as usize]);
        let mut square = 0.0_f64;
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let part = match known.middles[k] {
                None => LINEAR_SHARE * LINEAR_SHARE * (a - b).0.mean_square(),
                Some(m) => {
                    let share = match known.centre {
                        Some(_) => PROBED_SHARE,
                        None => QUADRATIC_SHARE,
                    };
                    share * share * (m - (a + b) * 0.5).0.mean_square()
                }
            };
            square = square.max(part);
        }
        let centre = known.centre.map_or(0.0, |c| CENTRE_WEIGHT * c);
        self.mesh.area(e) * square.max(centre)
    }

    /// Estimated RMS error over the element that holds frame coordinates `p`, W/m².
    pub(super) fn error_at(&self, p: DVec2) -> f64 {
        match self.locator.locate(&self.mesh, p) {
            Some(_) if self.is_uniform => (self.errors()[0] / self.area()).sqrt(),
            Some((e, _)) => (self.error(e) / self.mesh.area(e)).sqrt(),
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
                self.known = vec![Knowledge::default(); self.mesh.elements.len()];
                self.fill_sites(&mut ask);
            }
            return Ok(count);
        }
        let mut divided = Vec::new();
        let marked: Vec<usize> = (0..self.known.len())
            .filter(|&e| self.error(e) >= limit)
            .collect();
        for e in marked {
            if self.known[e].middles.iter().any(Option::is_none) {
                self.fill_middles(e, weld_distance, &mut ask);
            } else if self.known[e].centre.is_none() {
                let middle = self.mesh.centre(e);
                let third = 1.0 / 3.0;
                let off = ask(middle) - self.interpolate(e, [third; 3]);
                self.known[e].centre = Some(off.0.mean_square());
            } else {
                divided.push(e);
            }
        }
        if !divided.is_empty() {
            self.divide(face, &divided, weld_distance, &mut ask)?;
        }
        Ok(count)
    }

    fn fill_sites(&mut self, ask: &mut impl FnMut(DVec2) -> Irradiance) {
        for s in 0..self.values.len() {
            let g = self.mesh.vertices[self.mesh.site_vertices[s] as usize];
            let key = (2 * g.x, 2 * g.y);
            self.values[s] = if self.mesh.is_limit[s] {
                ask(self.mesh.site_points[s])
            } else if let Some(&value) = self.gathered.get(&key) {
                value
            } else {
                let value = ask(self.mesh.site_points[s]);
                self.gathered.insert(key, value);
                value
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
            self.values.iter_mut().for_each(|v| *v += all);
            return self.area() * all.0.mean_square();
        }
        self.gathered.clear();
        let mut more = |p: DVec2| more(&face.view(p), p);
        let mut added = Vec::with_capacity(self.values.len());
        for s in 0..self.values.len() {
            let amount = more(self.mesh.site_points[s]);
            added.push(amount);
            self.values[s] += amount;
            if !self.mesh.is_limit[s] {
                let g = self.mesh.vertices[self.mesh.site_vertices[s] as usize];
                self.gathered.insert((2 * g.x, 2 * g.y), self.values[s]);
            }
        }
        for e in 0..self.known.len() {
            let corners = self.mesh.sites[e].map(|s| added[s as usize]);
            if let Some(inherited) = &mut self.known[e].inherited {
                for k in 0..3 {
                    inherited.middles[k] += (corners[k] + corners[(k + 1) % 3]) * 0.5;
                }
            }
            for k in 0..3 {
                let Some(old) = self.known[e].middles[k] else {
                    continue;
                };
                let key = self.key(e, k);
                let p = self.mesh.corners(e);
                let middle = p[k].midpoint(p[(k + 1) % 3]);
                let is_barrier = self.mesh.is_barrier(e, k);
                let new = match self.gathered.get(&key) {
                    Some(&value) if !is_barrier => value,
                    _ if is_barrier => {
                        let inside = self.mesh.inset(e, middle, weld_distance);
                        old + more(inside)
                    }
                    _ => {
                        let value = old + more(middle);
                        self.gathered.insert(key, value);
                        value
                    }
                };
                self.known[e].middles[k] = Some(new);
            }
        }
        (0..self.mesh.elements.len())
            .map(|e| {
                let square = |&s: &u32| added[s as usize].0.mean_square();
                let sum: f64 = self.mesh.sites[e].iter().map(square).sum();
                self.mesh.area(e) * sum / 3.0
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
        for k in 0..3 {
            if self.known[e].middles[k].is_some() {
                continue;
            }
            let p = self.mesh.corners(e);
            let middle = p[k].midpoint(p[(k + 1) % 3]);
            if self.mesh.is_barrier(e, k) {
                let inside = self.mesh.inset(e, middle, weld_distance);
                self.known[e].middles[k] = Some(ask(inside));
                continue;
            }
            let value = ask(middle);
            self.gathered.insert(self.key(e, k), value);
            self.known[e].middles[k] = Some(value);
            if let Some(other) = self.mesh.neighbours[e][k] {
                let other = other as usize;
                for j in 0..3 {
                    if self.mesh.neighbours[other][j] == Some(e as u32) {
                        self.known[other].middles[j] = Some(value);
                        self.known[other].settle();
                    }
                }
            }
        }
        self.known[e].settle();
    }

    /// Doubled grid coordinates of the midpoint of edge `k` of element `e`.
    fn key(&self, e: usize, k: usize) -> (i64, i64) {
        let corners = self.mesh.elements[e];
        let [a, b] = [corners[k], corners[(k + 1) % 3]].map(|v| self.mesh.vertices[v as usize]);
        (a.x + b.x, a.y + b.y)
    }

    /// Meshes anew with the edges of the given elements halved.
    fn divide(
        &mut self,
        face: &SolveFace,
        elements: &[usize],
        weld_distance: f64,
        ask: &mut impl FnMut(DVec2) -> Irradiance,
    ) -> Result<(), MeshError> {
        let grid = &face.domain.grid;
        if self.points.is_empty() {
            self.points.clone_from(&self.mesh.vertices);
        }
        let before = self.points.len();
        for &e in elements {
            let p = self.mesh.corners(e);
            for k in 0..3 {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                if a.distance(b) > SMALLEST_EDGE_PX * grid.pixel_size() {
                    let g = grid.snap(a.midpoint(b));
                    // Rounded to the grid it is, for all that matters, the point whose value is known.
                    if let Some(&value) = self.gathered.get(&self.key(e, k)) {
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
        let keys = |mesh: &ReceiverMesh, e: usize| {
            let corners: [u32; 3] = mesh.elements[e];
            corners.map(|v| mesh.vertices[v as usize])
        };
        let old: HashMap<[GridPoint; 3], Knowledge> = (0..self.known.len())
            .map(|e| (keys(&self.mesh, e), self.known[e]))
            .collect();
        let mesh = face.domain.mesh(&[], &self.points)?;
        let mut heirs: Vec<Option<Inherited>> = (0..mesh.elements.len())
            .map(|e| match old.contains_key(&keys(&mesh, e)) {
                true => None,
                false => self.bequeath(&mesh, e, elements, weld_distance),
            })
            .collect();
        join(&mut heirs, &mesh);
        self.locator = Arc::new(Locator::new(&mesh));
        self.mesh = mesh;
        self.values = vec![Irradiance::ZERO; self.mesh.site_vertices.len()];
        self.fill_sites(ask);
        self.known = (0..self.mesh.elements.len())
            .map(|e| {
                let new = || {
                    let gathered = |k| self.gathered.get(&self.key(e, k)).copied();
                    let mut new = Knowledge {
                        middles: [0, 1, 2].map(|k| match self.mesh.is_barrier(e, k) {
                            true => None,
                            false => gathered(k),
                        }),
                        centre: None,
                        inherited: heirs[e],
                    };
                    new.settle();
                    new
                };
                old.get(&keys(&self.mesh, e)).copied().unwrap_or_else(new)
            })
            .collect();
        Ok(())
    }

    /// What this mesh knows of element `e` of a finer one, where it interpolates quadratically; `divided` are the elements
    /// (ascending) that are halved there.
    fn bequeath(
        &self,
        finer: &ReceiverMesh,
        e: usize,
        divided: &[usize],
        weld_distance: f64,
    ) -> Option<Inherited> {
        let (parent, _) = self.locator.locate(&self.mesh, finer.centre(e))?;
        let known = &self.known[parent];
        if (0..3).any(|k| known.middle(k).is_none()) {
            return None;
        }
        let share = match divided.binary_search(&parent) {
            Ok(_) => HALVED_SHARE,
            Err(_) => 1.0,
        };
        // The new element may reach beyond the old one that holds its centre, whose curve says nothing of what is there.
        let p = finer.corners(e);
        let at = |k: usize| {
            let middle = finer.inset(e, p[k].midpoint(p[(k + 1) % 3]), weld_distance);
            self.at(middle)
        };
        Some(Inherited {
            middles: [0, 1, 2].map(at),
            error: share * self.error(parent) / self.mesh.area(parent),
        })
    }

    /// Quadratic interpolation over element `e`; linear along edges whose midpoint is not known.
    fn interpolate(&self, e: usize, b: [f64; 3]) -> Irradiance {
        let corners = self.mesh.sites[e].map(|s| self.values[s as usize]);
        let mut sum = Irradiance::ZERO;
        for k in 0..3 {
            sum += corners[k] * b[k];
            if let Some(m) = self.known.get(e).and_then(|known| known.middle(k)) {
                let bend = m - (corners[k] + corners[(k + 1) % 3]) * 0.5;
                sum += bend * (4.0 * b[k] * b[(k + 1) % 3]);
            }
        }
        // Quadratic interpolation may dip below zero where light ends within an element.
        Irradiance(Rgb(sum.0.0.max(DVec3::ZERO)))
    }

    /// The field at frame coordinates `p`.
    pub(super) fn at(&self, p: DVec2) -> Irradiance {
        match self.locator.locate(&self.mesh, p) {
            Some((e, b)) => self.interpolate(e, b),
            None => Irradiance::ZERO,
        }
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

#[cfg(test)]
mod tests;
