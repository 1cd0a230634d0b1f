//! Which polygons together are one maximal planar face.

use super::piece::{Piece, Positions};
use crate::geom::Plane;
use crate::scene::VertexId;
use glam::DVec3;

/// Groups of pieces that lie in one plane, touch along edges, and share material, group and facing.
///
/// Each group grows from the largest piece left, whose plane is the best known, across edges that exactly two pieces
/// share. A candidate joins when all its corners are within `planarity` of that plane; its own normal then differs by at
/// most 2 · planarity / height, so of the angle only the sign is left to test.
pub(super) fn coplanar_groups(
    pieces: &[Piece],
    positions: &Positions,
    planarity: f64,
) -> Vec<Vec<usize>> {
    let neighbours = Neighbours::new(pieces);
    let newell: Vec<DVec3> = pieces.iter().map(|p| p.newell(positions)).collect();
    let mut seeds: Vec<usize> = (0..pieces.len()).collect();
    seeds.sort_by(|&a, &b| {
        let area = |i: usize| newell[i].length_squared();
        area(b).total_cmp(&area(a)).then(a.cmp(&b))
    });
    let mut is_taken = vec![false; pieces.len()];
    let mut groups = Vec::new();
    for seed in seeds {
        if is_taken[seed] {
            continue;
        }
        is_taken[seed] = true;
        let mut members = vec![seed];
        let plane = Plane::new(pieces[seed].mean(positions), newell[seed].normalize());
        let mut done = 0;
        while done < members.len() {
            for &candidate in neighbours.of(members[done]) {
                let joins = !is_taken[candidate]
                    && newell[candidate].dot(plane.normal) > 0.0
                    && pieces[candidate]
                        .points(positions)
                        .all(|p| plane.distance(p).abs() <= planarity);
                if joins {
                    is_taken[candidate] = true;
                    members.push(candidate);
                }
            }
            done += 1;
        }
        members.sort_unstable();
        groups.push(members);
    }
    // In the order of the file, so that a face's number tells where it came from.
    groups.sort_unstable();
    groups
}

/// For each piece, those across an edge with exactly two uses in opposite directions, of its material and group.
struct Neighbours {
    start: Vec<usize>,
    items: Vec<usize>,
}

impl Neighbours {
    fn new(pieces: &[Piece]) -> Self {
        let mut uses: Vec<(VertexId, VertexId, usize, bool)> = pieces
            .iter()
            .enumerate()
            .flat_map(|(i, p)| p.edges().map(move |(a, b)| (a.min(b), a.max(b), i, a < b)))
            .collect();
        uses.sort_unstable();
        let mut pairs = Vec::new();
        for edge in uses.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)) {
            if let [e, f] = edge
                && e.2 != f.2
                && e.3 != f.3
                && pieces[e.2].material == pieces[f.2].material
                && pieces[e.2].group == pieces[f.2].group
            {
                pairs.push((e.2, f.2));
                pairs.push((f.2, e.2));
            }
        }
        pairs.sort_unstable();
        let start = (0..=pieces.len())
            .map(|i| pairs.partition_point(|p| p.0 < i))
            .collect();
        Self {
            start,
            items: pairs.into_iter().map(|p| p.1).collect(),
        }
    }

    fn of(&self, piece: usize) -> &[usize] {
        &self.items[self.start[piece]..self.start[piece + 1]]
    }
}
