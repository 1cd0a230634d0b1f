//! Picture files as texels.

use super::{ImageFormat, Texels};
use png::Transformations;
use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Largest width or height, texels: what graphics cards take.
const MAX_SIDE: usize = 16384;

/// Texels that a picture file of a few bytes may hold: a square of 2048.
const MAX_FREE_TEXELS: usize = 1 << 22;

/// Texels that each byte of a larger file may stand for. Deflate packs 1032 equal bytes into one, so a PNG of one colour
/// holds some 1000 texels a byte (RGB: 344); photographs hold 1 to 30.
const MAX_TEXELS_PER_BYTE: usize = 2048;

/// The texels of a PNG, JPEG or WebP file.
///
/// 16-bit channels are cut to 8, grey is spread over the three colours, a missing opacity is full.
///
/// # Errors
/// What is wrong with the picture: damaged, larger than 16384 texels a side, or far more texels than its bytes can mean.
pub fn decode(bytes: &[u8]) -> Result<Texels, String> {
    match ImageFormat::of(bytes) {
        Some(ImageFormat::Png) => decode_png(bytes),
        Some(ImageFormat::Jpeg) => decode_jpeg(bytes),
        Some(ImageFormat::WebP) => decode_webp(bytes),
        None => Err("is no PNG, JPEG or WebP picture".to_owned()),
    }
}

/// Refuses sizes that would exhaust the memory before the decoder finds that the data are missing.
fn check_size(width: usize, height: usize, bytes: &[u8]) -> Result<(), String> {
    let allowed = MAX_FREE_TEXELS.max(bytes.len().saturating_mul(MAX_TEXELS_PER_BYTE));
    if width == 0 || height == 0 {
        return Err("has no texels".to_owned());
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!(
            "is {width} × {height} texels large, more than {MAX_SIDE} a side"
        ));
    }
    if width * height > allowed {
        return Err(format!(
            "claims {width} × {height} texels in {} bytes",
            bytes.len()
        ));
    }
    Ok(())
}

fn decode_png(bytes: &[u8]) -> Result<Texels, String> {
    let damaged = |error: png::DecodingError| format!("is a damaged PNG: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(damaged)?;
    let (width, height) = reader.info().size();
    check_size(width as usize, height as usize, bytes)?;
    let size = reader.output_buffer_size().ok_or("is too large a PNG")?;
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(damaged)?;
    data.truncate(frame.buffer_size());
    texels(
        width as usize,
        height as usize,
        frame.color_type.samples(),
        &data,
    )
}

fn decode_jpeg(bytes: &[u8]) -> Result<Texels, String> {
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .set_max_width(MAX_SIDE)
        .set_max_height(MAX_SIDE);
    let damaged = |error| format!("is a damaged JPEG: {error:?}");
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(damaged)?;
    let (width, height) = decoder.dimensions().ok_or("is a JPEG without a size")?;
    check_size(width, height, bytes)?;
    let data = decoder.decode().map_err(damaged)?;
    texels(width, height, 3, &data)
}

fn decode_webp(bytes: &[u8]) -> Result<Texels, String> {
    let damaged = |error: image_webp::DecodingError| format!("is a damaged WebP: {error}");
    let mut decoder = image_webp::WebPDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    check_size(width as usize, height as usize, bytes)?;
    let size = decoder.output_buffer_size().ok_or("is too large a WebP")?;
    let mut data = vec![0; size];
    decoder.read_image(&mut data).map_err(damaged)?;
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    texels(width as usize, height as usize, channels, &data)
}

/// Rows of pixels with 1 (grey), 2 (grey, opacity), 3 or 4 channels.
fn texels(width: usize, height: usize, channels: usize, data: &[u8]) -> Result<Texels, String> {
    if data.len() != width * height * channels {
        return Err(format!(
            "holds {} bytes for {width} × {height} texels of {channels} channels",
            data.len()
        ));
    }
    let rgba = data
        .chunks_exact(channels)
        .map(|t| match *t {
            [grey] => [grey, grey, grey, 255],
            [grey, opacity] => [grey, grey, grey, opacity],
            [r, g, b] => [r, g, b, 255],
            [r, g, b, a, ..] => [r, g, b, a],
            [] => [0; 4],
        })
        .collect();
    Ok(Texels {
        width: width as u32,
        height: height as u32,
        rgba,
    })
}
