//! The indirect part of the recipe: a guess of how much of it there is, and the solution.

use super::guess::Guess;
use crate::adapt::Receiver;
use crate::direct::DirectLight;
use crate::mesh::{FaceDomain, MeshError};
use crate::quantity::{Irradiance, Rgb};
use crate::radiosity::{Linking, Locator, Request, SolveMesh};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::visibility::Blockers;
use glam::DVec2;
use rayon::prelude::*;
use std::sync::Arc;

/// Elements of the solve mesh at an error of 1 %, before the shapes of the faces ask for more. The field between its nodes is
/// quadratic, and refined and corrected where that is not enough.
const SOLVE_ELEMENTS: f64 = 150.0;

/// Their number grows as error to minus this power.
const SOLVE_EXPONENT: f64 = 0.4;

/// From this error (relative) on the solve mesh is graded towards concave edges: at 0.5 to 0.2 % that took 0.7 of the time over
/// three rooms (0.2 to 1.5, as it spares a round or costs one); at 1 % and above, with 35 to 80 % more links, it saved nothing.
const GRADED_ERROR: f64 = 0.005;

/// Area of an equilateral triangle of side 1: elements of a staggered lattice.
const LATTICE_TRIANGLE: f64 = 0.433;

/// Share of the permitted error left to the iteration.
const SOLVE_SHARE: f64 = 0.01;

/// What stays the same for all solve meshes of a scene.
pub(super) struct Rooms<'r> {
    pub(super) scene: &'r Scene,
    pub(super) blockers: &'r Blockers,
    /// The lit sides, sorted.
    pub(super) domains: &'r [Arc<FaceDomain>],
}

impl Rooms<'_> {
    /// The solve mesh of all lit sides for an error (relative), graded towards edges that are lit by more than that where
    /// so little is permitted that it pays.
    pub(super) fn solve_mesh(
        &self,
        error: f64,
        direct: &DirectLight,
        guess: Guess,
    ) -> Result<SolveMesh, MeshError> {
        let elements = SOLVE_ELEMENTS * (0.01 / error).powf(SOLVE_EXPONENT);
        let permitted = error * (guess.direct + guess.indirect);
        let spacing = self.spacing(elements);
        let rims = self.rims(spacing);
        SolveMesh::graded(
            self.reflecting(),
            spacing,
            |domain, edge| {
                error <= GRADED_ERROR && self.is_edge_lit(domain, edge, direct, guess, permitted)
            },
            |domain| {
                let own = rims.get(&(domain.face, domain.side));
                own.map_or(&[], Vec::as_slice)
            },
        )
    }

    /// Distance of neighbouring points when there are about so many elements, metres.
    fn spacing(&self, elements: f64) -> f64 {
        let area: f64 = self
            .domains
            .iter()
            .map(|d| self.scene.faces[d.face].area)
            .sum();
        (area / (LATTICE_TRIANGLE * elements)).sqrt()
    }

    /// The lit sides with their reflectances.
    fn reflecting(&self) -> Vec<(Arc<FaceDomain>, Rgb)> {
        let faces = &self.scene.faces;
        let both = |d: &Arc<FaceDomain>| (d.clone(), faces[d.face].reflectance);
        self.domains.iter().map(both).collect()
    }
}

fn mix(sites: [u32; 3], weights: [f64; 3], values: &[Irradiance]) -> Irradiance {
    let mut sum = Irradiance::ZERO;
    for (s, w) in sites.into_iter().zip(weights) {
        sum += values[s as usize] * w;
    }
    sum
}

/// What is asked of the solution when the mean irradiance is `mean`, of which `indirect` by way of other faces, W/m².
pub(super) fn request(settings: &Settings, mean: f64, indirect: f64) -> Request {
    Request {
        error: settings.error * mean,
        ambient: indirect,
        bounces: settings.bounces,
        tolerance: settings.error * SOLVE_SHARE,
        basis: settings.basis,
        linking: Linking::default(),
        solver: settings.solver,
    }
}

/// The direct light that the display meshes hold, at points of the solve mesh's faces.
pub(super) struct Shown<'r> {
    /// For each solve face its receiver.
    faces: Vec<Option<(&'r Receiver, Locator)>>,
}

impl<'r> Shown<'r> {
    pub(super) fn new(receivers: &'r [Receiver], solve_faces: usize) -> Self {
        let mut of_face: Vec<Option<&Receiver>> = vec![None; solve_faces];
        for r in receivers {
            if let Some(f) = r.solve_face {
                of_face[f] = Some(r);
            }
        }
        Self {
            faces: of_face
                .into_par_iter()
                .map(|r| r.map(|r| (r, Locator::new(&r.mesh))))
                .collect(),
        }
    }

    /// Direct irradiance at frame coordinates `p` of solve face `f`, W/m².
    pub(super) fn direct(&self, f: usize, p: DVec2) -> Irradiance {
        let Some((r, locator)) = &self.faces[f] else {
            return Irradiance::ZERO;
        };
        match locator.locate(&r.mesh, p) {
            Some((e, weights)) => mix(r.mesh.sites[e], weights, &r.direct),
            None => Irradiance::ZERO,
        }
    }
}
