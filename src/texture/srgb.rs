//! Linear light to the numbers of a screen and back: the sRGB transfer curve (IEC 61966-2-1).

/// The sRGB value, 0…1, of a linear value; values outside 0…1 are clamped, NaN is black.
pub fn srgb_encode(linear: f64) -> f64 {
    let linear = if linear.is_nan() {
        0.0
    } else {
        linear.clamp(0.0, 1.0)
    };
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The linear value, 0…1, of an sRGB value between 0 and 1.
pub fn srgb_decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_is_the_standard_curve_and_decoding_its_inverse() {
        assert!((srgb_encode(0.5) - 0.735_357).abs() < 1e-6);
        for step in 0..=255 {
            let encoded = f64::from(step) / 255.0;
            assert!((srgb_encode(srgb_decode(encoded)) - encoded).abs() < 1e-7);
        }
    }

    #[test]
    fn what_a_screen_cannot_show_is_clamped() {
        let shown = [-1.0, 2.0, f64::INFINITY, f64::NAN].map(|x| (srgb_encode(x) * 255.0).round());
        assert_eq!(shown, [0.0, 255.0, 255.0, 0.0]);
    }
}
