//! Exact light straight from the emitters.

mod emitters;
mod irradiance;

pub use emitters::{DirectLight, EmitterPolygon};
pub use irradiance::{form_factor, form_factor_of_directions};
