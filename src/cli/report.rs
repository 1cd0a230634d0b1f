//! `umbrage report`: what the ways to light a scene are worth, as tables, plots and one page.

use super::args::SceneArgs;
use super::picture;
use super::progress::Shown;
use super::{Outcome, memory, options, terminal};
use clap::Args as ClapArgs;
use std::path::{Path, PathBuf};
use umbrage::bad_input::BadInput;
use umbrage::io::{read_lit, write_atomically, write_png};
use umbrage::pipeline::LightError;
use umbrage::quantity::WHITE_EFFICACY;
use umbrage::radiosity::{Basis, Solver};
use umbrage::render::{CameraChoice, ColourScale, LightUnit, round_top};
use umbrage::report::{
    ERRORS, MemoryMeter, POINTS, Record, Report, ReportScene, ReportSettings, SceneReport,
    convergence, default_scenes, growth, growth_csv, page, read_records, records_csv, regressions,
    stability, stability_csv, stages_csv,
};
use umbrage::settings::{Exposure, Settings};

#[derive(Debug, ClapArgs)]
pub(super) struct ReportArgs {
    /// Scenes: .obj, .gltf or .glb; three built-in ones when left out, and with them how cost grows and how stiff and
    /// extreme scenes go
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Folder for report.html, the tables (.csv) and the plots (.svg)
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Errors asked for, from coarse to fine
    #[arg(long, value_name = "E,E,…", value_delimiter = ',', default_values_t = ERRORS)]
    errors: Vec<f64>,
    /// Fails (exit code 1) when a run of this runs.csv of an earlier report has become less exact or takes more counted work
    #[arg(long, value_name = "BASELINE.csv")]
    check: Option<PathBuf>,
    /// How often light is reflected: a number, or all
    #[arg(long, default_value = "all", value_name = "N|all")]
    bounces: String,
    /// Length of one unit of OBJ files
    #[arg(long, value_name = "m|cm|mm|in|ft")]
    unit: Option<String>,
    /// The axis that points up in the files
    #[arg(long, default_value = "y", value_name = "y|z")]
    up: String,
    /// Threads; all processors when left out
    #[arg(long)]
    threads: Option<usize>,
    /// Says nothing but errors and what got worse
    #[arg(long)]
    quiet: bool,
}

/// Pixels of the pictures on the page.
const PICTURE: options::PictureSize = options::PictureSize {
    width: 320,
    height: 240,
};

pub(super) fn run(args: &ReportArgs) -> anyhow::Result<Outcome> {
    options::use_threads(args.threads)?;
    for &error in &args.errors {
        if !(error > 0.0 && error < 1.0) {
            let what = format!("{error} is outside 0…1");
            return Err(
                BadInput::new("--errors", what, "give errors such as 0.05,0.02,0.01").into(),
            );
        }
    }
    // A baseline that cannot be read is told before the work, and read before it may be written over.
    let baseline = args.check.as_deref().map(read_baseline).transpose()?;
    let (scenes, settings) = scenes(args)?;
    std::fs::create_dir_all(&args.output).map_err(|error| {
        BadInput::new(
            args.output.display().to_string(),
            format!("cannot be made a folder: {error}"),
            "name a folder that can be written",
        )
    })?;
    let report = measure(args, &scenes, settings)?;
    let records: Vec<Record> = report
        .scenes
        .iter()
        .flat_map(|s| s.records.clone())
        .collect();
    write(args, &report, &records)?;
    if !args.quiet {
        terminal::print(&told(args, &report))?;
    }
    let unsound = report.stability.iter().filter(|r| !r.is_sound());
    let mut faults: Vec<String> = Vec::new();
    if let Some(baseline) = baseline {
        faults.extend(unsound.map(|r| format!("{}: is not sound", r.name)));
        // Both as the table has them.
        let now = read_records(&records_csv(&records))
            .map_err(|(line, what)| anyhow::anyhow!("row {line} {what}"))?;
        faults.extend(regressions(&now, &baseline));
        let verdict = match faults.len() {
            0 => "no worse than the baseline".to_owned(),
            n => format!("worse than the baseline in {n} ways"),
        };
        terminal::print(&format!(
            "{}{verdict}\n",
            faults
                .iter()
                .map(|f| format!("worse        {f}\n"))
                .collect::<String>()
        ))?;
    }
    Ok(match faults.is_empty() {
        true => Outcome::Done,
        false => Outcome::CheckFailed,
    })
}

fn read_baseline(path: &Path) -> Result<Vec<Record>, BadInput> {
    let place = path.display().to_string();
    let remedy = "give a runs.csv that umbrage report wrote";
    let text = String::from_utf8(options::read_file(path)?)
        .map_err(|_| BadInput::new(&place, "is no text (UTF-8)", remedy))?;
    let records = read_records(&text)
        .map_err(|(line, what)| BadInput::new(format!("{place}:{line}"), what, remedy))?;
    if records.is_empty() {
        return Err(BadInput::new(place, "holds no runs", remedy));
    }
    Ok(records)
}

