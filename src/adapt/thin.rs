//! Vertices that are not worth their elements.
//!
//! Refinement adds points where the coarse mesh of the moment is off; later lines and finer neighbours make some of them
//! superfluous. What the light would lose without a vertex follows from the second derivatives around it, which the
//! samples on its spokes and its ring tell: no new light is asked for.

use super::misfit::unfitted;
use super::receiver::rounded;
use super::{Illumination, Receiver};
use crate::mesh::{EdgeSource, GridPoint, ReceiverMesh, orient};
use crate::quantity::Irradiance;
use glam::DVec2;
use std::sync::Arc;

/// The elements around a vertex with their corner there, counter-clockwise.
struct Star {
    elements: Vec<(usize, usize)>,
    /// The neighbour at the end of each spoke; the ring's edge `i` follows spoke `i`.
    ring: Vec<u32>,
    /// Spokes along the one line that runs through the vertex: two, or none.
    along: Vec<usize>,
}

impl Star {
    /// None when the vertex lies on a border of the values, where lines cross, or where one ends.
    fn around(mesh: &ReceiverMesh, first: (usize, usize)) -> Option<Self> {
        let vertex = mesh.elements[first.0][first.1];
        let (mut elements, mut ring, mut along) = (Vec::new(), Vec::new(), Vec::new());
        let mut line: Option<&[EdgeSource]> = None;
        let (mut e, mut k) = first;
        loop {
            if let Some(label) = mesh.edges[e][k] {
                let sources = &mesh.labels[label as usize][..];
                let is_same = line.is_none_or(|l| l == sources);
                if mesh.is_barrier(e, k) || !is_same {
                    return None;
                }
                line = Some(sources);
                along.push(ring.len());
            }
            elements.push((e, k));
            ring.push(mesh.elements[e][(k + 1) % 3]);
            e = mesh.neighbours[e][(k + 2) % 3]? as usize;
            k = mesh.elements[e].iter().position(|&c| c == vertex)?;
            if (e, k) == first {
                break;
            }
        }
        let is_plain = along.is_empty() || along.len() == 2;
        is_plain.then_some(Self {
            elements,
            ring,
            along,
        })
    }
}

/// A vertex that the mesh could do without.
pub(super) struct Removable {
    /// What the squared error grows by, (W/m²)² m².
    pub(super) loss: f64,
    vertex: u32,
    ring: Vec<u32>,
}

/// `−dᵀ H d / 8`, the misfit at the middle of a chord `d` of light with the second derivatives `H`, as factors of its three.
fn bend(d: DVec2) -> [f64; 3] {
    [d.x * d.x, 2.0 * d.x * d.y, d.y * d.y].map(|t| -0.125 * t)
}

/// Second derivatives (xx, xy, yy) from chords and their misfits by least squares, W/m⁴.
fn second_derivatives(chords: &[(DVec2, Irradiance)]) -> Option<[Irradiance; 3]> {
    let mut a = [[0.0; 3]; 3];
    let mut r = [Irradiance::ZERO; 3];
    for &(d, misfit) in chords {
        let t = bend(d);
        // Long and short chords tell as much.
        let weight = 1.0 / d.length_squared().powi(2);
        for i in 0..3 {
            r[i] += misfit * (t[i] * weight);
            for j in 0..3 {
                a[i][j] += t[i] * t[j] * weight;
            }
        }
    }
    // a is symmetric, so its cofactors are its inverse times the determinant.
    let a = a.map(glam::DVec3::from);
    let cofactors = [a[1].cross(a[2]), a[2].cross(a[0]), a[0].cross(a[1])];
    let determinant = a[0].dot(cofactors[0]);
    (determinant != 0.0).then(|| {
        [0, 1, 2].map(|i| {
            let c = cofactors[i] / determinant;
            r[0] * c.x + r[1] * c.y + r[2] * c.z
        })
    })
}

