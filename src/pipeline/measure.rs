//! How good the result is: what the mesh shows against what is there, at points that no stage has seen.

use super::Solution;
use super::evidence::{Evidence, Point};
use super::random::Pcg;
use crate::adapt::Receiver;
use crate::quantity::Irradiance;
use crate::radiosity::{Gatherer, IndirectField};
use crate::visibility::Scratch;
use glam::DVec2;
use rayon::prelude::*;

/// The measured error over the lit surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Measured {
    /// Points; indirect light is gathered at every fourth of them.
    pub samples: u32,
    /// RMS error of irradiance, W/m² (root of the mean square over points and channels); never less than that of either part
    /// below.
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

/// Indirect light is gathered at one of so many points: it is far dearer than direct light, and its field far smoother.
const GATHER_STRIDE: usize = 4;

/// Where it is not said at how many points: one for each so many lit sides, and how few and many at all. A few bright spots
/// among tens of thousands of sides decide, which a thousand points find or do not.
const SIDES_PER_SAMPLE: usize = 4;
const FEWEST_SAMPLES: usize = 1000;
const MOST_SAMPLES: usize = 5000;

/// Points at which to measure when it is not said.
pub(super) fn default_samples(receivers: &[Receiver]) -> u32 {
    let lit = receivers.iter().filter(|r| r.is_lit).count();
    (lit / SIDES_PER_SAMPLE).clamp(FEWEST_SAMPLES, MOST_SAMPLES) as u32
}

struct Sample {
    receiver: usize,
    element: usize,
    weights: [f64; 3],
    /// How many times the area that it stands for the mean point's is.
    counts: f64,
}

impl Sample {
    /// Frame coordinates on its receiver.
    fn place(&self, r: &Receiver) -> DVec2 {
        let (p, w) = (r.mesh.corners(self.element), self.weights);
        p[0] * w[0] + p[1] * w[1] + p[2] * w[2]
    }
}

/// What an element of the display mesh has of the whole.
struct Share {
    receiver: usize,
    element: usize,
    area: f64,
    /// Integrals of the squared light on it and of the squared error that is expected of it, W²/m².
    squares: [f64; 2],
}

/// Mean squares of the light that an element shows and of the error that is expected of it, (W/m²)².
fn shown(solution: &Solution, receiver: usize, element: usize) -> [f64; 2] {
    let r = &solution.receivers[receiver];
    let corners = r.mesh.sites[element].map(|s| r.site_total(s as usize).0.mean_square());
    let of_field = match (&solution.indirect, r.solve_face) {
        (Some(field), Some(f)) => field.interpolation_error_at(f, r.mesh.centre(element)),
        _ => 0.0,
    };
    let expected = r.expected_square(element) + of_field.powi(2);
    [corners.iter().sum::<f64>() / 3.0, expected]
}

