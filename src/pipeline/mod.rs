//! The recipe: a scene in, lit meshes out, one step a line.

mod conform;
mod exposure;
mod lines;
mod measure;
mod mesh_edges;
mod probe;
mod summary;

pub use lines::{LineCount, LineRecord, kind_name, line_records, order_number};
pub use measure::Measured;
pub use mesh_edges::{EdgeRole, MeshEdge, mesh_edges};
pub use probe::{NoReading, OffMesh, Reading, Sensor, probe_exact, probe_mesh};
pub use summary::{LeftOut, Stage, Summary};

use crate::adapt::{self, Illumination, Receiver};
use crate::bad_input::BadInput;
use crate::direct::DirectLight;
use crate::discontinuity::{Discontinuity, LineMap, find_lines};
use crate::lit_scene::LitScene;
use crate::mesh::{FaceDomain, MeshError};
use crate::quantity::Irradiance;
use crate::radiosity::{
    Bounces, IndirectField, LightSample, MANY_SIDES, SolveFace, SolveMesh, Transport, project,
    reached,
};
use crate::scene::{CleanReport, FaceId, FaceSide, RawScene, Scene, clean};
use crate::settings::Settings;
use crate::visibility::{Blockers, Scratch, Viewpoint};
use crate::warning::Warning;
use rayon::prelude::*;
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

/// Elements of the mesh that guesses how much light is indirect, so that the error asked for means something in W/m².
const FIRST_GUESS_ELEMENTS: f64 = 100.0;

/// The direct light may depart from its projection to the solve mesh by this many times the error asked for: it is
/// smoothed by a reflection before anyone sees it.
const FOLLOW_SHARE: f64 = 6.0;

/// Elements of the solve mesh at an error of 1 %, before the shapes of the faces ask for more.
///
/// The solution's error falls a little faster than in proportion to their number (measured on rooms lit around a corner
/// and on boxes on a floor: concave edges keep it from h³), but most of it is gone at the coarsest.
const SOLVE_ELEMENTS: f64 = 500.0;

/// Their number grows as error to minus this power.
const SOLVE_EXPONENT: f64 = 0.4;

/// Area of an equilateral triangle of side 1: elements of a staggered lattice.
const LATTICE_TRIANGLE: f64 = 0.433;

/// Display elements start at this share of the scene's diagonal: fine enough that no bright spot falls between all points
/// of a large face; shadows announce themselves by their lines.
const START_SPACING: f64 = 1.0 / 12.0;

/// Share of an emitter that may be left of it by rounding when it is hidden: slivers as wide as a few thousand roundings.
const CUTTING_ROUNDOFF: f64 = 4096.0 * f64::EPSILON;

/// How far beside a line light is looked for, as a share of its length.
const BESIDE_SHARE: f64 = 0.01;

/// Shares of the permitted error that interpolation over the display mesh and the indirect field may use; errors add in
/// squares, and the rest is left to the solution.
const DISPLAY_SHARE: f64 = 0.8;
const FIELD_SHARE: f64 = 0.45;

/// A part that exceeded its share is asked for so much more than its excess.
const MISSED_MARGIN: f64 = 0.9;

