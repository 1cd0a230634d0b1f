//! What a lit scene comes to in numbers, and what the ways to light it are worth.
//!
//! For lighting designers: least, mean and most light of a face or a grid of points. For everybody who asks what the lines
//! are good for: error against work and time for every way to mesh, show and solve, how cost grows with the scene, how stiff
//! and extreme scenes go, as tables, plots and one page; and whether a later version is worse than an earlier one.

mod check;
mod convergence;
mod extremes;
mod fit;
mod grid;
mod growth;
mod methods;
mod page;
mod plot;
mod record;
mod scenes;
mod stability;
mod statistics;
mod tables;

pub use check::regressions;
pub use convergence::{
    ERRORS, MemoryMeter, POINTS, ReportSettings, SceneReport, StageCost, convergence,
};
pub use extremes::many_lamps;
pub use fit::{crossing, exponent};
pub use grid::{FaceGrid, face_grid, standard_spacing};
pub use growth::{GrowthRow, growth};
pub use methods::{BASES, Basis, MESH_METHODS, MeshMethod, SOLVE_METHODS, SolveMethod};
pub use page::{Report, page};
pub use plot::{Curve, Plot};
pub use record::{Record, Work, read_records, records_csv};
pub use scenes::{
    ReportScene, blinds, box_on_floor, city, default_scenes, door_ajar, furnace, moved,
    square_over_square,
};
pub use stability::{StabilityCase, StabilityRow, stability, stability_cases};
pub use statistics::LightStatistics;
pub use tables::{growth_csv, stability_csv, stages_csv};

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests;
