//! Diagonals turned along the light: the same vertices, less error.
//!
//! A penumbra is steep across and flat along, so its best triangles are long. Of the two diagonals of a convex
//! quadrilateral the better one follows from the light at both their middles. No edge on a line is turned.
//!
//! Paper: N. Dyn, D. Levin & S. Rippa, *Data dependent triangulations for piecewise linear interpolation*, 1990.

use super::misfit::unfitted;
use super::{Illumination, Receiver};
use crate::mesh::{ReceiverMesh, orient};
use crate::quantity::Irradiance;
use std::sync::Arc;

/// A diagonal is turned when that leaves at most this share of the error: so the turning ends, and noise turns nothing.
const LEFT_SHARE: f64 = 0.9;

/// Quadrilaterals whose error is below this share of what is refined anyway are left alone: their light costs more than it tells.
const FLOOR_SHARE: f64 = 0.3;

/// Triangles get no flatter than this many pixels: the grid's rounding would show in their shape.
const FLATTEST_PX: i64 = 64;

/// Misfits at the middles of an element's edges, as far as they are known, W/m².
type EdgeMisfits = [Option<Irradiance>; 3];

/// Two elements, the first's edge between them and the second's.
#[derive(Clone, Copy)]
struct Pair {
    e: usize,
    k: usize,
    f: usize,
    m: usize,
}

impl Pair {
    /// The elements to both sides of edge `k` of `e`, if it lies on no line.
    fn across(mesh: &ReceiverMesh, e: usize, k: usize) -> Option<Self> {
        if mesh.edges[e][k].is_some() {
            return None;
        }
        let f = mesh.neighbours[e][k]? as usize;
        let m = (0..3).find(|&m| mesh.neighbours[f][m] == Some(e as u32))?;
        Some(Self { e, k, f, m })
    }

    /// Twice the areas before and after the turn, square pixels; none when the turn is impossible.
    fn areas(self, mesh: &ReceiverMesh) -> Option<[[i64; 2]; 2]> {
        let at = |e: usize, k: usize| mesh.vertices[mesh.elements[e][k % 3] as usize];
        let [a, b] = [at(self.e, self.k), at(self.e, self.k + 1)];
        let [c, d] = [at(self.e, self.k + 2), at(self.f, self.m + 2)];
        let after = [orient(a, d, c), orient(d, b, c)];
        let across = (c.x - d.x).abs().max((c.y - d.y).abs());
        let is_fine = after.iter().all(|&area| area > FLATTEST_PX * across);
        is_fine.then_some([[orient(a, b, c), orient(b, a, d)], after])
    }
}

impl Receiver {
    /// Turns diagonals of `mesh` as long as that makes the light fit better; elements with squared errors far below
    /// `limit` are not worth it.
    pub(super) fn turn_diagonals(
        &mut self,
        light: &Illumination,
        mesh: &mut Arc<ReceiverMesh>,
        limit: f64,
    ) {
        let mut open: Vec<(usize, usize)> = (0..mesh.elements.len())
            .flat_map(|e| [(e, 0), (e, 1), (e, 2)])
            .collect();
        let mut misfits: Vec<EdgeMisfits> = vec![[None; 3]; mesh.elements.len()];
        while let Some((e, k)) = open.pop() {
            let Some(pair) = Pair::across(mesh, e, k) else {
                continue;
            };
            if self.should_turn(light, mesh, &mut misfits, pair, FLOOR_SHARE * limit) {
                Arc::make_mut(mesh).flip(pair.e, pair.k, pair.f, pair.m);
                for t in [pair.e, pair.f] {
                    misfits[t] = [None; 3];
                    open.extend([(t, 0), (t, 1), (t, 2)]);
                }
            }
        }
    }

    /// The misfit at edge `k` of element `e`, looked up once.
    fn known_misfit(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        misfits: &mut [EdgeMisfits],
        e: usize,
        k: usize,
    ) -> Irradiance {
        if let Some(known) = misfits[e][k] {
            return known;
        }
        let misfit = self.edge_misfit(light, mesh, e, k);
        misfits[e][k] = Some(misfit);
        if let Some(Pair { f, m, .. }) = Pair::across(mesh, e, k) {
            misfits[f][m] = Some(misfit);
        }
        misfit
    }

    fn should_turn(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        misfits: &mut [EdgeMisfits],
        pair: Pair,
        floor: f64,
    ) -> bool {
        let Some([before, after]) = pair.areas(mesh) else {
            return false;
        };
        let Pair { e, k, f, m } = pair;
        let mut at = |e: usize, k: usize| self.known_misfit(light, mesh, misfits, e, k % 3);
        let ab = at(e, k);
        let [bc, ca] = [at(e, k + 1), at(e, k + 2)];
        let [ad, db] = [at(f, m + 1), at(f, m + 2)];
        let pixels = 0.5 * self.domain.grid.pixel_size().powi(2);
        let cost = |edges: [Irradiance; 3], area: i64| area as f64 * pixels * unfitted(edges);
        let around: f64 = [bc, ca, ad, db]
            .iter()
            .map(|m| m.0.mean_square())
            .fold(0.0, f64::max);
        if around * pixels * (before[0] + before[1]) as f64 <= floor {
            return false;
        }
        let cd = self.chord_misfit(light, mesh, [(e, (k + 2) % 3), (f, (m + 2) % 3)]);
        let now = cost([ab, bc, ca], before[0]) + cost([ab, ad, db], before[1]);
        let then = cost([ad, cd, ca], after[0]) + cost([db, bc, cd], after[1]);
        then < LEFT_SHARE * now
    }
}
