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
    let seen: Vec<Seen> = views
        .par_iter()
        .zip(lit)
        .map(|(views, &is_lit)| match is_lit {
            true => Seen::Light,
            false => look(blockers, sides, views, lit),
        })
        .collect();
    for (reached, seen) in reached.iter_mut().zip(&seen) {
        *reached |= matches!(seen, Seen::Light);
    }
    loop {
        let mut is_done = true;
        for i in 0..sides.len() {
            if let Seen::Dark(seen) = &seen[i]
                && !reached[i]
                && seen.iter().any(|&k| reached[k as usize])
            {
                reached[i] = true;
                is_done = false;
            }
        }
        if is_done {
            return reached;
        }
    }
}

/// What a side sees.
enum Seen {
    /// A lit side.
    Light,
    /// Nothing but these dark sides, their indices.
    Dark(Vec<u32>),
}

fn look(
    blockers: &Blockers,
    sides: &[(FaceId, FaceSide)],
    views: &[Viewpoint],
    lit: &[bool],
) -> Seen {
    let mut dark = Vec::new();
    for view in views {
        for (face, side, _) in met(blockers, view, 0..RAYS) {
            match sides.binary_search(&(face, side)) {
                Ok(k) if lit[k] => return Seen::Light,
                Ok(k) => dark.push(k as u32),
                Err(_) => {}
            }
        }
    }
    dark.sort_unstable();
    dark.dedup();
    Seen::Dark(dark)
}
