//! Which sides of faces light can reach at all.
//!
//! The inside of a solid, the outside of a room, a face under furniture: no light gets there, so nothing need be
//! solved or refined there. A side is reached when an emitter lights it or when rays from it meet a side that is.

use super::sweep::met;
use crate::scene::{FaceId, FaceSide};
use crate::visibility::{Blockers, Viewpoint};
use rayon::prelude::*;

/// Rays from each viewpoint: an opening that fills less than about this share⁻¹ of every viewpoint's hemisphere may be
/// missed, with the light that comes through it.
const RAYS: u32 = 64;

/// For each entry of `sides`, whether light can reach it; `lit` says which ones the emitters light directly, `views` gives
/// viewpoints on each.
pub fn reached(
    blockers: &Blockers,
    sides: &[(FaceId, FaceSide)],
    views: &[Vec<Viewpoint>],
    lit: &[bool],
) -> Vec<bool> {
    let mut reached = lit.to_vec();
    if reached.iter().all(|&r| r) {
        return reached;
    }
    // What each dark side sees, as indices into `sides`.
    let seen: Vec<Vec<u32>> = views
        .par_iter()
        .zip(lit)
        .map(|(views, &is_lit)| {
            let mut seen = Vec::new();
            if !is_lit {
                for view in views {
                    for (face, side, _) in met(blockers, view, 0..RAYS) {
                        if let Ok(k) = sides.binary_search(&(face, side)) {
                            seen.push(k as u32);
                        }
                    }
                }
                seen.sort_unstable();
                seen.dedup();
            }
            seen
        })
        .collect();
    loop {
        let mut is_done = true;
        for i in 0..sides.len() {
            if !reached[i] && seen[i].iter().any(|&k| reached[k as usize]) {
                reached[i] = true;
                is_done = false;
            }
        }
        if is_done {
            return reached;
        }
    }
}
