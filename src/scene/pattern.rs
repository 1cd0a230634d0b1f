//! What a textured face reflects, place by place.
//!
//! Light between surfaces does not see texels, but a carpet with a white half lights the wall beside that half. The face's
//! bounding rectangle is divided into squares; each has the mean of the texture over it, and between their middles the
//! reflectance is linear.

use crate::quantity::Rgb;
use glam::DVec2;

/// Reflectance over a face, in the coordinates of its frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    low: DVec2,
    /// Size of a cell, metres.
    cell: DVec2,
    columns: usize,
    /// Row by row from the lowest corner.
    values: Vec<Rgb>,
}

impl Pattern {
    /// The means that `mean` gives over parallelograms (corners in turn, frame coordinates) of about `spacing` metres, at
    /// most `most` along each side of the rectangle from `low` to `high`. None when one cell is enough, or when nowhere it
    /// departs from `whole` by more than `least`.
    pub fn new(
        [low, high]: [DVec2; 2],
        spacing: f64,
        most: u32,
        (whole, least): (Rgb, f64),
        mean: impl Fn([DVec2; 4]) -> Rgb,
    ) -> Option<Self> {
        let count = ((high - low) / spacing).ceil();
        let [columns, rows] = [count.x, count.y].map(|n| (n as u32).clamp(1, most) as usize);
        if columns * rows < 2 {
            return None;
        }
        let cell = (high - low) / DVec2::new(columns as f64, rows as f64);
        let corner = |i: usize, j: usize| low + cell * DVec2::new(i as f64, j as f64);
        let values: Vec<Rgb> = (0..rows * columns)
            .map(|k| (k % columns, k / columns))
            .map(|(i, j)| {
                mean([
                    corner(i, j),
                    corner(i + 1, j),
                    corner(i + 1, j + 1),
                    corner(i, j + 1),
                ])
            })
            .collect();
        let departs = |v: &Rgb| (v.0 - whole.0).abs().max_element() > least;
        values.iter().any(departs).then_some(Self {
            low,
            cell,
            columns,
            values,
        })
    }

    /// The reflectance at frame coordinates `p`; beyond the middles of the outermost cells it is theirs.
    pub fn at(&self, p: DVec2) -> Rgb {
        let rows = self.values.len() / self.columns;
        let last = DVec2::new((self.columns - 1) as f64, (rows - 1) as f64);
        let place = ((p - self.low) / self.cell - 0.5).clamp(DVec2::ZERO, last);
        let (base, share) = (place.floor(), place.fract());
        let (i, j) = (base.x as usize, base.y as usize);
        let value = |i: usize, j: usize| {
            self.values[j.min(rows - 1) * self.columns + i.min(self.columns - 1)].0
        };
        let low = value(i, j).lerp(value(i + 1, j), share.x);
        let high = value(i, j + 1).lerp(value(i + 1, j + 1), share.x);
        Rgb(low.lerp(high, share.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reflectance that is the mean of the four corners' x.
    fn ramp(most: u32) -> Option<Pattern> {
        let mean = |corners: [DVec2; 4]| Rgb::grey(corners.iter().map(|c| c.x).sum::<f64>() / 4.0);
        let rectangle = [DVec2::ZERO, DVec2::new(1.0, 0.5)];
        Pattern::new(rectangle, 0.1, most, (Rgb::grey(0.5), 0.01), mean)
    }

    #[test]
    fn a_ramp_is_a_ramp_between_the_outermost_middles() {
        let pattern = ramp(64).expect("a pattern");
        for (x, y) in [(0.05, 0.1), (0.3, 0.0), (0.512, 0.5), (0.95, 0.25)] {
            let found = pattern.at(DVec2::new(x, y)).mean();
            assert!((found - x).abs() < 1e-12, "{found} at {x}");
        }
        assert!((pattern.at(DVec2::new(-3.0, 9.0)).mean() - 0.05).abs() < 1e-12);
        assert!((pattern.at(DVec2::new(1.0, 0.2)).mean() - 0.95).abs() < 1e-12);
    }

    #[test]
    fn there_is_none_where_the_mean_says_it_all() {
        assert!(ramp(1).is_none());
        let even = |_: [DVec2; 4]| Rgb::grey(0.505);
        let rectangle = [DVec2::ZERO, DVec2::ONE];
        assert!(Pattern::new(rectangle, 0.1, 64, (Rgb::grey(0.5), 0.01), even).is_none());
    }
}
