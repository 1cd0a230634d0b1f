//! How far two pictures are apart, in steps of 8-bit sRGB and as eyes see it: the golden-image check.

use crate::bad_input::BadInput;
use crate::render::Picture;
use ssimulacra2::{ColorPrimaries, TransferCharacteristic};

/// What still counts as the same picture, in steps of 0…255.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureTolerance {
    /// Largest difference of any channel of any pixel.
    pub max_error: f64,
    /// Mean difference over all channels of all pixels.
    pub mean_error: f64,
}

impl Default for PictureTolerance {
    /// Two steps anywhere, a tenth of a step on average: one step is how far mathematics libraries differ when a value is
    /// rounded to 8 bits, and it happens to few pixels.
    fn default() -> Self {
        Self {
            max_error: 2.0,
            mean_error: 0.1,
        }
    }
}

/// The differences between two pictures, in steps of 0…255 (all but the counts).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PictureDifference {
    /// Largest absolute difference of a channel.
    pub max_error: f64,
    /// Mean absolute difference over all channels.
    pub mean_error: f64,
    /// Root of the mean squared difference over all channels.
    pub rms_error: f64,
    /// Pixels of each picture.
    pub pixels: usize,
    /// Pixels with a channel beyond the largest difference that is allowed.
    pub pixels_beyond: usize,
    /// Whether both limits are kept.
    pub is_within: bool,
}

/// Compares `a` and `b`; pictures of different sizes cannot be compared.
pub fn compare(
    a: &Picture,
    b: &Picture,
    tolerance: &PictureTolerance,
) -> Result<PictureDifference, BadInput> {
    same_size(a, b)?;
    let limits = [tolerance.max_error, tolerance.mean_error];
    if !limits.iter().all(|limit| *limit >= 0.0) {
        return Err(BadInput::new(
            "compare",
            format!("the limits are {} and {}", limits[0], limits[1]),
            "give numbers from 0 to 255",
        ));
    }
    // Sums of whole numbers are exact, so that the order of pixels plays no part.
    let (mut largest, mut sum, mut sum_of_squares, mut pixels_beyond) = (0u8, 0u64, 0u64, 0);
    for (p, q) in a.pixels.iter().zip(&b.pixels) {
        let worst = worst_channel(p, q);
        largest = largest.max(worst);
        pixels_beyond += usize::from(f64::from(worst) > tolerance.max_error);
        for (x, y) in p.iter().zip(q) {
            let step = u64::from(x.abs_diff(*y));
            sum += step;
            sum_of_squares += step * step;
        }
    }
    let channels = (3 * a.pixels.len()).max(1) as f64;
    let max_error = f64::from(largest);
    let mean_error = sum as f64 / channels;
    Ok(PictureDifference {
        max_error,
        mean_error,
        rms_error: (sum_of_squares as f64 / channels).sqrt(),
        pixels: a.pixels.len(),
        pixels_beyond,
        is_within: max_error <= tolerance.max_error && mean_error <= tolerance.mean_error,
    })
}

/// Least width and height of a picture that eyes are asked about, pixels: the smallest that the score is defined for.
pub const SMALLEST_SEEN: u32 = 8;

/// How much alike `a` and `b` look: the SSIMULACRA 2 score (Sneyers 2023), 100 for the same picture, 90 for one that is hardly
/// told apart by flipping between them, 70 for high, 50 for medium, 30 for low quality; very different pictures are below 0.
///
/// `a` is the golden one: the score weighs what `b` lost and what it gained differently. None for pictures under
/// [`SMALLEST_SEEN`] pixels.
///
/// # Errors
/// When the sizes differ.
pub fn perceptual_score(a: &Picture, b: &Picture) -> Result<Option<f64>, BadInput> {
    same_size(a, b)?;
    if a.width.min(a.height) < SMALLEST_SEEN {
        return Ok(None);
    }
    // The score of a picture against itself is 100 but for rounding.
    if a == b {
        return Ok(Some(IDENTICAL));
    }
    let unusual = |error: &dyn std::fmt::Display| {
        BadInput::new(
            "compare",
            error.to_string(),
            "compare 8-bit pictures of one size",
        )
    };
    let frame = |p: &Picture| {
        let pixels = p.pixels.iter().map(|c| c.map(|c| f32::from(c) / 255.0));
        ssimulacra2::Rgb::new(
            pixels.collect(),
            p.width as usize,
            p.height as usize,
            TransferCharacteristic::SRGB,
            ColorPrimaries::BT709,
        )
        .map_err(|error| unusual(&error))
    };
    let score = ssimulacra2::compute_frame_ssimulacra2(frame(a)?, frame(b)?)
        .map_err(|error| unusual(&error))?;
    Ok(Some(score))
}

/// Score of the same picture.
const IDENTICAL: f64 = 100.0;

/// A picture of where `a` and `b` differ.
///
/// `a` stays visible as a dark grey. Pixels that differ within `max_error` are blue; those beyond it are red for the first
/// step too many and go over orange and yellow to white where the difference is largest, however small it is.
pub fn difference_picture(a: &Picture, b: &Picture, max_error: f64) -> Result<Picture, BadInput> {
    same_size(a, b)?;
    let pairs = || a.pixels.iter().zip(&b.pixels);
    let largest = pairs().map(|(p, q)| worst_channel(p, q)).max();
    let largest = f64::from(largest.unwrap_or(0));
    let pixels = pairs()
        .map(|(p, q)| {
            let [red, green, blue] = p.map(f64::from);
            let dim = ((0.2126 * red + 0.7152 * green + 0.0722 * blue) / 4.0) as u8;
            match f64::from(worst_channel(p, q)) {
                0.0 => [dim; 3],
                worst if worst <= max_error => [dim, dim, 255],
                worst => heat((worst - max_error) / (largest - max_error)),
            }
        })
        .collect();
    Ok(Picture { pixels, ..*a })
}

