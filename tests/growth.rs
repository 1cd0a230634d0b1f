//! What a larger building costs: time and memory against its triangles.

use crate::common::library::world_of_mesh;
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use crate::lines::cities::add_box;
use std::fmt::Write;
use std::process::{Command, Stdio};
use umbrage::pipeline::light;
use umbrage::settings::Settings;

/// Time and memory may grow as this power of the triangles.
const GREATEST_EXPONENT: f64 = 1.15;

/// Twice the rooms may take so many times the work: linear growth, and the depth of a tree.
const DEAREST_DOUBLING: f64 = 2.3;

/// The relative error at which work is counted.
const COARSE: f64 = 0.2;

/// A room: width, height and depth, and the doorway to the next one, metres.
const ROOM: [f64; 3] = [5.0, 2.8, 4.0];
const DOOR: [f64; 2] = [1.0, 2.1];

/// Rows of rooms are so many long.
const ROW: usize = 8;

/// A building of furnished rooms, each with a lamp of its own and a doorway to the next one in its row.
fn building(rooms: usize) -> ObjMesh {
    let mut mesh = ObjMesh::default();
    for i in 0..rooms {
        let (column, row) = (i % ROW, i / ROW);
        let is_last = column + 1 == ROW || i + 1 == rooms;
        // Walls have no thickness; rows stand apart.
        let corner = [column as f64 * ROOM[0], 0.0, row as f64 * (ROOM[2] + 1.0)];
        add_shell(&mut mesh, corner, column == 0, is_last);
        add_furniture(&mut mesh, corner, &mut Rng::new(i as u64));
    }
    mesh
}

/// Floor, ceiling, walls and lamp of the room whose lowest corner is `o`.
fn add_shell(mesh: &mut ObjMesh, o: [f64; 3], is_first: bool, is_last: bool) {
    let [w, h, d] = ROOM;
    let mut add = |corners: [[f64; 3]; 4], ke: f64| {
        let kd = if ke > 0.0 { 0.0 } else { 0.7 };
        mesh.add(&corners.map(|p| [0, 1, 2].map(|k| o[k] + p[k])), kd, ke);
    };
    add([[0., 0., d], [w, 0., d], [w, 0., 0.], [0., 0., 0.]], 0.0);
    add([[0., h, 0.], [w, h, 0.], [w, h, d], [0., h, d]], 0.0);
    add([[0., 0., 0.], [w, 0., 0.], [w, h, 0.], [0., h, 0.]], 0.0);
    add([[0., 0., d], [0., h, d], [w, h, d], [w, 0., d]], 0.0);
    if is_first {
        add([[0., 0., 0.], [0., h, 0.], [0., h, d], [0., 0., d]], 0.0);
    }
    if is_last {
        add([[w, 0., 0.], [w, 0., d], [w, h, d], [w, h, 0.]], 0.0);
    } else {
        // Beside and above the doorway.
        let [door, top] = DOOR;
        let (a, b) = (0.5 * (d - door), 0.5 * (d + door));
        for [from, to, low, high] in [[0., a, 0., h], [b, d, 0., h], [a, b, top, h]] {
            add(
                [[w, low, from], [w, low, to], [w, high, to], [w, high, from]],
                0.0,
            );
        }
    }
    let (x, y, z, half) = (0.5 * w, h - 0.05, 0.5 * d, 0.3);
    let lamp = [[-half, -half], [half, -half], [half, half], [-half, half]];
    add(lamp.map(|[i, j]| [x + i, y, z + j]), 20.0);
}

/// A table with four chairs, a shelf and some boxes: about 45 boxes.
fn add_furniture(mesh: &mut ObjMesh, o: [f64; 3], rng: &mut Rng) {
    let mut add = |low: [f64; 3], high: [f64; 3]| {
        let at = |p: [f64; 3]| [0, 1, 2].map(|k| o[k] + p[k]);
        add_box(mesh, at(low), at(high), true);
    };
    let (x, z) = (rng.range(1.6, 2.4), rng.range(1.2, 1.6));
    // A top of `size` and height `y` on four legs.
    let mut on_legs = |x: f64, y: f64, z: f64, size: [f64; 2]| {
        add([x, y - 0.03, z], [x + size[0], y, z + size[1]]);
        for (i, j) in [
            (0.05, 0.05),
            (size[0] - 0.1, 0.05),
            (0.05, size[1] - 0.1),
            (size[0] - 0.1, size[1] - 0.1),
        ] {
            add(
                [x + i, 0.001, z + j],
                [x + i + 0.05, y - 0.031, z + j + 0.05],
            );
        }
    };
    on_legs(x, 0.75, z, [1.6, 0.9]);
    for (i, j) in [(0.1, -0.6), (1.0, -0.6), (0.1, 1.05), (1.0, 1.05)] {
        on_legs(x + i + rng.range(0.0, 0.1), 0.45, z + j, [0.45, 0.45]);
    }
    // A shelf against the wall: two sides and five boards.
    for side in [0.3, 1.5] {
        add([side, 0.001, 0.01], [side + 0.03, 2.0, 0.35]);
    }
    for i in 0..5 {
        let y = 0.2 + 0.4 * f64::from(i);
        add([0.34, y, 0.02], [1.49, y + 0.025, 0.34]);
        for k in 0..2 {
            let x = 0.4 + 0.5 * f64::from(k) + rng.range(0.0, 0.2);
            add(
                [x, y + 0.026, 0.08],
                [x + rng.range(0.1, 0.3), y + rng.range(0.15, 0.3), 0.3],
            );
        }
    }
}

