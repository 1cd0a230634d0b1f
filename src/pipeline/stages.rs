//! The stages of a bake, one function each, and what they share: the settings, the budget, the clock and the summary.

use super::aim::Aim;
use super::evidence::{Evidence, teach_field};
use super::guess::Guess;
use super::indirect::{Rooms, Shown, request};
use super::lit::greatest_mean;
use super::measure::{default_samples, measure, probe};
use super::{LightError, Measured, Progress, Solution, Step, Summary, World, domain, mean_of};
use crate::adapt::{self, AdaptReport, Illumination, Meshing, Receiver};
use crate::bad_input::BadInput;
use crate::budget::{Limit, Meter};
use crate::direct::{DirectLight, Vantage};
use crate::discontinuity::{FaceLines, LineMap, LineTolerance, check_outlines, find_lines_within};
use crate::mesh::{FaceDomain, MeshError};
use crate::quantity::Irradiance;
use crate::radiosity::{IndirectField, SolveMesh, SolveReport, TooManyUnknowns, check_size};
use crate::scene::{FaceId, FaceSide, Scene, Size};
use crate::settings::Settings;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Lines of the second kind are left out when they change less than this share of the error asked for, relative to what
/// the emitter gives there unoccluded: through the slats of a blind they are many, and elements are cheaper than lines.
const LINE_FLOOR: f64 = 1.0;

/// Lines that break by less than this share of the error asked for, of the mean irradiance that all emitters together could give,
/// are left out: of hundreds of lamps each is dim in most of the building.
const LINE_LEAST: f64 = 0.25;

/// Chords of arcs are off by this share of the error asked for, relative to the size of their face: a tenth of a percent
/// of it for an error of one.
const LINE_CHORD: f64 = 0.1;

/// Pairs of neighbouring points whose outlines of the emitters are compared, to tell whether lines were missed.
const OUTLINE_PAIRS: usize = 200;

/// A measured error that exceeds the one asked for by less than this share is let be: it is known to a few per cent, and
/// another round costs as much as all before.
pub const MEASURE_SLACK: f64 = 0.05;

/// So many times the points at which a mesh is first measured tell whether it has to be better.
const MORE_POINTS: u32 = 4;

/// The mesh is refined again at most so often when the measured error exceeds the one asked for.
const MAX_ROUNDS: usize = 4;

/// The solution is corrected by its own residual until all further corrections together would stay below this share of the
/// permitted error, if each is smaller than the one before by as much as the last. By the links that gathers have left a correction
/// costs little.
const CORRECTION_SHARE: f64 = 0.1;

/// The first correction is made once the field is within this many times its permitted error.
const FIRST_CORRECTION: f64 = 3.0;

/// A field that was within its permitted error before a correction is left as it is while it is within so many times that
/// after it: what the estimate takes for error there is in part what the correction's own gathers miss.
const CORRECTED_SLACK: f64 = 1.25;

/// Corrections at most, a round.
const MAX_CORRECTIONS: usize = 8;

/// The seeds of the points at which the field is held against gathers early start here: not those of the final measure.
const PROBE_SEED: u64 = 1 << 32;

/// One bake while it runs.
pub(super) struct Run<'r, 'p> {
    settings: &'r Settings,
    meter: Meter,
    clock: Clock<'r, 'p>,
    summary: Summary,
}

impl<'r, 'p> Run<'r, 'p> {
    pub(super) fn new(settings: &'r Settings, progress: &'r mut Progress<'p>) -> Self {
        Self {
            settings,
            meter: Meter::new(settings.budget),
            clock: Clock::new(progress),
            summary: Summary::default(),
        }
    }

    /// Begins the stage `name`.
    pub(super) fn start(&mut self, name: &'static str) {
        self.clock.start(name, &mut self.summary);
    }

    /// Ends the last stage.
    pub(super) fn finish(mut self) -> Summary {
        self.clock.finish(&mut self.summary);
        self.summary
    }

    /// The lines along which the light of the emitters breaks.
    pub(super) fn find_lines(
        &mut self,
        scene: &Scene,
        direct: &DirectLight,
        sides: &[(FaceId, FaceSide)],
    ) -> LineMap {
        self.start("lines");
        let error = self.settings.error;
        let tolerance = LineTolerance {
            floor: error * LINE_FLOOR,
            least: error * LINE_LEAST * greatest_mean(scene, sides),
            chord: error * LINE_CHORD,
        };
        let mut lines = find_lines_within(&self.meter, scene, direct, tolerance);
        if !lines.report.is_cut_short {
            lines.report.outlines = check_outlines(scene, direct, &lines, tolerance, OUTLINE_PAIRS);
        }
        self.summary.lines = lines.report;
        lines
    }

