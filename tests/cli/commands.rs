//! Every command on good input.

use super::{Folder, shown, small};
use crate::common::scenes::fixture;
use serde_json::Value;

#[test]
fn bake_without_a_scene_lights_the_built_in_one_and_takes_its_picture() {
    let folder = Folder::new();
    let run = folder.done("bake --error 0.05");
    assert_eq!(folder.names(), ["cornell.lit.glb", "cornell.lit.png"]);
    for word in [
        "repaired",
        "lines",
        "D0 contact",
        "measured",
        "left out",
        "memory",
    ] {
        let is_told = run.out.contains(word) || (word == "memory" && !cfg!(target_os = "linux"));
        assert!(is_told, "{word} is missing in\n{}", run.out);
    }
    assert!(
        run.err
            .starts_with("warning: cornell-box: 1 of 16 polygons bent"),
        "{}",
        run.err
    );
    assert!(folder.read("cornell.lit.glb").starts_with(b"glTF"));
    assert!(folder.read("cornell.lit.png").starts_with(b"\x89PNG"));
}

#[test]
fn bake_names_its_output_after_the_scene_and_keeps_quiet_when_asked() {
    let folder = Folder::new();
    let run = folder.done(&format!("bake {} --error 0.1 --quiet", small()));
    assert_eq!(folder.names(), ["square-over-square.lit.glb"]);
    assert_eq!((run.out.as_str(), run.err.as_str()), ("", ""));
}

#[test]
fn a_budget_that_is_used_up_is_a_warning_and_no_error() {
    let folder = Folder::new();
    let line = format!("bake {} -o a.glb --error 0.005 --json a.json", small());
    let run = folder.done(&format!("{line} --budget elements=100,time=600"));
    let told: Vec<&str> = run.err.lines().filter(|l| l.contains("budget")).collect();
    assert_eq!(told.len(), 1, "{}", run.err);
    assert!(told[0].starts_with("warning: ") && told[0].contains("(elements)"));
    let json: Value = serde_json::from_str(&folder.text("a.json")).expect("JSON");
    assert_eq!(json["settings"]["budget"], "elements=100,time=600");
    let summary = &json["summary"];
    assert_eq!(summary["stopped_by"], "elements");
    assert!(summary["elements"].as_u64() <= Some(100));
    if cfg!(target_os = "linux") {
        for stage in summary["stages"].as_array().expect("a list") {
            assert!(stage["peak_memory_bytes"].as_u64() > Some(0), "{stage}");
        }
    }
}

