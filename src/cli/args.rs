//! Arguments as typed.

use super::bake::BakeArgs;
use super::compare::CompareArgs;
use super::inspect::InspectArgs;
use super::probe::ProbeArgs;
use super::render::RenderArgs;
use super::report::ReportArgs;
use clap::{Args as ClapArgs, Parser, Subcommand};
use std::path::PathBuf;

/// Light that is right, baked into the mesh.
#[derive(Debug, Parser)]
#[command(name = "umbrage", version, about, max_term_width = 100)]
pub(super) struct Args {
    #[command(subcommand)]
    pub(super) command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Scene in, lit glTF out. Without a scene: the built-in Cornell box, and a picture of it
    Bake(BakeArgs),
    /// Irradiance at points: a sensor grid
    Probe(ProbeArgs),
    /// What the mesher saw: lines, meshes, what was repaired, what was left out
    Inspect(InspectArgs),
    /// A picture of a lit glTF
    Render(RenderArgs),
    /// Golden-image check: exit code 0 within the tolerance, 1 beyond it
    Compare(CompareArgs),
    /// Error against run time and elements for every way to mesh and solve: tables, plots and one page
    Report(ReportArgs),
}

/// How a scene is read and lit.
#[derive(Clone, Debug, ClapArgs)]
pub(super) struct SceneArgs {
    /// Scene: .obj (with .mtl), .gltf or .glb; the built-in Cornell box when left out
    pub(super) scene: Option<PathBuf>,
    /// Relative RMS error of irradiance over the lit surfaces that you accept
    #[arg(long, default_value_t = 0.01, allow_negative_numbers = true)]
    pub(super) error: f64,
    /// Stops at the best mesh within any of these, and says what error that is
    #[arg(long, value_name = "elements=N,time=SECONDS,memory=MB")]
    pub(super) budget: Option<String>,
    /// Length of one unit of an OBJ file
    #[arg(long, value_name = "m|cm|mm|in|ft")]
    pub(super) unit: Option<String>,
    /// The axis that points up in the file; what is written has y up
    #[arg(long, default_value = "y", value_name = "y|z")]
    pub(super) up: String,
    /// How often light is reflected: a number, or all
    #[arg(
        long,
        default_value = "all",
        value_name = "N|all",
        allow_negative_numbers = true
    )]
    pub(super) bounces: String,
    /// How light between surfaces is solved for: hierarchical chooses by the scene between gauss-seidel and gmres
    #[arg(
        long,
        default_value = "hierarchical",
        value_name = "hierarchical|gauss-seidel|progressive|gmres|lu|jacobi|sor"
    )]
    pub(super) solver: String,
    /// What the surfaces know of the light that they reflect: linear or constant over each of their cells, or linear told by
    /// wavelets, of which links leave out those that do not matter
    #[arg(long, default_value = "linear", value_name = "linear|constant|wavelet")]
    pub(super) basis: String,
    /// Threads; all processors when left out
    #[arg(long, allow_negative_numbers = true)]
    pub(super) threads: Option<usize>,
    /// Seed of the points at which the error is measured
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// Number of points at which the error is measured; 1000 to 5000, one for four lit sides, when left out
    #[arg(long)]
    pub(super) samples: Option<u32>,
    /// Below this distance two points are the same point, metres; a millionth of the scene when left out
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    pub(super) weld: Option<f64>,
    /// How far a corner may lie outside its face's plane, metres; the weld distance when left out
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    pub(super) planarity: Option<f64>,
    /// Writes the summary for machines (docs/summary.md)
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Says nothing but errors
    #[arg(long)]
    pub(super) quiet: bool,
    /// Says more: every warning, and in a log each stage as it begins
    #[arg(short, long)]
    pub(super) verbose: bool,
}
