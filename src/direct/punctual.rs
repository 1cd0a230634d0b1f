//! Lights without a surface: the limit of an emitter that vanishes, or that is infinitely far away.
//!
//! ```text
//!   point         E = I cos θ / r²
//!   spot          E = I a² cos θ / r²,  a = clamp((cos φ − cos φₒ) / max(0.001, cos φᵢ − cos φₒ), 0, 1)
//!   directional   E = E₀ cos θ
//! ```
//!
//! with `I` the radiant intensity, `r` the distance, `θ` the angle to the surface's normal, `φ` to the spot's axis, `φᵢ` and `φₒ`
//! its inner and outer angle: the formula that `KHR_lights_punctual` gives. What lies between hides all of it, so its
//! shadows have no penumbra. The `range` of the file is a leave to cut light off, which an exact evaluation does not take.

use crate::quantity::Irradiance;
use crate::scene::{PunctualKind, PunctualLight};
use crate::visibility::{Blockers, Viewpoint};
use glam::DVec3;

/// The cosines of a spot's angles are taken to differ by this much at least, as the extension has it.
const LEAST_COSINE_STEP: f64 = 0.001;

/// The way of a ray to a light.
struct Way {
    /// From the viewpoint to the light; a unit vector where it is infinitely far.
    towards: DVec3,
    is_far: bool,
}

/// Irradiance at `view` as if nothing hid the light, W/m².
pub fn unoccluded_by(light: &PunctualLight, view: &Viewpoint) -> Irradiance {
    arriving(light, view).map_or(Irradiance::ZERO, |(e, _)| e)
}

/// Irradiance at `view`, W/m²: all of it or nothing.
///
/// Faces within the weld distance of the plane of `view`, or of the light, hide nothing.
pub(super) fn irradiance_by(
    light: &PunctualLight,
    blockers: &Blockers,
    view: &Viewpoint,
) -> Irradiance {
    match arriving(light, view) {
        Some((e, way)) if !is_hidden(blockers, view, &way) => e,
        _ => Irradiance::ZERO,
    }
}

fn arriving(light: &PunctualLight, view: &Viewpoint) -> Option<(Irradiance, Way)> {
    let (towards, is_far) = match light.kind {
        PunctualKind::Directional => (-light.direction, true),
        PunctualKind::Point | PunctualKind::Spot { .. } => (light.position - view.position, false),
    };
    if view.horizon.normal.dot(towards) <= 0.0 {
        return None;
    }
    let direction = towards.try_normalize()?;
    let cosine = view.shading.dot(direction).max(0.0);
    let spread = if is_far {
        1.0
    } else {
        spot_share(light, -direction) / towards.length_squared()
    };
    let share = cosine * spread;
    (share > 0.0).then(|| {
        let arriving = Irradiance(light.intensity * share);
        (arriving, Way { towards, is_far })
    })
}

/// The share of its intensity that a light sends into a direction (unit).
fn spot_share(light: &PunctualLight, direction: DVec3) -> f64 {
    let Some([full, none]) = cone_cosines(light) else {
        return 1.0;
    };
    let a = (light.direction.dot(direction) - none) / (full - none);
    a.clamp(0.0, 1.0).powi(2)
}

/// The cosines of the angles from a spot's axis up to which it shines fully, and from which on not at all.
pub fn cone_cosines(light: &PunctualLight) -> Option<[f64; 2]> {
    let PunctualKind::Spot {
        inner_angle_rad,
        outer_angle_rad,
    } = light.kind
    else {
        return None;
    };
    let none = outer_angle_rad.cos();
    Some([inner_angle_rad.cos().max(none + LEAST_COSINE_STEP), none])
}

fn is_hidden(blockers: &Blockers, view: &Viewpoint, way: &Way) -> bool {
    let tol = blockers.weld_distance();
    // Points of the way that are no higher than this above the plane are on it.
    let start = tol / view.horizon.normal.dot(way.towards);
    let end = if way.is_far {
        f64::INFINITY
    } else {
        1.0 - tol / way.towards.length()
    };
    let from = view.position;
    start < end
        && blockers
            .rays()
            .is_blocked(from, from + way.towards, start, end, |_| false)
}
