//! Direct irradiance at a point by brute force: an exact one, and a coarse one to check it with.
//!
//! The exact one sees the scene as a picture ([`super::picture`]): from `x`, an emitter and all polygons before it are
//! projected centrally, and the light that passes between the blockers is cut into trapezoids. Nothing is subtracted
//! from anything, so nothing about the blockers (overlap, contact, shared or coinciding edges) needs care.

use super::obj_lite::ObjMesh;
use super::picture::Picture;
use glam::DVec3;
use std::ops::RangeInclusive;

/// Within this part of the scene's diagonal a point lies on a face: that face hides nothing from the point.
const CONTACT: f64 = 1e-9;

/// A scene prepared for evaluation.
#[derive(Clone, Debug)]
pub(crate) struct DirectReference {
    facets: Vec<Facet>,
    emitters: Vec<usize>,
    contact_distance: f64,
}

#[derive(Clone, Debug)]
struct Facet {
    corners: Vec<DVec3>,
    normal: DVec3,
    centre: DVec3,
    radius: f64,
    radiance: DVec3,
}

impl DirectReference {
    /// Prepares a scene of planar convex polygons.
    pub(crate) fn new(mesh: &ObjMesh) -> Self {
        let facets: Vec<Facet> = mesh
            .polygons
            .iter()
            .enumerate()
            .map(|(i, polygon)| {
                let centre = polygon.centre();
                let radii = polygon.corners.iter().map(|c| c.distance(centre));
                Facet {
                    corners: polygon.corners.clone(),
                    normal: polygon.normal(),
                    centre,
                    radius: radii.fold(0.0, f64::max),
                    radiance: mesh.surface_of(i).ke,
                }
            })
            .collect();
        let (low, high) = mesh.bounds();
        Self {
            emitters: (0..facets.len())
                .filter(|&i| facets[i].radiance != DVec3::ZERO)
                .collect(),
            facets,
            contact_distance: CONTACT * low.distance(high),
        }
    }

    /// Direct irradiance (W/m²; red, green, blue) at `x` on a surface with unit normal `n`; exact but for round-off.
    ///
    /// Faces that contain `x` or lie in its plane hide nothing; on a contact line the value is thus one without the
    /// touching wall, which is neither side's.
    pub(crate) fn irradiance(&self, x: DVec3, n: DVec3) -> DVec3 {
        let blockers = self.blockers(x, n);
        self.emitters
            .iter()
            .map(|&e| self.facets[e].radiance * self.visible_factor(x, n, e, &blockers))
            .sum()
    }

    /// The same by ray casting, without any of the exact one's geometry: each emitter is divided into four again and
    /// again, at least `depths.start()` times, then where seven rays into a part do not agree, up to `depths.end()`
    /// times. Misses what slips between the rays.
    pub(crate) fn irradiance_by_casting(
        &self,
        x: DVec3,
        n: DVec3,
        depths: RangeInclusive<u32>,
    ) -> DVec3 {
        let blockers = self.blockers(x, n);
        let mut sum = DVec3::ZERO;
        for &e in &self.emitters {
            let facet = &self.facets[e];
            if !self.shines_on(x, e) {
                continue;
            }
            for w in facet.corners[1..].windows(2) {
                let triangle = [facet.corners[0], w[0], w[1]];
                let lit = |y: DVec3| !self.is_hidden(x, y, e, &blockers);
                sum += facet.radiance * cast(x, n, triangle, *depths.end(), *depths.start(), &lit);
            }
        }
        sum
    }

    /// Faces that may hide something from `x`: neither containing it nor lying in the plane of its surface.
    fn blockers(&self, x: DVec3, n: DVec3) -> Vec<usize> {
        let is_near = |p: DVec3| (p - x).dot(n).abs() <= self.contact_distance;
        (0..self.facets.len())
            .filter(|&i| {
                let facet = &self.facets[i];
                !self.contains(facet, x) && !facet.corners.iter().all(|&c| is_near(c))
            })
            .collect()
    }

    fn contains(&self, facet: &Facet, x: DVec3) -> bool {
        let margin = self.contact_distance;
        (x - facet.corners[0]).dot(facet.normal).abs() <= margin
            && x.distance(facet.centre) <= facet.radius + margin
            && pairs(&facet.corners).all(|(a, b)| {
                let inwards = facet.normal.cross(b - a).normalize_or_zero();
                (x - a).dot(inwards) >= -margin
            })
    }

    fn shines_on(&self, x: DVec3, emitter: usize) -> bool {
        let facet = &self.facets[emitter];
        (x - facet.corners[0]).dot(facet.normal) > 0.0 && !self.contains(facet, x)
    }

