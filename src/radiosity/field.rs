//! The indirect irradiance as a field over the receivers, gathered where it matters.
//!
//! The solution itself is coarse; what is shown is its final gather. A gather is the dearest thing there is, so each face
//! buys only what the error asked for needs, the cheapest first: one value for a face that is small; values at the corners
//! of its elements; at the midpoints of their edges (quadratic interpolation); one in the middle, to know the error; and
//! where that is too large, smaller elements.
//!
//! What the finer field reflects differs from what the solution had assumed. That difference is the residual of the
//! solution; what it brings about is both an estimate of the solution's error and its correction. The points remember what
//! they see, so that a correction costs next to nothing.

mod accuracy;
mod correction;
mod estimate;
mod room;
mod shot;
#[cfg(test)]
mod tests;
mod told;

pub use estimate::SolutionError;

use accuracy::{Accuracy, oracle};
use room::{Room, Shot, held};

use super::cells::{FaceCells, FaceLight, FollowLimits, follow_all};
use super::clusters::Sources;
use super::field_face::{CellLink, FieldFace, Gathered, Source, merged};
use super::gather::Gatherers;
use super::held::Held;
use super::nodes::{NodalField, inset};
use super::rows::point_nodes;
use super::solve::{Method, Transport};
use super::sweep::RAYS;
use super::{
    Basis, Bounces, Gatherer, Linking, SolveFace, SolveMesh, SolveReport, Solver, TooManyUnknowns,
};
use crate::mesh::MeshError;
use crate::quantity::{Irradiance, Radiosity};
use crate::scene::Size;
use crate::visibility::{Blockers, Viewpoint};
use glam::DVec2;
use rayon::prelude::*;
use std::borrow::Borrow;

/// Share of the permitted squared error that may stay in places where nothing more is bought. Gathers are dear and choosing is
/// cheap: with ½, five scenes took 1.1 to 1.2 times as many gathers, in half the rounds.
const UNMARKED_SHARE: f64 = 0.95;

/// Rounds of buying: enough for twelve halvings of an element's longest edge, each of up to three steps, one after the other with
/// what is bought beside.
const MAX_ROUNDS: usize = 72;

/// Points that are gathered while more links than this are remembered, of 20 bytes each, remember none: a correction gathers
/// there anew.
const MOST_LINKS: usize = 16_000_000;

/// Cells are at most as wide as the spacing of the solve mesh, and not divided below this share of it.
const SMALLEST_SHARE: f64 = 1.0 / 32.0;

/// The indirect light on a whole face departs from a linear function by about this share of its mean, and ranges over as
/// much: all that is known before it is solved for.
const AMBIENT_SHARE: f64 = 0.15;

/// What is asked of the indirect light.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// Permitted error, W/m².
    pub error: f64,
    /// The mean that is expected, W/m².
    pub ambient: f64,
    /// How often light is reflected.
    pub bounces: Bounces,
    /// Permitted error of the iteration, relative to the largest radiosity.
    pub tolerance: f64,
    /// What cells know of their light.
    pub basis: Basis,
    /// How nodes are linked with cells.
    pub linking: Linking,
    /// How the links are solved.
    pub solver: Solver,
}

impl Request {
    fn method(&self) -> Method {
        Method {
            solver: self.solver,
            bounces: self.bounces,
            tolerance: self.tolerance,
        }
    }
}

/// Indirect irradiance over all lit sides.
pub struct IndirectField<'a> {
    solution: Coarse<'a>,
    /// Links of the coarse mesh, for what the corrections cause in their turn.
    transport: Transport,
    faces: Vec<FieldFace>,
    /// How many times what they tell their squared errors are taken to be.
    distrust: Vec<f64>,
    /// What of each face the links have no say in.
    held: Vec<Held>,
    request: Request,
    /// Gathers made.
    gathers: usize,
    /// Estimated RMS error of the field, W/m².
    estimated_rms: f64,
}

