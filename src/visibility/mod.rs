//! Who hides whom: convex blockers in a tree, and the part of a polygon that a point sees.

mod blockers;
mod box_tree;
mod cone;
mod ray;
mod region;

pub use blockers::{Blockers, Part};
pub use box_tree::BoxTree;
pub use cone::{Cone, Cones, Relation, Scratch, Target, Viewpoint};
pub use ray::{Hit, RayCaster};
pub use region::Region;
