//! The quadratic elements of a field over one face, and what is known of how far they are off.

use super::locator::Locator;
use crate::mesh::ReceiverMesh;
use crate::quantity::{Irradiance, Rgb};
use glam::{DVec2, DVec3};

/// Linear interpolation is off by at most this share of the range of the corners, unless light breaks inside.
const LINEAR_SHARE: f64 = 0.25;

/// Quadratic interpolation is off by about this share of what it adds to linear interpolation.
const QUADRATIC_SHARE: f64 = 0.3;

/// Weight of the error found in the middle of an element: of the 7-point rule, corners and edge midpoints being exact.
const CENTRE_WEIGHT: f64 = 9.0 / 20.0;

/// A part of an element, with values of its own, is off by about this share of what its values differ from those that the
/// element had foreseen there: an eighth where the light is smooth, half of it across a break. At a quarter the errors found
/// in the Cornell box and in a room behind blinds were twice those estimated, at a half well below them.
const PART_SHARE: f64 = 0.35;

/// An edge is halved when the element is off along it by at least this share of what it is off along the worst one.
const BENT_SHARE: f64 = 0.3;

/// And by no less than this share of what the element was off by: quadratic interpolation is of third order.
const LEAST_PART_SHARE: f64 = 0.125;

/// What is known of one element.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Knowledge {
    /// Values at the midpoints of its edges, where gathered.
    pub(super) middles: [Option<Irradiance>; 3],
    /// What the field had been there before the element was cut out of larger ones.
    pub(super) foreseen: [Option<Irradiance>; 3],
    /// Mean squared error of that earlier field here.
    pub(super) inherited: Option<f64>,
    /// Error found in its middle (mean square), once gathered there.
    pub(super) centre: Option<f64>,
}

/// A mesh with values at its sites, quadratic where the midpoints of edges are known or foreseen.
pub(super) struct Elements {
    pub(super) mesh: ReceiverMesh,
    pub(super) locator: Locator,
    pub(super) values: Vec<Irradiance>,
    pub(super) known: Vec<Knowledge>,
}

impl Elements {
    /// Nothing known but the values at the sites.
    pub(super) fn new(mesh: ReceiverMesh, values: Vec<Irradiance>) -> Self {
        Self {
            locator: Locator::new(&mesh),
            known: vec![Knowledge::default(); mesh.elements.len()],
            values,
            mesh,
        }
    }

    /// Estimated mean squared error over element `e`.
    pub(super) fn error(&self, e: usize) -> f64 {
        let known = &self.known[e];
        let corners = self.mesh.sites[e].map(|s| self.values[s as usize]);
        if let Some(centre) = known.centre {
            return CENTRE_WEIGHT * centre;
        }
        let is_complete = known.middles.iter().all(Option::is_some);
        if let Some(inherited) = known.inherited {
            if !is_complete {
                return inherited;
            }
            let missed = (0..3).filter_map(|k| {
                let off = known.middles[k]? - known.foreseen[k]?;
                Some(off.0.mean_square())
            });
            let part = PART_SHARE * PART_SHARE * missed.fold(0.0, f64::max);
            return part.max(LEAST_PART_SHARE * LEAST_PART_SHARE * inherited);
        }
        let mut square = 0.0_f64;
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            square = square.max(match known.middles[k] {
                None => LINEAR_SHARE * LINEAR_SHARE * (a - b).0.mean_square(),
                Some(m) => {
                    let bend = (m - (a + b) * 0.5).0.mean_square();
                    QUADRATIC_SHARE * QUADRATIC_SHARE * bend
                }
            });
        }
        square
    }

    /// Which edges of element `e` are worth halving: those along which it is off by most. Where the light breaks along a
    /// line, or falls off towards a corner, edges along the line are left as long as they are.
    pub(super) fn bent_edges(&self, e: usize) -> [bool; 3] {
        let known = &self.known[e];
        let corners = self.mesh.sites[e].map(|s| self.values[s as usize]);
        let bends = [0, 1, 2].map(|k| {
            let foreseen = (corners[k] + corners[(k + 1) % 3]) * 0.5;
            let Some(m) = known.middles[k] else {
                return f64::INFINITY;
            };
            (m - known.foreseen[k].unwrap_or(foreseen)).0.mean_square()
        });
        let most = bends.into_iter().fold(0.0, f64::max);
        bends.map(|b| b >= BENT_SHARE * BENT_SHARE * most)
    }

    /// Doubled grid coordinates of the midpoint of edge `k` of element `e`.
    pub(super) fn key(&self, e: usize, k: usize) -> (i64, i64) {
        let corners = self.mesh.elements[e];
        let [a, b] = [corners[k], corners[(k + 1) % 3]].map(|v| self.mesh.vertices[v as usize]);
        (a.x + b.x, a.y + b.y)
    }

    /// The midpoint of edge `k` of element `e`, on its side of the edge where values may differ across it.
    pub(super) fn middle(&self, e: usize, k: usize, weld_distance: f64) -> DVec2 {
        let p = self.mesh.corners(e);
        let middle = p[k].midpoint(p[(k + 1) % 3]);
        if self.mesh.is_barrier(e, k) {
            self.mesh.inset(e, middle, weld_distance)
        } else {
            middle
        }
    }

    /// The value gathered at the vertex or edge midpoint with doubled grid coordinates `key`, of the element that `p` lies
    /// in: beside a line along which values differ, this tells the sides apart.
    pub(super) fn gathered(&self, p: DVec2, key: (i64, i64)) -> Option<Irradiance> {
        let (e, _) = self.locator.locate(&self.mesh, p)?;
        // A midpoint that became a vertex has been rounded to the grid.
        let is_it = |(x, y): (i64, i64)| (x - key.0).abs() <= 1 && (y - key.1).abs() <= 1;
        (0..3).find_map(|k| {
            let g = self.mesh.vertices[self.mesh.elements[e][k] as usize];
            if is_it((2 * g.x, 2 * g.y)) {
                return Some(self.values[self.mesh.sites[e][k] as usize]);
            }
            let is_middle = is_it(self.key(e, k));
            self.known[e].middles[k].filter(|_| is_middle)
        })
    }

    /// Quadratic interpolation over element `e`; linear along edges whose midpoint is not known.
    pub(super) fn interpolate(&self, e: usize, b: [f64; 3]) -> Irradiance {
        let corners = self.mesh.sites[e].map(|s| self.values[s as usize]);
        let known = &self.known[e];
        let mut sum = Irradiance::ZERO;
        for k in 0..3 {
            sum += corners[k] * b[k];
            if let Some(m) = known.middles[k].or(known.foreseen[k]) {
                let bend = m - (corners[k] + corners[(k + 1) % 3]) * 0.5;
                sum += bend * (4.0 * b[k] * b[(k + 1) % 3]);
            }
        }
        // Quadratic interpolation may dip below zero where light ends within an element.
        Irradiance(Rgb(sum.0.0.max(DVec3::ZERO)))
    }

    /// The field at frame coordinates `p`, and its mean squared error thereabouts.
    pub(super) fn at_with_error(&self, p: DVec2) -> Option<(Irradiance, f64)> {
        let (e, b) = self.locator.locate(&self.mesh, p)?;
        Some((self.interpolate(e, b), self.error(e)))
    }

    /// The field at frame coordinates `p`.
    pub(super) fn at(&self, p: DVec2) -> Irradiance {
        match self.locator.locate(&self.mesh, p) {
            Some((e, b)) => self.interpolate(e, b),
            None => Irradiance::ZERO,
        }
    }
}
