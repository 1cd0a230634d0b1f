//! One side of one face while its display mesh grows.

use super::Illumination;
use super::breaks::Rank;
use super::fit::fit;
use super::samples::{ElementError, Samples};
use super::vantages::Vantages;
use crate::direct::{Outlook, Vantage};
use crate::discontinuity::FaceLines;
use crate::mesh::{FaceDomain, GridPoint, MeshError, ReceiverMesh};
use crate::quantity::Irradiance;
use crate::scene::{Scene, Size};
use crate::visibility::Viewpoint;
use glam::DVec2;
use std::sync::Arc;

/// An element is not divided when its longest edge is shorter than this many pixels: the grid's rounding (a few pixels)
/// would show in its shape.
const SMALLEST_EDGE_PX: f64 = 64.0;

/// The display mesh of one side of a face with its light.
pub struct Receiver {
    /// Geometry that stays.
    pub domain: Arc<FaceDomain>,
    /// The mesh of the last update.
    pub mesh: Arc<ReceiverMesh>,
    /// Direct irradiance to show at the sites of `mesh`, W/m².
    pub direct: Vec<Irradiance>,
    /// Indirect irradiance to show at the sites of `mesh`, W/m².
    pub indirect: Vec<Irradiance>,
    /// Its face in the indirect field, if it has one.
    pub solve_face: Option<usize>,
    /// The lines found on it.
    pub lines: FaceLines,
    /// Whether any light reaches it; the others keep their first mesh and stay black.
    pub is_lit: bool,
    /// How much it matters; an element of a minor face agrees at its edges where it does in the middle.
    pub size: Size,
    /// Of a tiny face, what its middle sees of the emitters.
    pub(super) outlook: Option<Outlook>,
    /// What may be seen of the emitters from around it, where that is known.
    pub around: Option<Arc<Vantage>>,
    /// What its pieces see of them.
    pub(super) vantages: Vantages,
    /// Direct and indirect irradiance that there is at the sites of `mesh`, W/m².
    pub(super) exact: [Vec<Irradiance>; 2],
    pub(super) kept: Vec<bool>,
    /// Measured break of the kept candidates, W/m².
    pub(super) breaks: Vec<f64>,
    pub(super) ranks: Vec<Rank>,
    /// Points of the mesh besides the ends and crossings of lines, ascending.
    pub(super) points: Vec<GridPoint>,
    /// Those it started with, which stay: nowhere is the light looked at less densely.
    pub(super) seeds: Vec<GridPoint>,
    pub(super) errors: Vec<ElementError>,
    /// How many times what they tell the squared errors are taken to be.
    pub(super) distrust: f64,
    pub(super) samples: Samples,
    pub(super) is_stale: bool,
    pub(super) weld_distance: f64,
}

