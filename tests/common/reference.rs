//! Direct irradiance at a point by brute force: an exact one, and a coarse one to check it with.
//!
//! The exact one sees the scene as a picture. From `x`, an emitter and all polygons before it are projected centrally
//! onto a plane; straight lines stay straight. The picture of the emitter is then swept once: at every abscissa where a
//! vertex or a crossing of two edges lies, it is cut into slabs, in each of which no edge begins, ends or crosses
//! another, so that the light that passes between the blockers is a stack of trapezoids.
//!
//! ```text
//!      ___________________      emitter's outline
//!     |   :    : ////:   |
//!     |   : ///://///:   |      //// blockers; ':' slab limits;
//!     |___:_///:___ _:___|      white parts of a slab are trapezoids
//! ```
//!
//! Their edges are straight in the picture, so arcs of great circles on the sphere around `x`: Lambert's formula for
//! polygons is exact for each trapezoid. Nothing is subtracted from anything, so nothing about the blockers
//! (overlap, contact, shared or coinciding edges) needs care: a mistaken order of two edges that agree to round-off
//! makes a sliver as thin as the round-off.

use super::obj_lite::ObjMesh;
use glam::{DVec2, DVec3};
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

fn lambert_edge(n: DVec3, a: DVec3, b: DVec3, step: DVec3) -> f64 {
    // The cross product with the step instead of with b keeps the digits of a short edge.
    let cross = a.cross(step);
    let length = cross.length();
    if length == 0.0 {
        return 0.0;
    }
    length.atan2(a.dot(b)) / length * cross.dot(n)
}

/// Each corner with the next.
fn pairs<T: Copy>(corners: &[T]) -> impl Iterator<Item = (T, T)> + '_ {
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

/// An emitter and its blockers, projected from the eye onto the plane at distance 1 along `axis`.
struct Picture {
    axis: DVec3,
    u: DVec3,
    v: DVec3,
    edges: Vec<Edge>,
    emitter: Shape,
    blockers: Vec<Shape>,
}

/// A convex polygon of the picture: indices of the edges below and above its inside.
struct Shape {
    lower: Vec<usize>,
    upper: Vec<usize>,
    left: f64,
    right: f64,
}

/// An edge of the picture that is not upright, from left to right.
#[derive(Clone, Copy)]
struct Edge {
    a: DVec2,
    b: DVec2,
    shape: usize,
}

/// Light between a lower and an upper edge, from one abscissa to another.
#[derive(Clone, Copy)]
struct Trapezoid {
    left: f64,
    right: f64,
    lower: usize,
    upper: usize,
}

impl Edge {
    fn height_at(&self, abscissa: f64) -> f64 {
        let t = ((abscissa - self.a.x) / (self.b.x - self.a.x)).clamp(0.0, 1.0);
        self.a.y + (self.b.y - self.a.y) * t
    }

    fn crossing(&self, other: &Edge) -> Option<f64> {
        let (left, right) = (self.a.x.max(other.a.x), self.b.x.min(other.b.x));
        if left >= right {
            return None;
        }
        let gap = |x: f64| self.height_at(x) - other.height_at(x);
        let (gl, gr) = (gap(left), gap(right));
        (gl * gr < 0.0).then(|| left + (right - left) * (gl / (gl - gr)))
    }
}

impl Picture {
    /// Projects an emitter (corners relative to the eye, its normal towards the eye) and the parts of blockers in the
    /// pyramid between the two.
    fn new(emitter: &[DVec3], normal: DVec3, blockers: &[Vec<DVec3>]) -> Self {
        // Look at the emitter's middle, unless it spans so much of the sky that a corner would come near the picture's
        // horizon: then look straight at its plane, of which every point is in front.
        let towards: DVec3 = emitter.iter().map(|p| p.normalize_or_zero()).sum();
        let mut axis = towards.normalize_or_zero();
        if emitter.iter().any(|p| p.dot(axis) < 0.05 * p.length()) {
            axis = -normal;
        }
        let along = (emitter[1] - emitter[0]).reject_from_normalized(axis);
        let mut u = along
            .try_normalize()
            .unwrap_or_else(|| axis.any_orthonormal_vector());
        let mut v = axis.cross(u);
        // Sweep across the blockers rather than along them: fewer of them are in a slab.
        let extent = |d: DVec3| -> f64 {
            let project = |p: &DVec3| p.dot(d) / p.dot(axis);
            blockers
                .iter()
                .map(|b| spread(b.iter().map(project)))
                .sum::<f64>()
                / spread(emitter.iter().map(project))
        };
        if extent(v) < extent(u) {
            (u, v) = (v, -u);
        }
        let mut picture = Self {
            axis,
            u,
            v,
            edges: Vec::new(),
            emitter: Shape::empty(),
            blockers: Vec::new(),
        };
        picture.emitter = picture.shape(emitter, 0).unwrap_or_else(Shape::empty);
        for (i, blocker) in blockers.iter().enumerate() {
            let shape = picture.shape(blocker, i + 1);
            picture.blockers.extend(shape);
        }
        picture
    }