    /// The mesh to solve on.
    pub(super) fn solve_mesh(
        &self,
        world: &World,
        rooms: &Rooms,
        direct: &DirectLight,
        guess: Guess,
    ) -> Result<SolveMesh, LightError> {
        let settings = self.settings;
        let mesh = rooms.solve_mesh(settings.error, direct, guess)?;
        check_size(&mesh, &world.blockers, settings.solver, settings.basis)
            .map_err(|e| too_many(world, e))?;
        Ok(mesh)
    }

    /// Refines the display meshes; `mean_besides` (W/m²) is the mean of light that comes later. Once time is up, indirect light
    /// is shown on them as they are.
    pub(super) fn refine_display(
        &mut self,
        aim: &mut Aim,
        receivers: &mut [Receiver],
        direct: &DirectLight,
        indirect: Option<&IndirectField>,
        mean_besides: f64,
    ) -> Result<(), MeshError> {
        let light = Illumination {
            direct,
            tolerance: aim.weak,
            indirect,
        };
        if indirect.is_some() && self.meter.is_used_up() {
            receivers
                .par_iter_mut()
                .for_each(|r| r.show_indirect(&light));
            return Ok(());
        }
        let target = self.settings.error * aim.display;
        let (meter, clock) = (&self.meter, &mut self.clock);
        let tick = |f| clock.tick(f);
        if indirect.is_some() {
            receivers.iter_mut().for_each(Receiver::relight);
        }
        let mesher = &mut aim.mesher;
        let report = mesher.refine(receivers, &light, target, mean_besides, meter, tick)?;
        self.summary.adapt.add(&report);
        Ok(())
    }

