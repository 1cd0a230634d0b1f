//! The recipe: a scene in, lit meshes out, one step a line.

mod conform;
mod convergence;
mod energy;
mod estimate;
mod exposure;
mod grading;
mod indirect;
mod lines;
mod lit;
mod measure;
mod mesh_edges;
mod probe;
mod smooth;
mod summary;

pub use convergence::{
    ConvergenceRow, convergence, convergence_csv, convergence_slope, meshing_name,
};
pub use energy::Energy;
pub use estimate::ErrorEstimate;
pub use lines::{LineCount, LineRecord, kind_name, line_records, order_number};
pub use measure::Measured;
pub use mesh_edges::{EdgeRole, MeshEdge, mesh_edges};
pub use probe::{NoReading, OffMesh, Reading, Sensor, probe_exact, probe_mesh};
pub use summary::{LeftOut, Stage, Summary};

use crate::adapt::{self, AdaptReport, Illumination, Meshing, Receiver};
use crate::bad_input::BadInput;
use crate::budget::{Limit, Meter};
use crate::direct::DirectLight;
use crate::discontinuity::{FaceLines, LineTolerance, check_outlines, find_lines};
use crate::lit_scene::LitScene;
use crate::mesh::MeshError;
use crate::radiosity::{Bounces, IndirectField, SolveReport, TooManyUnknowns, check_size};
use crate::scene::{CleanReport, FaceId, FaceSide, RawScene, Scene, clean};
use crate::settings::Settings;
use crate::visibility::Blockers;
use crate::warning::Warning;
use indirect::{Rooms, Shown, request};
use lit::{greatest_mean, guess_direct, lit_sides};
use std::time::Instant;

/// Why a scene could not be lit.
#[derive(Debug, thiserror::Error)]
pub enum LightError {
    /// The user can mend it.
    #[error(transparent)]
    Input(#[from] BadInput),
    /// Only we can.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

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

/// Display elements start at this share of the scene's diagonal. The light is looked at twice as densely, at the middles of
/// edges, and at centres: so that no bright spot falls between all points of a large face. Shadows announce themselves by
/// their lines.
const START_SPACING: f64 = 0.15;

/// Shares of the permitted error that interpolation over the display mesh and the indirect field may use; errors add in
/// squares, and the rest is left to the solution.
const DISPLAY_SHARE: f64 = 0.8;
const FIELD_SHARE: f64 = 0.45;

/// Share of the permitted error that the weakest emitters at a point may together be off by at most: they are looked at by
/// single rays.
const WEAK_SHARE: f64 = 0.2;

/// Share of the display mesh where there is no indirect light: the rest covers what the samples of the estimate miss.
const DIRECT_SHARE: f64 = 0.9;

/// A part that exceeded its share is asked for so much more than its excess.
const MISSED_MARGIN: f64 = 0.9;

/// The mesh is refined again at most so often when the measured error exceeds the one asked for.
const MAX_ROUNDS: usize = 4;

/// The solution is corrected by its own residual until a correction is below this share of the permitted error: what it
/// leaves to the next one is smaller by far.
const CORRECTION_SHARE: f64 = 0.4;

/// The first correction is made once the field is within this many times its permitted error.
const FIRST_CORRECTION: f64 = 3.0;

/// Corrections at most, a round.
const MAX_CORRECTIONS: usize = 4;

/// A cleaned scene, ready to be lit.
pub struct World {
    /// The scene.
    pub scene: Scene,
    /// Its opaque faces.
    pub blockers: Blockers,
    /// What was repaired, in numbers.
    pub clean: CleanReport,
    /// What was repaired, in words.
    pub warnings: Vec<Warning>,
}

impl World {
    /// Cleans `raw`.
    ///
    /// # Errors
    /// When nothing usable is left.
    pub fn new(raw: &RawScene, settings: &Settings) -> Result<Self, BadInput> {
        let (scene, clean, repairs) = clean(raw, &settings.clean)?;
        let mut warnings = raw.warnings.clone();
        warnings.extend(repairs);
        if scene.emitters.is_empty() && scene.lights.is_empty() {
            warnings.push(Warning::new(
                &scene.source,
                "no face emits light: the result is black (set Ke or emissiveFactor on a material)",
            ));
        }
        Ok(Self {
            blockers: Blockers::new(&scene),
            scene,
            clean,
            warnings,
        })
    }
}

/// What `light` tells while it works: the stage's name, and how far it is (0…1) where that is known.
pub type Progress<'p> = dyn FnMut(&'static str, Option<f64>) + 'p;

/// A lit world.
pub struct Solution<'a> {
    /// The scene.
    pub world: &'a World,
    /// Light straight from the emitters.
    pub direct: DirectLight<'a>,
    /// Every lit side with its display mesh, and the fronts that no light reaches.
    pub receivers: Vec<Receiver>,
    /// Indirect light; none when nothing reflects or no bounces were asked for.
    pub indirect: Option<IndirectField<'a>>,
    /// Counts, times, errors.
    pub summary: Summary,
    /// Estimated error at the sites of each receiver, W/m², once it was asked for.
    site_errors: Option<Vec<Vec<f64>>>,
    settings: Settings,
}

