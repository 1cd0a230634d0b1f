//! The pixel grid of one face: plane coordinates in metres ↔ whole pixels, and exact signs on it.

use glam::DVec2;

/// Bits of a coordinate of a face's own box: `|x|, |y| ≤ 2²⁵` pixels from the grid's origin.
///
/// One more bit is left for what sticks out of the box, so that every kernel function may rely on
/// [`LIMIT`]. Then differences stay below 2²⁷ and `orient` below 2⁵⁵: exact in `i64`, and with room
/// to compare doubled values; coordinates are exact in `f64` too.
const BOX_BITS: i32 = 25;

/// Largest coordinate, in pixels, that the kernel is proven for (2²⁶).
pub(super) const LIMIT: i64 = 1 << (BOX_BITS + 1);

/// A point of a face's grid, in pixels; ordered by `x`, then `y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GridPoint {
    /// Pixels along the frame's first axis.
    pub x: i64,
    /// Pixels along the frame's second axis.
    pub y: i64,
}

impl GridPoint {
    /// The point `(x, y)`.
    pub const fn new(x: i64, y: i64) -> Self {
        Self { x, y }
    }
}

/// Twice the signed area of the triangle `a b c` in square pixels, exactly: positive when counter-clockwise.
pub fn orient(a: GridPoint, b: GridPoint, c: GridPoint) -> i64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Maps a face's frame coordinates to grid points: an origin, and a pixel whose size is a power of two.
///
/// The power of two makes pixel → metres a mere change of exponent, so that a snapped point has one
/// position and not one per rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    origin: DVec2,
    pixel: f64,
}

impl Grid {
    /// The grid for a face with the bounding box `lo..hi` (metres, finite): its coordinates are at most 2²⁵ pixels.
    ///
    /// A pixel is at most 2⁻²⁵ (3·10⁻⁸) of the longer side of the box. A box without extent gets
    /// a grid as for one of a metre: all its points are the same anyway.
    pub fn around(lo: DVec2, hi: DVec2) -> Self {
        let half = 0.5 * (hi - lo).max_element();
        let half = if half >= f64::MIN_POSITIVE { half } else { 0.5 };
        // The exponent field gives the power of two just above `half` without a rounded logarithm.
        let exponent = (half.to_bits() >> 52) as i32 - 1023 + 1 - BOX_BITS;
        let pixel = power_of_two(exponent);
        // An origin on a multiple of the pixel keeps the way back to metres exact as well, unless
        // the box lies more than 2⁵³ pixels from the frame's origin.
        let origin = ((0.5 * (lo + hi)) / pixel).round() * pixel;
        Self { origin, pixel }
    }

    /// Side of a pixel, metres.
    pub fn pixel_size(&self) -> f64 {
        self.pixel
    }

    /// The pixel that `p` (metres) lies in; a pixel is half-open, `[x − ½, x + ½)`, so ties go up.
    ///
    /// Points up to half the box outside it are fine; farther out is a mistake of the caller.
    pub fn snap(&self, p: DVec2) -> GridPoint {
        let q = (p - self.origin) / self.pixel;
        let point = GridPoint::new(ties_up(q.x), ties_up(q.y));
        debug_assert!(
            point.x.abs() <= LIMIT && point.y.abs() <= LIMIT,
            "{p} lies far outside the grid's box"
        );
        point
    }

    /// The centre of the pixel `g` in frame coordinates, metres.
    pub fn to_plane(&self, g: GridPoint) -> DVec2 {
        self.origin + DVec2::new(g.x as f64, g.y as f64) * self.pixel
    }
}

/// Nearest whole number, `½` going up; `floor(v + ½)` would lift the largest number below `½` to 1.
fn ties_up(v: f64) -> i64 {
    let floor = v.floor();
    floor as i64 + i64::from(v - floor >= 0.5)
}

/// 2 to the power of `exponent`, clamped to the normal numbers.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent.clamp(-1022, 1023) + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_fine_and_the_box_fits() {
        for size in [1e-9, 1e-3, 0.999, 1.0, 1.001, 2.0, 3.7, 1e4] {
            for at in [DVec2::ZERO, DVec2::new(-3.3 * size, 17.1 * size)] {
                let (lo, hi) = (at, at + DVec2::new(size, 0.3 * size));
                let grid = Grid::around(lo, hi);
                assert!(grid.pixel_size() <= 1e-7 * size, "{size}");
                for p in [lo, hi, 0.5 * (lo + hi)] {
                    let g = grid.snap(p);
                    assert!(g.x.abs() <= LIMIT / 2 && g.y.abs() <= LIMIT / 2, "{g:?}");
                    let error = (grid.to_plane(g) - p).abs().max_element();
                    assert!(error <= 0.5 * grid.pixel_size(), "{error}");
                    assert_eq!(grid.snap(grid.to_plane(g)), g);
                }
            }
        }
    }

    #[test]
    fn ties_go_up_on_both_sides_of_zero() {
        let below_half = 0.499_999_999_999_999_94;
        for (v, want) in [
            (0.5, 1),
            (-0.5, 0),
            (-1.5, -1),
            (below_half, 0),
            (-0.51, -1),
        ] {
            assert_eq!(ties_up(v), want, "{v}");
        }
    }

    #[test]
    fn a_box_without_extent_still_has_a_grid() {
        let p = DVec2::new(3.0, -2.0);
        let grid = Grid::around(p, p);
        assert_eq!(grid.to_plane(grid.snap(p)), p);
    }

    #[test]
    fn orient_is_exact_at_the_limit() {
        let (a, b) = (GridPoint::new(-LIMIT, -LIMIT), GridPoint::new(LIMIT, LIMIT));
        assert_eq!(orient(a, b, GridPoint::new(0, 0)), 0);
        assert_eq!(orient(a, b, GridPoint::new(0, 1)), 2 * LIMIT);
        let c = GridPoint::new(-LIMIT, LIMIT);
        assert_eq!(orient(a, b, c), 4 * LIMIT * LIMIT);
    }
}
