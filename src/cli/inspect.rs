//! `umbrage inspect`: what the mesher saw.

use super::args::SceneArgs;
use super::faces::{Side, find_face};
use super::table::{faces_table, statistics_table, summary_table};
use super::{Outcome, lighting, options, terminal};
use clap::Args as ClapArgs;
use std::path::{Path, PathBuf};
use umbrage::bad_input::BadInput;
use umbrage::discontinuity::DiscontinuityOrder;
use umbrage::form_factor::FormFactors;
use umbrage::io::{
    LineSet, candidates_csv, face_svg, form_factors_csv, lines_csv, read_lit, write_atomically,
    write_lines_glb,
};
use umbrage::pipeline::{EdgeRole, Solution, line_records, mesh_edges};
use umbrage::quantity::WHITE_EFFICACY;
use umbrage::render::{LightUnit, LitModel};
use umbrage::scene::{FaceId, FaceSide};
use umbrage::settings::Exposure;
use umbrage::viewer::Page;

#[derive(Debug, ClapArgs)]
pub(super) struct InspectArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The discontinuity lines that the meshes hold, as CSV
    #[arg(long, value_name = "FILE.csv")]
    lines: Option<PathBuf>,
    /// All lines that were found, as CSV with a column kept
    #[arg(long, value_name = "FILE.csv")]
    candidates: Option<PathBuf>,
    /// Element edges over faint faces, discontinuities coloured by order
    #[arg(long, value_name = "FILE.glb")]
    mesh: Option<PathBuf>,
    /// Form factors between all sides of faces, one pair a row, as exact as --error; for scenes of up to some hundred faces
    #[arg(long, value_name = "FILE.csv")]
    form_factors: Option<PathBuf>,
    /// A page to look around in with any browser: the light, its error, the lines and what makes them.
    /// LIT.glb instead of a scene shows the light that the file holds
    #[arg(long, value_name = "OUT.html")]
    html: Option<PathBuf>,
    /// Lumens a watt of white, for illuminance
    #[arg(long, value_name = "LM/W", default_value_t = WHITE_EFFICACY, value_parser = options::efficacy)]
    efficacy: f64,
    /// One face flat and to scale
    #[arg(long, value_name = "FACE.svg", requires = "face")]
    svg: Option<PathBuf>,
    /// Least, mean and most light on every face, or on --face, and its uniformity (least / mean): what the mesh shows
    #[arg(long)]
    statistics: bool,
    /// --statistics in lux instead of W/m² (mean of the channels)
    #[arg(long, requires = "statistics")]
    lux: bool,
    /// The face of --svg and --statistics: the name of its object, or its number; -v lists them
    #[arg(long, value_name = "NAME|INDEX")]
    face: Option<String>,
    /// The side of --face
    #[arg(long, value_enum, default_value_t = Side::Front)]
    side: Side,
}

/// Colours of the sets of lines, linear: grey elements, black outlines, and D0, D1, D2 as in the drawings of faces.
const SETS: [(&str, EdgeRole, [f64; 3]); 5] = [
    ("elements", EdgeRole::Inner, [0.2, 0.2, 0.2]),
    ("outlines", EdgeRole::Outline, [0.0, 0.0, 0.0]),
    (
        "D0",
        EdgeRole::Break(DiscontinuityOrder::D0),
        [0.665, 0.112, 0.0],
    ),
    (
        "D1",
        EdgeRole::Break(DiscontinuityOrder::D1),
        [0.0, 0.168, 0.445],
    ),
    (
        "D2",
        EdgeRole::Break(DiscontinuityOrder::D2),
        [0.0, 0.342, 0.171],
    ),
];

