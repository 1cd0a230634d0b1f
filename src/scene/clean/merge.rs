//! Which polygons together are one maximal planar face.

use super::best_plane::best_plane;
use super::piece::{Piece, Positions};
use super::surface::{Corners, SurfaceMaps};
use crate::geom::Plane;
use crate::scene::VertexId;
use glam::DVec3;

/// Rounds of growing a group anew from the plane of all its members. The seed's corners are rounded, so far from it its
/// plane is off by that rounding times the distance over the seed's size; each round multiplies the size.
const MAX_REFITS: usize = 4;

/// Groups of pieces that lie in one plane, touch along edges, share material, group and facing, and whose texture and
/// shading go on from one to the next.
///
/// Each group grows from the largest piece left, whose plane is the best known, across edges that exactly two pieces
/// share, or at which only coplanar sheets meet. A candidate joins when all its corners are within `planarity` of that plane; its own normal then differs by at
/// most 2 · planarity / height, so of the angle only the sign is left to test.
pub(super) fn coplanar_groups(
    pieces: &[Piece],
    positions: &Positions,
    planarity: f64,
    corners: &Corners<'_>,
    maps: &[SurfaceMaps],
) -> Vec<Vec<usize>> {
    let newell: Vec<DVec3> = pieces.iter().map(|p| p.newell(positions)).collect();
    let mut seeds: Vec<usize> = (0..pieces.len()).collect();
    seeds.sort_by(|&a, &b| {
        let area = |i: usize| newell[i].length_squared();
        area(b).total_cmp(&area(a)).then(a.cmp(&b))
    });
    let are_coplanar = |along: &[Use]| {
        let area = |u: &&Use| newell[u.piece].length_squared();
        let largest = along.iter().max_by(|a, b| area(a).total_cmp(&area(b)));
        let frame =
            largest.and_then(|u| best_plane(newell[u.piece], pieces[u.piece].points(positions)));
        frame.is_some_and(|frame| {
            let plane = frame.plane();
            along
                .iter()
                .flat_map(|u| pieces[u.piece].points(positions))
                .all(|p| plane.distance(p).abs() <= planarity)
        })
    };
    let mut growth = Growth {
        neighbours: Neighbours::new(pieces, are_coplanar, &newell),
        pieces,
        positions,
        newell,
        planarity,
        corners,
        maps,
        is_taken: vec![false; pieces.len()],
    };
    let mut groups = Vec::new();
    for seed in seeds {
        if !growth.is_taken[seed] {
            groups.push(growth.group(seed));
        }
    }
    // In the order of the file, so that a face's number tells where it came from.
    groups.sort_unstable();
    groups
}

struct Growth<'a> {
    pieces: &'a [Piece],
    positions: &'a Positions,
    neighbours: Neighbours,
    /// Twice the area vector of each piece.
    newell: Vec<DVec3>,
    planarity: f64,
    corners: &'a Corners<'a>,
    maps: &'a [SurfaceMaps],
    is_taken: Vec<bool>,
}

impl Growth<'_> {
    /// The largest group around `seed` that the plane of the seed, or a refitted one, finds; its members are taken.
    fn group(&mut self, seed: usize) -> Vec<usize> {
        let mut best = vec![seed];
        for _ in 0..=MAX_REFITS {
            let Some(plane) = self.plane(&best).filter(|p| self.fits(seed, p)) else {
                break;
            };
            let members = self.grow(seed, &plane);
            if members.len() <= best.len() {
                break;
            }
            best = members;
        }
        best.iter().for_each(|&i| self.is_taken[i] = true);
        best.sort_unstable();
        best
    }

    fn plane(&self, members: &[usize]) -> Option<Plane> {
        let points = members
            .iter()
            .flat_map(|&i| self.pieces[i].points(self.positions));
        best_plane(members.iter().map(|&i| self.newell[i]).sum(), points).map(|f| f.plane())
    }

    fn fits(&self, piece: usize, plane: &Plane) -> bool {
        self.newell[piece].dot(plane.normal) > 0.0
            && self.pieces[piece]
                .points(self.positions)
                .all(|p| plane.distance(p).abs() <= self.planarity)
    }

    fn shows_the_same(&self, seed: usize, candidate: usize) -> bool {
        let (seed, candidate) = (&self.pieces[seed], &self.pieces[candidate]);
        self.corners
            .continue_each_other(self.maps, seed, candidate, self.positions)
    }

    /// All free pieces that fit the plane and that the seed reaches through others that fit.
    fn grow(&mut self, seed: usize, plane: &Plane) -> Vec<usize> {
        let mut members = vec![seed];
        self.is_taken[seed] = true;
        let mut done = 0;
        while done < members.len() {
            for &candidate in self.neighbours.of(members[done]) {
                if !self.is_taken[candidate]
                    && self.fits(candidate, plane)
                    && self.shows_the_same(seed, candidate)
                {
                    self.is_taken[candidate] = true;
                    members.push(candidate);
                }
            }
            done += 1;
        }
        members.iter().for_each(|&i| self.is_taken[i] = false);
        members
    }
}

/// For each piece, those that may continue it across an edge.
struct Neighbours {
    start: Vec<usize>,
    items: Vec<usize>,
}

/// One piece along an edge.
struct Use {
    ends: [VertexId; 2],
    piece: usize,
    is_forward: bool,
}

impl Neighbours {
    fn new(pieces: &[Piece], are_coplanar: impl Fn(&[Use]) -> bool, newell: &[DVec3]) -> Self {
        let mut uses: Vec<Use> = pieces
            .iter()
            .enumerate()
            .flat_map(|(piece, p)| {
                p.edges().map(move |(a, b)| Use {
                    ends: [a.min(b), a.max(b)],
                    piece,
                    is_forward: a < b,
                })
            })
            .collect();
        uses.sort_unstable_by_key(|u| (u.ends, u.piece, u.is_forward));
        let mut pairs = Vec::new();
        for along in uses.chunk_by(|a, b| a.ends == b.ends) {
            // Where a wall stands, its foot divides the floor; where more sheets lie in one plane, nothing stands.
            if along.len() > 2 && !are_coplanar(along) {
                continue;
            }
            let continues = |a: &Use, b: &Use| {
                let (p, q) = (&pieces[a.piece], &pieces[b.piece]);
                a.piece != b.piece
                    && a.is_forward != b.is_forward
                    && (p.material, p.group) == (q.material, q.group)
                    && newell[a.piece].dot(newell[b.piece]) > 0.0
            };
            // A sheet goes on in one way or not at all: of two overlapping continuations neither is taken.
            let only = |a: &Use| {
                let mut others = along.iter().filter(|b| continues(a, b));
                others.next().filter(|_| others.next().is_none())
            };
            for a in along {
                if let Some(b) = only(a)
                    && only(b).is_some()
                {
                    pairs.push((a.piece, b.piece));
                }
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
