//! Irradiance at points, on paper and by the program.

use super::{Folder, Run, small};
use std::io::Write;
use std::process::Stdio;

fn rows(text: &str) -> Vec<[f64; 3]> {
    text.lines()
        .map(|line| {
            let numbers: Vec<f64> = line
                .split(' ')
                .map(|word| word.parse().expect("a number"))
                .collect();
            numbers.try_into().expect("three channels")
        })
        .collect()
}

/// Right under a square of side 1 m at 2 m that leaves π W/m², seen past nothing, Lambert's formula gives
/// `E = 2 a/√(a²+h²) · atan(a/√(a²+h²)) · 2` with half side `a` and height `h`.
fn under_the_middle_of_the_lamp(h: f64) -> f64 {
    let x = 0.5 / 0.5f64.hypot(h);
    4.0 * x * x.atan()
}

#[test]
fn exact_points_have_the_light_that_paper_says() {
    let folder = Folder::new();
    // On the blocker's top side, hovering over it, below a rounding error of the floor in full shadow, and behind it.
    folder.write(
        "p.txt",
        "# x y z nx ny nz\n0 1 0 0 1 0\n0 1.5 0 0 3 0 # free\n0 -1e-8 0 0 1 0\n0 0 0 0 -1 0\n",
    );
    folder.done(&format!(
        "probe {} --points p.txt --from exact --terms direct -o e.txt",
        small()
    ));
    let text = folder.text("e.txt");
    let found = rows(&text);
    let expected = [1.0, 0.5].map(under_the_middle_of_the_lamp);
    assert_eq!(found.len(), 4);
    for (row, e) in found.iter().zip(expected) {
        assert!(
            (row[0] - e).abs() < 1e-12 && row[0] == row[2],
            "{row:?} instead of {e}"
        );
    }
    assert_eq!(found[2..], [[0.0; 3]; 2]);
    let digits = text.split(['e', ' ']).next().expect("a number").len();
    assert_eq!(digits, 18, "17 digits and a point: {text}");
}

#[test]
fn a_point_just_below_its_own_face_is_not_in_its_shadow() {
    let folder = Folder::new();
    folder.write(
        "p.txt",
        "2.5 0 2.5 0 1 0\n2.5 -1e-8 2.5 0 1 0\n2.5 1e-8 2.5 0 1 0.001\n",
    );
    for from in ["exact", "mesh"] {
        let run = folder.done(&format!(
            "probe {} --points p.txt --from {from} --quiet",
            small()
        ));
        let found = rows(&run.out);
        assert!(found[0][0] > 0.01, "{found:?}");
        for row in &found {
            assert!(
                (row[0] / found[0][0] - 1.0).abs() < 1e-12,
                "{from}: {found:?}"
            );
        }
    }
}

#[test]
fn the_mesh_shows_what_is_there() {
    let folder = Folder::new();
    let points: String = (0..200)
        .map(|i| {
            let x = -2.9 + 5.8 * f64::from(i) / 199.0;
            format!("{x} 0 {} 0 1 0\n", 0.37 * x + 0.2)
        })
        .collect();
    folder.write("p.txt", points);
    for from in ["mesh", "exact"] {
        for terms in ["direct", "indirect", "total"] {
            folder.done(&format!(
                "probe {} --points p.txt --from {from} --terms {terms} -o {from}-{terms} --quiet",
                small()
            ));
        }
    }
    let read = |name: &str| rows(&folder.text(name));
    let (mesh, exact) = (read("mesh-total"), read("exact-total"));
    let mean = exact.iter().map(|r| r[0]).sum::<f64>() / 200.0;
    let squares = mesh.iter().zip(&exact).map(|(m, e)| (m[0] - e[0]).powi(2));
    let rms = (squares.sum::<f64>() / 200.0).sqrt();
    assert!(rms < 0.02 * mean, "rms {rms}, mean {mean}");
    let parts = read("exact-direct").into_iter().zip(read("exact-indirect"));
    for ((direct, indirect), total) in parts.zip(&exact) {
        assert!((direct[0] + indirect[0] - total[0]).abs() < 1e-12);
    }
}

