//! From a polygon soup to a [`Scene`].

use super::{RawScene, Scene};
use crate::bad_input::BadInput;
use crate::warning::Warning;

/// Tolerances of the clean-up, metres; `None` derives them from the scene's diagonal.
#[derive(Clone, Copy, Debug, Default)]
pub struct CleanSettings {
    /// Below this distance two points are the same point.
    pub weld_distance: Option<f64>,
    /// How far a corner may lie outside its face's plane.
    pub planarity: Option<f64>,
}

/// What was repaired.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct CleanReport {
    /// Polygons of the input.
    pub polygons: usize,
}

/// Cleans `raw`.
pub fn clean(
    _raw: &RawScene,
    _settings: &CleanSettings,
) -> Result<(Scene, CleanReport, Vec<Warning>), BadInput> {
    todo!()
}