impl Receiver {
    /// The points that could go, the least loss first.
    pub(super) fn removable(&mut self, light: &Illumination) -> Vec<Removable> {
        let mut found = Vec::new();
        if !self.is_lit {
            return found;
        }
        let mesh = Arc::clone(&self.mesh);
        let mut corners: Vec<Option<(usize, usize)>> = vec![None; mesh.vertices.len()];
        for (e, elements) in mesh.elements.iter().enumerate() {
            for k in 0..3 {
                corners[elements[k] as usize].get_or_insert((e, k));
            }
        }
        for (v, corner) in corners.into_iter().enumerate() {
            let is_in = |points: &[GridPoint]| points.binary_search(&mesh.vertices[v]).is_ok();
            let is_ours = is_in(&self.points) && !is_in(&self.seeds);
            let Some(first) = corner.filter(|_| is_ours) else {
                continue;
            };
            let Some(star) = Star::around(&mesh, first) else {
                continue;
            };
            if let Some(loss) = self.loss_without(light, &mesh, v, &star) {
                let loss = loss * self.distrust;
                found.push(Removable {
                    loss,
                    vertex: v as u32,
                    ring: star.ring,
                });
            }
        }
        found.sort_unstable_by(|a, b| {
            let loss = rounded(a.loss).total_cmp(&rounded(b.loss));
            loss.then(a.vertex.cmp(&b.vertex))
        });
        found
    }

    /// Removes the points among `found` that add at most `most` each to the squared error; their number.
    ///
    /// What was computed for a vertex must still hold, so its neighbours stay.
    pub(super) fn remove(&mut self, found: &[Removable], most: f64) -> usize {
        let mut stays = vec![false; self.mesh.vertices.len()];
        let mut gone: Vec<GridPoint> = Vec::new();
        for point in found
            .iter()
            .take_while(|p| rounded(p.loss) <= rounded(most))
        {
            if !stays[point.vertex as usize] {
                gone.push(self.mesh.vertices[point.vertex as usize]);
                for &neighbour in &point.ring {
                    stays[neighbour as usize] = true;
                }
            }
        }
        gone.sort_unstable();
        self.points.retain(|p| gone.binary_search(p).is_err());
        self.is_stale |= !gone.is_empty();
        gone.len()
    }

    /// What the squared error over a star grows by when its vertex is merged with the best of its neighbours.
    fn loss_without(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        v: usize,
        star: &Star,
    ) -> Option<f64> {
        let at = |v: u32| mesh.plane[v as usize];
        let count = star.ring.len();
        let mut now = 0.0;
        let mut outer = Vec::with_capacity(count);
        let mut chords = Vec::with_capacity(2 * count);
        for (i, &(e, k)) in star.elements.iter().enumerate() {
            let edges = [0, 1, 2].map(|j| self.edge_misfit(light, mesh, e, (k + j) % 3));
            let [p, q] = [star.ring[i], star.ring[(i + 1) % count]].map(at);
            now += mesh.area(e) * unfitted(edges);
            chords.extend([(p - mesh.plane[v], edges[0]), (q - p, edges[1])]);
            outer.push(edges[1]);
        }
        let second = second_derivatives(&chords)?;
        let predicted = |p: u32, q: u32| {
            let t = bend(at(q) - at(p));
            second[0] * t[0] + second[1] * t[1] + second[2] * t[2]
        };
        // On a line the vertex may only move along it.
        (0..count)
            .filter(|i| star.along.is_empty() || star.along.contains(i))
            .filter_map(|i| self.fan_error(mesh, star, i, &outer, predicted))
            .min_by(f64::total_cmp)
            .map(|then| then - now)
    }

    /// Squared error over the star as a fan around vertex `i` of its ring; none if that does not cover it.
    fn fan_error(
        &self,
        mesh: &ReceiverMesh,
        star: &Star,
        i: usize,
        outer: &[Irradiance],
        predicted: impl Fn(u32, u32) -> Irradiance,
    ) -> Option<f64> {
        let count = star.ring.len();
        let pixels = 0.5 * self.domain.grid.pixel_size().powi(2);
        let apex = star.ring[i];
        // From the apex to the j-th vertex after it: the ring's own edges, or new chords.
        let spoke = |j: usize| match j {
            1 => outer[i],
            _ if j == count - 1 => outer[(i + count - 1) % count],
            _ => predicted(apex, star.ring[(i + j) % count]),
        };
        let mut sum = 0.0;
        for j in 1..count - 1 {
            let [p, q] = [(i + j) % count, (i + j + 1) % count].map(|c| star.ring[c]);
            let [a, b, c] = [apex, p, q].map(|v| mesh.vertices[v as usize]);
            let area = orient(a, b, c);
            if area <= 0 {
                return None;
            }
            let edges = [spoke(j), outer[(i + j) % count], spoke(j + 1)];
            sum += area as f64 * pixels * unfitted(edges);
        }
        Some(sum)
    }
}
