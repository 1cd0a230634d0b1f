//! How far the indirect light is off, everywhere.

use super::{IndirectField, residual};
use crate::quantity::Irradiance;
use crate::radiosity::{Bounces, SolveFace};
use glam::DVec2;

/// The error of the solution, from the equation that it obeys: that of the light, with the residual as its source
/// (Bekaert & Willems 1996).
pub struct SolutionError {
    /// At the nodes of the solution; none where light is reflected a counted number of times.
    nodes: Option<Vec<Irradiance>>,
}

impl IndirectField<'_> {
    /// Solves for the error of the solution, given the direct light as in [`IndirectField::solve`]: the light that what the
    /// field reflects would bring about beyond what the cells send. What [`IndirectField::correct`] would add, without
    /// adding it.
    pub fn solution_error(
        &self,
        direct: impl Fn(&SolveFace, usize, DVec2) -> Irradiance + Sync,
    ) -> SolutionError {
        if self.request.bounces != Bounces::All {
            return SolutionError { nodes: None };
        }
        let solution = &self.solution;
        let mut trees = solution.trees.clone();
        let (_, light) = residual(
            &solution.mesh,
            &mut trees,
            solution.light.faces.iter().collect(),
            self.request.error,
            |face, f, p| direct(face, f, p) + self.faces[f].at(p),
        );
        let solved = self
            .transport
            .solve(&solution.mesh, &light, self.request.method())
            .expect("the same links have been solved before");
        SolutionError {
            nodes: Some(solved.values),
        }
    }

    /// `error` at frame coordinates `p` of solve face `f`: what is missing there, W/m².
    pub fn solution_error_at(&self, error: &SolutionError, f: usize, p: DVec2) -> Irradiance {
        match &error.nodes {
            Some(nodes) => self
                .transport
                .field(nodes)
                .at(&self.solution.mesh.faces[f], f, p),
            None => Irradiance::ZERO,
        }
    }

    /// Estimated RMS error of interpolating the field over that of its elements which holds frame coordinates `p` of solve
    /// face `f`, W/m².
    pub fn interpolation_error_at(&self, f: usize, p: DVec2) -> f64 {
        self.faces[f].error_at(p) * self.distrust[f].sqrt()
    }
}
