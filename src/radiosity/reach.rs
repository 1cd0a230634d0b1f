//! Which sides of faces light can reach at all.
//!
//! The inside of a solid, the outside of a room, a face under furniture: no light gets there, so nothing need be
//! solved or refined there. A side is reached when an emitter lights it or when rays from it meet a side that is.

use crate::scene::{FaceId, FaceSide};
use crate::visibility::{Blockers, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Rays from each viewpoint: an opening that fills less than about this share⁻¹ of every viewpoint's hemisphere may be
/// missed, with the light that comes through it.
const RAYS: u32 = 64;

/// Fractional parts of the generalised golden ratio's powers (Roberts 2018): a sequence that fills the square evenly.
const R2: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

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
    let seen: Vec<Vec<u32>> = sides
        .par_iter()
        .zip(views)
        .zip(lit)
        .map(|((&(face, _), views), &is_lit)| {
            let mut seen = Vec::new();
            if !is_lit {
                for view in views {
                    for i in 0..RAYS {
                        let hit = blockers.rays().nearest_where(
                            view.position,
                            direction(view.horizon.normal, i),
                            0.0,
                            f64::INFINITY,
                            |h| blockers.ray_owner(h.triangle) != face,
                        );
                        if let Some(h) = hit {
                            let side = if h.is_front {
                                FaceSide::Front
                            } else {
                                FaceSide::Back
                            };
                            let key = (blockers.ray_owner(h.triangle), side);
                            if let Ok(k) = sides.binary_search(&key) {
                                seen.push(k as u32);
                            }
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

/// Point `i` of a sequence that fills the unit square evenly.
pub(super) fn even_point(i: u32) -> [f64; 2] {
    R2.map(|r| (0.5 + r * f64::from(i + 1)).fract())
}

/// Direction `i` of a cosine-distributed set over the hemisphere about `n`.
pub(super) fn direction(n: DVec3, i: u32) -> DVec3 {
    let [a, b] = even_point(i);
    let (sin, cos) = (TAU * b).sin_cos();
    let u = n.any_orthonormal_vector();
    let v = n.cross(u);
    (u * cos + v * sin) * a.sqrt() + n * (1.0 - a).sqrt()
}
