//! Arguments checked and made usable.

use super::args::SceneArgs;
use glam::DVec3;
use std::path::{Path, PathBuf};
use umbrage::bad_input::BadInput;
use umbrage::budget::Budget;
use umbrage::io::{ReadSettings, Unit, UpAxis, builtin, read_scene};
use umbrage::radiosity::Bounces;
use umbrage::scene::{CleanSettings, RawScene};
use umbrage::settings::{Exposure, Settings};

/// The scene named by the arguments, or the built-in one.
pub(super) fn scene(args: &SceneArgs) -> Result<RawScene, BadInput> {
    // A wrong unit is told even where there is no file to use it on.
    let settings = read_settings(args)?;
    match &args.scene {
        None => Ok(builtin::cornell_box()),
        Some(path) => read_scene(path, &settings),
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
    let up = up(args)?;
    Ok(ReadSettings { unit, up })
}

/// The axis that points up in the file.
pub(super) fn up(args: &SceneArgs) -> Result<UpAxis, BadInput> {
    args.up
        .parse()
        .map_err(|_| BadInput::new("--up", format!("\"{}\" is no axis", args.up), "give y or z"))
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
        budget: match &args.budget {
            Some(text) => text.parse()?,
            None => Budget::default(),
        },
        bounces,
        solver: args.solver.parse()?,
        basis: args.basis.parse()?,
        clean: CleanSettings {
            weld_distance: positive("--weld", args.weld)?,
            planarity: positive("--planarity", args.planarity)?,
        },
        exposure,
        seed: args.seed,
        samples: args.samples,
        ..Settings::default()
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

/// Refuses to write over the scene, or two results into one file.
pub(super) fn check_outputs(args: &SceneArgs, outputs: &[&Path]) -> Result<(), BadInput> {
    let inputs: Vec<&Path> = args.scene.iter().map(PathBuf::as_path).collect();
    let outputs: Vec<&Path> = outputs
        .iter()
        .copied()
        .chain(args.json.iter().map(PathBuf::as_path))
        .collect();
    check_distinct(&inputs, &outputs)
}

/// Refuses outputs that are inputs, or named twice. Devices may be.
pub(super) fn check_distinct(inputs: &[&Path], outputs: &[&Path]) -> Result<(), BadInput> {
    let place = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let is_device = |path: &Path| path.exists() && !path.is_file();
    for (i, output) in outputs.iter().enumerate() {
        if is_device(output) {
            continue;
        }
        let same = |other: &&Path| place(other) == place(output);
        let what = if inputs.iter().any(same) {
            "is read and would be written over"
        } else if outputs[..i].iter().any(same) {
            "is named for two results"
        } else {
            continue;
        };
        return Err(BadInput::new(
            output.display().to_string(),
            what,
            "name another file",
        ));
    }
    Ok(())
}

/// All bytes of a file.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, BadInput> {
    std::fs::read(path).map_err(|error| {
        BadInput::new(
            path.display().to_string(),
            format!("cannot be read: {error}"),
            "check the path and the permissions",
        )
    })
}

/// The line that tells of a file.
pub(super) fn written(path: &Path, bytes: usize) -> String {
    format!("written      {} ({})\n", path.display(), size(bytes as u64))
}

/// A number of bytes for people.
pub(super) fn size(bytes: u64) -> String {
    let b = bytes as f64;
    match bytes {
        0..1_000 => format!("{bytes} bytes"),
        1_000..1_000_000 => format!("{:.0} kB", b / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", b / 1e6),
        _ => format!("{:.2} GB", b / 1e9),
    }
}

/// Pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PictureSize {
    pub(super) width: u32,
    pub(super) height: u32,
}

/// `WxH`.
pub(super) fn picture_size(text: &str) -> Result<PictureSize, String> {
    let (w, h) = text.split_once(['x', 'X', '×']).unwrap_or((text, ""));
    match (w.parse(), h.parse()) {
        (Ok(width), Ok(height)) if width > 0 && height > 0 => Ok(PictureSize { width, height }),
        _ => Err("give width and height in pixels, such as 800x600".to_owned()),
    }
}

/// `x,y,z`.
pub(super) fn vector(text: &str) -> Result<DVec3, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map_while(|part| part.trim().parse().ok())
        .filter(|n: &f64| n.is_finite())
        .collect();
    match numbers[..] {
        [x, y, z] if text.split(',').count() == 3 => Ok(DVec3::new(x, y, z)),
        _ => Err("give three numbers with commas between them, such as 0,1.5,-2".to_owned()),
    }
}

/// A number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("give a number above 0".to_owned()),
    }
}

/// Lumens a watt, above zero.
pub(super) fn efficacy(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(lm) if lm > 0.0 && lm.is_finite() => Ok(lm),
        _ => Err("give lumens a watt, such as 179 (or 1 where the scene is in lumens)".to_owned()),
    }
}

/// Degrees between 0 and 180, as radians.
pub(super) fn angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees.to_radians()),
        _ => Err("give an angle between 0 and 180 degrees".to_owned()),
    }
}
