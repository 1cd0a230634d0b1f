//! Exact signs (Shewchuk 97, by the crate `robust`): the only place where geometry decides a side in world coordinates.

use glam::{DVec2, DVec3};

/// On which side of a directed line or plane a point lies, exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Left of the line `a → b`; for a plane, the side from which `a b c` turn clockwise (below).
    Left,
    /// Exactly on it.
    On,
    /// Right of the line; for a plane, the side from which `a b c` turn counter-clockwise (above).
    Right,
}

impl Side {
    fn from_sign(sign: f64) -> Self {
        if sign > 0.0 {
            Self::Left
        } else if sign < 0.0 {
            Self::Right
        } else {
            Self::On
        }
    }
}

/// The side of the directed line `a → b` on which `p` lies.
pub fn side_of_line(a: DVec2, b: DVec2, p: DVec2) -> Side {
    let c = |v: DVec2| robust::Coord { x: v.x, y: v.y };
    Side::from_sign(robust::orient2d(c(a), c(b), c(p)))
}

/// The side of the plane through `a b c` on which `p` lies.
///
/// `Right` is the side towards which the normal `(b − a) × (c − a)` points.
pub fn side_of_plane(a: DVec3, b: DVec3, c: DVec3, p: DVec3) -> Side {
    let k = |v: DVec3| robust::Coord3D {
        x: v.x,
        y: v.y,
        z: v.z,
    };
    Side::from_sign(robust::orient3d(k(a), k(b), k(c), k(p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_points_to_the_right_side() {
        let (a, b, c) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        assert_eq!(side_of_plane(a, b, c, DVec3::Z), Side::Right);
        assert_eq!(side_of_plane(a, b, c, -DVec3::Z), Side::Left);
        assert_eq!(side_of_plane(a, b, c, DVec3::new(3.0, 7.0, 0.0)), Side::On);
    }

    #[test]
    fn left_of_a_line_is_counter_clockwise() {
        assert_eq!(
            side_of_line(DVec2::ZERO, DVec2::X, DVec2::new(0.5, f64::MIN_POSITIVE)),
            Side::Left
        );
    }
}
