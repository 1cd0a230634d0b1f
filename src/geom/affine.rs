//! Quantities that vary linearly over a plane.

use glam::DVec3;

/// `N` numbers that vary linearly along a plane: texture coordinates, shading normals.
///
/// Constant across the plane, so that a point a rounding off it has the value of its foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AffineMap<const N: usize> {
    origin: DVec3,
    start: [f64; N],
    gradients: [DVec3; N],
}

impl<const N: usize> AffineMap<N> {
    /// The map that has `values` at the corners of a triangle; `None` when the corners lie on one line.
    pub fn through(corners: [DVec3; 3], values: [[f64; N]; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let (p, q) = (b - a, c - a);
        let normal = p.cross(q);
        let square = normal.length_squared();
        // The gradient g in the plane of p and q with g·p = dp, g·q = dq.
        let (along_p, along_q) = (q.cross(normal) / square, normal.cross(p) / square);
        let gradients = std::array::from_fn(|i| {
            along_p * (values[1][i] - values[0][i]) + along_q * (values[2][i] - values[0][i])
        });
        let map = Self {
            origin: a,
            start: values[0],
            gradients,
        };
        (square > 0.0 && map.gradients.iter().all(|g| g.is_finite())).then_some(map)
    }

    /// The value at `p`.
    pub fn at(&self, p: DVec3) -> [f64; N] {
        let d = p - self.origin;
        std::array::from_fn(|i| self.start[i] + self.gradients[i].dot(d))
    }

    /// How fast the values change, one vector in the plane for each, per metre.
    pub fn gradients(&self) -> [DVec3; N] {
        self.gradients
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_has_its_values_at_the_corners_and_is_linear_between() {
        let corners = [
            DVec3::new(1.0, 2.0, 3.0),
            DVec3::new(4.0, 2.5, 3.0),
            DVec3::new(1.5, 2.0, 9.0),
        ];
        let values = [[0.25, -1.0], [0.75, 3.0], [0.0, 0.5]];
        let map = AffineMap::through(corners, values).expect("the corners span a plane");
        for (corner, value) in corners.iter().zip(values) {
            for (found, wanted) in map.at(*corner).iter().zip(value) {
                assert!((found - wanted).abs() < 1e-14);
            }
        }
        let middle = map.at(corners[0].midpoint(corners[1]));
        assert!((middle[0] - 0.5).abs() < 1e-14 && (middle[1] - 1.0).abs() < 1e-14);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        assert!(map.gradients().iter().all(|g| g.dot(normal).abs() < 1e-12));
    }

    #[test]
    fn a_line_carries_no_map() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert_eq!(AffineMap::through(corners, [[0.0], [1.0], [2.0]]), None);
    }
}
