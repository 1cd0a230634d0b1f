//! Form factors between polygons: what share of the light that leaves one arrives at the other.
//!
//! `F₁₂ = 1/A₁ ∫∫ G V dA₂ dA₁`, `G = cos θ₁ cos θ₂ / π r²`, `V` = 1 where nothing stands between. Which way it is computed
//! depends on the pair:
//!
//! | pair | way | error |
//! |---|---|---|
//! | point and polygon | Lambert's formula ([`form_factor`](crate::direct::form_factor)) | round-off |
//! | parallel edges of two polygons in full view, touching ones included | closed form of the double line integral | round-off |
//! | other edges | one line integral in closed form, the other by Gauss on pieces | proven bound |
//! | edges far from each other | Gauss on both | proven bound |
//! | polygons that something hides parts of from each other | the visible part is exact at every point ([`Scratch::visible_pieces`](crate::visibility::Scratch::visible_pieces)), Gauss over the points, divided where two levels differ | estimate |
//!
//! Rectangles with parallel and perpendicular edges are therefore exact (perpendicular edges add nothing). All are
//! symmetric, `A₁ F₁₂ = A₂ F₂₁`, to the last bit: it is the exchange `A₁ F₁₂` that is computed, for both orders the same way.
//!
//! ```
//! use glam::DVec3;
//! use umbrage::form_factor::{FLAT, Patch, between};
//!
//! let square = |y: f64, up: bool| {
//!     let mut corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]
//!         .map(|(x, z)| DVec3::new(x, y, z));
//!     if !up {
//!         corners.reverse();
//!     }
//!     Patch::new(&corners, FLAT)
//! };
//! let (floor, ceiling) = (square(0.0, true)?, square(1.0, false)?);
//! let f = between(&floor, &ceiling, 1e-12).from_first();
//! assert!((f.value - 0.199_824_895_7).abs() < 1e-10);
//! # Ok::<(), umbrage::bad_input::BadInput>(())
//! ```
//!
//! Papers: Lambert, *Photometria* (1760); Sparrow, *A new and simpler formulation for radiative angle factors* (1963), for
//! the contour integral; Baum, Rushmeier & Winget, *Improving radiosity solutions through the use of analytically determined
//! form-factors* (1989), for one of its integrals in closed form. Schröder & Hanrahan, *On the form factor between two
//! polygons* (1993), have both in closed form, with dilogarithms of many branches; here the second one is a quadrature whose
//! error is proven, which is as exact and has no branches.

mod contour;
mod edge_pair;
mod matrix;
mod obstructed;
mod patch;
mod rule;
#[cfg(test)]
mod tests;

pub use contour::between;
pub use matrix::FormFactors;
pub use obstructed::past;
pub use patch::{FLAT, Patch};
pub(crate) use rule::RADON;

/// A form factor and how far it may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormFactor {
    /// 0…1.
    pub value: f64,
    /// The largest error of `value`, round-off included.
    pub error: f64,
    /// Whether `error` is proven; else it is an estimate.
    pub is_proven: bool,
}

/// What two patches exchange: their common area `A₁ F₁₂ = A₂ F₂₁`, m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// `A₁ F₁₂`, m².
    pub area: f64,
    /// The largest error of `area`, m².
    pub error: f64,
    /// Whether `error` is proven; else it is an estimate.
    pub is_proven: bool,
    /// Areas of the two patches, m².
    areas: [f64; 2],
}

impl Exchange {
    /// No larger than what either patch can send, no less than nothing.
    fn new(area: f64, error: f64, is_proven: bool, areas: [f64; 2]) -> Self {
        let most = areas[0].min(areas[1]);
        Self {
            area: area.clamp(0.0, most),
            error: error.min(most),
            is_proven,
            areas,
        }
    }

    /// The share of the light leaving the first patch that arrives at the second.
    pub fn from_first(&self) -> FormFactor {
        self.over(self.areas[0])
    }

    /// The share of the light leaving the second patch that arrives at the first.
    pub fn from_second(&self) -> FormFactor {
        self.over(self.areas[1])
    }

    fn over(&self, area: f64) -> FormFactor {
        FormFactor {
            value: self.area / area,
            error: self.error / area,
            is_proven: self.is_proven,
        }
    }
}