#[test]
fn the_summary_for_machines_says_what_the_table_says() {
    let folder = Folder::new();
    folder.done(&format!(
        "bake {} -o a.glb --error 0.02 --seed 7 --json a.json",
        small()
    ));
    let json: Value = serde_json::from_str(&folder.text("a.json")).expect("JSON");
    assert_eq!(json["command"], "bake");
    assert_eq!(json["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(json["settings"]["seed"], 7);
    assert_eq!(json["outputs"][0], "a.glb");
    let summary = &json["summary"];
    assert_eq!(summary["clean"]["faces"], 3);
    let measured = summary["measured"]["relative_rms"]
        .as_f64()
        .expect("a number");
    assert!(measured > 0.0 && measured < 0.02, "{measured}");
    let counts = summary["line_counts"].as_array().expect("a list");
    let found: u64 = counts.iter().filter_map(|c| c["found"].as_u64()).sum();
    assert_eq!(Some(found), summary["lines"]["lines"].as_u64());
    let stages: Vec<&str> = summary["stages"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|s| s["name"].as_str())
        .collect();
    assert_eq!(stages[..3], ["read", "clean", "lines"]);
    if cfg!(target_os = "linux") {
        assert!(json["peak_memory_bytes"].as_u64() > Some(1 << 20));
        assert!(summary["stages"][2]["peak_memory_bytes"].is_u64());
    }
}

#[test]
fn the_same_input_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    let scene = small();
    for (n, threads) in [1, 2, 1, 2].into_iter().enumerate() {
        folder.done(&format!(
            "bake {scene} -o {n}.glb --png {n}.png --error 0.02 --threads {threads} --quiet"
        ));
        folder.done(&format!(
            "inspect {scene} --candidates {n}.csv --svg {n}.svg --face floor --mesh {n}.lines \
             --error 0.02 --threads {threads} --quiet"
        ));
    }
    for kind in ["glb", "png", "csv", "svg", "lines"] {
        for n in 1..4 {
            let same = folder.read(&format!("0.{kind}")) == folder.read(&format!("{n}.{kind}"));
            assert!(same, "run {n}: another {kind}");
        }
    }
}

#[test]
fn render_takes_pictures_from_cameras_and_from_anywhere() {
    let folder = Folder::new();
    folder.done("bake --error 0.1 --quiet");
    folder.done("render cornell.lit.glb -o all.png --quiet");
    assert_eq!(folder.read("all.png"), folder.read("cornell.lit.png"));
    let run =
        folder.done("render cornell.lit.glb -o 0.png --camera 0 --size 40x30 --supersample 1");
    assert!(run.out.contains("0.png"), "{}", run.out);
    let view = "--eye 0.3,0.3,-0.8 --target 0.3,0.3,0 --up 0,1,0 --size 40x20 --quiet";
    folder.done(&format!("render cornell.lit.glb -o v.png {view} --fov 30"));
    let hfov = (2.0 * (2.0 * 15.0_f64.to_radians().tan()).atan()).to_degrees();
    folder.done(&format!(
        "render cornell.lit.glb -o h.png {view} --hfov {hfov}"
    ));
    folder.done("compare v.png h.png");
}

#[test]
fn compare_tells_same_different_and_incomparable_apart() {
    let folder = Folder::new();
    folder.done("bake --error 0.1 --quiet");
    for (name, size, fov) in [("a", "30x30", 39), ("b", "30x30", 50), ("c", "20x20", 39)] {
        folder.done(&format!(
            "render cornell.lit.glb -o {name}.png --size {size} --fov {fov} --quiet"
        ));
    }
    let same = folder.done("compare a.png a.png");
    assert!(same.out.contains("same picture"), "{}", same.out);
    let different = folder.run("compare a.png b.png --diff d.png");
    assert_eq!(different.code, Some(1));
    assert!(
        different.out.contains("different pictures"),
        "{}",
        different.out
    );
    assert!(folder.read("d.png").starts_with(b"\x89PNG"));
    folder.done("compare a.png b.png --max-error 255 --mean-error 255");
    // Not the same to eyes either, whatever the steps.
    let loose = "compare a.png b.png --max-error 255 --mean-error 255 --json c.json --min-score";
    let seen = folder.run(&format!("{loose} 99.9"));
    assert_eq!(seen.code, Some(1), "{}", seen.out);
    assert!(seen.out.contains("(at least 99.9)"), "{}", seen.out);
    let json: Value = serde_json::from_str(&folder.text("c.json")).expect("JSON");
    let score = json["ssimulacra2"].as_f64().expect("a score");
    assert!(score < 99.9 && json["is_same"] == false, "{json}");
    folder.done(&format!("{loose} {}", score - 0.01));
    folder.refused(
        "compare a.png b.png --min-score 101",
        "no picture has such a score",
    );
    folder.refused("compare a.png c.png", "30 × 30");
    folder.refused("compare a.png none.png", "none.png: cannot be read");
    folder.refused("compare a.png b.png --diff b.png", "would be written over");
}

#[test]
fn inspect_writes_the_lines_that_the_mesh_holds() {
    let folder = Folder::new();
    let header = "face,order,kind,x0,y0,z0,x1,y1,z1,jump,emitter,cause";
    folder.done(&format!(
        "inspect {} --lines l.csv --candidates c.csv --mesh m.glb --svg f.svg --face floor --error 0.005 --quiet",
        small()
    ));
    let (lines, candidates) = (folder.text("l.csv"), folder.text("c.csv"));
    assert_eq!(lines.lines().next(), Some(header));
    assert_eq!(candidates.lines().next(), Some(&*format!("{header},kept")));
    let held = lines.lines().count() - 1;
    assert!(
        held >= 8,
        "penumbra and umbra have four sides each:\n{lines}"
    );
    assert_eq!(
        candidates.lines().filter(|l| l.ends_with(",1")).count(),
        held
    );
    for line in lines.lines().skip(1) {
        assert_eq!(line.split(',').count(), 12, "{line}");
    }
    // The outer border of the penumbra lies at ±1.5 m.
    assert!(lines.lines().any(|l| l.contains("-1.5,0,")), "{lines}");
    assert!(folder.read("m.glb").starts_with(b"glTF"));
    let svg = folder.text("f.svg");
    assert!(svg.starts_with("<svg ") && svg.contains("floor (face 0, front)"));
}

#[test]
fn inspect_without_options_is_a_table() {
    let folder = Folder::new();
    let run = folder.done(&format!("inspect {} --error 0.05 -v", small()));
    assert!(run.out.contains("D1"), "{}", run.out);
    assert!(run.out.contains("floor, floor"), "{}", run.out);
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn help_and_version_are_no_errors() {
    let folder = Folder::new();
    assert!(folder.done("--help").out.contains("bake"));
    assert!(folder.done("probe --help").out.contains("--points"));
    let version = folder.done("--version").out;
    assert_eq!(
        version.trim(),
        format!("umbrage {}", env!("CARGO_PKG_VERSION"))
    );
}

#[test]
fn many_scenes_are_baked_and_a_broken_one_stops_none() {
    let folder = Folder::new();
    folder.write("bad.obj", "v 0 0 nan\n");
    std::fs::copy(small(), folder.path("a.obj")).expect("a copy");
    let library = std::path::Path::new(&small()).with_extension("mtl");
    if let Some(name) = library.file_name().filter(|_| library.is_file()) {
        std::fs::copy(&library, folder.path(&name.to_string_lossy())).expect("a copy");
    }
    let run = folder.run(&format!(
        "bake a.obj bad.obj {} -o lit/ --error 0.1 --quiet",
        small()
    ));
    assert_eq!(run.code, Some(2), "{}", run.err);
    let errors: Vec<&str> = run.err.lines().collect();
    assert_eq!(errors.len(), 2, "{}", run.err);
    assert!(errors[0].starts_with("error: bad.obj:1: "), "{}", run.err);
    assert!(
        errors[1].contains("1 of 3 scenes were not baked"),
        "{}",
        run.err
    );
    let mut names: Vec<_> = std::fs::read_dir(folder.path("lit"))
        .expect("the folder was made")
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    assert_eq!(names, ["a.lit.glb", "square-over-square.lit.glb"]);
    // Each is what it is by itself.
    folder.done("bake a.obj -o alone.glb --error 0.1 --quiet");
    assert!(folder.read("alone.glb") == folder.read("lit/a.lit.glb"));
    folder.done("bake a.obj -o one/ --error 0.1 --quiet");
    assert!(folder.path("one/a.lit.glb").is_file());
}

#[test]
fn many_scenes_need_names_of_their_own() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\n");
    folder.refused("bake a.obj ./a.obj -o lit/", "is named for two results");
    folder.refused("bake a.obj b.obj --png a.png", "--png: names one file");
    folder.refused("bake a.obj b.obj --json a.json", "--json: names one file");
    folder.write("taken", "");
    folder.refused("bake a.obj b.obj -o taken", "cannot be made a folder");
    assert_eq!(folder.names(), ["a.obj", "taken"]);
}

/// Interrupted while it works, the program ends as shells expect, and leaves nothing.
#[cfg(unix)]
#[test]
fn an_interrupted_bake_leaves_nothing() {
    let folder = Folder::new();
    let args = ["bake", "--error", "0.0005", "-o", "out.glb", "--quiet"];
    let mut child = folder.command(args).spawn().expect("the program starts");
    std::thread::sleep(std::time::Duration::from_millis(300));
    let kill = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.expect("a shell's kill").success());
    let status = child.wait().expect("the program ends");
    assert_eq!(status.code(), Some(130));
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn statistics_of_a_face_are_those_of_its_light() {
    let folder = Folder::new();
    let scene = small();
    let run = folder.done(&format!(
        "inspect {scene} --error 0.02 --bounces 0 --statistics --face floor"
    ));
    let row = run
        .out
        .lines()
        .find(|l| l.ends_with("floor"))
        .expect("the floor");
    let word = |i: usize| row.split_whitespace().nth(i).expect("a number");
    let [min, mean, max, even] = [2, 3, 4, 5].map(|i| word(i).parse::<f64>().expect("a number"));
    assert!(min >= 0.0 && min < mean && mean < max, "{row}");
    assert!((min / mean - even).abs() < 1e-3, "{row}");
    // The mean on a fine grid of exact points.
    folder.done(&format!(
        "probe {scene} --grid floor --spacing 0.1 --from exact --terms direct -o p.txt --quiet"
    ));
    let text = folder.text("p.txt");
    let light = text
        .split_whitespace()
        .map(|w| w.parse::<f64>().expect("a number"));
    let exact = light.sum::<f64>() / (3 * text.lines().count()) as f64;
    assert!((mean / exact - 1.0).abs() < 0.01, "{mean} {exact}");
    let lux = folder.done(&format!(
        "inspect {scene} --error 0.1 --bounces 0 --statistics --lux --efficacy 683"
    ));
    assert!(lux.out.contains("lx, at 683 lm/W"), "{}", lux.out);
    folder.refused(&format!("inspect {scene} --face floor"), "--statistics");
}

#[test]
fn inspect_writes_the_form_factors_of_a_closed_room() {
    let folder = Folder::new();
    let room = shown(&fixture("furnace-box-r50"));
    folder.done(&format!("inspect {room} --error 0.1 --form-factors f.csv"));
    let text = folder.text("f.csv");
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("from,from_side,to,to_side,form_factor,error")
    );
    let (mut pairs, mut sums) = (0, 0);
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let factor: f64 = cells[4].parse().expect("a number");
        if cells[2].is_empty() {
            let expected = if cells[1] == "front" { 1.0 } else { 0.0 };
            assert!((factor - expected).abs() < 1e-12, "{line}");
            sums += 1;
        } else {
            assert!(factor > 0.0 && factor < 1.0, "{line}");
            pairs += 1;
        }
    }
    // Six fronts see each other; the backs are there, too.
    assert_eq!((pairs, sums), (30, 12));
}

