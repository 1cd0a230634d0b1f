//! The basis by itself, and rows of links in it.

use super::super::Basis;
use super::super::cells::CellLight;
use super::super::tests::{cube_mesh, random};
use super::*;
use crate::quantity::{Radiosity, Rgb};
use glam::DVec2;

/// Coefficients and moments are sums of a few products of numbers near 1.
const ROUNDOFF: f64 = 1e-13;

/// A function over two halves of a triangle.
type Halves = [[f64; 3]; 2];

/// The three wavelets by their values at the corners of both halves.
fn wavelets() -> [Halves; 3] {
    [0, 1, 2].map(|k| {
        let mut one = [DVec3::ZERO; 3];
        one[k] = DVec3::ONE;
        halves([DVec3::ZERO; 3], one, [0, 1, 2]).map(|half| half.map(|v| v.x))
    })
}

/// `∫ u v` of two linear functions over a triangle.
fn product(u: [f64; 3], v: [f64; 3], t: [DVec2; 3]) -> f64 {
    let area = 0.5 * (t[1] - t[0]).perp_dot(t[2] - t[0]).abs();
    let sum = |x: [f64; 3]| x.iter().sum::<f64>();
    let same: f64 = u.iter().zip(v).map(|(a, b)| a * b).sum();
    area / 12.0 * (sum(u) * sum(v) + same)
}

/// A random triangle, and its halves.
fn triangle(next: &mut impl FnMut() -> f64) -> ([DVec2; 3], [[DVec2; 3]; 2]) {
    let [a, b, c] = [0, 1, 2].map(|_| DVec2::new(next(), next()));
    let m = a.midpoint(b);
    ([a, b, c], [[a, m, c], [m, b, c]])
}

#[test]
fn wavelets_are_orthonormal_over_triangles_of_all_shapes() {
    let mut next = random(1);
    for _ in 0..50 {
        let ([a, b, c], parts) = triangle(&mut next);
        let area = 0.5 * (b - a).perp_dot(c - a).abs();
        for (i, u) in wavelets().iter().enumerate() {
            for (j, v) in wavelets().iter().enumerate() {
                let both = product(u[0], v[0], parts[0]) + product(u[1], v[1], parts[1]);
                let known = f64::from(u8::from(i == j));
                assert!((both / area - known).abs() < ROUNDOFF, "{i} {j}: {both}");
            }
        }
    }
}

#[test]
fn wavelets_have_neither_means_nor_first_moments() {
    let mut next = random(2);
    for _ in 0..50 {
        let (_, parts) = triangle(&mut next);
        let functions = [|_: DVec2| 1.0, |p: DVec2| p.x, |p: DVec2| p.y];
        for (i, wavelet) in wavelets().iter().enumerate() {
            for f in functions {
                let moment: f64 = parts
                    .iter()
                    .zip(wavelet)
                    .map(|(t, &u)| product(u, t.map(f), *t))
                    .sum();
                assert!(moment.abs() < ROUNDOFF, "{i}: {moment}");
            }
        }
    }
}

#[test]
fn wavelets_of_a_cell_are_at_right_angles_to_those_of_its_halves() {
    // On a half they are linear: those of the half have no product with that.
    let mut next = random(3);
    for _ in 0..20 {
        let (_, [half, _]) = triangle(&mut next);
        let m = half[0].midpoint(half[1]);
        let parts = [[half[0], m, half[2]], [m, half[1], half[2]]];
        for coarse in wavelets().map(|w| w[0]) {
            let middle = 0.5 * (coarse[0] + coarse[1]);
            let on = [
                [coarse[0], middle, coarse[2]],
                [middle, coarse[1], coarse[2]],
            ];
            for fine in wavelets() {
                let both = product(on[0], fine[0], parts[0]) + product(on[1], fine[1], parts[1]);
                assert!(both.abs() < ROUNDOFF, "{both}");
            }
        }
    }
}

