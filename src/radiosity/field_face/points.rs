//! The points of a field: what each has gathered, and from where.

use super::super::cells::FaceLight;
use crate::quantity::Irradiance;
use glam::DVec2;

/// What a point receives of the light at the corners of a cell.
#[derive(Clone, Copy, Debug)]
pub(in crate::radiosity) struct CellLink {
    pub(in crate::radiosity) face: u32,
    pub(in crate::radiosity) cell: u32,
    /// In single precision: only corrections are told by them.
    weights: [f32; 3],
}

/// Where the light of a point comes from.
#[derive(Clone, Debug)]
pub(in crate::radiosity) enum Source {
    /// It is this node of the solution.
    Node(u32),
    /// These cells, by number.
    Cells(Box<[CellLink]>),
    /// Links have become too many for it to be remembered.
    Forgotten,
}

impl Source {
    /// How many cells are remembered.
    pub(in crate::radiosity) fn len(&self) -> usize {
        match self {
            Self::Cells(links) => links.len(),
            Self::Node(_) | Self::Forgotten => 0,
        }
    }
}

/// A point of a field.
#[derive(Clone, Debug)]
pub(in crate::radiosity) struct Point {
    /// Frame coordinates, metres.
    pub(in crate::radiosity) place: DVec2,
    pub(in crate::radiosity) value: Irradiance,
    pub(in crate::radiosity) source: Source,
}

/// What one point gathers.
#[derive(Clone, Debug)]
pub(in crate::radiosity) struct Gathered {
    pub(in crate::radiosity) value: Irradiance,
    pub(in crate::radiosity) source: Source,
}

impl CellLink {
    pub(in crate::radiosity) fn new(f: usize, c: usize, weights: [f64; 3]) -> Self {
        Self {
            face: f as u32,
            cell: c as u32,
            weights: weights.map(|w| w as f32),
        }
    }

    /// The form factor of what is seen of the cell.
    pub(in crate::radiosity) fn form_factor(&self) -> f64 {
        self.weights.iter().map(|&w| f64::from(w)).sum()
    }

    /// Irradiance from the cell when the faces send `light`, W/m².
    pub(in crate::radiosity) fn irradiance(&self, light: &[FaceLight]) -> Irradiance {
        let corners = light[self.face as usize].cells[self.cell as usize].corners;
        let mut sum = Irradiance::ZERO;
        for (b, w) in corners.iter().zip(self.weights) {
            sum += Irradiance(b.0 * f64::from(w));
        }
        sum
    }
}

/// One link for all to the same cell.
pub(in crate::radiosity) fn merged(mut links: Vec<CellLink>) -> Box<[CellLink]> {
    // Stable, so that sums do not depend on how it sorts.
    links.sort_by_key(|l| (l.face, l.cell));
    links.dedup_by(|link, first| {
        let is_same = (link.face, link.cell) == (first.face, first.cell);
        if is_same {
            for (sum, w) in first.weights.iter_mut().zip(link.weights) {
                *sum += w;
            }
        }
        is_same
    });
    links.into_boxed_slice()
}
