//! The recipe: a scene in, lit meshes out, one step a line.

mod aim;
mod conform;
mod convergence;
mod energy;
mod estimate;
mod evidence;
mod exposure;
mod grading;
mod guess;
mod indirect;
mod lines;
mod lit;
mod measure;
mod mesh_edges;
mod probe;
mod random;
mod rims;
mod smooth;
mod stages;
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

use crate::adapt::Receiver;
use crate::bad_input::BadInput;
use crate::direct::{DirectLight, stuck_emitters};
use crate::discontinuity::{FaceLines, LineMap};
use crate::lit_scene::LitScene;
use crate::mesh::{FaceDomain, MeshError};
use crate::radiosity::{Bounces, IndirectField};
use crate::scene::{CleanReport, FaceId, FaceSide, IdVec, RawScene, Scene, clean};
use crate::settings::Settings;
use crate::visibility::Blockers;
use crate::warning::Warning;
use aim::Aim;
use guess::guess;
use indirect::Rooms;
use lit::lit_sides;
pub use stages::MEASURE_SLACK;
use stages::{Mesher, Run};
use std::sync::Arc;

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
        let (mut scene, mut clean, repairs) = clean(raw, &settings.clean)?;
        let mut warnings = raw.warnings.clone();
        warnings.extend(repairs);
        if scene.emitters.is_empty() && scene.lights.is_empty() {
            warnings.push(Warning::new(
                &scene.source,
                "no face emits light: the result is black (set Ke or emissiveFactor on a material)",
            ));
        }
        let blockers = Blockers::new(&scene);
        let stuck = put_out_stuck(&mut scene, &blockers);
        if stuck > 0 {
            clean.emitters = scene.emitters.len();
            let what =
                format!("{stuck} sides that emit light lie against other faces: none leaves there");
            warnings.push(Warning::new(&scene.source, what));
        }
        Ok(Self {
            blockers,
            scene,
            clean,
            warnings,
        })
    }
}

/// Takes from the emitters of `scene` those that lie against something else; returns their number.
fn put_out_stuck(scene: &mut Scene, blockers: &Blockers) -> usize {
    let stuck = stuck_emitters(scene, blockers);
    if stuck.len() == scene.emitters.len() {
        // None would be left: these are no bodies but rooms whose fronts look outwards.
        return 0;
    }
    let emitters = scene.emitters.iter();
    let shining: Vec<_> = emitters
        .filter(|(id, _)| stuck.binary_search(id).is_err())
        .map(|(_, &e)| e)
        .collect();
    scene.emitters = IdVec::from(shining);
    stuck.len()
}

/// What `light` tells while it works.
#[derive(Clone, Copy, Debug)]
pub enum Step<'s> {
    /// The stage that is at work, and how far it is (0…1) where that is known.
    Stage(&'static str, Option<f64>),
    /// The error was measured and is larger than the one asked for: another round begins.
    Missed(&'s Measured),
}

/// Is told every [`Step`].
pub type Progress<'p> = dyn FnMut(Step) + 'p;

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
    /// What emitters that are weak, or behind a crowd of blockers, may together be off by at a vertex, W/m².
    tolerance: f64,
    settings: Settings,
}

/// Display elements start at this share of the scene's diagonal. The light is looked at twice as densely, at the middles of
/// edges, and at centres: so that no bright spot falls between all points of a large face. Shadows announce themselves by
/// their lines.
const START_SPACING: f64 = 0.15;

/// Share of the permitted error that the weakest emitters at a point may together be off by at most: they are looked at by
/// single rays.
const WEAK_SHARE: f64 = 0.2;

/// Where the convex pieces of emitters are no more than this, each face finds out for itself which of them it may see.
const FEW_EMITTERS: usize = 8;

/// Lights `world` to the error asked for.
///
/// # Errors
/// [`MeshError`]: our own bug.
pub fn light<'a>(
    world: &'a World,
    settings: &Settings,
    progress: &mut Progress,
) -> Result<Solution<'a>, LightError> {
    let mut run = Run::new(settings, progress);
    let scene = &world.scene;
    let direct = DirectLight::new(scene, &world.blockers);
    let sides = receiver_sides(scene);
    let lines = run.find_lines(scene, &direct, &sides);

    run.start("reach");
    let with_bounces = settings.bounces != Bounces::Count(0)
        && sides
            .iter()
            .any(|&(f, _)| !scene.faces[f].reflectance.is_black());
    let is_many = direct.polygons.len() > FEW_EMITTERS;
    let vantages = is_many.then(|| direct.vantages_of_sides(scene, &sides));
    let known = vantages.as_deref();
    let is_lit = lit_sides(world, &direct, &lines, &sides, known, with_bounces);
    let domains = lit_domains(scene, &lines, &sides, &is_lit);

    run.start("first guess");
    let guess = guess(world, &direct, &sides, &is_lit, settings.bounces);
    let mut solve_mesh = None;
    if with_bounces {
        let rooms = Rooms {
            scene,
            blockers: &world.blockers,
            domains: &domains,
        };
        solve_mesh = Some(run.solve_mesh(world, &rooms, &direct, guess)?);
    }

    run.start("display mesh");
    let mesher = Mesher {
        meshing: settings.meshing,
        spacing: START_SPACING * scene.diagonal,
        limit: None,
    };
    let mean_indirect = guess.indirect;
    let weak = WEAK_SHARE * settings.error * (guess.direct + mean_indirect);
    let mut aim = Aim::new(mesher, solve_mesh.is_some(), weak);
    let mut receivers = aim
        .mesher
        .receivers(scene, &sides, &is_lit, domains, lines, vantages);
    run.refine_display(&mut aim, &mut receivers, &direct, None, mean_indirect)?;
    let indirect = match solve_mesh {
        Some(mesh) => Some(run.solve(world, mesh, &mut receivers, mean_indirect)?),
        None => None,
    };
    let mean = mean_of(&receivers) + mean_indirect;
    let mut solution = Solution {
        world,
        direct,
        receivers,
        indirect,
        summary: Summary::default(),
        site_errors: None,
        tolerance: weak,
        settings: settings.clone(),
    };
    run.rounds(&mut solution, &mut aim, mean)?;
    let mut summary = run.finish();
    summary.fill(&solution, &is_lit, &sides);
    solution.summary = summary;
    Ok(solution)
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

/// What is to be meshed of the lit sides, with all their lines.
fn lit_domains(
    scene: &Scene,
    lines: &LineMap,
    sides: &[(FaceId, FaceSide)],
    is_lit: &[bool],
) -> Vec<Arc<FaceDomain>> {
    let lit = sides.iter().zip(is_lit).filter(|s| *s.1);
    lit.map(|(&(face, side), _)| Arc::new(domain(scene, face, side, lines.of(face, side))))
        .collect()
}

fn domain(scene: &Scene, face: FaceId, side: FaceSide, lines: &FaceLines) -> FaceDomain {
    let (contacts, candidates) = (&lines.contacts, &lines.candidates);
    FaceDomain::new(scene, face, side, contacts, candidates, &lines.covers)
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
        measure::measure(self, samples, seed).0
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
