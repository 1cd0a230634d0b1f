//! One side of one face while its display mesh grows.

use super::Illumination;
use super::error::ElementError;
use crate::direct::DirectLight;
use crate::discontinuity::FaceLines;
use crate::mesh::{FaceDomain, GridPoint, MeshError, ReceiverMesh, barycentric};
use crate::quantity::Irradiance;
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec2;
use std::collections::HashMap;

/// A line is tried when its predicted jump exceeds this share of the error asked for: smaller ones cannot matter.
const JUMP_SHARE: f64 = 0.25;

/// A line is inserted when its measured break inside an element exceeds this share of the element's error: below that,
/// curvature and not the break is what is wrong.
const BREAK_SHARE: f64 = 0.25;

/// An element is not divided when its longest edge is shorter than this many pixels: the grid's rounding (a few pixels)
/// would show in its shape.
const SMALLEST_EDGE_PX: f64 = 64.0;

/// The display mesh of one side of a face with its direct light.
pub struct Receiver {
    /// Geometry that stays.
    pub domain: FaceDomain,
    /// The mesh of the last update.
    pub mesh: ReceiverMesh,
    /// Direct irradiance at the sites of `mesh`, W/m².
    pub direct: Vec<Irradiance>,
    /// Indirect irradiance at the sites of `mesh`, W/m².
    pub indirect: Vec<Irradiance>,
    /// Its face in the indirect field, if it has one.
    pub solve_face: Option<usize>,
    /// The lines found on it.
    pub lines: FaceLines,
    /// Whether any light reaches it; the others keep their first mesh and stay black.
    pub is_lit: bool,
    kept: Vec<bool>,
    /// Measured break of the kept candidates, W/m².
    breaks: Vec<f64>,
    points: Vec<GridPoint>,
    errors: Vec<ElementError>,
    /// Exact values at points of the doubled grid: vertices and edge midpoints.
    values: HashMap<(i64, i64), Irradiance>,
    /// Errors of elements that a later mesh may hold again.
    known: HashMap<[GridPoint; 3], ElementError>,
    is_stale: bool,
    evaluations: usize,
    weld_distance: f64,
    scratch: Scratch,
}

impl Receiver {
    /// A receiver with its starting points `spacing` metres apart.
    pub fn new(
        scene: &Scene,
        face: FaceId,
        side: FaceSide,
        lines: FaceLines,
        spacing: f64,
    ) -> Self {
        let domain = FaceDomain::new(
            scene,
            face,
            side,
            &lines.contacts,
            &lines.candidates,
            &lines.covers,
        );
        let points = domain.seed_points(spacing);
        Self {
            domain,
            mesh: ReceiverMesh::default(),
            direct: Vec::new(),
            indirect: Vec::new(),
            solve_face: None,
            is_lit: true,
            kept: vec![false; lines.candidates.len()],
            breaks: vec![0.0; lines.candidates.len()],
            lines,
            points,
            errors: Vec::new(),
            values: HashMap::new(),
            known: HashMap::new(),
            is_stale: true,
            evaluations: 0,
            weld_distance: scene.weld_distance,
            scratch: Scratch::default(),
        }
    }

    /// Indices of the candidate lines that the mesh holds, with their measured break.
    pub fn kept(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        (0..self.kept.len())
            .filter(|&i| self.kept[i])
            .map(|i| (i, self.breaks[i]))
    }

    /// Exact evaluations of direct light so far.
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// Area of the elements, m².
    pub fn area(&self) -> f64 {
        (0..self.mesh.elements.len())
            .map(|e| self.mesh.area(e))
            .sum()
    }

