//! The links of one node, in no more memory than what is known of them needs: of all that a large scene keeps they are the most.

use super::system::Corners;
use glam::DVec3;
use std::ops::Range;

/// What a node receives of the light at the corners of a cell.
#[derive(Clone, Copy, Debug)]
pub(in crate::radiosity) struct Link {
    /// Number of the cell through all blocks.
    pub(in crate::radiosity) cell: u32,
    pub(in crate::radiosity) weights: [f64; 3],
}

/// A link in single precision.
#[derive(Clone, Copy, Debug)]
pub(in crate::radiosity) struct ShortLink {
    cell: u32,
    weights: [f32; 3],
}

/// A link with the mean over a cell, in single precision.
#[derive(Clone, Copy, Debug)]
pub(in crate::radiosity) struct MeanLink {
    cell: u32,
    weight: f32,
}

/// The links of one node, those with cells of one block beside each other.
#[derive(Clone, Debug)]
pub(in crate::radiosity) enum Row {
    /// Right to round-off.
    Exact(Box<[Link]>),
    /// Told in part by rays, to a per cent: seven digits are plenty.
    Short(Box<[ShortLink]>),
    /// Told by rays alone, which take the light over a cell for even.
    Means(Box<[MeanLink]>),
}

impl From<Link> for ShortLink {
    fn from(link: Link) -> Self {
        Self {
            cell: link.cell,
            weights: link.weights.map(|w| w as f32),
        }
    }
}

impl From<Link> for MeanLink {
    fn from(link: Link) -> Self {
        Self {
            cell: link.cell,
            weight: link.weights.iter().sum::<f64>() as f32,
        }
    }
}

impl From<ShortLink> for Link {
    fn from(link: ShortLink) -> Self {
        Self {
            cell: link.cell,
            weights: link.weights.map(f64::from),
        }
    }
}

impl From<MeanLink> for Link {
    fn from(link: MeanLink) -> Self {
        Self {
            cell: link.cell,
            weights: [f64::from(link.weight) / 3.0; 3],
        }
    }
}

impl Row {
    /// As exact as the links are.
    pub(in crate::radiosity) fn exact(links: Vec<Link>) -> Self {
        Self::Exact(links.into_boxed_slice())
    }

    /// In single precision.
    pub(in crate::radiosity) fn short(links: Vec<Link>) -> Self {
        Self::Short(links.into_iter().map(ShortLink::from).collect())
    }

    /// In single precision, taking the three weights of each link for equal.
    pub(in crate::radiosity) fn means(links: Vec<Link>) -> Self {
        Self::Means(links.into_iter().map(MeanLink::from).collect())
    }

    /// Number of links.
    pub(in crate::radiosity) fn len(&self) -> usize {
        match self {
            Self::Exact(links) => links.len(),
            Self::Short(links) => links.len(),
            Self::Means(links) => links.len(),
        }
    }

    /// Link number `i`.
    pub(super) fn link(&self, i: usize) -> Link {
        match self {
            Self::Exact(links) => links[i],
            Self::Short(links) => links[i].into(),
            Self::Means(links) => links[i].into(),
        }
    }

    /// All links.
    pub(in crate::radiosity) fn links(&self) -> impl Iterator<Item = Link> + '_ {
        (0..self.len()).map(|i| self.link(i))
    }

    /// What comes by the links in `part` from cells that send `light`, the first of which has number `first`.
    pub(super) fn gather(&self, part: Range<usize>, first: usize, light: &[Corners]) -> DVec3 {
        match self {
            Self::Exact(links) => gathered(&links[part], first, light),
            Self::Short(links) => gathered(&links[part], first, light),
            Self::Means(links) => gathered(&links[part], first, light),
        }
    }
}

fn gathered<L: Copy + Into<Link>>(links: &[L], first: usize, light: &[Corners]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for &link in links {
        let link: Link = link.into();
        for (b, w) in light[link.cell as usize - first].iter().zip(link.weights) {
            sum += *b * w;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_rows_tell_the_same_to_single_precision() {
        let links: Vec<Link> = (0..20)
            .map(|cell| Link {
                cell,
                weights: [f64::from(cell).sqrt() / 70.0; 3],
            })
            .collect();
        let light: Vec<Corners> = (0..20)
            .map(|i| [1.0, 2.0, 4.0].map(|k| DVec3::splat(k * f64::from(i + 1))))
            .collect();
        let gather = |row: &Row, part| row.gather(part, 0, &light).x;
        let exact = Row::exact(links.clone());
        for row in [Row::short(links.clone()), Row::means(links)] {
            assert_eq!(row.len(), exact.len());
            for part in [0..20, 3..7] {
                let (known, found) = (gather(&exact, part.clone()), gather(&row, part));
                assert!((found / known - 1.0).abs() <= f64::from(f32::EPSILON));
            }
            for (a, b) in row.links().zip(exact.links()) {
                assert_eq!(a.cell, b.cell);
            }
        }
    }
}
