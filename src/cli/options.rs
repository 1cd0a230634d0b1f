//! Arguments checked and made usable.

use super::args::SceneArgs;
use std::path::Path;
use umbrage::bad_input::BadInput;
use umbrage::io::{ReadSettings, Unit, UpAxis, builtin, read_scene};
use umbrage::radiosity::Bounces;
use umbrage::scene::{CleanSettings, RawScene};
use umbrage::settings::{Exposure, Settings};

/// The scene named by the arguments, or the built-in one.
pub(super) fn scene(args: &SceneArgs) -> Result<RawScene, BadInput> {
    match &args.scene {
        None => Ok(builtin::cornell_box()),
        Some(path) => read_scene(path, &read_settings(args)?),
    }
}

fn read_settings(args: &SceneArgs) -> Result<ReadSettings, BadInput> {
    let unit = match &args.unit {
        None => None,
        Some(text) => Some(text.parse::<Unit>().map_err(|_| {
            BadInput::new(
                "--unit",
                format!("\"{text}\" is no unit"),
                "give m, cm, mm, in or ft",
            )
        })?),
    };
    let up = args
        .up
        .parse::<UpAxis>()
        .map_err(|_| BadInput::new("--up", format!("\"{}\" is no axis", args.up), "give y or z"))?;
    Ok(ReadSettings { unit, up })
}

/// How to light it.
pub(super) fn settings(args: &SceneArgs, exposure: Exposure) -> Result<Settings, BadInput> {
    if !(args.error > 0.0 && args.error < 1.0) {
        return Err(BadInput::new(
            "--error",
            format!("{} is outside 0…1", args.error),
            "give a relative error such as 0.01 (1 %)",
        ));
    }
    let bounces = if args.bounces == "all" {
        Bounces::All
    } else {
        Bounces::Count(args.bounces.parse().map_err(|_| {
            BadInput::new(
                "--bounces",
                format!("\"{}\" is neither a number nor all", args.bounces),
                "give 0, 1, 2, … or all",
            )
        })?)
    };
    let positive = |name: &str, value: Option<f64>| match value {
        Some(v) if !(v.is_finite() && v >= 0.0) => Err(BadInput::new(
            name,
            format!("{v} is no distance"),
            "give metres, 0 or more",
        )),
        _ => Ok(value),
    };
    Ok(Settings {
        error: args.error,
        bounces,
        clean: CleanSettings {
            weld_distance: positive("--weld", args.weld)?,
            planarity: positive("--planarity", args.planarity)?,
        },
        exposure,
        seed: args.seed,
        samples: args.samples,
    })
}

/// `auto` or a number of stops.
pub(super) fn exposure(text: &str) -> Result<Exposure, BadInput> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    match text.parse::<f64>() {
        Ok(ev) if ev.is_finite() => Ok(Exposure::Ev(ev)),
        _ => Err(BadInput::new(
            "--exposure",
            format!("\"{text}\" is neither auto nor a number"),
            "give auto, or EV such as -2.5",
        )),
    }
}

/// Sets the number of threads for everything that follows.
pub(super) fn use_threads(threads: Option<usize>) -> Result<(), BadInput> {
    let Some(n) = threads else { return Ok(()) };
    if n == 0 {
        return Err(BadInput::new(
            "--threads",
            "0 threads do no work",
            "give 1 or more",
        ));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(n)
        .build_global()
        .map_err(|e| BadInput::new("--threads", e.to_string(), "give a smaller number"))
}

/// `SCENE.lit.glb` in the current directory, `cornell.lit.glb` for the built-in scene.
pub(super) fn default_output(scene: Option<&Path>) -> std::path::PathBuf {
    let stem = scene
        .and_then(Path::file_stem)
        .map_or_else(|| "cornell".into(), |s| s.to_string_lossy().into_owned());
    format!("{stem}.lit.glb").into()
}
