//! The opaque world as the largest convex things it is made of: solids, and the convex parts of all other faces.

use super::solid::{Solid, solids};
use super::{Blockers, BoxTree, Region, Viewpoint};
use crate::geom::{Plane, bounds};
use crate::scene::Scene;
use glam::DVec3;

/// What hides as one.
#[derive(Clone, Copy)]
pub(super) enum Screen {
    /// A convex part of a face.
    Part(u32),
    /// A convex solid.
    Solid(u32),
}

/// All screens, in a tree.
pub(super) struct Screens {
    pub(super) all: Vec<Screen>,
    pub(super) solids: Vec<Solid>,
    /// For each part its screen.
    of_part: Vec<u32>,
    tree: BoxTree,
}

impl Screens {
    /// Every one of `part_count` convex parts, with the given corners, is a screen or belongs to one.
    pub(super) fn new<'p>(
        scene: &Scene,
        first_part: &[u32],
        part_count: usize,
        roundoff: f64,
        corners: impl Fn(u32) -> &'p [DVec3],
    ) -> Self {
        let solids = solids(scene, first_part, roundoff);
        let mut of_part: Vec<Option<u32>> = vec![None; part_count];
        for (s, solid) in solids.iter().enumerate() {
            for &i in &solid.parts {
                of_part[i as usize] = Some(s as u32);
            }
        }
        let mut all: Vec<Screen> = (0..solids.len() as u32).map(Screen::Solid).collect();
        let of_part = (0u32..)
            .zip(of_part)
            .map(|(i, solid)| {
                solid.unwrap_or_else(|| {
                    all.push(Screen::Part(i));
                    all.len() as u32 - 1
                })
            })
            .collect();
        let tree = BoxTree::new(all.iter().map(|&s| {
            let corners = match s {
                Screen::Part(i) => corners(i),
                Screen::Solid(i) => &solids[i as usize].corners,
            };
            bounds(corners.iter().copied())
        }));
        Self {
            all,
            solids,
            of_part,
            tree,
        }
    }
}

impl Blockers {
    pub(super) fn screen_corners(&self, screen: Screen) -> &[DVec3] {
        match screen {
            Screen::Part(i) => self.corners(self.part(i)),
            Screen::Solid(i) => &self.screens.solids[i as usize].corners,
        }
    }

    /// The corners of screen `i`.
    pub(super) fn corners_of(&self, i: u32) -> &[DVec3] {
        self.screen_corners(self.screens.all[i as usize])
    }

    /// The screen that a part is, or belongs to.
    pub(super) fn screen_of(&self, part: u32) -> u32 {
        self.screens.of_part[part as usize]
    }

    /// Number of screens.
    pub(super) fn screen_count(&self) -> usize {
        self.screens.all.len()
    }

    /// Appends the screens that may hide from `view` something that lies in the plane `target`, ascending; every line of
    /// sight to it passes through `region`.
    pub fn collect_screens(
        &self,
        view: &Viewpoint,
        region: &Region,
        target: Plane,
        out: &mut Vec<u32>,
    ) {
        self.collect_few_screens(usize::MAX, view, region, target, out);
    }

    /// As [`Blockers::collect_screens`], unless they are more than `most`: then some are appended and it returns false.
    pub fn collect_few_screens(
        &self,
        most: usize,
        view: &Viewpoint,
        region: &Region,
        target: Plane,
        out: &mut Vec<u32>,
    ) -> bool {
        let first = out.len();
        self.screens.tree.query_while(region, |i| {
            if self.may_hide(i, view, region, target) {
                out.push(i);
            }
            out.len() - first <= most
        });
        // The tree's order depends on its shape; the scene's order gives the same pieces in the same order.
        out[first..].sort_unstable();
        out.len() - first <= most
    }

    /// Whether screen `i` is one of those that [`Blockers::collect_screens`] appends.
    pub fn may_hide(&self, i: u32, view: &Viewpoint, region: &Region, target: Plane) -> bool {
        let corners = self.corners_of(i);
        self.is_between(view, target, corners) && region.may_meet_polygon(corners, 0.0)
    }

    /// Whether some of the corners lie above the horizon of `view` and some in front of `target`.
    pub(super) fn is_between(&self, view: &Viewpoint, target: Plane, corners: &[DVec3]) -> bool {
        let tol = self.weld_distance();
        corners.iter().any(|&c| view.horizon.distance(c) > tol)
            && corners.iter().any(|&c| target.distance(c) > tol)
    }
}