/// What is gathered from.
struct Coarse<'a> {
    mesh: SolveMesh,
    trees: Vec<FaceCells>,
    light: Sources,
    blockers: &'a Blockers,
    /// Permitted error of one gather, W/m², less the amplification by further bounces.
    error: f64,
    /// Share of the light that is lost with each bounce.
    loss: f64,
    /// Area of all faces, m².
    area: f64,
}

impl Coarse<'_> {
    fn gatherer(&self) -> Gatherer<'_> {
        Gatherer::new(&self.mesh, &self.trees, self.blockers)
    }

    fn gatherers(&self) -> Gatherers<'_> {
        Gatherers::new(&self.mesh, &self.trees, self.blockers)
    }

    /// How good a gather is where all of what it misses comes back. The mistakes of rays fall differently on each point: what
    /// comes back of them is a mean over many.
    fn accuracy(&self) -> Accuracy {
        Accuracy {
            link: self.error,
            ray: self.error / self.loss,
            together: f64::INFINITY,
            sweep: RAYS,
        }
    }

    /// The same on `face`.
    fn accuracy_on(&self, face: &SolveFace) -> Accuracy {
        match self.mesh.is_crowded() {
            true => self
                .accuracy()
                .times(Size::new(face.area, self.area).accuracy()),
            false => self.accuracy(),
        }
    }

    /// The field as it starts when the nodes of the solution are whole elements: gathered at points.
    fn gathered_at_nodes(&self) -> Vec<FieldFace> {
        let (nodes, views) = point_nodes(&self.mesh, self.blockers);
        let gathered: Vec<Gathered> = views
            .par_iter()
            .map_init(
                || self.gatherer(),
                |gatherer, view| self.gather_links(gatherer, view, &self.light, self.accuracy()),
            )
            .collect();
        let values: Vec<Irradiance> = gathered.iter().map(|g| g.value).collect();
        let field = NodalField {
            nodes: &nodes,
            values: &values,
        };
        let source = |node: u32| gathered[node as usize].source.clone();
        self.started(&field, source)
    }

    /// The field as it starts: from where light comes to each node `source` tells.
    fn started(
        &self,
        values: &NodalField,
        source: impl Fn(u32) -> Source + Copy,
    ) -> Vec<FieldFace> {
        let inset = inset(self.blockers.weld_distance());
        let faces = self.mesh.faces.iter().enumerate();
        faces
            .map(|(f, face)| FieldFace::new(face, f, values, inset, source))
            .collect()
    }

    /// Indirect irradiance at `view` from `light`, W/m².
    fn gather(
        &self,
        gatherer: &mut Gatherer,
        view: &Viewpoint,
        light: &Sources,
        accuracy: Accuracy,
    ) -> Irradiance {
        self.visit(gatherer, view, light, accuracy, |_, _, _| ())
    }

    /// The same, and the cells that it comes from.
    fn gather_links(
        &self,
        gatherer: &mut Gatherer,
        view: &Viewpoint,
        light: &Sources,
        accuracy: Accuracy,
    ) -> Gathered {
        let mut links = Vec::new();
        let value = self.visit(gatherer, view, light, accuracy, |f, c, weights| {
            links.push(CellLink::new(f, c, weights));
        });
        Gathered {
            value,
            source: Source::Cells(merged(links)),
        }
    }

    fn visit(
        &self,
        gatherer: &mut Gatherer,
        view: &Viewpoint,
        light: &Sources,
        accuracy: Accuracy,
        mut link: impl FnMut(usize, usize, [f64; 3]),
    ) -> Irradiance {
        let oracle = oracle(&self.mesh, light, accuracy);
        let mut sum = Irradiance::ZERO;
        gatherer.visit(view, &oracle, &mut |f, c, weights| {
            let corners = &light.faces[f].cells[c].corners;
            for (b, w) in corners.iter().zip(weights) {
                sum += Irradiance(b.0 * w);
            }
            link(f, c, weights);
        });
        sum
    }
}

fn follow_limits(mesh: &SolveMesh, error: f64) -> FollowLimits {
    FollowLimits {
        error,
        smallest: SMALLEST_SHARE * mesh.spacing,
    }
}

