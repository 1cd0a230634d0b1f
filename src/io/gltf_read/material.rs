//! A glTF material as a diffuse one.

use crate::bad_input::BadInput;
use crate::io::gltf_data::texture::UvSource;
use crate::io::{check_material, default_material};
use crate::quantity::{Radiance, Rgb};
use crate::scene::Material;
use crate::warning::Warning;
use glam::DVec3;
use gltf::material::AlphaMode;

/// A blended surface, or texel, below this opacity counts as not there: glass is written near 0, paint at 1.
const SEE_THROUGH_BELOW: f32 = 0.5;

/// The cut-off of `MASK` materials that state none, by the glTF specification.
const DEFAULT_ALPHA_CUTOFF: f32 = 0.5;

/// A material in the scene.
#[derive(Clone, Copy)]
pub(super) struct Converted {
    /// Index into the scene's materials.
    pub(super) index: u32,
    /// The coordinates of its texture, if it has one.
    pub(super) uv: Option<UvSource>,
}

/// The textures of a material, looked up with the same coordinates.
#[derive(Default)]
pub(super) struct Textures<'a> {
    pub(super) base: Option<gltf::texture::Info<'a>>,
    pub(super) emissive: Option<gltf::texture::Info<'a>>,
}

/// The material as light sees it, still without its textures, which come beside it.
///
/// The base colour is the reflectance of metals too: they scatter as a rough one would. Of the layers that extensions put
/// on top (coat, sheen, specular colour) a diffuse surface has none; most of a transmitting one is not there.
pub(super) fn convert<'a>(
    source: &gltf::Material<'a>,
    place: &str,
    warnings: &mut Vec<Warning>,
) -> Result<(Material, Textures<'a>), BadInput> {
    let name = match (source.name(), source.index()) {
        (Some(name), _) => name.to_owned(),
        (None, Some(index)) => format!("material {index}"),
        // The standard's white without a name would reflect all light for ever.
        (None, None) => return Ok((default_material("(none)", false), Textures::default())),
    };
    let base = source.pbr_metallic_roughness();
    let ([r, g, b, alpha], texture) = match source.pbr_specular_glossiness() {
        Some(older) => (older.diffuse_factor(), older.diffuse_texture()),
        None => (base.base_color_factor(), base.base_color_texture()),
    };
    let strength = f64::from(source.emissive_strength().unwrap_or(1.0));
    let emission = rgb(source.emissive_factor()) * strength;
    let transmitted = source
        .transmission()
        .map_or(0.0, |t| t.transmission_factor());
    let cut_off = match source.alpha_mode() {
        AlphaMode::Opaque => None,
        AlphaMode::Mask => Some(source.alpha_cutoff().unwrap_or(DEFAULT_ALPHA_CUTOFF)),
        AlphaMode::Blend => Some(SEE_THROUGH_BELOW),
    };
    let material = Material {
        name,
        reflectance: rgb([r, g, b]),
        emission: Radiance(emission),
        is_see_through: transmitted > SEE_THROUGH_BELOW
            || cut_off.is_some_and(|cut_off| alpha < cut_off),
        reflects_back: source.double_sided(),
        emits_back: source.double_sided(),
        texture: None,
        emission_texture: None,
        // The factor multiplies the opacity of each texel.
        cut_off: cut_off
            .filter(|_| texture.is_some() && alpha > 0.0)
            .map(|cut_off| f64::from(cut_off / alpha)),
    };
    check_material(place, &material)?;
    // One set of coordinates belongs to a corner: that of the base colour comes first.
    let emissive = source.emissive_texture();
    let other = |info: &gltf::texture::Info<'_>| {
        let base = texture.as_ref().map(UvSource::of);
        base.is_some_and(|base| base != UvSource::of(info))
    };
    if emissive.as_ref().is_some_and(other) {
        let message = format!(
            "material \"{}\": the emissive texture has coordinates of its own and is not read, the factor alone is used",
            material.name
        );
        warnings.push(Warning::new(place, message));
    }
    let emissive = emissive.filter(|info| !other(info));
    Ok((
        material,
        Textures {
            base: texture,
            emissive,
        },
    ))
}

fn rgb(channels: [f32; 3]) -> Rgb {
    Rgb(DVec3::from_array(channels.map(f64::from)))
}
