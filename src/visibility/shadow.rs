//! What the opaque world hides from a viewpoint: the cones of its screens, and single rays.

use super::cone::{Piece, Whole, clip};
use super::screen::Screen;
use super::solid::Stance;
use super::{Blockers, Cones, Region, Target, Viewpoint};
use crate::geom::{Plane, even_point_of};
use crate::scene::FaceId;
use glam::DVec3;
use smallvec::SmallVec;
use std::ops::Range;

impl Blockers {
    /// Appends the parts that may hide from `view` something that lies in `region` and in the plane `target`.
    pub fn collect(&self, view: &Viewpoint, region: Region, target: Plane, out: &mut Vec<u32>) {
        let region = region.in_front_of([view.horizon, target]);
        self.query(&region, |i| {
            let corners = self.corners(self.part(i));
            if self.is_between(view, target, corners) && region.may_meet_polygon(corners, 0.0) {
                out.push(i);
            }
        });
        // The tree's order depends on its shape; the scene's order gives the same pieces in the same order.
        out.sort_unstable();
    }

    /// Fills `out` with the cones of the given screens as far as they lie in front of the plane `target` and may hide some
    /// of the convex polygon `base` (directions from the viewpoint). The widest come first: what is hidden is then gone
    /// before small ones cut it into pieces. Returns a screen that hides all of `base` alone.
    pub fn cones(
        &self,
        screens: &[u32],
        view: &Viewpoint,
        target: Plane,
        base: &[DVec3],
        out: &mut Cones,
    ) -> Option<u32> {
        out.start(self, view.position);
        let wholes: SmallVec<[Whole; 64]> = screens
            .iter()
            .map(|&s| out.whole(s, |out| self.whole_screen(s, view.position, out)))
            .collect();
        for (&s, whole) in screens.iter().zip(wholes) {
            self.add_cones(s, whole, view, target, out);
        }
        let hider = out.narrow(base);
        out.items.sort_by(|a, b| b.width.total_cmp(&a.width));
        hider
    }

    /// What a screen as a whole hides from `eye`.
    fn whole_screen(&self, screen: u32, eye: DVec3, out: &mut Cones) -> Whole {
        match self.screens.all[screen as usize] {
            Screen::Part(i) => {
                let part = self.part(i);
                let distance = part.plane.distance(eye);
                if distance.abs() <= self.roundoff() {
                    return Whole::Nothing;
                }
                let rim = self.corners(part).iter().map(|c| c - eye);
                out.cone(rim, distance.signum(), screen)
                    .map_or(Whole::Nothing, Whole::Cone)
            }
            Screen::Solid(i) => {
                let solid = &self.screens.solids[i as usize];
                let mut outline = Piece::new();
                let tol = self.weld_distance();
                match solid.outline(eye, self.roundoff(), tol, &mut outline) {
                    Stance::Outside => out
                        .cone(outline.iter().map(|c| c - eye), 1.0, screen)
                        .map_or(Whole::Parts, Whole::Cone),
                    Stance::Elsewhere => Whole::Parts,
                }
            }
        }
    }

    /// Adds what a screen hides in front of the plane `target`: its cone when all of it lies there.
    fn add_cones(
        &self,
        index: u32,
        whole: Whole,
        view: &Viewpoint,
        target: Plane,
        out: &mut Cones,
    ) {
        let screen = self.screens.all[index as usize];
        // Points within the weld distance of the target's plane are in it: a ceiling does not hide the lamp flush with it.
        let tol = self.weld_distance();
        let is_ahead = |corners: &[DVec3]| corners.iter().all(|&c| target.distance(c) >= -tol);
        match (screen, whole) {
            (_, Whole::Nothing) => {}
            (_, Whole::Cone(item)) if is_ahead(self.screen_corners(screen)) => out.items.push(item),
            (Screen::Part(i), _) => self.add_clipped(i, index, view, target, out),
            (Screen::Solid(i), _) => {
                // From outside, whatever it hides its faces towards the viewpoint hide.
                let is_outside = matches!(whole, Whole::Cone(_));
                let solid = &self.screens.solids[i as usize];
                for (k, &part) in solid.parts.iter().enumerate() {
                    let is_turned_away =
                        is_outside && !solid.is_front(k, view.position, self.roundoff());
                    let corners = self.corners(self.part(part));
                    if !is_turned_away && self.is_between(view, target, corners) {
                        self.add_clipped(part, index, view, target, out);
                    }
                }
            }
        }
    }

    /// Adds the cone of what of a part (of a screen) lies in front of the target's plane, unless it hides nothing.
    fn add_clipped(
        &self,
        part: u32,
        screen: u32,
        view: &Viewpoint,
        target: Plane,
        out: &mut Cones,
    ) {
        let part = self.part(part);
        let eye = view.position;
        let distance = part.plane.distance(eye);
        // Seen edge-on it hides nothing.
        if distance.abs() <= self.roundoff() {
            return;
        }
        let tol = self.weld_distance();
        let ahead = |p: &DVec3| {
            let d = target.distance(*p);
            if d.abs() <= tol { 0.0 } else { d }
        };
        let rim = clip(self.corners(part), ahead);
        if rim.len() >= 3
            && let Some(item) = out.cone(rim.iter().map(|c| c - eye), distance.signum(), screen)
        {
            out.items.push(item);
        }
    }

    /// What of the light of `target`, a part of `face`, `view` sees by these rays of an even set, and what there would be of it
    /// if nothing hid it: in the same units, which depend on the number of rays.
    pub fn seen_by_rays(
        &self,
        view: &Viewpoint,
        target: Target,
        face: FaceId,
        rays: Range<u32>,
    ) -> [f64; 2] {
        let (mut seen, mut all) = (0.0, 0.0);
        for i in rays {
            let point = even_point_of(target.corners, i);
            let way = point - view.position;
            let squared = way.length_squared();
            if view.horizon.normal.dot(way) <= 0.0 {
                continue;
            }
            // Equal areas give light as both cosines and the inverse square of the distance say.
            let cosines = view.shading.dot(way).max(0.0) * -target.plane.normal.dot(way);
            let weight = cosines / (squared * squared);
            if weight > 0.0 {
                all += weight;
                if self.sees(view, point, face) {
                    seen += weight;
                }
            }
        }
        [seen, all]
    }

    /// True when the straight line from `view` to `point` on `face` meets no other face, tested by a ray.
    pub fn sees(&self, view: &Viewpoint, point: DVec3, face: FaceId) -> bool {
        // Nothing within the weld distance of either end stands in the way: that is the surface it lies on, or another one in its
        // plane.
        let margin = self.weld_distance() / view.position.distance(point);
        !self
            .rays()
            .is_blocked(view.position, point, margin, 1.0 - margin, |t| {
                self.ray_owner(t) == face
            })
    }
}
