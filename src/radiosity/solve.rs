//! The linear system and its solution by Gauss–Seidel sweeps.

use super::{Gatherer, Row, SolveMesh};
use crate::quantity::{Irradiance, Radiosity};
use crate::visibility::Blockers;
use rayon::prelude::*;

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
pub struct Transport {
    /// One for each site, but for uniform faces one for all sites of the face.
    rows: Vec<Row>,
    row_of: Vec<u32>,
    uniform: Vec<bool>,
    /// For each face its sites' shares of the area: the mean of a face's radiosity.
    shares: Vec<Vec<(u32, f64)>>,
}

impl Transport {
    /// Computes every row, in parallel.
    pub fn new(mesh: &SolveMesh, blockers: &Blockers) -> Self {
        let mut views = Vec::with_capacity(mesh.site_count());
        let mut row_of = Vec::with_capacity(mesh.site_count());
        for face in &mesh.faces {
            let n = face.mesh.site_vertices.len();
            let middle = face.is_small.then(|| face.middle()).flatten();
            if let Some(middle) = middle {
                row_of.extend((0..n).map(|_| views.len() as u32));
                views.push(face.view(middle));
            } else {
                row_of.extend((0..n).map(|s| (views.len() + s) as u32));
                views.extend((0..n).map(|s| face.site_view(s)));
            }
        }
        let rows = views
            .par_iter()
            .map_init(
                || Gatherer::new(mesh, blockers),
                |gatherer, view| gatherer.row(view),
            )
            .collect();
        let shares = mesh
            .faces
            .iter()
            .map(|face| {
                let mut areas = vec![0.0; face.mesh.site_vertices.len()];
                for (e, sites) in face.mesh.sites.iter().enumerate() {
                    for &s in sites {
                        areas[s as usize] += face.mesh.area(e) / 3.0;
                    }
                }
                let total: f64 = areas.iter().sum();
                let site = |s: usize| (face.first_site + s) as u32;
                areas
                    .iter()
                    .enumerate()
                    .map(|(s, a)| (site(s), a / total))
                    .collect()
            })
            .collect();
        Self {
            rows,
            row_of,
            uniform: mesh.faces.iter().map(|f| f.is_small).collect(),
            shares,
        }
    }

    /// Number of nonzero coefficients.
    pub fn coefficients(&self) -> usize {
        self.rows
            .iter()
            .map(|r| r.sites.len() + r.faces.len())
            .sum()
    }

    /// Sum of the weights of the row of `site`.
    pub fn row_sum(&self, site: usize) -> f64 {
        self.rows[self.row_of[site] as usize].sum()
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// True when all sites of solve face `f` share one row.
    pub fn is_uniform(&self, f: usize) -> bool {
        self.uniform[f]
    }

    /// Area-weighted mean of a nodal field over each face.
    pub fn face_means(&self, radiosity: &[Radiosity]) -> Vec<Radiosity> {
        self.shares
            .iter()
            .map(|shares| {
                let mut sum = Radiosity::ZERO;
                for &(s, w) in shares {
                    sum += radiosity[s as usize] * w;
                }
                sum
            })
            .collect()
    }

    /// Solves for the reflected radiosity at all sites, given the direct irradiance there.
    ///
    /// Sweeps end when the error that is left, extrapolated from the last two changes, is below `tolerance` (relative to
    /// the largest radiosity).
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
        for _ in 0..sweeps {
            let means = self.face_means(&radiosity);
            // Gauss–Seidel reads what this sweep has already updated; counted bounces must not.
            let before = (bounces != Bounces::All).then(|| radiosity.clone());
            let (mut change, mut largest) = (0.0_f64, 0.0_f64);
            for i in 0..radiosity.len() {
                let source = before.as_deref().unwrap_or(&radiosity);
                let row = &self.rows[self.row_of[i] as usize];
                let new = reflect(i, apply(row, source, &means));
                change = change.max((new - radiosity[i]).0.0.abs().max_element());
                largest = largest.max(new.0.0.max_element());
                radiosity[i] = new;
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

    /// Indirect irradiance at every site from the radiosity.
    pub fn apply_all(&self, radiosity: &[Radiosity]) -> Vec<Irradiance> {
        let means = self.face_means(radiosity);
        let values: Vec<Irradiance> = self
            .rows
            .iter()
            .map(|r| apply(r, radiosity, &means))
            .collect();
        self.row_of.iter().map(|&r| values[r as usize]).collect()
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
