//! What measuring tells about the estimates: where they were too small, there more is asked for.
//!
//! A bake that misses its error mostly misses it in a few places, bright faces beside lamps, whose light does what no estimate
//! foresaw. Asking for less error everywhere would buy what is not needed at several times the cost of all before. So what was
//! found is held against what was expected: face by face where there are points enough, and for the others together with
//! those that are as bright.

use super::Solution;
use crate::adapt::Receiver;
use crate::quantity::Irradiance;
use crate::radiosity::IndirectField;
use std::collections::BTreeMap;

/// Faces with fewer points than this are judged together with others.
const FEW_POINTS: usize = 4;

/// A single point counts for at most so many times what was expected, in squares: one bright spot says that there are others,
/// and little about how many.
const MOST_DISTRUST: f64 = 16.0;

/// Brightnesses whose logarithms to this base round to the same whole number are alike.
const ALIKE: f64 = 4.0;

/// A point of one part of the light.
#[derive(Clone, Copy)]
pub(super) struct Point {
    /// Number of the face.
    pub(super) face: usize,
    /// Mean squares of the error, found and expected, (W/m²)², times the area that the point stands for over that of the mean
    /// point.
    pub(super) found: f64,
    pub(super) expected: f64,
}

/// All points, of the display mesh and of the indirect field.
#[derive(Default)]
pub(super) struct Evidence {
    pub(super) mesh: Vec<Point>,
    pub(super) field: Vec<Point>,
}

/// What the parts are expected to be off by, relative to the mean.
#[derive(Clone, Copy)]
pub(super) struct Expected {
    pub(super) mesh: f64,
    pub(super) field: f64,
}

impl Evidence {
    /// Takes the errors of faces for what they were found to be; returns what is expected of the whole then, of the mean irradiance
    /// `mean` (W/m²).
    pub(super) fn teach(&self, solution: &mut Solution, mean: f64) -> Expected {
        let receivers = &mut solution.receivers;
        let light: Vec<Irradiance> = receivers.iter().map(Receiver::mean).collect();
        let of_mesh = distrust(&self.mesh, &light);
        let (mut square, mut area) = (0.0, 0.0);
        for (r, mesh) in receivers.iter_mut().zip(of_mesh) {
            r.distrust(mesh);
            if r.is_lit {
                square += r.expected_error();
                area += r.area();
            }
        }
        let field = solution.indirect.as_mut();
        let field = field.map_or(0.0, |f| teach_field(&self.field, receivers, &light, f));
        Expected {
            mesh: (square / area).sqrt() / mean,
            field: field / mean,
        }
    }
}

/// Takes the errors of the field for what they were found to be, on sides with such mean irradiances; returns what is expected of
/// it then, W/m².
pub(super) fn teach_field(
    points: &[Point],
    receivers: &[Receiver],
    light: &[Irradiance],
    field: &mut IndirectField,
) -> f64 {
    for (r, factor) in receivers.iter().zip(distrust(points, light)) {
        if let Some(f) = r.solve_face {
            field.distrust(f, factor);
        }
    }
    field.estimate_rms()
}

/// Sums over several points.
#[derive(Clone, Copy, Default)]
struct Tally {
    found: f64,
    expected: f64,
    points: usize,
}

impl Tally {
    fn add(&mut self, point: &Point) {
        self.found += point.found.min(MOST_DISTRUST * point.expected);
        self.expected += point.expected;
        self.points += 1;
    }

    /// How many times what was expected has been found, 1 at least.
    fn distrust(&self) -> f64 {
        if self.found > self.expected {
            self.found / self.expected
        } else {
            1.0
        }
    }
}

/// How many times its estimate the squared error of each face has been found to be, given its mean irradiance; 1 where the
/// estimate was enough.
fn distrust(points: &[Point], irradiance: &[Irradiance]) -> Vec<f64> {
    let mut faces = vec![Tally::default(); irradiance.len()];
    points.iter().for_each(|p| faces[p.face].add(p));
    let brightness = |f: usize| {
        irradiance[f]
            .mean()
            .max(f64::MIN_POSITIVE)
            .log(ALIKE)
            .round() as i64
    };
    let mut alike: BTreeMap<i64, Tally> = BTreeMap::new();
    for p in points.iter().filter(|p| faces[p.face].points < FEW_POINTS) {
        alike.entry(brightness(p.face)).or_default().add(p);
    }
    (0..faces.len())
        .map(|f| match faces[f].points {
            FEW_POINTS.. => faces[f].distrust(),
            _ => alike.get(&brightness(f)).map_or(1.0, Tally::distrust),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Rgb;

    fn point(face: usize, found: f64) -> Point {
        Point {
            face,
            found,
            expected: 1.0,
        }
    }

    #[test]
    fn only_what_was_found_to_be_worse_is_distrusted() {
        // Two large faces; of the small ones two are as bright as each other, and one is dark.
        let light = [1.0, 1.0, 50.0, 60.0, 0.01, 60.0].map(|l| Irradiance(Rgb::grey(l)));
        let mut points = vec![point(2, 9.0), point(3, 7.0), point(4, 0.5)];
        points.extend((0..4).map(|_| point(0, 0.5)));
        points.extend((0..4).map(|_| point(1, 4.0)));
        let found = distrust(&points, &light);
        assert_eq!(found, [1.0, 4.0, 8.0, 8.0, 1.0, 8.0]);
        // One bright spot among many points.
        points.push(point(4, 1e9));
        assert_eq!(distrust(&points, &light)[4], (0.5 + MOST_DISTRUST) / 2.0);
        assert_eq!(distrust(&[], &light[..2]), [1.0, 1.0]);
    }
}
