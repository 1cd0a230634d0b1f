//! Convex parts of a face.
//!
//! S. Hertel, K. Mehlhorn, *Fast triangulation of simple polygons*, 1983: drop diagonals of a triangulation as long as
//! both their ends stay convex; at most four times as many parts remain as the best division has.

use super::triangulate::Triangulation;
use crate::geom::predicates::{Side, side_of_line};
use crate::scene::VertexId;

/// The triangles of a face joined into convex polygons; straight corners are allowed, the signs are exact.
pub(super) fn convex_parts(triangulation: &Triangulation) -> Vec<Vec<VertexId>> {
    let mut parts = Parts::new(&triangulation.triangles);
    let points = &triangulation.points;
    // Longest diagonals first: the parts come out compact rather than as fans.
    let mut diagonals = parts.diagonals();
    diagonals.sort_by(|&(h, _), &(k, _)| {
        let length = |h: usize| {
            points[parts.origin[h]].distance_squared(points[parts.origin[triangle_next(h)]])
        };
        length(k).total_cmp(&length(h)).then(h.cmp(&k))
    });
    for (h, twin) in diagonals {
        let is_convex = |before: usize, at: usize, after: usize| {
            side_of_line(points[before], points[at], points[after]) != Side::Right
        };
        let end = |k: usize| parts.origin[parts.next[k]];
        let start = |k: usize| parts.origin[parts.previous[k]];
        if is_convex(start(h), parts.origin[h], end(parts.next[twin]))
            && is_convex(start(twin), parts.origin[twin], end(parts.next[h]))
        {
            parts.join(h, twin);
        }
    }
    parts
        .polygons()
        .into_iter()
        .map(|l| l.into_iter().map(|i| triangulation.vertices[i]).collect())
        .collect()
}

fn triangle_next(h: usize) -> usize {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// Half-edges: `3 t + i` runs from corner `i` of triangle `t`.
struct Parts {
    origin: Vec<usize>,
    next: Vec<usize>,
    previous: Vec<usize>,
    is_gone: Vec<bool>,
}

impl Parts {
    fn new(triangles: &[[usize; 3]]) -> Self {
        let count = 3 * triangles.len();
        Self {
            origin: triangles.iter().flatten().copied().collect(),
            next: (0..count).map(triangle_next).collect(),
            previous: (0..count)
                .map(|h| if h % 3 == 0 { h + 2 } else { h - 1 })
                .collect(),
            is_gone: vec![false; count],
        }
    }

    /// Pairs of half-edges that run along the same diagonal in opposite directions.
    fn diagonals(&self) -> Vec<(usize, usize)> {
        let ends = |h: usize| {
            let (a, b) = (self.origin[h], self.origin[self.next[h]]);
            (a.min(b), a.max(b))
        };
        let mut order: Vec<usize> = (0..self.origin.len()).collect();
        order.sort_unstable_by_key(|&h| (ends(h), h));
        order
            .chunk_by(|&h, &k| ends(h) == ends(k))
            .filter(|uses| uses.len() == 2)
            .map(|uses| (uses[0], uses[1]))
            .collect()
    }

    /// Removes the diagonal and links the two parts into one.
    fn join(&mut self, h: usize, twin: usize) {
        for (h, twin) in [(h, twin), (twin, h)] {
            let (before, after) = (self.previous[h], self.next[twin]);
            self.next[before] = after;
            self.previous[after] = before;
            self.is_gone[h] = true;
        }
    }

    fn polygons(&self) -> Vec<Vec<usize>> {
        let mut is_walked = self.is_gone.clone();
        let mut polygons = Vec::new();
        for start in 0..is_walked.len() {
            let mut polygon = Vec::new();
            let mut h = start;
            while !is_walked[h] {
                is_walked[h] = true;
                polygon.push(self.origin[h]);
                h = self.next[h];
            }
            if !polygon.is_empty() {
                polygons.push(polygon);
            }
        }
        polygons
    }
}
