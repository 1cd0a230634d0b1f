//! Small pictures of lit fixtures, through the whole pipeline: bake, write, read back, render.
//!
//! `UPDATE_GOLDEN=<name>` or `UPDATE_GOLDEN=all cargo test golden` writes them anew. A failure leaves the picture and the
//! difference under `target/golden` and prints where.

use crate::common::bake::{bake, world};
use crate::common::scenes::fixtures;
use glam::DVec3;
use std::path::{Path, PathBuf};
use umbrage::compare::{PictureTolerance, compare, difference_picture};
use umbrage::io::{read_lit, read_png, write_glb, write_png};
use umbrage::radiosity::Bounces;
use umbrage::render::{CameraChoice, Picture, RenderSettings, choose_camera, render};

/// Width and height, pixels.
const SIZE: u32 = 64;

/// A golden picture has at most this many bytes.
const LARGEST_FILE: usize = 8192;

/// Room for other mathematics libraries, which may turn a diagonal or insert a vertex more: a pixel by a few steps of 255,
/// all of them by a quarter of one.
const TOLERANCE: PictureTolerance = PictureTolerance {
    max_error: 8.0,
    mean_error: 0.25,
};

/// How a picture is taken.
struct View {
    name: &'static str,
    error: f64,
    bounces: Bounces,
    eye: [f64; 3],
    target: [f64; 3],
}

/// The floor from above, past the lamp.
const fn shadow(name: &'static str) -> View {
    View {
        name,
        error: 0.03,
        bounces: Bounces::Count(0),
        eye: [3.5, 5.0, 4.5],
        target: [0.0, 0.3, 0.0],
    }
}

const VIEWS: [View; 8] = [
    shadow("square-over-square"),
    shadow("crossing-blockers"),
    shadow("wall-piercing-floor"),
    shadow("emitter-with-hole"),
    shadow("two-emitters"),
    View {
        name: "box-on-table",
        error: 0.03,
        bounces: Bounces::Count(0),
        eye: [1.2, 2.4, 2.2],
        target: [0.0, 0.6, 0.0],
    },
    View {
        name: "blinds",
        error: 0.1,
        bounces: Bounces::Count(0),
        eye: [3.6, 2.2, 2.7],
        target: [1.5, 0.8, 1.2],
    },
    View {
        name: "l-room",
        error: 0.05,
        bounces: Bounces::All,
        eye: [0.3, 1.8, 3.7],
        target: [1.6, 0.9, 0.8],
    },
];

fn picture(view: &View, size: u32) -> Picture {
    let world = world(view.name);
    let bytes = write_glb(&bake(&world, view.error, view.bounces).lit_scene());
    let model = read_lit(view.name, &bytes).unwrap_or_else(|e| panic!("{e}"));
    let choice = CameraChoice::LookAt {
        eye: DVec3::from(view.eye),
        target: DVec3::from(view.target),
        up: None,
        vertical_fov_rad: Some(50_f64.to_radians()),
    };
    let camera = choose_camera(&choice, &model, 1.0).unwrap_or_else(|e| panic!("{e}"));
    let image = render(&model, &RenderSettings::new(size, size, camera));
    image.unwrap_or_else(|e| panic!("{e}")).to_srgb()
}

fn golden(name: &str) -> PathBuf {
    fixtures().join("golden").join(name).join("image.png")
}

/// Where pictures of failures and large pictures go.
fn output(file: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("golden");
    std::fs::create_dir_all(&directory).expect("the build directory can be written to");
    directory.join(file)
}

fn save(path: &Path, picture: &Picture) {
    std::fs::write(path, write_png(picture))
        .unwrap_or_else(|e| panic!("{}: cannot be written: {e}", path.display()));
}

fn update(view: &View, found: &Picture) {
    let path = golden(view.name);
    let directory = path.parent().expect("a file has a directory");
    std::fs::create_dir_all(directory).expect("the fixtures can be written to");
    save(&path, found);
    eprintln!("written: {}", path.display());
}

/// Compares with the golden picture; where they differ, says where the evidence is.
fn judge(view: &View, found: &Picture) -> Result<(), String> {
    let path = golden(view.name);
    let bytes = std::fs::read(&path).map_err(|e| {
        let name = view.name;
        format!("{}: {e}; UPDATE_GOLDEN={name} writes it", path.display())
    })?;
    if bytes.len() > LARGEST_FILE {
        return Err(format!("{}: {} bytes", path.display(), bytes.len()));
    }
    let expected = read_png(&path.display().to_string(), &bytes).map_err(|e| e.to_string())?;
    let difference = compare(&expected, found, &TOLERANCE).map_err(|e| e.to_string())?;
    if difference.is_within {
        return Ok(());
    }
    let actual = output(&format!("{}.actual.png", view.name));
    let diff = output(&format!("{}.difference.png", view.name));
    save(&actual, found);
    let picture = difference_picture(&expected, found, TOLERANCE.max_error);
    save(&diff, &picture.map_err(|e| e.to_string())?);
    Err(format!(
        "{}: largest difference {}, mean {:.3}; see {} and {}",
        view.name,
        difference.max_error,
        difference.mean_error,
        actual.display(),
        diff.display()
    ))
}

#[test]
fn pictures_are_the_golden_ones() {
    let wanted = std::env::var("UPDATE_GOLDEN").unwrap_or_default();
    let mut failures = Vec::new();
    for view in &VIEWS {
        let found = picture(view, SIZE);
        if wanted == "all" || wanted == view.name {
            update(view, &found);
        }
        failures.extend(judge(view, &found).err());
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
#[ignore = "writes large pictures to look at"]
fn large_pictures() {
    for view in &VIEWS {
        let path = output(&format!("{}.large.png", view.name));
        save(&path, &picture(view, 400));
        eprintln!("written: {}", path.display());
    }
}