fn random_corners(next: &mut impl FnMut() -> f64) -> Corners {
    [0, 1, 2].map(|_| DVec3::new(next(), next(), next()))
}

#[test]
fn halves_are_told_by_the_whole_and_its_wavelets() {
    let mut next = random(4);
    for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        let [left, right] = [0, 1].map(|_| random_corners(&mut next));
        let whole = projected(left, right, order);
        let coefficients = details(left, right);
        let again = halves(whole, coefficients, order);
        for (a, b) in again.concat().iter().zip([left, right].concat()) {
            assert!(a.distance(b) < ROUNDOFF, "{a} for {b}");
        }
        // Nothing of the square is lost, either.
        let both = 0.5 * (mean_square(&left) + mean_square(&right));
        let squares: f64 = coefficients.iter().map(|d| d.length_squared()).sum();
        assert!((mean_square(&whole) + squares - both).abs() < ROUNDOFF);
    }
}

#[test]
fn what_is_linear_has_no_wavelets() {
    let mut next = random(5);
    let [a, b, c] = random_corners(&mut next);
    let m = (a + b) * 0.5;
    for d in details([a, m, c], [m, b, c]) {
        assert!(d.length() < ROUNDOFF, "{d}");
    }
}

/// The first wall of a cube in cells of 1/8 of its width with random light, and a row that takes something of half of the
/// cells of all sizes.
fn random_row(seed: u64) -> (SolveMesh, FaceCells, FaceLight, Vec<Link>) {
    let mesh = cube_mesh(0.5);
    let tree = FaceCells::new(&mesh.faces[0], 0.125, Basis::Wavelet);
    let mut next = random(seed);
    let mut light = FaceLight::dark(&tree);
    for i in tree.leaves() {
        light.cells[i] = CellLight::linear(random_corners(&mut next).map(|c| Radiosity(Rgb(c))));
    }
    light.pull(&tree);
    let mut row = Vec::new();
    for cell in 0..tree.cells.len() as u32 {
        if next() < 0.5 {
            let weights = [next(), next(), next()];
            row.push(Link { cell, weights });
        }
    }
    (mesh, tree, light, row)
}

/// What links take light from.
fn coefficients(tree: &FaceCells, light: &FaceLight) -> Vec<Corners> {
    let corners = |c: usize| light.cells[c].corners.map(|c| c.0.0);
    let mut found = vec![[DVec3::ZERO; 3]; tree.cells.len()];
    (0..tree.roots as usize).for_each(|r| found[r] = corners(r));
    for (_, child) in halved(tree) {
        found[child] = details(corners(child), corners(child + 1));
    }
    found
}

fn gathered(row: &[Link], light: impl Fn(usize) -> Corners) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for link in row {
        for (b, w) in light(link.cell as usize).iter().zip(link.weights) {
            sum += *b * w;
        }
    }
    sum
}

#[test]
fn a_row_brings_the_same_in_both_bases() {
    for seed in 1..5 {
        let (mesh, tree, light, row) = random_row(seed);
        let known = gathered(&row, |c| light.cells[c].corners.map(|c| c.0.0));
        let (told, trees) = (coefficients(&tree, &light), [tree]);
        let mut lights = vec![FaceLight::default(); 6];
        lights[0] = light;
        let sources = Sources::new(&mesh, lights, 0.0);
        // With nothing permitted, and with a per cent and a tenth of what comes.
        for share in [0.0, 0.01, 0.1] {
            let permitted = share * known.length();
            let wavelets = Wavelets::new(&mesh, &trees, &[0], &sources, permitted);
            let (links, dropped) = wavelets.compressed(row.iter().copied());
            let off = gathered(&links, |c| told[c]) - known;
            // The sizes are means of the three channels.
            let off = off.length() / 3_f64.sqrt();
            assert!(off <= permitted + ROUNDOFF * known.length(), "{off}");
            assert_eq!(dropped > 0, share > 0.0, "{dropped}");
        }
    }
}
