//! Planes, and the right-handed 2D frame that each face is meshed in.

use glam::{DVec2, DVec3};

/// The plane `n · x = d`, `n` of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: DVec3,
    /// Distance of the plane from the frame's origin along the normal, metres.
    pub offset: f64,
}

impl Plane {
    /// The plane through `point` with unit normal `normal`.
    pub fn new(point: DVec3, normal: DVec3) -> Self {
        Self {
            normal,
            offset: normal.dot(point),
        }
    }

    /// Signed distance of `p`, metres, positive on the side of the normal.
    #[inline]
    pub fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// A plane with an orthonormal, right-handed frame: `u × v = n`, `n` towards the front of the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneFrame {
    /// Where (0, 0) lies.
    pub origin: DVec3,
    /// First axis, unit.
    pub u: DVec3,
    /// Second axis, unit.
    pub v: DVec3,
    /// Unit normal.
    pub n: DVec3,
}

impl PlaneFrame {
    /// A frame at `origin` with unit normal `n`; `u` is chosen from the world axis least aligned with `n`.
    pub fn new(origin: DVec3, n: DVec3) -> Self {
        let a = n.abs();
        let axis = if a.x <= a.y && a.x <= a.z {
            DVec3::X
        } else if a.y <= a.z {
            DVec3::Y
        } else {
            DVec3::Z
        };
        let u = axis.cross(n).normalize();
        Self {
            origin,
            u,
            v: n.cross(u),
            n,
        }
    }

    /// Coordinates of the foot of `p` in this frame, metres.
    pub fn to_plane(&self, p: DVec3) -> DVec2 {
        let d = p - self.origin;
        DVec2::new(d.dot(self.u), d.dot(self.v))
    }

    /// The point of the plane with frame coordinates `q`.
    pub fn to_space(&self, q: DVec2) -> DVec3 {
        self.origin + self.u * q.x + self.v * q.y
    }

    /// The plane without its frame.
    pub fn plane(&self) -> Plane {
        Plane::new(self.origin, self.n)
    }
}
