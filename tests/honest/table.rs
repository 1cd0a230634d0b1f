//! The whole table: `cargo test --release -- --ignored --nocapture honest::table`.

use super::{Errors, POINTS, SLACK};
use crate::common::bake::{bake, clean, raw, raw_at};
use crate::common::fine_field::FineField;
use crate::common::scenes::{fixture_names, shared_scene};
use std::time::Instant;
use umbrage::pipeline::Solution;
use umbrage::radiosity::Bounces;
use umbrage::scene::RawScene;

/// Elements of the reference solution before it is refined: four times as many as a bake to 0.1 % starts from.
const FINE_ELEMENTS: f64 = 1500.0;

const HEADER: &str = "\
scene                         asked  estim.   meas.     rms     max  direct interpol. solution elements  lines       s";

#[test]
#[ignore = "prints the table of all fixtures: minutes in release"]
fn fixtures() {
    eprintln!("{HEADER}");
    let mut names = fixture_names();
    names.retain(|name| !["-t1e", "-s1e"].iter().any(|mark| name.contains(mark)));
    // The slow ones last.
    names.sort_by_key(|name| (name == "blinds", name.starts_with("furnace-cornell")));
    for name in names {
        print_rows(&name, &raw(&name), &[0.03, 0.01, 0.003]);
    }
}

#[test]
#[ignore = "prints the table of both Cornell boxes; needs scenes from outside the repository"]
fn cornell_boxes() {
    eprintln!("{HEADER}");
    for name in ["cornell-mcguire", "cornell-bitterli"] {
        if let Some(path) = shared_scene(&format!("{name}/{name}.obj")) {
            print_rows(name, &raw_at(&path), &[0.03, 0.01, 0.003]);
        }
    }
}

/// Real scenes, each held against a bake of its own to a third of the error: their finest solution would take too long.
macro_rules! real_scenes {
    ($($name:ident: $file:literal,)*) => {$(
        #[test]
        #[ignore = "bakes a real scene twice: minutes to hours in release; needs scenes from outside the repository"]
        fn $name() {
            print_against_finer($file);
        }
    )*};
}

real_scenes! {
    veach_ajar: "veach-ajar/veach-ajar.obj",
    living_room: "godot-living-room/living_room_lit.glb",
    freedoom: "freedoom-e2m2/freedoom-e2m2.obj",
    modern_hall: "modern-hall/modern-hall.obj",
    veach_ajar_full: "veach-ajar/veach-ajar-full.glb",
    fzk_haus: "fzk-haus/fzk-haus.obj",
    pandora: "pandora/pandora.obj",
    wooden_staircase: "wooden-staircase/wooden-staircase.glb",
}

/// Bakes a scene to 3 % and to 1 %, and prints a row of the first, with exact direct light and the second's indirect light.
fn print_against_finer(file: &str) {
    let Some(path) = shared_scene(file) else {
        return;
    };
    let world = clean(&raw_at(&path));
    let start = Instant::now();
    let solution = bake(&world, 0.03, Bounces::All);
    let seconds = start.elapsed().as_secs_f64();
    let finer = bake(&world, 0.01, Bounces::All);
    let e = Errors::measure(&solution, finer.indirect.as_ref(), POINTS, 91);
    eprintln!("{HEADER}");
    print_row(file, 0.03, &solution, &e, seconds);
}

/// Bakes at each error, and prints a row for each.
fn print_rows(name: &str, raw: &RawScene, errors: &[f64]) {
    let world = clean(raw);
    let mut fine = None;
    for &error in errors {
        let start = Instant::now();
        let solution = bake(&world, error, Bounces::All);
        let seconds = start.elapsed().as_secs_f64();
        if fine.is_none() {
            fine = FineField::new(&solution, FINE_ELEMENTS);
        }
        let e = Errors::measure(&solution, fine.as_ref().map(FineField::field), POINTS, 91);
        print_row(name, error, &solution, &e, seconds);
    }
}

fn print_row(name: &str, error: f64, solution: &Solution, e: &Errors, seconds: f64) {
    let s = &solution.summary;
    eprintln!(
        "{name:28} {error:6} {:7.4} {:7.4} {:7.4} {:7.3} {:7.4}   {:7.4}  {:7.4} {:8} {:6} {seconds:7.1}{}",
        s.error_estimated,
        s.measured.relative_rms,
        e.rms,
        e.max,
        e.direct,
        e.interpolation,
        e.solution,
        s.elements,
        s.lines_kept,
        verdict(e, error),
    );
}

fn verdict(e: &Errors, asked: f64) -> &'static str {
    match e.rms / asked {
        r if r > SLACK => "  MISSED",
        r if r < 0.1 => "  ten times better than asked",
        _ => "",
    }
}
