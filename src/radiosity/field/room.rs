//! The links of a room and the light that goes along them, before any of it is gathered for display.

use super::super::sweep::RAYS;
use super::accuracy::{Accuracy, oracle};
use super::{AMBIENT_SHARE, Request, follow_limits};
use crate::quantity::Radiosity;
use crate::radiosity::cells::{FaceCells, FaceLight, follow_all};
use crate::radiosity::clusters::Sources;
use crate::radiosity::held::{Held, looks_into_gap};
use crate::radiosity::solve::{Solved, Transport};
use crate::radiosity::{Bounces, Linking, SolveFace, SolveMesh, TooManyUnknowns};
use crate::scene::MINOR_SHARE;
use crate::visibility::Blockers;
use glam::DVec2;
use rayon::prelude::*;

/// Rays from each point of a small face where faces are many; from the largest of them, which are minor, and from the
/// smallest. Evenly spread, four times 128 are right to about a per cent.
const MOST_SMALL_RAYS: f64 = 128.0;
const FEWEST_SMALL_RAYS: f64 = 16.0;

/// The mistakes of `n` even rays fall as `n^(−3/4)`, and those of faces add in squares, weighed by area: so many rays are best
/// spent as this power of the area.
const SMALL_RAYS_EXPONENT: f64 = 0.4;

/// What is solved for.
pub(super) struct Room<'r> {
    pub(super) mesh: &'r SolveMesh,
    pub(super) blockers: &'r Blockers,
    /// What of each face the links have no say in.
    pub(super) held: &'r [Held],
    pub(super) request: Request,
}

/// Light between surfaces, and the links that it has gone along.
pub(super) struct Shot {
    pub(super) transport: Transport,
    /// What the cells send.
    pub(super) light: Vec<FaceLight>,
    pub(super) solved: Solved,
}

impl Room<'_> {
    /// Links the nodes as the direct light asks for that cells `send(face, point)` (frame coordinates, W/m²), and solves.
    pub(super) fn solve(
        &self,
        trees: &mut [FaceCells],
        send: impl Fn(usize, DVec2) -> Radiosity + Sync,
    ) -> Result<Shot, TooManyUnknowns> {
        let (mesh, request) = (self.mesh, &self.request);
        let limits = follow_limits(mesh, request.error);
        let light = follow_all(trees, &mesh.faces, limits, send);
        let (transport, mut sources) = self.linked(
            trees,
            light,
            request.linking,
            request.error,
            request.ambient,
        );
        let solved = transport.solve(mesh, &sources.faces, request.method())?;
        transport.take_over(&solved, &mut sources.faces);
        Ok(Shot {
            transport,
            light: sources.faces,
            solved,
        })
    }

    /// Links all nodes with what sends `light`, for a solution that may be off by `error`, where up to `ambient` is still to
    /// come on average, W/m².
    pub(super) fn linked(
        &self,
        trees: &[FaceCells],
        light: Vec<FaceLight>,
        linking: Linking,
        error: f64,
        ambient: f64,
    ) -> (Transport, Sources) {
        let (mesh, request) = (self.mesh, &self.request);
        // What a gather misses comes back with every bounce.
        let loss = mesh.loss();
        // Whatever may come on top of the light, no cell that has children is good enough for leaves.
        let (accuracy, ambient) = match linking {
            Linking::Hierarchical => (error * loss, AMBIENT_SHARE * ambient),
            Linking::Leaves => (0.0, 1.0),
        };
        let sources = Sources::new(mesh, light, ambient);
        let accuracy = Accuracy {
            link: accuracy,
            ray: accuracy / loss,
            together: f64::INFINITY,
            sweep: RAYS,
        };
        let oracle = oracle(mesh, &sources, accuracy);
        let (is_crowded, area) = (mesh.is_crowded(), mesh.area());
        let rays =
            |face: &SolveFace| (is_crowded && face.is_small).then(|| small_rays(face.area / area));
        let mut transport =
            Transport::new(mesh, trees, self.blockers, &oracle, request.basis, rays);
        for (f, held) in self.held.iter().enumerate() {
            transport.hold(f, held);
        }
        (transport, sources)
    }
}

/// What links have no say in: the corrections alone bring it back.
pub(super) fn held(
    mesh: &SolveMesh,
    trees: &[FaceCells],
    blockers: &Blockers,
    bounces: Bounces,
) -> Vec<Held> {
    let is_corrected = bounces == Bounces::All;
    trees
        .par_iter()
        .zip(&mesh.faces)
        .map(|(tree, face)| {
            Held::new(tree, |cell| {
                is_corrected && looks_into_gap(face, cell, blockers)
            })
        })
        .collect()
}

/// Rays from each point of a small face that makes up this share of all faces.
fn small_rays(share: f64) -> u32 {
    let rays = MOST_SMALL_RAYS * (share / MINOR_SHARE).powf(SMALL_RAYS_EXPONENT);
    rays.clamp(FEWEST_SMALL_RAYS, MOST_SMALL_RAYS) as u32
}
