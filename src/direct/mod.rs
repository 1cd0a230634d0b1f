//! Exact light straight from the emitters.

mod emitters;
mod irradiance;
mod many;

pub use emitters::{DirectLight, EmitterPolygon};
pub use irradiance::{edge_term, form_factor, form_factor_of_directions};
