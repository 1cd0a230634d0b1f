//! `umbrage inspect`: what the mesher saw.

use super::args::SceneArgs;
use super::table::{faces_table, summary_table};
use super::{Outcome, lighting, options, terminal};
use clap::{Args as ClapArgs, ValueEnum};
use std::path::{Path, PathBuf};
use umbrage::bad_input::BadInput;
use umbrage::discontinuity::DiscontinuityOrder;
use umbrage::io::{
    LineSet, candidates_csv, face_svg, lines_csv, write_atomically, write_lines_glb,
};
use umbrage::pipeline::{EdgeRole, Solution, line_records, mesh_edges};
use umbrage::scene::{FaceId, FaceSide, Scene};
use umbrage::settings::Exposure;

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
    /// One face flat and to scale
    #[arg(long, value_name = "FACE.svg", requires = "face")]
    svg: Option<PathBuf>,
    /// The face of --svg: the name of its object, or its number; -v lists them
    #[arg(long, value_name = "NAME|INDEX", requires = "svg")]
    face: Option<String>,
    /// The side of --face
    #[arg(long, value_enum, default_value_t = Side::Front)]
    side: Side,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Side {
    /// From which its corners turn counter-clockwise
    Front,
    /// The other one
    Back,
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
    let outputs: Vec<&Path> = [&args.lines, &args.candidates, &args.mesh, &args.svg]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    options::check_outputs(scene, &outputs)?;
    options::use_threads(scene.threads)?;
    let prepared = lighting::prepare(scene, Exposure::Auto)?;
    // A wrong name is told before the work, not after it.
    let side = match args.side {
        Side::Front => FaceSide::Front,
        Side::Back => FaceSide::Back,
    };
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

/// The face of that object, or of that number; names go before numbers.
fn find_face(scene: &Scene, name: &str) -> Result<FaceId, BadInput> {
    let named: Vec<FaceId> = scene
        .faces
        .iter()
        .filter(|(_, f)| scene.groups[f.group as usize] == name)
        .map(|(id, _)| id)
        .collect();
    let bad = |what: String, remedy: &str| Err(BadInput::new("--face", what, remedy));
    match named[..] {
        [face] => Ok(face),
        [] => match name.parse::<usize>() {
            Ok(index) if index < scene.faces.len() => Ok(FaceId::from(index)),
            _ => bad(
                format!(
                    "\"{name}\" is neither the name of an object with one face nor a number below {}",
                    scene.faces.len()
                ),
                "umbrage inspect SCENE -v lists the faces",
            ),
        },
        _ => {
            let numbers: Vec<String> = named.iter().map(ToString::to_string).collect();
            bad(
                format!("\"{name}\" has {} faces", named.len()),
                &format!("give one of their numbers: {}", numbers.join(", ")),
            )
        }
    }
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
