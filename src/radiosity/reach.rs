//! Which sides of faces light can reach at all.
//!
//! The inside of a solid, the outside of a room, a face under furniture: no light gets there, so nothing need be
//! solved or refined there. A side is reached when an emitter lights it or when rays from it meet a side that is.

use super::sweep::met;
use crate::scene::{FaceId, FaceSide};
use crate::visibility::{Blockers, Viewpoint};
use rayon::prelude::*;
use std::ops::Range;

/// Rays from each viewpoint at last: an opening that fills less than about this share⁻¹ of every viewpoint's hemisphere may be
/// missed, with the light that comes through it. Most sides need few: of what is still dark after some, what sees a side that is
/// not is done.
const RAYS: [u32; 3] = [4, 16, 64];

/// For each entry of `sides`, whether light can reach it; `lit` says which ones the emitters light directly, `views` gives
/// viewpoints on each.
pub fn reached(
    blockers: &Blockers,
    sides: &[(FaceId, FaceSide)],
    views: &[Vec<Viewpoint>],
    lit: &[bool],
) -> Vec<bool> {
    let mut reached = lit.to_vec();
    // The sides that those still in the dark see.
    let mut seen: Vec<Vec<u32>> = vec![Vec::new(); sides.len()];
    let mut first = 0;
    for last in RAYS {
        let known = &reached;
        seen.par_iter_mut().enumerate().for_each(|(i, seen)| {
            if !known[i] {
                look(blockers, sides, &views[i], first..last, known, seen);
            }
        });
        spread(&seen, &mut reached);
        first = last;
    }
    reached
}

/// Adds what some of the rays from the viewpoints meet, until that is a side known to be reached.
fn look(
    blockers: &Blockers,
    sides: &[(FaceId, FaceSide)],
    views: &[Viewpoint],
    rays: Range<u32>,
    reached: &[bool],
    seen: &mut Vec<u32>,
) {
    for view in views {
        for (face, side, _) in met(blockers, view, rays.clone()) {
            if let Ok(k) = sides.binary_search(&(face, side)) {
                seen.push(k as u32);
                if reached[k] {
                    return;
                }
            }
        }
    }
    seen.sort_unstable();
    seen.dedup();
}

/// Reaches all that see a side that is reached.
fn spread(seen: &[Vec<u32>], reached: &mut [bool]) {
    let mut is_done = false;
    while !is_done {
        is_done = true;
        for (i, seen) in seen.iter().enumerate() {
            if !reached[i] && seen.iter().any(|&k| reached[k as usize]) {
                reached[i] = true;
                is_done = false;
            }
        }
    }
}