    fn shape(&mut self, corners: &[DVec3], id: usize) -> Option<Shape> {
        let mut points = Vec::with_capacity(corners.len());
        for p in corners {
            let depth = p.dot(self.axis);
            if depth <= 0.0 {
                return None;
            }
            points.push(DVec2::new(p.dot(self.u), p.dot(self.v)) / depth);
        }
        let first = points[0];
        let twice_area: f64 = pairs(&points)
            .map(|(a, b)| (a - first).perp_dot(b - first))
            .sum();
        if twice_area < 0.0 {
            points.reverse();
        }
        let mut shape = Shape::empty();
        for (a, b) in pairs(&points) {
            shape.left = shape.left.min(a.x);
            shape.right = shape.right.max(a.x);
            // Counter-clockwise, the edges that run to the right are the lower ones.
            let (chain, a, b) = match a.x.total_cmp(&b.x) {
                std::cmp::Ordering::Less => (&mut shape.lower, a, b),
                std::cmp::Ordering::Equal => continue,
                std::cmp::Ordering::Greater => (&mut shape.upper, b, a),
            };
            chain.push(self.edges.len());
            self.edges.push(Edge { a, b, shape: id });
        }
        Some(shape)
    }

    /// The edge of a chain over an abscissa.
    fn edge_at(&self, chain: &[usize], abscissa: f64) -> Option<usize> {
        let covers = |&&e: &&usize| (self.edges[e].a.x..=self.edges[e].b.x).contains(&abscissa);
        chain.iter().find(covers).copied()
    }

    /// Abscissae between which no edge begins, ends or crosses another.
    fn slab_limits(&self) -> Vec<f64> {
        let mut limits: Vec<f64> = self.edges.iter().flat_map(|e| [e.a.x, e.b.x]).collect();
        let mut order: Vec<&Edge> = self.edges.iter().collect();
        order.sort_by(|e, f| e.a.x.total_cmp(&f.a.x));
        for (i, e) in order.iter().enumerate() {
            for f in order[i + 1..].iter().take_while(|f| f.a.x < e.b.x) {
                if e.shape != f.shape {
                    limits.extend(e.crossing(f));
                }
            }
        }
        limits.retain(|x| (self.emitter.left..=self.emitter.right).contains(x));
        limits.sort_by(f64::total_cmp);
        limits.dedup();
        limits
    }

    /// The visible part of the emitter.
    fn trapezoids(&self) -> Vec<Trapezoid> {
        let mut order: Vec<&Shape> = self.blockers.iter().collect();
        order.sort_by(|a, b| a.left.total_cmp(&b.left));
        let mut waiting = order.into_iter().peekable();
        let mut in_reach: Vec<&Shape> = Vec::new();
        let (mut done, mut open): (Vec<Trapezoid>, Vec<Trapezoid>) = (Vec::new(), Vec::new());
        for slab in self.slab_limits().windows(2) {
            let (left, right) = (slab[0], slab[1]);
            let middle = left + (right - left) / 2.0;
            while let Some(shape) = waiting.next_if(|s| s.left <= middle) {
                in_reach.push(shape);
            }
            in_reach.retain(|s| s.right >= middle);
            // A gap between the same two edges as in the slab before is the same trapezoid, continued.
            let mut now = Vec::new();
            for (lower, upper) in self.gaps(&in_reach, middle) {
                let before = open
                    .iter()
                    .position(|t| t.lower == lower && t.upper == upper);
                let left = before.map_or(left, |i| open.swap_remove(i).left);
                now.push(Trapezoid {
                    left,
                    right,
                    lower,
                    upper,
                });
            }
            done.append(&mut open);
            open = now;
        }
        done.append(&mut open);
        done
    }

    /// Pairs of edges between which light passes over an abscissa, from below to above.
    fn gaps(&self, shapes: &[&Shape], abscissa: f64) -> Vec<(usize, usize)> {
        let span = |s: &Shape| -> Option<[(f64, usize); 2]> {
            let lower = self.edge_at(&s.lower, abscissa)?;
            let upper = self.edge_at(&s.upper, abscissa)?;
            Some([lower, upper].map(|e| (self.edges[e].height_at(abscissa), e)))
        };
        let Some([mut bottom, top]) = span(&self.emitter) else {
            return Vec::new();
        };
        let mut hidden: Vec<_> = shapes.iter().filter_map(|s| span(s)).collect();
        hidden.sort_by(|a, b| a[0].0.total_cmp(&b[0].0));
        let mut gaps = Vec::new();
        for [low, high] in hidden {
            if low.0 > bottom.0 {
                gaps.push((bottom.1, low.1));
            }
            if high.0 > bottom.0 {
                bottom = high;
            }
        }
        if top.0 > bottom.0 {
            gaps.push((bottom.1, top.1));
        }
        gaps
    }

    /// Irradiance from the visible part, for radiance 1.
    fn irradiance(&self, n: DVec3) -> f64 {
        let mut sum = 0.0;
        for t in self.trapezoids() {
            let corner = |abscissa: f64, edge: usize| {
                DVec2::new(abscissa, self.edges[edge].height_at(abscissa))
            };
            let corners = [
                corner(t.left, t.lower),
                corner(t.right, t.lower),
                corner(t.right, t.upper),
                corner(t.left, t.upper),
            ];
            for (a, b) in pairs(&corners) {
                let lift = |p: DVec2| self.u * p.x + self.v * p.y;
                sum += lambert_edge(n, self.axis + lift(a), self.axis + lift(b), lift(b - a));
            }
        }
        sum / 2.0
    }
}

impl Shape {
    fn empty() -> Self {
        Self {
            lower: Vec::new(),
            upper: Vec::new(),
            left: f64::INFINITY,
            right: f64::NEG_INFINITY,
        }
    }
}

/// Greatest less least.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
        (l.min(x), h.max(x))
    });
    high - low
}