/// Red at 0, over orange and yellow to white at 1.
fn heat(amount: f64) -> [u8; 3] {
    let green = (amount * 2.0).min(1.0) * 255.0;
    let blue = (amount * 2.0 - 1.0).max(0.0) * 255.0;
    [255, green as u8, blue as u8]
}

fn worst_channel(p: &[u8; 3], q: &[u8; 3]) -> u8 {
    p[0].abs_diff(q[0])
        .max(p[1].abs_diff(q[1]))
        .max(p[2].abs_diff(q[2]))
}

fn same_size(a: &Picture, b: &Picture) -> Result<(), BadInput> {
    if (a.width, a.height) == (b.width, b.height) && a.pixels.len() == b.pixels.len() {
        return Ok(());
    }
    Err(BadInput::new(
        "compare",
        format!(
            "the first picture has {} × {} pixels, the second {} × {}",
            a.width, a.height, b.width, b.height
        ),
        "render both at the same size",
    ))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    fn grey(values: [u8; 4]) -> Picture {
        Picture {
            width: 2,
            height: 2,
            pixels: values.map(|v| [v; 3]).to_vec(),
        }
    }

    #[test]
    fn a_picture_is_itself() {
        let a = grey([0, 1, 100, 255]);
        let none = PictureTolerance {
            max_error: 0.0,
            mean_error: 0.0,
        };
        let found = compare(&a, &a, &none).unwrap();
        assert!(found.is_within);
        assert_eq!((found.max_error, found.rms_error), (0.0, 0.0));
        let picture = difference_picture(&a, &a, 0.0).unwrap();
        assert_eq!(picture.pixels[3], [63; 3]);
    }

    #[test]
    fn numbers_are_in_steps_and_both_limits_count() {
        let (a, mut b) = (grey([10, 20, 30, 255]), grey([10, 20, 30, 255]));
        b.pixels[1] = [20, 24, 17];
        let judge = |max_error, mean_error| {
            let tolerance = PictureTolerance {
                max_error,
                mean_error,
            };
            compare(&a, &b, &tolerance).unwrap()
        };
        let found = judge(4.0, 1.0);
        assert_eq!((found.max_error, found.pixels_beyond), (4.0, 0));
        assert!((found.mean_error - 7.0 / 12.0).abs() < 1e-12);
        assert!((found.rms_error - (25.0f64 / 12.0).sqrt()).abs() < 1e-12);
        assert!(found.is_within);
        assert!(!judge(4.0, 0.5).is_within);
        assert!(!judge(3.5, 1.0).is_within);
        assert_eq!(judge(3.5, 1.0).pixels_beyond, 1);
    }

    #[test]
    fn the_difference_picture_tells_same_within_and_beyond_apart() {
        let found = difference_picture(&grey([0; 4]), &grey([0, 2, 3, 40]), 2.0).unwrap();
        assert_eq!(found.pixels[0], [0; 3]);
        assert_eq!(found.pixels[1], [0, 0, 255]);
        assert_eq!(found.pixels[2][0], 255);
        assert!(found.pixels[2][2] == 0 && found.pixels[2][1] < 64);
        assert_eq!(found.pixels[3], [255; 3]);
    }

    /// A picture of smooth waves, each pixel changed by `change`.
    fn waves(change: impl Fn(u32, u32) -> f64) -> Picture {
        let (width, height) = (64, 48);
        let value = |x: u32, y: u32| {
            let wave = 110.0 + 60.0 * (f64::from(x) / 9.0).sin() * (f64::from(y) / 7.0).cos();
            [(wave + change(x, y)).clamp(0.0, 255.0) as u8; 3]
        };
        Picture {
            width,
            height,
            pixels: (0..height)
                .flat_map(|y| (0..width).map(move |x| (x, y)))
                .map(|(x, y)| value(x, y))
                .collect(),
        }
    }

    #[test]
    fn the_score_falls_with_what_eyes_see_and_not_with_the_sum_of_steps() {
        let golden = waves(|_, _| 0.0);
        let score = |b: &Picture| perceptual_score(&golden, b).unwrap().unwrap();
        assert!((score(&golden) - 100.0).abs() < 1e-9);
        // One step brighter everywhere is invisible; a dark square with the same sum of steps is seen at once.
        let square = |steps: f64| {
            let darker = |x: u32, y: u32| (20..36).contains(&x) && (16..28).contains(&y);
            waves(move |x, y| if darker(x, y) { -steps } else { 0.0 })
        };
        let (brighter, dark) = (score(&waves(|_, _| 1.0)), score(&square(16.0)));
        assert!(
            brighter > 95.0 && dark < brighter - 5.0,
            "{brighter} {dark}"
        );
        assert!(score(&square(48.0)) < dark - 10.0);
    }

    #[test]
    fn small_pictures_have_no_score() {
        let a = grey([0, 1, 100, 255]);
        assert_eq!(perceptual_score(&a, &a).unwrap(), None);
        assert!(perceptual_score(&a, &waves(|_, _| 0.0)).is_err());
    }

    #[test]
    fn sizes_must_agree_and_limits_be_numbers() {
        let a = grey([0; 4]);
        let wide = Picture {
            width: 4,
            height: 1,
            ..a.clone()
        };
        let limits = PictureTolerance::default();
        let error = compare(&a, &wide, &limits).unwrap_err();
        assert!(error.what.contains("2 × 2") && error.what.contains("4 × 1"));
        assert!(difference_picture(&a, &wide, 0.0).is_err());
        let limits = PictureTolerance {
            mean_error: f64::NAN,
            ..limits
        };
        assert!(compare(&a, &a, &limits).is_err());
    }
}
