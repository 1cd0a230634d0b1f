//! Who looks, and what at.

use crate::geom::Plane;
use glam::DVec3;

/// A point that looks into the half-space in front of it.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Where it stands, metres, local.
    pub position: DVec3,
    /// The plane it lies in, normal towards the side it looks to.
    pub horizon: Plane,
    /// Unit normal that light is weighed by: that of the curved surface which the plane stands for. What is below the
    /// plane is hidden all the same, and what is behind this normal has no weight.
    pub shading: DVec3,
}

impl Viewpoint {
    /// A viewpoint at `position` on a surface with unit normal `normal`.
    pub fn new(position: DVec3, normal: DVec3) -> Self {
        Self {
            position,
            horizon: Plane::new(position, normal),
            shading: normal,
        }
    }

    /// The same on a plane that stands for a curved surface with unit normal `shading` there.
    pub fn on_curve(position: DVec3, normal: DVec3, shading: DVec3) -> Self {
        Self {
            shading,
            ..Self::new(position, normal)
        }
    }
}

/// One side of a convex polygon that is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// Corners, counter-clockwise seen from the side of `plane.normal`.
    pub corners: &'a [DVec3],
    /// Its plane, normal towards the side that is looked at.
    pub plane: Plane,
}
