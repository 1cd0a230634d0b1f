//! Arguments as typed.

use clap::{Args as ClapArgs, Parser, Subcommand};
use std::path::PathBuf;

/// Light that is right, baked into the mesh.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Scene in, lit glTF out. Without a scene: the built-in Cornell box
    Bake(BakeArgs),
}

/// How a scene is read and lit.
#[derive(Debug, ClapArgs)]
pub(crate) struct SceneArgs {
    /// Scene: .obj (with .mtl), .gltf or .glb; the built-in Cornell box when left out
    pub(crate) scene: Option<PathBuf>,
    /// Relative RMS error of irradiance over the lit surfaces that you accept
    #[arg(long, default_value_t = 0.01)]
    pub(crate) error: f64,
    /// Length of one unit of an OBJ file
    #[arg(long, value_name = "m|cm|mm|in|ft")]
    pub(crate) unit: Option<String>,
    /// The axis that points up in the file
    #[arg(long, default_value = "y", value_name = "y|z")]
    pub(crate) up: String,
    /// How often light is reflected: a number, or all
    #[arg(long, default_value = "all", value_name = "N|all")]
    pub(crate) bounces: String,
    /// Threads; all processors when left out
    #[arg(long)]
    pub(crate) threads: Option<usize>,
    /// Seed of the points at which the error is measured
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Number of points at which the error is measured
    #[arg(long, default_value_t = 1000)]
    pub(crate) samples: u32,
    /// Below this distance two points are the same point, metres; a millionth of the scene when left out
    #[arg(long)]
    pub(crate) weld: Option<f64>,
    /// How far a corner may lie outside its face's plane, metres; the weld distance when left out
    #[arg(long)]
    pub(crate) planarity: Option<f64>,
    /// Writes the summary for machines
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Says nothing but errors
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Says more: every warning
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct BakeArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// The lit glTF; SCENE.lit.glb when left out
    #[arg(short, long, value_name = "OUT.glb")]
    pub(crate) output: Option<PathBuf>,
    /// Brightness: auto, or EV (colours are scaled by 2^EV)
    #[arg(
        long,
        default_value = "auto",
        value_name = "auto|EV",
        allow_hyphen_values = true
    )]
    pub(crate) exposure: String,
}
