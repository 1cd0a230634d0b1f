use super::*;
use crate::pipeline::{World, light};
use crate::radiosity::Bounces;
use crate::settings::Settings;

/// A meter that measures nothing.
const NO_METER: MemoryMeter = MemoryMeter {
    reset: || {},
    peak: || None,
};

fn small(errors: &[f64]) -> ReportSettings {
    ReportSettings {
        errors: errors.to_vec(),
        settings: Settings::default(),
        points: 4000,
    }
}

fn measured(raw: crate::scene::RawScene, bounces: Bounces, errors: &[f64]) -> SceneReport {
    let scene = ReportScene {
        name: "a, b".to_owned(),
        raw,
        bounces,
    };
    convergence(&scene, &small(errors), NO_METER, &mut |_| {}).unwrap()
}

#[test]
fn errors_are_those_that_the_program_measures_by_itself() {
    let found = measured(square_over_square(), Bounces::Count(0), &[0.05]);
    assert_eq!(found.records.len(), MESH_METHODS.len() * BASES.len());
    let settings = Settings {
        error: 0.05,
        bounces: Bounces::Count(0),
        samples: Some(4000),
        ..Settings::default()
    };
    let world = World::new(&square_over_square(), &settings).unwrap();
    let own = light(&world, &settings, &mut |_| {}).unwrap().summary;
    let row = |mesh: &str, basis: &str| {
        let is_it = |r: &&Record| r.mesh == mesh && r.basis == basis;
        found.records.iter().find(is_it).unwrap()
    };
    let linear = row("discontinuity", "linear");
    assert_eq!(linear.scene, "a  b");
    assert_eq!(linear.work.elements, own.elements as u64);
    // The same light at other points.
    let ratio = linear.rms / own.measured.relative_rms;
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
    // Constants are worse than what joins their corners, and the same elements under them.
    let constant = row("discontinuity", "constant");
    assert!(constant.rms > 2.0 * linear.rms, "{constant:?} {linear:?}");
    assert_eq!(constant.work, linear.work);
}

#[test]
fn a_furnace_shows_one_everywhere_whatever_shows_it() {
    let found = measured(furnace(0.5), Bounces::All, &[0.1]);
    assert!(found.has_indirect);
    for r in &found.records {
        assert!(r.rms < 1e-3, "{r:?}");
        assert!(r.work.links > 0, "{r:?}");
    }
    for method in SOLVE_METHODS {
        let rows = found.records.iter().filter(|r| r.solver == method.name);
        assert!(rows.count() >= 2, "{}", method.name);
    }
    assert!((found.mean - 1.0).abs() < 1e-3, "{}", found.mean);
}

#[test]
fn a_row_that_is_not_as_it_should_be_is_not_sound() {
    let sound = StabilityRow {
        name: "a".to_owned(),
        is_finite: true,
        is_positive: true,
        imbalance: 0.0,
        is_balanced: true,
        asked: 0.02,
        measured: 0.01,
        known: Some(0.01),
        sweeps: 1,
        rounds: 1,
        elements: 1,
    };
    assert!(sound.is_sound());
    let faults: [fn(&mut StabilityRow); 5] = [
        |r| r.is_finite = false,
        |r| r.is_positive = false,
        |r| r.is_balanced = false,
        |r| r.measured = f64::NAN,
        |r| r.known = Some(0.03),
    ];
    for fault in faults {
        let mut row = sound.clone();
        fault(&mut row);
        assert!(!row.is_sound(), "{row:?}");
    }
}

#[test]
fn the_page_holds_all_of_its_plots_and_pictures() {
    let report = Report {
        scenes: vec![measured(
            square_over_square(),
            Bounces::Count(0),
            &[0.2, 0.1],
        )],
        ..Report::default()
    };
    let plots = report.plots();
    let names: Vec<&str> = plots.iter().map(|p| p.0.as_str()).collect();
    assert_eq!(names, ["a--b-elements", "a--b-seconds"]);
    let html = page(&report, &[vec![("lit <1>".to_owned(), vec![1, 2, 3])]]);
    assert_eq!(html.matches("<svg ").count(), 2);
    assert!(html.contains("data:image/png;base64,AQID") && html.contains("lit &lt;1&gt;"));
    assert!(
        !html.contains("http")
            || html.matches("http").count() == html.matches("http://www.w3.org").count()
    );
    assert!(plots[0].1.svg().contains("discontinuity, linear (slope "));
}