/// Lights `world` to the error asked for.
///
/// # Errors
/// [`MeshError`]: our own bug.
pub fn light<'a>(
    world: &'a World,
    settings: &Settings,
    progress: &mut Progress,
) -> Result<Solution<'a>, LightError> {
    let mut summary = Summary::default();
    let meter = Meter::new(settings.budget);
    let mut clock = Clock::new(progress);
    let scene = &world.scene;
    let direct = DirectLight::new(scene, &world.blockers);

    clock.start("lines", &mut summary);
    let tolerance = LineTolerance {
        floor: settings.error * LINE_FLOOR,
        least: settings.error * LINE_LEAST * greatest_mean(scene, &direct, &receiver_sides(scene)),
        chord: settings.error * LINE_CHORD,
    };
    let mut lines = find_lines(scene, &direct, tolerance);
    lines.report.outlines = check_outlines(scene, &direct, &lines, tolerance, OUTLINE_PAIRS);
    summary.lines = lines.report;

    clock.start("reach", &mut summary);
    let sides = receiver_sides(scene);
    let with_bounces = settings.bounces != Bounces::Count(0)
        && sides
            .iter()
            .any(|&(f, _)| !scene.faces[f].reflectance.is_black());
    let is_lit = lit_sides(world, &direct, &lines, &sides, with_bounces);
    let mean_direct = guess_direct(scene, &direct, &sides, &is_lit);
    let mut mesher = Mesher {
        meshing: settings.meshing,
        spacing: START_SPACING * scene.diagonal,
    };
    let rooms = Rooms {
        scene,
        blockers: &world.blockers,
        lines: &lines,
        sides: &sides,
        is_lit: &is_lit,
    };
    let (mut mean_indirect, mut solve_mesh) = (0.0, None);
    if with_bounces {
        clock.start("first guess", &mut summary);
        let guess = rooms.guess(&direct, settings.bounces)?;
        mean_indirect = guess.indirect;
        let mesh = rooms.solve_mesh(settings.error, &direct, guess)?;
        check_size(&mesh, &world.blockers, settings.solver, settings.basis)
            .map_err(|e| too_many(world, e))?;
        solve_mesh = Some(mesh);
    }

    clock.start("display mesh", &mut summary);
    let mut receivers: Vec<Receiver> = sides
        .iter()
        .zip(&is_lit)
        .filter(|&(&(_, side), &lit)| lit || side == FaceSide::Front)
        .map(|(&(face, side), &lit)| {
            let lines = match settings.meshing {
                Meshing::Discontinuity => lines.take(face, side),
                Meshing::Adaptive | Meshing::Uniform => FaceLines::default(),
            };
            let mut r = Receiver::new(scene, face, side, lines, mesher.spacing);
            r.is_lit = lit;
            r
        })
        .collect();
    let display_share = if with_bounces {
        DISPLAY_SHARE
    } else {
        DIRECT_SHARE
    };
    let target = settings.error * display_share;
    let tolerance = WEAK_SHARE * settings.error * (mean_direct + mean_indirect);
    let before = Illumination {
        direct: &direct,
        tolerance,
        indirect: None,
    };
    summary.adapt = mesher.refine(
        &mut receivers,
        &before,
        target,
        mean_indirect,
        &meter,
        |f| clock.tick(f),
    )?;

    let mut indirect = None;
    if let Some(mesh) = solve_mesh {
        clock.start("solve", &mut summary);
        let index: Vec<(FaceId, FaceSide)> = mesh
            .faces
            .iter()
            .map(|f| (f.domain.face, f.domain.side))
            .collect();
        for r in &mut receivers {
            r.solve_face = index.binary_search(&(r.domain.face, r.domain.side)).ok();
        }
        let mean = mean_of(&receivers) + mean_indirect;
        let shown = Shown::new(&receivers, mesh.faces.len());
        let request = request(settings, mean, mean_indirect);
        let (field, report) =
            IndirectField::solve(mesh, &world.blockers, request, |_, f, p| shown.direct(f, p))
                .map_err(|e| too_many(world, e))?;
        if !report.is_settled {
            return Err(unsettled(world, &report).into());
        }
        summary.solve = report;
        indirect = Some(field);
    }

    let mut solution = Solution {
        world,
        direct,
        receivers,
        indirect,
        summary: Summary::default(),
        site_errors: None,
        settings: settings.clone(),
    };
    let mean = mean_of(&solution.receivers) + mean_indirect;
    let (mut display, mut gathered) = (display_share, FIELD_SHARE);
    // Alone the mesh may use it all: what the estimate missed has been measured then.
    let allowed = if with_bounces { DISPLAY_SHARE } else { 1.0 };
    for round in 0..MAX_ROUNDS {
        if let Some(field) = &mut solution.indirect {
            let target = settings.error * gathered * mean;
            let shown = Shown::new(&solution.receivers, field.mesh().faces.len());
            // The first correction is made while there are few values to correct.
            for step in 0..MAX_CORRECTIONS {
                if meter.is_used_up() {
                    break;
                }
                clock.start("gather", &mut summary);
                let coarser = if step == 0 { FIRST_CORRECTION } else { 1.0 };
                field.refine(coarser * target, |f| {
                    clock.tick(f);
                    !meter.is_used_up()
                })?;
                if meter.is_used_up() {
                    break;
                }
                clock.start("correct", &mut summary);
                let corrected = field.correct(|_, f, p| shown.direct(f, p));
                summary.corrections.push(corrected / mean);
                if step > 0 && corrected <= CORRECTION_SHARE * settings.error * mean {
                    break;
                }
            }
            solution.receivers.iter_mut().for_each(Receiver::relight);
        }
        // Without indirect light nothing is new the first time.
        if solution.indirect.is_some() || round > 0 {
            clock.start("display mesh", &mut summary);
            let light = Illumination {
                direct: &solution.direct,
                tolerance,
                indirect: solution.indirect.as_ref(),
            };
            let target = settings.error * display;
            let receivers = &mut solution.receivers;
            let report =
                mesher.refine(receivers, &light, target, 0.0, &meter, |f| clock.tick(f))?;
            summary.adapt.add(&report);
        }
        clock.start("measure", &mut summary);
        let measured = solution.measure(settings.samples, settings.seed + round as u64);
        summary.measured = measured;
        summary.rounds = round + 1;
        let is_met = measured.relative_rms <= settings.error;
        summary.stopped_by = meter.reached().filter(|_| !is_met).map(Limit::name);
        if is_met || summary.stopped_by.is_some() {
            break;
        }
        // What an estimate has missed is asked for on top, of that part which exceeds its share.
        let ask_more = |share: f64, found: f64, allowed: f64| {
            if found > allowed * settings.error {
                share * (allowed * settings.error / found).max(0.25) * MISSED_MARGIN
            } else {
                share
            }
        };
        display = ask_more(display, measured.relative_rms_mesh, allowed);
        gathered = ask_more(gathered, measured.relative_rms_field, FIELD_SHARE);
    }
    clock.finish(&mut summary);
    summary.fill(&solution, &is_lit, &sides);
    solution.summary = summary;
    Ok(solution)
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
struct Mesher {
    meshing: Meshing,
    /// Of the starting points, or of the last uniform lattice, metres.
    spacing: f64,
}

