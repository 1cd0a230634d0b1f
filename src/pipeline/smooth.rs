//! Facets of a curved surface made to show one light along their common edges.
//!
//! Each facet is lit by itself: by the surface's normal, but with its own horizon, and its indirect light by its own
//! plane. Where facets meet, each has a vertex in the same place. The light of the surface there is what the facet found that
//! sees most: a facet that turns its back to a lamp sees nothing of it, though its surface bends towards it at that vertex,
//! and the next facet sees it whole. So all have one light, and no facet shows. Across a shadow's sharp border nothing is mixed: a vertex where a contact line meets
//! the edge has a value for either part of the edge, and each finds its like on the other facet.
//!
//! Faces in one plane that something else than their shape divides (a material, a texture) are of one light in the same way.

use crate::lit_scene::LitMesh;
use crate::quantity::Irradiance;
use crate::scene::{EdgeId, FaceSide};
use glam::DVec3;
use std::collections::BTreeMap;

/// A place on an edge as one of the two parts of the edge sees it that meet there, on one side of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct SeamKey {
    edge: EdgeId,
    is_back: bool,
    /// Parameter along the edge, 0…1, as its bits: their order is that of the numbers.
    at: u64,
    /// Whether the part of the edge lies beyond the place, or before it.
    is_beyond: bool,
}

impl SeamKey {
    fn new(edge: EdgeId, side: FaceSide, t: f64, is_beyond: bool) -> Self {
        Self {
            edge,
            is_back: side == FaceSide::Back,
            at: (t + 0.0).to_bits(),
            is_beyond,
        }
    }

    /// The keys of both ends of a part of an edge, given by their parameters and vertices.
    pub(super) fn along(edge: EdgeId, side: FaceSide, ends: &[(f64, u32); 2]) -> [(Self, u32); 2] {
        let [(a, from), (b, to)] = *ends;
        [
            (Self::new(edge, side, a, b > a), from),
            (Self::new(edge, side, b, a > b), to),
        ]
    }

    /// The keys of a vertex within such a part.
    pub(super) fn at(edge: EdgeId, side: FaceSide, t: f64) -> [Self; 2] {
        [false, true].map(|is_beyond| Self::new(edge, side, t, is_beyond))
    }
}

/// A vertex of one of the meshes.
type Node = (usize, u32);

/// Gives all vertices that meet in a key, or by way of each other's keys, the largest irradiance found and the mean of their
/// normals; in a plane, where each sees the same, the mean of the irradiance.
pub(super) fn share(meshes: &mut [LitMesh], mut seams: Vec<(SeamKey, Node)>) {
    seams.sort_unstable();
    seams.dedup();
    let mut nodes: Vec<Node> = seams.iter().map(|s| s.1).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let number = |node: &Node| nodes.partition_point(|n| n < node);
    let mut leader: Vec<usize> = (0..nodes.len()).collect();
    for pair in seams.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let a = find(&mut leader, number(&pair[0].1));
        let b = find(&mut leader, number(&pair[1].1));
        leader[a.max(b)] = a.min(b);
    }
    let mut groups: BTreeMap<usize, Vec<Node>> = BTreeMap::new();
    for (i, &node) in nodes.iter().enumerate() {
        let first = find(&mut leader, i);
        groups.entry(first).or_default().push(node);
    }
    for group in groups.values().filter(|group| group.len() > 1) {
        let found = |&(mesh, v): &Node| meshes[mesh].irradiance[v as usize];
        let light = group.iter().map(found);
        let is_flat = group
            .iter()
            .all(|&(mesh, _)| meshes[mesh].normals.is_empty());
        let shared = if is_flat { mean(light) } else { most(light) };
        let normals = group
            .iter()
            .map(|&(mesh, v)| meshes[mesh].normal_at(v as usize));
        let normal = normals.sum::<DVec3>().normalize_or_zero();
        for &(mesh, v) in group {
            let mesh = &mut meshes[mesh];
            mesh.irradiance[v as usize] = shared;
            if let Some(own) = mesh.normals.get_mut(v as usize) {
                *own = normal;
            }
        }
    }
}

/// The largest.
fn most(light: impl Iterator<Item = Irradiance>) -> Irradiance {
    light
        .reduce(|a, b| if b.mean() > a.mean() { b } else { a })
        .unwrap_or(Irradiance::ZERO)
}

/// The mean of what the lit ones have found.
fn mean(light: impl Iterator<Item = Irradiance>) -> Irradiance {
    let (mut sum, mut count) = (Irradiance::ZERO, 0.0_f64);
    for found in light.filter(|&found| found != Irradiance::ZERO) {
        sum += found;
        count += 1.0;
    }
    sum * (1.0 / count.max(1.0))
}

fn find(leader: &mut [usize], mut i: usize) -> usize {
    while leader[i] != i {
        leader[i] = leader[leader[i]];
        i = leader[i];
    }
    i
}
