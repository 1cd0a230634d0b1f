//! The edges of a display mesh by what they lie on.

use crate::adapt::Receiver;
use crate::discontinuity::DiscontinuityOrder;
use crate::mesh::EdgeSource;
use glam::DVec2;

/// What an edge of the mesh lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EdgeRole {
    /// Nothing: it lies between two elements.
    Inner,
    /// The outline of the face.
    Outline,
    /// A line across which this order of the irradiance breaks.
    Break(DiscontinuityOrder),
}

/// One edge of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshEdge {
    /// Ends in the coordinates of the face's frame, metres.
    pub ends: [DVec2; 2],
    /// What it lies on; the outline goes before lines, and of several lines the lowest order counts.
    pub role: EdgeRole,
}

/// Every edge of the display mesh of `receiver` once, in the order of its elements.
pub fn mesh_edges(receiver: &Receiver) -> Vec<MeshEdge> {
    let mesh = &receiver.mesh;
    let mut edges = Vec::new();
    for e in 0..mesh.elements.len() {
        let p = mesh.corners(e);
        for k in 0..3 {
            if mesh.neighbours[e][k].is_some_and(|other| (other as usize) < e) {
                continue;
            }
            edges.push(MeshEdge {
                ends: [p[k], p[(k + 1) % 3]],
                role: role(receiver, mesh.edges[e][k]),
            });
        }
    }
    edges
}

fn role(receiver: &Receiver, label: Option<u32>) -> EdgeRole {
    let sources = label.map_or(&[][..], |l| &receiver.mesh.labels[l as usize]);
    let roles = sources.iter().map(|source| match *source {
        EdgeSource::Outline(_) => EdgeRole::Outline,
        EdgeSource::Contact(i) => EdgeRole::Break(receiver.lines.contacts[i as usize].order),
        EdgeSource::Line(i) => EdgeRole::Break(receiver.lines.candidates[i as usize].order),
    });
    roles.min().unwrap_or(EdgeRole::Inner)
}
