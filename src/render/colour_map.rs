//! Light as false colours: the map from dark to bright, and a scale with a round end.

use crate::quantity::Irradiance;

/// Colours from nothing to the end of a scale, sRGB, equally spaced: *viridis* by Smith and van der Walt (2015, CC0), whose
/// lightness grows evenly and which colour-blind eyes can read. Between them colours are interpolated in sRGB.
pub const COLOUR_MAP: [[u8; 3]; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2d, 0x7b],
    [0x3b, 0x52, 0x8b],
    [0x2c, 0x72, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x28, 0xae, 0x80],
    [0x5e, 0xc9, 0x62],
    [0xad, 0xdc, 0x30],
    [0xfd, 0xe7, 0x25],
];

/// The colour at `t`, 0…1, of the map; what lies outside has the colour of its end.
pub fn false_colour(t: f64) -> [u8; 3] {
    let last = COLOUR_MAP.len() - 1;
    let at = t.clamp(0.0, 1.0) * last as f64;
    let i = (at as usize).min(last - 1);
    let share = at - i as f64;
    std::array::from_fn(|c| {
        let [a, b] = [COLOUR_MAP[i][c], COLOUR_MAP[i + 1][c]].map(f64::from);
        (a + (b - a) * share).round() as u8
    })
}

/// What the numbers of a scale are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightUnit {
    /// Mean of the channels of the irradiance, W/m².
    WattsPerSquareMetre,
    /// Illuminance at so many lumens a watt of white.
    Lux {
        /// lm/W.
        efficacy: f64,
    },
}

impl LightUnit {
    /// The number of `light` in this unit.
    pub fn of(self, light: Irradiance) -> f64 {
        match self {
            Self::WattsPerSquareMetre => light.mean(),
            Self::Lux { efficacy } => light.illuminance(efficacy),
        }
    }

    /// How it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::WattsPerSquareMetre => "W/m²",
            Self::Lux { .. } => "lx",
        }
    }
}

/// A scale from 0 to `top`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourScale {
    /// What its numbers are.
    pub unit: LightUnit,
    /// Its end, in that unit.
    pub top: f64,
}

impl ColourScale {
    /// The colour of `light`, sRGB; brighter light than the end has the colour of the end.
    pub fn colour(&self, light: Irradiance) -> [u8; 3] {
        false_colour(self.unit.of(light) / self.top)
    }

    /// Steps between numbers at the scale: 1, 2 or 5 times a power of ten, four to ten of them.
    pub fn step(&self) -> f64 {
        round_down(self.top / 4.0)
    }
}

/// Share of the area that may be brighter than the end of a scale: the few elements right below a lamp would leave the
/// rest of the scene one colour.
const BEYOND_SHARE: f64 = 0.03;

/// A round end for a scale of `values`, each with its area: at most 3 % of the area are brighter. 1 where nothing
/// is bright at all.
pub fn round_top(values: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let mut values: Vec<(f64, f64)> = values.into_iter().filter(|v| v.0 > 0.0).collect();
    values.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let total: f64 = values.iter().map(|v| v.1).sum();
    let mut brighter = 0.0;
    let quantile = values.iter().find(|v| {
        brighter += v.1;
        brighter >= BEYOND_SHARE * total
    });
    let Some(&(value, _)) = quantile else {
        return 1.0;
    };
    // The next of 1, 1.5, 2, 3, 4, 5, 6, 8, 10 times a power of ten: at most a third of the scale stays empty.
    let power = 10.0_f64.powi(value.log10().floor() as i32);
    let digits = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    let digit = digits.into_iter().find(|d| d * power >= value);
    digit.unwrap_or(10.0) * power
}

/// The largest of 1, 2, 5 times a power of ten that is not above `x`.
fn round_down(x: f64) -> f64 {
    let power = 10.0_f64.powi(x.log10().floor() as i32);
    // A quotient such as 0.6 / 3 comes out a rounding below its step.
    let reach = x * (1.0 + 4.0 * f64::EPSILON);
    let digit = [5.0, 2.0, 1.0].into_iter().find(|d| d * power <= reach);
    digit.unwrap_or(1.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Rgb;

    #[test]
    fn the_map_grows_lighter_from_end_to_end() {
        let lightness = |[r, g, b]: [u8; 3]| {
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        let steps: Vec<f64> = (0..=64)
            .map(|i| lightness(false_colour(f64::from(i) / 64.0)))
            .collect();
        assert!(steps.windows(2).all(|w| w[0] < w[1]), "{steps:?}");
        assert_eq!(false_colour(-1.0), COLOUR_MAP[0]);
        assert_eq!(false_colour(9.0), COLOUR_MAP[8]);
    }

    #[test]
    fn scales_end_at_round_numbers_beyond_almost_all_of_the_light() {
        let values = (0..1000).map(|i| (f64::from(i) * 0.4, 1.0));
        let top = round_top(values);
        assert!((top - 400.0).abs() < 1e-9, "{top}");
        // A little of the area may be a million times as bright.
        let lamp = [(1.0, 995.0), (1e6, 5.0)];
        assert!((round_top(lamp) - 1.0).abs() < 1e-12);
        assert!((round_top([]) - 1.0).abs() < 1e-12);
        for top in [0.6, 1.0, 1.5, 3.0, 800.0] {
            let unit = LightUnit::WattsPerSquareMetre;
            let steps = top / ColourScale { unit, top }.step();
            assert!((3.99..=10.01).contains(&steps), "{top}: {steps}");
        }
    }

    #[test]
    fn white_light_has_the_efficacy_that_was_stated() {
        let unit = LightUnit::Lux { efficacy: 179.0 };
        let white = Irradiance(Rgb::grey(2.0));
        assert!((unit.of(white) - 358.0).abs() < 1e-9);
        let green = Irradiance(Rgb::new(0.0, 1.0, 0.0));
        assert!((unit.of(green) - 179.0 * 0.7152).abs() < 1e-9);
    }
}