/// The light of the cells when `arriving` (W/m²) reaches them, and what it has over `old`.
fn residual(
    mesh: &SolveMesh,
    trees: &mut [FaceCells],
    old: Vec<impl Borrow<FaceLight> + Send>,
    error: f64,
    arriving: impl Fn(&SolveFace, usize, DVec2) -> Irradiance + Sync,
) -> (Vec<FaceLight>, Vec<FaceLight>) {
    let new = follow_all(trees, &mesh.faces, follow_limits(mesh, error), |f, p| {
        let face = &mesh.faces[f];
        Radiosity(face.reflectance_at(p) * arriving(face, f, p).0)
    });
    let residual = new
        .par_iter()
        .zip(old.into_par_iter())
        .zip(trees)
        .map(|((new, old), tree)| new.minus(old.borrow(), tree))
        .collect();
    (new, residual)
}

impl<'a> IndirectField<'a> {
    /// Solves for the indirect light on `mesh`, given the direct light at every point of its faces (`direct(face, its index, point)`,
    /// frame coordinates, W/m²).
    ///
    /// # Errors
    /// [`TooManyUnknowns`] of the dense solver; the others take any number.
    pub fn solve(
        mesh: SolveMesh,
        blockers: &'a Blockers,
        request: Request,
        direct: impl Fn(&SolveFace, usize, DVec2) -> Irradiance + Sync,
    ) -> Result<(Self, SolveReport), TooManyUnknowns> {
        // What a gather misses comes back with every bounce.
        let loss = mesh.loss();
        let error = request.error * loss;
        let mut trees: Vec<FaceCells> = mesh
            .faces
            .par_iter()
            .map(|f| FaceCells::new(f, mesh.spacing, request.basis))
            .collect();
        let held = held(&mesh, &trees, blockers, request.bounces);
        let sent = |f: usize, p: DVec2| {
            let face = &mesh.faces[f];
            Radiosity(face.reflectance_at(p) * direct(face, f, p).0)
        };
        let room = Room {
            mesh: &mesh,
            blockers,
            held: &held,
            request,
        };
        let Shot {
            transport,
            light,
            solved,
        } = match room.is_shot_at() {
            true => room.shoot(&mut trees, sent),
            false => room.solve(&mut trees, sent)?,
        };
        let solution = Coarse {
            area: mesh.area(),
            light: Sources::new(&mesh, light, 0.0),
            mesh,
            trees,
            blockers,
            error,
            loss,
        };
        let faces = match request.basis {
            Basis::Linear | Basis::Wavelet => {
                solution.started(&transport.field(&solved.values), Source::Node)
            }
            Basis::Constant => solution.gathered_at_nodes(),
        };
        let field = Self {
            gathers: transport.node_count(),
            solution,
            transport,
            distrust: vec![1.0; faces.len()],
            faces,
            held,
            request,
            estimated_rms: 0.0,
        };
        Ok((field, solved.report))
    }

