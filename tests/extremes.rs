//! Stiff scenes and extreme ones: the light is finite, not negative, balanced, and as exact as is said.

use std::collections::HashSet;
use std::time::Instant;
use umbrage::radiosity::Bounces;
use umbrage::report::{StabilityCase, many_lamps, stability_cases};

/// Lights the scene, and holds the light to what must be true of it.
fn check(case: &StabilityCase) {
    let start = Instant::now();
    let row = case.row().expect("a scene of the report");
    let seconds = start.elapsed().as_secs_f64();
    eprintln!("{seconds:.1} s: {row:?}");
    assert!(row.is_sound(), "{row:?}");
    let lit = case.known != Some(0.0);
    assert_eq!(row.measured > 0.0, lit, "{row:?}");
}

#[test]
fn every_case_of_the_report_is_sound() {
    let cases = stability_cases();
    let names: HashSet<&str> = cases.iter().map(|c| c.raw.source.as_str()).collect();
    assert_eq!(names.len(), cases.len(), "two cases have one name");
    cases.iter().for_each(check);
}

#[test]
#[ignore = "minutes: cost grows with the square of the lamps"]
fn two_thousand_lamps() {
    check(&StabilityCase {
        raw: many_lamps(50, 40),
        bounces: Bounces::All,
        error: 0.05,
        known: None,
    });
}
