//! What the tests share: fixtures, and references that reach the answers by other roads than the library.

pub(crate) mod bake;
pub(crate) mod events;
pub(crate) mod fine_field;
pub(crate) mod kinks;
pub(crate) mod library;
pub(crate) mod obj_lite;
pub(crate) mod path_tracer;
mod picture;
pub(crate) mod quadrature;
pub(crate) mod reference;
pub(crate) mod rng;
pub(crate) mod scenes;
pub(crate) mod tables;
