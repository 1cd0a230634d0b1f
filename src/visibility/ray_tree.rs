//! A tree of boxes for rays: four boxes a node, all four asked at once.
//!
//! obvhs builds the binary tree (PLOC, Meister & Bittner 2018); pairs of its levels are joined into one (Dammertz, Hanika &
//! Keller, *Shallow bounding volume hierarchies for fast SIMD ray tracing of incoherent rays*, 2008). Boxes stay in f32: to
//! unpack smaller ones takes longer than to fetch these.

use glam::{Vec3A, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use smallvec::SmallVec;
use std::ops::Range;
use std::time::Duration;

/// Children of a node.
const WIDTH: usize = 4;

/// A node takes as long as about so many triangles.
const NODE_COST: f32 = 1.0;

/// So many nodes wait without allocating.
const USUAL_STACK: usize = 96;

/// A child that is a leaf has this bit, its number of items less one in the next three, and its first item in the others.
const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 28;
const FIRST_MASK: u32 = (1 << COUNT_SHIFT) - 1;
const MOST_IN_LEAF: u32 = 8;

/// No component of a direction is nearer to zero: its inverse times any length in the tree stays finite.
const LEAST_COMPONENT: f32 = 1e-30;

/// Boxes of four children, axis by axis, and what they hold.
#[repr(align(64))]
struct Node {
    /// Low and high ends; a child that is not there has none between them.
    ends: [[Vec4; 3]; 2],
    children: [u32; WIDTH],
}

struct Item(Aabb);

impl Boundable for Item {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// A ray in the frame of the boxes.
pub(super) struct TreeRay {
    pub(super) origin: Vec3A,
    /// Of unit length.
    pub(super) direction: Vec3A,
    /// How far along it boxes matter.
    pub(super) end: f32,
}

/// A static tree over axis-aligned boxes.
pub(super) struct RayTree {
    nodes: Vec<Node>,
    /// The items in the order of the leaves, as they were listed.
    pub(super) order: Vec<u32>,
}

impl RayTree {
    /// Builds the tree over `(low, high)` corners, finite.
    pub(super) fn new(boxes: impl Iterator<Item = (Vec3A, Vec3A)>) -> Self {
        let items: Vec<Item> = boxes.map(|(lo, hi)| Item(Aabb::new(lo, hi))).collect();
        let params = BvhBuildParams {
            max_prims_per_leaf: MOST_IN_LEAF,
            collapse_traversal_cost: NODE_COST,
            ..BvhBuildParams::medium_build()
        };
        let binary = build_bvh2(&items, params, &mut Duration::default());
        let mut tree = Self {
            nodes: Vec::new(),
            order: binary.primitive_indices.clone(),
        };
        if !binary.nodes.is_empty() {
            tree.join(&binary);
        }
        tree
    }

    pub(super) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Makes nodes of four of the binary tree.
    fn join(&mut self, binary: &Bvh2) {
        // The binary node that each of ours stands for.
        let mut open = vec![0_u32];
        while let Some(&top) = open.get(self.nodes.len()) {
            let mut held: SmallVec<[u32; WIDTH]> = SmallVec::from_slice(&[top]);
            let node = |i: u32| &binary.nodes[i as usize];
            // The largest is met most often: its children take its place.
            while held.len() < WIDTH {
                let inner = (0..held.len()).filter(|&k| node(held[k]).prim_count == 0);
                let area = |k: usize| node(held[k]).aabb.half_area();
                let Some(k) = inner.max_by(|&a, &b| area(a).total_cmp(&area(b))) else {
                    break;
                };
                let first = node(held[k]).first_index;
                held[k] = first;
                held.push(first + 1);
            }
            let mut joined = Node {
                ends: [
                    [Vec4::splat(f32::INFINITY); 3],
                    [Vec4::splat(f32::NEG_INFINITY); 3],
                ],
                children: [LEAF; WIDTH],
            };
            for (k, &i) in held.iter().enumerate() {
                let [low, high] = [node(i).aabb.min, node(i).aabb.max];
                for axis in 0..3 {
                    joined.ends[0][axis][k] = low[axis];
                    joined.ends[1][axis][k] = high[axis];
                }
                joined.children[k] = match node(i).prim_count {
                    0 => {
                        open.push(i);
                        open.len() as u32 - 1
                    }
                    count => LEAF | (count - 1) << COUNT_SHIFT | node(i).first_index,
                };
            }
            self.nodes.push(joined);
        }
    }

    /// Calls `test` with the places (in the order of the leaves) of the items of every leaf whose box the ray meets, until
    /// that returns true; whether it did.
    pub(super) fn any(&self, ray: &TreeRay, mut test: impl FnMut(Range<usize>) -> bool) -> bool {
        let slabs = Slabs::new(ray);
        let mut stack = SmallVec::<[u32; USUAL_STACK]>::new();
        let mut next = self.root();
        while let Some(child) = next {
            let node = &self.nodes[child as usize];
            let (_, mut met) = slabs.meet(node, ray.end);
            while met != 0 {
                let child = node.children[met.trailing_zeros() as usize];
                met &= met - 1;
                if child & LEAF == 0 {
                    stack.push(child);
                } else if test(places(child)) {
                    return true;
                }
            }
            next = stack.pop();
        }
        false
    }

    /// Calls `test` as [`RayTree::any`] does, the nearest boxes first; it returns how far along the ray boxes still matter.
    pub(super) fn nearest(&self, ray: &TreeRay, mut test: impl FnMut(Range<usize>) -> f32) {
        let slabs = Slabs::new(ray);
        let mut end = ray.end;
        let mut stack = SmallVec::<[(u32, f32); USUAL_STACK]>::new();
        let mut next = self.root().map(|root| (root, 0.0));
        while let Some((child, begin)) = next {
            if begin > end {
            } else if child & LEAF != 0 {
                end = end.min(test(places(child)));
            } else {
                let node = &self.nodes[child as usize];
                let (near, mut met) = slabs.meet(node, end);
                let first = stack.len();
                while met != 0 {
                    let k = met.trailing_zeros() as usize;
                    met &= met - 1;
                    stack.push((node.children[k], near[k]));
                }
                stack[first..].sort_unstable_by(|a, b| b.1.total_cmp(&a.1));
            }
            next = stack.pop();
        }
    }

    fn root(&self) -> Option<u32> {
        (!self.nodes.is_empty()).then_some(0)
    }
}

/// The places of the items of a leaf.
fn places(leaf: u32) -> Range<usize> {
    let first = (leaf & FIRST_MASK) as usize;
    first..first + ((leaf & !LEAF) >> COUNT_SHIFT) as usize + 1
}

/// What a ray brings along for the boxes of all nodes (Kay & Kajiya 1986).
struct Slabs {
    origin: [Vec4; 3],
    inverse: [Vec4; 3],
    /// Whether it runs backwards, axis by axis: then it enters at the high end.
    is_backward: [usize; 3],
}

impl Slabs {
    fn new(ray: &TreeRay) -> Self {
        let inverse = |d: f32| Vec4::splat(1.0 / d.abs().max(LEAST_COMPONENT).copysign(d));
        Self {
            origin: ray.origin.to_array().map(Vec4::splat),
            inverse: ray.direction.to_array().map(inverse),
            is_backward: ray
                .direction
                .to_array()
                .map(|d| usize::from(d.is_sign_negative())),
        }
    }

    /// Where the ray enters each of the boxes of `node`, and a bit for each that it meets before `end`.
    #[inline]
    fn meet(&self, node: &Node, end: f32) -> ([f32; WIDTH], u32) {
        let at = |ends: Vec4, axis: usize| (ends - self.origin[axis]) * self.inverse[axis];
        let enters = [0, 1, 2].map(|i| at(node.ends[self.is_backward[i]][i], i));
        let leaves = [0, 1, 2].map(|i| at(node.ends[1 - self.is_backward[i]][i], i));
        let near = enters[0].max(enters[1]).max(enters[2].max(Vec4::ZERO));
        let far = leaves[0]
            .min(leaves[1])
            .min(leaves[2].min(Vec4::splat(end)));
        (near.to_array(), near.cmple(far).bitmask())
    }
}
