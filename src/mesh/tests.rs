//! Seeded troublemakers for the whole kernel, shared by the tests of its parts.

use super::{GridPoint, Segment, arrangement, triangulate};

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

/// Prints how long typical and large faces take; run with `--release -- --ignored --nocapture timing`.
#[test]
#[ignore = "a measurement, not a test"]
fn timing_of_arrangement_and_triangulation() {
    let size = 1 << 25;
    let short = |count: usize, reach: i64, random: &mut Random| -> Vec<Segment> {
        let mut all = segments(Kind::Uniform, count, size - reach, random);
        for s in &mut all {
            s.b = random.jitter(s.a, reach);
        }
        all
    };
    let random = &mut Random::new(1);
    let few = segments(Kind::Uniform, 50, size, random);
    let many_points = points(20_000, size, &few, random);
    // All in one corner, 1/1000 of the face.
    let crowded = segments(Kind::Uniform, 500, size / 1000, random);
    let crowd = points(20_000, size / 1000, &crowded[..50], random);
    let mut cornered = crowded.clone();
    cornered.extend(segments(Kind::Lattice, 50, size, random));
    let cases = [
        (
            "500 long segments",
            segments(Kind::Uniform, 500, size, random),
            vec![],
        ),
        ("50 long segments, 20 000 points", few, many_points),
        ("3000 short segments", short(3000, size / 6, random), vec![]),
        (
            "3000 long segments",
            segments(Kind::Uniform, 3000, size, random),
            vec![],
        ),
        (
            "480 shadow edges, 2000 points",
            segments(Kind::BoxShadow, 480, size, random),
            points(2000, size, &[], random),
        ),
        (
            "500 nearly coincident segments",
            segments(Kind::NearCoincident, 500, size, random),
            vec![],
        ),
        (
            "550 segments, 500 of them in a corner with 20 000 points",
            cornered,
            crowd,
        ),
    ];
    for (name, segments, points) in cases {
        let mut best = [f64::INFINITY; 2];
        let mut line = String::new();
        for _ in 0..3 {
            let start = std::time::Instant::now();
            let (arrangement, passes) = arrangement::arrange_counted(&segments, &points);
            let arranged = start.elapsed().as_secs_f64();
            let triangulation = triangulate(&arrangement).expect("arrangements triangulate");
            let both = start.elapsed().as_secs_f64();
            best = [best[0].min(arranged), best[1].min(both - arranged)];
            line = format!(
                "{} vertices, {} edges ({} with their sources), {} triangles, {passes} passes",
                arrangement.vertices.len(),
                arrangement.edges.len(),
                arrangement
                    .edges
                    .iter()
                    .map(|e| e.sources.len())
                    .sum::<usize>(),
                triangulation.triangles.len()
            );
        }
        let [arranged, triangulated] = best.map(|s| s * 1e3);
        eprintln!("{name}: arrange {arranged:.2} ms, triangulate {triangulated:.2} ms ({line})");
    }
}
