//! `umbrage bake`: scene in, lit glTF out.

use super::args::SceneArgs;
use super::table::summary_table;
use super::{Outcome, lighting, options, picture, terminal};
use clap::Args as ClapArgs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use umbrage::io::{read_lit, write_atomically, write_glb, write_png};
use umbrage::render::CameraChoice;

#[derive(Debug, ClapArgs)]
pub(super) struct BakeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The lit glTF; SCENE.lit.glb in the current folder when left out
    #[arg(short, long, value_name = "OUT.glb")]
    output: Option<PathBuf>,
    /// Also a picture, from the first camera of the scene; without a scene one is written beside the glTF
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Brightness: auto, or EV (colours are scaled by 2^EV)
    #[arg(
        long,
        default_value = "auto",
        value_name = "auto|EV",
        allow_hyphen_values = true
    )]
    exposure: String,
}

pub(super) fn run(args: &BakeArgs) -> anyhow::Result<Outcome> {
    let scene = &args.scene;
    let output = args
        .output
        .clone()
        .unwrap_or_else(|| options::default_output(scene.scene.as_deref()));
    let png = match (&args.png, &scene.scene) {
        (None, None) => Some(output.with_extension("png")),
        (png, _) => png.clone(),
    };
    let outputs: Vec<&Path> = [Some(&output), png.as_ref()]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    options::check_outputs(scene, &outputs)?;

    let prepared = lighting::prepare(scene, options::exposure(&args.exposure)?)?;
    let mut lit = lighting::solve(&prepared, scene)?;
    let start = Instant::now();
    let glb = write_glb(&lit.solution.lit_scene());
    let seconds = start.elapsed().as_secs_f64();
    lit.solution.summary.add_time("write", seconds);
    // The picture shows what the file holds, and is there before any file is touched.
    let mut files = vec![(output.as_path(), glb)];
    if let Some(path) = &png {
        let start = Instant::now();
        let model = read_lit(&output.display().to_string(), &files[0].1)?;
        let image = picture::take(&model, &CameraChoice::Auto, None, None)?;
        files.push((path, write_png(&image)));
        let seconds = start.elapsed().as_secs_f64();
        lit.solution.summary.add_time("picture", seconds);
    }
    for (path, bytes) in &files {
        write_atomically(path, bytes)?;
    }
    lit.write_json("bake", scene, &prepared.settings, &outputs)?;
    if !scene.quiet {
        let mut text = summary_table(&prepared.world, lit.summary());
        for (path, bytes) in &files {
            text.push_str(&options::written(path, bytes.len()));
        }
        terminal::print(&text)?;
    }
    Ok(Outcome::Done)
}
