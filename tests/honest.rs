//! The error asked for is the error found, at points and by a reference that no stage of the bake has seen.

mod errors;
mod regressions;
mod table;

use crate::common::bake::{bake, world};
use crate::common::fine_field::FineField;
use errors::Errors;
use umbrage::radiosity::Bounces;

/// Points at which errors are measured.
const POINTS: usize = 10_000;

/// What a measurement at random points and a reference may find beyond the error asked for.
const SLACK: f64 = 1.2;

/// Bakes `name` to each error, and fails when more than that is measured. The reference has `fine_elements`.
fn check(name: &str, errors: &[f64], fine_elements: f64) {
    let world = world(name);
    for &asked in errors {
        let solution = bake(&world, asked, Bounces::All);
        let fine = FineField::new(&solution, fine_elements);
        let found = Errors::measure(&solution, fine.as_ref().map(FineField::field), POINTS, 5);
        assert!(
            found.rms <= SLACK * asked,
            "{name} at {asked}: {found:?}, {} elements",
            solution.summary.elements
        );
        // A bake that is far better than asked has wasted its time: here nothing forces that.
        assert!(
            found.rms >= 0.2 * asked,
            "{name} at {asked}: {found:?}, {} elements",
            solution.summary.elements
        );
    }
}

#[test]
fn what_is_measured_does_not_hang_on_where_the_points_fall() {
    let world = world("box-on-table");
    let solution = bake(&world, 0.05, Bounces::All);
    let found: Vec<f64> = (1..13)
        .map(|seed| solution.measure(1000, seed).relative_rms)
        .collect();
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let squares = found.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    let deviation = (squares / found.len() as f64).sqrt();
    // By area alone it is a ninth of it.
    assert!(deviation < 0.06 * mean, "{deviation} of {mean}: {found:?}");
    let errors = Errors::measure(&solution, None, 4 * POINTS, 5);
    let off = mean / errors.interpolation - 1.0;
    assert!(off.abs() < 0.1, "{mean}, by even points {errors:?}");
}

#[test]
fn a_floor_in_soft_shadow_is_as_good_as_asked() {
    for name in ["square-over-square", "rotated-blocker", "crossing-blockers"] {
        check(name, &[0.03, 0.01], 500.0);
    }
}

#[test]
fn a_floor_with_contacts_is_as_good_as_asked() {
    check("blocker-touching-floor", &[0.03, 0.01], 500.0);
}

#[test]
fn a_room_lit_around_a_corner_is_as_good_as_asked() {
    check("l-room", &[0.03], 1500.0);
}