    /// Solves for the indirect light, given the direct light that the receivers show.
    pub(super) fn solve<'a>(
        &mut self,
        world: &'a World,
        mesh: SolveMesh,
        receivers: &mut [Receiver],
        mean_indirect: f64,
    ) -> Result<IndirectField<'a>, LightError> {
        self.start("solve");
        let index: Vec<(FaceId, FaceSide)> = mesh
            .faces
            .iter()
            .map(|f| (f.domain.face, f.domain.side))
            .collect();
        for r in &mut *receivers {
            r.solve_face = index.binary_search(&(r.domain.face, r.domain.side)).ok();
        }
        let mean = mean_of(receivers) + mean_indirect;
        let shown = Shown::new(receivers, mesh.faces.len());
        let request = request(self.settings, mean, mean_indirect);
        let (field, report) =
            IndirectField::solve(mesh, &world.blockers, request, |_, f, p| shown.direct(f, p))
                .map_err(|e| too_many(world, e))?;
        if !report.is_settled {
            return Err(unsettled(world, &report).into());
        }
        self.summary.solve = report;
        Ok(field)
    }

    /// Gathers the indirect light and refines the meshes that show it, until the error that is measured is the one asked
    /// for; `mean` is the mean irradiance that is expected, W/m².
    pub(super) fn rounds(
        &mut self,
        solution: &mut Solution,
        aim: &mut Aim,
        mean: f64,
    ) -> Result<(), MeshError> {
        let settings = self.settings;
        for round in 0..MAX_ROUNDS {
            if let Some(field) = &mut solution.indirect {
                self.gather(field, &solution.receivers, aim, mean, round == 0)?;
            }
            // Without indirect light nothing is new the first time.
            if solution.indirect.is_some() || round > 0 {
                self.start("display mesh");
                let indirect = solution.indirect.as_ref();
                let receivers = &mut solution.receivers;
                self.refine_display(aim, receivers, &solution.direct, indirect, 0.0)?;
            }
            self.start("measure");
            let seed = settings.seed + round as u64;
            let (measured, evidence) = self.measured(solution, seed);
            let summary = &mut self.summary;
            summary.measured = measured;
            summary.rounds = round + 1;
            let is_met = is_met(&measured, settings);
            summary.stopped_by = self.meter.reached().filter(|_| !is_met).map(Limit::name);
            if is_met || summary.stopped_by.is_some() {
                break;
            }
            summary.missed.push(measured);
            self.clock.tell(Step::Missed(&measured));
            let expected = evidence.teach(solution, measured.mean);
            aim.ask_more(settings.error, &measured, expected);
        }
        Ok(())
    }

    /// Measures the error; where it exceeds the one asked for once more at many points, unless their number is given: a few spots
    /// decide, which a thousand points find or do not, and another round costs more than they do.
    fn measured(&self, solution: &Solution, seed: u64) -> (Measured, Evidence) {
        let settings = self.settings;
        if let Some(samples) = settings.samples {
            return measure(solution, samples, seed);
        }
        let samples = default_samples(&solution.receivers);
        let first = measure(solution, samples, seed);
        if is_met(&first.0, settings) || self.meter.is_used_up() {
            return first;
        }
        measure(solution, MORE_POINTS * samples, seed + MAX_ROUNDS as u64)
    }

    /// Gathers the field and corrects it by its residual, in turn: the first correction of all is made while there are few
    /// values to correct.
    fn gather(
        &mut self,
        field: &mut IndirectField,
        receivers: &[Receiver],
        aim: &mut Aim,
        mean: f64,
        is_first: bool,
    ) -> Result<(), MeshError> {
        let error = self.settings.error;
        let shown = Shown::new(receivers, field.mesh().faces.len());
        let mut before = f64::INFINITY;
        for step in 0..MAX_CORRECTIONS {
            if self.meter.is_used_up() {
                break;
            }
            self.start("gather");
            let is_rough = is_first && step == 0;
            let coarser = if is_rough { FIRST_CORRECTION } else { 1.0 };
            let target = coarser * error * aim.field * mean;
            if step < 2 || field.estimate_rms() > CORRECTED_SLACK * target {
                self.refine_field(field, target)?;
            }
            // Another round of everything costs more than to look early.
            if is_first && step == 1 && field.mesh().is_crowded() {
                self.probe(field, receivers, aim, mean)?;
            }
            if self.meter.is_used_up() {
                break;
            }
            self.start("correct");
            let corrected = field.correct(|_, f, p| shown.direct(f, p));
            self.summary.corrections.push(corrected / mean);
            // The sum of a geometric series, c²/b + c³/b² + … = c²/(b − c).
            let permitted = CORRECTION_SHARE * error * mean;
            if step > 0 && corrected * corrected <= permitted * (before - corrected) {
                break;
            }
            before = corrected;
        }
        Ok(())
    }

    /// Gathers until the field is estimated to be off by `target`, W/m².
    fn refine_field(&mut self, field: &mut IndirectField, target: f64) -> Result<(), MeshError> {
        let (meter, clock) = (&self.meter, &mut self.clock);
        let is_late = || meter.is_late();
        field.refine(target, is_late, |f| {
            clock.tick(f);
            !meter.is_used_up()
        })
    }

    /// Holds the field against gathers at a few points, before anything shows it, and asks for more of it where it is off by too
    /// much.
    fn probe(
        &mut self,
        field: &mut IndirectField,
        receivers: &[Receiver],
        aim: &mut Aim,
        mean: f64,
    ) -> Result<(), MeshError> {
        let settings = self.settings;
        let n = settings
            .samples
            .unwrap_or_else(|| default_samples(receivers));
        let (found, points) = probe(receivers, field, n, settings.seed.wrapping_add(PROBE_SEED));
        if self.meter.is_used_up() || !aim.is_field_missed(settings.error, found / mean) {
            return Ok(());
        }
        let light = |r: &Receiver| r.solve_face.map_or(Irradiance::ZERO, |f| field.mean_on(f));
        let light: Vec<Irradiance> = receivers.iter().map(light).collect();
        let expected = teach_field(&points, receivers, &light, field);
        aim.ask_more_of_field(settings.error, found / mean, expected / mean);
        self.refine_field(field, settings.error * aim.field * mean)
    }
}

fn is_met(measured: &Measured, settings: &Settings) -> bool {
    measured.relative_rms <= (1.0 + MEASURE_SLACK) * settings.error
}

fn too_many(world: &World, error: TooManyUnknowns) -> BadInput {
    let remedy = "use --solver gmres, or accept a larger --error";
    BadInput::new(&world.scene.source, error.to_string(), remedy)
}

