//! Input and use that the program has to refuse, in one clear line and without harm.

use super::{Folder, small};

/// A triangle, 1 m wide.
const TRIANGLE: &str = "v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\n";

#[test]
fn broken_scenes_are_refused_by_name() {
    let folder = Folder::new();
    folder.write("grey.mtl", "newmtl grey\nKd 1.2 0.5 0.5\n");
    folder.write("anti.mtl", "newmtl anti\nKd 0.5 0.5 0.5\nKe -1 0 0\n");
    for (name, text, what) in [
        ("empty.obj", "", "no faces"),
        (
            "nan.obj",
            "v 0 0 0\nv nan 0 1\nv 1 0 0\nf 1 2 3\n",
            "nan.obj:2: ",
        ),
        ("range.obj", "v 0 0 0\nv 0 0 1\nf 1 2 9\n", "range.obj:3: "),
        (
            "point.obj",
            "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n",
            "degenerate",
        ),
        (
            "line.obj",
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
            "degenerate",
        ),
        (
            "bright.obj",
            &format!("mtllib grey.mtl\nusemtl grey\n{TRIANGLE}"),
            "\"grey\" has reflectance",
        ),
        (
            "dark.obj",
            &format!("mtllib anti.mtl\nusemtl anti\n{TRIANGLE}"),
            "\"anti\" emits",
        ),
        ("empty.glb", "", "empty.glb: "),
        ("short.glb", "glTF\u{2}\0\0\0", "short.glb: "),
        ("no.gltf", "{", "no.gltf: "),
        (
            "index.gltf",
            r#"{"asset":{"version":"2.0"},"scene":3}"#,
            "index.gltf: ",
        ),
        ("scene.stl", "solid", "extension \"stl\""),
    ] {
        folder.write(name, text);
        folder.refused(&format!("bake {name} -o out.glb"), what);
        assert!(!folder.names().contains(&"out.glb".to_owned()), "{name}");
    }
    folder.refused("bake none.obj", "none.obj: cannot be read");
}

#[test]
fn lit_files_cut_anywhere_are_refused() {
    let folder = Folder::new();
    folder.done(&format!("bake {} -o a.glb --error 0.1 --quiet", small()));
    let bytes = folder.read("a.glb");
    for cut in [0, 3, 11, 20, 100, 1000, bytes.len() / 2, bytes.len() - 1] {
        folder.write("cut.glb", &bytes[..cut]);
        folder.refused("render cut.glb -o a.png", "cut.glb: ");
    }
    folder.refused("render a.glb -o a.png --camera door", "door");
    folder.refused(
        "render a.glb -o a.png --eye 0,1,0 --target 0,1,0",
        "same point",
    );
    folder.refused("render a.glb -o a.png --size 0x10", "800x600");
    folder.refused("render a.glb -o a.png --size 99999x1", "16384");
    folder.refused("render a.glb -o a.png --fov 180", "between 0 and 180");
    folder.refused(
        "render a.glb -o a.png --eye 0,1 --target 0,0,0",
        "three numbers",
    );
    assert!(!folder.names().contains(&"a.png".to_owned()));
}

#[test]
fn what_is_missing_is_replaced_with_a_warning() {
    let folder = Folder::new();
    folder.write("a.obj", format!("mtllib none.mtl\nusemtl x\n{TRIANGLE}"));
    let run = folder.done("bake a.obj --error 0.1");
    for what in [
        "none.mtl not found",
        "\"x\" is not defined",
        "no face emits light",
    ] {
        assert!(run.err.contains(what), "{what}: {}", run.err);
    }
    assert!(
        run.err.lines().all(|l| l.starts_with("warning: ")),
        "{}",
        run.err
    );
    assert!(
        run.out.contains("light reaches 0 of 2 sides, 0 m²"),
        "{}",
        run.out
    );
    // Black, but a picture.
    folder.done("render a.lit.glb -o a.png --size 20x20 --quiet");
}

