//! Vertices in the middle of a straight edge that no other face needs vanish.
//!
//! Every edge casts its own critical lines, so a wall's edge in five pieces costs five times the work of one.

use super::face::{Look, face};
use super::piece::Positions;
use super::point_tree::PointTree;
use crate::scene::{Face, VertexId};
use glam::DVec3;
use rayon::prelude::*;

/// Removes such vertices from the loops of all faces; returns how many.
///
/// A vertex is *plain* when the same faces run along both its edges and no other edge meets it. Chains of plain vertices
/// are thinned so that each removed one stays within `edge_distance` of the edge that replaces it (D. Douglas, T. Peucker,
/// *Algorithms for the reduction of the number of points*, 1973). A chain stays as it is where the new edge would meet
/// another vertex or coincide with another edge.
pub(super) fn straighten(faces: &mut [Face], positions: &Positions, edge_distance: f64) -> usize {
    let mut is_pinned = vec![false; positions.len()];
    loop {
        let is_removed = removable(faces, positions, edge_distance, &is_pinned);
        let rebuilt: Vec<(usize, Option<Face>)> = faces
            .par_iter()
            .enumerate()
            .filter(|(_, f)| vertices_of(f).any(|v| is_removed[v.0 as usize]))
            .map(|(i, f)| (i, thinned(f, &is_removed, positions)))
            .collect();
        // A face that has no outline without them keeps its vertices, and so do its neighbours then.
        let mut has_failed = false;
        for (i, _) in rebuilt.iter().filter(|(_, face)| face.is_none()) {
            has_failed = true;
            vertices_of(&faces[*i]).for_each(|v| is_pinned[v.0 as usize] = true);
        }
        if has_failed {
            continue;
        }
        for (i, face) in rebuilt {
            faces[i] = face.expect("failures were tried again");
        }
        return is_removed.iter().filter(|&&r| r).count();
    }
}

fn vertices_of(face: &Face) -> impl Iterator<Item = VertexId> + '_ {
    face.loops.iter().flatten().copied()
}

fn thinned(old: &Face, is_removed: &[bool], positions: &Positions) -> Option<Face> {
    let mut loops = old.loops.clone();
    for l in &mut loops {
        l.retain(|v| !is_removed[v.0 as usize]);
        if l.len() < 3 {
            return None;
        }
    }
    face(loops, Look::of(old), positions)
}

/// An edge with the faces along it.
struct Link {
    ends: [VertexId; 2],
    faces: Vec<usize>,
}

/// Which vertices can go.
fn removable(
    faces: &[Face],
    positions: &Positions,
    edge_distance: f64,
    is_pinned: &[bool],
) -> Vec<bool> {
    let links = links(faces);
    let around = links_around(&links, positions.len());
    let is_plain: Vec<bool> = around
        .iter()
        .zip(is_pinned)
        .map(|(around, &is_pinned)| match around.as_slice() {
            &[a, b] => !is_pinned && links[a].faces == links[b].faces,
            _ => false,
        })
        .collect();
    let mut is_removed = vec![false; positions.len()];
    let mut new_edges = Vec::new();
    for mut chain in chains(&links, &around, &is_plain) {
        if is_plain[chain[0].0 as usize] {
            start_ring_at_corner(&mut chain, positions);
        }
        for span in spans(&chain, positions, edge_distance) {
            let inner = &span[1..span.len() - 1];
            inner.iter().for_each(|v| is_removed[v.0 as usize] = true);
            if !inner.is_empty() {
                let (a, b) = (span[0], span[span.len() - 1]);
                new_edges.push(NewEdge {
                    ends: [a.min(b), a.max(b)],
                    inner: inner.to_vec(),
                });
            }
        }
    }
    keep_where_in_conflict(&links, new_edges, positions, edge_distance, &mut is_removed);
    is_removed
}

fn links(faces: &[Face]) -> Vec<Link> {
    let mut uses: Vec<([VertexId; 2], usize)> = Vec::new();
    for (i, face) in faces.iter().enumerate() {
        for l in &face.loops {
            let next = l.iter().cycle().skip(1);
            uses.extend(l.iter().zip(next).map(|(&a, &b)| ([a.min(b), a.max(b)], i)));
        }
    }
    uses.sort_unstable();
    uses.chunk_by(|a, b| a.0 == b.0)
        .map(|along| Link {
            ends: along[0].0,
            faces: along.iter().map(|u| u.1).collect(),
        })
        .collect()
}

fn links_around(links: &[Link], vertices: usize) -> Vec<Vec<usize>> {
    let mut around = vec![Vec::new(); vertices];
    for (i, link) in links.iter().enumerate() {
        for end in link.ends {
            around[end.0 as usize].push(i);
        }
    }
    around
}