    /// Irradiance from the visible part of one emitter of radiance 1.
    fn visible_factor(&self, x: DVec3, n: DVec3, emitter: usize, blockers: &[usize]) -> f64 {
        if !self.shines_on(x, emitter) {
            return 0.0;
        }
        let facet = &self.facets[emitter];
        let seen: Vec<DVec3> = facet.corners.iter().map(|&c| c - x).collect();
        let seen = clip(&seen, |v| v.dot(n));
        if seen.len() < 3 {
            return 0.0;
        }
        // The pyramid from x over the emitter: side planes point inwards. It bounds everything in the picture.
        let middle: DVec3 = seen.iter().sum();
        let sides: Vec<DVec3> = pairs(&seen)
            .map(|(a, b)| a.cross(b - a).normalize_or_zero())
            .map(|m| if m.dot(middle) < 0.0 { -m } else { m })
            .collect();
        let plane = (facet.corners[0] - x).dot(facet.normal);
        let mut before: Vec<Vec<DVec3>> = Vec::new();
        for &b in blockers {
            let blocker = &self.facets[b];
            let centre = blocker.centre - x;
            let misses = |m: &DVec3| m.dot(centre) < -blocker.radius;
            if b == emitter || sides.iter().any(misses) {
                continue;
            }
            let height = |v: DVec3| v.dot(facet.normal) - plane;
            let corners: Vec<DVec3> = blocker.corners.iter().map(|&c| c - x).collect();
            if corners.iter().all(|&v| height(v) <= self.contact_distance) {
                continue;
            }
            let mut part = clip(&corners, height);
            for &m in &sides {
                if part.len() < 3 {
                    break;
                }
                part = clip(&part, |v| v.dot(m));
            }
            if part.len() >= 3 {
                before.push(part);
            }
        }
        if before.is_empty() {
            return lambert(n, &seen);
        }
        Picture::new(&seen, facet.normal, &before).irradiance(n)
    }

    /// True when something lies between `x` and the point `y` of an emitter.
    fn is_hidden(&self, x: DVec3, y: DVec3, emitter: usize, blockers: &[usize]) -> bool {
        let ray = y - x;
        blockers.iter().any(|&b| {
            let facet = &self.facets[b];
            let (slope, distance) = (
                ray.dot(facet.normal),
                (facet.corners[0] - x).dot(facet.normal),
            );
            let t = distance / slope;
            if b == emitter || slope == 0.0 || !(1e-12..=1.0 - 1e-9).contains(&t) {
                return false;
            }
            let hit = x + ray * t;
            pairs(&facet.corners).all(|(a, c)| (c - a).cross(hit - a).dot(facet.normal) >= 0.0)
        })
    }
}

/// Lambert's formula (1760) for a polygon of radiance 1 above the horizon, whole: corners relative to the point.
///
/// `E = ½ Σ θᵢ n·(vᵢ×vᵢ₊₁)/|vᵢ×vᵢ₊₁|`, positive for counter-clockwise corners seen from behind the picture (from
/// the emitter's back), so its absolute value is what counts for a polygon that is not clipped.
pub(crate) fn lambert(n: DVec3, corners: &[DVec3]) -> f64 {
    (pairs(corners)
        .map(|(a, b)| lambert_edge(n, a, b, b - a))
        .sum::<f64>()
        / 2.0)
        .abs()
}

pub(super) fn lambert_edge(n: DVec3, a: DVec3, b: DVec3, step: DVec3) -> f64 {
    // The cross product with the step instead of with b keeps the digits of a short edge.
    let cross = a.cross(step);
    let length = cross.length();
    if length == 0.0 {
        return 0.0;
    }
    length.atan2(a.dot(b)) / length * cross.dot(n)
}

/// Each corner with the next.
pub(crate) fn pairs<T: Copy>(corners: &[T]) -> impl Iterator<Item = (T, T)> + '_ {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| (a, b))
}

/// The part of a convex polygon where `height` (linear) is not negative.
fn clip(corners: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut part = Vec::with_capacity(corners.len() + 1);
    for (a, b) in pairs(corners) {
        let (ha, hb) = (height(a), height(b));
        if ha >= 0.0 {
            part.push(a);
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            part.push(a + (b - a) * (ha / (ha - hb)));
        }
    }
    part
}

/// Irradiance from the part of a triangle of radiance 1 that `lit` says is visible.
fn cast(
    x: DVec3,
    n: DVec3,
    t: [DVec3; 3],
    depth: u32,
    at_least: u32,
    lit: &dyn Fn(DVec3) -> bool,
) -> f64 {
    // The middle, and points just inside of the corners and of the sides' middles: an edge that cuts off more than a
    // sliver of the triangle parts them.
    let weights = [
        [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
        [0.998, 0.001, 0.001],
        [0.001, 0.998, 0.001],
        [0.001, 0.001, 0.998],
        [0.4995, 0.4995, 0.001],
        [0.001, 0.4995, 0.4995],
        [0.4995, 0.001, 0.4995],
    ];
    let inside = weights.map(|w| t[0] * w[0] + t[1] * w[1] + t[2] * w[2]);
    let count = if at_least > 0 {
        0
    } else {
        inside.iter().filter(|&&y| lit(y)).count()
    };
    if at_least == 0 && (depth == 0 || count == 0 || count == weights.len()) {
        let seen = clip(&t.map(|p| p - x), |v| v.dot(n));
        return lambert(n, &seen) * count as f64 / weights.len() as f64;
    }
    let [a, b, c] = t;
    let (ab, bc, ca) = ((a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0);
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        .into_iter()
        .map(|part| {
            cast(
                x,
                n,
                part,
                depth.saturating_sub(1),
                at_least.saturating_sub(1),
                lit,
            )
        })
        .sum()
}
