//! Total irradiance at a point by tracing paths: slow, noisy, and independent of meshes and solvers.
//!
//! Both sides of a face reflect, fronts emit. Two estimators of the same number: `from_hits` collects emission wherever
//! a path ends up, `from_emitters` asks at every vertex for the light of one random point of the emitters instead.

use super::obj_lite::{ObjMesh, Triangle};
use super::rng::Rng;
use glam::DVec3;
use std::f64::consts::PI;

/// A mean with the standard deviation of the mean, per channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    /// W/m².
    pub(crate) mean: DVec3,
    /// W/m².
    pub(crate) standard_error: DVec3,
}

impl Estimate {
    /// How many standard errors `value` is away, in the worst channel. `round_off` is added to the standard error, for
    /// estimators without variance.
    pub(crate) fn z(&self, value: DVec3, round_off: f64) -> f64 {
        let error = self.standard_error + DVec3::splat(round_off);
        ((self.mean - value) / error).abs().max_element()
    }
}

/// How to trace.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathSettings {
    /// Paths a point.
    pub(crate) paths: u32,
    /// Reflections a path: 0 for direct light only.
    pub(crate) bounces: u32,
    /// Seed of the random numbers.
    pub(crate) seed: u64,
    /// Whether each vertex samples the emitters (true) or emission is found by chance (false).
    pub(crate) from_emitters: bool,
}

/// A scene prepared for tracing.
pub(crate) struct PathTracer {
    triangles: Vec<Triangle>,
    boxes: Vec<BoxNode>,
    emitters: Vec<usize>,
    /// Sums of the emitters' areas up to and including each.
    area_sums: Vec<f64>,
    /// Rays start this far off a face.
    offset: f64,
}

struct BoxNode {
    low: DVec3,
    high: DVec3,
    /// Leaf: triangles `first..first + count`; inner node (`count` 0): children follow, and at `first`.
    first: usize,
    count: usize,
}

struct Hit {
    position: DVec3,
    /// On the side that was hit.
    normal: DVec3,
    triangle: usize,
    is_front: bool,
}

const LEAF_SIZE: usize = 4;

impl PathTracer {
    /// Prepares a scene.
    pub(crate) fn new(mesh: &ObjMesh) -> Self {
        let (low, high) = mesh.bounds();
        let mut tracer = Self {
            triangles: mesh.triangles(),
            boxes: Vec::new(),
            emitters: Vec::new(),
            area_sums: Vec::new(),
            offset: 1e-9 * low.distance(high),
        };
        if !tracer.triangles.is_empty() {
            tracer.build(0, tracer.triangles.len());
        }
        let mut area = 0.0;
        for (i, t) in tracer.triangles.iter().enumerate() {
            if t.ke != DVec3::ZERO {
                area += doubled_normal(t).length() / 2.0;
                tracer.emitters.push(i);
                tracer.area_sums.push(area);
            }
        }
        tracer
    }

    /// Irradiance at `x` on a surface with unit normal `n`.
    pub(crate) fn irradiance(&self, x: DVec3, n: DVec3, settings: &PathSettings) -> Estimate {
        self.estimate(x, n, settings, true)
    }

    /// The part of it that has been reflected at least once.
    pub(crate) fn indirect(&self, x: DVec3, n: DVec3, settings: &PathSettings) -> Estimate {
        self.estimate(x, n, settings, false)
    }

    fn estimate(&self, x: DVec3, n: DVec3, settings: &PathSettings, direct: bool) -> Estimate {
        let mut rng = Rng::new(settings.seed);
        let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for _ in 0..settings.paths {
            let sample = self.path(x, n, settings, direct, &mut rng);
            sum += sample;
            squares += sample * sample;
        }
        let count = f64::from(settings.paths);
        let mean = sum / count;
        let variance = (squares / count - mean * mean).max(DVec3::ZERO) / (count - 1.0).max(1.0);
        Estimate {
            mean,
            standard_error: variance.map(f64::sqrt),
        }
    }

    /// One sample of the irradiance, with or without what comes straight from the emitters.
    fn path(
        &self,
        x: DVec3,
        n: DVec3,
        settings: &PathSettings,
        direct: bool,
        rng: &mut Rng,
    ) -> DVec3 {
        let (mut x, mut n) = (x, n);
        let mut irradiance = DVec3::ZERO;
        // What one unit of irradiance at the path's end adds at its start.
        let mut weight = DVec3::ONE;
        for bounce in 0..=settings.bounces {
            let counts = direct || bounce > 0;
            if settings.from_emitters && counts {
                irradiance += weight * self.light_of_an_emitter(x, n, rng);
            }
            if bounce == settings.bounces && settings.from_emitters {
                break;
            }
            let Some(hit) =
                self.nearest(x + n * self.offset, cosine_direction(n, rng), f64::INFINITY)
            else {
                break;
            };
            let surface = &self.triangles[hit.triangle];
            if hit.is_front && !settings.from_emitters && counts {
                irradiance += weight * surface.ke * PI;
            }
            weight *= surface.kd;
            // Russian roulette: a path goes on as likely as its surface reflects.
            let survival = surface.kd.max_element();
            if rng.unit() >= survival {
                break;
            }
            weight /= survival;
            (x, n) = (hit.position, hit.normal);
        }
        irradiance
    }

