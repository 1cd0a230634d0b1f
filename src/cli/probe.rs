//! `umbrage probe`: irradiance at points.

use super::args::SceneArgs;
use super::faces::{Side, find_face};
use super::lighting::Prepared;
use super::{Outcome, lighting, options, table, terminal};
use clap::{Args as ClapArgs, ValueEnum};
use std::fmt::Write;
use std::io::Read;
use std::path::{Path, PathBuf};
use umbrage::bad_input::BadInput;
use umbrage::direct::DirectLight;
use umbrage::io::{SensorList, read_sensors, readings_csv, write_atomically};
use umbrage::pipeline::{Reading, Sensor, World, probe_exact, probe_mesh};
use umbrage::quantity::{Irradiance, WHITE_EFFICACY};
use umbrage::radiosity::Bounces;
use umbrage::render::LightUnit;
use umbrage::report::{LightStatistics, face_grid};
use umbrage::settings::Exposure;

#[derive(Debug, ClapArgs)]
pub(super) struct ProbeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// One point a line: x y z nx ny nz, metres in the scene's own frame, or a CSV with these columns; - reads standard
    /// input
    #[arg(
        long,
        value_name = "FILE|-",
        allow_hyphen_values = true,
        required_unless_present = "grid",
        conflicts_with = "grid"
    )]
    points: Option<PathBuf>,
    /// A grid of points on a face: the name of its object, or its number; inspect -v lists them
    #[arg(long, value_name = "NAME|INDEX")]
    grid: Option<String>,
    /// The side of --grid
    #[arg(long, value_enum, default_value_t = Side::Front, requires = "grid")]
    side: Side,
    /// Largest distance between points of --grid, metres; that of EN 12464-1 for the size of the face when left out
    #[arg(long, value_name = "METRES", requires = "grid", value_parser = options::positive)]
    spacing: Option<f64>,
    /// How far above the face the points of --grid are, metres (0.75 is a desk); needs --from exact
    #[arg(long, value_name = "METRES", requires = "grid", value_parser = options::positive)]
    height: Option<f64>,
    /// A table with a header: the points, E_r E_g E_b, and lux
    #[arg(long)]
    csv: bool,
    /// Lumens a watt of white, for lux
    #[arg(long, value_name = "LM/W", default_value_t = WHITE_EFFICACY, value_parser = options::efficacy)]
    efficacy: f64,
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
    if let Some(points) = &args.points {
        options::check_distinct(&[points], &outputs)?;
    }
    if args.height.is_some() && args.from == Source::Mesh {
        return Err(BadInput::new(
            "--height",
            "the mesh has no light above its faces",
            "add --from exact",
        )
        .into());
    }
    // Points that cannot be read are told before the scene is.
    let list = args
        .points
        .as_ref()
        .map(|p| read_points(args, p))
        .transpose()?;
    let prepared = lighting::prepare(&args.scene, Exposure::Auto)?;
    let list = match (list, &args.grid) {
        (Some(list), _) => list,
        (None, name) => grid(args, &prepared.world, name.as_deref().unwrap_or_default())?,
    };
    let readings = readings(args, &prepared, &list, &outputs)?;
    let light: Vec<Irradiance> = readings.iter().map(|r| of(r, args.terms)).collect();
    let text = if args.csv {
        readings_csv(&list.given, &light, args.efficacy)
    } else {
        plain(&light)
    };
    match &args.output {
        None => terminal::print(&text)?,
        Some(path) => {
            write_atomically(path, text.as_bytes())?;
            if args.grid.is_some() && !args.scene.quiet {
                let efficacy = args.efficacy;
                let found = LightStatistics::of_points(light, LightUnit::Lux { efficacy });
                let unit = format!("lx (at {efficacy} lm/W of white)");
                let mut told = table::points_line(&found, list.sensors.len(), &unit);
                told.push_str(&options::written(path, text.len()));
                terminal::print(&told)?;
            }
        }
    }
    Ok(Outcome::Done)
}

fn plain(light: &[Irradiance]) -> String {
    let mut text = String::new();
    for e in light {
        let [r, g, b] = e.0.to_array();
        // 17 significant digits bring every f64 back; writing to a string cannot fail.
        let _ = writeln!(text, "{r:.16e} {g:.16e} {b:.16e}");
    }
    text
}

/// The grid that was asked for, in the frame of the file.
fn grid(args: &ProbeArgs, world: &World, name: &str) -> anyhow::Result<SensorList> {
    let up = options::up(&args.scene)?;
    let face = find_face(&world.scene, name)
        .map_err(|error| BadInput::new("--grid", error.what, error.remedy))?;
    let height = args.height.unwrap_or(0.0);
    let grid = face_grid(&world.scene, face, args.side.into(), args.spacing, height)?;
    let [nx, ny, nz] = up.from_y_up(grid.normal).to_array();
    let given = grid.points.iter().map(|&p| {
        let [x, y, z] = up.from_y_up(p).to_array();
        [x, y, z, nx, ny, nz]
    });
    let sensors = grid.points.iter();
    Ok(SensorList {
        source: "--grid".to_owned(),
        sensors: sensors
            .filter_map(|&p| Sensor::new(p, grid.normal))
            .collect(),
        lines: (1..=grid.points.len()).collect(),
        given: given.collect(),
    })
}

fn read_points(args: &ProbeArgs, points: &Path) -> anyhow::Result<SensorList> {
    let is_stdin = points == Path::new("-");
    let source = if is_stdin {
        "standard input".to_owned()
    } else {
        points.display().to_string()
    };
    let bytes = if is_stdin {
        let mut bytes = Vec::new();
        std::io::stdin().read_to_end(&mut bytes).map_err(|error| {
            let what = format!("cannot be read: {error}");
            BadInput::new(&source, what, "pipe the points in, or name a file")
        })?;
        bytes
    } else {
        options::read_file(points)?
    };
    let text = String::from_utf8(bytes)
        .map_err(|_| BadInput::new(&source, "is no text (UTF-8)", "write x y z nx ny nz a line"))?;
    let up = options::up(&args.scene)?;
    Ok(read_sensors(&source, &text, up)?)
}

fn readings(
    args: &ProbeArgs,
    prepared: &Prepared,
    list: &SensorList,
    outputs: &[&Path],
) -> anyhow::Result<Vec<Reading>> {
    let scene = &args.scene;
    let world = &prepared.world;
    let has_indirect =
        args.terms != Terms::Direct && prepared.settings.bounces != Bounces::Count(0);
    // Without a solution there is no summary to write either.
    if args.from == Source::Exact && !has_indirect && scene.json.is_none() {
        let direct = DirectLight::new(&world.scene, &world.blockers);
        return Ok(probe_exact(world, &direct, None, &list.sensors));
    }
    let lit = lighting::solve(prepared, scene)?;
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