    /// Buys gathers until the RMS error of the field over its faces is estimated below `target` (W/m²), or until `progress`
    /// says that it has to stop; `is_late`, asked for each face, may say so before.
    ///
    /// # Errors
    /// [`MeshError`]: our own bug.
    pub fn refine(
        &mut self,
        target: f64,
        is_late: impl Fn() -> bool + Sync,
        mut progress: impl FnMut(f64) -> bool,
    ) -> Result<(), MeshError> {
        let allowed = target * target * self.area();
        for _ in 0..MAX_ROUNDS {
            let goes_on = progress((target / self.estimate_rms()).min(1.0));
            if self.estimated_rms <= target || !goes_on {
                break;
            }
            let mut squares: Vec<f64> = self.squares().collect();
            squares.sort_unstable_by(f64::total_cmp);
            let mut unmarked = 0.0;
            let limit = squares
                .iter()
                .find(|&&s| {
                    unmarked += s;
                    unmarked > UNMARKED_SHARE * allowed
                })
                .copied()
                .unwrap_or(f64::INFINITY);
            let solution = &self.solution;
            let gatherers = solution.gatherers();
            let inset = inset(solution.blockers.weld_distance());
            let is_remembered = self.link_count() < MOST_LINKS;
            let gather =
                |g: &mut Gatherer, view: &Viewpoint, accuracy: Accuracy| match is_remembered {
                    true => solution.gather_links(g, view, &solution.light, accuracy),
                    false => Gathered {
                        value: solution.gather(g, view, &solution.light, accuracy),
                        source: Source::Forgotten,
                    },
                };
            let bought: Vec<usize> = self
                .faces
                .par_iter_mut()
                .zip(&solution.mesh.faces)
                .zip(&self.distrust)
                // One face may cost more than all others together.
                .with_max_len(1)
                .map(|((field, face), distrust)| {
                    let limit = limit / distrust;
                    if is_late() {
                        return Ok(0);
                    }
                    let accuracy = solution.accuracy_on(face).shown();
                    field.buy(face, limit, inset, |view| {
                        gatherers.lend(|g| gather(g, view, accuracy))
                    })
                })
                .collect::<Result<_, _>>()?;
            let bought: usize = bought.iter().sum();
            self.gathers += bought;
            if bought == 0 {
                break;
            }
            self.held.iter_mut().for_each(Held::forget);
        }
        Ok(())
    }

    /// Links that points remember.
    fn link_count(&self) -> usize {
        self.faces.iter().map(FieldFace::link_count).sum()
    }

    fn area(&self) -> f64 {
        self.faces.iter().map(FieldFace::area).sum()
    }

    /// Squared errors of all elements, (W/m²)² m².
    fn squares(&self) -> impl Iterator<Item = f64> {
        let faces = self.faces.iter().zip(&self.distrust);
        faces.flat_map(|(face, &d)| face.errors().into_iter().map(move |e| d * e))
    }

    /// Takes the squared errors on solve face `f` for `factor` times what they are taken for now.
    pub fn distrust(&mut self, f: usize, factor: f64) {
        self.distrust[f] *= factor;
    }

    /// Indirect irradiance at frame coordinates `p` of solve face `f`, W/m², interpolated.
    pub fn at(&self, f: usize, p: DVec2) -> Irradiance {
        self.faces[f].at(p)
    }

    /// Mean indirect irradiance over all faces, mean of the channels, W/m².
    pub fn mean(&self) -> f64 {
        let power: f64 = self.faces.iter().map(|f| f.power().mean()).sum();
        let area = self.area();
        if area > 0.0 { power / area } else { 0.0 }
    }

    /// Mean indirect irradiance over solve face `f`, W/m².
    pub fn mean_on(&self, f: usize) -> Irradiance {
        let face = &self.faces[f];
        match face.area() {
            area if area > 0.0 => face.power() * area.recip(),
            _ => Irradiance::ZERO,
        }
    }

    /// Indirect irradiance at `view`, gathered there from the solution more finely than the field is, W/m².
    pub fn gather(&self, gatherer: &mut Gatherer, view: &Viewpoint) -> Irradiance {
        let solution = &self.solution;
        let accuracy = solution.accuracy().reference();
        solution.gather(gatherer, view, &solution.light, accuracy)
    }

    /// A gatherer for [`IndirectField::gather`].
    pub fn gatherer(&self) -> Gatherer<'_> {
        self.solution.gatherer()
    }

    /// The mesh that the solution lives on.
    pub fn mesh(&self) -> &SolveMesh {
        &self.solution.mesh
    }

    /// Number of gathers made for the field, those of the solution included.
    pub fn gathers(&self) -> usize {
        self.gathers
    }

    /// Estimated RMS error of the field against gathering everywhere when it was last refined, W/m².
    pub fn estimated_rms(&self) -> f64 {
        self.estimated_rms
    }

    /// The same as it is now.
    pub fn estimate_rms(&mut self) -> f64 {
        let total: f64 = self.squares().sum();
        self.estimated_rms = (total / self.area()).sqrt();
        self.estimated_rms
    }
}
