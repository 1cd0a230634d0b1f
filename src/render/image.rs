//! Pixels: linear while light is added up, 8-bit sRGB for files and comparison.

use super::srgb_decode;
use crate::quantity::Rgb;

/// A picture in linear light, rows from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// `width × height` linear pixels.
    pub pixels: Vec<Rgb>,
}

/// A picture in 8-bit sRGB, rows from top to bottom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// `width × height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

impl Image {
    /// What a screen shows of it: clamped to 0…1, sRGB, rounded to the nearest step.
    pub fn to_srgb(&self) -> Picture {
        // A step is shown from where the curve rounds to it: to find it takes less time than the power.
        let from: [f64; 255] = std::array::from_fn(|i| srgb_decode((i as f64 + 0.5) / 255.0));
        let encode = |linear: f64| from.partition_point(|&step| step <= linear) as u8;
        Picture {
            width: self.width,
            height: self.height,
            pixels: self
                .pixels
                .iter()
                .map(|pixel| pixel.to_array().map(encode))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::srgb_encode;

    #[test]
    fn steps_are_those_that_the_curve_rounds_to() {
        let values: Vec<f64> = (0..=10_000)
            .map(|i| f64::from(i) / 10_000.0)
            .chain([-1.0, 2.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN])
            .collect();
        let image = Image {
            width: values.len() as u32,
            height: 1,
            pixels: values.iter().map(|&x| Rgb::grey(x)).collect(),
        };
        for (x, shown) in values.iter().zip(image.to_srgb().pixels) {
            assert_eq!(shown, [(srgb_encode(*x) * 255.0).round() as u8; 3], "{x}");
        }
    }
}
