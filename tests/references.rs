//! The references that other tests trust, held against closed forms and against each other.

mod direct;
mod fixtures;
mod kinks;
mod measure;
mod paths;

use glam::DVec3;

/// The floor's normal.
const UP: DVec3 = DVec3::Y;

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{what}: {found:.15} instead of {expected:.15} ± {tolerance:e}"
    );
}
