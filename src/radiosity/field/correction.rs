//! The correction of the field by the residual of the solution.
//!
//! What the points of the field see stays the same: the residual comes to them by the links that their gathers have left.
//! Only where a cell that is linked has been divided since, and what the residual is over it is too far from linear for
//! the weight that it has there, a point gathers the residual anew; so does one that has forgotten its links, unless there is
//! less of the residual between the nodes of the solution than is permitted to be missed.

use super::super::cells::FaceLight;
use super::super::clusters::Sources;
use super::super::field_face::{CellLink, Gathered, Point, Source};
use super::super::gather::{Gatherer, Gatherers};
use super::super::nodes::NodalField;
use super::super::solve::Transport;
use super::super::sweep::rays_for;
use super::super::walk::spread;
use super::super::{Bounces, SolveFace};
use super::accuracy::LINK_SHARE;
use super::{Coarse, IndirectField, residual};
use crate::quantity::{Irradiance, Radiosity};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// What the faces send beyond what they did.
struct Correction<'c, 'a> {
    solution: &'c Coarse<'a>,
    transport: &'c Transport,
    gatherers: Gatherers<'c>,
    change: Sources,
    /// Rays of an even set that tell as much of it as of all light.
    rays: u32,
    /// Irradiance from it at the nodes of the solution.
    at_nodes: NodalField<'c>,
}

impl IndirectField<'_> {
    /// Replaces the light of the cells by what the field and `direct` (as in [`IndirectField::solve`]) reflect, and adds to
    /// the field what that changes; returns the RMS of this correction (W/m²), an estimate of the error before it. Light
    /// that is reflected a counted number of times is left alone.
    pub fn correct(
        &mut self,
        direct: impl Fn(&SolveFace, usize, DVec2) -> Irradiance + Sync,
    ) -> f64 {
        if self.request.bounces != Bounces::All {
            return 0.0;
        }
        let (change, all) = self.relight(direct);
        let all = self.transport.field(&all);
        let at_nodes = self.transport.gather_all(&change);
        let change = Sources::new(&self.solution.mesh, change, 0.0);
        let correction = Correction {
            solution: &self.solution,
            transport: &self.transport,
            gatherers: self.solution.gatherers(),
            rays: rays_for(change.power(), self.solution.light.power()),
            change,
            at_nodes: self.transport.field(&at_nodes),
        };
        let squares: Vec<f64> = self
            .faces
            .par_iter_mut()
            .zip(&self.solution.mesh.faces)
            .enumerate()
            .with_max_len(1)
            .map(|(f, (field, face))| {
                field.add(
                    face,
                    |p| all.at(face, f, p),
                    |point| correction.at(face, f, point),
                )
            })
            .collect();
        (squares.iter().sum::<f64>() / self.area()).sqrt()
    }

    /// Replaces the light of the cells by what the field and `direct` reflect and all that this brings about; returns how the
    /// light has changed, and what it brings about at the nodes of the solution.
    fn relight(
        &mut self,
        direct: impl Fn(&SolveFace, usize, DVec2) -> Irradiance + Sync,
    ) -> (Vec<FaceLight>, Vec<Irradiance>) {
        let solution = &mut self.solution;
        let mesh = &solution.mesh;
        // Of a large scene the light of all cells is a lot of memory: the old goes as the residual comes.
        let old = std::mem::take(&mut solution.light.faces);
        let (mut new, mut change) = residual(
            mesh,
            &mut solution.trees,
            old,
            self.request.error,
            |face, f, p| direct(face, f, p) + self.faces[f].at(p),
        );
        for (f, (light, tree)) in change.iter().zip(&solution.trees).enumerate() {
            if self.held[f].note(tree, light) {
                self.transport.hold(f, &self.held[f]);
            }
        }
        // What the residual brings about at the coarse nodes: itself gathered once, and all further bounces of that.
        let all = self
            .transport
            .solve(mesh, &change, self.request.method())
            .expect("the same links have been solved before")
            .values;
        let at = self.transport.field(&all);
        let (trees, held) = (&solution.trees, &self.held);
        new.par_iter_mut()
            .zip(&mut change)
            .zip(&mesh.faces)
            .enumerate()
            .for_each(|(f, ((light, change), face))| {
                light.add(change, &trees[f], &held[f], |p| {
                    Radiosity(face.reflectance * at.at(face, f, p).0)
                });
            });
        solution.light = Sources::new(mesh, new, 0.0);
        (change, all)
    }
}

impl Correction<'_, '_> {
    /// What a point of `face`, solve face `f`, receives of it.
    fn at(&self, face: &SolveFace, f: usize, point: &mut Point) -> Irradiance {
        let accuracy = self.solution.accuracy_on(face).correcting(self.rays);
        let view = face.view(point.place);
        let is_good =
            |link: &CellLink| self.strays(link, view.position) <= LINK_SHARE * accuracy.link;
        let light = &self.change.faces;
        match &point.source {
            Source::Cells(links) if links.iter().all(is_good) => {
                let from_all = links.iter().map(|l| l.irradiance(light));
                return from_all.fold(Irradiance::ZERO, |sum, e| sum + e);
            }
            Source::Node(node) if self.transport.links(*node).all(|l| is_good(&l)) => {
                return self.at_nodes.values[*node as usize];
            }
            Source::Forgotten => {
                // Interpolation may miss as much as there is.
                let between = self.at_nodes.at(face, f, point.place);
                let permitted = LINK_SHARE * self.solution.accuracy_on(face).link;
                if self.at_nodes.greatest(face, f, point.place) <= permitted {
                    return between;
                }
                let (solution, change) = (self.solution, &self.change);
                let gather = |g: &mut Gatherer| solution.gather(g, &view, change, accuracy);
                return self.gatherers.lend(gather);
            }
            _ => {}
        }
        let Gathered { value, source } = self.gatherers.lend(|gatherer| {
            let solution = self.solution;
            solution.gather_links(gatherer, &view, &self.change, accuracy)
        });
        point.source = source;
        value
    }

    /// By how much the irradiance at `eye` from a cell that is linked may be off, W/m².
    fn strays(&self, link: &CellLink, eye: DVec3) -> f64 {
        let (f, c) = (link.face as usize, link.cell as usize);
        let most = self.change.faces[f].cells[c].deviation * link.form_factor();
        if most <= 0.0 {
            return 0.0;
        }
        let solution = self.solution;
        most * spread(
            &solution.trees[f].cells[c],
            &solution.mesh.faces[f].plane,
            eye,
        )
    }
}
