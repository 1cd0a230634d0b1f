//! How far the values on one side of a face are off.

use super::{FieldFace, Uniform};
use glam::DVec2;

/// What the points of a small face do not tell of how it varies, as a share of its value.
const UNIFORM_VARIATION: f64 = 0.1;

/// Linear interpolation is off by at most this share of the range of the corners, unless light breaks inside.
const LINEAR_SHARE: f64 = 0.25;

/// Quadratic interpolation is off by about this share of what it adds to linear interpolation: with a fifth, and .08 where it was
/// probed, the fields of three Cornell boxes were off by 1.3 to 1.6 times their estimate.
const QUADRATIC_SHARE: f64 = 0.3;

/// And by no less than this share of it, however good one gather in the middle finds it.
const PROBED_SHARE: f64 = 0.12;

/// Weight of the error found in the middle of an element: of the 7-point rule, corners and edge midpoints being exact.
const CENTRE_WEIGHT: f64 = 9.0 / 20.0;

impl Uniform {
    /// Mean square of what it does not tell.
    pub(super) fn unseen(&self) -> f64 {
        UNIFORM_VARIATION * UNIFORM_VARIATION * self.value.0.mean_square()
    }
}

impl FieldFace {
    /// Estimated integrals of the squared error: of the whole face when it has one value, else of each element.
    pub(in crate::radiosity) fn errors(&self) -> Vec<f64> {
        if let Some(uniform) = self.uniform {
            return vec![self.area() * (uniform.variance + uniform.unseen())];
        }
        (0..self.known.len()).map(|e| self.error(e)).collect()
    }

    /// The same of one element.
    pub(super) fn error(&self, e: usize) -> f64 {
        let known = &self.known[e];
        let corners = self.corners(e);
        let mut square = 0.0_f64;
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let part = match self.at_middle(e, k) {
                None => LINEAR_SHARE * LINEAR_SHARE * (a - b).0.mean_square(),
                Some(m) => {
                    let share = match known.centre {
                        Some(_) => PROBED_SHARE,
                        None => QUADRATIC_SHARE,
                    };
                    share * share * (m - (a + b) * 0.5).0.mean_square()
                }
            };
            square = square.max(part);
        }
        let centre = known.centre.map_or(0.0, |c| CENTRE_WEIGHT * c);
        let inherited = known.inherited.map_or(0.0, |i| i.error);
        self.mesh.area(e) * square.max(centre).max(inherited)
    }

    /// Estimated RMS error over the element that holds frame coordinates `p`, W/m².
    pub(in crate::radiosity) fn error_at(&self, p: DVec2) -> f64 {
        match self.locator.locate(&self.mesh, p) {
            Some(_) if self.uniform.is_some() => (self.errors()[0] / self.area()).sqrt(),
            Some((e, _)) => (self.error(e) / self.mesh.area(e)).sqrt(),
            None => 0.0,
        }
    }
}