fn triangles(mesh: &ObjMesh) -> usize {
    mesh.polygons.iter().map(|p| p.corners.len() - 2).sum()
}

/// As a file.
fn obj(mesh: &ObjMesh) -> [String; 2] {
    let (mut obj, mut mtl) = (String::from("mtllib rooms.mtl\n"), String::new());
    for s in &mesh.surfaces {
        let ([r, g, b], [x, y, z]) = (s.kd.to_array(), s.ke.to_array());
        writeln!(mtl, "newmtl {}\nKd {r} {g} {b}\nKe {x} {y} {z}", s.name).expect("a string");
    }
    for p in &mesh.polygons {
        writeln!(obj, "usemtl {}", mesh.surfaces[p.surface].name).expect("a string");
        for c in &p.corners {
            writeln!(obj, "v {} {} {}", c.x, c.y, c.z).expect("a string");
        }
        let corners: Vec<String> = (1..=p.corners.len())
            .rev()
            .map(|i| format!("-{i}"))
            .collect();
        writeln!(obj, "f {}", corners.join(" ")).expect("a string");
    }
    [obj, mtl]
}

/// Seconds and peak memory (bytes) of a bake of so many rooms to the relative error `error`, and their triangles.
fn cost(rooms: usize, error: f64) -> [f64; 3] {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = building(rooms);
    let [obj, mtl] = obj(&mesh);
    std::fs::write(folder.path().join("rooms.obj"), obj).expect("writable");
    std::fs::write(folder.path().join("rooms.mtl"), mtl).expect("writable");
    let error = error.to_string();
    let status = Command::new(env!("CARGO_BIN_EXE_umbrage"))
        .args([
            "bake",
            "rooms.obj",
            "--error",
            &error,
            "--json",
            "told.json",
        ])
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .expect("the program starts");
    assert!(status.success());
    let told = std::fs::read_to_string(folder.path().join("told.json")).expect("written");
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    let times = told["summary"]["stages"].as_array().expect("stages");
    let seconds = times
        .iter()
        .map(|t| t["seconds"].as_f64().expect("a time"))
        .sum();
    let memory = told["peak_memory_bytes"].as_f64().expect("a size");
    let measured = &told["summary"]["measured"]["relative_rms"];
    let triangles = triangles(&mesh) as f64;
    eprintln!(
        "{rooms:5} rooms {triangles:8} triangles {seconds:8.2} s {:7.0} MB, measured {measured}",
        memory / 1e6
    );
    [triangles, seconds, memory]
}

/// Links and gathers of a bake of so many rooms.
fn work(rooms: usize) -> [f64; 2] {
    let world = world_of_mesh("rooms", &building(rooms));
    let settings = Settings {
        error: COARSE,
        ..Settings::default()
    };
    let solution = light(&world, &settings, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    let summary = &solution.summary;
    [summary.solve.links as f64, summary.gathers as f64]
}

#[test]
fn twice_the_rooms_are_twice_the_work() {
    let (small, large) = (work(2), work(4));
    for (small, large) in small.into_iter().zip(large) {
        assert!(large <= DEAREST_DOUBLING * small, "{large} after {small}");
        assert!(small > 1000.0, "{small}");
    }
}

/// The power `p` of the best fit `y ∝ x^p`.
fn exponent(points: &[[f64; 2]]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    let n = logs.len() as f64;
    let mean = [0, 1].map(|k| logs.iter().map(|p| p[k]).sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        logs.iter().map(|p| f(p[0] - mean[0], p[1] - mean[1])).sum()
    };
    sum(&|x, y| x * y) / sum(&|x, _| x * x)
}

/// Bakes so many rooms to the relative error `error`, and holds against the triangles what that took.
fn check_growth(rooms: [usize; 4], error: f64) {
    let found = rooms.map(|rooms| cost(rooms, error));
    let of = |k: usize| exponent(&found.map(|f| [f[0], f[k]]));
    let (time, memory) = (of(1), of(2));
    eprintln!("time ∝ triangles^{time:.2}, memory ∝ triangles^{memory:.2}");
    assert!(time <= GREATEST_EXPONENT, "{time:.2}");
    assert!(memory <= GREATEST_EXPONENT, "{memory:.2}");
}

#[test]
#[ignore = "measures time: minutes in release"]
fn time_and_memory_grow_with_the_triangles() {
    // Two rooms take a second round, which would hide growth.
    check_growth([4, 8, 16, 32], 0.05);
}

#[test]
#[ignore = "measures time: ten minutes in release"]
fn time_and_memory_grow_with_the_triangles_up_to_a_million() {
    check_growth([2, 16, 128, 2048], COARSE);
}
