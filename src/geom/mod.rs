//! Numbers and shapes: exact signs, planes with their own 2D frames, polygons, ruled quadrics. Knows no scene.

mod affine;
mod bounds;
mod even;
mod plane;
mod polygon;
pub mod predicates;
mod quadric;

pub use affine::AffineMap;
pub(crate) use bounds::bounds;
pub(crate) use even::{even_point, even_point_in, even_point_of};
pub use plane::{Plane, PlaneFrame};
pub use polygon::{Polygon2, convex_hull, loop_area, newell_normal};
pub use quadric::{ConicArc, Regulus, Ruling};
