//! A texture in linear light at every resolution (L. Williams, *Pyramidal parametrics*, 1983).

use super::{Texels, Wrap, srgb_decode};
use crate::quantity::Rgb;
use glam::{DVec2, DVec4};
use std::sync::Arc;

/// Texels along one side of the part of a level that a mean adds up: finer levels are summed beforehand. A texel on the
/// border of the triangle then counts for at most 1/256 of its width too much.
const MEAN_TEXELS: f64 = 256.0;

/// Lines along which a mean is taken at least, in triangles lower than that many texels.
const MIN_LINES: f64 = 8.0;

/// Points along each side of a triangle that repeats its texture so often that no level is coarse enough.
const SPARSE_POINTS: u32 = 64;

/// What a texture shows over some area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMean {
    /// Mean linear colour of what is there; black when nothing is.
    pub colour: Rgb,
    /// Share of the area in which something is there.
    pub coverage: f64,
}

/// One resolution; texels hold linear colour times coverage, and coverage.
struct Level {
    size: [u32; 2],
    texels: Vec<[f32; 4]>,
}

/// The texture at full resolution and at half of it, a quarter … down to one texel.
pub struct MipMap {
    full: Arc<Texels>,
    /// Linear values of the 256 steps.
    linear: [f32; 256],
    wrap: [Wrap; 2],
    /// Texels of lower opacity are not there.
    cut_off: Option<f64>,
    /// From half the resolution on.
    levels: Vec<Level>,
}

impl MipMap {
    /// The levels of `texels`. Texels with an opacity below `cut_off` (0…1) are not there; without it all are.
    pub fn new(texels: Arc<Texels>, wrap: [Wrap; 2], cut_off: Option<f64>) -> Self {
        let mut map = Self {
            full: texels,
            linear: std::array::from_fn(|step| srgb_decode(step as f64 / 255.0) as f32),
            wrap,
            cut_off,
            levels: Vec::new(),
        };
        let mut size = [map.full.width, map.full.height];
        while size != [1, 1] {
            let next = size.map(|n| (n / 2).max(1));
            let level = map.reduced(size, next);
            map.levels.push(level);
            size = next;
        }
        map
    }

    /// The last level, as means over the boxes of the next one's texels.
    fn reduced(&self, from: [u32; 2], to: [u32; 2]) -> Level {
        let last = self.levels.len();
        let (columns, rows) = (Shares::new(from[0], to[0]), Shares::new(from[1], to[1]));
        let mut texels = Vec::with_capacity(to[0] as usize * to[1] as usize);
        for y in 0..to[1] {
            for x in 0..to[0] {
                let mut sum = DVec4::ZERO;
                for (j, height) in rows.of(y) {
                    for (i, width) in columns.of(x) {
                        sum += self.texel(last, i, j) * (width * height);
                    }
                }
                texels.push(sum.as_vec4().to_array());
            }
        }
        Level { size: to, texels }
    }

    fn size(&self, level: usize) -> [u32; 2] {
        match level.checked_sub(1) {
            None => [self.full.width, self.full.height],
            Some(coarse) => self.levels[coarse].size,
        }
    }

    /// Width and height at full resolution, texels.
    pub fn full_size(&self) -> DVec2 {
        let [width, height] = self.size(0).map(f64::from);
        DVec2::new(width, height)
    }

    /// Number of levels.
    pub fn level_count(&self) -> usize {
        self.levels.len() + 1
    }

    /// Linear colour times coverage, and coverage, of a texel of `level`.
    fn texel(&self, level: usize, x: u32, y: u32) -> DVec4 {
        let at = y as usize * self.size(level)[0] as usize + x as usize;
        if let Some(coarse) = level.checked_sub(1) {
            let [r, g, b, a] = self.levels[coarse].texels[at].map(f64::from);
            return DVec4::new(r, g, b, a);
        }
        let [r, g, b, opacity] = self.full.rgba[at];
        let is_there = self
            .cut_off
            .is_none_or(|cut_off| f64::from(opacity) >= cut_off * 255.0);
        if !is_there {
            return DVec4::ZERO;
        }
        let [r, g, b] = [r, g, b].map(|step| f64::from(self.linear[step as usize]));
        DVec4::new(r, g, b, 1.0)
    }

    fn wrapped(&self, level: usize, x: i64, y: i64) -> DVec4 {
        let [width, height] = self.size(level);
        self.texel(
            level,
            self.wrap[0].texel(x, width),
            self.wrap[1].texel(y, height),
        )
    }

    /// The mean over the triangle with these texture coordinates.
    ///
    /// Texels count by the length of their rows inside the triangle, row by row; the level is the finest at which the
    /// triangle is at most 256 texels wide and high. A triangle without area has the mean along its longest side.
    pub fn mean(&self, corners: [DVec2; 3]) -> TextureMean {
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let scale = |level| {
            let [width, height] = self.size(level);
            DVec2::new(f64::from(width), f64::from(height))
        };
        let fits = |level: &usize| ((high - low) * scale(*level)).max_element() <= MEAN_TEXELS;
        let sum = match (0..self.level_count()).find(fits) {
            Some(level) => self.sum_of_rows(level, corners.map(|c| c * scale(level))),
            None => DVec4::ZERO,
        };
        // No rows: a triangle without area, or one that repeats the texture hundreds of times.
        let sum = if sum.w > 0.0 && sum.is_finite() {
            sum
        } else {
            self.sum_of_points(corners)
        };
        mean_of(sum)
    }

