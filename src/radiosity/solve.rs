//! The linear system and its solution by Gauss–Seidel sweeps.

use super::{Gatherer, Row, SolveFace, SolveMesh};
use crate::quantity::{Irradiance, Radiosity, Rgb};
use crate::scene::FaceId;
use crate::visibility::{Blockers, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// How often light is reflected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounces {
    /// Exactly so many times.
    Count(u32),
    /// Until nothing changes.
    All,
}

/// How the solution was reached.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct SolveReport {
    /// Unknowns a channel.
    pub sites: usize,
    /// Elements of the solve mesh.
    pub elements: usize,
    /// Nonzero coefficients.
    pub coefficients: usize,
    /// Largest change of any radiosity in each sweep, relative to the largest radiosity.
    pub residuals: Vec<f64>,
}

/// A Gauss–Seidel run that needs more sweeps than this has ρ above 0.999; Krylov methods are for that.
const MAX_SWEEPS: usize = 20_000;

/// The transport operator on a solve mesh.
///
/// Light is gathered at the sites and at the midpoints of the elements' edges; between these points it is quadratic. What a
/// site reflects is the mean of that field under its own basis function (lumped projection), not its value at the site: in
/// a corner, where the light behaves like `r^γ`, the value at the site says little about its surroundings, and the power
/// that is missed comes back with every bounce.
pub struct Transport {
    rows: Vec<Row>,
    /// For each site the rows that its mean is made of, with their weights.
    means: Vec<Vec<(u32, f64)>>,
    faces: Vec<FaceRows>,
}

/// The rows of one face.
struct FaceRows {
    /// Its rows among all rows.
    rows: Range<usize>,
    /// Its sites among all sites.
    sites: Range<usize>,
    /// For each site, its own row.
    site_rows: Vec<u32>,
    /// For each element the rows of its edges' midpoints; none when the whole face has one row.
    middles: Option<Vec<[u32; 3]>>,
    /// For each site its share of the area.
    shares: Vec<f64>,
}

impl Transport {
    /// Computes every row, in parallel.
    pub fn new(mesh: &SolveMesh, blockers: &Blockers) -> Self {
        let mut views = Vec::with_capacity(mesh.site_count());
        let mut means = Vec::with_capacity(mesh.site_count());
        let faces: Vec<FaceRows> = mesh
            .faces
            .iter()
            .map(|face| FaceRows::new(face, blockers.weld_distance(), &mut views, &mut means))
            .collect();
        let mut sampled: Vec<Option<FaceId>> = vec![None; views.len()];
        for (rows, face) in faces.iter().map(|f: &FaceRows| &f.rows).zip(&mesh.faces) {
            if face.is_small && face.sampled_below > 0.0 {
                sampled[rows.start] = Some(face.domain.face);
            }
        }
        let rows = views
            .par_iter()
            .zip(&sampled)
            .map_init(
                || Gatherer::new(mesh, blockers),
                |gatherer, (view, sampled)| match *sampled {
                    Some(own) => gatherer.sampled_row(view, own),
                    None => gatherer.row(view),
                },
            )
            .collect();
        Self { rows, means, faces }
    }

    /// Number of nonzero coefficients.
    pub fn coefficients(&self) -> usize {
        self.rows
            .iter()
            .map(|r| r.sites.len() + r.faces.len())
            .sum()
    }

    /// Sum of the weights of the row at `site`.
    pub fn row_sum(&self, site: usize) -> f64 {
        let face = self.faces.partition_point(|f| f.sites.end <= site);
        let face = &self.faces[face];
        self.rows[face.site_rows[site - face.sites.start] as usize].sum()
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Area-weighted mean of a nodal field over each face.
    pub fn face_means(&self, radiosity: &[Radiosity]) -> Vec<Radiosity> {
        self.faces.iter().map(|face| face.mean(radiosity)).collect()
    }

    /// Solves for the reflected radiosity at all sites, given the direct irradiance there.
    ///
    /// Sweeps go face by face and end when the error that is left, extrapolated from the last two changes, is below
    /// `tolerance` (relative to the largest radiosity).
    pub fn solve(
        &self,
        mesh: &SolveMesh,
        direct: &[Irradiance],
        bounces: Bounces,
        tolerance: f64,
    ) -> (Vec<Radiosity>, SolveReport) {
        let reflectance = mesh.reflectances();
        let reflect = |i: usize, h: Irradiance| Radiosity(reflectance[i] * (direct[i] + h).0);
        let mut radiosity: Vec<Radiosity> = (0..direct.len())
            .map(|i| reflect(i, Irradiance::ZERO))
            .collect();
        let mut report = SolveReport {
            sites: mesh.site_count(),
            elements: mesh.element_count(),
            coefficients: self.coefficients(),
            residuals: Vec::new(),
        };
        let sweeps = match bounces {
            // The final gather adds one bounce to those in the radiosity.
            Bounces::Count(n) => n.saturating_sub(1) as usize,
            Bounces::All => MAX_SWEEPS,
        };
        let mut gathered = vec![Irradiance::ZERO; self.rows.len()];
        for _ in 0..sweeps {
            let mut face_means = self.face_means(&radiosity);
            // Gauss–Seidel reads what this sweep has already updated; counted bounces must not.
            let before = (bounces != Bounces::All).then(|| radiosity.clone());
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for (f, face) in self.faces.iter().enumerate() {
                let source = before.as_deref().unwrap_or(&radiosity);
                for r in face.rows.clone() {
                    gathered[r] = apply(&self.rows[r], source, &face_means);
                }
                for i in face.sites.clone() {
                    let new = reflect(i, self.mean_at(i, &gathered));
                    change = change.max((new - radiosity[i]).0.0.abs().max_element());
                    largest = largest.max(new.0.0.max_element());
                    radiosity[i] = new;
                }
                if bounces == Bounces::All {
                    face_means[f] = face.mean(&radiosity);
                }
            }
            let relative = if largest > 0.0 { change / largest } else { 0.0 };
            let previous = report.residuals.last().copied();
            report.residuals.push(relative);
            if bounces == Bounces::All && is_settled(relative, previous, tolerance) {
                break;
            }
        }
        (radiosity, report)
    }

    /// Mean of the gathered light under the basis function of `site`.
    fn mean_at(&self, site: usize, gathered: &[Irradiance]) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for &(r, w) in &self.means[site] {
            sum += gathered[r as usize] * w;
        }
        // A mean over a quadratic that bends sharply may dip below zero.
        Irradiance(Rgb(sum.0.0.max(DVec3::ZERO)))
    }

