//! Counts, times and errors of one run, for people and machines.

use super::lines::{line_counts, line_records};
use super::{Energy, ErrorEstimate, LineCount, Measured, Solution};
use crate::adapt::AdaptReport;
use crate::budget::peak_bytes;
use crate::discontinuity::SearchReport;
use crate::radiosity::{Bounces, SolveReport};
use crate::scene::{CleanReport, FaceId, FaceSide};
use crate::settings::Settings;
use serde_json::{Value, json};

/// Wall-clock time and memory of one stage.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// Seconds, all visits together.
    pub seconds: f64,
    /// The most memory that was resident up to its end, bytes; none where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
}

impl Stage {
    /// A stage that ends now after `seconds`.
    pub fn ended(name: &'static str, seconds: f64) -> Self {
        Self {
            name,
            seconds,
            peak_memory_bytes: peak_bytes(),
        }
    }
}

/// What was not done because the scene does not need it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}

/// Everything there is to say about one run.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Summary {
    /// What the clean-up did.
    pub clean: CleanReport,
    /// What the search for lines did.
    pub lines: SearchReport,
    /// Lines that the display meshes hold.
    pub lines_kept: usize,
    /// Contact lines (D0).
    pub contacts: usize,
    /// Lines by order and kind, contact lines among them.
    pub line_counts: Vec<LineCount>,
    /// Sides of faces that may receive light.
    pub sides: usize,
    /// Of these, sides that show light which reaches them.
    pub lit_sides: usize,
    /// Area of the lit sides, m².
    pub lit_area_m2: f64,
    /// Display elements.
    pub elements: usize,
    /// Values at their corners (a vertex on a contact line has one a side).
    pub sites: usize,
    /// How the display mesh was refined.
    pub adapt: AdaptReport,
    /// How the indirect light was solved.
    pub solve: SolveReport,
    /// Where the power goes; none for counted bounces but zero.
    pub energy: Option<Energy>,
    /// RMS of what each correction of the solution by its own residual changed, relative to the mean: an estimate of the error
    /// that it mended.
    pub corrections: Vec<f64>,
    /// Final gathers of the indirect light, those of the solution included.
    pub gathers: usize,
    /// Error asked for, relative.
    pub error_asked: f64,
    /// Estimated interpolation error, relative.
    pub error_estimated: f64,
    /// Estimated error at the vertices, where it was asked for.
    pub error_at_vertices: Option<ErrorEstimate>,
    /// Error measured.
    pub measured: Measured,
    /// Which limit of the budget kept the error above the one asked for: `elements`, `time` or `memory`.
    pub stopped_by: Option<&'static str>,
    /// Rounds of refine and measure.
    pub rounds: usize,
    /// What was measured at the end of each round that another followed.
    pub missed: Vec<Measured>,
    /// Stages in order.
    pub stages: Vec<Stage>,
    /// What was left out.
    pub left_out: Vec<LeftOut>,
    /// Repairs and omissions, in words.
    pub warnings: Vec<String>,
}

impl Summary {
    /// Adds `seconds` to a stage.
    pub fn add_time(&mut self, name: &'static str, seconds: f64) {
        match self.stages.iter_mut().find(|s| s.name == name) {
            Some(s) => {
                s.seconds += seconds;
                s.peak_memory_bytes = peak_bytes();
            }
            None => self.stages.push(Stage::ended(name, seconds)),
        }
    }

    pub(super) fn fill(
        &mut self,
        solution: &Solution,
        is_lit: &[bool],
        sides: &[(FaceId, FaceSide)],
    ) {
        let world = solution.world;
        let receivers = &solution.receivers;
        self.clean = world.clean.clone();
        self.error_asked = solution.settings.error;
        self.warnings = world.warnings.iter().map(ToString::to_string).collect();
        self.warnings.extend(covered(solution));
        self.warnings.extend(self.shortfall(&world.scene.source));
        self.sides = sides.len();
        self.lit_sides = is_lit.iter().filter(|l| **l).count();
        self.lit_area_m2 = receivers
            .iter()
            .filter(|r| r.is_lit)
            .map(|r| r.area())
            .fold(0.0, |sum, area| sum + area);
        self.elements = receivers.iter().map(|r| r.mesh.elements.len()).sum();
        self.sites = receivers.iter().map(|r| r.mesh.site_vertices.len()).sum();
        self.lines_kept = receivers.iter().map(|r| r.kept().count()).sum();
        self.contacts = receivers.iter().map(|r| r.lines.contacts.len()).sum();
        self.gathers = solution.indirect.as_ref().map_or(0, |f| f.gathers());
        self.line_counts = line_counts(solution);
        let mean = self.measured.mean;
        self.error_estimated = if mean > 0.0 {
            self.adapt.estimated_rms / mean
        } else {
            0.0
        };
        self.energy = solution.energy();
        self.left_out(solution);
    }