/// The mesh is refined again at most so often when the measured error exceeds the one asked for.
const MAX_ROUNDS: usize = 4;

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
        if scene.emitters.is_empty() {
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
    let mut clock = Clock::new(progress);
    let scene = &world.scene;
    let direct = DirectLight::new(scene, &world.blockers);

    clock.start("lines", &mut summary);
    let mut lines = find_lines(scene, &direct);
    summary.lines = lines.report;

    clock.start("reach", &mut summary);
    let sides = receiver_sides(scene);
    let with_bounces = settings.bounces != Bounces::Count(0)
        && sides
            .iter()
            .any(|&(f, _)| !scene.material_of(f).reflectance.is_black());
    let is_lit = lit_sides(world, &direct, &lines, &sides, with_bounces);
    let spacing = START_SPACING * scene.diagonal;

    let elements = SOLVE_ELEMENTS * (0.01 / settings.error).powf(SOLVE_EXPONENT);
    let lit_count = is_lit.iter().filter(|l| **l).count();
    // With very many sides the guess would cost as much as the solution: then the solution's own mesh makes it.
    let is_guessed_apart = lit_count <= MANY_SIDES;
    let mut mean_indirect = 0.0;
    let mut coarse = None;
    if with_bounces {
        clock.start("first guess", &mut summary);
        let n = if is_guessed_apart {
            FIRST_GUESS_ELEMENTS
        } else {
            elements
        };
        let mesh = solve_mesh(scene, &lines, &sides, &is_lit, n, settings.error)?;
        let transport = Transport::new(&mesh, &world.blockers);
        let at_sites = direct_at_sites(&mesh, &direct);
        let (radiosity, _) = transport.solve(&mesh, &at_sites, settings.bounces, settings.error);
        let gathered = transport.gather_all(&radiosity);
        mean_indirect = mean_at_sites(&mesh, |f, s| gathered.at_site(f, s));
        coarse = Some(if is_guessed_apart {
            (
                solve_mesh(scene, &lines, &sides, &is_lit, elements, settings.error)?,
                None,
            )
        } else {
            (mesh, Some(transport))
        });
    }

    clock.start("display mesh", &mut summary);
    let mut receivers: Vec<Receiver> = sides
        .iter()
        .zip(&is_lit)
        .filter(|&(&(_, side), &lit)| lit || side == FaceSide::Front)
        .map(|(&(face, side), &lit)| {
            let lines = lines.take(face, side);
            let mut r = Receiver::new(scene, face, side, lines, spacing);
            r.is_lit = lit;
            r
        })
        .collect();
    let target = settings.error * DISPLAY_SHARE;
    let before = Illumination {
        direct: &direct,
        indirect: None,
    };
    summary.adapt = adapt::refine(&mut receivers, &before, target, mean_indirect, |f| {
        clock.tick(f)
    })?;

    let mut indirect = None;
    if let Some((mesh, transport)) = coarse {
        clock.start("transport", &mut summary);
        let index: Vec<(FaceId, FaceSide)> = mesh
            .faces
            .iter()
            .map(|f| (f.domain.face, f.domain.side))
            .collect();
        for r in &mut receivers {
            r.solve_face = index.binary_search(&(r.domain.face, r.domain.side)).ok();
        }
        let samples = light_samples(&receivers);
        let at_site = |face: &SolveFace, s: usize| {
            direct.irradiance(&face.site_view(s), &mut Scratch::default())
        };
        let mean = mean_of(&receivers) + mean_indirect;
        let (mesh, transport) = match transport {
            Some(transport) => (mesh, transport),
            None => {
                let target = FOLLOW_SHARE * settings.error * mean;
                let mesh = mesh.follow(&samples, at_site, target)?;
                let transport = Transport::new(&mesh, &world.blockers);
                (mesh, transport)
            }
        };
        clock.start("solve", &mut summary);
        let g = project(&mesh, samples.into_iter(), |f, s| {
            at_site(&mesh.faces[f], s)
        });
        let tolerance = settings.error * SOLVE_SHARE;
        let (radiosity, report) = transport.solve(&mesh, &g, settings.bounces, tolerance);
        summary.solve = report;
        clock.start("gather", &mut summary);
        let field = IndirectField::new(mesh, &world.blockers, &transport, radiosity);
        indirect = Some(field);
    }

    let mut solution = Solution {
        world,
        direct,
        receivers,
        indirect,
        summary: Summary::default(),
        settings: settings.clone(),
    };
    let mean = mean_of(&solution.receivers) + mean_indirect;
    let (mut display, mut gathered) = (DISPLAY_SHARE, FIELD_SHARE);
    for round in 0..MAX_ROUNDS {
        if let Some(field) = &mut solution.indirect {
            clock.start("gather", &mut summary);
            field.refine(settings.error * gathered * mean, |f| clock.tick(f))?;
            solution.receivers.iter_mut().for_each(Receiver::relight);
        }
        clock.start("display mesh", &mut summary);
        let light = Illumination {
            direct: &solution.direct,
            indirect: solution.indirect.as_ref(),
        };
        let target = settings.error * display;
        let report = adapt::refine(&mut solution.receivers, &light, target, 0.0, |f| {
            clock.tick(f)
        })?;
        summary.adapt.add(&report);
        clock.start("measure", &mut summary);
        let measured = solution.measure(settings.samples, settings.seed + round as u64);
        summary.measured = measured;
        summary.rounds = round + 1;
        if measured.relative_rms <= settings.error {
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
        display = ask_more(display, measured.relative_rms_mesh, DISPLAY_SHARE);
        gathered = ask_more(gathered, measured.relative_rms_field, FIELD_SHARE);
    }
    clock.finish(&mut summary);
    summary.fill(&solution, &is_lit, &sides);
    solution.summary = summary;
    Ok(solution)
}

/// Share of the permitted error left to the iteration.
const SOLVE_SHARE: f64 = 0.01;

/// Every side that reflects or is seen, sorted.
fn receiver_sides(scene: &Scene) -> Vec<(FaceId, FaceSide)> {
    scene
        .faces
        .ids()
        .flat_map(|f| [FaceSide::Front, FaceSide::Back].map(|s| (f, s)))
        .filter(|&(f, s)| scene.receives(f, s))
        .collect()
}

/// Which sides light reaches: directly (it shows at coarse points, or draws a line), or by way of other sides.
fn lit_sides(
    world: &World,
    direct: &DirectLight,
    lines: &LineMap,
    sides: &[(FaceId, FaceSide)],
    with_bounces: bool,
) -> Vec<bool> {
    let scene = &world.scene;
    let views: Vec<Vec<Viewpoint>> = sides
        .iter()
        .map(|&(face, side)| {
            let f = &scene.faces[face];
            f.triangles
                .iter()
                .map(|t| {
                    let centre = t.map(|v| scene.vertices[v]).iter().sum::<glam::DVec3>() / 3.0;
                    let on_plane = f.frame.to_space(f.frame.to_plane(centre));
                    Viewpoint::new(on_plane, scene.normal(face, side))
                })
                .collect()
        })
        .collect();
    let lit: Vec<bool> = sides
        .par_iter()
        .zip(&views)
        .map_init(Scratch::default, |scratch, (&(face, side), views)| {
            let mut shines = |v: &Viewpoint| {
                // What the cutting of cones leaves of a hidden emitter is no light.
                let least = direct.unoccluded(v, scratch).mean() * CUTTING_ROUNDOFF;
                direct.irradiance(v, scratch).mean() > least
            };
            views.iter().any(&mut shines)
                || beside_lines(scene, &lines.of(face, side).candidates)
                    .iter()
                    .any(shines)
        })
        .collect();
    if with_bounces {
        reached(&world.blockers, sides, &views, &lit)
    } else {
        lit
    }
}

/// Viewpoints to both sides of the middle of each line: light that reaches a face only within a small patch draws lines
/// around it.
fn beside_lines(scene: &Scene, lines: &[Discontinuity]) -> Vec<Viewpoint> {
    lines
        .iter()
        .flat_map(|line| {
            let normal = scene.normal(line.face, line.side);
            let [a, b] = line.ends;
            let across = normal.cross(b - a) * BESIDE_SHARE;
            [1.0, -1.0].map(|s| Viewpoint::new(0.5 * (a + b) + across * s, normal))
        })
        .collect()
}

/// The coarse mesh of all lit sides.
fn solve_mesh(
    scene: &Scene,
    lines: &LineMap,
    sides: &[(FaceId, FaceSide)],
    is_lit: &[bool],
    elements: f64,
    error: f64,
) -> Result<SolveMesh, MeshError> {
    let lit = || sides.iter().zip(is_lit).filter(|s| *s.1).map(|s| *s.0);
    let area: f64 = lit().map(|(f, _)| scene.faces[f].area).sum();
    let spacing = (area / (LATTICE_TRIANGLE * elements)).sqrt();
    let domains = lit()
        .map(|(face, side)| {
            let l = lines.of(face, side);
            let domain = FaceDomain::new(scene, face, side, &l.contacts, &[], &l.covers);
            (domain, scene.material_of(face).reflectance)
        })
        .collect();
    SolveMesh::new(domains, spacing, error)
}

/// Exact direct light at every site of the solve mesh.
fn direct_at_sites(mesh: &SolveMesh, direct: &DirectLight) -> Vec<Irradiance> {
    mesh.faces
        .par_iter()
        .flat_map_iter(|face| {
            let mut scratch = Scratch::default();
            (0..face.mesh.site_vertices.len())
                .map(|s| direct.irradiance(&face.site_view(s), &mut scratch))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// Area-weighted mean over the solve mesh, mean of the channels, W/m².
fn mean_at_sites(mesh: &SolveMesh, value: impl Fn(usize, usize) -> Irradiance) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (f, face) in mesh.faces.iter().enumerate() {
        for (e, sites) in face.mesh.sites.iter().enumerate() {
            let a = face.mesh.area(e);
            area += a;
            for &s in sites {
                sum += value(f, s as usize).mean() * a / 3.0;
            }
        }
    }
    if area > 0.0 { sum / area } else { 0.0 }
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

/// The direct light of the display meshes, as samples on the faces of the solve mesh.
fn light_samples(receivers: &[Receiver]) -> Vec<LightSample> {
    let mut samples = Vec::new();
    for r in receivers {
        let Some(face) = r.solve_face else { continue };
        for e in 0..r.mesh.elements.len() {
            let p = r.mesh.corners(e);
            let value = r.mesh.sites[e].map(|s| r.direct[s as usize]);
            let area = r.mesh.area(e) / SUB_POINTS.len() as f64;
            samples.extend(SUB_POINTS.iter().map(|w| LightSample {
                face: face as u32,
                point: p[0] * w[0] + p[1] * w[1] + p[2] * w[2],
                area,
                irradiance: value[0] * w[0] + value[1] * w[1] + value[2] * w[2],
            }));
        }
    }
    samples
}

/// Middles of the four triangles that a triangle is divided into at its edge midpoints: four equal shares of its area.
const SUB_POINTS: [[f64; 3]; 4] = [
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
];

impl Solution<'_> {
    /// Compares what the mesh shows with what is there, at stratified random points of the lit surfaces.
    pub fn measure(&self, samples: u32, seed: u64) -> Measured {
        measure::measure(self, samples, seed)
    }

    /// The meshes with their light, neighbours sharing their vertices, ready to be written.
    pub fn lit_scene(&self) -> LitScene {
        let meshes = conform::lit_meshes(self);
        let scene = &self.world.scene;
        LitScene {
            origin: scene.origin,
            materials: scene.materials.clone(),
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
