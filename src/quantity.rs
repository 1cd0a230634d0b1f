//! Light as typed, linear RGB quantities: which number is W/m² and which is W/(m² sr) is in the type.

use glam::DVec3;
use std::f64::consts::PI;
use std::ops::{Add, AddAssign, Mul, Sub};

/// Three linear channels (red, green, blue) without a unit: reflectances and weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb(pub DVec3);

impl Rgb {
    /// No light in any channel.
    pub const BLACK: Self = Self(DVec3::ZERO);

    /// The three channels as given.
    pub const fn new(r: f64, g: f64, b: f64) -> Self {
        Self(DVec3::new(r, g, b))
    }

    /// The same value in each channel.
    pub const fn grey(value: f64) -> Self {
        Self(DVec3::splat(value))
    }

    /// The mean of the three channels: the scalar by which errors are weighed.
    pub fn mean(self) -> f64 {
        self.0.element_sum() / 3.0
    }

    /// The mean of the three squared channels.
    pub fn mean_square(self) -> f64 {
        self.0.length_squared() / 3.0
    }

    /// True when no channel is above zero.
    pub fn is_black(self) -> bool {
        self.0.max_element() <= 0.0
    }

    /// True when every channel is finite.
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// Channels as an array.
    pub fn to_array(self) -> [f64; 3] {
        self.0.to_array()
    }
}

impl Mul<Rgb> for Rgb {
    type Output = Rgb;
    fn mul(self, rhs: Rgb) -> Rgb {
        Rgb(self.0 * rhs.0)
    }
}

macro_rules! linear {
    ($t:ident) => {
        impl Add for $t {
            type Output = $t;
            fn add(self, rhs: $t) -> $t {
                $t(self.0 + rhs.0)
            }
        }
        impl Sub for $t {
            type Output = $t;
            fn sub(self, rhs: $t) -> $t {
                $t(self.0 - rhs.0)
            }
        }
        impl AddAssign for $t {
            fn add_assign(&mut self, rhs: $t) {
                self.0 = self.0 + rhs.0;
            }
        }
        impl Mul<f64> for $t {
            type Output = $t;
            fn mul(self, rhs: f64) -> $t {
                $t(self.0 * rhs)
            }
        }
    };
}

macro_rules! quantity {
    ($(#[$doc:meta])* $t:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $t(pub Rgb);

        impl $t {
            /// Nothing.
            pub const ZERO: Self = Self(Rgb::BLACK);

            /// The mean of the three channels.
            pub fn mean(self) -> f64 {
                self.0.mean()
            }
        }
        linear!($t);
    };
}

linear!(Rgb);
quantity!(
    /// Power that a surface sends out of itself, W/m².
    Exitance
);
quantity!(
    /// Power that arrives at a surface, W/m².
    Irradiance
);
quantity!(
    /// Power that leaves a surface, emitted and reflected, W/m².
    Radiosity
);
quantity!(
    /// Power per area and solid angle, W/(m² sr).
    Radiance
);

/// Lumens a watt of equal power in all three channels: what Radiance takes for white light over the visible spectrum
/// (Ward, *The RADIANCE Lighting Simulation and Rendering System*, 1994). Scenes whose numbers mean something else state
/// their own.
pub const WHITE_EFFICACY: f64 = 179.0;

/// What each channel of linear sRGB adds to the luminance of white (IEC 61966-2-1).
pub const LUMINANCE_WEIGHTS: Rgb = Rgb::new(0.2126, 0.7152, 0.0722);

impl Irradiance {
    /// Illuminance in lux at `efficacy` lumens a watt of white.
    pub fn illuminance(self, efficacy: f64) -> f64 {
        efficacy * self.0.0.dot(LUMINANCE_WEIGHTS.0)
    }
}

impl Exitance {
    /// `M = π L` of a diffuse emitter.
    pub fn from_radiance(radiance: Radiance) -> Self {
        Self(radiance.0 * PI)
    }
}

impl Radiosity {
    /// `L = B / π` of a diffuse surface.
    pub fn to_radiance(self) -> Radiance {
        Radiance(self.0 * (1.0 / PI))
    }

    /// `B = M + ρ E`.
    pub fn leaving(emitted: Exitance, reflectance: Rgb, arriving: Irradiance) -> Self {
        Self(emitted.0 + reflectance * arriving.0)
    }
}
