//! What a point sees of the cells: the transport, one receiving point at a time.
//!
//! Face by face: the parts that may stand between are found once for the face and their cones built once; then the face's
//! trees are walked from the roots. A cell that a cone hides ends the walk; cones that pass it by are not looked at again
//! below it. The walk stops at a cell whose light, seen from here, is as good as linear: its form factor is Lambert's,
//! its visible part what exact cutting leaves of it. Where faces are many, those that an even set of rays over the hemisphere
//! tells well enough are left to it.

mod swept;

use self::swept::Hit;
use super::SolveMesh;
use super::cells::{FaceCells, FaceLight};
use super::clusters::Sources;
use super::kernel::{Basis, Corner, add_triangle};
use super::sweep::Sweep;
use super::walk::{Seen, Strength, Walk, clear, sampled, share_of_samples};
use crate::direct::form_factor_of_directions;
use crate::visibility::{Blockers, Cones, Region, Relation, Scratch, Viewpoint};
use glam::DVec3;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// A face is judged by rays alone when so many of them are enough.
const FEW_RAYS: f64 = 32.0;

/// Up to so many blockers a cell in partial view is cut exactly, however faint it is.
const FEW_BLOCKERS: usize = 2;

/// A cell behind more blockers than this is looked at child by child.
const MANY_BLOCKERS: usize = 4;

/// Behind more than few blockers a cell that sends up to this many times the light of one ray is judged at sixteen
/// points: their mistakes are a quarter of one ray's.
const SAMPLED_FACTOR: f64 = 16.0;

/// How good a gather has to be; every limit is irradiance, W/m².
#[derive(Clone, Copy)]
pub(super) struct Oracle<'l> {
    /// The light of all cells.
    pub(super) sources: &'l Sources,
    /// A cell is taken as it is when what is not linear about it sends less than this.
    pub(super) link: f64,
    /// A bit of surface that sends less than this may be judged by one ray.
    pub(super) ray: f64,
    /// Rays for what they tell well enough.
    pub(super) sweep: Option<Sweep>,
}

/// Walks the cells; holds the buffers of one thread.
pub struct Gatherer<'a> {
    mesh: &'a SolveMesh,
    trees: &'a [FaceCells],
    blockers: &'a Blockers,
    scratch: Scratch,
    candidates: Vec<u32>,
    cones: Cones,
    /// For each face, the screen that last hid all of it.
    hiders: Vec<Option<u32>>,
    /// Cones that touch the cells on the way from the root to the cell at hand.
    touching: Vec<u32>,
    /// For each side whether it is cut exactly, and those that are.
    is_cut: Vec<bool>,
    cut: Vec<usize>,
    /// What rays have met.
    hits: Vec<Hit>,
}

/// Gatherers to lend: making one takes as long as there are faces, and most faces have nothing to gather.
pub(super) struct Gatherers<'a> {
    mesh: &'a SolveMesh,
    trees: &'a [FaceCells],
    blockers: &'a Blockers,
    idle: Mutex<Vec<Gatherer<'a>>>,
}

impl<'a> Gatherers<'a> {
    pub(super) fn new(mesh: &'a SolveMesh, trees: &'a [FaceCells], blockers: &'a Blockers) -> Self {
        Self {
            mesh,
            trees,
            blockers,
            idle: Mutex::default(),
        }
    }

    /// Lets `work` use one that nobody else uses. What it remembers of earlier work saves time and changes no result.
    pub(super) fn lend<R>(&self, work: impl FnOnce(&mut Gatherer<'a>) -> R) -> R {
        let idle = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let one = idle().pop();
        let mut one = one.unwrap_or_else(|| Gatherer::new(self.mesh, self.trees, self.blockers));
        let result = work(&mut one);
        idle().push(one);
        result
    }
}

/// What stands between a viewpoint and a face.
enum Outlook {
    /// One thing that hides all of it.
    Hidden,
    /// Things whose cones have been found.
    Cones,
    /// More than there are rays to be cast.
    Crowd,
}

impl<'a> Gatherer<'a> {
    pub(super) fn new(mesh: &'a SolveMesh, trees: &'a [FaceCells], blockers: &'a Blockers) -> Self {
        Self {
            mesh,
            trees,
            blockers,
            scratch: Scratch::default(),
            candidates: Vec::new(),
            cones: Cones::default(),
            hiders: vec![None; mesh.faces.len()],
            touching: Vec::new(),
            is_cut: vec![false; mesh.faces.len()],
            cut: Vec::new(),
            hits: Vec::new(),
        }
    }