impl Mesher {
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
                adapt::refine(receivers, light, error, mean_besides, meter, progress)
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

/// Every side that reflects or is seen, sorted.
fn receiver_sides(scene: &Scene) -> Vec<(FaceId, FaceSide)> {
    scene
        .faces
        .ids()
        .flat_map(|f| [FaceSide::Front, FaceSide::Back].map(|s| (f, s)))
        .filter(|&(f, s)| scene.receives(f, s))
        .collect()
}

/// Mean irradiance that the meshes show over the lit surfaces, W/m².
fn mean_of(receivers: &[Receiver]) -> f64 {
    let (mut power, mut area) = (0.0, 0.0);
    for r in receivers.iter().filter(|r| r.is_lit) {
        power += r.power().mean();
        area += r.area();
    }
    if area > 0.0 { power / area } else { 0.0 }
}

impl Solution<'_> {
    /// Compares what the mesh shows with what is there, at stratified random points of the lit surfaces.
    pub fn measure(&self, samples: u32, seed: u64) -> Measured {
        measure::measure(self, samples, seed)
    }

    /// Estimates the error at every vertex, for [`Solution::lit_scene`] and the summary.
    pub fn estimate_error(&mut self) {
        let (sites, figures) = estimate::estimate(self);
        self.site_errors = Some(sites);
        self.summary.error_at_vertices = Some(figures);
    }

    /// Where the power goes; none for counted bounces but zero.
    pub fn energy(&self) -> Option<Energy> {
        energy::energy(self)
    }

    /// The meshes with their light, neighbours sharing their vertices, ready to be written.
    pub fn lit_scene(&self) -> LitScene {
        let meshes = conform::lit_meshes(self);
        let scene = &self.world.scene;
        LitScene {
            origin: scene.origin,
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
            groups: scene.groups.clone(),
            cameras: scene.cameras.clone(),
            exposure: exposure::exposure(&meshes, self.settings.exposure),
            meshes,
            extras: summary::extras(self, &self.settings),
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
        (self.progress)(name, None);
        self.open = Some((name, Instant::now()));
    }

    /// `error` is what the estimate has come down to, relative to what is asked for: progress on a logarithmic scale.
    fn tick(&mut self, share: f64) {
        if let Some((name, _)) = self.open {
            (self.progress)(name, Some(share));
        }
    }

    fn finish(&mut self, summary: &mut Summary) {
        if let Some((name, since)) = self.open.take() {
            summary.add_time(name, since.elapsed().as_secs_f64());
        }
    }
}