    /// Indirect irradiance at every site and midpoint from the radiosity.
    pub fn gather_all(&self, radiosity: &[Radiosity]) -> Gathered<'_> {
        let face_means = self.face_means(radiosity);
        Gathered {
            transport: self,
            values: self
                .rows
                .iter()
                .map(|r| apply(r, radiosity, &face_means))
                .collect(),
        }
    }
}

/// Indirect irradiance at all points of the solve mesh.
pub struct Gathered<'t> {
    transport: &'t Transport,
    values: Vec<Irradiance>,
}

impl Gathered<'_> {
    /// At local site `s` of solve face `f`.
    pub fn at_site(&self, f: usize, s: usize) -> Irradiance {
        self.values[self.transport.faces[f].site_rows[s] as usize]
    }

    /// At the midpoints of the edges of element `e` of solve face `f`; none when all sites of the face share one row.
    pub fn at_middles(&self, f: usize, e: usize) -> Option<[Irradiance; 3]> {
        let middles = self.transport.faces[f].middles.as_ref()?;
        Some(middles[e].map(|r| self.values[r as usize]))
    }
}

/// Means of a quadratic over a triangle under the basis function of one corner, as weights of its values at that corner, at
/// each other corner, at each adjacent edge midpoint and at the opposite one: `∫ φ N_k / ∫ φ`.
const CORNER: f64 = 1.0 / 10.0;
const OTHER_CORNER: f64 = -1.0 / 20.0;
const NEAR_MIDDLE: f64 = 2.0 / 5.0;
const FAR_MIDDLE: f64 = 1.0 / 5.0;

impl FaceRows {
    /// Appends the viewpoints of the rows of `face`, and for each of its sites the rows that its mean is made of.
    fn new(
        face: &SolveFace,
        weld_distance: f64,
        views: &mut Vec<Viewpoint>,
        means: &mut Vec<Vec<(u32, f64)>>,
    ) -> Self {
        let mesh = &face.mesh;
        let n = mesh.site_vertices.len();
        let first = views.len();
        let mut areas = vec![0.0; n];
        for (e, sites) in mesh.sites.iter().enumerate() {
            for &s in sites {
                areas[s as usize] += mesh.area(e) / 3.0;
            }
        }
        let total: f64 = areas.iter().sum();
        let shares = areas.iter().map(|a| a / total).collect();
        let sites = face.first_site..face.first_site + n;
        if let Some(middle) = face.is_small.then(|| face.middle()).flatten() {
            views.push(face.view(middle));
            means.extend((0..n).map(|_| vec![(first as u32, 1.0)]));
            return Self {
                rows: first..first + 1,
                sites,
                site_rows: vec![first as u32; n],
                middles: None,
                shares,
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
        let mut of_site: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        for (e, sites) in mesh.sites.iter().enumerate() {
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let s = sites[k] as usize;
                let share = mesh.area(e) / (3.0 * areas[s]);
                let row = |c: usize| first as u32 + sites[c];
                of_site[s].extend([
                    (row(k), CORNER * share),
                    (row(i), OTHER_CORNER * share),
                    (row(j), OTHER_CORNER * share),
                    (middles[e][k], NEAR_MIDDLE * share),
                    (middles[e][j], NEAR_MIDDLE * share),
                    (middles[e][i], FAR_MIDDLE * share),
                ]);
            }
        }
        means.extend(of_site);
        Self {
            rows: first..views.len(),
            sites,
            site_rows: (0..n).map(|s| (first + s) as u32).collect(),
            middles: Some(middles),
            shares,
        }
    }

    fn mean(&self, radiosity: &[Radiosity]) -> Radiosity {
        let mut sum = Radiosity::ZERO;
        for (site, &w) in self.sites.clone().zip(&self.shares) {
            sum += radiosity[site] * w;
        }
        sum
    }
}

/// Changes shrink geometrically by some q: what is left after the last is change · q / (1 − q).
fn is_settled(change: f64, previous: Option<f64>, tolerance: f64) -> bool {
    match previous {
        _ if change == 0.0 => true,
        Some(previous) if change < previous => {
            let q = change / previous;
            change * q / (1.0 - q) <= tolerance
        }
        _ => false,
    }
}

/// `Σ weight · R` over one row.
pub(super) fn apply(row: &Row, radiosity: &[Radiosity], means: &[Radiosity]) -> Irradiance {
    let mut h = Irradiance::ZERO;
    for &(s, w) in &row.sites {
        h += Irradiance(radiosity[s as usize].0 * w);
    }
    for &(f, w) in &row.faces {
        h += Irradiance(means[f as usize].0 * w);
    }
    h
}
