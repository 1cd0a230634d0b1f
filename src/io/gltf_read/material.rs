//! A glTF material as a diffuse one.

use crate::bad_input::BadInput;
use crate::io::{check_material, default_material};
use crate::quantity::{Radiance, Rgb};
use crate::scene::Material;
use crate::warning::Warning;
use glam::DVec3;
use gltf::material::AlphaMode;

/// A blended surface below this opacity counts as not there: glass is written near 0, paint at 1.
const SEE_THROUGH_BELOW: f32 = 0.5;

/// The cut-off of `MASK` materials that state none, by the glTF specification.
const DEFAULT_ALPHA_CUTOFF: f32 = 0.5;

/// The material as light sees it. The base colour is the reflectance of metals too: they scatter as a rough one would.
pub(super) fn convert(
    source: &gltf::Material<'_>,
    place: &str,
    warnings: &mut Vec<Warning>,
) -> Result<Material, BadInput> {
    let name = match (source.name(), source.index()) {
        (Some(name), _) => name.to_owned(),
        (None, Some(index)) => format!("material {index}"),
        // The standard's white without a name would reflect all light for ever.
        (None, None) => return Ok(default_material("(none)", false)),
    };
    let base = source.pbr_metallic_roughness();
    let [r, g, b, alpha] = base.base_color_factor();
    let strength = f64::from(source.emissive_strength().unwrap_or(1.0));
    let emission = rgb(source.emissive_factor()) * strength;
    let material = Material {
        name,
        reflectance: rgb([r, g, b]),
        emission: Radiance(emission),
        is_see_through: match source.alpha_mode() {
            AlphaMode::Opaque => false,
            AlphaMode::Mask => alpha < source.alpha_cutoff().unwrap_or(DEFAULT_ALPHA_CUTOFF),
            AlphaMode::Blend => alpha < SEE_THROUGH_BELOW,
        },
        reflects_back: source.double_sided(),
        emits_back: source.double_sided(),
    };
    check_material(place, &material)?;

    let mut textures = Vec::new();
    if base.base_color_texture().is_some() {
        textures.push("base colour");
    }
    if source.emissive_texture().is_some() {
        textures.push("emissive");
    }
    if !textures.is_empty() {
        let message = format!(
            "material \"{}\": the {} texture is not averaged yet, the factor alone is used",
            material.name,
            textures.join(" and the ")
        );
        warnings.push(Warning::new(place, message));
    }
    Ok(material)
}

fn rgb(channels: [f32; 3]) -> Rgb {
    Rgb(DVec3::from_array(channels.map(f64::from)))
}
