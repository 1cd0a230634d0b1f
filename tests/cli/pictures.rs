//! Pages and false colours.

use super::{Folder, small};
use umbrage::io::read_png;
use umbrage::render::{LEGEND_HEIGHT, Picture, false_colour};

fn picture(folder: &Folder, name: &str) -> Picture {
    read_png(name, &folder.read(name)).expect("a picture")
}

#[test]
fn a_page_of_the_scene_holds_its_lines_and_one_of_the_lit_file_its_light() {
    let folder = Folder::new();
    let scene = small();
    folder.done(&format!(
        "inspect {scene} --error 0.1 --html a.html --quiet"
    ));
    let page = folder.text("a.html");
    assert!(page.starts_with("<!doctype html>") && page.contains("disappears behind edge"));

    folder.done(&format!("bake {scene} --error 0.1 -o a.glb --quiet"));
    let run = folder.done("inspect a.glb --html b.html");
    assert!(run.out.contains("written      b.html"), "{}", run.out);
    let page = folder.text("b.html");
    assert!(page.contains("\"lines\":[]") && page.contains("\"errors\":null"));
    folder.refused(
        "inspect a.glb --html b.html --lines l.csv",
        "a.glb: is lit already",
    );
    folder.refused("inspect --html c.html --efficacy 0", "give lumens a watt");
    assert_eq!(folder.names(), ["a.glb", "a.html", "b.html"]);
}

#[test]
fn false_colours_follow_the_scale_and_say_what_they_stand_for() {
    let folder = Folder::new();
    folder.done(&format!("bake {} --error 0.1 -o a.glb --quiet", small()));
    let view = "--eye 0.2,3,0.3 --target 0.2,0,0.3 --up 0,0,-1 --size 40x30";
    let run = folder.done(&format!(
        "render a.glb -o lux.png {view} --false-colour --lux --scale 100"
    ));
    assert!(run.out.contains("0 to 100 lx, at 179 lm/W"), "{}", run.out);
    let found = picture(&folder, "lux.png");
    assert_eq!((found.width, found.height), (40, 30 + LEGEND_HEIGHT));

    // A scale a million times as long shows all of it as nothing, one a million times as short as its end.
    for (scale, t) in [("1e8", 0.0), ("1e-6", 1.0)] {
        folder.done(&format!(
            "render a.glb -o {scale}.png {view} --false-colour --lux --scale {scale} --quiet"
        ));
        let all = picture(&folder, &format!("{scale}.png"));
        let of_map = all.pixels[..40 * 30]
            .iter()
            .filter(|p| **p == false_colour(t));
        assert!(of_map.count() > 100, "{scale}");
    }
    // The same light in other units has the same colours on a scale in these units.
    folder.done(&format!(
        "render a.glb -o one.png {view} --false-colour --lux --efficacy 1 --scale 0.5586592178770949 --quiet"
    ));
    let one = picture(&folder, "one.png");
    assert_eq!(one.pixels[..40 * 30], found.pixels[..40 * 30]);

    let run = folder.done(&format!("render a.glb -o watt.png {view} --false-colour"));
    assert!(
        run.out.contains("W/m², mean of the channels"),
        "{}",
        run.out
    );
    folder.refused("render a.glb -o b.png --lux", "--false-colour");
    folder.refused("render a.glb -o b.png --false-colour --scale 0", "above 0");
}

#[test]
#[cfg(unix)]
fn the_job_of_the_manual_tells_the_same_from_the_different_and_from_no_picture() {
    use std::process::Command;
    let folder = Folder::new();
    let manual = include_str!("../../docs/golden-images.md");
    let script = manual.split("```sh\n").nth(1).expect("a script");
    let script = script.split("```").next().expect("its end");
    // A scene of its own beside its materials, as the manual has it; coarse, to be quick.
    let fixture = crate::common::scenes::fixture("square-over-square");
    let text = std::fs::read_to_string(&fixture).expect("the fixture");
    let materials = fixture.parent().expect("a folder").join("../common.mtl");
    std::fs::create_dir_all(folder.path("scenes")).expect("a folder");
    std::fs::create_dir_all(folder.path("golden")).expect("a folder");
    folder.write(
        "scenes/room.obj",
        text.replace("../common.mtl", "common.mtl"),
    );
    std::fs::copy(materials, folder.path("scenes/common.mtl")).expect("the materials");
    folder.write(
        "job.sh",
        script.replace("--error 0.01", "--error 0.2 --bounces 0"),
    );
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_umbrage"));
    let path = format!(
        "{}:/usr/bin:/bin",
        program.parent().expect("a folder").display()
    );
    let job = || {
        let mut job = Command::new("sh");
        let job = job
            .arg("job.sh")
            .current_dir(folder.path(""))
            .env("PATH", &path);
        job.output().expect("a shell").status.code()
    };
    assert_eq!(job(), Some(1), "no golden picture is no pass");
    std::fs::copy(
        folder.path("differences/room.png"),
        folder.path("golden/room.png"),
    )
    .expect("the new picture");
    assert_eq!(job(), Some(0));
    folder.write(
        "scenes/room.obj",
        text.replace("../common.mtl", "common.mtl")
            .replace("v -0.5 1 0.5", "v -0.9 1 0.5"),
    );
    assert_eq!(job(), Some(1));
    assert!(
        folder
            .read("differences/room.diff.png")
            .starts_with(b"\x89PNG")
    );
}
