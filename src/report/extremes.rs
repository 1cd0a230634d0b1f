//! Stiff and extreme rooms: reflectances, emitters and gaps that differ by powers of ten.

use super::scenes::Builder;
use crate::scene::RawScene;

/// Sizes of rooms, m.
const CUBE: [f64; 3] = [1.0; 3];
const OFFICE: [f64; 3] = [4.0, 2.5, 3.0];

/// How much of the light floor, ceiling and walls reflect in the rooms that are extreme in something else.
const USUAL: [f64; 3] = [0.3, 0.7, 0.5];

/// A cube of 1 m that absorbs next to nothing but for its floor, which absorbs all.
pub(super) fn black_floor() -> RawScene {
    let mut b = room("ρ = 0 below ρ = 0.9999", CUBE, [0.0, 0.9999, 0.9999]);
    square_lamp(&mut b, [0.5, 0.9, 0.5], 0.2, 1.0);
    b.raw
}

/// The same where all that absorbs is the back of a small lamp.
pub(super) fn black_speck() -> RawScene {
    let mut b = room("a speck of ρ = 0 in ρ = 0.9999", CUBE, [0.9999; 3]);
    square_lamp(&mut b, [0.5, 0.9, 0.5], 0.01, 1.0);
    b.raw
}

/// Lamps of one size whose exitances span twelve powers of ten.
pub(super) fn lamps_of_all_powers() -> RawScene {
    let mut b = room("lamps of 10⁻⁶ … 10⁶ W/m²", OFFICE, USUAL);
    for (i, exitance) in [1e-6, 1e-2, 1e2, 1e6].into_iter().enumerate() {
        square_lamp(&mut b, [0.5 + i as f64, 2.4, 1.5], 0.2, exitance);
    }
    b.raw
}

/// A lamp of 2 m, and one of 0.4 mm that sends a quarter as much.
pub(super) fn lamps_of_all_sizes() -> RawScene {
    let mut b = room("lamps of 0.4 mm and 2 m", OFFICE, USUAL);
    let (large, small) = (1.0, 2e-4_f64);
    square_lamp(&mut b, [1.2, 2.4, 1.3], large, 1.0);
    square_lamp(&mut b, [3.2, 1.3, 2.1], small, 0.25 / (small * small));
    b.raw
}

/// A sheet 1 µm above the floor.
pub(super) fn micrometre_gap() -> RawScene {
    let mut b = room("sheets 1 µm apart", CUBE, [0.5; 3]);
    square_lamp(&mut b, [0.5, 0.9, 0.5], 0.2, 1.0);
    let paper = b.material(0.8, 0.0);
    b.rectangle(
        "sheet",
        paper,
        [0.3, 1e-6, 0.6],
        [0.5, 0.0, 0.0],
        [0.0, 0.0, -0.4],
    );
    b.raw
}

/// A curtain that hangs from the middle of the lamp.
pub(super) fn curtain_on_lamp() -> RawScene {
    let mut b = room("a curtain on the lamp", CUBE, [0.5; 3]);
    square_lamp(&mut b, [0.5, 0.9, 0.5], 0.2, 1.0);
    let cloth = b.material(0.5, 0.0);
    b.rectangle(
        "curtain",
        cloth,
        [0.5, 0.9, 0.2],
        [0.0, -0.3, 0.0],
        [0.0, 0.0, 0.6],
    );
    b.raw
}

/// A lid that lies in the plane of the lamp, against half of it.
pub(super) fn half_covered_lamp() -> RawScene {
    let mut b = room("a lid on half of the lamp", CUBE, [0.5; 3]);
    square_lamp(&mut b, [0.5, 0.9, 0.5], 0.2, 1.0);
    let lid = b.material(0.5, 0.0);
    b.rectangle(
        "lid",
        lid,
        [0.5, 0.9, 0.2],
        [0.3, 0.0, 0.0],
        [0.0, 0.0, 0.6],
    );
    b.raw
}

/// A ceiling full of lamps, 3 cm wide each.
pub fn many_lamps(columns: usize, rows: usize) -> RawScene {
    let mut b = room(&format!("{} lamps", columns * rows), OFFICE, USUAL);
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let at = |k: usize, n: usize, size: f64| size * (k as f64 + 0.5) / n as f64;
        let place = [at(i, columns, 4.0), 2.4, at(j, rows, 3.0)];
        square_lamp(&mut b, place, 0.015, 10.0);
    }
    b.raw
}

/// A closed room of `size` metres whose floor, ceiling and walls reflect as given.
fn room(name: &str, size: [f64; 3], [floor, ceiling, walls]: [f64; 3]) -> Builder {
    let mut b = Builder::new(name);
    b.room([0.0; 3], size);
    let of = [floor, ceiling, walls].map(|reflectance| b.material(reflectance, 0.0));
    for (i, side) in b.raw.polygons.iter_mut().enumerate() {
        side.material = of[i.min(2)];
    }
    b
}

/// A black lamp about `at` that shines down: `half` m to each side, exitance in W/m².
fn square_lamp(b: &mut Builder, [x, y, z]: [f64; 3], half: f64, exitance: f64) {
    let lamp = b.material(0.0, exitance);
    let corner = [x - half, y, z - half];
    b.rectangle(
        "lamp",
        lamp,
        corner,
        [2.0 * half, 0.0, 0.0],
        [0.0, 0.0, 2.0 * half],
    );
}
