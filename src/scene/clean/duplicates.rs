//! Polygons over the same vertices.

use super::piece::Piece;
use crate::scene::{Material, VertexId};

/// Drops every polygon that repeats another one; returns how many.
///
/// Of two that face the same way, an emitter beats a surface, then the first in the file stays. Two that face opposite
/// ways are the sides of a thin sheet where materials are one-sided, or where each emits from its front only; otherwise
/// one of them already stands for both sides.
pub(super) fn drop_duplicates(pieces: &mut Vec<Piece>, materials: &[Material]) -> usize {
    let keys: Vec<Key> = pieces.iter().map(key).collect();
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_unstable_by(|&a, &b| keys[a].corners.cmp(&keys[b].corners).then(a.cmp(&b)));

    let mut is_dropped = vec![false; pieces.len()];
    for same in order.chunk_by(|&a, &b| keys[a].corners == keys[b].corners) {
        if same.len() == 1 {
            continue;
        }
        let mut ranked = same.to_vec();
        ranked.sort_by_key(|&i| !materials[pieces[i].material as usize].is_emitter());
        let mut kept: Vec<usize> = Vec::new();
        for i in ranked {
            let material = &materials[pieces[i].material as usize];
            is_dropped[i] = kept.iter().any(|&k| {
                keys[k].is_forward == keys[i].is_forward
                    || !are_two_sides(&materials[pieces[k].material as usize], material)
            });
            if !is_dropped[i] {
                kept.push(i);
            }
        }
    }
    let before = pieces.len();
    let mut flags = is_dropped.iter();
    pieces.retain(|_| !flags.next().expect("one flag a piece"));
    before - pieces.len()
}

/// Whether two coincident polygons that face opposite ways are both needed.
fn are_two_sides(a: &Material, b: &Material) -> bool {
    let neither_reflects_back = !a.reflects_back && !b.reflects_back;
    let each_emits_forward = a.is_emitter() && b.is_emitter() && !a.emits_back && !b.emits_back;
    neither_reflects_back || each_emits_forward
}

/// Corners from the lowest on, towards its lower neighbour: equal for equal polygons, whichever way they face.
struct Key {
    corners: Vec<VertexId>,
    is_forward: bool,
}

fn key(piece: &Piece) -> Key {
    let n = piece.corners.len();
    let start = (0..n).min_by_key(|&i| piece.corners[i]).unwrap_or(0);
    let forward = |i: usize| piece.corners[(start + i) % n];
    let backward = |i: usize| piece.corners[(start + n - i) % n];
    let is_forward = n < 2 || forward(1) <= backward(1);
    Key {
        corners: (0..n)
            .map(|i| if is_forward { forward(i) } else { backward(i) })
            .collect(),
        is_forward,
    }
}