/// Stratified over the elements of all lit sides, in equal parts by their area, by their squared light and by the squared error
/// that is expected of them, of which `means(receiver, element)` tells the mean squares: sample `i` lies in the `i`-th of `n`
/// equal shares.
///
/// Errors are the largest where light is the brightest, beside lamps: a square centimetre there may be off by as much as all
/// else. By area alone a thousand points seldom find it, and say that there is no error, or find it once and say far too much.
fn samples(
    receivers: &[Receiver],
    n: u32,
    seed: u64,
    means: impl Fn(usize, usize) -> [f64; 2],
) -> Vec<Sample> {
    let lit = receivers.iter().enumerate().filter(|r| r.1.is_lit);
    let shares: Vec<Share> = lit
        .flat_map(|(r, receiver)| (0..receiver.mesh.elements.len()).map(move |e| (r, e)))
        .map(|(r, e)| {
            let area = receivers[r].mesh.area(e);
            Share {
                receiver: r,
                element: e,
                area,
                squares: means(r, e).map(|mean| area * mean),
            }
        })
        .collect();
    let parts = |share: &Share| [share.area, share.squares[0], share.squares[1]];
    let mut sums = [0.0; 3];
    for share in &shares {
        for (sum, part) in sums.iter_mut().zip(parts(share)) {
            *sum += part;
        }
    }
    if sums[0] <= 0.0 {
        return Vec::new();
    }
    let present = sums.iter().filter(|s| **s > 0.0).count() as f64;
    // The density of the samples at each element, over its mean.
    let density = |share: &Share| {
        let parts = parts(share).into_iter().zip(sums);
        let all: f64 = parts
            .filter(|p| p.1 > 0.0)
            .map(|(part, sum)| part / sum)
            .sum();
        all / present * sums[0] / share.area
    };
    let mut cumulative = Vec::with_capacity(shares.len());
    let mut sum = 0.0;
    for (k, share) in shares.iter().enumerate().filter(|s| s.1.area > 0.0) {
        sum += share.area * density(share);
        cumulative.push((sum, k));
    }
    let mut rng = Pcg::new(seed);
    (0..n)
        .map(|i| {
            let at = sum * (f64::from(i) + rng.unit()) / f64::from(n);
            let k = cumulative
                .partition_point(|c| c.0 <= at)
                .min(cumulative.len() - 1);
            let share = &shares[cumulative[k].1];
            let (root, v) = (rng.unit().sqrt(), rng.unit());
            Sample {
                receiver: share.receiver,
                element: share.element,
                weights: [1.0 - root, root * (1.0 - v), root * v],
                counts: density(share).recip(),
            }
        })
        .collect()
}

pub(super) fn measure(solution: &Solution, n: u32, seed: u64) -> (Measured, Evidence) {
    let samples = samples(&solution.receivers, n, seed, |r, e| shown(solution, r, e));
    if samples.is_empty() {
        return Default::default();
    }
    let tools = || Tools {
        scratch: Scratch::default(),
        gatherer: solution.indirect.as_ref().map(|f| f.gatherer()),
    };
    let found: Vec<Found> = samples
        .par_iter()
        .enumerate()
        .map_init(tools, |tools, (i, s)| look(solution, s, i, tools))
        .collect();
    // Summed in order, so that the figures do not depend on the number of threads.
    let average = |values: &mut dyn Iterator<Item = (f64, f64)>| {
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for (counts, v) in values {
            sum += counts * v;
            count += 1.0;
        }
        sum / count.max(1.0)
    };
    let all = || samples.iter().map(|s| s.counts).zip(&found);
    // Light is much the same where much and where little of the area is: over what the points count for in fact, not over their
    // number, it hardly depends on where they happen to be.
    let counted: f64 = samples.iter().map(|s| s.counts).sum();
    let mean =
        average(&mut all().map(|(c, f)| (c, f.known.mean()))) * samples.len() as f64 / counted;
    let mesh = average(&mut all().map(|(c, f)| (c, f.off_known.0.mean_square())));
    let gathered = || all().filter_map(|(c, f)| Some((c, f.off_known, f.field_off?)));
    let field = average(&mut gathered().map(|(c, _, g)| (c, g.0.mean_square())));
    // (a + b)² = a² + (2ab + b²): the first at all points, the rest where it is known.
    let cross = |m: Irradiance, g: Irradiance| (m + g).0.mean_square() - m.0.mean_square();
    let cross = average(&mut gathered().map(|(c, m, g)| (c, cross(m, g))));
    let largest = found
        .iter()
        .map(|f| f.off_known + f.field_off.unwrap_or_default())
        .map(|off| off.0.0.abs().max_element())
        .fold(0.0, f64::max);
    let relative = |x: f64| if mean > 0.0 { x / mean } else { 0.0 };
    // A few points where both happen to cancel do not make the whole better than either part.
    let rms = (mesh + cross).max(mesh).max(field).sqrt();
    let measured = Measured {
        samples: found.len() as u32,
        rms,
        relative_rms: relative(rms),
        relative_max: relative(largest),
        mean,
        relative_rms_mesh: relative(mesh.sqrt()),
        relative_rms_field: relative(field.sqrt()),
    };
    (measured, evidence(solution, &samples, &found))
}

