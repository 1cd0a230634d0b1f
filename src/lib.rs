//! umbrage bakes light into meshes.

pub mod adapt;
pub mod bad_input;
pub mod compare;
pub mod direct;
pub mod discontinuity;
pub mod geom;
pub mod io;
pub mod lit_scene;
pub mod mesh;
pub mod pipeline;
pub mod quantity;
pub mod radiosity;
pub mod render;
pub mod scene;
pub mod settings;
pub mod visibility;
pub mod warning;
