//! Who hides whom: convex blockers in a tree, and the part of a polygon that a point sees.

mod backprojection;
mod blockers;
mod box_tree;
mod cone;
mod hidden;
mod pieces;
#[cfg(test)]
mod random;
mod ray;
mod ray_tree;
mod region;
mod screen;
mod shadow;
mod shaft;
mod solid;
mod view;

pub(crate) use backprojection::FEW_SCREENS;
pub use backprojection::{Scratch, Screening, Seen};
pub use blockers::{Blockers, Part};
pub use box_tree::BoxTree;
pub(crate) use cone::clip_to_front;
pub use cone::{Ball, Cone, Cones, Relation};
pub use ray::{Hit, RayCaster};
pub use region::Region;
pub use shaft::{Shaft, Sight};
pub use view::{Target, Viewpoint};
