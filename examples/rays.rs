//! How many rays a second the ray caster tells hit or miss, on one core; the same rays are written for other programs.
//!
//! ```text
//! cargo run --release --example rays -- SCENE OUT.bin
//! ```
//!
//! Rays join random points of random triangles, uniform by area, slightly off both surfaces: what a bake asks when it looks at
//! an emitter. `OUT.bin` holds, little-endian: the number of triangles and of rays (u32), nine f32 a triangle, six f32 a ray
//! (start, and way to its end), one byte a ray (1: hidden).

use glam::DVec3;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};
use umbrage::io::{ReadSettings, read_scene};
use umbrage::pipeline::World;
use umbrage::settings::Settings;
use umbrage::visibility::RayCaster;

const RAYS: usize = 1_000_000;

/// The best of so many rounds: other work on the machine only takes time.
const ROUNDS: usize = 5;

/// Sine of the least angle between a ray and the surfaces at its ends.
const GRAZING: f64 = 0.01;

/// A share of the way that is left out at both ends.
const OFF: f64 = 1e-4;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (Some(scene), Some(out)) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: rays SCENE OUT.bin");
        std::process::exit(2);
    };
    if let Err(error) = run(Path::new(&scene), Path::new(&out)) {
        eprintln!("error: {error}");
        std::process::exit(2);
    }
}

fn run(scene: &Path, out: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let raw = read_scene(scene, &ReadSettings::default())?;
    let world = World::new(&raw, &Settings::default())?;
    let scene = &world.scene;
    // Both programs see the same: positions as f32.
    let corner = |v| scene.vertices[v].as_vec3().as_dvec3();
    let triangles: Vec<[DVec3; 3]> = scene
        .faces
        .iter()
        .flat_map(|(_, face)| face.triangles.iter().map(|t| t.map(corner)))
        .collect();
    let rays = rays(&triangles);
    let start = Instant::now();
    let caster = RayCaster::new(&triangles);
    let built = start.elapsed();

    let mut best = Duration::MAX;
    let mut hidden = Vec::new();
    for _ in 0..ROUNDS {
        let start = Instant::now();
        hidden = rays
            .iter()
            .map(|&[from, way]| caster.is_blocked(from, from + way, 0.0, 1.0, |_| false))
            .collect();
        best = best.min(start.elapsed());
    }

    let mut bytes = Vec::new();
    for count in [triangles.len(), rays.len()] {
        bytes.extend(u32::try_from(count)?.to_le_bytes());
    }
    for v in triangles.iter().flatten().chain(rays.iter().flatten()) {
        for x in v.as_vec3().to_array() {
            bytes.extend(x.to_le_bytes());
        }
    }
    bytes.extend(hidden.iter().map(|&h: &bool| u8::from(h)));
    std::fs::File::create(out)?.write_all(&bytes)?;
    writeln!(
        std::io::stdout(),
        "{} triangles, built in {:.3} s; {} rays, {:.3} hidden; {:.3} million rays a second",
        triangles.len(),
        built.as_secs_f64(),
        rays.len(),
        hidden.iter().filter(|h| **h).count() as f64 / rays.len() as f64,
        rays.len() as f64 / best.as_secs_f64() / 1e6
    )?;
    Ok(())
}

/// Starts and ways to the ends, all in f32.
fn rays(triangles: &[[DVec3; 3]]) -> Vec<[DVec3; 2]> {
    let mut areas = Vec::with_capacity(triangles.len());
    let mut sum = 0.0;
    for [a, b, c] in triangles {
        sum += (b - a).cross(c - a).length();
        areas.push(sum);
    }
    let mut state = 1_u64;
    // SplitMix64 (Steele, Lea, Flood 2014).
    let mut unit = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut point = || {
        let at = sum * unit();
        let k = areas.partition_point(|&s| s <= at).min(areas.len() - 1);
        let [a, b, c] = triangles[k];
        let (root, v) = (unit().sqrt(), unit());
        let p = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
        (p, (b - a).cross(c - a).normalize_or_zero())
    };
    let single = |p: DVec3| p.as_vec3().as_dvec3();
    let mut rays = Vec::with_capacity(RAYS);
    while rays.len() < RAYS {
        let ((a, m), (b, n)) = (point(), point());
        let way = b - a;
        // Along a surface it is rounding that decides.
        if m.dot(way).abs().min(n.dot(way).abs()) > GRAZING * way.length() {
            rays.push([a.lerp(b, OFF), way * (1.0 - 2.0 * OFF)].map(single));
        }
    }
    rays
}
