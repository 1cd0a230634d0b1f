//! Pictures on surfaces: what the file holds, its texels, and what light and a camera see of them.
//!
//! Light needs the mean over a face ([`MipMap::mean`]), a camera the value at a point ([`MipMap::sample`]); the output
//! needs the file's own bytes, unchanged.

mod decode;
mod mip;
mod srgb;

pub use decode::decode;
pub use mip::{MipMap, TextureMean};
pub use srgb::{srgb_decode, srgb_encode};

use glam::DVec2;
use std::sync::Arc;

/// Kinds of picture files that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// Portable Network Graphics.
    Png,
    /// JPEG, baseline or progressive.
    Jpeg,
    /// WebP, lossy or lossless.
    WebP,
}

impl ImageFormat {
    /// The format that the first bytes of a file tell.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            Some(Self::Png)
        } else if bytes.starts_with(&[0xFF, 0xD8, 0xFF]) {
            Some(Self::Jpeg)
        } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
            Some(Self::WebP)
        } else {
            None
        }
    }

    /// Its media type.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
            Self::WebP => "image/webp",
        }
    }
}

/// How a texture goes on beyond 0…1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// It begins again.
    #[default]
    Repeat,
    /// It begins again as its mirror image.
    Mirror,
    /// Its border goes on for ever.
    Clamp,
}

impl Wrap {
    /// The texel, 0…`size` − 1, at the whole number `i`.
    fn texel(self, i: i64, size: u32) -> u32 {
        let n = i64::from(size);
        let inside = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Mirror => {
                let turn = i.rem_euclid(2 * n);
                turn.min(2 * n - 1 - turn)
            }
            Self::Clamp => i.clamp(0, n - 1),
        };
        u32::try_from(inside).expect("a texel lies inside its picture")
    }
}

/// Texels as decoded, rows from top to bottom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texels {
    /// Width, texels.
    pub width: u32,
    /// Height, texels.
    pub height: u32,
    /// Red, green, blue (sRGB) and opacity.
    pub rgba: Vec<[u8; 4]>,
}

/// A picture that materials lay on surfaces. Coordinates (0, 0) are its top left corner, (1, 1) its bottom right one.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name for messages and the output.
    pub name: String,
    /// The picture as the file holds it.
    pub encoded: Arc<[u8]>,
    /// Its format.
    pub format: ImageFormat,
    /// The same, decoded.
    pub texels: Arc<Texels>,
    /// How it goes on along u and v.
    pub wrap: [Wrap; 2],
    /// Magnification and minification filter by their numbers in OpenGL (9728 nearest, 9729 linear, …), where stated.
    pub filters: [Option<u32>; 2],
}

impl Texture {
    /// A repeated texture of the picture file `encoded`.
    ///
    /// # Errors
    /// What is wrong with the picture.
    pub fn new(name: impl Into<String>, encoded: Vec<u8>) -> Result<Self, String> {
        let format = ImageFormat::of(&encoded).ok_or("is no PNG, JPEG or WebP picture")?;
        Ok(Self {
            name: name.into(),
            texels: Arc::new(decode(&encoded)?),
            encoded: encoded.into(),
            format,
            wrap: [Wrap::Repeat; 2],
            filters: [None; 2],
        })
    }

    /// Whole repetitions by which `uv` may be shifted without a change, nearest to `shift`.
    pub fn repetition(&self, shift: DVec2) -> DVec2 {
        let whole = |wrap: Wrap, x: f64| match wrap {
            Wrap::Repeat => x.round(),
            Wrap::Mirror => 2.0 * (x / 2.0).round(),
            Wrap::Clamp => 0.0,
        };
        DVec2::new(whole(self.wrap[0], shift.x), whole(self.wrap[1], shift.y))
    }

    /// Width and height, texels.
    pub fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.texels.width), f64::from(self.texels.height))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests;
