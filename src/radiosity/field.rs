//! The indirect irradiance as a field over the receivers, gathered where it matters.
//!
//! The solution itself is coarse; what is shown is its final gather. A gather is the dearest thing there is, so each face
//! buys only what the error asked for needs, the cheapest first: one value for a face that is small; values at the corners
//! of its elements; at the midpoints of their edges (quadratic interpolation); one in the middle, to know the error; and
//! where that is too large, smaller elements.

use super::field_face::FieldFace;
use super::solve::apply;
use super::{Gatherer, SolveMesh, Transport};
use crate::mesh::MeshError;
use crate::quantity::{Irradiance, Radiosity};
use crate::visibility::{Blockers, Viewpoint};
use glam::DVec2;
use rayon::prelude::*;

/// Share of the permitted squared error that may stay in places where nothing more is bought.
const UNMARKED_SHARE: f64 = 0.5;

/// Rounds of buying: enough for six halvings of an element, each of three steps.
const MAX_ROUNDS: usize = 24;

/// Indirect irradiance over all lit sides.
pub struct IndirectField<'a> {
    solution: Coarse<'a>,
    faces: Vec<FieldFace>,
    /// Gathers made.
    gathers: usize,
    /// Estimated RMS error of the field, W/m².
    estimated_rms: f64,
}

/// The coarse solution and what is needed to gather from it.
pub(super) struct Coarse<'a> {
    pub(super) mesh: SolveMesh,
    pub(super) blockers: &'a Blockers,
    radiosity: Vec<Radiosity>,
    means: Vec<Radiosity>,
}

impl Coarse<'_> {
    /// Indirect irradiance at `view`, W/m².
    pub(super) fn gather(&self, gatherer: &mut Gatherer, view: &Viewpoint) -> Irradiance {
        apply(&gatherer.row(view), &self.radiosity, &self.means)
    }

    pub(super) fn gatherer(&self) -> Gatherer<'_> {
        Gatherer::new(&self.mesh, self.blockers)
    }
}

impl<'a> IndirectField<'a> {
    /// The field of a solution, with what the solution itself has gathered already.
    pub fn new(
        mesh: SolveMesh,
        blockers: &'a Blockers,
        transport: &Transport,
        radiosity: Vec<Radiosity>,
    ) -> Self {
        let gathered = transport.gather_all(&radiosity);
        let faces = (0..mesh.faces.len())
            .map(|f| FieldFace::new(&mesh.faces[f], f, &gathered))
            .collect();
        Self {
            solution: Coarse {
                means: transport.face_means(&radiosity),
                mesh,
                blockers,
                radiosity,
            },
            faces,
            gathers: transport.row_count(),
            estimated_rms: 0.0,
        }
    }

    /// Buys gathers until the RMS error of the field over its faces is estimated below `target` (W/m²).
    ///
    /// # Errors
    /// [`MeshError`]: our own bug.
    pub fn refine(&mut self, target: f64, mut progress: impl FnMut(f64)) -> Result<(), MeshError> {
        let area: f64 = self.faces.iter().map(FieldFace::area).sum();
        let allowed = target * target * area;
        for _ in 0..MAX_ROUNDS {
            let mut squares: Vec<f64> = self.faces.iter().flat_map(FieldFace::errors).collect();
            squares.sort_unstable_by(f64::total_cmp);
            let total: f64 = squares.iter().sum();
            self.estimated_rms = (total / area).sqrt();
            progress((target / self.estimated_rms).min(1.0));
            if total <= allowed {
                break;
            }
            let mut unmarked = 0.0;
            let limit = squares
                .iter()
                .find(|&&s| {
                    unmarked += s;
                    unmarked > UNMARKED_SHARE * allowed
                })
                .copied()
                .unwrap_or(f64::INFINITY);
            let solution = &self.solution;
            let bought: Vec<usize> = self
                .faces
                .par_iter_mut()
                .zip(&solution.mesh.faces)
                .map_init(
                    || solution.gatherer(),
                    |gatherer, (field, face)| {
                        field.buy(face, limit, solution.blockers.weld_distance(), |view| {
                            solution.gather(gatherer, view)
                        })
                    },
                )
                .collect::<Result<_, _>>()?;
            let bought: usize = bought.iter().sum();
            self.gathers += bought;
            if bought == 0 {
                break;
            }
        }
        Ok(())
    }

    /// Indirect irradiance at frame coordinates `p` of solve face `f`, W/m², interpolated.
    pub fn at(&self, f: usize, p: DVec2) -> Irradiance {
        self.faces[f].at(p)
    }

    /// Indirect irradiance at `view`, gathered there exactly from the solution, W/m².
    pub fn gather(&self, gatherer: &mut Gatherer, view: &Viewpoint) -> Irradiance {
        self.solution.gather(gatherer, view)
    }

    /// A gatherer for [`IndirectField::gather`].
    pub fn gatherer(&self) -> Gatherer<'_> {
        self.solution.gatherer()
    }

    /// The mesh that the solution lives on.
    pub fn mesh(&self) -> &SolveMesh {
        &self.solution.mesh
    }

    /// Number of gathers made for the field, those of the solution included.
    pub fn gathers(&self) -> usize {
        self.gathers
    }

    /// Estimated RMS error of the field against gathering everywhere, W/m².
    pub fn estimated_rms(&self) -> f64 {
        self.estimated_rms
    }
}
