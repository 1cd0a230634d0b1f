//! The indirect irradiance as a field over the receivers: piecewise quadratic between gathered values.

use super::solve::apply;
use super::{Gatherer, SolveMesh, Transport};
use crate::quantity::{Irradiance, Radiosity, Rgb};
use crate::visibility::{Blockers, Viewpoint};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Indirect irradiance at the corners and edge midpoints of every element of the solve mesh.
///
/// Between them it is quadratic, one order above the linear elements of the solution: the final gather is paid at a few
/// points of the coarse mesh instead of every vertex of the displayed one.
pub struct IndirectField<'a> {
    mesh: SolveMesh,
    blockers: &'a Blockers,
    radiosity: Vec<Radiosity>,
    means: Vec<Radiosity>,
    sites: Vec<Irradiance>,
    /// Values at the midpoints of each element's edges, by face and element.
    middles: Vec<Vec<[Irradiance; 3]>>,
}

impl<'a> IndirectField<'a> {
    /// Gathers at every site and edge midpoint.
    pub fn new(
        mesh: SolveMesh,
        blockers: &'a Blockers,
        transport: &Transport,
        radiosity: Vec<Radiosity>,
    ) -> Self {
        let mut field = Self {
            blockers,
            means: transport.face_means(&radiosity),
            sites: transport.apply_all(&radiosity),
            radiosity,
            middles: mesh
                .faces
                .iter()
                .map(|f| vec![[Irradiance::ZERO; 3]; f.mesh.elements.len()])
                .collect(),
            mesh,
        };
        field.gather_middles();
        field
    }

    /// An edge between two elements has one midpoint value; on a contact line each side has its own.
    fn gather_middles(&mut self) {
        let mut jobs = Vec::new();
        for (f, face) in self.mesh.faces.iter().enumerate() {
            for e in 0..face.mesh.elements.len() {
                for k in 0..3 {
                    let other = face.mesh.neighbours[e][k];
                    if face.mesh.is_barrier(e, k) || other.is_none_or(|o| e < o as usize) {
                        jobs.push((f, e, k));
                    }
                }
            }
        }
        let values: Vec<Irradiance> = jobs
            .par_iter()
            .map_init(
                || self.gatherer(),
                |gatherer, &(f, e, k)| {
                    let face = &self.mesh.faces[f];
                    let p = face.mesh.corners(e);
                    let mut middle = p[k].midpoint(p[(k + 1) % 3]);
                    if face.mesh.is_barrier(e, k) {
                        middle = face.mesh.inset(e, middle, self.blockers.weld_distance());
                    }
                    self.gather(gatherer, &face.view(middle))
                },
            )
            .collect();
        for (&(f, e, k), &value) in jobs.iter().zip(&values) {
            self.middles[f][e][k] = value;
            let mesh = &self.mesh.faces[f].mesh;
            if let (false, Some(o)) = (mesh.is_barrier(e, k), mesh.neighbours[e][k]) {
                let back = (0..3)
                    .find(|&j| mesh.neighbours[o as usize][j] == Some(e as u32))
                    .expect("neighbours are mutual");
                self.middles[f][o as usize][back] = value;
            }
        }
    }

    /// Indirect irradiance at frame coordinates `p` of solve face `f`, W/m², by quadratic interpolation.
    pub fn at(&self, f: usize, p: DVec2) -> Irradiance {
        let face = &self.mesh.faces[f];
        let Some((e, b)) = face.locate(p) else {
            return Irradiance::ZERO;
        };
        let corners = face.mesh.sites[e].map(|s| self.sites[face.first_site + s as usize]);
        let mut sum = Irradiance::ZERO;
        for k in 0..3 {
            sum += corners[k] * (b[k] * (2.0 * b[k] - 1.0));
            sum += self.middles[f][e][k] * (4.0 * b[k] * b[(k + 1) % 3]);
        }
        // Quadratic interpolation may dip below zero where light ends within an element.
        Irradiance(Rgb(sum.0.0.max(DVec3::ZERO)))
    }

    /// Indirect irradiance at `view`, gathered there exactly from the solution, W/m².
    pub fn gather(&self, gatherer: &mut Gatherer, view: &Viewpoint) -> Irradiance {
        apply(&gatherer.row(view), &self.radiosity, &self.means)
    }

    /// A gatherer for [`IndirectField::gather`].
    pub fn gatherer(&self) -> Gatherer<'_> {
        Gatherer::new(&self.mesh, self.blockers)
    }

    /// The mesh that the field lives on.
    pub fn mesh(&self) -> &SolveMesh {
        &self.mesh
    }
}
