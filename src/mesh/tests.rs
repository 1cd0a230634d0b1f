//! Seeded troublemakers for the whole kernel, shared by the tests of its parts.

use super::{GridPoint, Segment};

/// Marsaglia's xorshift: a few lines, the same numbers everywhere.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(super) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16
    }

    /// A whole number in `low..=high`.
    pub(super) fn within(&mut self, low: i64, high: i64) -> i64 {
        low + (self.next() % (high - low + 1) as u64) as i64
    }

    /// A number in `0.0..1.0`.
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() % (1 << 32)) as f64 / (1_u64 << 32) as f64
    }

    /// A point with coordinates up to `size` in magnitude.
    pub(super) fn point(&mut self, size: i64) -> GridPoint {
        GridPoint::new(self.within(-size, size), self.within(-size, size))
    }

    /// The point at a fraction `t` of the way from `a` to `b`, rounded.
    fn along(a: GridPoint, b: GridPoint, t: f64) -> GridPoint {
        let at = |a: i64, b: i64| a + (t * (b - a) as f64).round() as i64;
        GridPoint::new(at(a.x, b.x), at(a.y, b.y))
    }

    fn jitter(&mut self, p: GridPoint, pixels: i64) -> GridPoint {
        let d = self.point(pixels);
        GridPoint::new(p.x + d.x, p.y + d.y)
    }
}

/// Kinds of trouble.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Lattice,
    JitteredLattice,
    Collinear,
    TJunctions,
    TinyAngles,
    BoxShadow,
    NearCoincident,
    Uniform,
}

pub(super) const KINDS: [Kind; 8] = [
    Kind::Lattice,
    Kind::JitteredLattice,
    Kind::Collinear,
    Kind::TJunctions,
    Kind::TinyAngles,
    Kind::BoxShadow,
    Kind::NearCoincident,
    Kind::Uniform,
];

/// `count` segments of a kind within `±size` pixels, sources `0..count`.
pub(super) fn segments(kind: Kind, count: usize, size: i64, random: &mut Random) -> Vec<Segment> {
    let mut ends: Vec<(GridPoint, GridPoint)> = Vec::new();
    let inner = size - 4;
    let base = (random.point(inner), random.point(inner));
    while ends.len() < count {
        let pick = |random: &mut Random, ends: &[(GridPoint, GridPoint)]| match ends.len() {
            0 => base,
            n => ends[random.within(0, n as i64 - 1) as usize],
        };
        ends.push(match kind {
            Kind::Lattice | Kind::JitteredLattice => {
                let pitch = (inner / 4).max(1);
                let mut node = || {
                    let p = random.point(4);
                    let p = GridPoint::new(p.x * pitch, p.y * pitch);
                    let shift = i64::from(kind == Kind::JitteredLattice);
                    random.jitter(p, shift)
                };
                (node(), node())
            }
            Kind::Collinear => {
                let mut at = || Random::along(base.0, base.1, random.unit());
                (at(), at())
            }
            Kind::TJunctions => {
                let (a, b) = pick(random, &ends);
                (Random::along(a, b, random.unit()), random.point(inner))
            }
            Kind::TinyAngles => (base.0, random.jitter(base.1, 3)),
            Kind::BoxShadow => {
                ends.extend(box_shadow(inner, random));
                continue;
            }
            Kind::NearCoincident => {
                let (a, b) = pick(random, &ends);
                (random.jitter(a, 1), random.jitter(b, 1))
            }
            Kind::Uniform => (random.point(inner), random.point(inner)),
        });
        // A chain of jitters must not wander off.
        if let Some((a, b)) = ends.last_mut() {
            for p in [a, b] {
                *p = GridPoint::new(p.x.clamp(-size, size), p.y.clamp(-size, size));
            }
        }
    }
    ends.truncate(count);
    (0..)
        .zip(ends)
        .map(|(source, (a, b))| Segment { a, b, source })
        .collect()
}

/// The twelve edges of a box, projected through the four corners of a lamp onto the floor.
fn box_shadow(size: i64, random: &mut Random) -> Vec<(GridPoint, GridPoint)> {
    let centre = [random.unit() - 0.5, random.unit() - 0.5];
    let (half, top) = (0.05 + 0.15 * random.unit(), 0.1 + 0.5 * random.unit());
    let project = |corner: usize, lamp: usize| {
        let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
        let height = if corner & 4 == 0 { 0.0 } else { top };
        let at = |axis: usize| {
            let p = centre[axis] + half * sign(corner & (1 << axis));
            let light = 0.1 * sign(lamp & (1 << axis));
            let shadow = p + (p - light) * height / (2.0 - height);
            ((shadow * 0.9 * size as f64).round() as i64).clamp(-size, size)
        };
        GridPoint::new(at(0), at(1))
    };
    let mut edges = Vec::new();
    for lamp in 0..4 {
        for corner in 0..8 {
            for bit in [1, 2, 4] {
                if corner & bit == 0 {
                    edges.push((project(corner, lamp), project(corner | bit, lamp)));
                }
            }
        }
    }
    edges
}

/// Isolated points: half anywhere, half within a few pixels of a segment.
pub(super) fn points(
    count: usize,
    size: i64,
    segments: &[Segment],
    random: &mut Random,
) -> Vec<GridPoint> {
    (0..count)
        .map(|k| {
            if k % 2 == 0 || segments.is_empty() {
                return random.point(size);
            }
            let s = segments[random.within(0, segments.len() as i64 - 1) as usize];
            let on = Random::along(s.a, s.b, random.unit());
            let near = random.jitter(on, 2);
            GridPoint::new(near.x.clamp(-size, size), near.y.clamp(-size, size))
        })
        .collect()
}
