//! Points that fill a square, a triangle or a polygon evenly, each sequence as long as it is needed.

use glam::{DVec2, DVec3};
use std::ops::{Add, Mul};

/// Fractional parts of the generalised golden ratio's powers (Roberts 2018): a sequence that fills the square evenly.
const R2: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

/// Point `i` of a sequence that fills the unit square evenly.
pub(crate) fn even_point(i: u32) -> DVec2 {
    DVec2::from(R2.map(|r| (0.5 + r * f64::from(i + 1)).fract()))
}

/// Point `i` of a sequence that fills a triangle evenly.
pub(crate) fn even_point_in<P>(corners: [P; 3], i: u32) -> P
where
    P: Mul<f64, Output = P> + Add<Output = P>,
{
    mapped(corners, even_point(i))
}

/// Point `i` of a sequence that fills a convex polygon evenly.
pub(crate) fn even_point_of(corners: &[DVec3], i: u32) -> DVec3 {
    let triangle = |k: usize| [corners[0], corners[k], corners[k + 1]];
    let area = |k: usize| {
        let [a, b, c] = triangle(k);
        (b - a).cross(c - a).length()
    };
    let fan = 1..corners.len() - 1;
    let all: f64 = fan.clone().map(area).sum();
    let at = even_point(i);
    // Each triangle of the fan has the points of a strip of the square, as wide as its share of the area.
    let mut left = at.x * all;
    for k in fan.clone() {
        let own = area(k);
        if left < own || k + 1 == fan.end {
            return mapped(triangle(k), DVec2::new((left / own).min(1.0), at.y));
        }
        left -= own;
    }
    corners[0]
}

/// The triangle's point for a point of the unit square; areas stay in proportion.
fn mapped<P>([a, b, c]: [P; 3], at: DVec2) -> P
where
    P: Mul<f64, Output = P> + Add<Output = P>,
{
    let root = at.x.sqrt();
    a * (1.0 - root) + b * (root * (1.0 - at.y)) + c * (root * at.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_of_a_polygon_fill_it_evenly() {
        let corners = [(0.0, 0.0), (4.0, 0.0), (5.0, 2.0), (1.0, 3.0)].map(|(x, y)| {
            // Somewhere in space.
            DVec3::new(x, y, 0.5 * x - y)
        });
        let points: Vec<DVec3> = (0..4000).map(|i| even_point_of(&corners, i)).collect();
        // What lies left of x = 2, of the points and of the area: a triangle and a trapezium.
        let share = points.iter().filter(|p| p.x < 2.0).count() as f64 / 4000.0;
        let left = 0.5 * 3.0 + 0.5 * (3.0 + 2.75);
        let area = 0.5 * (4.0 * 2.0 + (5.0 * 3.0 - 1.0 * 2.0));
        assert!(
            (share - left / area).abs() < 0.005,
            "{share} {}",
            left / area
        );
        // A point is a sum of a few products of coordinates of up to five.
        let round_off = 16.0 * 5.0 * f64::EPSILON;
        assert!(
            points
                .iter()
                .all(|p| (p.z - (0.5 * p.x - p.y)).abs() < round_off)
        );
        assert!(points.iter().all(|p| p.y >= 0.0 && p.y <= 3.0));
    }
}
