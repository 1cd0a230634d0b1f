//! What an even set of rays tells a point of the light: all that is not worth cutting.

use super::super::clusters::Sources;
use super::super::sweep::{RUNS, Runs, Sweep, met};
use super::{Gatherer, Oracle};
use crate::mesh::barycentric;
use crate::quantity::Irradiance;
use crate::scene::{FaceId, FaceSide};
use crate::visibility::Viewpoint;
use glam::DVec3;
use std::ops::Range;

/// A point of a cell that a ray has met, by what the light at each corner counts there.
pub(super) struct Hit {
    face: usize,
    cell: usize,
    weights: [f64; 3],
}

impl Hit {
    /// What arrives if all rays find it.
    fn light(&self, sources: &Sources) -> Irradiance {
        let corners = &sources.faces[self.face].cells[self.cell].corners;
        let parts = corners.iter().zip(self.weights);
        parts.fold(Irradiance::ZERO, |sum, (b, w)| sum + Irradiance(b.0 * w))
    }
}

impl Gatherer<'_> {
    /// What an even set of rays meets of the sides that are not cut: more of them where those that were cast do not agree.
    pub(super) fn swept(
        &mut self,
        view: &Viewpoint,
        oracle: &Oracle,
        sweep: Sweep,
        sink: &mut impl FnMut(usize, usize, [f64; 3]),
    ) {
        let mut hits = std::mem::take(&mut self.hits);
        let mut runs = Runs::default();
        let (mut cast, mut rays, mut old) = (0, sweep.rays, 0);
        loop {
            let parts = (RUNS - old) as u32;
            let start = |part: usize| cast + (rays - cast) * part as u32 / parts;
            for run in old..RUNS {
                let numbers = start(run - old)..start(run - old + 1);
                for (face, side, point) in met(self.blockers, view, numbers) {
                    if let Some(hit) = self.hit(view, oracle, (face, side), point) {
                        runs.sums[run] += hit.light(oracle.sources);
                        hits.push(hit);
                    }
                }
            }
            cast = rays;
            if !sweep.goes_on(&runs, rays) {
                break;
            }
            runs.join();
            (rays, old) = (2 * rays, RUNS / 2);
        }
        let share = 1.0 / f64::from(rays);
        for hit in hits.drain(..) {
            sink(hit.face, hit.cell, hit.weights.map(|w| w * share));
        }
        self.hits = hits;
    }

    /// What a ray meets at `point` of a side, unless that is cut.
    fn hit(
        &self,
        view: &Viewpoint,
        oracle: &Oracle,
        (face, side): (FaceId, FaceSide),
        point: DVec3,
    ) -> Option<Hit> {
        let f = self.mesh.number(face, side).filter(|&f| !self.is_cut[f])?;
        let walk = self.walk(view, oracle, f);
        let p = walk.face.domain.frame.to_plane(point);
        let c = walk.cell_at(p)?;
        Some(Hit {
            face: f,
            cell: c,
            weights: barycentric(walk.tree.cells[c].flat, p),
        })
    }

    /// As [`Gatherer::visit`] by these rays of an even set alone, taking the light as even over whole roots: right to a few
    /// per cent.
    pub(in crate::radiosity) fn visit_by_rays(
        &self,
        view: &Viewpoint,
        rays: Range<u32>,
        sink: &mut impl FnMut(usize, usize, [f64; 3]),
    ) {
        let share = 1.0 / f64::from(rays.end - rays.start);
        for (face, side, point) in met(self.blockers, view, rays) {
            let Some(f) = self.mesh.number(face, side) else {
                continue;
            };
            let p = self.mesh.faces[f].domain.frame.to_plane(point);
            if let Some(root) = self.trees[f].root_at(p) {
                sink(f, root, [share / 3.0; 3]);
            }
        }
    }
}