    /// Calls `sink(face, cell, weights)` for every cell that `view` takes light from: its irradiance is the sum of
    /// `weights[k]` times the radiosity at the cells' corners.
    pub(super) fn visit(
        &mut self,
        view: &Viewpoint,
        oracle: &Oracle,
        sink: &mut impl FnMut(usize, usize, [f64; 3]),
    ) {
        let (mesh, roundoff) = (self.mesh, self.blockers.roundoff());
        let mut cut = std::mem::take(&mut self.cut);
        mesh.clusters
            .visit(view, oracle.sources, oracle.sweep, |f| {
                let brightest = oracle.sources.brightest(mesh, f);
                let arriving = mesh.faces[f].largest_form_factor(view, roundoff) * brightest;
                let is_swept = |s: Sweep| s.is_enough(brightest, arriving);
                if arriving > 0.0 && !oracle.sweep.is_some_and(is_swept) {
                    cut.push(f);
                    self.is_cut[f] = true;
                }
            });
        for &f in &cut {
            self.side(view, oracle, f, sink);
        }
        if let Some(sweep) = oracle.sweep {
            self.swept(view, oracle, sweep, sink);
        }
        for f in cut.drain(..) {
            self.is_cut[f] = false;
        }
        self.cut = cut;
    }

    fn walk<'w>(&self, view: &'w Viewpoint, oracle: &'w Oracle, f: usize) -> Walk<'w>
    where
        'a: 'w,
    {
        let face = &self.mesh.faces[f];
        Walk {
            view,
            oracle,
            f,
            face,
            tree: &self.trees[f],
            ambient: oracle.sources.ambient * face.reflectance.0.max_element(),
        }
    }

    /// What `view` sees of side `f`.
    fn side(
        &mut self,
        view: &Viewpoint,
        oracle: &Oracle,
        f: usize,
        sink: &mut impl FnMut(usize, usize, [f64; 3]),
    ) {
        let walk = self.walk(view, oracle, f);
        let most = walk
            .face
            .largest_form_factor(view, self.blockers.roundoff());
        // So many are enough, if each may be wrong about as much as is permitted.
        let rays = most * oracle.sources.brightest(self.mesh, f) / oracle.ray;
        let outlook = if rays <= FEW_RAYS {
            Outlook::Crowd
        } else {
            self.look_at(view, f, rays)
        };
        let roots = 0..walk.tree.roots as usize;
        match outlook {
            Outlook::Hidden => {}
            Outlook::Crowd => roots.for_each(|root| self.cell_by_rays(&walk, root, sink)),
            Outlook::Cones => {
                let all = self.touch_all();
                roots.for_each(|root| self.descend(&walk, root, all.clone(), sink));
            }
        }
    }

    /// Sum of all weights at `view`, every cell cut exactly: the share of the hemisphere filled by reflecting surfaces
    /// (0…1).
    pub fn row_sum(&mut self, view: &Viewpoint) -> f64 {
        let dark = self.trees.iter().map(FaceLight::dark).collect();
        let oracle = Oracle {
            sources: &Sources::new(self.mesh, dark, 1.0),
            link: 0.0,
            ray: 0.0,
            sweep: None,
        };
        let mut sum = 0.0;
        self.visit(view, &oracle, &mut |_, _, w| sum += w[0] + w[1] + w[2]);
        sum
    }

