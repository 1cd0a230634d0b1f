//! Numbers and shapes: exact signs, planes with their own 2D frames, polygons. Knows no scene.

mod affine;
mod plane;
mod polygon;
pub mod predicates;

pub use affine::AffineMap;
pub use plane::{Plane, PlaneFrame};
pub use polygon::{Polygon2, loop_area, newell_normal};
