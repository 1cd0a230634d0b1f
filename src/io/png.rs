//! 8-bit sRGB pictures as PNG files.

use crate::bad_input::BadInput;
use crate::render::Picture;
use png::{BitDepth, ColorType, Compression, SrgbRenderingIntent, Transformations};
use std::io::Cursor;

/// Bytes of a decoded picture that are accepted: a square of 16384 pixels with four channels.
const MAX_BYTES: usize = 4 << 28;

/// `picture` as a PNG with an sRGB chunk; the same picture gives the same bytes.
///
/// # Panics
/// When width or height is 0 or the pixels do not fill them.
pub fn write_png(picture: &Picture) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_compression(Compression::Fast);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(picture.pixels.as_flattened()))
        .expect("memory takes every byte, and the picture has as many pixels as it says");
    bytes
}

/// The picture in `bytes`, a PNG of any colour type; `source` is its name for messages.
///
/// 16-bit channels are cut to 8; pixels that are not opaque are refused, for they look different on every background.
pub fn read_png(source: &str, bytes: &[u8]) -> Result<Picture, BadInput> {
    let unreadable = |error: png::DecodingError| {
        BadInput::new(
            source,
            format!("cannot be read as PNG: {error}"),
            "give a PNG file that opens in a picture viewer",
        )
    };
    let limits = png::Limits { bytes: MAX_BYTES };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(unreadable)?;
    let size = reader
        .output_buffer_size()
        .filter(|&size| size <= MAX_BYTES);
    let Some(size) = size else {
        let what = format!("is larger than {MAX_BYTES} bytes");
        return Err(BadInput::new(source, what, "give a smaller picture"));
    };
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(unreadable)?;
    data.truncate(frame.buffer_size());

    let channels = frame.color_type.samples();
    let has_alpha = matches!(
        frame.color_type,
        ColorType::GrayscaleAlpha | ColorType::Rgba
    );
    let mut pixels = Vec::with_capacity(data.len() / channels);
    for pixel in data.chunks_exact(channels) {
        if has_alpha && pixel[channels - 1] != 255 {
            return Err(BadInput::new(
                source,
                "has pixels that are not opaque",
                "flatten it onto a background first",
            ));
        }
        let is_grey = channels < 3;
        pixels.push(if is_grey {
            [pixel[0]; 3]
        } else {
            [pixel[0], pixel[1], pixel[2]]
        });
    }
    Ok(Picture {
        width: frame.width,
        height: frame.height,
        pixels,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    fn picture() -> Picture {
        Picture {
            width: 3,
            height: 2,
            pixels: (0..6).map(|i| [i * 50, 255 - i, i]).collect(),
        }
    }

    #[test]
    fn a_picture_comes_back_as_it_was_and_twice_as_the_same_bytes() {
        let bytes = write_png(&picture());
        assert_eq!(read_png("a.png", &bytes).unwrap(), picture());
        assert_eq!(bytes, write_png(&picture()));
        assert!(bytes.windows(4).any(|chunk| chunk == b"sRGB"));
    }

    fn encoded(color: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        drop(writer);
        bytes
    }

    #[test]
    fn other_colour_types_are_understood_and_transparency_is_refused() {
        let pixel = |bytes: &[u8]| read_png("p.png", bytes).map(|p| p.pixels[0]);
        let grey = encoded(ColorType::Grayscale, BitDepth::Eight, &[7]);
        let deep = encoded(ColorType::Rgb, BitDepth::Sixteen, &[1, 0, 2, 0, 3, 0]);
        let solid = encoded(ColorType::Rgba, BitDepth::Eight, &[1, 2, 3, 255]);
        let glass = encoded(ColorType::Rgba, BitDepth::Eight, &[1, 2, 3, 254]);
        assert_eq!(pixel(&grey).unwrap(), [7; 3]);
        assert_eq!(pixel(&deep).unwrap(), [1, 2, 3]);
        assert_eq!(pixel(&solid).unwrap(), [1, 2, 3]);
        assert!(pixel(&glass).unwrap_err().what.contains("not opaque"));
    }

    #[test]
    fn what_is_no_png_is_refused() {
        let bytes = write_png(&picture());
        for damaged in [&b"GIF89a"[..], &[], &bytes[..bytes.len() - 20]] {
            assert!(read_png("p.png", damaged).is_err());
        }
    }
}
