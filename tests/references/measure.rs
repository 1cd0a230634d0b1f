//! What the references cost and can see: `cargo test -- --ignored --nocapture measure`.

use super::UP;
use super::kinks::{broken, kinks_of, order_of};
use crate::common::kinks::{KinkSettings, find_kinks};
use crate::common::path_tracer::{PathSettings, PathTracer};
use crate::common::reference::DirectReference;
use crate::common::rng::Rng;
use crate::common::scenes::read_fixture;
use glam::DVec3;

#[test]
#[ignore = "prints measurements"]
fn measure_the_exact_irradiance() {
    for name in [
        "square-over-square",
        "rotated-blocker",
        "box-on-table",
        "blinds",
    ] {
        let scene = DirectReference::new(&read_fixture(name));
        let mut rng = Rng::new(13);
        let points: Vec<DVec3> = (0..500)
            .map(|_| DVec3::new(rng.range(0.2, 2.8), 0.0, rng.range(0.2, 2.8)))
            .collect();
        let start = std::time::Instant::now();
        let sum: DVec3 = points.iter().map(|&x| scene.irradiance(x, UP)).sum();
        let each = start.elapsed().as_secs_f64() * 1e6 / points.len() as f64;
        eprintln!(
            "{name}: {each:.1} µs a point (mean irradiance {:.6})",
            sum.x / points.len() as f64
        );
        // The light is linear over a nanometre: what the third difference shows is round-off.
        let step = DVec3::X * 1e-9;
        let mut worst: f64 = 0.0;
        let mut squares = 0.0;
        for &x in &points {
            let at = |k: f64| scene.irradiance(x + step * k, UP).x;
            let third = at(3.0) - 3.0 * at(2.0) + 3.0 * at(1.0) - at(0.0);
            worst = worst.max(third.abs());
            squares += third * third / 20.0;
        }
        let rms = (squares / points.len() as f64).sqrt();
        eprintln!("  round-off {rms:.1e} rms, worst third difference {worst:.1e}");
    }
    let scene = DirectReference::new(&read_fixture("blinds"));
    let tracer = PathTracer::new(&read_fixture("blinds"));
    for x in [DVec3::new(1.2, 0.0, 0.46), DVec3::new(2.7, 0.0, 1.4)] {
        let exact = scene.irradiance(x, UP).x;
        let settings = PathSettings {
            paths: 1_000_000,
            bounces: 0,
            seed: 37,
            from_emitters: true,
        };
        let traced = tracer.irradiance(x, UP, &settings);
        let (off, error) = (traced.mean.x / exact - 1.0, traced.standard_error.x / exact);
        eprintln!("blinds, a million random points: off by {off:.1e} ± {error:.1e}");
        for least in 5..=8 {
            let cast = scene.irradiance_by_casting(x, UP, least..=9).x;
            eprintln!(
                "blinds, cast from depth {least}: off by {:.1e}",
                cast / exact - 1.0
            );
        }
    }
}

#[test]
#[ignore = "prints measurements"]
fn measure_what_kinks_can_be_seen() {
    for noise in [1e-15, 1e-14, 1e-12, 1e-10] {
        for order in 0..=2 {
            let (mut smallest, mut misplaced) = (f64::INFINITY, 0.0);
            for tenth in 0..=130 {
                let size = 10_f64.powf(1.0 - f64::from(tenth) / 10.0);
                let mut rng = Rng::new(31);
                let all = (0..30).all(|_| {
                    let at = rng.range(0.1, 0.9);
                    let wobble = std::cell::RefCell::new(rng.clone());
                    let f = |t: f64| {
                        broken(t, &[(at, order, size)])
                            + noise * wobble.borrow_mut().range(-1.0, 1.0)
                    };
                    let settings = KinkSettings {
                        noise: noise.max(1e-14),
                        ..KinkSettings::default()
                    };
                    let found = find_kinks(&f, (0.0, 1.0), &settings);
                    let is_right = found.len() == 1 && order_of(&found[0]) == order;
                    if is_right {
                        misplaced = f64::max(misplaced, (found[0].t - at).abs());
                    }
                    is_right
                });
                if !all {
                    break;
                }
                smallest = size;
            }
            eprintln!(
                "noise {noise:e}, order {order}: jumps down to {smallest:.1e} seen (at most {misplaced:.1e} away)"
            );
        }
    }
    for orders in [[1, 1], [1, 2], [2, 2], [0, 0]] {
        // The greatest distance at which some of fifty pairs are not seen as what they are.
        let mut worst = (0.0, Vec::new());
        let mut rng = Rng::new(41);
        for step in 0..50 {
            let distance = 0.1 * 0.87_f64.powi(step);
            for _ in 0..50 {
                let at = rng.range(0.2, 0.7);
                let breaks = [(at, orders[0], 1.0), (at + distance, orders[1], 1.0)];
                let found: Vec<i32> = kinks_of(&breaks).iter().map(order_of).collect();
                if found != orders && distance > worst.0 {
                    worst = (distance, found);
                }
            }
        }
        eprintln!(
            "orders {orders:?}: all told apart above a distance of {:.1e} (there: {:?})",
            worst.0, worst.1
        );
    }
    let scene = DirectReference::new(&read_fixture("rotated-blocker"));
    let count = std::cell::Cell::new(0);
    let along = |x: f64| {
        count.set(count.get() + 1);
        scene.irradiance(DVec3::new(x, 0.0, 0.1), UP).x
    };
    let found = find_kinks(&along, (-2.7, 2.9), &KinkSettings::default());
    eprintln!(
        "rotated-blocker, one line: {} kinks in {} evaluations",
        found.len(),
        count.get()
    );
    for kink in found {
        eprintln!("  {kink:?}");
    }
}