#[test]
fn the_error_attribute_says_how_far_each_vertex_is_off() {
    let folder = Folder::new();
    let room = shown(&fixture("box-on-table"));
    let run = folder.done(&format!(
        "bake {room} -o a.glb --error 0.05 --error-attribute --json a.json"
    ));
    assert!(run.out.contains("at vertices"), "{}", run.out);
    let json: Value = serde_json::from_str(&folder.text("a.json")).expect("JSON");
    let figures = &json["summary"]["error_at_vertices"];
    let figure = |name: &str| figures[name].as_f64().expect("a number");
    // An estimate of what was measured to be within the error asked for.
    let rms = figure("relative_rms");
    assert!(rms > 0.005 && rms < 0.1, "{figures}");
    let parts = ["solution", "field", "mesh"].map(|p| figure(&format!("relative_rms_{p}")));
    let together = parts.iter().map(|p| p * p).sum::<f64>().sqrt();
    assert!((together / rms - 1.0).abs() < 1e-6, "{figures}");

    let file = gltf::Gltf::from_slice(&folder.read("a.glb")).expect("a valid file");
    let buffer = file.blob.as_deref().expect("a binary part");
    let mean = json["summary"]["measured"]["mean"]
        .as_f64()
        .expect("a number");
    let mut largest = 0.0_f32;
    for primitive in file.document.meshes().flat_map(|m| m.primitives()) {
        let name = gltf::Semantic::Extras("ERROR".to_owned());
        let errors = primitive.get(&name).expect("every primitive has it");
        let positions = primitive
            .get(&gltf::Semantic::Positions)
            .expect("positions");
        assert_eq!(errors.count(), positions.count());
        let view = errors.view().expect("not sparse");
        let start = view.offset() + errors.offset();
        let bytes = &buffer[start..start + 4 * errors.count()];
        for number in bytes.chunks_exact(4) {
            let error = f32::from_le_bytes([number[0], number[1], number[2], number[3]]);
            assert!(error.is_finite() && error >= 0.0, "{error}");
            largest = largest.max(error);
        }
    }
    let told = figure("relative_max") * mean;
    assert!(
        (f64::from(largest) / told - 1.0).abs() < 1e-5,
        "{largest} and {told}"
    );
    // Without the option nothing of it is there.
    folder.done(&format!("bake {room} -o b.glb --error 0.05 --json b.json"));
    assert!(
        folder
            .text("b.json")
            .contains("\"error_at_vertices\": null")
    );
    assert!(!folder.read("b.glb").windows(6).any(|w| w == b"_ERROR"));
}