/// The scenes that were named, or the built-in ones, and how they are lit.
fn scenes(args: &ReportArgs) -> Result<(Vec<ReportScene>, Settings), BadInput> {
    let arguments = |scene: Option<PathBuf>| SceneArgs {
        scene,
        error: ERRORS[0],
        unit: args.unit.clone(),
        up: args.up.clone(),
        budget: None,
        bounces: args.bounces.clone(),
        solver: Solver::default().name().to_owned(),
        basis: Basis::default().name().to_owned(),
        threads: None,
        seed: 1,
        samples: Settings::default().samples,
        weld: None,
        planarity: None,
        json: None,
        quiet: args.quiet,
        verbose: false,
    };
    let settings = options::settings(&arguments(None), Exposure::Auto)?;
    if args.scenes.is_empty() {
        return Ok((default_scenes(), settings));
    }
    let read = |path: &PathBuf| {
        Ok(ReportScene {
            name: path
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            raw: options::scene(&arguments(Some(path.clone())))?,
            bounces: settings.bounces,
        })
    };
    let scenes: Result<Vec<ReportScene>, BadInput> = args.scenes.iter().map(read).collect();
    let scenes = scenes?;
    for (i, scene) in scenes.iter().enumerate() {
        if scenes[..i].iter().any(|s| s.name == scene.name) {
            return Err(BadInput::new(
                args.scenes[i].display().to_string(),
                format!("another scene is called {}, too", scene.name),
                "rename one of the files, or report on them apart",
            ));
        }
    }
    Ok((scenes, settings))
}

fn measure(
    args: &ReportArgs,
    scenes: &[ReportScene],
    settings: Settings,
) -> Result<Report, LightError> {
    let shown = Shown::new(args.quiet, false);
    let mut tell = |what: &str| shown.tell(what);
    let mut errors = args.errors.clone();
    errors.sort_unstable_by(|a, b| b.total_cmp(a));
    errors.dedup();
    let asked = ReportSettings {
        errors,
        settings,
        points: POINTS,
    };
    let meter = MemoryMeter {
        reset: memory::reset_peak,
        peak: umbrage::budget::peak_bytes,
    };
    let mut report = Report::default();
    for scene in scenes {
        report
            .scenes
            .push(convergence(scene, &asked, meter, &mut tell)?);
    }
    if args.scenes.is_empty() {
        report.growth = growth(&mut tell)?;
        report.stability = stability(&mut tell)?;
    }
    shown.finish();
    Ok(report)
}

fn write(args: &ReportArgs, report: &Report, records: &[Record]) -> anyhow::Result<()> {
    let pictures = report
        .scenes
        .iter()
        .map(pictures)
        .collect::<Result<Vec<_>, _>>()?;
    let mut files = vec![
        ("report.html".to_owned(), page(report, &pictures)),
        ("runs.csv".to_owned(), records_csv(records)),
        ("stages.csv".to_owned(), stages_csv(&report.scenes)),
    ];
    if !report.growth.is_empty() {
        files.push(("growth.csv".to_owned(), growth_csv(&report.growth)));
        files.push(("stability.csv".to_owned(), stability_csv(&report.stability)));
    }
    let plots = report.plots().into_iter();
    files.extend(plots.map(|(name, plot)| (format!("{name}.svg"), plot.svg())));
    for (name, text) in files {
        write_atomically(&args.output.join(name), text.as_bytes())?;
    }
    Ok(())
}

/// The scene as its first camera, or one in front of it, sees it, and the light on it.
fn pictures(scene: &SceneReport) -> Result<Vec<(String, Vec<u8>)>, BadInput> {
    let model = read_lit(&scene.name, &scene.glb)?;
    let unit = LightUnit::Lux {
        efficacy: WHITE_EFFICACY,
    };
    let light = model.triangle_light().into_iter();
    let top = round_top(light.map(|(e, area)| (unit.of(e), area)));
    let scale = ColourScale { unit, top };
    let take = |scale| {
        let choice = CameraChoice::Auto;
        let picture = picture::take(&model, &choice, Some(PICTURE), None, scale)?;
        Ok(write_png(&picture))
    };
    Ok(vec![
        ("lit".to_owned(), take(None)?),
        (
            format!("illuminance at {WHITE_EFFICACY} lm/W of white"),
            take(Some(&scale))?,
        ),
    ])
}

fn told(args: &ReportArgs, report: &Report) -> String {
    let mut text = String::new();
    for scene in &report.scenes {
        for r in scene.records.iter().filter(|r| r.basis == "linear") {
            text.push_str(&format!(
                "{:<22} {:<14} {:<13} asked {:>6.2} %  rms {:>6.2} %  {:>8} elements  {:>7.2} s\n",
                r.scene,
                r.mesh,
                r.solver,
                100.0 * r.asked,
                100.0 * r.rms,
                r.work.elements,
                r.seconds
            ));
        }
    }
    let unsound: Vec<&str> = report
        .stability
        .iter()
        .filter(|r| !r.is_sound())
        .map(|r| r.name.as_str())
        .collect();
    if !report.stability.is_empty() {
        let cases = report.stability.len();
        let rest = match unsound.is_empty() {
            true => String::new(),
            false => format!(": not {}", unsound.join(", ")),
        };
        text.push_str(&format!(
            "stability    {} of {cases} cases are sound{rest}\n",
            cases - unsound.len()
        ));
    }
    let page = args.output.join("report.html");
    text.push_str(&format!("written      {}\n", page.display()));
    text
}