pub(super) fn run(args: &InspectArgs) -> anyhow::Result<Outcome> {
    let scene = &args.scene;
    let outputs: Vec<&Path> = [
        &args.lines,
        &args.candidates,
        &args.mesh,
        &args.form_factors,
        &args.html,
        &args.svg,
    ]
    .into_iter()
    .flatten()
    .map(PathBuf::as_path)
    .collect();
    options::check_outputs(scene, &outputs)?;
    options::use_threads(scene.threads)?;
    if args.face.is_some() && args.svg.is_none() && !args.statistics {
        return Err(BadInput::new(
            "--face",
            "nothing is asked about the face",
            "add --statistics, or --svg FACE.svg",
        )
        .into());
    }
    if let Some((path, model)) = scene.scene.as_ref().zip(lit_model(args)?) {
        return inspect_lit(args, path, &model);
    }
    let prepared = lighting::prepare(scene, Exposure::Auto)?;
    // A wrong name is told before the work, not after it.
    let side = args.side.into();
    let face = args.face.as_ref();
    let face = face
        .map(|name| find_face(&prepared.world.scene, name))
        .transpose()?;
    let lit = lighting::solve(&prepared, scene)?;
    let solution = &lit.solution;

    let mut files: Vec<(&Path, Vec<u8>)> = Vec::new();
    let records = line_records(solution);
    if let Some(path) = &args.lines {
        files.push((path, lines_csv(&records).into_bytes()));
    }
    if let Some(path) = &args.candidates {
        files.push((path, candidates_csv(&records).into_bytes()));
    }
    if let Some(path) = &args.mesh {
        files.push((path, mesh_glb(solution)));
    }
    if let Some(path) = &args.form_factors {
        let world = &prepared.world;
        let factors = FormFactors::new(&world.scene, &world.blockers, prepared.settings.error);
        files.push((path, form_factors_csv(&factors).into_bytes()));
    }
    if let Some(path) = &args.html {
        let page = Page::of_solution(solution, Some(args.efficacy))?;
        files.push((path, page.html().into_bytes()));
    }
    if let (Some(path), Some(face)) = (&args.svg, face) {
        let svg = face_svg(solution, find_receiver(solution, face, side)?);
        files.push((path, svg.into_bytes()));
    }
    for (path, bytes) in &files {
        write_atomically(path, bytes)?;
    }
    lit.write_json("inspect", scene, &prepared.settings, &outputs)?;
    if !scene.quiet {
        let mut text = String::new();
        if files.is_empty() || scene.verbose {
            text = summary_table(&prepared.world, lit.summary());
        }
        if args.statistics {
            let unit = match args.lux {
                true => LightUnit::Lux {
                    efficacy: args.efficacy,
                },
                false => LightUnit::WattsPerSquareMetre,
            };
            let only = face.map(|f| find_receiver(solution, f, side)).transpose()?;
            text = statistics_table(solution, only, unit);
        }
        if scene.verbose {
            text.push_str(&faces_table(solution));
        }
        for (path, bytes) in &files {
            text.push_str(&options::written(path, bytes.len()));
        }
        terminal::print(&text)?;
    }
    Ok(Outcome::Done)
}

/// The lit model in the file, when it is one that was baked and a page of it is asked for.
fn lit_model(args: &InspectArgs) -> Result<Option<LitModel>, BadInput> {
    let Some(path) = args.scene.scene.as_ref().filter(|_| args.html.is_some()) else {
        return Ok(None);
    };
    if path
        .extension()
        .is_none_or(|e| !e.eq_ignore_ascii_case("glb"))
    {
        return Ok(None);
    }
    let bytes = options::read_file(path)?;
    let model = read_lit(&path.display().to_string(), &bytes);
    Ok(model.ok().filter(|model| model.exposure.is_some()))
}

/// A page of a lit file, which holds nothing else of what `inspect` can tell.
fn inspect_lit(args: &InspectArgs, lit: &Path, model: &LitModel) -> anyhow::Result<Outcome> {
    let others = [
        &args.lines,
        &args.candidates,
        &args.mesh,
        &args.form_factors,
        &args.svg,
    ];
    if others.iter().any(|o| o.is_some()) || args.scene.json.is_some() {
        return Err(BadInput::new(
            lit.display().to_string(),
            "is lit already: it holds its light, but neither lines nor faces",
            "give the scene that it was baked from, or --html alone",
        )
        .into());
    }
    let Some(path) = &args.html else {
        return Ok(Outcome::Done);
    };
    let html = Page::of_model(model, Some(args.efficacy))?.html();
    write_atomically(path, html.as_bytes())?;
    if !args.scene.quiet {
        terminal::print(&options::written(path, html.len()))?;
    }
    Ok(Outcome::Done)
}

fn mesh_glb(solution: &Solution) -> Vec<u8> {
    let mut sets = SETS.map(|(name, _, colour)| LineSet {
        name: name.to_owned(),
        colour,
        segments: Vec::new(),
    });
    for r in &solution.receivers {
        for edge in mesh_edges(r) {
            let ends = edge.ends.map(|p| r.domain.frame.to_space(p));
            for ((_, role, _), set) in SETS.iter().zip(&mut sets) {
                if *role == edge.role {
                    set.segments.push(ends);
                }
            }
        }
    }
    let lit = solution.lit_scene();
    write_lines_glb(lit.origin, &lit.meshes, &sets)
}

fn find_receiver(solution: &Solution, face: FaceId, side: FaceSide) -> Result<usize, BadInput> {
    solution
        .receivers
        .binary_search_by_key(&(face, side), |r| (r.domain.face, r.domain.side))
        .map_err(|_| {
            BadInput::new(
                "--side",
                format!("no light reaches the back of face {face}, so it has no mesh"),
                "draw its front, or a face that is lit",
            )
        })
}
