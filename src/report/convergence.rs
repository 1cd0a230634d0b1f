//! Error against cost: every way to mesh, solve and show the light of one scene, from coarse to fine.

use super::methods::{BASES, Basis, MESH_METHODS, MeshMethod, SOLVE_METHODS, SolveMethod};
use super::record::{Record, Work};
use super::scenes::ReportScene;
use crate::adapt::Receiver;
use crate::pipeline::{LeftOut, LightError, LineCount, Solution, Stage, Step, World, light};
use crate::quantity::Irradiance;
use crate::radiosity::Bounces;
use crate::settings::Settings;
use crate::visibility::Scratch;
use rayon::prelude::*;

/// Tells how much memory the process uses. The library knows no operating system.
#[derive(Clone, Copy)]
pub struct MemoryMeter {
    /// Starts a new measurement of the peak.
    pub reset: fn(),
    /// The peak since then, bytes, where the system tells.
    pub peak: fn() -> Option<u64>,
}

/// What is measured.
#[derive(Clone, Debug)]
pub struct ReportSettings {
    /// Errors asked for, from coarse to fine.
    pub errors: Vec<f64>,
    /// How the scenes are lit, but for the error and the ways that are compared.
    pub settings: Settings,
    /// Points at which each run is measured.
    pub points: u32,
}

/// Errors asked for when nobody says otherwise.
pub const ERRORS: [f64; 5] = [0.1, 0.05, 0.02, 0.01, 0.005];

/// Points at which each run is measured: the RMS error of smooth light is then known to 2 %.
pub const POINTS: u32 = 2000;

/// The reference is asked for this share of the finest error: its own error adds less than a tenth in squares.
const REFERENCE_SHARE: f64 = 0.4;

/// A way to mesh that has needed more elements than this is not asked for finer errors: without lines the light that jumps
/// takes millions.
const MOST_ELEMENTS: u64 = 20_000;

/// A run that takes less than this, seconds, is timed so many times more and the least counts: the clock and the threads'
/// start are as long as the work.
const QUICK: f64 = 0.1;
const REPEATS: usize = 4;

/// Cost of one stage of the program's own way at the finest error.
#[derive(Clone, Debug)]
pub struct StageCost {
    /// Name and seconds.
    pub stage: Stage,
    /// The most memory in use up to its end, bytes, where it is known.
    pub peak_bytes: Option<u64>,
}

/// All there is to say of one scene.
#[derive(Clone, Debug)]
pub struct SceneReport {
    /// Name of the scene.
    pub name: String,
    /// Faces after clean-up.
    pub faces: usize,
    /// Mean irradiance, W/m².
    pub mean: f64,
    /// Whether light between surfaces is part of it.
    pub has_indirect: bool,
    /// One row for each run and basis.
    pub records: Vec<Record>,
    /// Stages of the program's own way at the finest error.
    pub stages: Vec<StageCost>,
    /// Lines of that run by order and kind.
    pub lines: Vec<LineCount>,
    /// What that run left out.
    pub left_out: Vec<LeftOut>,
    /// The lit file of that run.
    pub glb: Vec<u8>,
}

