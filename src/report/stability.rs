//! Stiff and extreme scenes: is the light finite, not negative, balanced, and as exact as is said?

use super::extremes;
use super::scenes::{blinds, box_on_floor, door_ajar, furnace, moved, square_over_square};
use crate::adapt::Receiver;
use crate::io::builtin::cornell_box;
use crate::pipeline::{LightError, MEASURE_SLACK, Solution, World, light};
use crate::quantity::Rgb;
use crate::radiosity::Bounces;
use crate::scene::RawScene;
use crate::settings::Settings;

/// Error asked for in every case but those of many lamps, which take long at it.
const ERROR: f64 = 0.02;
const ERROR_OF_MANY_LAMPS: f64 = 0.05;

/// One case and how it went.
#[derive(Clone, Debug)]
pub struct StabilityRow {
    /// What is tried.
    pub name: String,
    /// No value is infinite or no number.
    pub is_finite: bool,
    /// No value is below zero.
    pub is_positive: bool,
    /// What is emitted and neither absorbed nor leaves the scene, over all light that arrives.
    pub imbalance: f64,
    /// Whether that is within the error asked for.
    pub is_balanced: bool,
    /// Relative error asked for, and measured by the program.
    pub asked: f64,
    /// As measured by the program.
    pub measured: f64,
    /// Relative error where the light is known on paper.
    pub known: Option<f64>,
    /// Sweeps of the solver.
    pub sweeps: usize,
    /// Rounds of refining.
    pub rounds: usize,
    /// Elements.
    pub elements: usize,
}

impl StabilityRow {
    /// Whether all is as it should be.
    pub fn is_sound(&self) -> bool {
        let honest = self.measured <= (1.0 + MEASURE_SLACK) * self.asked
            && self.known.is_none_or(|k| k <= self.asked);
        self.is_finite && self.is_positive && self.is_balanced && honest
    }
}

/// One scene to try.
#[derive(Clone, Debug)]
pub struct StabilityCase {
    /// What is tried; its source is the name of the case.
    pub raw: RawScene,
    /// Which light.
    pub bounces: Bounces,
    /// Error asked for.
    pub error: f64,
    /// The irradiance (W/m²) everywhere, where that is known on paper.
    pub known: Option<f64>,
}

/// Every case of the table.
pub fn stability_cases() -> Vec<StabilityCase> {
    let of = |raw, bounces, known| StabilityCase {
        raw,
        bounces,
        error: ERROR,
        known,
    };
    let mut cases: Vec<StabilityCase> = [0.1, 0.5, 0.9, 0.99, 0.9999]
        .map(|rho| of(furnace(rho), Bounces::All, Some(1.0)))
        .into();
    cases.extend([0.1, 0.01].map(|gap| of(door_ajar(gap), Bounces::All, None)));
    let far = [
        ("cornell-box × 0.001", 1e-3, 0.0),
        ("cornell-box × 1000", 1e3, 0.0),
        ("cornell-box 10 km away", 1.0, 1e4),
        ("cornell-box 1000 km away", 1.0, 1e6),
    ];
    cases.extend(far.map(|(name, scale, shift)| {
        of(moved(cornell_box(), name, scale, shift), Bounces::All, None)
    }));
    let rooms = [
        extremes::black_floor(),
        extremes::black_speck(),
        extremes::lamps_of_all_powers(),
        extremes::lamps_of_all_sizes(),
        extremes::micrometre_gap(),
        extremes::curtain_on_lamp(),
        extremes::half_covered_lamp(),
    ];
    cases.extend(rooms.map(|raw| of(raw, Bounces::All, None)));
    cases.push(StabilityCase {
        error: ERROR_OF_MANY_LAMPS,
        ..of(extremes::many_lamps(12, 12), Bounces::All, None)
    });
    let direct = [square_over_square(), box_on_floor(), blinds(16)];
    cases.extend(direct.map(|raw| of(raw, Bounces::Count(0), None)));
    let mut dark = square_over_square();
    dark.source = "no light at all".to_owned();
    for material in &mut dark.materials {
        material.emission = Default::default();
    }
    cases.push(of(dark, Bounces::All, Some(0.0)));
    cases
}

/// Tries every case.
///
/// # Errors
/// A fault of our own: the scenes are the report's.
pub fn stability(tell: &mut dyn FnMut(&str)) -> Result<Vec<StabilityRow>, LightError> {
    let rows = stability_cases().into_iter().map(|case| {
        tell(&format!("stability: {}", case.raw.source));
        case.row()
    });
    rows.collect()
}

impl StabilityCase {
    /// Lights the scene, and judges the light.
    ///
    /// # Errors
    /// The scene cannot be lit as asked.
    pub fn row(&self) -> Result<StabilityRow, LightError> {
        let settings = Settings {
            error: self.error,
            bounces: self.bounces,
            ..Settings::default()
        };
        let world = World::new(&self.raw, &settings)?;
        let solution = light(&world, &settings, &mut |_| {})?;
        let lit = || solution.receivers.iter().filter(|r| r.is_lit);
        let values =
            || lit().flat_map(|r| (0..r.mesh.site_vertices.len()).map(|s| r.site_total(s).0));
        let s = &solution.summary;
        let imbalance = imbalance(&solution);
        Ok(StabilityRow {
            name: self.raw.source.clone(),
            is_finite: values().all(Rgb::is_finite),
            is_positive: values().all(|e| e.0.min_element() >= 0.0),
            imbalance,
            is_balanced: imbalance <= self.error,
            asked: self.error,
            measured: s.measured.relative_rms,
            known: self.known.map(|known| off(lit(), known)),
            sweeps: s.solve.residuals.len(),
            rounds: s.rounds,
            elements: s.elements,
        })
    }
}

/// What the account of the energy is off by, over all light that arrives: an error of the light is at most so large in it.
fn imbalance(solution: &Solution) -> f64 {
    let lit = solution.receivers.iter().filter(|r| r.is_lit);
    let arriving: f64 = lit.map(|r| r.power().mean()).sum();
    match solution.energy() {
        Some(energy) if arriving > 0.0 => {
            let emitted = energy.emitted_w.iter().sum::<f64>() / 3.0;
            (energy.imbalance * emitted / arriving).abs()
        }
        _ => 0.0,
    }
}

/// RMS of what the meshes show against the `known` irradiance, over that (or by itself where that is nothing), at the
/// middles of the elements' edges: exact for the square of a linear function.
fn off<'r>(lit: impl Iterator<Item = &'r Receiver>, known: f64) -> f64 {
    let (mut squares, mut area) = (0.0, 0.0);
    for r in lit {
        for e in 0..r.mesh.elements.len() {
            let a = r.mesh.area(e);
            area += a;
            for weights in [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]] {
                let d = r.shown(e, weights).0 + Rgb::grey(-known);
                squares += d.mean_square() * a / 3.0;
            }
        }
    }
    if area <= 0.0 {
        return 0.0;
    }
    (squares / area).sqrt() / if known > 0.0 { known } else { 1.0 }
}
