//! What must not change when the scene is turned, moved, scaled, reordered or made brighter.

mod bakes;
mod direct;
mod moved;
