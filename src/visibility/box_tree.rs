//! A tree of boxes that answers "which items may meet this region?" for any convex region.
//!
//! The tree is obvhs's binary BVH (PLOC, Meister & Bittner 18); its boxes are float32 and padded, so an answer may hold
//! too many items, never too few.

use super::Region;
use glam::{DVec3, Vec3A};
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb, bvh2::Bvh2, bvh2::builder::build_bvh2};
use std::time::Duration;

/// Boxes are padded by this share of their largest coordinate: eight roundings to float32.
const PADDING: f32 = 8.0 * f32::EPSILON;

struct Item(Aabb);

impl Boundable for Item {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// A static tree over axis-aligned boxes.
pub struct BoxTree {
    bvh: Bvh2,
}

impl BoxTree {
    /// Builds the tree; item `i` is the box `(min, max)` number `i`.
    pub fn new(boxes: impl Iterator<Item = (DVec3, DVec3)>) -> Self {
        let items: Vec<Item> = boxes
            .map(|(lo, hi)| {
                let (lo, hi): (Vec3A, Vec3A) = (lo.as_vec3a(), hi.as_vec3a());
                let pad = Vec3A::splat(PADDING * lo.abs().max(hi.abs()).max_element());
                Item(Aabb::new(lo - pad, hi + pad))
            })
            .collect();
        Self {
            bvh: build_bvh2(
                &items,
                BvhBuildParams::medium_build(),
                &mut Duration::default(),
            ),
        }
    }

    /// Calls `visit` with every item whose box meets `region` (and with some whose box does not).
    pub fn query(&self, region: &Region, mut visit: impl FnMut(u32)) {
        self.query_while(region, |i| {
            visit(i);
            true
        });
    }

    /// As [`Self::query`], until `visit` returns false.
    pub fn query_while(&self, region: &Region, mut visit: impl FnMut(u32) -> bool) {
        if self.bvh.nodes.is_empty() {
            return;
        }
        let mut stack = smallvec::SmallVec::<[u32; 64]>::new();
        stack.push(0);
        while let Some(index) = stack.pop() {
            let node = &self.bvh.nodes[index as usize];
            let (lo, hi) = (node.aabb.min.as_dvec3(), node.aabb.max.as_dvec3());
            if !region.may_meet_box(lo, hi) {
                continue;
            }
            if node.prim_count == 0 {
                stack.push(node.first_index);
                stack.push(node.first_index + 1);
            } else {
                for i in node.first_index..node.first_index + node.prim_count {
                    if !visit(self.bvh.primitive_indices[i as usize]) {
                        return;
                    }
                }
            }
        }
    }
}
