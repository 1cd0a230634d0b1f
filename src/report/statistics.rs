//! Least, mean and most light on a face or a grid, and how even it is.

use crate::adapt::Receiver;
use crate::quantity::Irradiance;
use crate::render::LightUnit;

/// Light over an area or at points.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LightStatistics {
    /// Least.
    pub min: f64,
    /// Mean over the area or the points.
    pub mean: f64,
    /// Most.
    pub max: f64,
}

impl LightStatistics {
    /// Of one side of a face: what its mesh shows, to the last point. Linear elements have their extremes at their corners
    /// and their mean in the mean of these.
    pub fn of_receiver(r: &Receiver, unit: LightUnit) -> Self {
        let mut total = Irradiance::ZERO;
        let mut area = 0.0;
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        for (e, sites) in r.mesh.sites.iter().enumerate() {
            let a = r.mesh.area(e);
            area += a;
            for &s in sites {
                let light = r.site_total(s as usize);
                total += light * (a / 3.0);
                let value = unit.of(light);
                (min, max) = (min.min(value), max.max(value));
            }
        }
        let mean = unit.of(total) / area;
        Self::checked(min, mean, max)
    }

    /// At points, each for an equal share of the area, as the standards measure.
    pub fn of_points(light: impl IntoIterator<Item = Irradiance>, unit: LightUnit) -> Self {
        let (mut sum, mut count) = (0.0, 0.0);
        let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in light.into_iter().map(|e| unit.of(e)) {
            sum += value;
            count += 1.0;
            (min, max) = (min.min(value), max.max(value));
        }
        Self::checked(min, sum / count, max)
    }

    /// Nothing is lit where there is nothing.
    fn checked(min: f64, mean: f64, max: f64) -> Self {
        if mean.is_finite() && min <= max {
            Self { min, mean, max }
        } else {
            Self {
                min: 0.0,
                mean: 0.0,
                max: 0.0,
            }
        }
    }

    /// Uniformity U₀ = least / mean (EN 12464-1); 0 where no light is.
    pub fn uniformity(&self) -> f64 {
        if self.mean > 0.0 {
            self.min / self.mean
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Rgb;

    #[test]
    fn uniformity_is_the_least_over_the_mean() {
        let light = [1.0, 2.0, 6.0].map(|e| Irradiance(Rgb::grey(e)));
        let unit = LightUnit::Lux { efficacy: 100.0 };
        let found = LightStatistics::of_points(light, unit);
        assert!((found.min - 100.0).abs() < 1e-9 && (found.max - 600.0).abs() < 1e-9);
        assert!((found.mean - 300.0).abs() < 1e-9);
        assert!((found.uniformity() - 1.0 / 3.0).abs() < 1e-12);
        let none = LightStatistics::of_points([], unit);
        assert_eq!((none.mean, none.uniformity()), (0.0, 0.0));
    }
}
