//! A budget is kept, what comes of it is the best there is, and it says how good that is.

use crate::common::bake::{settings, world};
use umbrage::budget::Budget;
use umbrage::pipeline::{LeftOut, Solution, World, light};
use umbrage::radiosity::Bounces;
use umbrage::settings::Settings;

const SCENE: &str = "box-on-table";

/// Finer than any budget here allows.
const ERROR: f64 = 0.004;

fn lit<'a>(world: &'a World, error: f64, bounces: Bounces, budget: Budget) -> Solution<'a> {
    let settings = Settings {
        budget,
        ..settings(error, bounces)
    };
    light(world, &settings, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"))
}

fn elements(most: usize) -> Budget {
    Budget {
        elements: Some(most),
        ..Budget::default()
    }
}

#[test]
fn elements_are_kept_to_and_more_of_them_are_better() {
    let world = world(SCENE);
    let mut last = f64::INFINITY;
    for most in [300, 600, 1200] {
        let solution = lit(&world, ERROR, Bounces::All, elements(most));
        let s = &solution.summary;
        assert!(s.elements <= most, "{} of {most}", s.elements);
        assert!(10 * s.elements > 9 * most, "{} of {most}", s.elements);
        assert_eq!(s.stopped_by, Some("elements"));
        let found = s.measured.relative_rms;
        assert!(found > ERROR && found < last, "{found} after {last}");
        last = found;
        let told = s.warnings.last().expect("a warning");
        let percent = format!("{:.2} %", 100.0 * found);
        assert!(
            told.contains("(elements)") && told.contains(&percent),
            "{told}"
        );
    }
}

#[test]
fn a_mesh_within_a_budget_is_as_good_as_one_that_stops_there_by_itself() {
    let world = world(SCENE);
    for bounces in [Bounces::Count(0), Bounces::All] {
        let free = lit(&world, 0.02, bounces, Budget::default());
        let most = free.summary.elements;
        let bound = lit(&world, ERROR, bounces, elements(most));
        // The estimates: a thousand points tell errors of single elements that stand out from such of all.
        let [free, bound] = [&free, &bound].map(|s| s.summary.error_estimated);
        assert!(bound < 1.15 * free, "{bound} with a budget, {free} without");
    }
}

#[test]
fn a_budget_that_suffices_changes_nothing() {
    let world = world(SCENE);
    let plenty = Budget {
        elements: Some(1_000_000),
        seconds: Some(1e6),
        memory: Some(u64::MAX),
    };
    let [free, bound] = [Budget::default(), plenty].map(|b| lit(&world, 0.03, Bounces::All, b));
    assert_eq!(bound.summary.stopped_by, None);
    assert_eq!(bound.summary.warnings, free.summary.warnings);
    for (a, b) in free.receivers.iter().zip(&bound.receivers) {
        assert_eq!(a.mesh.elements, b.mesh.elements);
        assert_eq!((&a.direct, &a.indirect), (&b.direct, &b.indirect));
    }
}

#[test]
fn without_time_or_memory_the_first_mesh_is_shown_with_its_error() {
    let world = world(SCENE);
    let late = Budget {
        seconds: Some(1e-9),
        ..Budget::default()
    };
    let full = Budget {
        memory: Some(1),
        ..Budget::default()
    };
    for (budget, name) in [(late, "time"), (full, "memory")] {
        if name == "memory" && !cfg!(target_os = "linux") {
            continue;
        }
        let solution = lit(&world, ERROR, Bounces::All, budget);
        let s = &solution.summary;
        assert_eq!(s.stopped_by, Some(name));
        assert!(s.measured.relative_rms > ERROR && s.measured.mean > 0.0);
        // Memory is not looked at before the mesh.
        assert_eq!(s.lines.is_cut_short, name == "time");
        assert_eq!(s.lines.wedges == 0, name == "time");
        let says = |l: &LeftOut| l.why.contains("budget");
        assert_eq!(s.left_out.iter().any(says), name == "time");
        assert!(
            s.elements > 0 && s.adapt.passes <= 2,
            "{} passes",
            s.adapt.passes
        );
    }
}
