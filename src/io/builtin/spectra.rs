//! The published spectra of the Cornell box, and the sum that turns them into the linear sRGB numbers of the scene.

use super::{GREEN, LIGHT_EMISSION, RED, WHITE};
use crate::quantity::Rgb;
use glam::{DMat3, DVec3};

/// Wavelength of the first sample, nm.
const FIRST_NM: f64 = 400.0;
/// Distance of the samples, nm.
const STEP_NM: f64 = 4.0;

/// Measured reflectance of the white surfaces.
#[rustfmt::skip]
const WHITE_SPECTRUM: [f64; 76] = [
    0.343, 0.445, 0.551, 0.624, 0.665, 0.687, 0.708, 0.723, 0.715, 0.710,
    0.745, 0.758, 0.739, 0.767, 0.777, 0.765, 0.751, 0.745, 0.748, 0.729,
    0.745, 0.757, 0.753, 0.750, 0.746, 0.747, 0.735, 0.732, 0.739, 0.734,
    0.725, 0.721, 0.733, 0.725, 0.732, 0.743, 0.744, 0.748, 0.728, 0.716,
    0.733, 0.726, 0.713, 0.740, 0.754, 0.764, 0.752, 0.736, 0.734, 0.741,
    0.740, 0.732, 0.745, 0.755, 0.751, 0.744, 0.731, 0.733, 0.744, 0.731,
    0.712, 0.708, 0.729, 0.730, 0.727, 0.707, 0.703, 0.729, 0.750, 0.760,
    0.751, 0.739, 0.724, 0.730, 0.740, 0.737,
];

/// Measured reflectance of the green wall.
#[rustfmt::skip]
const GREEN_SPECTRUM: [f64; 76] = [
    0.092, 0.096, 0.098, 0.097, 0.098, 0.095, 0.095, 0.097, 0.095, 0.094,
    0.097, 0.098, 0.096, 0.101, 0.103, 0.104, 0.107, 0.109, 0.112, 0.115,
    0.125, 0.140, 0.160, 0.187, 0.229, 0.285, 0.343, 0.390, 0.435, 0.464,
    0.472, 0.476, 0.481, 0.462, 0.447, 0.441, 0.426, 0.406, 0.373, 0.347,
    0.337, 0.314, 0.285, 0.277, 0.266, 0.250, 0.230, 0.207, 0.186, 0.171,
    0.160, 0.148, 0.141, 0.136, 0.130, 0.126, 0.123, 0.121, 0.122, 0.119,
    0.114, 0.115, 0.117, 0.117, 0.118, 0.120, 0.122, 0.128, 0.132, 0.139,
    0.144, 0.146, 0.150, 0.152, 0.157, 0.159,
];

/// Measured reflectance of the red wall.
#[rustfmt::skip]
const RED_SPECTRUM: [f64; 76] = [
    0.040, 0.046, 0.048, 0.053, 0.049, 0.050, 0.053, 0.055, 0.057, 0.056,
    0.059, 0.057, 0.061, 0.061, 0.060, 0.062, 0.062, 0.062, 0.061, 0.062,
    0.060, 0.059, 0.057, 0.058, 0.058, 0.058, 0.056, 0.055, 0.056, 0.059,
    0.057, 0.055, 0.059, 0.059, 0.058, 0.059, 0.061, 0.061, 0.063, 0.063,
    0.067, 0.068, 0.072, 0.080, 0.090, 0.099, 0.124, 0.154, 0.192, 0.255,
    0.287, 0.349, 0.402, 0.443, 0.487, 0.513, 0.558, 0.584, 0.620, 0.606,
    0.609, 0.651, 0.612, 0.610, 0.650, 0.638, 0.627, 0.620, 0.630, 0.628,
    0.642, 0.639, 0.657, 0.639, 0.635, 0.642,
];

/// Emission of the light at 400, 500, 600 and 700 nm.
const LIGHT_SPECTRUM: [f64; 4] = [0.0, 8.0, 15.6, 18.4];

/// `exp(−t²/2)` with `t = (λ − mean) · slope`, another slope on each side of the mean.
fn lobe(nm: f64, mean: f64, slope_below: f64, slope_above: f64) -> f64 {
    let t = (nm - mean) * if nm < mean { slope_below } else { slope_above };
    (-0.5 * t * t).exp()
}

/// The CIE 1931 matching functions x̄, ȳ, z̄ in the multi-lobe fit of Wyman, Sloan and Shirley (2013), section 2.2.
fn xyz_matching(nm: f64) -> DVec3 {
    DVec3::new(
        0.362 * lobe(nm, 442.0, 0.0624, 0.0374) + 1.056 * lobe(nm, 599.8, 0.0264, 0.0323)
            - 0.065 * lobe(nm, 501.1, 0.0490, 0.0382),
        0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322),
        1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725),
    )
}

/// XYZ to linear sRGB (IEC 61966-2-1 primaries, D65).
fn srgb_of_xyz() -> DMat3 {
    DMat3::from_cols(
        DVec3::new(3.2404542, -0.9692660, 0.0556434),
        DVec3::new(-1.5371385, 1.8760108, -0.2040259),
        DVec3::new(-0.4985314, 0.0415560, 1.0572252),
    )
}

/// `Σ s(λ) m(λ) / Σ m(λ)` with `m` the matching function of each channel; trapezoids over the samples.
fn rendition(spectrum: impl Fn(usize) -> f64) -> Rgb {
    let mut sum = DVec3::ZERO;
    let mut weight = DVec3::ZERO;
    for sample in 0..76 {
        let half_at_ends = if sample == 0 || sample == 75 {
            0.5
        } else {
            1.0
        };
        let nm = FIRST_NM + STEP_NM * sample as f64;
        let matching = srgb_of_xyz() * xyz_matching(nm) * half_at_ends;
        sum += matching * spectrum(sample);
        weight += matching;
    }
    Rgb(sum / weight)
}

fn light(sample: usize) -> f64 {
    let hundreds = sample as f64 * STEP_NM / 100.0;
    let below = (hundreds as usize).min(2);
    let [low, high] = [LIGHT_SPECTRUM[below], LIGHT_SPECTRUM[below + 1]];
    low + (high - low) * (hundreds - below as f64)
}

fn assert_rounds_to(computed: Rgb, stated: Rgb) {
    let difference = (computed.0 - stated.0).abs().max_element();
    assert!(difference <= 0.5e-4, "{computed:?} is not {stated:?}");
}

#[test]
fn stated_colours_are_the_renditions_of_the_published_spectra() {
    assert_rounds_to(rendition(|i| WHITE_SPECTRUM[i]), WHITE);
    assert_rounds_to(rendition(|i| GREEN_SPECTRUM[i]), GREEN);
    assert_rounds_to(rendition(|i| RED_SPECTRUM[i]), RED);
    assert_rounds_to(rendition(light), LIGHT_EMISSION);
}

#[test]
fn a_constant_spectrum_keeps_its_value() {
    assert_rounds_to(rendition(|_| 0.78), Rgb::grey(0.78));
}
