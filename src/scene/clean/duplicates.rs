//! Polygons, and faces, over the same vertices.

use super::piece::Piece;
use crate::scene::{Face, Material, VertexId};

/// Drops every polygon that repeats another one; returns how many.
///
/// Of two that face the same way, an emitter beats a surface, then the first in the file stays. Two that face opposite
/// ways are the sides of a thin sheet where materials are one-sided, or where each emits from its front only; otherwise
/// one of them already stands for both sides.
pub(super) fn drop_duplicates(pieces: &mut Vec<Piece>, materials: &[Material]) -> usize {
    let keys: Vec<Key> = pieces
        .iter()
        .map(|p| Key::new([p.corners.as_slice()].into_iter(), p.material))
        .collect();
    retain_first(pieces, &keys, materials)
}

/// Does the same for faces: doubled surfaces can differ in their triangles and still have the same outline.
pub(super) fn drop_duplicate_faces(faces: &mut Vec<Face>, materials: &[Material]) -> usize {
    let keys: Vec<Key> = faces
        .iter()
        .map(|f| Key::new(f.loops.iter().map(Vec::as_slice), f.material))
        .collect();
    retain_first(faces, &keys, materials)
}

fn retain_first<T>(items: &mut Vec<T>, keys: &[Key], materials: &[Material]) -> usize {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_unstable_by(|&a, &b| keys[a].loops.cmp(&keys[b].loops).then(a.cmp(&b)));
    let material_of = |i: usize| &materials[keys[i].material as usize];

    let mut is_dropped = vec![false; keys.len()];
    for same in order.chunk_by(|&a, &b| keys[a].loops == keys[b].loops) {
        if same.len() == 1 {
            continue;
        }
        let mut ranked = same.to_vec();
        ranked.sort_by_key(|&i| !material_of(i).is_emitter());
        let mut kept: Vec<usize> = Vec::new();
        for i in ranked {
            is_dropped[i] = kept.iter().any(|&k| {
                keys[k].is_forward == keys[i].is_forward
                    || !are_two_sides(material_of(k), material_of(i))
            });
            if !is_dropped[i] {
                kept.push(i);
            }
        }
    }
    let before = items.len();
    let mut flags = is_dropped.iter();
    items.retain(|_| !flags.next().expect("one flag an item"));
    before - items.len()
}

/// Whether two coincident polygons that face opposite ways are both needed.
fn are_two_sides(a: &Material, b: &Material) -> bool {
    let neither_reflects_back = !a.reflects_back && !b.reflects_back;
    let each_emits_forward = a.is_emitter() && b.is_emitter() && !a.emits_back && !b.emits_back;
    neither_reflects_back || each_emits_forward
}

/// Loops in an order and direction that are equal for equal outlines, whichever way they face.
struct Key {
    loops: Vec<Vec<VertexId>>,
    /// Whether the first loop had this direction.
    is_forward: bool,
    material: u32,
}

impl Key {
    fn new<'a>(loops: impl Iterator<Item = &'a [VertexId]>, material: u32) -> Self {
        let (mut loops, directions): (Vec<_>, Vec<_>) = loops.map(canonical).unzip();
        let is_forward = directions.first().copied().unwrap_or(true);
        loops.sort_unstable();
        Self {
            loops,
            is_forward,
            material,
        }
    }
}

/// The corners from the lowest on, towards its lower neighbour, and whether that is the direction given.
fn canonical(corners: &[VertexId]) -> (Vec<VertexId>, bool) {
    let n = corners.len();
    let start = (0..n).min_by_key(|&i| corners[i]).unwrap_or(0);
    let forward = |i: usize| corners[(start + i) % n];
    let backward = |i: usize| corners[(start + n - i) % n];
    let is_forward = n < 2 || forward(1) <= backward(1);
    let turned = (0..n)
        .map(|i| if is_forward { forward(i) } else { backward(i) })
        .collect();
    (turned, is_forward)
}