    /// What the budget has cost, in words.
    fn shortfall(&self, source: &str) -> Option<String> {
        let limit = self.stopped_by?;
        let [asked, found] = [self.error_asked, self.measured.relative_rms].map(|e| 100.0 * e);
        Some(format!(
            "{source}: the budget ({limit}) was used up: the error is {found:.2} %, {asked:.2} % was asked for"
        ))
    }

    fn left_out(&mut self, solution: &Solution) {
        let mut say = |what: String, why: &str| {
            self.left_out.push(LeftOut {
                what,
                why: why.to_owned(),
            });
        };
        if self.sides > self.lit_sides {
            say(
                format!("{} of {} sides", self.sides - self.lit_sides, self.sides),
                "no light reaches them, or they are lamps that reflect nothing",
            );
        }
        if self.lines.is_partial {
            say(
                "lines of short edges far from their emitters".to_owned(),
                "there are too many to look at each",
            );
        }
        if self.lines.is_cut_short {
            say(
                "lines that had not been looked for".to_owned(),
                "the budget was used up",
            );
        }
        let found: usize = solution
            .receivers
            .iter()
            .map(|r| r.lines.candidates.len())
            .sum();
        if found > self.lines_kept {
            // Contact lines are always kept.
            let strongest = line_records(solution)
                .iter()
                .filter(|l| !l.is_kept)
                .map(|l| l.jump)
                .fold(0.0, f64::max);
            say(
                format!(
                    "{} of {found} lines, {strongest:.3} W/m² at most",
                    found - self.lines_kept
                ),
                "elements without them are as good at the error asked for",
            );
        }
        if let Some(w) = &self.solve.wavelets {
            let dropped = w.dropped_links;
            say(
                format!("{dropped} of {} links", dropped + self.solve.links),
                "all wavelets that a point does without bring less than the error asked for permits one link to miss",
            );
        }
        let by_rays = solution.direct.looks_by_rays();
        if by_rays > 0 {
            say(
                format!("exact cutting of {by_rays} views of emitters"),
                "rays tell as much where a crowd of blockers stands between",
            );
        }
        let hidden = solution.direct.hidden_sights();
        if hidden > 0 {
            say(
                format!("{hidden} times all looks from a face, or a piece of one, at an emitter"),
                "other faces hide it from all of that",
            );
        }
        if solution.indirect.is_none() {
            let why = if solution.settings.bounces == Bounces::Count(0) {
                "no bounces were asked for"
            } else {
                "nothing reflects"
            };
            say("indirect light".to_owned(), why);
        }
    }
}

/// Faces that are hidden in part by others in their plane, in words.
fn covered(solution: &Solution) -> Option<String> {
    let mut faces: Vec<FaceId> = solution
        .receivers
        .iter()
        .filter(|r| !r.lines.covers.is_empty())
        .map(|r| r.domain.face)
        .collect();
    faces.dedup();
    let source = &solution.world.scene.source;
    (!faces.is_empty()).then(|| {
        format!(
            "{source}: faces that others cover in the same plane: {} (of two the smaller is seen, an emitter before all)",
            faces.len()
        )
    })
}

/// What the lit file says about itself.
pub(super) fn extras(solution: &Solution, settings: &Settings) -> Value {
    let s = &solution.summary;
    json!({
        "umbrage": {
            "version": env!("CARGO_PKG_VERSION"),
            "source": solution.world.scene.source,
            "error_asked": settings.error,
            "error_measured_rms": s.measured.relative_rms,
            "error_measured_max": s.measured.relative_max,
            "samples": s.measured.samples,
            "seed": settings.seed,
            "bounces": match settings.bounces {
                Bounces::All => json!("all"),
                Bounces::Count(n) => json!(n),
            },
        }
    })
}
