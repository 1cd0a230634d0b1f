//! Materials of an MTL file.
//!
//! Numbers that mean nothing are an error with their line; what makes no difference to diffuse light is passed over.

use super::text::{Statement, decode, statements};
use super::texture::TextureMap;
use crate::bad_input::BadInput;
use crate::io::default_material;
use crate::quantity::{Radiance, Rgb};
use crate::scene::Material;
use crate::warning::Warning;

/// A surface below this opacity counts as not there. Glass is written with `d` near 0, paint with `d 1`; half way
/// separates the two, and nothing in between can be said without refraction.
pub(super) const SEE_THROUGH_BELOW: f64 = 0.5;

/// A material and the line that begins it.
#[derive(Debug)]
pub(super) struct MtlMaterial {
    pub(super) material: Material,
    /// `file:line` of its `newmtl`.
    pub(super) place: String,
    has_kd: bool,
    has_dissolve: bool,
    /// `map_Kd`.
    pub(super) texture: Option<TextureMap>,
    /// `map_d`.
    opacity_map: Option<TextureMap>,
    unread: Vec<&'static str>,
}

/// All materials of the file `file`, in its order, with warnings about what they state and this reader does not use.
pub(super) fn parse(
    bytes: &[u8],
    file: &str,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<MtlMaterial>, BadInput> {
    let text = decode(bytes);
    let mut materials: Vec<MtlMaterial> = Vec::new();
    for statement in statements(&text) {
        let place = format!("{file}:{}", statement.number);
        if statement.keyword() == "newmtl" {
            materials.push(MtlMaterial::new(statement.rest(), place));
        } else if let Some(current) = materials.last_mut() {
            current.apply(&statement, &place)?;
        }
    }
    for material in &materials {
        material.warn(warnings);
    }
    Ok(materials)
}

impl MtlMaterial {
    fn new(name: &str, place: String) -> Self {
        Self {
            material: default_material(name, true),
            place,
            has_kd: false,
            has_dissolve: false,
            texture: None,
            opacity_map: None,
            unread: Vec::new(),
        }
    }

    /// A material that stands in for one that no library defines.
    pub(super) fn made_up(material: Material, place: &str) -> Self {
        Self {
            material,
            ..Self::new("", place.to_owned())
        }
    }

    fn apply(&mut self, statement: &Statement<'_>, place: &str) -> Result<(), BadInput> {
        match statement.keyword() {
            "Kd" => {
                self.material.reflectance = colour(statement, place)?;
                self.has_kd = true;
            }
            "Ke" => self.material.emission = Radiance(colour(statement, place)?),
            "d" => {
                self.material.is_see_through = scalar(statement, place)? < SEE_THROUGH_BELOW;
                self.has_dissolve = true;
            }
            // Some exporters write `d 1` and `Tr 1` for one opaque surface: `d`, which all agree on, wins.
            "Tr" => {
                let transparency = scalar(statement, place)?;
                if !self.has_dissolve {
                    self.material.is_see_through = transparency > 1.0 - SEE_THROUGH_BELOW;
                }
            }
            "map_Kd" => self.texture = TextureMap::parse(statement),
            "map_d" => self.opacity_map = TextureMap::parse(statement),
            "map_Ke" => self.unread.push("map_Ke"),
            _ => {}
        }
        Ok(())
    }

    /// Whether the opacity of the texture's own texels says what is there.
    pub(super) fn is_cut_out(&self) -> bool {
        let file = |map: &Option<TextureMap>| map.as_ref().map(|map| map.file.clone());
        self.texture.is_some() && file(&self.texture) == file(&self.opacity_map)
    }

    fn warn(&self, warnings: &mut Vec<Warning>) {
        let name = &self.material.name;
        if !self.has_kd {
            warnings.push(Warning::new(
                &self.place,
                format!("material \"{name}\" states no Kd: reflectance 0.5 grey is used"),
            ));
        }
        let opacity = self.opacity_map.is_some() && !self.is_cut_out();
        let unread = self.unread.iter().copied();
        let unread: Vec<&str> = unread.chain(opacity.then_some("map_d")).collect();
        if !unread.is_empty() {
            warnings.push(Warning::new(
                &self.place,
                format!(
                    "material \"{name}\": {} not read; the plain Ke and d are used",
                    unread.join(", ")
                ),
            ));
        }
    }
}

/// Three channels, or one for all three (the format lets green and blue default to red).
fn colour(statement: &Statement<'_>, place: &str) -> Result<Rgb, BadInput> {
    match numbers(statement, place)?[..] {
        [grey] => Ok(Rgb::grey(grey)),
        [r, g, b] => Ok(Rgb::new(r, g, b)),
        _ => Err(bad_value(statement, place)),
    }
}

/// One number, after options such as `-halo`.
fn scalar(statement: &Statement<'_>, place: &str) -> Result<f64, BadInput> {
    match numbers(statement, place)?[..] {
        [value] if !value.is_nan() => Ok(value),
        _ => Err(bad_value(statement, place)),
    }
}

fn numbers(statement: &Statement<'_>, place: &str) -> Result<Vec<f64>, BadInput> {
    statement
        .values()
        .filter(|word| *word != "-halo")
        .map(|word| word.parse().map_err(|_| bad_value(statement, place)))
        .collect()
}

fn bad_value(statement: &Statement<'_>, place: &str) -> BadInput {
    let keyword = statement.keyword();
    BadInput::new(
        place,
        format!("{keyword} has the value \"{}\"", statement.rest()),
        "write plain numbers: three (or one grey) after Kd and Ke, one after d and Tr",
    )
}
