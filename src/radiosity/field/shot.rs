//! Progressive refinement: cells and links follow the light while it is shot.
//!
//! Before the first shot only the direct light is known. So the first shots go along coarse links; then those cells are
//! divided across which what has arrived, direct light and all, departs from linear by too much, and the nodes are linked
//! anew with the cells that this light asks for. What has arrived stays: only what the finer links find out about it is
//! left to send. Cohen, Chen, Wallace & Greenberg, *A progressive refinement approach to fast radiosity image generation*
//! (1988), divide the elements of shooting patches in the same way; that links have levels, too, is Hanrahan, Salzman &
//! Aupperle's (1991), who refine them between iterations.

use super::follow_limits;
use super::room::{Room, Shot};
use crate::quantity::{Irradiance, Radiosity};
use crate::radiosity::cells::{FaceCells, FaceLight, FollowLimits, follow_all};
use crate::radiosity::solve::Transport;
use crate::radiosity::solvers::Until;
use crate::radiosity::{Basis, Bounces, Linking, Solver};
use glam::DVec2;

/// The error that links and cells permit from level to level, in parts of the one asked for: on cells half as wide light
/// departs from linear by a quarter.
const LEVELS: [f64; 3] = [16.0, 4.0, 1.0];

/// One level of links.
#[derive(Clone, Copy)]
struct Level {
    /// What cells and links may be off by, W/m².
    error: f64,
    linking: Linking,
    /// When the next level comes.
    until: Until,
}

impl Room<'_> {
    /// Whether links follow the light while it is shot. Those of whole elements and those by rays, to many sides at a time,
    /// are made once; counted bounces are no shots.
    pub(super) fn is_shot_at(&self) -> bool {
        let request = &self.request;
        request.solver == Solver::Progressive
            && request.basis != Basis::Constant
            && request.bounces == Bounces::All
            && !self.mesh.is_crowded()
    }

    /// Shoots the light that cells `send(face, point)` (frame coordinates, W/m²) level by level. Where all leaves are to be
    /// linked, those of the last level are.
    pub(super) fn shoot(
        &self,
        trees: &mut [FaceCells],
        send: impl Fn(usize, DVec2) -> Radiosity + Sync,
    ) -> Shot {
        let request = &self.request;
        let [coarse @ .., last] = LEVELS.map(|factor| factor * request.error);
        let (mut ambient, mut shot) = (request.ambient, None);
        for error in coarse {
            let level = Level {
                error,
                linking: Linking::Hierarchical,
                until: Until::Ambient(error),
            };
            let (next, left) = self.level(level, trees, ambient, shot, &send);
            (shot, ambient) = (Some(next), left);
        }
        let level = Level {
            error: last,
            linking: request.linking,
            until: Until::Settled,
        };
        self.level(level, trees, ambient, shot, send).0
    }

    /// Goes on from light that has been shot `before`; and tells how much is still to come on average, where it was thought to
    /// be `ambient`, W/m².
    fn level(
        &self,
        level: Level,
        trees: &mut [FaceCells],
        ambient: f64,
        before: Option<Shot>,
        send: impl Fn(usize, DVec2) -> Radiosity + Sync,
    ) -> (Shot, f64) {
        let transport = self.refined(level, trees, ambient, before.as_ref(), &send);
        let mut light = self.projected(trees, send);
        let arrived = before.as_ref().map(|s| s.solved.values.as_slice());
        let tolerance = self.request.tolerance;
        let (mut solved, left) =
            transport.shoot(self.mesh, &light, tolerance, arrived, level.until);
        transport.take_over(&solved, &mut light);
        let report = &mut solved.report;
        report.reason = match before {
            None => format!("links were refined while shooting, {}", report.links),
            Some(Shot { solved, .. }) => {
                let mut old = solved.report;
                report.shots += old.shots;
                old.residuals.append(&mut report.residuals);
                report.residuals = old.residuals;
                format!("{} to {}", old.reason, report.links)
            }
        };
        let shot = Shot {
            transport,
            light,
            solved,
        };
        (shot, left)
    }

    /// Divides cells and links nodes as the light asks for that has been shot so far, and up to `ambient` that is to come on
    /// average, W/m².
    fn refined(
        &self,
        level: Level,
        trees: &mut [FaceCells],
        ambient: f64,
        before: Option<&Shot>,
        send: impl Fn(usize, DVec2) -> Radiosity + Sync,
    ) -> Transport {
        let mesh = self.mesh;
        let arrived = before.map(|s| s.transport.field(&s.solved.values));
        let limits = follow_limits(mesh, level.error);
        let light = follow_all(trees, &mesh.faces, limits, |f, p| {
            let face = &mesh.faces[f];
            let arrived = arrived.map_or(Irradiance::ZERO, |a| a.at(face, f, p));
            send(f, p) + Radiosity(face.reflectance_at(p) * arrived.0)
        });
        self.linked(trees, light, level.linking, level.error, ambient)
            .0
    }

    /// The direct light on the cells that there are.
    fn projected(
        &self,
        trees: &mut [FaceCells],
        send: impl Fn(usize, DVec2) -> Radiosity + Sync,
    ) -> Vec<FaceLight> {
        let none = FollowLimits {
            error: f64::INFINITY,
            ..follow_limits(self.mesh, self.request.error)
        };
        follow_all(trees, &self.mesh.faces, none, send)
    }
}