    /// ∫ E dA over the elements, W.
    pub fn power(&self) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for (e, sites) in self.mesh.sites.iter().enumerate() {
            for &s in sites {
                sum += self.site_total(s as usize) * (self.mesh.area(e) / 3.0);
            }
        }
        sum
    }

    /// Squared errors of the elements that can still be divided.
    pub(super) fn open_errors(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.errors.len())
            .filter(|&e| self.is_divisible(e))
            .map(|e| self.errors[e].square)
    }

    /// Sum of the squared errors of the others.
    pub(super) fn settled_error(&self) -> f64 {
        (0..self.errors.len())
            .filter(|&e| !self.is_divisible(e))
            .map(|e| self.errors[e].square)
            .sum()
    }

    fn is_divisible(&self, e: usize) -> bool {
        let p = self.mesh.corners(e);
        let longest = (0..3)
            .map(|k| p[k].distance(p[(k + 1) % 3]))
            .fold(0.0, f64::max);
        longest > SMALLEST_EDGE_PX * self.domain.grid.pixel_size()
    }

    /// A viewpoint on this side at frame coordinates `p`.
    pub fn view(&self, p: DVec2) -> Viewpoint {
        Viewpoint::new(self.domain.frame.to_space(p), self.domain.normal)
    }

    /// Exact direct irradiance at a point of the plane.
    fn exact_direct(&mut self, light: &DirectLight, p: DVec2) -> Irradiance {
        self.evaluations += 1;
        let view = self.view(p);
        light.irradiance(&view, &mut self.scratch)
    }

    /// As [`Receiver::exact_direct`], remembered for the vertex or midpoint `key` of the doubled grid.
    fn direct_at(&mut self, light: &DirectLight, key: (i64, i64), p: DVec2) -> Irradiance {
        if let Some(&value) = self.values.get(&key) {
            return value;
        }
        let value = self.exact_direct(light, p);
        self.values.insert(key, value);
        value
    }

    /// Indirect irradiance at a point of the plane.
    fn indirect_at(&self, light: &Illumination, p: DVec2) -> Irradiance {
        match (light.indirect, self.solve_face) {
            (Some(field), Some(f)) => field.at(f, p),
            _ => Irradiance::ZERO,
        }
    }

    /// Direct and indirect irradiance at a point of the plane.
    pub fn total(&self, light: &Illumination, p: DVec2) -> Irradiance {
        let direct = light
            .direct
            .irradiance(&self.view(p), &mut Scratch::default());
        direct + self.indirect_at(light, p)
    }

    /// Forgets what was known of the errors: the indirect light has changed.
    pub fn relight(&mut self) {
        self.known.clear();
        self.is_stale = true;
    }

    /// Meshes anew if anything was added, and evaluates the light at what is new.
    pub(super) fn update_mesh(&mut self, light: &Illumination) -> Result<(), MeshError> {
        if !std::mem::take(&mut self.is_stale) {
            return Ok(());
        }
        let kept: Vec<u32> = (0..self.kept.len())
            .filter(|&i| self.kept[i])
            .map(|i| i as u32)
            .collect();
        self.mesh = self.domain.mesh(&kept, &self.points)?;
        self.errors.clear();
        if !self.is_lit {
            self.direct = vec![Irradiance::ZERO; self.mesh.site_vertices.len()];
            self.indirect = self.direct.clone();
            return Ok(());
        }
        let mesh = std::mem::take(&mut self.mesh);
        self.direct = (0..mesh.site_vertices.len())
            .map(|s| {
                let p = mesh.site_points[s];
                if mesh.is_limit[s] {
                    self.exact_direct(light.direct, p)
                } else {
                    let g = mesh.vertices[mesh.site_vertices[s] as usize];
                    self.direct_at(light.direct, (2 * g.x, 2 * g.y), p)
                }
            })
            .collect();
        self.indirect = mesh
            .site_points
            .iter()
            .map(|&p| self.indirect_at(light, p))
            .collect();
        self.mesh = mesh;
        Ok(())
    }

    /// Measures the interpolation errors of elements that are new.
    pub(super) fn update_errors(&mut self, light: &Illumination, target: f64) {
        if !self.is_lit || !self.errors.is_empty() {
            return;
        }
        let mesh = std::mem::take(&mut self.mesh);
        let mut known = HashMap::with_capacity(mesh.elements.len());
        self.errors = (0..mesh.elements.len())
            .map(|e| {
                let key = mesh.elements[e].map(|v| mesh.vertices[v as usize]);
                let error = match self.known.get(&key) {
                    Some(&error) => error,
                    None => self.measure(light, &mesh, e, target),
                };
                known.insert(key, error);
                error
            })
            .collect();
        self.known = known;
        self.mesh = mesh;
    }

    /// Irradiance at site `s`, W/m².
    pub fn site_total(&self, s: usize) -> Irradiance {
        self.direct[s] + self.indirect[s]
    }

    /// Linear interpolation over element `e` at barycentric coordinates `weights`: what a viewer will show, W/m².
    pub fn shown(&self, e: usize, weights: [f64; 3]) -> Irradiance {
        self.interpolate(&self.mesh, e, weights)
    }

    /// Linear interpolation over element `e`.
    fn interpolate(&self, mesh: &ReceiverMesh, e: usize, weights: [f64; 3]) -> Irradiance {
        let [a, b, c] = mesh.sites[e].map(|s| self.site_total(s as usize));
        a * weights[0] + b * weights[1] + c * weights[2]
    }

    fn measure(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        e: usize,
        target: f64,
    ) -> ElementError {
        let p = mesh.corners(e);
        let g = mesh.elements[e].map(|v| mesh.vertices[v as usize]);
        let mut edges = [0.0; 3];
        for k in 0..3 {
            let j = (k + 1) % 3;
            let middle = p[k].midpoint(p[j]);
            let exact = if mesh.is_barrier(e, k) {
                let inside = mesh.inset(e, middle, self.weld_distance);
                self.exact_direct(light.direct, inside) + self.indirect_at(light, inside)
            } else {
                let key = (g[k].x + g[j].x, g[k].y + g[j].y);
                self.direct_at(light.direct, key, middle) + self.indirect_at(light, middle)
            };
            let mut weights = [0.5; 3];
            weights[(k + 2) % 3] = 0.0;
            edges[k] = (exact - self.interpolate(mesh, e, weights)).0.mean_square();
        }
        let third = 1.0 / 3.0;
        let middle = mesh.centre(e);
        let centre = self.exact_direct(light.direct, middle) + self.indirect_at(light, middle);
        let centre = (centre - self.interpolate(mesh, e, [third; 3]))
            .0
            .mean_square();
        let mut line = 0.0_f64;
        for i in 0..self.kept.len() {
            if let Some([a, b]) = self.open_line_in(i, p, target) {
                let q = a.midpoint(b);
                let exact = self.exact_direct(light.direct, q) + self.indirect_at(light, q);
                let at_line = self.interpolate(mesh, e, barycentric(p, q));
                line = line.max((exact - at_line).0.mean_square());
            }
        }
        ElementError::new(mesh.area(e), edges, centre, line)
    }

    /// The stretch inside triangle `p` of a candidate that is not yet kept and could matter.
    fn open_line_in(&self, i: usize, p: [DVec2; 3], target: f64) -> Option<[DVec2; 2]> {
        if self.kept[i] || self.lines.candidates[i].jump < JUMP_SHARE * target {
            return None;
        }
        clip_to_triangle(self.domain.line(i), p)
    }

    /// Adds lines or points to every element whose squared error is at least `limit`.
    pub(super) fn refine(&mut self, light: &Illumination, limit: f64, target: f64) {
        if !self.is_lit {
            return;
        }
        let mesh = std::mem::take(&mut self.mesh);
        let mut added = Vec::new();
        for e in 0..mesh.elements.len() {
            if self.errors[e].square < limit {
                continue;
            }
            let p = mesh.corners(e);
            let pixels = self.domain.grid.pixel_size();
            let longest = (0..3)
                .map(|k| p[k].distance(p[(k + 1) % 3]))
                .fold(0.0, f64::max);
            if longest <= SMALLEST_EDGE_PX * pixels {
                continue;
            }
            self.is_stale = true;
            if !self.keep_lines(light, &mesh, e, target) {
                self.bisect(&mesh, e, &mut added);
            }
        }
        self.points.extend(added);
        self.points.sort_unstable();
        self.points.dedup();
        self.mesh = mesh;
    }

    /// Keeps the candidates that really break inside element `e`; false when there is none.
    fn keep_lines(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        e: usize,
        target: f64,
    ) -> bool {
        let p = mesh.corners(e);
        let scale = (self.errors[e].square / mesh.area(e)).sqrt();
        let mut any = false;
        for i in 0..self.kept.len() {
            let Some([a, b]) = self.open_line_in(i, p, target) else {
                continue;
            };
            let measured = self.measure_break(light, p, a, b);
            if measured >= BREAK_SHARE * scale {
                self.kept[i] = true;
                self.breaks[i] = measured;
                any = true;
            }
        }
        any
    }

    /// How much the irradiance departs, across the line through `a` and `b`, from one smooth function: the jump of slope and
    /// curvature at the line over the triangle's reach to both sides, W/m².
    fn measure_break(&mut self, light: &Illumination, p: [DVec2; 3], a: DVec2, b: DVec2) -> f64 {
        let middle = a.midpoint(b);
        let normal = (b - a).perp().normalize_or_zero();
        let reach = |n: DVec2| {
            let far = clip_to_triangle([middle, middle + n * longest_edge(p)], p);
            far.map_or(0.0, |[_, q]| middle.distance(q))
        };
        // Both sides as far as the nearer border allows, and not onto the border itself.
        let h = 0.9
            * reach(normal)
                .min(reach(-normal))
                .max(0.25 * reach(normal).max(reach(-normal)));
        if h <= 0.0 {
            return 0.0;
        }
        let mut at = |t: f64| self.exact_direct(light.direct, middle + normal * (t * h));
        let (e0, near, far) = (at(0.0), [at(0.5), at(-0.5)], [at(1.0), at(-1.0)]);
        // One-sided parabolas through 0, ½, 1: slope and curvature at the line in units of h.
        let fit = |k: usize| {
            let slope = near[k] * 4.0 - far[k] - e0 * 3.0;
            let curvature = (far[k] - near[k] * 2.0 + e0) * 4.0;
            (slope, curvature)
        };
        let ((s0, c0), (s1, c1)) = (fit(0), fit(1));
        let slope = (s0 + s1).0.mean_square().sqrt();
        let curvature = 0.5 * (c0 - c1).0.mean_square().sqrt();
        0.5 * slope.max(curvature)
    }

    /// Adds the midpoints of the edges along which interpolation fails most, or of the longest edge.
    fn bisect(&self, mesh: &ReceiverMesh, e: usize, added: &mut Vec<GridPoint>) {
        let p = mesh.corners(e);
        let errors = self.errors[e].edges;
        let worst = errors.iter().copied().fold(0.0, f64::max);
        let length = |k: usize| p[k].distance_squared(p[(k + 1) % 3]);
        let longest = (0..3)
            .max_by(|&i, &j| length(i).total_cmp(&length(j)))
            .expect("three edges");
        for k in 0..3 {
            let share = errors[k] * mesh.area(e);
            // An edge far shorter than the longest is not what makes the element too large.
            let is_long = 4.0 * length(k) >= length(longest);
            if k == longest || (is_long && errors[k] >= 0.5 * worst && share > 0.0) {
                let middle = p[k].midpoint(p[(k + 1) % 3]);
                added.push(self.domain.grid.snap(middle));
            }
        }
    }
}

fn longest_edge(p: [DVec2; 3]) -> f64 {
    (0..3)
        .map(|k| p[k].distance(p[(k + 1) % 3]))
        .fold(0.0, f64::max)
}

/// The stretch of a segment inside a counter-clockwise triangle; none when it has no length.
fn clip_to_triangle(ends: [DVec2; 2], p: [DVec2; 3]) -> Option<[DVec2; 2]> {
    let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
    for k in 0..3 {
        let d = p[(k + 1) % 3] - p[k];
        let (da, db) = (d.perp_dot(ends[0] - p[k]), d.perp_dot(ends[1] - p[k]));
        if da <= 0.0 && db <= 0.0 {
            return None;
        } else if da < 0.0 {
            t0 = t0.max(da / (da - db));
        } else if db < 0.0 {
            t1 = t1.min(da / (da - db));
        }
    }
    (t0 < t1).then(|| [ends[0].lerp(ends[1], t0), ends[0].lerp(ends[1], t1)])
}