/// Measures `scene`. `tell` hears what is being run.
///
/// # Errors
/// What the scene cannot be lit for.
pub fn convergence(
    scene: &ReportScene,
    report: &ReportSettings,
    meter: MemoryMeter,
    tell: &mut dyn FnMut(&str),
) -> Result<SceneReport, LightError> {
    let base = Settings {
        bounces: scene.bounces,
        ..report.settings.clone()
    };
    let world = World::new(&scene.raw, &base)?;
    let run = Runner {
        // Commas part the columns of the table.
        name: scene.name.replace([',', '\n', '\r'], " "),
        world: &world,
        base,
        points: report.points,
        meter,
    };
    let finest = report.errors.iter().copied().fold(f64::INFINITY, f64::min);
    let has_indirect = scene.bounces != Bounces::Count(0);
    let reference = if has_indirect {
        tell(&format!("{}: reference", run.name));
        Some(run.light(
            &MESH_METHODS[MESH_METHODS.len() - 1],
            &SOLVE_METHODS[0],
            finest * REFERENCE_SHARE,
        )?)
    } else {
        None
    };
    let mut found = SceneReport {
        name: run.name.clone(),
        faces: world.clean.faces,
        mean: 0.0,
        has_indirect,
        records: Vec::new(),
        stages: Vec::new(),
        lines: Vec::new(),
        left_out: Vec::new(),
        glb: Vec::new(),
    };
    for (mesh, solver) in pairs(has_indirect) {
        for &error in &report.errors {
            tell(&format!(
                "{}: {} {} at {error}",
                run.name, mesh.name, solver.name
            ));
            (meter.reset)();
            let is_own = mesh.name == MESH_METHODS[MESH_METHODS.len() - 1].name
                && solver.name == SOLVE_METHODS[0].name;
            let run_of = match run.light(mesh, solver, error) {
                Ok(run_of) => run_of,
                // Too large for this solver, and finer ones are no smaller.
                Err(LightError::Input(e)) if !is_own => {
                    found.left_out.push(LeftOut {
                        what: format!("{} at {error} and finer", solver.name),
                        why: e.to_string(),
                    });
                    break;
                }
                Err(e) => return Err(e),
            };
            let peak_bytes = (meter.peak)();
            let truth = reference.as_ref().map_or(&run_of.solution, |r| &r.solution);
            let records = run.records(&run_of, truth, mesh, solver, error, peak_bytes);
            let is_beyond = records.iter().any(|r| r.work.elements > MOST_ELEMENTS);
            found.records.extend(records);
            if is_own && error <= finest {
                found.keep(run_of);
            }
            if is_beyond && !is_own {
                break;
            }
        }
    }
    Ok(found)
}

/// Every way to mesh with the program's own solver, and the program's own mesh with every other solver.
fn pairs(has_indirect: bool) -> Vec<(&'static MeshMethod, &'static SolveMethod)> {
    let own = &MESH_METHODS[MESH_METHODS.len() - 1];
    let mut pairs: Vec<_> = MESH_METHODS
        .iter()
        .map(|m| (m, &SOLVE_METHODS[0]))
        .collect();
    if has_indirect {
        pairs.extend(SOLVE_METHODS[1..].iter().map(|s| (own, s)));
    }
    pairs
}

impl SceneReport {
    /// Keeps what is told of the program's own way only.
    fn keep(&mut self, run: Run) {
        let summary = &run.solution.summary;
        self.mean = summary.measured.mean;
        self.lines = summary.line_counts.clone();
        self.left_out = summary.left_out.clone();
        self.glb = crate::io::write_glb(&run.solution.lit_scene());
        self.stages = summary
            .stages
            .iter()
            .map(|stage| StageCost {
                stage: stage.clone(),
                peak_bytes: run
                    .peaks
                    .iter()
                    .rev()
                    .find(|p| p.0 == stage.name)
                    .map(|p| p.1),
            })
            .collect();
    }
}

struct Runner<'w> {
    name: String,
    world: &'w World,
    base: Settings,
    points: u32,
    meter: MemoryMeter,
}

/// A solution, and the memory in use at the end of each stage.
struct Run<'w> {
    solution: Solution<'w>,
    /// Wall clock without the measuring, of the quickest of several runs.
    seconds: f64,
    peaks: Vec<(&'static str, u64)>,
}

impl<'w> Runner<'w> {
    fn light(
        &self,
        mesh: &MeshMethod,
        solver: &SolveMethod,
        error: f64,
    ) -> Result<Run<'w>, LightError> {
        let mut settings = Settings {
            error,
            meshing: mesh.meshing,
            ..self.base.clone()
        };
        solver.choose(&mut settings);
        let mut run = self.once(&settings)?;
        if run.seconds < QUICK {
            for _ in 0..REPEATS {
                run.seconds = run.seconds.min(self.once(&settings)?.seconds);
            }
        }
        Ok(run)
    }

    fn once(&self, settings: &Settings) -> Result<Run<'w>, LightError> {
        let (mut peaks, mut open) = (Vec::new(), None);
        let mut close = |name: Option<&'static str>| {
            if let (Some(name), Some(bytes)) = (name, (self.meter.peak)()) {
                peaks.push((name, bytes));
            }
        };
        let solution = light(self.world, settings, &mut |step| {
            if let Step::Stage(name, _) = step
                && open != Some(name)
            {
                close(open.replace(name));
            }
        })?;
        close(open);
        let stages = solution.summary.stages.iter();
        let counted = stages.filter(|s| s.name != "measure");
        Ok(Run {
            seconds: counted.map(|s| s.seconds).sum(),
            solution,
            peaks,
        })
    }

    fn records(
        &self,
        run: &Run,
        truth: &Solution,
        mesh: &MeshMethod,
        solver: &SolveMethod,
        asked: f64,
        peak_bytes: Option<u64>,
    ) -> Vec<Record> {
        let summary = &run.solution.summary;
        let seconds = run.seconds;
        let errors = errors(&run.solution, truth, self.points);
        let record = |(basis, found): (&(&str, Basis), &[f64; 2])| Record {
            scene: self.name.clone(),
            mesh: mesh.name.to_owned(),
            solver: if truth.indirect.is_some() {
                solver.name
            } else {
                "direct"
            }
            .to_owned(),
            basis: basis.0.to_owned(),
            asked,
            rms: found[0],
            max: found[1],
            work: Work::of(summary),
            seconds,
            peak_bytes,
        };
        BASES.iter().zip(&errors).map(record).collect()
    }
}