    /// The light of cell `c` by rays, each to a part that sends about as little as one ray may be wrong by; what sends much more
    /// for its size is cut for itself.
    fn cell_by_rays(
        &mut self,
        walk: &Walk,
        c: usize,
        sink: &mut impl FnMut(usize, usize, [f64; 3]),
    ) {
        let Some(seen) = walk.look(c) else { return };
        let rays = seen.form_factor * walk.strength(c).rms / walk.oracle.ray;
        if rays > 1.0
            && let Some(child) = walk.tree.cells[c].first_child()
        {
            self.cell_by_rays(walk, child, sink);
            self.cell_by_rays(walk, child + 1, sink);
            return;
        }
        let (blockers, eye) = (self.blockers, walk.view.position);
        let sees = |d: DVec3| blockers.sees(walk.view, eye + d, walk.face.domain.face);
        let visible = if rays > SAMPLED_FACTOR {
            match self.look_at_cell(walk, c, &seen, rays) {
                Outlook::Hidden => 0.0,
                Outlook::Cones => {
                    let all = self.touch_all();
                    self.descend(walk, c, all, sink);
                    return;
                }
                Outlook::Crowd => self.share_by_rays(walk, c, rays),
            }
        } else if rays > 1.0 {
            share_of_samples(seen.corners, sees)
        } else {
            let middle = walk.tree.cells[c].centre;
            f64::from(u8::from(sees(middle - eye)))
        };
        if visible > 0.0 {
            let f = visible * self.open_form_factor(walk, c, &seen);
            sink(walk.f, c, [f / 3.0; 3]);
        }
    }

    /// The share of cell `c` that is seen, by about so many rays.
    fn share_by_rays(&self, walk: &Walk, c: usize, rays: f64) -> f64 {
        let (view, face) = (walk.view, walk.face.domain.face);
        let rays = 0..rays.ceil() as u32;
        let [seen, all] = self.blockers.seen_by_rays(view, walk.target(c), face, rays);
        if all > 0.0 { seen / all } else { 0.0 }
    }

    /// The form factor of cell `c` if nothing hid it.
    fn open_form_factor(&mut self, walk: &Walk, c: usize, seen: &Seen) -> f64 {
        let n = walk.view.horizon.normal;
        if seen.is_above {
            return form_factor_of_directions(n, &seen.corners);
        }
        let mut f = 0.0;
        let (target, none) = (walk.target(c), std::iter::empty());
        self.scratch
            .visible_past(self.blockers, none, walk.view, target, |piece| {
                f += form_factor_of_directions(n, piece);
            });
        f
    }

    /// Finds the cones of everything between the viewpoint and cell `c`, unless they are more than `most`.
    fn look_at_cell(&mut self, walk: &Walk, c: usize, seen: &Seen, most: f64) -> Outlook {
        let (view, target) = (walk.view, walk.target(c));
        let region = Region::pyramid(view.position, target.corners)
            .in_front_of([view.horizon, target.plane]);
        self.candidates.clear();
        let (blockers, candidates) = (self.blockers, &mut self.candidates);
        if !blockers.collect_few_screens(most as usize, view, &region, target.plane, candidates) {
            return Outlook::Crowd;
        }
        let cones = &mut self.cones;
        match blockers.cones(candidates, view, target.plane, &seen.corners, cones) {
            None => Outlook::Cones,
            Some(_) => Outlook::Hidden,
        }
    }

    /// All cones may touch what is looked at.
    fn touch_all(&mut self) -> Range<usize> {
        self.touching.clear();
        self.touching.extend(0..self.cones.len() as u32);
        0..self.cones.len()
    }

    /// Finds the cones of everything between `view` and face number `f`, unless they are more than `most`.
    fn look_at(&mut self, view: &Viewpoint, f: usize, most: f64) -> Outlook {
        let face = &self.mesh.faces[f];
        let blockers = self.blockers;
        let rectangle = face.rectangle.map(|p| p - view.position);
        let region = face.region(view).in_front_of([view.horizon, face.plane]);
        self.candidates.clear();
        // What hid the face from the last viewpoint likely hides it from this one.
        if let Some(hider) = self.hiders[f]
            && blockers.may_hide(hider, view, &region, face.plane)
        {
            self.candidates.push(hider);
            let cones = &mut self.cones;
            let hiding = blockers.cones(&self.candidates, view, face.plane, &rectangle, cones);
            if hiding.is_some() {
                return Outlook::Hidden;
            }
            self.candidates.clear();
        }
        let candidates = &mut self.candidates;
        if !blockers.collect_few_screens(most as usize, view, &region, face.plane, candidates) {
            return Outlook::Crowd;
        }
        let cones = &mut self.cones;
        self.hiders[f] = blockers.cones(&self.candidates, view, face.plane, &rectangle, cones);
        match self.hiders[f] {
            None => Outlook::Cones,
            Some(_) => Outlook::Hidden,
        }
    }

