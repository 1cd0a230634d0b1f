//! The border of a set of coplanar polygons, as simple loops.

use super::piece::{Piece, Positions};
use crate::geom::predicates::{Side, side_of_line};
use crate::geom::{PlaneFrame, Polygon2, loop_area};
use crate::scene::VertexId;
use glam::DVec2;
use std::cmp::Ordering;
use std::collections::HashMap;

/// The loops of one face: its outline, then its holes.
pub(super) type Loops = Vec<Vec<VertexId>>;

/// The faces that `pieces` make together: edges between two of them vanish, what is left is traced into loops.
///
/// `None` when the pieces overlap, so that no loops border them.
pub(super) fn trace(
    pieces: &[&Piece],
    frame: &PlaneFrame,
    positions: &Positions,
) -> Option<Vec<Loops>> {
    if let [piece] = pieces
        && has_distinct_corners(&piece.corners)
    {
        return Some(vec![vec![piece.corners.clone()]]);
    }
    let plane = |v: VertexId| frame.to_plane(positions[v]);
    let border = border(pieces)?;
    let loops = walk(&border, &plane)?
        .into_iter()
        .flat_map(split_at_pinches);
    let (mut outer, mut holes) = (Vec::new(), Vec::new());
    for l in loops {
        let points: Vec<DVec2> = l.iter().map(|&v| plane(v)).collect();
        let area = loop_area(&points);
        if l.len() < 3 || area == 0.0 {
            return None;
        }
        if area > 0.0 {
            outer.push((l, points));
        } else {
            holes.push((l, points));
        }
    }
    nest(outer, holes)
}

fn has_distinct_corners(corners: &[VertexId]) -> bool {
    let mut sorted = corners.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).all(|w| w[0] != w[1])
}

type DirectedEdge = (VertexId, VertexId);

/// Directed edges, sorted, that no opposite one cancels; the inside lies to their left.
fn border(pieces: &[&Piece]) -> Option<Vec<DirectedEdge>> {
    let mut edges: Vec<(VertexId, VertexId, bool)> = pieces
        .iter()
        .flat_map(|p| p.edges())
        .map(|(a, b)| (a.min(b), a.max(b), a < b))
        .collect();
    edges.sort_unstable();
    let mut border = Vec::new();
    for uses in edges.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)) {
        let forward = uses.iter().filter(|e| e.2).count();
        let (a, b, _) = uses[0];
        match (forward, uses.len() - forward) {
            (f, g) if f == g => {}
            (f, g) if f == g + 1 => border.push((a, b)),
            (f, g) if f + 1 == g => border.push((b, a)),
            _ => return None,
        }
    }
    border.sort_unstable();
    Some(border)
}

/// Closed walks over all border edges.
///
/// Where several edges leave a vertex, the walk takes the first one clockwise from where it came: that one borders the
/// same piece of the inside.
///
/// ```text
///        inside  ↗ next
///   from ─────▶ v ─ ─ other walks' edges
///               ↘
/// ```
fn walk(border: &[DirectedEdge], plane: &impl Fn(VertexId) -> DVec2) -> Option<Vec<Vec<VertexId>>> {
    let mut is_walked = vec![false; border.len()];
    let mut loops = Vec::new();
    for start in 0..border.len() {
        if is_walked[start] {
            continue;
        }
        let mut vertices = vec![border[start].0];
        let mut edge = start;
        loop {
            let (from, at) = border[edge];
            let first = border.partition_point(|e| e.0 < at);
            let next = (first..border.len())
                .take_while(|&i| border[i].0 == at)
                .filter(|&i| !is_walked[i])
                .max_by(|&i, &j| {
                    let [o, r, p, q] = [at, from, border[i].1, border[j].1].map(plane);
                    counter_clockwise(o, r, p, q)
                })?;
            is_walked[next] = true;
            if next == start {
                break;
            }
            vertices.push(at);
            edge = next;
        }
        loops.push(vertices);
    }
    Some(loops)
}

/// Orders `p` and `q` by the angle through which the ray `o → r` turns counter-clockwise to meet them.
fn counter_clockwise(o: DVec2, r: DVec2, p: DVec2, q: DVec2) -> Ordering {
    let half = |x: DVec2| match side_of_line(o, r, x) {
        Side::On if (x - o).dot(r - o) > 0.0 => 0,
        Side::Left => 1,
        Side::On => 2,
        Side::Right => 3,
    };
    half(p)
        .cmp(&half(q))
        .then_with(|| match side_of_line(o, p, q) {
            Side::Left => Ordering::Less,
            Side::On => Ordering::Equal,
            Side::Right => Ordering::Greater,
        })
}

/// Cuts a walk that meets itself at vertices into loops that do not.
fn split_at_pinches(walk: Vec<VertexId>) -> Vec<Vec<VertexId>> {
    if has_distinct_corners(&walk) {
        return vec![walk];
    }
    let mut loops = Vec::new();
    let mut open: Vec<VertexId> = Vec::new();
    let mut place: HashMap<VertexId, usize> = HashMap::new();
    for v in walk {
        if let Some(&at) = place.get(&v) {
            for w in &open[at + 1..] {
                place.remove(w);
            }
            loops.push(open[at..].to_vec());
            open.truncate(at + 1);
        } else {
            place.insert(v, open.len());
            open.push(v);
        }
    }
    loops.push(open);
    loops
}

type PlacedLoop = (Vec<VertexId>, Vec<DVec2>);

/// Gives each hole to the smallest outline around it.
fn nest(outer: Vec<PlacedLoop>, holes: Vec<PlacedLoop>) -> Option<Vec<Loops>> {
    if let [_] = outer.as_slice() {
        let all = outer.into_iter().chain(holes).map(|(l, _)| l).collect();
        return Some(vec![all]);
    }
    let outlines: Vec<Polygon2> = outer
        .iter()
        .map(|(_, points)| Polygon2 {
            loops: vec![points.clone()],
        })
        .collect();
    let mut faces: Vec<Loops> = outer.iter().map(|(l, _)| vec![l.clone()]).collect();
    for (hole, points) in holes {
        let owner = (0..outer.len())
            .filter(|&i| {
                // Corners shared with the outline lie on it: ask one that is not, or else the middle of an edge.
                let free = (0..hole.len()).find(|&k| !outer[i].0.contains(&hole[k]));
                let probe = free.map_or_else(|| points[0].midpoint(points[1]), |k| points[k]);
                outlines[i].contains(probe)
            })
            .min_by(|&i, &j| outlines[i].area().total_cmp(&outlines[j].area()))?;
        faces[owner].push(hole);
    }
    Some(faces)
}