/// How far the indirect field is off, W/m² (root of the mean square), and what was found against what was expected, before
/// anything shows it: at as many points as it is gathered at to measure at `n`.
pub(super) fn probe(
    receivers: &[Receiver],
    field: &IndirectField,
    n: u32,
    seed: u64,
) -> (f64, Vec<Point>) {
    let at_centre = |r: usize, e: usize| {
        let Some(f) = receivers[r].solve_face else {
            return [0.0; 2];
        };
        let p = receivers[r].mesh.centre(e);
        let expected = field.interpolation_error_at(f, p).powi(2);
        [field.at(f, p).0.mean_square(), expected]
    };
    let samples = samples(receivers, n / GATHER_STRIDE as u32, seed, at_centre);
    let points: Vec<Point> = samples
        .par_iter()
        .map_init(
            || field.gatherer(),
            |gatherer, s| {
                let r = &receivers[s.receiver];
                let (f, p) = (r.solve_face?, s.place(r));
                let off = field.at(f, p) - field.gather(gatherer, &r.view(p));
                Some(Point::of_field(s, off, field, f, p))
            },
        )
        .flatten()
        .collect();
    let square: f64 = points.iter().map(|p| p.found).sum();
    ((square / samples.len().max(1) as f64).sqrt(), points)
}

impl Point {
    /// Where the field on solve face `f` is `off` at a sample, whose place is `p`.
    fn of_field(s: &Sample, off: Irradiance, field: &IndirectField, f: usize, p: DVec2) -> Self {
        Self {
            face: s.receiver,
            found: s.counts * off.0.mean_square(),
            expected: s.counts * field.interpolation_error_at(f, p).powi(2),
        }
    }
}

/// What was found against what was expected.
fn evidence(solution: &Solution, samples: &[Sample], found: &[Found]) -> Evidence {
    let mut evidence = Evidence::default();
    for (s, found) in samples.iter().zip(found) {
        let r = &solution.receivers[s.receiver];
        evidence.mesh.push(Point {
            face: s.receiver,
            found: s.counts * found.off_known.0.mean_square(),
            expected: s.counts * r.expected_square(s.element),
        });
        if let (Some(off), Some(field), Some(f)) =
            (found.field_off, &solution.indirect, r.solve_face)
        {
            let point = Point::of_field(s, off, field, f, s.place(r));
            evidence.field.push(point);
        }
    }
    evidence
}

/// The buffers of one thread.
struct Tools<'a> {
    scratch: Scratch,
    gatherer: Option<Gatherer<'a>>,
}

/// What was found at one point.
struct Found {
    /// Exact direct light and the indirect field.
    known: Irradiance,
    /// What the mesh shows less that.
    off_known: Irradiance,
    /// The indirect field less what is gathered, where it was gathered.
    field_off: Option<Irradiance>,
}

/// What is found at sample number `i`.
fn look(solution: &Solution, s: &Sample, i: usize, tools: &mut Tools) -> Found {
    let r = &solution.receivers[s.receiver];
    let view = r.view(s.place(r));
    // Not the rays that the vertices looked by, and others at each sample.
    let (direct, doubt) = (&solution.direct, solution.tolerance);
    let mut known = direct
        .look_past_crowds(&view, doubt, 1 + i as u32, &mut tools.scratch)
        .light;
    let mut field_off = None;
    if let (Some(field), Some(gatherer), Some(f)) =
        (&solution.indirect, &mut tools.gatherer, r.solve_face)
    {
        let indirect = field.at(f, r.domain.frame.to_plane(view.position));
        known += indirect;
        field_off = i
            .is_multiple_of(GATHER_STRIDE)
            .then(|| indirect - field.gather(gatherer, &view));
    }
    Found {
        known,
        off_known: r.shown(s.element, s.weights) - known,
        field_off,
    }
}
