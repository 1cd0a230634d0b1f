//! Textures of a glTF document.

use super::buffers::{Buffers, Folder};
use crate::texture::{Texture, Wrap};
use glam::{DMat2, DVec2};
use gltf::texture::WrappingMode;

/// The texture with its picture decoded.
///
/// # Errors
/// Why it cannot be shown, in words.
pub(in crate::io) fn load(
    source: &gltf::Texture<'_>,
    document: &gltf::Document,
    buffers: &Buffers,
    folder: &Folder<'_>,
) -> Result<Texture, String> {
    let image = image_index(source).ok_or("names no picture that can be read")?;
    let images = &document.as_json().images;
    let image = images
        .get(image)
        .ok_or_else(|| format!("names picture {image}, which is not there"))?;
    let bytes = match (&image.buffer_view, &image.uri) {
        (Some(view), _) => {
            let view = document.views().nth(view.value());
            let bytes = view.and_then(|view| Some(buffers.view(&view)?.to_vec()));
            bytes.ok_or("lies outside the data of the file")?
        }
        (None, Some(uri)) => folder
            .load(uri, "picture")
            .map_err(|error| format!("cannot be read: {}", error.what))?,
        (None, None) => return Err("has neither data nor a file".to_owned()),
    };
    let file_name = || image.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
    let name = source.name().map(str::to_owned);
    let name = name.or_else(|| image.name.clone()).or(file_name().cloned());
    let name = name.unwrap_or_else(|| format!("texture {}", source.index()));
    let sampler = source.sampler();
    let mut texture = Texture::new(name, bytes)?;
    texture.wrap = [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())];
    texture.filters = [
        sampler.mag_filter().map(|f| f.as_gl_enum()),
        sampler.min_filter().map(|f| f.as_gl_enum()),
    ];
    Ok(texture)
}

/// The picture, by `EXT_texture_webp` where there is one: all of its formats are read.
fn image_index(source: &gltf::Texture<'_>) -> Option<usize> {
    let webp = source.extension_value("EXT_texture_webp");
    let webp = webp.and_then(|value| value.get("source")?.as_u64());
    match webp {
        Some(index) => usize::try_from(index).ok(),
        None => source.source().map(|image| image.index()),
    }
}

fn wrap(mode: WrappingMode) -> Wrap {
    match mode {
        WrappingMode::Repeat => Wrap::Repeat,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::ClampToEdge => Wrap::Clamp,
    }
}

/// Which texture coordinates a material wants, and how they are moved first (`KHR_texture_transform`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::io) struct UvSource {
    /// Number of the attribute `TEXCOORD_…`.
    pub(in crate::io) set: u32,
    matrix: DMat2,
    offset: DVec2,
}

impl UvSource {
    /// Those of a reference to a texture.
    pub(in crate::io) fn of(info: &gltf::texture::Info<'_>) -> Self {
        let mut source = Self {
            set: info.tex_coord(),
            matrix: DMat2::IDENTITY,
            offset: DVec2::ZERO,
        };
        if let Some(transform) = info.texture_transform() {
            let vector = |v: [f32; 2]| DVec2::from_array(v.map(f64::from));
            // Counter-clockwise as seen on the picture, where v points down.
            let turn = DMat2::from_angle(-f64::from(transform.rotation()));
            source.set = transform.tex_coord().unwrap_or(source.set);
            source.matrix = turn * DMat2::from_diagonal(vector(transform.scale()));
            source.offset = vector(transform.offset());
        }
        source
    }

    /// Coordinates of the file as the texture is looked up with.
    pub(in crate::io) fn apply(&self, uv: [f64; 2]) -> DVec2 {
        self.matrix * DVec2::from(uv) + self.offset
    }
}
