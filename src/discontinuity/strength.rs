//! How much a line of the second kind (NVE, EEE) can matter, told before any light is evaluated.
//!
//! Features that meet on a sight line bound a small triangle of the emitter, seen from beside the line. It is not wider
//! than the shortest feature looks, nor wider than what parallax can move the features against each other while the
//! viewpoint crosses the receiver; with that width φ (radians) it sheds `L cos θ φ²`.

use crate::direct::DirectLight;
use crate::scene::{EmitterId, FaceId, FaceSide, Scene};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;
use std::f64::consts::PI;

/// A corner of the visible outline changes by half of what the whole triangle sheds.
const CORNER_SHARE: f64 = 0.5;

/// Something that a sight line grazes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feature {
    /// Where it is grazed, metres.
    pub(super) at: DVec3,
    /// How far it reaches from there, metres.
    pub(super) reach: DVec3,
}

/// Where a sight line ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub(super) face: FaceId,
    pub(super) side: FaceSide,
    pub(super) point: DVec3,
}

/// The predicted break, W/m², mean of the channels; none below the share `floor` of what the whole emitter gives there.
pub(super) fn predicted_jump(
    scene: &Scene,
    light: &DirectLight,
    emitter: EmitterId,
    end: End,
    features: &[Feature],
    floor: f64,
) -> Option<f64> {
    let normal = scene.normal(end.face, end.side);
    let direction = (features[0].at - end.point).try_normalize()?;
    let whole = light
        .unoccluded_from(
            emitter,
            &Viewpoint::new(end.point, normal),
            &mut Scratch::default(),
        )
        .mean();
    let width = apparent_width(
        end.point,
        direction,
        features,
        scene.faces[end.face].area.sqrt(),
    );
    let polygon = light.polygons_of(emitter).first();
    let exitance = polygon.map_or(0.0, |p| p.exitance.0.mean());
    let corner = exitance / PI * normal.dot(direction).max(0.0) * width * width;
    let jump = CORNER_SHARE * whole.min(corner);
    (jump > 0.0 && jump >= floor * whole).then_some(jump)
}

/// The width φ of the triangle between the features, radians.
fn apparent_width(eye: DVec3, direction: DVec3, features: &[Feature], receiver_size: f64) -> f64 {
    let (mut width, mut nearest, mut farthest) = (f64::INFINITY, f64::INFINITY, 0.0_f64);
    for f in features {
        let distance = eye.distance(f.at);
        width = width.min(f.reach.reject_from_normalized(direction).length() / distance);
        nearest = nearest.min(distance);
        farthest = farthest.max(distance);
    }
    width.min(receiver_size * (1.0 / nearest - 1.0 / farthest))
}
