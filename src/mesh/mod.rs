//! The planar kernel of meshing: breaks on one face become triangles with labelled edges.
//!
//! ```text
//! outline, breaks, points (metres)                       Grid::snap
//!   → Segment, GridPoint (whole pixels)                  arrange
//!   → Arrangement: planar graph, each edge knows its sources   triangulate
//!   → Triangulation of the convex hull                   inside, regions, sectors
//!   → which triangles belong to the face, which touch across a break, where values live
//! ```
//!
//! Everything after `Grid::snap` is decided on whole numbers, so no step can contradict another:
//! two segments cross or they do not, for good. The price is that a line moves by a few pixels
//! (a pixel is at most 3·10⁻⁸ of the face), a drift that the tests measure.
//!
//! Papers: D. Halperin and E. Packer, *Iterated snap rounding*, 2002, for the arrangement;
//! J. D. Hobby, *Practical segment intersection with finite precision output*, 1999, for why a
//! rounded arrangement has no new crossings.

mod arrangement;
mod cdt;
mod domain;
mod grid;
mod inset;
mod receiver;
#[cfg(test)]
mod tests;

pub use arrangement::{ArrangedEdge, Arrangement, Segment, arrange};
pub use cdt::{MeshError, Sites, Triangulation, inside, regions, sectors, triangulate};
pub use domain::{EdgeSource, FaceDomain};
pub use grid::{Grid, GridPoint, orient};
pub use inset::Inset;
pub use receiver::{ReceiverMesh, VertexOrigin, barycentric};