/// Light that comes back again and again and is never lost, or too slowly for the solver.
fn unsettled(world: &World, report: &SolveReport) -> BadInput {
    let what = format!(
        "light between surfaces does not settle in {} steps of {}: it is absorbed too slowly, or nowhere",
        report.residuals.len(),
        report.method
    );
    let remedy = "lower the reflectances that are 1, let light out, or use --solver hierarchical";
    BadInput::new(&world.scene.source, what, remedy)
}

/// Makes display meshes of one kind.
pub(super) struct Mesher {
    pub(super) meshing: Meshing,
    /// Of the starting points, or of the last uniform lattice, metres.
    pub(super) spacing: f64,
    /// The squared error below which elements were let be last, (W/m²)² m².
    pub(super) limit: Option<f64>,
}

impl Mesher {
    /// The sides to mesh, with their lines: all that are lit, whose `domains` are given, and the fronts of the others. `vantages`
    /// tells which emitters may be seen from each side, if that is known.
    pub(super) fn receivers(
        &self,
        scene: &Scene,
        sides: &[(FaceId, FaceSide)],
        is_lit: &[bool],
        domains: Vec<Arc<FaceDomain>>,
        mut lines: LineMap,
        vantages: Option<Vec<Arc<Vantage>>>,
    ) -> Vec<Receiver> {
        let area = |face: FaceId| scene.faces[face].area;
        let lit = sides.iter().zip(is_lit).filter(|s| *s.1);
        let lit_area: f64 = lit.map(|(s, _)| area(s.0)).sum();
        let mut domains = domains.into_iter();
        let around = |i: usize| vantages.as_ref().map(|v| v[i].clone());
        sides
            .iter()
            .zip(is_lit)
            .enumerate()
            .filter(|&(_, (&(_, side), &lit))| lit || side == FaceSide::Front)
            .map(|(i, (&(face, side), &lit))| {
                let with_lines = if lit { domains.next() } else { None };
                let (domain, lines) = match self.meshing {
                    Meshing::Discontinuity => {
                        let lines = lines.take(face, side);
                        let without = || Arc::new(domain(scene, face, side, &lines));
                        (with_lines.unwrap_or_else(without), lines)
                    }
                    Meshing::Adaptive | Meshing::Uniform => {
                        let none = FaceLines::default();
                        (Arc::new(domain(scene, face, side, &none)), none)
                    }
                };
                let mut r = Receiver::new(scene, domain, lines, self.spacing);
                r.is_lit = lit;
                r.around = around(i);
                r.size = Size::new(area(face), lit_area);
                r
            })
            .collect()
    }

    fn refine(
        &mut self,
        receivers: &mut [Receiver],
        light: &Illumination,
        error: f64,
        mean_besides: f64,
        meter: &Meter,
        progress: impl FnMut(f64),
    ) -> Result<AdaptReport, MeshError> {
        match self.meshing {
            Meshing::Discontinuity | Meshing::Adaptive => {
                let limit = &mut self.limit;
                adapt::refine(
                    receivers,
                    light,
                    error,
                    mean_besides,
                    limit,
                    meter,
                    progress,
                )
            }
            Meshing::Uniform => adapt::refine_uniformly(
                receivers,
                light,
                error,
                mean_besides,
                &mut self.spacing,
                meter,
                progress,
            ),
        }
    }
}

/// Times the stages.
struct Clock<'c, 'p> {
    progress: &'c mut Progress<'p>,
    open: Option<(&'static str, Instant)>,
}

impl<'c, 'p> Clock<'c, 'p> {
    fn new(progress: &'c mut Progress<'p>) -> Self {
        Self {
            progress,
            open: None,
        }
    }

    fn start(&mut self, name: &'static str, summary: &mut Summary) {
        self.finish(summary);
        self.tell(Step::Stage(name, None));
        self.open = Some((name, Instant::now()));
    }

    /// `error` is what the estimate has come down to, relative to what is asked for: progress on a logarithmic scale.
    fn tick(&mut self, share: f64) {
        if let Some((name, _)) = self.open {
            self.tell(Step::Stage(name, Some(share)));
        }
    }

    fn tell(&mut self, step: Step) {
        (self.progress)(step);
    }

    fn finish(&mut self, summary: &mut Summary) {
        if let Some((name, since)) = self.open.take() {
            summary.add_time(name, since.elapsed().as_secs_f64());
        }
    }
}
