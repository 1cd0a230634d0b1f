//! An emitter and what stands before it as a flat picture, and the light that passes between.
//!
//! Everything is projected centrally from the eye onto a plane; straight lines stay straight. The picture is then swept
//! once: at every abscissa where a vertex or a crossing of two edges lies it is cut into slabs, in each of which no edge
//! begins, ends or crosses another, so that the light in it is a stack of trapezoids.
//!
//! ```text
//!      ___________________      emitter's outline
//!     |   :    : ////:   |
//!     |   : ///://///:   |      //// blockers; ':' slab limits;
//!     |___:_///:___ _:___|      white parts of a slab are trapezoids
//! ```
//!
//! Their edges are straight in the picture, so arcs of great circles on the sphere around the eye: Lambert's formula
//! for polygons is exact for each trapezoid. A mistaken order of two edges that agree to round-off makes a sliver as
//! thin as the round-off.

use super::reference::{lambert_edge, pairs};
use glam::{DVec2, DVec3};

/// An emitter and its blockers, projected from the eye onto the plane at distance 1 along `axis`.
pub(super) struct Picture {
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
    pub(super) fn new(emitter: &[DVec3], normal: DVec3, blockers: &[Vec<DVec3>]) -> Self {
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
    pub(super) fn irradiance(&self, n: DVec3) -> f64 {
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