/// RMS and largest error of what each basis shows against the light of `truth`, over the mean of that.
///
/// The points are spread over the lit area by a sequence that leaves no gaps (Roberts 2018, after Kronecker), each in its
/// equal share of it.
fn errors(shown: &Solution, truth: &Solution, points: u32) -> [[f64; 2]; BASES.len()] {
    let lit: Vec<&Receiver> = shown.receivers.iter().filter(|r| r.is_lit).collect();
    let mut sums = vec![0.0];
    let mut elements = Vec::new();
    for (i, r) in lit.iter().enumerate() {
        for e in 0..r.mesh.elements.len() {
            sums.push(sums[elements.len()] + r.mesh.area(e));
            elements.push((i, e));
        }
    }
    let total = sums[elements.len()];
    if elements.is_empty() || total <= 0.0 || points == 0 {
        return [[0.0; 2]; BASES.len()];
    }
    let found: Vec<([Irradiance; BASES.len()], Irradiance)> = (0..points)
        .into_par_iter()
        .map(|i| {
            let u = KRONECKER.map(|step| (step * f64::from(i + 1)).fract());
            let at = total * (f64::from(i) + u[0]) / f64::from(points);
            let k = sums.partition_point(|&s| s <= at) - 1;
            let (r, e) = elements[k.min(elements.len() - 1)];
            let root = u[1].sqrt();
            let weights = [1.0 - root, root * (1.0 - u[2]), root * u[2]];
            at_point(shown, truth, lit[r], e, weights)
        })
        .collect();
    // Summed in order, so that the figures do not depend on the number of threads.
    let count = f64::from(points);
    let mean = found.iter().map(|f| f.1.mean()).sum::<f64>() / count;
    std::array::from_fn(|b| {
        let off = || found.iter().map(move |f| (f.0[b] - f.1).0);
        let rms = (off().map(|d| d.mean_square()).sum::<f64>() / count).sqrt();
        let max = off().map(|d| d.0.abs().max_element()).fold(0.0, f64::max);
        if mean > 0.0 {
            [rms / mean, max / mean]
        } else {
            [rms, max]
        }
    })
}

/// Powers of 1/ρ, ρ⁴ = ρ + 1: the steps along three axes.
const KRONECKER: [f64; 3] = [
    0.819_172_513_396_164_5,
    0.671_043_606_703_789_3,
    0.549_700_477_901_970_3,
];

/// What each basis shows at a point of element `e`, and the light of `truth` there.
fn at_point(
    shown: &Solution,
    truth: &Solution,
    r: &Receiver,
    e: usize,
    weights: [f64; 3],
) -> ([Irradiance; BASES.len()], Irradiance) {
    let mut scratch = Scratch::default();
    let corners = r.mesh.corners(e);
    let at = |w: [f64; 3]| r.view(corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]);
    let view = at(weights);
    let mut exact = truth.direct.irradiance(&view, &mut scratch);
    if let Some(field) = &truth.indirect {
        exact += field.gather(&mut field.gatherer(), &view);
    }
    let third = [1.0 / 3.0; 3];
    let values = BASES.map(|(_, basis)| match basis {
        Basis::Linear => r.shown(e, weights),
        Basis::Constant => {
            let middle = at(third);
            let indirect = shown.indirect.as_ref().zip(r.solve_face);
            let indirect =
                indirect.map(|(field, f)| field.at(f, r.domain.frame.to_plane(middle.position)));
            shown.direct.irradiance(&middle, &mut scratch) + indirect.unwrap_or(Irradiance::ZERO)
        }
    });
    (values, exact)
}
