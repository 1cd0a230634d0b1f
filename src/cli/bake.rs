//! `umbrage bake`: scene in, lit glTF out.

use super::args::SceneArgs;
use super::table::summary_table;
use super::{Outcome, fault, lighting, options, picture, terminal};
use clap::Args as ClapArgs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use umbrage::bad_input::BadInput;
use umbrage::io::{read_lit, write_atomically, write_glb, write_png};
use umbrage::render::CameraChoice;

#[derive(Debug, ClapArgs)]
pub(super) struct BakeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// More scenes, each lit by itself: one that fails does not stop the others
    #[arg(value_name = "MORE")]
    more: Vec<PathBuf>,
    /// The lit glTF, or with a slash at its end a folder; SCENE.lit.glb in the current folder when left out
    #[arg(short, long, value_name = "OUT.glb|FOLDER/")]
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
    /// Also the estimated error at every vertex, W/m²: the attribute _ERROR of the glTF
    #[arg(long)]
    error_attribute: bool,
}

pub(super) fn run(args: &BakeArgs) -> anyhow::Result<Outcome> {
    options::use_threads(args.scene.threads)?;
    if args.more.is_empty() {
        let scene = args.scene.scene.as_deref();
        let output = match &args.output {
            Some(path) if is_folder_name(path) => {
                make_folder(path)?;
                path.join(options::default_output(scene))
            }
            Some(path) => path.clone(),
            None => options::default_output(scene),
        };
        return bake_one(args, &args.scene, &output);
    }
    bake_all(args)
}

/// Whether a path says by its last character that it is a folder.
fn is_folder_name(path: &Path) -> bool {
    let text = path.as_os_str().to_string_lossy();
    text.ends_with(std::path::is_separator)
}

fn make_folder(path: &Path) -> Result<(), BadInput> {
    std::fs::create_dir_all(path).map_err(|error| {
        let place = path.display().to_string();
        let what = format!("cannot be made a folder: {error}");
        BadInput::new(place, what, "name a folder that can be written to")
    })
}

/// Bakes every scene. Errors are told as they occur; the last one is their number.
fn bake_all(args: &BakeArgs) -> anyhow::Result<Outcome> {
    for (name, value) in [("--png", &args.png), ("--json", &args.scene.json)] {
        if value.is_some() {
            let what = "names one file, and there are several scenes";
            return Err(BadInput::new(name, what, "bake them one by one").into());
        }
    }
    let first = args.scene.scene.iter();
    let scenes: Vec<&PathBuf> = first.chain(&args.more).collect();
    let folder = args.output.clone().unwrap_or_default();
    let output = |scene: &Path| folder.join(options::default_output(Some(scene)));
    let outputs: Vec<PathBuf> = scenes.iter().map(|scene| output(scene)).collect();
    let inputs: Vec<&Path> = scenes.iter().map(|path| path.as_path()).collect();
    let paths: Vec<&Path> = outputs.iter().map(PathBuf::as_path).collect();
    options::check_distinct(&inputs, &paths)?;
    if args.output.is_some() {
        make_folder(&folder)?;
    }
    let mut failed = 0;
    for (scene, output) in scenes.iter().zip(&outputs) {
        let one = SceneArgs {
            scene: Some(scene.to_path_buf()),
            ..args.scene.clone()
        };
        let done = fault::caught(|| bake_one(args, &one, output));
        let error = match done {
            Ok(Ok(_)) => continue,
            Ok(Err(error)) => format!("{error:#}"),
            Err(fault) => fault,
        };
        terminal::error(&error);
        failed += 1;
    }
    if failed == 0 {
        return Ok(Outcome::Done);
    }
    let what = format!("{failed} of {} scenes were not baked", scenes.len());
    Err(BadInput::new(
        "bake",
        what,
        "see the errors above; the others are complete",
    )
    .into())
}

fn bake_one(args: &BakeArgs, scene: &SceneArgs, output: &Path) -> anyhow::Result<Outcome> {
    let png = match (&args.png, &scene.scene) {
        (None, None) => Some(output.with_extension("png")),
        (png, _) => png.clone(),
    };
    let outputs: Vec<&Path> = [Some(output), png.as_deref()]
        .into_iter()
        .flatten()
        .collect();
    options::check_outputs(scene, &outputs)?;

    let prepared = lighting::prepare(scene, options::exposure(&args.exposure)?)?;
    let mut lit = lighting::solve(&prepared, scene)?;
    if args.error_attribute {
        let start = Instant::now();
        lit.solution.estimate_error();
        let seconds = start.elapsed().as_secs_f64();
        lit.solution.summary.add_time("estimate", seconds);
    }
    let start = Instant::now();
    let glb = write_glb(&lit.solution.lit_scene());
    let seconds = start.elapsed().as_secs_f64();
    lit.solution.summary.add_time("write", seconds);
    // The picture shows what the file holds, and is there before any file is touched.
    let mut files = vec![(output, glb)];
    if let Some(path) = &png {
        let start = Instant::now();
        let model = read_lit(&output.display().to_string(), &files[0].1)?;
        let image = picture::take(&model, &CameraChoice::Auto, None, None, None)?;
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
