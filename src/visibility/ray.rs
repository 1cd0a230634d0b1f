//! The shared ray caster: nearest hit and occlusion against a list of triangles, without leaks along shared edges.
//!
//! Boxes are culled in f32 (obvhs, eight-wide compressed tree), triangles are decided in f64 by the test of Woop, Benthin and
//! Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013). Their fall-back to higher precision where an edge function is
//! zero is not needed: two triangles that share an edge compute exactly opposite values for it, and zero belongs to both.

use glam::{DVec3, Vec3A};
use obvhs::Boundable;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};
use std::time::Duration;

/// How far boxes reach beyond their triangles, as a fraction of the diagonal of the whole.
///
/// The box test rounds to f32 (6e-8 of the diagonal for each of origin, direction and box) and clamps direction components
/// below 1.2e-7, while the triangle test is exact to f64. On tight boxes 2 to 3 rays in 10 000 that are aimed at an edge or
/// a vertex slip through; at 1e-5 none of two million does.
const BOX_PADDING: f64 = 1e-5;

/// How far behind its origin a ray enters the tree, as a fraction of the diagonal of the whole.
///
/// The tree drops every box that ends within 1e-4 of the ray's start (a constant inside it), which would let light through
/// an occluder that almost touches the receiver. Twice that distance keeps such boxes; what lies behind the origin is
/// rejected by its `t` like any other hit.
const RUN_UP: f64 = 2e-4;

/// From the unit sphere no ray passes more than two units of boxes; a finite end keeps f32 arithmetic free of infinities.
const BEYOND_ALL_BOXES: f64 = 4.0;

/// A point where a ray meets a triangle: `(1 − u − v) A + u B + v C`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the ray's direction: the point is `origin + t · dir`.
    pub t: f64,
    /// Index into the list that the caster was built from.
    pub triangle: u32,
    /// Weight of the second corner, 0…1.
    pub u: f64,
    /// Weight of the third corner, 0…1.
    pub v: f64,
    /// Whether the ray sees the corners run counter-clockwise.
    pub is_front: bool,
}

/// Triangles ready for rays. Answers depend on the triangles alone, not on the order in which boxes are visited.
pub struct RayCaster {
    bvh: CwBvh,
    /// In the order of the tree's leaves; `bvh.primitive_indices` leads back to the caller's order.
    triangles: Vec<[DVec3; 3]>,
    /// The frame of the boxes: `(p − centre) / diagonal`, so that absolute thresholds of the tree never see the scene's scale.
    centre: DVec3,
    diagonal: f64,
}

/// A ray in the frame of the boxes.
struct BoxRay {
    ray: Ray,
    /// Box units by which the start was moved along the ray; negative when it was moved back.
    skipped: f64,
    /// Box units for each unit of the caller's `t`.
    per_t: f64,
}

struct PaddedBox(Aabb);

impl Boundable for PaddedBox {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl RayCaster {
    /// Prepares `triangles` (any order, metres). Corners must be finite; triangles without area are never hit.
    pub fn new(triangles: &[[DVec3; 3]]) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &p in triangles.iter().flatten() {
            (low, high) = (low.min(p), high.max(p));
        }
        let is_extended = low.cmplt(high).any();
        let diagonal = if is_extended { low.distance(high) } else { 1.0 };
        let centre = if triangles.is_empty() {
            DVec3::ZERO
        } else {
            low.midpoint(high)
        };