    /// Sum of (colour × coverage, coverage) over the triangle and, in place of a fifth number, divided by its area.
    fn sum_of_rows(&self, level: usize, t: [DVec2; 3]) -> DVec4 {
        let (low, high) = (
            t[0].y.min(t[1].y).min(t[2].y),
            t[0].y.max(t[1].y).max(t[2].y),
        );
        let lines_per_row = (MIN_LINES / (high - low).max(1.0)).ceil();
        let (mut sum, mut area) = (DVec4::ZERO, 0.0);
        let step = 1.0 / lines_per_row;
        let mut from = low;
        while from < high {
            // To the next border of a row or of its part.
            let to = (((from * lines_per_row).floor() + 1.0) * step).min(high);
            if to <= from {
                break;
            }
            let y = from.midpoint(to);
            if let Some((left, right)) = span(t, y) {
                sum += self.sum_along(level, y.floor() as i64, left, right) * (to - from);
                area += (right - left) * (to - from);
            }
            from = to;
        }
        if area > 0.0 { sum / area } else { DVec4::ZERO }
    }

    /// Sum over the stretch of row `y` between two distances from the left, in texels.
    fn sum_along(&self, level: usize, y: i64, left: f64, right: f64) -> DVec4 {
        let mut sum = DVec4::ZERO;
        let mut from = left;
        while from < right {
            let texel = from.floor();
            let to = (texel + 1.0).min(right);
            if to <= from {
                break;
            }
            sum += self.wrapped(level, texel as i64, y) * (to - from);
            from = to;
        }
        sum
    }

    /// Mean over a regular grid of points of the triangle, at full resolution.
    fn sum_of_points(&self, corners: [DVec2; 3]) -> DVec4 {
        let [width, height] = self.size(0).map(f64::from);
        let n = SPARSE_POINTS;
        let mut sum = DVec4::ZERO;
        for i in 0..n {
            for j in 0..n - i {
                let (u, v) = (f64::from(i) + 1.0 / 3.0, f64::from(j) + 1.0 / 3.0);
                let edges = [corners[1] - corners[0], corners[2] - corners[0]];
                let p = corners[0] + (edges[0] * u + edges[1] * v) / f64::from(n);
                let (x, y) = ((p.x * width).floor(), (p.y * height).floor());
                sum += self.wrapped(0, x as i64, y as i64);
            }
        }
        sum / (f64::from(n) * f64::from(n + 1) / 2.0)
    }

    /// What a camera sees at `uv` when a pixel is as wide as 2^`level` texels: linear in space and between levels.
    ///
    /// Linear colour, not multiplied by the coverage beside it.
    pub fn sample(&self, uv: DVec2, level: f64) -> TextureMean {
        let level = level.clamp(0.0, (self.level_count() - 1) as f64);
        let (fine, share) = (level.floor(), level.fract());
        let mut value = self.bilinear(fine as usize, uv);
        if share > 0.0 {
            value = value.lerp(self.bilinear(fine as usize + 1, uv), share);
        }
        mean_of(value)
    }

    /// What the nearest texel of the full resolution shows.
    pub fn nearest(&self, uv: DVec2) -> TextureMean {
        let [width, height] = self.size(0).map(f64::from);
        let (x, y) = ((uv.x * width).floor(), (uv.y * height).floor());
        mean_of(self.wrapped(0, x as i64, y as i64))
    }

    fn bilinear(&self, level: usize, uv: DVec2) -> DVec4 {
        let [width, height] = self.size(level).map(f64::from);
        let at = DVec2::new(uv.x * width - 0.5, uv.y * height - 0.5);
        let (low, t) = (at.floor(), at - at.floor());
        let texel = |i: i64, j: i64| {
            let (x, y) = (low.x as i64, low.y as i64);
            self.wrapped(level, x.saturating_add(i), y.saturating_add(j))
        };
        let upper = texel(0, 0).lerp(texel(1, 0), t.x);
        let lower = texel(0, 1).lerp(texel(1, 1), t.x);
        upper.lerp(lower, t.y)
    }
}

fn mean_of(sum: DVec4) -> TextureMean {
    let colour = if sum.w > 0.0 {
        sum.truncate() / sum.w
    } else {
        DVec4::ZERO.truncate()
    };
    TextureMean {
        colour: Rgb(colour.clamp(glam::DVec3::ZERO, glam::DVec3::ONE)),
        coverage: sum.w.clamp(0.0, 1.0),
    }
}

/// Where the horizontal line at `y` enters and leaves a triangle.
fn span(t: [DVec2; 3], y: f64) -> Option<(f64, f64)> {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..3 {
        let (a, b) = (t[k], t[(k + 1) % 3]);
        if (a.y <= y) != (b.y <= y) {
            let x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
            left = left.min(x);
            right = right.max(x);
        }
    }
    (left < right).then_some((left, right))
}

/// Which of `from` texels each of `to` ≤ `from` texels covers, and with what share of its own width.
struct Shares {
    from: u32,
    to: u32,
}

impl Shares {
    fn new(from: u32, to: u32) -> Self {
        Self { from, to }
    }

    fn of(&self, index: u32) -> impl Iterator<Item = (u32, f64)> + use<> {
        let (from, to) = (u64::from(self.from), u64::from(self.to));
        // In units of 1/to of a fine texel, everything is whole.
        let (start, end) = (u64::from(index) * from, u64::from(index + 1) * from);
        (start / to..end.div_ceil(to)).map(move |i| {
            let overlap = end.min((i + 1) * to) - start.max(i * to);
            (i as u32, overlap as f64 / from as f64)
        })
    }
}