impl Receiver {
    /// A receiver with its starting points `spacing` metres apart; `lines` are those of `domain`.
    pub fn new(scene: &Scene, domain: Arc<FaceDomain>, lines: FaceLines, spacing: f64) -> Self {
        let points = domain.seed_points(spacing);
        let candidates = &lines.candidates;
        Self {
            domain,
            mesh: Arc::default(),
            direct: Vec::new(),
            indirect: Vec::new(),
            solve_face: None,
            is_lit: true,
            size: Size::default(),
            outlook: None,
            around: None,
            vantages: Vantages::default(),
            exact: [Vec::new(), Vec::new()],
            kept: vec![false; candidates.len()],
            breaks: vec![0.0; candidates.len()],
            ranks: candidates.iter().map(|l| Rank::new(scene, l)).collect(),
            lines,
            seeds: points.clone(),
            points,
            errors: Vec::new(),
            distrust: 1.0,
            samples: Samples::default(),
            is_stale: true,
            weld_distance: scene.weld_distance,
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
        self.samples.evaluations
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
        is_divisible(self.mesh.corners(e), self.domain.grid.pixel_size())
    }

    /// A viewpoint on this side at frame coordinates `p`.
    pub fn view(&self, p: DVec2) -> Viewpoint {
        self.domain.view(p)
    }

    /// Direct and indirect irradiance at a point of the plane.
    pub fn total(&self, light: &Illumination, p: DVec2) -> Irradiance {
        self.direct_at(light, p) + self.indirect_at(light, p)
    }

    /// Forgets what was known of the errors: the indirect light has changed.
    pub fn relight(&mut self) {
        self.samples.forget_indirect();
        self.is_stale = true;
    }

    /// Shows the indirect light on the mesh as it is: there is no time for more.
    pub fn show_indirect(&mut self, light: &Illumination) {
        if self.is_lit {
            let points = self.mesh.site_points.iter();
            self.indirect = points.map(|&p| self.indirect_at(light, p)).collect();
            self.exact[1].clone_from(&self.indirect);
        }
    }

    /// Starts anew with points `spacing` metres apart.
    pub(super) fn seed(&mut self, spacing: f64) {
        self.points = self.domain.seed_points(spacing);
        self.is_stale = true;
    }

    /// Meshes anew if anything was changed, and evaluates the light at what is new. Diagonals are turned where squared
    /// errors are not far below `limit`, if there is one.
    pub(super) fn update_mesh(
        &mut self,
        light: &Illumination,
        limit: Option<f64>,
    ) -> Result<(), MeshError> {
        if !std::mem::take(&mut self.is_stale) {
            return Ok(());
        }
        let kept: Vec<u32> = (0..self.kept.len())
            .filter(|&i| self.kept[i])
            .map(|i| i as u32)
            .collect();
        let mut mesh = self.domain.mesh(&kept, &self.points)?;
        if !self.errors.is_empty() {
            self.samples.measured = std::mem::take(&mut self.errors);
        }
        if self.is_lit {
            if self.size == Size::Tiny && self.lines.contacts.is_empty() && self.outlook.is_none() {
                self.look_out(light, &mesh);
            }
            if self.outlook.is_none() {
                let around = self.around.as_deref();
                self.vantages
                    .refine(light.direct, &self.domain, &mesh, around);
            }
            self.exact = self.light_at_sites(light, &mesh);
            if let Some(limit) = limit {
                self.turn_diagonals(light, &mut mesh, limit);
            }
            [self.direct, self.indirect] = self.exact.clone();
        } else {
            self.direct = vec![Irradiance::ZERO; mesh.site_vertices.len()];
            self.indirect = self.direct.clone();
        }
        self.mesh = mesh;
        Ok(())
    }

    /// Measures the interpolation errors of elements that are new, and with `is_fitted` fits the values to the light.
    pub(super) fn update_errors(&mut self, light: &Illumination, target: f64, is_fitted: bool) {
        if !self.is_lit || !self.errors.is_empty() {
            return;
        }
        let mesh = Arc::clone(&self.mesh);
        self.errors = self.measure_all(light, &mesh, target);
        let mut added = [0, 1].map(|i| vec![Irradiance::ZERO; self.exact[i].len()]);
        if is_fitted {
            let of =
                |part: fn(&ElementError) -> _| self.errors.iter().map(part).collect::<Vec<_>>();
            added[0] = fit(&mesh, &self.exact[0], &of(|e| e.direct));
            added[1] = fit(&mesh, &self.exact[1], &of(|e| e.indirect));
        }
        for (e, error) in self.errors.iter_mut().enumerate() {
            let corners = mesh.sites[e].map(|s| added[0][s as usize] + added[1][s as usize]);
            error.estimate(mesh.area(e), corners);
            error.square *= self.distrust;
        }
        let sum = |i: usize| {
            let both = self.exact[i].iter().zip(&added[i]);
            both.map(|(&v, &a)| v + a).collect()
        };
        (self.direct, self.indirect) = (sum(0), sum(1));
    }

    /// Takes the squared errors for `factor` times what they are taken for now.
    pub fn distrust(&mut self, factor: f64) {
        self.distrust *= factor;
        self.errors.iter_mut().for_each(|e| e.square *= factor);
    }

    /// Mean irradiance that is shown, W/m².
    pub fn mean(&self) -> Irradiance {
        match self.area() {
            area if area > 0.0 => self.power() * area.recip(),
            _ => Irradiance::ZERO,
        }
    }

    /// Estimated integral of the squared error of interpolation, (W/m²)² m².
    pub fn expected_error(&self) -> f64 {
        self.errors.iter().map(|e| e.square).sum()
    }

    /// Estimated mean square of the error of interpolation over element `e`, (W/m²)².
    pub fn expected_square(&self, e: usize) -> f64 {
        let error = self.errors.get(e).map_or(0.0, |e| e.square);
        error / self.mesh.area(e)
    }

    /// Irradiance to show at site `s`, W/m².
    pub fn site_total(&self, s: usize) -> Irradiance {
        self.direct[s] + self.indirect[s]
    }

    /// Estimated RMS error of the interpolation over the elements around each site, W/m²; nothing where no light is.
    pub fn interpolation_errors(&self) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.mesh.site_vertices.len()];
        for (e, error) in self.errors.iter().enumerate() {
            for &s in &self.mesh.sites[e] {
                let sum = &mut sums[s as usize];
                *sum = (sum.0 + error.square, sum.1 + self.mesh.area(e));
            }
        }
        let root = |&(square, area): &(f64, f64)| {
            if area > 0.0 {
                (square / area).sqrt()
            } else {
                0.0
            }
        };
        sums.iter().map(root).collect()
    }

    /// Linear interpolation over element `e` at barycentric coordinates `weights`: what a viewer will show, W/m².
    pub fn shown(&self, e: usize, weights: [f64; 3]) -> Irradiance {
        let [a, b, c] = self.mesh.sites[e].map(|s| self.site_total(s as usize));
        a * weights[0] + b * weights[1] + c * weights[2]
    }

    /// Adds a line or a point to every element whose squared error is at least `limit`.
    pub(super) fn refine(&mut self, light: &Illumination, limit: f64, target: f64) {
        if !self.is_lit {
            return;
        }
        let mesh = Arc::clone(&self.mesh);
        let pixel = self.domain.grid.pixel_size();
        for e in 0..mesh.elements.len() {
            if rounded(self.errors[e].square) < rounded(limit)
                || !is_divisible(mesh.corners(e), pixel)
            {
                continue;
            }
            self.is_stale = true;
            if self.outlook.take().is_some() {
                // It matters after all: first all its points look for themselves.
                self.size = Size::Minor;
                self.samples.forget();
                break;
            }
            if !self.keep_line(light, &mesh, e, target) {
                let point = self.division(&mesh, e);
                self.points.push(point);
            }
        }
        self.points.sort_unstable();
        self.points.dedup();
    }

    /// The middle of the edge along which interpolation fails most, of the longest among equals.
    fn division(&self, mesh: &ReceiverMesh, e: usize) -> GridPoint {
        let p = mesh.corners(e);
        let misfits = self.errors[e].edges();
        let length = |k: usize| p[k].distance(p[(k + 1) % 3]);
        let pixel = self.domain.grid.pixel_size();
        let k = (0..3)
            .filter(|&k| length(k) > SMALLEST_EDGE_PX * pixel)
            .max_by(|&i, &j| {
                let misfit = rounded(misfits[i]).total_cmp(&rounded(misfits[j]));
                misfit.then(rounded(length(i)).total_cmp(&rounded(length(j))))
            })
            .expect("the longest edge can be divided");
        self.domain.grid.snap(p[k].midpoint(p[(k + 1) % 3]))
    }
}

/// For comparisons: what symmetry makes equal stays equal, however it was rounded.
pub(super) fn rounded(x: f64) -> f32 {
    x as f32
}

fn is_divisible(p: [DVec2; 3], pixel: f64) -> bool {
    let longest = (0..3)
        .map(|k| p[k].distance(p[(k + 1) % 3]))
        .fold(0.0, f64::max);
    longest > SMALLEST_EDGE_PX * pixel
}
