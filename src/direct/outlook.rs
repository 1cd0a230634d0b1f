//! What a face so small that it makes no difference sees of the emitters: at all its points the same share of each.
//!
//! What is visible of an emitter is by far the dearest thing to know about it, and changes the least from one end of a bolt
//! to the other. How much light it would give if nothing hid it is cheap, and goes on changing: so a bolt is as round as
//! ever, and only the rim of a shadow across it is left out.

use super::DirectLight;
use super::emitters::unoccluded_factor;
use super::punctual::irradiance_by;
use super::vantage::Vantage;
use crate::quantity::Irradiance;
use crate::visibility::{Scratch, Viewpoint};
use smallvec::SmallVec;

/// The share of each emitter that is seen.
#[derive(Clone, Debug, Default)]
pub struct Outlook {
    /// Numbers of the polygons of which anything is seen, and the share, 0…1.
    seen: SmallVec<[(u32, f64); 2]>,
    /// What the light may be off by elsewhere on the face because some emitters are seen in part, squared, (W/m²)².
    pub doubt: f64,
}

impl DirectLight<'_> {
    /// What is seen from `view`, the middle of a small face; as good as [`DirectLight::look_within`] `tolerance`, with the same
    /// `vantage`.
    pub fn outlook(
        &self,
        view: &Viewpoint,
        vantage: Option<&Vantage>,
        tolerance: f64,
        scratch: &mut Scratch,
    ) -> Outlook {
        let prospects = self.prospects(view, vantage, scratch);
        let factors = self.factors(&prospects, tolerance, view, scratch);
        let mut outlook = Outlook::default();
        for (p, factor) in prospects.iter().zip(factors) {
            if factor.value <= 0.0 {
                continue;
            }
            let share = (factor.value / p.factor).min(1.0);
            outlook.seen.push((p.number, share));
            outlook.doubt += (share * (1.0 - share) * p.light).powi(2);
        }
        outlook
    }

    /// Irradiance at `view` from what `outlook` says is seen of the emitters, W/m².
    pub fn irradiance_through(
        &self,
        outlook: &Outlook,
        view: &Viewpoint,
        scratch: &mut Scratch,
    ) -> Irradiance {
        let mut sum = Irradiance::ZERO;
        for &(number, share) in &outlook.seen {
            let polygon = &self.polygons[number as usize];
            let factor = unoccluded_factor(polygon, self.blockers, view, scratch);
            sum += Irradiance(polygon.exitance.0 * (share * factor));
        }
        for light in &self.lights {
            sum += irradiance_by(light, self.blockers, view);
        }
        sum
    }
}
