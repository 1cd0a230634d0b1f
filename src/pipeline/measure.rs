//! How good the result is: what the mesh shows against what is there, at points that no stage has seen.

use super::Solution;
use crate::quantity::Irradiance;
use crate::visibility::Scratch;
use rayon::prelude::*;

/// The measured error over the lit surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Measured {
    /// Points.
    pub samples: u32,
    /// RMS error of irradiance, W/m² (root of the mean square over points and channels).
    pub rms: f64,
    /// RMS error over mean irradiance.
    pub relative_rms: f64,
    /// Largest error at any point, over mean irradiance.
    pub relative_max: f64,
    /// Mean irradiance, W/m².
    pub mean: f64,
    /// Relative RMS error of interpolating over the display mesh what is known of the light (exact direct light and the
    /// interpolated indirect field).
    pub relative_rms_mesh: f64,
    /// Relative RMS error of the indirect field against gathering.
    pub relative_rms_field: f64,
}

/// A permuted congruential generator (O'Neill 2014, XSH RR 64/32): the same points for the same seed on every machine.
struct Pcg(u64);

impl Pcg {
    fn new(seed: u64) -> Self {
        let mut rng = Self(0);
        rng.next();
        rng.0 = rng.0.wrapping_add(seed);
        rng.next();
        rng
    }

    fn next(&mut self) -> u32 {
        let old = self.0;
        self.0 = old
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let shifted = (((old >> 18) ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1).
    fn unit(&mut self) -> f64 {
        f64::from(self.next()) / 4_294_967_296.0
    }
}

struct Sample {
    receiver: usize,
    element: usize,
    weights: [f64; 3],
}

/// Stratified by area over the elements of all lit sides: sample `i` lies in the `i`-th of `n` equal shares.
fn samples(solution: &Solution, n: u32, seed: u64) -> Vec<Sample> {
    let mut cumulative = Vec::new();
    let mut sum = 0.0;
    for (r, receiver) in solution.receivers.iter().enumerate() {
        if receiver.is_lit {
            for e in 0..receiver.mesh.elements.len() {
                sum += receiver.mesh.area(e);
                cumulative.push((sum, r, e));
            }
        }
    }
    if cumulative.is_empty() {
        return Vec::new();
    }
    let mut rng = Pcg::new(seed);
    (0..n)
        .map(|i| {
            let at = sum * (f64::from(i) + rng.unit()) / f64::from(n);
            let k = cumulative
                .partition_point(|c| c.0 <= at)
                .min(cumulative.len() - 1);
            let (root, v) = (rng.unit().sqrt(), rng.unit());
            Sample {
                receiver: cumulative[k].1,
                element: cumulative[k].2,
                weights: [1.0 - root, root * (1.0 - v), root * v],
            }
        })
        .collect()
}

pub(super) fn measure(solution: &Solution, n: u32, seed: u64) -> Measured {
    let samples = samples(solution, n, seed);
    if samples.is_empty() {
        return Measured::default();
    }
    // Shown − exact, shown − (direct + field), field − gathered, and exact.
    let found: Vec<[Irradiance; 4]> = samples
        .par_iter()
        .map_init(
            || {
                (
                    Scratch::default(),
                    solution.indirect.as_ref().map(|f| f.gatherer()),
                )
            },
            |(scratch, gatherer), s| {
                let r = &solution.receivers[s.receiver];
                let p = r.mesh.corners(s.element);
                let w = s.weights;
                let view = r.view(p[0] * w[0] + p[1] * w[1] + p[2] * w[2]);
                let direct = solution.direct.irradiance(&view, scratch);
                let (indirect, field) = match (&solution.indirect, gatherer, r.solve_face) {
                    (Some(field), Some(g), Some(f)) => {
                        let p = r.domain.frame.to_plane(view.position);
                        (field.gather(g, &view), field.at(f, p))
                    }
                    _ => (Irradiance::ZERO, Irradiance::ZERO),
                };
                let shown = r.shown(s.element, w);
                let exact = direct + indirect;
                [
                    shown - exact,
                    shown - (direct + field),
                    field - indirect,
                    exact,
                ]
            },
        )
        .collect();
    let count = found.len() as f64;
    // Summed in order, so that the figure does not depend on the number of threads.
    let mean = found.iter().map(|f| f[3].mean()).sum::<f64>() / count;
    let rms = |k: usize| (found.iter().map(|f| f[k].0.mean_square()).sum::<f64>() / count).sqrt();
    let largest = found
        .iter()
        .map(|f| f[0].0.0.abs().max_element())
        .fold(0.0, f64::max);
    let relative = |x: f64| if mean > 0.0 { x / mean } else { 0.0 };
    Measured {
        samples: found.len() as u32,
        rms: rms(0),
        relative_rms: relative(rms(0)),
        relative_max: relative(largest),
        mean,
        relative_rms_mesh: relative(rms(1)),
        relative_rms_field: relative(rms(2)),
    }
}