/// Paths over plain vertices between two that are not; a ring of plain vertices only starts and ends at the same one.
fn chains(links: &[Link], around: &[Vec<usize>], is_plain: &[bool]) -> Vec<Vec<VertexId>> {
    let mut is_walked = vec![false; links.len()];
    let mut walk = |start: VertexId, first: usize| {
        let mut chain = vec![start];
        let (mut at, mut link) = (start, first);
        while !is_walked[link] {
            is_walked[link] = true;
            let [a, b] = links[link].ends;
            at = if a == at { b } else { a };
            chain.push(at);
            if !is_plain[at.0 as usize] {
                break;
            }
            let ways = &around[at.0 as usize];
            link = if ways[0] == link { ways[1] } else { ways[0] };
        }
        chain
    };
    let mut chains = Vec::new();
    for wanted in [false, true] {
        for (v, ways) in around.iter().enumerate() {
            if is_plain[v] == wanted {
                chains.extend(ways.iter().map(|&link| walk(VertexId::from(v), link)));
            }
        }
    }
    chains.retain(|c| c.len() > 2);
    chains
}

/// Turns a ring of plain vertices so that it starts and ends at the one farthest from its first: that one is a corner,
/// while the first may lie in the middle of a straight edge.
fn start_ring_at_corner(ring: &mut Vec<VertexId>, positions: &Positions) {
    let first = positions[ring[0]];
    let distance = |i: usize| positions[ring[i]].distance_squared(first);
    let corner = (0..ring.len()).max_by(|&i, &j| distance(i).total_cmp(&distance(j)));
    ring.pop();
    ring.rotate_left(corner.unwrap_or(0));
    ring.push(ring[0]);
}

/// Cuts a chain into spans whose inner vertices lie within `edge_distance` of the line between the span's ends.
fn spans<'a>(
    chain: &'a [VertexId],
    positions: &Positions,
    edge_distance: f64,
) -> Vec<&'a [VertexId]> {
    // The ends of a ring coincide: the distance is then that from the point, and a ring is always cut.
    let farthest = |start: usize, end: usize| {
        let (a, b) = (positions[chain[start]], positions[chain[end]]);
        (start + 1..end)
            .map(|i| (i, distance_to_segment(a, b, positions[chain[i]])))
            .max_by(|(i, d), (j, e)| d.total_cmp(e).then(chain[*j].cmp(&chain[*i])))
            .filter(|&(_, d)| d > edge_distance)
    };
    // Indices of both ends of each span, in order.
    let mut done: Vec<(usize, usize)> = Vec::new();
    let mut open = vec![(0, chain.len() - 1)];
    while let Some((start, end)) = open.pop() {
        if let Some((i, _)) = farthest(start, end) {
            open.push((i, end));
            open.push((start, i));
            continue;
        }
        // On a line parallel to the one between the ends all vertices are farthest: a cut in its middle heals here.
        match done.last_mut() {
            Some(last) if farthest(last.0, end).is_none() => last.1 = end,
            _ => done.push((start, end)),
        }
    }
    done.into_iter()
        .map(|(start, end)| &chain[start..=end])
        .collect()
}

/// An edge that replaces a chain.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct NewEdge {
    ends: [VertexId; 2],
    inner: Vec<VertexId>,
}

/// Puts back the vertices of new edges that come too close to another vertex or that another edge coincides with.
fn keep_where_in_conflict(
    links: &[Link],
    mut new_edges: Vec<NewEdge>,
    positions: &Positions,
    edge_distance: f64,
    is_removed: &mut [bool],
) {
    new_edges.sort_unstable();
    let mut is_used = vec![false; positions.len()];
    for end in links.iter().flat_map(|link| link.ends) {
        is_used[end.0 as usize] = true;
    }
    // What is put back may be in the way of another new edge: again, until nothing is.
    loop {
        let staying: Vec<VertexId> = positions
            .iter()
            .map(|(v, _)| v)
            .filter(|v| is_used[v.0 as usize] && !is_removed[v.0 as usize])
            .collect();
        let tree = PointTree::new(positions, staying);
        let is_twin = |i: Option<usize>, ends: [VertexId; 2]| {
            i.and_then(|i| new_edges.get(i))
                .is_some_and(|e| e.ends == ends)
        };
        let is_conflict: Vec<bool> = new_edges
            .par_iter()
            .enumerate()
            .map(|(i, &NewEdge { ends, .. })| {
                let [a, b] = ends.map(|v| positions[v]);
                let mut meets_vertex = false;
                tree.near_segment(a, b, edge_distance, &mut |v| {
                    meets_vertex |= !ends.contains(&v)
                        && distance_to_segment(a, b, positions[v]) <= edge_distance;
                });
                meets_vertex
                    || is_twin(i.checked_sub(1), ends)
                    || is_twin(Some(i + 1), ends)
                    || links.binary_search_by_key(&ends, |link| link.ends).is_ok()
            })
            .collect();
        if !is_conflict.contains(&true) {
            return;
        }
        let mut flags = is_conflict.into_iter();
        new_edges.retain(|edge| {
            let is_conflict = flags.next().expect("one flag an edge");
            if is_conflict {
                for v in &edge.inner {
                    is_removed[v.0 as usize] = false;
                }
            }
            !is_conflict
        });
    }
}

/// Distance of `p` from the segment `a b`, whose ends may coincide.
fn distance_to_segment(a: DVec3, b: DVec3, p: DVec3) -> f64 {
    let (p, d) = (p - a, b - a);
    let t = (p.dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (p - d * t).length()
}
