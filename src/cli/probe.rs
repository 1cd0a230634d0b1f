//! `umbrage probe`: irradiance at points.

use super::args::SceneArgs;
use super::{Outcome, lighting, options, terminal};
use clap::{Args as ClapArgs, ValueEnum};
use std::fmt::Write;
use std::io::Read;
use std::path::{Path, PathBuf};
use umbrage::bad_input::BadInput;
use umbrage::direct::DirectLight;
use umbrage::io::{SensorList, read_sensors, write_atomically};
use umbrage::pipeline::{Reading, probe_exact, probe_mesh};
use umbrage::quantity::Irradiance;
use umbrage::radiosity::Bounces;
use umbrage::settings::Exposure;

#[derive(Debug, ClapArgs)]
pub(super) struct ProbeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// One point a line: x y z nx ny nz, metres in the scene's own frame; - reads standard input
    #[arg(long, value_name = "FILE|-", allow_hyphen_values = true)]
    points: PathBuf,
    /// Where E_r E_g E_b go, W/m², one line a point; standard output when left out
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// What a viewer of the baked mesh shows, or what is there
    #[arg(long, value_enum, default_value_t = Source::Mesh)]
    from: Source,
    /// Which light
    #[arg(long, value_enum, default_value_t = Terms::Total)]
    terms: Terms,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Source {
    /// Interpolated over the baked mesh; a point on no surface is an error
    Mesh,
    /// Direct light exactly at the point, indirect light gathered from the solution
    Exact,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Terms {
    /// Straight from the emitters
    Direct,
    /// By way of other surfaces
    Indirect,
    /// Both
    Total,
}

pub(super) fn run(args: &ProbeArgs) -> anyhow::Result<Outcome> {
    let outputs: Vec<&Path> = args.output.iter().map(PathBuf::as_path).collect();
    options::check_outputs(&args.scene, &outputs)?;
    options::check_distinct(&[&args.points], &outputs)?;
    let list = read_points(args)?;
    let readings = readings(args, &list, &outputs)?;
    let mut text = String::new();
    for reading in readings {
        let [r, g, b] = of(&reading, args.terms).0.to_array();
        // 17 significant digits bring every f64 back; writing to a string cannot fail.
        let _ = writeln!(text, "{r:.16e} {g:.16e} {b:.16e}");
    }
    match &args.output {
        Some(path) => write_atomically(path, text.as_bytes())?,
        None => terminal::print(&text)?,
    }
    Ok(Outcome::Done)
}

fn read_points(args: &ProbeArgs) -> anyhow::Result<SensorList> {
    let is_stdin = args.points == Path::new("-");
    let source = if is_stdin {
        "standard input".to_owned()
    } else {
        args.points.display().to_string()
    };
    let bytes = if is_stdin {
        let mut bytes = Vec::new();
        std::io::stdin().read_to_end(&mut bytes).map_err(|error| {
            let what = format!("cannot be read: {error}");
            BadInput::new(&source, what, "pipe the points in, or name a file")
        })?;
        bytes
    } else {
        options::read_file(&args.points)?
    };
    let text = String::from_utf8(bytes)
        .map_err(|_| BadInput::new(&source, "is no text (UTF-8)", "write x y z nx ny nz a line"))?;
    let up = options::up(&args.scene)?;
    Ok(read_sensors(&source, &text, up)?)
}

fn readings(
    args: &ProbeArgs,
    list: &SensorList,
    outputs: &[&Path],
) -> anyhow::Result<Vec<Reading>> {
    let scene = &args.scene;
    options::use_threads(scene.threads)?;
    let prepared = lighting::prepare(scene, Exposure::Auto)?;
    let world = &prepared.world;
    let has_indirect =
        args.terms != Terms::Direct && prepared.settings.bounces != Bounces::Count(0);
    // Without a solution there is no summary to write either.
    if args.from == Source::Exact && !has_indirect && scene.json.is_none() {
        let direct = DirectLight::new(&world.scene, &world.blockers);
        return Ok(probe_exact(world, &direct, None, &list.sensors));
    }
    let lit = lighting::solve(&prepared, scene)?;
    let solution = &lit.solution;
    let readings = match args.from {
        Source::Exact => probe_exact(
            world,
            &solution.direct,
            solution.indirect.as_ref(),
            &list.sensors,
        ),
        Source::Mesh => probe_mesh(solution, &list.sensors).map_err(|missing| {
            BadInput::new(
                format!("{}:{}", list.source, list.lines[missing.index]),
                format!(
                    "the point {} (limit: {:.1e} m, the weld distance)",
                    missing.place, world.scene.weld_distance
                ),
                "move it onto a face, or use --from exact",
            )
        })?,
    };
    lit.write_json("probe", scene, &prepared.settings, outputs)?;
    Ok(readings)
}

fn of(reading: &Reading, terms: Terms) -> Irradiance {
    match terms {
        Terms::Direct => reading.direct,
        Terms::Indirect => reading.indirect,
        Terms::Total => reading.total(),
    }
}
