//! The planar kernel of meshing: breaks on one face become triangles with labelled edges.

mod grid;

pub use grid::{Grid, GridPoint, orient};
