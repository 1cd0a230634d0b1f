//! umbrage bakes light into meshes.

pub mod bad_input;
pub mod geom;
pub mod lit_scene;
pub mod quantity;
pub mod scene;
pub mod warning;