#[test]
fn a_lamp_alone_lights_nothing() {
    let folder = Folder::new();
    folder.write("lamp.mtl", "newmtl lamp\nKd 0 0 0\nKe 5 5 5\n");
    folder.write("a.obj", format!("mtllib lamp.mtl\nusemtl lamp\n{TRIANGLE}"));
    let run = folder.done("bake a.obj");
    assert!(run.out.contains("nothing reflects"), "{}", run.out);
}

#[test]
fn many_warnings_are_cut_short_unless_asked_for() {
    let folder = Folder::new();
    let mut text = String::from("v 0 0 0\nv 0 0 1\nv 1 0 0\n");
    for i in 0..9 {
        text.push_str(&format!("mtllib none{i}.mtl\n"));
    }
    folder.write("a.obj", text + "f 1 2 3\n");
    let few = folder.done("bake a.obj --error 0.1").err;
    assert_eq!(few.lines().count(), 6, "{few}");
    assert!(few.contains("more; -v shows them"), "{few}");
    let all = folder.done("bake a.obj --error 0.1 -v").err;
    assert!(
        all.contains("none8.mtl") && !all.contains("more; -v"),
        "{all}"
    );
}

#[test]
fn wrong_use_is_told_in_one_line() {
    let folder = Folder::new();
    let scene = small();
    for (line, what) in [
        ("", "umbrage --help"),
        ("bak", "'bake'"),
        ("bake --eror 1", "'--error'"),
        ("probe", "--points"),
        ("bake --error 0", "--error"),
        ("bake --error x", "--error"),
        ("bake --budget speed=1", "--budget"),
        ("bake --budget time=0", "--budget"),
        ("bake --bounces -1", "--bounces"),
        ("bake --threads 0", "--threads"),
        ("bake --solver magic", "\"magic\" is no solver"),
        ("probe --points - --basis cubic", "\"cubic\" is no basis"),
        ("bake --unit mile", "--unit"),
        ("bake --up x", "--up"),
        ("bake --exposure bright", "--exposure"),
        ("bake --weld -1", "--weld"),
        ("inspect --svg f.svg", "--face"),
        ("inspect --svg f.svg --face cupboard", "\"cupboard\""),
    ] {
        folder.refused(line, what);
    }
    folder.refused("inspect --svg f.svg --face 99", "below 17");
    folder.refused("inspect --svg f.svg --face tall_block", "neither the name");
    let line = format!("inspect {scene} --svg f.svg --face lamp --side back --error 0.1");
    folder.refused(&line, "--side");
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn an_output_that_cannot_be_written_leaves_the_old_one() {
    let folder = Folder::new();
    let scene = small();
    folder.refused(
        &format!("bake {scene} -o no/a.glb --error 0.1"),
        "no does not exist",
    );
    std::fs::create_dir(folder.path("taken.glb")).expect("a folder");
    folder.refused(
        &format!("bake {scene} -o taken.glb --error 0.1"),
        "is a folder",
    );

    // A picture that fails takes the model with it.
    folder.write("old.glb", "old");
    folder.write("bad.obj", "v 0 0 0\nf 1 1 1\n");
    folder.refused("bake bad.obj -o old.glb", "bad.obj");
    assert_eq!(folder.text("old.glb"), "old");
    assert_eq!(folder.names(), ["bad.obj", "old.glb", "taken.glb"]);
}

#[test]
fn an_input_is_never_written_over() {
    let folder = Folder::new();
    folder.write("a.obj", TRIANGLE);
    folder.write("p.txt", "0 0 0 0 1 0\n");
    folder.refused("bake a.obj -o a.obj", "would be written over");
    folder.refused("bake a.obj -o ./a.obj", "would be written over");
    folder.refused("bake a.obj -o b.glb --json b.glb", "named for two results");
    folder.refused(
        "probe a.obj --points p.txt -o p.txt",
        "would be written over",
    );
    assert_eq!(folder.text("a.obj"), TRIANGLE);
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    use std::process::Stdio;
    let folder = Folder::new();
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let output = folder
        .command(["--help"])
        .stdout(Stdio::from(writer))
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
}
