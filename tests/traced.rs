//! Bakes against a path tracer of our own at random points of all surfaces, as one figure: the RMS error.
//!
//! The direct part of the truth is the exact query's (held against an independent one elsewhere), the indirect part is
//! traced. Its noise would add to a squared difference; so each point is traced twice, with different paths, and the product
//! of the two differences is taken: its mean is the squared error of the bake alone.

use crate::common::bake::{bake, clean, raw, surface_points};
use crate::common::library::mesh_of_scene;
use crate::common::path_tracer::{PathSettings, PathTracer};
use rayon::prelude::*;
use std::time::Instant;
use umbrage::io::builtin::cornell_box;
use umbrage::pipeline::Solution;
use umbrage::radiosity::Bounces;
use umbrage::scene::RawScene;
use umbrage::visibility::Scratch;

/// What may be found beyond the error asked for.
const SLACK: f64 = 1.2;

/// Standard errors that chance may account for: once in 700 runs.
const CHANCE: f64 = 3.0;

/// Points, and paths for each of the two estimates at each of them.
#[derive(Clone, Copy)]
struct Effort {
    points: usize,
    paths: u32,
}

/// Mean square of the relative error, and its standard error.
#[derive(Clone, Copy, Debug)]
struct SquaredError {
    value: f64,
    standard_error: f64,
}

impl SquaredError {
    fn rms(&self) -> f64 {
        self.value.max(0.0).sqrt()
    }

    /// The largest RMS error that chance allows.
    fn at_most(&self) -> f64 {
        (self.value + CHANCE * self.standard_error).max(0.0).sqrt()
    }

    /// The smallest RMS error that chance allows.
    fn at_least(&self) -> f64 {
        (self.value - CHANCE * self.standard_error).max(0.0).sqrt()
    }
}

fn measure(solution: &Solution, effort: Effort) -> SquaredError {
    let tracer = PathTracer::new(&mesh_of_scene(&solution.world.scene));
    let points = surface_points(solution, effort.points, 211);
    // Product of the differences, and the light, by point.
    let found: Vec<(f64, f64)> = points
        .par_iter()
        .enumerate()
        .map(|(i, p)| {
            let view = p.view(solution);
            let direct = solution
                .direct
                .irradiance(&view, &mut Scratch::default())
                .0
                .0;
            let shown = solution.receivers[p.receiver]
                .shown(p.element, p.weights)
                .0
                .0;
            let [a, b] = [0, 1].map(|half| {
                let settings = PathSettings {
                    paths: effort.paths,
                    bounces: 10_000,
                    seed: 1009 * i as u64 + half,
                    from_emitters: true,
                };
                let traced = tracer.indirect(view.position, view.horizon.normal, &settings);
                direct + traced.mean
            });
            let product = (shown - a).dot(shown - b) / 3.0;
            (product, (a + b).element_sum() / 6.0)
        })
        .collect();
    let n = found.len() as f64;
    let light = found.iter().map(|f| f.1).sum::<f64>() / n;
    let mean = found.iter().map(|f| f.0).sum::<f64>() / n;
    let variance = found.iter().map(|f| (f.0 - mean).powi(2)).sum::<f64>() / (n - 1.0);
    SquaredError {
        value: mean / (light * light),
        standard_error: (variance / n).sqrt() / (light * light),
    }
}

/// Bakes and measures; fails when the error is certainly beyond the limit, or when the measurement could not tell.
fn check(raw: &RawScene, asked: f64, effort: Effort) -> SquaredError {
    let world = clean(raw);
    let solution = bake(&world, asked, Bounces::All);
    let start = Instant::now();
    let found = measure(&solution, effort);
    eprintln!(
        "{} at {asked}: {:.4} traced ({:.4} … {:.4}), {:.4} measured by itself; {:.1} s of tracing",
        raw.source,
        found.rms(),
        found.at_least(),
        found.at_most(),
        solution.summary.measured.relative_rms,
        start.elapsed().as_secs_f64(),
    );
    assert!(
        found.at_least() <= SLACK * asked,
        "{}: {found:?} for {asked}",
        raw.source
    );
    let blind = CHANCE * found.standard_error;
    assert!(
        blind <= asked * asked,
        "{}: too noisy to tell: {found:?}",
        raw.source
    );
    found
}

#[test]
fn the_cornell_box_is_what_paths_find() {
    let effort = Effort {
        points: 400,
        paths: 400,
    };
    check(&cornell_box(), 0.05, effort);
}

#[test]
fn a_box_on_a_table_is_what_paths_find() {
    let effort = Effort {
        points: 4800,
        paths: 200,
    };
    check(&raw("box-on-table"), 0.03, effort);
}

#[test]
#[ignore = "a hundred million paths: minutes in release"]
fn bakes_to_a_percent_are_what_a_hundred_million_paths_find() {
    let asked = 0.01;
    let effort = |points, paths| Effort { points, paths };
    let mut scenes = vec![(cornell_box(), effort(3000, 6000))];
    // Paths are longest where surfaces reflect most, and there the light is even.
    scenes.extend([
        (raw("blinds"), effort(3000, 3000)),
        (raw("box-on-table"), effort(3000, 6000)),
        (raw("l-room"), effort(3000, 6000)),
        (raw("furnace-cornell-r90"), effort(300, 3000)),
    ]);
    let found: Vec<SquaredError> = scenes
        .iter()
        .map(|(raw, effort)| check(raw, asked, *effort))
        .collect();
    for error in found {
        assert!(error.rms() <= SLACK * asked, "{error:?}");
        assert!(error.standard_error <= 0.25 * asked * asked, "{error:?}");
    }
}
