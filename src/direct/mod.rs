//! Exact light straight from the emitters: faces that shine, and lights without a surface.

mod cell;
mod crowd;
mod emitters;
mod irradiance;
mod many;
mod outlook;
mod punctual;
mod stuck;
mod vantage;

pub use crowd::Look;
pub use emitters::{DirectLight, EmitterPolygon};
pub use irradiance::{edge_term, form_factor, form_factor_of_directions};
pub use outlook::Outlook;
pub use punctual::{cone_cosines, unoccluded_by};
pub use stuck::stuck_emitters;
pub use vantage::Vantage;