    /// The light of cell `c`, past those of the cones that `parents` lists.
    fn descend(
        &mut self,
        walk: &Walk,
        c: usize,
        parents: Range<usize>,
        sink: &mut impl FnMut(usize, usize, [f64; 3]),
    ) {
        let Some(seen) = walk.look(c) else { return };
        let first = self.touching.len();
        for i in parents {
            let cone = self.touching[i];
            if self.cones.is_clear_of(cone as usize, &seen.ball) {
                continue;
            }
            match self.cones.get(cone as usize).relation(&seen.corners) {
                Relation::Apart => {}
                Relation::Holds => {
                    self.touching.truncate(first);
                    return;
                }
                Relation::Touches => self.touching.push(cone),
            }
        }
        let touching = first..self.touching.len();
        let strength = walk.strength(c);
        let strays = strength.deviation * seen.form_factor * seen.spread;
        // Behind many blockers the children, each behind fewer, are cut for less.
        let is_cluttered = touching.len() > MANY_BLOCKERS
            && seen.form_factor * strength.rms > SAMPLED_FACTOR * walk.oracle.ray;
        match walk.tree.cells[c].first_child() {
            Some(child) if strays > walk.oracle.link || is_cluttered => {
                self.descend(walk, child, touching.clone(), sink);
                self.descend(walk, child + 1, touching, sink);
            }
            child => {
                if child.is_none() {
                    walk.tree.expose(c, seen.form_factor * seen.spread);
                }
                let weights = if touching.is_empty() && seen.is_above {
                    clear(walk, &seen, &strength)
                } else {
                    self.partial(walk, c, &seen, &strength, touching)
                };
                sink(walk.f, c, weights);
            }
        }
        self.touching.truncate(first);
    }

    /// The weights of what the given cones leave of a cell.
    fn partial(
        &mut self,
        walk: &Walk,
        c: usize,
        seen: &Seen,
        strength: &Strength,
        touching: Range<usize>,
    ) -> [f64; 3] {
        let n = walk.view.horizon.normal;
        let touching = &self.touching[touching];
        let cones = || touching.iter().map(|&i| self.cones.get(i as usize));
        let rays = seen.form_factor * strength.rms / walk.oracle.ray;
        if touching.len() > FEW_BLOCKERS && rays <= SAMPLED_FACTOR {
            return [sampled(n, seen.corners, cones) / 3.0; 3];
        }
        if touching.len() as f64 > rays {
            let visible = self.share_by_rays(walk, c, rays);
            return [visible * self.open_form_factor(walk, c, seen) / 3.0; 3];
        }
        let mut sum = [0.0; 3];
        let basis = Basis::new(seen.corners);
        let target = walk.target(c);
        let is_far = seen.is_far(strength, walk.oracle.link);
        self.scratch
            .visible_past(self.blockers, cones(), walk.view, target, |piece| {
                let corner = |&direction: &DVec3| Corner {
                    direction,
                    basis: basis.at(direction),
                };
                if !is_far {
                    let f = form_factor_of_directions(n, piece);
                    if strength.range * f <= walk.oracle.link {
                        let middle = piece.iter().sum::<DVec3>() / piece.len() as f64;
                        for (s, w) in sum.iter_mut().zip(basis.at(middle)) {
                            *s += f * w;
                        }
                        return;
                    }
                }
                let [first, second, others @ ..] = piece else {
                    return;
                };
                let (first, mut last) = (corner(first), corner(second));
                for next in others.iter().map(corner) {
                    add_triangle(n, [first, last, next], is_far, &mut sum);
                    last = next;
                }
            });
        sum
    }
}

#[cfg(test)]
mod tests;