    /// Direct irradiance by way of one point of the emitters, chosen uniformly by area.
    fn light_of_an_emitter(&self, x: DVec3, n: DVec3, rng: &mut Rng) -> DVec3 {
        let Some(&area) = self.area_sums.last() else {
            return DVec3::ZERO;
        };
        let pick = rng.unit() * area;
        let which = self.area_sums.partition_point(|&a| a <= pick);
        let t = &self.triangles[self.emitters[which.min(self.emitters.len() - 1)]];
        let (mut a, mut b) = (rng.unit(), rng.unit());
        if a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        let y =
            t.corners[0] + (t.corners[1] - t.corners[0]) * a + (t.corners[2] - t.corners[0]) * b;
        let normal = doubled_normal(t).normalize();
        let (from, to) = (x + n * self.offset, y + normal * self.offset);
        let way = to - from;
        let distance = way.length();
        let direction = way / distance;
        let (at_x, at_y) = (direction.dot(n), -direction.dot(normal));
        if at_x <= 0.0 || at_y <= 0.0 || self.nearest(from, direction, distance).is_some() {
            return DVec3::ZERO;
        }
        t.ke * (at_x * at_y * area / (distance * distance))
    }

    fn nearest(&self, origin: DVec3, direction: DVec3, limit: f64) -> Option<Hit> {
        let mut best = (limit, usize::MAX);
        let mut stack = vec![0];
        while let Some(node) = stack.pop() {
            let Some(b) = self.boxes.get(node) else { break };
            if !b.is_met(origin, direction, best.0) {
                continue;
            }
            if b.count == 0 {
                stack.extend([node + 1, b.first]);
            }
            for i in b.first..b.first + b.count {
                if let Some(t) = intersect(&self.triangles[i], origin, direction)
                    && t < best.0
                {
                    best = (t, i);
                }
            }
        }
        let triangle = self.triangles.get(best.1)?;
        let front = doubled_normal(triangle).normalize();
        let is_front = front.dot(direction) < 0.0;
        Some(Hit {
            position: origin + direction * best.0,
            normal: if is_front { front } else { -front },
            triangle: best.1,
            is_front,
        })
    }

    /// Builds the node over a range of triangles, halved at the median of the longest side of their centres' box.
    fn build(&mut self, first: usize, count: usize) -> usize {
        let range = first..first + count;
        let centre = |t: &Triangle| t.corners.iter().sum::<DVec3>() / 3.0;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut inner_low, mut inner_high) = (low, high);
        for t in &self.triangles[range.clone()] {
            for &c in &t.corners {
                (low, high) = (low.min(c), high.max(c));
            }
            inner_low = inner_low.min(centre(t));
            inner_high = inner_high.max(centre(t));
        }
        let margin = DVec3::splat(self.offset * 1e-3);
        let node = self.boxes.len();
        self.boxes.push(BoxNode {
            low: low - margin,
            high: high + margin,
            first,
            count,
        });
        if count > LEAF_SIZE {
            let axis = (inner_high - inner_low).max_position();
            self.triangles[range].sort_by(|a, b| centre(a)[axis].total_cmp(&centre(b)[axis]));
            self.build(first, count / 2);
            let second = self.build(first + count / 2, count - count / 2);
            (self.boxes[node].first, self.boxes[node].count) = (second, 0);
        }
        node
    }
}

impl BoxNode {
    fn is_met(&self, origin: DVec3, direction: DVec3, limit: f64) -> bool {
        let (a, b) = (
            (self.low - origin) / direction,
            (self.high - origin) / direction,
        );
        let (mut near, mut far) = (0.0, limit);
        for axis in 0..3 {
            // In a box's own plane 0/0 says nothing: then that pair of planes does not count.
            if direction[axis] == 0.0 {
                if origin[axis] < self.low[axis] || origin[axis] > self.high[axis] {
                    return false;
                }
                continue;
            }
            near = f64::max(near, a[axis].min(b[axis]));
            far = f64::min(far, a[axis].max(b[axis]));
        }
        near <= far
    }
}

fn doubled_normal(t: &Triangle) -> DVec3 {
    let [a, b, c] = t.corners;
    (b - a).cross(c - a)
}

/// Distance to a triangle along a ray (Möller, Trumbore 1997).
fn intersect(t: &Triangle, origin: DVec3, direction: DVec3) -> Option<f64> {
    let (e1, e2) = (t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
    let p = direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - t.corners[0];
    let u = s.dot(p) / determinant;
    let q = s.cross(e1);
    let v = direction.dot(q) / determinant;
    let distance = e2.dot(q) / determinant;
    // A ray through a shared edge has to meet one of its triangles.
    let margin = -1e-12;
    (u >= margin && v >= margin && u + v <= 1.0 - margin && distance > 0.0).then_some(distance)
}

/// A direction with density cos θ / π about `n`.
fn cosine_direction(n: DVec3, rng: &mut Rng) -> DVec3 {
    let (u, v) = n.any_orthonormal_pair();
    let (radius, angle) = (rng.unit().sqrt(), 2.0 * PI * rng.unit());
    let up = (1.0 - radius * radius).max(0.0).sqrt();
    u * (radius * angle.cos()) + v * (radius * angle.sin()) + n * up
}
