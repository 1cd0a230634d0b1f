//! Which of many triangles holds a point.

use crate::mesh::{ReceiverMesh, barycentric};
use glam::DVec2;
use std::sync::Arc;

/// So few triangles are all looked at: most of many faces have no more, and buckets would take more room than they.
const FEW: usize = 4;

/// Finds triangles by a grid of buckets, which copies share; without one among few.
#[derive(Clone, Debug, Default)]
pub struct Locator(Option<Arc<Buckets>>);

/// A uniform grid of buckets over the triangles' boxes, about one triangle a bucket.
#[derive(Debug)]
struct Buckets {
    lo: DVec2,
    cell: DVec2,
    side: usize,
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Locator {
    /// Sorts the elements of `mesh` into buckets.
    pub fn new(mesh: &ReceiverMesh) -> Self {
        Self::of(mesh.elements.len(), |e| mesh.corners(e))
    }

    /// Sorts `n` triangles with these corners into buckets.
    pub(super) fn of(n: usize, corners: impl Fn(usize) -> [DVec2; 3]) -> Self {
        if n <= FEW {
            return Self::default();
        }
        let used = || (0..n).flat_map(&corners);
        let lo = used().fold(DVec2::INFINITY, DVec2::min);
        let hi = used().fold(DVec2::NEG_INFINITY, DVec2::max);
        let side = ((n as f64).sqrt().ceil() as usize).max(1);
        let mut buckets = Buckets {
            lo,
            cell: ((hi - lo) / side as f64).max(DVec2::splat(f64::MIN_POSITIVE)),
            side,
            starts: Vec::new(),
            items: Vec::new(),
        };
        let mut pairs = Vec::new();
        for e in 0..n {
            let [a, b, c] = corners(e);
            let (from, to) = (
                buckets.bucket(a.min(b).min(c)),
                buckets.bucket(a.max(b).max(c)),
            );
            for j in from.1..=to.1 {
                for i in from.0..=to.0 {
                    pairs.push((j * side + i, e as u32));
                }
            }
        }
        pairs.sort_unstable();
        buckets.starts = (0..=side * side)
            .map(|c| pairs.partition_point(|p| p.0 < c) as u32)
            .collect();
        buckets.items = pairs.into_iter().map(|p| p.1).collect();
        Self(Some(Arc::new(buckets)))
    }

    /// The element that holds `p` and the barycentric coordinates there; outside all elements the one that comes nearest,
    /// with coordinates clamped to it. None when there is no element.
    pub fn locate(&self, mesh: &ReceiverMesh, p: DVec2) -> Option<(usize, [f64; 3])> {
        self.find(mesh.elements.len(), |e| mesh.corners(e), p)
    }

    /// The same for the triangles given to [`Locator::of`].
    pub(super) fn find(
        &self,
        n: usize,
        corners: impl Fn(usize) -> [DVec2; 3],
        p: DVec2,
    ) -> Option<(usize, [f64; 3])> {
        let mut found = None;
        if let Some(buckets) = &self.0 {
            found = deepest(buckets.items_at(p).iter().map(|&e| e as usize), &corners, p);
        }
        if found.is_none_or(|f| f.2 < 0.0) {
            found = deepest(0..n, &corners, p);
        }
        found.map(|(e, b, _)| {
            let clamped = b.map(|x| x.max(0.0));
            let sum: f64 = clamped.iter().sum();
            (e, clamped.map(|x| x / sum))
        })
    }
}

/// Of these triangles, no two of which have more than their borders in common, the one that `p` lies in or is nearest to, the
/// barycentric coordinates there and the least of them.
fn deepest(
    items: impl Iterator<Item = usize>,
    corners: &impl Fn(usize) -> [DVec2; 3],
    p: DVec2,
) -> Option<(usize, [f64; 3], f64)> {
    let mut found: Option<(usize, [f64; 3], f64)> = None;
    for e in items {
        let b = barycentric(corners(e), p);
        // One without area has no coordinates.
        let depth = b[0].min(b[1]).min(b[2]).max(f64::NEG_INFINITY);
        if found.is_none_or(|f| depth > f.2) {
            found = Some((e, b, depth));
        }
        if depth > 0.0 {
            break;
        }
    }
    found
}

impl Buckets {
    fn bucket(&self, p: DVec2) -> (usize, usize) {
        let q = (p - self.lo) / self.cell;
        let index = |x: f64| (x.max(0.0) as usize).min(self.side - 1);
        (index(q.x), index(q.y))
    }

    /// The triangles in the bucket that holds `p`.
    fn items_at(&self, p: DVec2) -> &[u32] {
        let (i, j) = self.bucket(p);
        let c = j * self.side + i;
        &self.items[self.starts[c] as usize..self.starts[c + 1] as usize]
    }
}