        let padding = DVec3::splat(BOX_PADDING);
        let boxes: Vec<PaddedBox> = triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|p| (p - centre) / diagonal);
                PaddedBox(Aabb {
                    min: (a.min(b).min(c) - padding).as_vec3a(),
                    max: (a.max(b).max(c) + padding).as_vec3a(),
                })
            })
            .collect();
        let bvh = build_cwbvh(
            &boxes,
            BvhBuildParams::medium_build(),
            &mut Duration::default(),
        );
        let triangles = bvh
            .primitive_indices
            .iter()
            .map(|&i| triangles[i as usize])
            .collect();
        Self {
            bvh,
            triangles,
            centre,
            diagonal,
        }
    }

    /// The nearest hit with `t_min < t < t_max`, or none; of hits at the same `t`, the triangle that was listed first.
    ///
    /// `t` counts in lengths of `dir`, which need not be a unit vector; `t_min` is at least 0. Both sides of a triangle count.
    pub fn nearest(&self, origin: DVec3, dir: DVec3, t_min: f64, t_max: f64) -> Option<Hit> {
        self.nearest_where(origin, dir, t_min, t_max, |_| true)
    }

    /// As [`Self::nearest`], among the hits that `accept` lets through.
    ///
    /// The way to see only fronts: a second ray started behind a rejected hit would miss a triangle in the same place.
    pub fn nearest_where(
        &self,
        origin: DVec3,
        dir: DVec3,
        t_min: f64,
        t_max: f64,
        accept: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let box_ray = self.box_ray(origin, dir, t_max)?;
        let woop = WoopRay::new(origin, dir);
        let mut best: Option<Hit> = None;
        let test = |_: &Ray, leaf: usize| {
            let found = woop
                .hit(&self.triangles[leaf], self.bvh.primitive_indices[leaf])
                .filter(|hit| hit.t > t_min && hit.t < t_max && accept(hit));
            let Some(hit) = found else {
                return f32::INFINITY;
            };
            if best.is_none_or(|b| (hit.t, hit.triangle) < (b.t, b.triangle)) {
                best = Some(hit);
            }
            box_ray.cull_behind(hit.t)
        };
        self.bvh
            .ray_traverse(box_ray.ray, &mut RayHit::none(), test);
        best
    }

    /// True when a triangle that is not skipped meets `a + t (b − a)` somewhere in `t_min < t < t_max`.
    ///
    /// `t_min` and `t_max` are fractions of the way, usually 0 and 1: touching an end does not block. `skip` names the
    /// triangles (as listed) that never block, such as those of the faces on which the ends lie.
    pub fn is_blocked(
        &self,
        a: DVec3,
        b: DVec3,
        t_min: f64,
        t_max: f64,
        skip: impl Fn(u32) -> bool,
    ) -> bool {
        let Some(box_ray) = self.box_ray(a, b - a, t_max) else {
            return false;
        };
        let woop = WoopRay::new(a, b - a);
        let test = |_: &Ray, leaf: usize| {
            let triangle = self.bvh.primitive_indices[leaf];
            let blocks = woop
                .hit(&self.triangles[leaf], triangle)
                .is_some_and(|hit| hit.t > t_min && hit.t < t_max && !skip(triangle));
            if blocks { 0.0 } else { f32::INFINITY }
        };
        !self.bvh.ray_traverse_miss(box_ray.ray, test)
    }

    /// The ray in the frame of the boxes, or none when it has no direction or ends before them.
    fn box_ray(&self, origin: DVec3, dir: DVec3, t_max: f64) -> Option<BoxRay> {
        let length = dir.length();
        if self.triangles.is_empty() || !origin.is_finite() || !(length > 0.0 && length.is_finite())
        {
            return None;
        }
        let (start, unit) = ((origin - self.centre) / self.diagonal, dir / length);
        // Move a far start to the unit sphere, which holds every box, before f32 takes its digits.
        let skipped = (start.length() - 1.0).max(0.0) - RUN_UP;
        let per_t = length / self.diagonal;
        let end = t_max * per_t - skipped + BOX_PADDING;
        (end > 0.0).then(|| BoxRay {
            ray: Ray::new(
                (start + unit * skipped).as_vec3a(),
                // Adding zero turns −0 into +0: the tree takes −0 for a positive direction with a negative inverse.
                unit.as_vec3a() + Vec3A::ZERO,
                0.0,
                end.min(BEYOND_ALL_BOXES) as f32,
            ),
            skipped,
            per_t,
        })
    }
}

impl BoxRay {
    /// A bound behind which no box can hold a hit at or before `t`; the padding keeps ties in play.
    fn cull_behind(&self, t: f64) -> f32 {
        (t * self.per_t - self.skipped + BOX_PADDING) as f32
    }
}

impl std::fmt::Debug for RayCaster {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RayCaster")
            .field("triangles", &self.triangles.len())
            .field("nodes", &self.bvh.nodes.len())
            .finish_non_exhaustive()
    }
}

/// A ray sheared so that it runs along +z from the origin (Woop et al. 2013, section 3).
struct WoopRay {
    origin: DVec3,
    /// Axes of the scene that become x, y and z; z is the one along which the ray moves most.
    axes: [usize; 3],
    shear: DVec3,
}

impl WoopRay {
    fn new(origin: DVec3, dir: DVec3) -> Self {
        let z = dir.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        // Keep the winding of a triangle as the ray sees it.
        if dir[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        Self {
            origin,
            axes: [x, y, z],
            shear: DVec3::new(dir[x] / dir[z], dir[y] / dir[z], 1.0 / dir[z]),
        }
    }

    /// Where the line of the ray meets the triangle, edges and corners included; none when it is seen edge-on.
    fn hit(&self, corners: &[DVec3; 3], triangle: u32) -> Option<Hit> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|p| {
            let p = p - self.origin;
            DVec3::new(
                p[x] - self.shear.x * p[z],
                p[y] - self.shear.y * p[z],
                self.shear.z * p[z],
            )
        });
        // Twice the signed areas that the ray makes with the three edges: the weights of the opposite corners.
        let (wa, wb, wc) = (cross(c, b), cross(a, c), cross(b, a));
        if (wa < 0.0 || wb < 0.0 || wc < 0.0) && (wa > 0.0 || wb > 0.0 || wc > 0.0) {
            return None;
        }
        let sum = wa + wb + wc;
        if sum.abs().partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        Some(Hit {
            t: (wa * a.z + wb * b.z + wc * c.z) / sum,
            triangle,
            u: wb / sum,
            v: wc / sum,
            is_front: sum > 0.0,
        })
    }
}

/// `p × q` in the plane; `cross(q, p)` is its exact negative, which is what makes shared edges tight.
fn cross(p: DVec3, q: DVec3) -> f64 {
    p.x * q.y - p.y * q.x
}

#[cfg(test)]
mod tests;