#[test]
fn points_come_from_standard_input_in_the_frame_of_the_file() {
    let folder = Folder::new();
    let probe = |up: &str, point: &str| {
        let words = format!(
            "probe {} --points - --from exact --terms direct --up {up}",
            small()
        );
        let mut child = folder
            .command(words.split_whitespace())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut stdin = child.stdin.take().expect("a pipe");
        stdin
            .write_all(point.as_bytes())
            .expect("the program reads");
        drop(stdin);
        let run = Run::of(child.wait_with_output().expect("the program ends"));
        assert_eq!(run.code, Some(0), "{}", run.err);
        run.out
    };
    // The scene lies on its side when its y is taken for z, and so do the points.
    let upright = rows(&probe("y", "2 0 1.7 0 1 0"));
    let turned = rows(&probe("z", "2 0 1.7 0 1 0"));
    assert!(
        (upright[0][0] / turned[0][0] - 1.0).abs() < 1e-12,
        "{upright:?} {turned:?}"
    );
    assert!(upright[0][0] > 0.0);
}

#[test]
fn bad_points_are_named_by_file_and_line() {
    let folder = Folder::new();
    let scene = small();
    for (text, from, what) in [
        ("0 0 0 0 1 0\n0 0 0 0 1", "exact", "p.txt:2: 5 values"),
        (
            "0 0 0 0 1 0\n\n0 0 zero 0 1 0",
            "exact",
            "p.txt:3: \"zero\" is no number",
        ),
        ("0 inf 0 0 1 0", "exact", "p.txt:1: inf is not finite"),
        ("0 0 0 0 0 0", "exact", "p.txt:1: the normal is zero"),
        (
            "0 0 0 0 1 0\n0 0.5 0 0 1 0",
            "mesh",
            "p.txt:2: the point lies on no face",
        ),
    ] {
        folder.write("p.txt", text);
        folder.refused(
            &format!("probe {scene} --points p.txt --from {from} --error 0.1"),
            what,
        );
    }
    folder.write("p.txt", [0xff, 0xfe]);
    folder.refused(
        &format!("probe {scene} --points p.txt"),
        "p.txt: is no text",
    );
    folder.refused(
        &format!("probe {scene} --points none.txt"),
        "none.txt: cannot be read",
    );
}

#[test]
fn tables_go_in_and_come_out_and_grids_make_their_own_points() {
    let folder = Folder::new();
    let scene = small();
    let options = "--from exact --terms direct --quiet";
    folder.done(&format!(
        "probe {scene} --grid floor --spacing 0.5 --height 0.05 --csv -o grid.csv {options}"
    ));
    let table = folder.text("grid.csv");
    assert!(
        table.starts_with("x,y,z,nx,ny,nz,E_r,E_g,E_b,lux\n"),
        "{table}"
    );
    let points: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|w| w.parse().expect("a number")).collect())
        .collect();
    // The floor is 6 m wide.
    assert_eq!(points.len(), 144);
    assert!(
        points
            .iter()
            .all(|p| (p[1] - 0.05).abs() < 1e-12 && p[4] > 0.99)
    );
    for p in &points {
        let lux = 179.0 * (0.2126 * p[6] + 0.7152 * p[7] + 0.0722 * p[8]);
        assert!((lux - p[9]).abs() <= 1e-5 * lux, "{p:?}");
    }
    // A table that came out is read again, and gives itself.
    folder.done(&format!(
        "probe {scene} --points grid.csv --csv -o again.csv {options}"
    ));
    assert_eq!(folder.text("again.csv"), table);

    let run = folder.done(&format!(
        "probe {scene} --grid floor --csv -o mesh.csv --error 0.1 --terms direct"
    ));
    assert!(run.out.contains("min/mean"), "{}", run.out);
    folder.refused(
        &format!("probe {scene} --grid ceiling"),
        "--grid: \"ceiling\" is neither",
    );
    folder.refused(
        &format!("probe {scene} --grid floor --height 1"),
        "add --from exact",
    );
    folder.refused(&format!("probe {scene}"), "--points");
}
