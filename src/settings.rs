//! Every knob, its unit and its default.

use crate::adapt::Meshing;
use crate::budget::Budget;
use crate::radiosity::{Basis, Bounces, Solver};
use crate::scene::CleanSettings;

/// How a scene is lit.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Relative RMS error of irradiance over the lit surfaces that the user accepts.
    pub error: f64,
    /// How often light is reflected.
    pub bounces: Bounces,
    /// What the run may use.
    pub budget: Budget,
    /// How the light between surfaces is solved for.
    pub solver: Solver,
    /// What cells know of the light that they reflect.
    pub basis: Basis,
    /// What display meshes follow.
    pub meshing: Meshing,
    /// Tolerances of the clean-up.
    pub clean: CleanSettings,
    /// How `COLOR_0` is scaled.
    pub exposure: Exposure,
    /// Seed of the points at which the error is measured.
    pub seed: u64,
    /// Number of these points; by the number of lit sides when left out.
    pub samples: Option<u32>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            error: 0.01,
            bounces: Bounces::All,
            budget: Budget::default(),
            solver: Solver::default(),
            basis: Basis::default(),
            meshing: Meshing::default(),
            clean: CleanSettings::default(),
            exposure: Exposure::Auto,
            seed: 1,
            samples: None,
        }
    }
}

/// How irradiance becomes a colour between 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// The brightest hundredth of the lit area just saturates.
    Auto,
    /// `exposure = 2^EV`.
    Ev(f64),
}
