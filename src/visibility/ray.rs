//! The shared ray caster: nearest hit and occlusion against a list of triangles, without leaks along shared edges.
//!
//! Boxes are culled in f32 (a tree of its own layout), triangles are decided in f64 by the test of Woop, Benthin and Wald,
//! "Watertight Ray/Triangle Intersection" (JCGT 2013). Their fall-back to higher precision where an edge function is zero is not
//! needed: two triangles that share an edge compute exactly opposite values for it, and zero belongs to both.

use super::ray_tree::{RayTree, TreeRay};
use glam::DVec3;

/// How far boxes reach beyond their triangles, as a fraction of the diagonal of the whole.
///
/// Coordinates of boxes are at most ½ and those of origins at most 1, so that the ways between them are at most 1½. Rounding
/// moves an end of a box by ½ ε (its coordinate), ε (the origin), 1½ ε (their difference) and 1½ · 3 ε (the component of the
/// direction, its inverse and the product), ε = 2⁻²⁴: 7½ ε together. This is twice that, so that the same length is enough where
/// the end of a ray is rounded.
const BOX_PADDING: f64 = 8.0 * f32::EPSILON as f64;

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
    tree: RayTree,
    /// In the order of the tree's leaves; `tree.order` leads back to the caller's order.
    triangles: Vec<[DVec3; 3]>,
    /// The frame of the boxes: `(p − centre) / diagonal`, so that absolute thresholds of the tree never see the scene's scale.
    centre: DVec3,
    /// One over the diagonal.
    scale: f64,
}

/// A ray in the frame of the boxes.
struct BoxRay {
    ray: TreeRay,
    /// Box units by which the start was moved along the ray.
    skipped: f64,
    /// Box units for each unit of the caller's `t`.
    per_t: f64,
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
        let tree = RayTree::new(triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|p| (p - centre) / diagonal);
            let (low, high) = (a.min(b).min(c) - padding, a.max(b).max(c) + padding);
            (low.as_vec3a(), high.as_vec3a())
        }));
        let in_order = tree.order.iter();
        let triangles = in_order.map(|&i| triangles[i as usize]).collect();
        Self {
            tree,
            triangles,
            centre,
            scale: diagonal.recip(),
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
        self.tree.nearest(&box_ray.ray, |leaf| {
            for place in leaf {
                let found = woop
                    .hit(&self.triangles[place], self.tree.order[place])
                    .filter(|hit| hit.t > t_min && hit.t < t_max && accept(hit));
                if let Some(hit) = found
                    && best.is_none_or(|b| (hit.t, hit.triangle) < (b.t, b.triangle))
                {
                    best = Some(hit);
                }
            }
            best.map_or(f32::INFINITY, |b| box_ray.cull_behind(b.t))
        });
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
        self.tree.any(&box_ray.ray, |mut leaf| {
            leaf.any(|place| {
                let triangle = self.tree.order[place];
                woop.hit(&self.triangles[place], triangle)
                    .is_some_and(|hit| hit.t > t_min && hit.t < t_max && !skip(triangle))
            })
        })
    }

    /// The ray in the frame of the boxes, or none when it has no direction or ends before them.
    fn box_ray(&self, origin: DVec3, dir: DVec3, t_max: f64) -> Option<BoxRay> {
        let length = dir.length();
        if self.triangles.is_empty() || !origin.is_finite() || !(length > 0.0 && length.is_finite())
        {
            return None;
        }
        let (start, unit) = ((origin - self.centre) * self.scale, dir * (1.0 / length));
        // Move a far start to the unit sphere, which holds every box, before f32 takes its digits.
        let skipped = (start.length_squared().max(1.0)).sqrt() - 1.0;
        let per_t = length * self.scale;
        let end = t_max * per_t - skipped + BOX_PADDING;
        (end > 0.0).then(|| BoxRay {
            ray: TreeRay {
                origin: (start + unit * skipped).as_vec3a(),
                direction: unit.as_vec3a(),
                end: end as f32,
            },
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
            .field("nodes", &self.tree.node_count())
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
        let sheared = |p: &DVec3| {
            let (p, o) = (p.as_ref(), self.origin.as_ref());
            let along = p[z] - o[z];
            DVec3::new(
                (p[x] - o[x]) - self.shear.x * along,
                (p[y] - o[y]) - self.shear.y * along,
                self.shear.z * along,
            )
        };
        let [a, b, c] = [0, 1, 2].map(|k| sheared(&corners[k]));
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
