//! Lights without a surface (`KHR_lights_punctual`).

use super::node::PlacedNode;
use crate::io::UpAxis;
use crate::quantity::Rgb;
use crate::scene::{PunctualKind, PunctualLight};
use glam::DVec3;
use gltf::khr_lights_punctual::{Kind, Light};

/// Lumens a watt: the file's candela and lux are divided by it. It is the constant that the candela is defined by (SI), and what
/// exporters multiply watts with for these lights, while emissive surfaces are written as they stand.
pub(super) const LUMENS_A_WATT: f64 = 683.0;

/// The light of a node in the world; `None` when its numbers are not finite, or the node is flattened.
pub(super) fn light(
    placed: &PlacedNode<'_>,
    source: &Light<'_>,
    up: UpAxis,
) -> Option<PunctualLight> {
    // A glTF light shines along −z.
    let direction = up.to_y_up(placed.world.transform_vector3(DVec3::NEG_Z));
    let colour = DVec3::from_array(source.color().map(f64::from));
    let intensity = colour * (f64::from(source.intensity()) / LUMENS_A_WATT);
    let name = placed.node.name().or(source.name());
    let is_sound = intensity.is_finite() && intensity.cmpge(DVec3::ZERO).all();
    is_sound.then_some(PunctualLight {
        name: name.map_or_else(|| format!("light {}", source.index()), str::to_owned),
        kind: match source.kind() {
            Kind::Directional => PunctualKind::Directional,
            Kind::Point => PunctualKind::Point,
            Kind::Spot {
                inner_cone_angle,
                outer_cone_angle,
            } => PunctualKind::Spot {
                inner_angle_rad: f64::from(inner_cone_angle),
                outer_angle_rad: f64::from(outer_cone_angle),
            },
        },
        position: up.to_y_up(placed.world.transform_point3(DVec3::ZERO)),
        direction: direction.try_normalize()?,
        intensity: Rgb(intensity),
        range: source.range().map(f64::from).filter(|r| *r > 0.0),
    })
}
