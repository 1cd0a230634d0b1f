//! Which emitters a box full of faces may see: found for many faces at once, before each looks for itself.
//!
//! In a street of a thousand rooms with a lamp each a chair sees one lamp. To ask each face about each lamp would cost more
//! than all its light. So boxes of faces are halved, and what a wall hides from a whole box none of its parts asks about any
//! more: from-region visibility as a hierarchy (Teller & Séquin 1991 ask it of rooms and doorways).

use super::{DirectLight, Vantage};
use crate::geom::bounds;
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::Shaft;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// A box with no more sides is not halved: they are near each other, and see the same.
const MOST_SIDES: usize = 4;

/// Where a box and its halves find less than this share of the emitters outside of them hidden, smaller ones hardly find more:
/// a figure among hundreds of lamps sees most of them from everywhere.
const LEAST_HIDDEN: f64 = 1.0 / 16.0;

impl DirectLight<'_> {
    /// For each of some sides of faces the emitters that may be seen from there.
    pub fn vantages_of_sides(
        &self,
        scene: &Scene,
        sides: &[(FaceId, FaceSide)],
    ) -> Vec<Arc<Vantage>> {
        let all = Arc::new(Vantage::of_all(self.polygons.len()));
        let boxes = sides.iter().map(|&(face, side)| box_of(scene, face, side));
        let mut items: Vec<Item> = (0u32..).zip(boxes).map(|(i, b)| Item(i, b)).collect();
        let mut found = vec![all.clone(); sides.len()];
        if !items.is_empty() {
            for (i, vantage) in self.halve(&mut items, &all, false) {
                found[i as usize] = vantage;
            }
        }
        found
    }

    /// What each of `items` sees of what is seen from around them; `was_idle` when little of that was found hidden from there.
    fn halve(
        &self,
        items: &mut [Item],
        around: &Vantage,
        was_idle: bool,
    ) -> Vec<(u32, Arc<Vantage>)> {
        let (low, high) = bounds(items.iter().flat_map(|i| [i.1.0, i.1.1]));
        let (mut seen, mut outside) = (around.clone(), 0);
        seen.retain(|number| {
            let polygon = &self.polygons[number as usize];
            let middle = polygon.middle();
            if middle.cmpge(low).all() && middle.cmple(high).all() {
                return true;
            }
            outside += 1;
            let shaft = Shaft::from_box((low, high), polygon.target());
            !shaft.is_hidden_along_its_middle(polygon.face, self.blockers)
        });
        let hidden = around.count() - seen.count();
        let looks = &self.hidden_sights;
        looks.fetch_add(hidden * items.len(), Ordering::Relaxed);
        let is_idle = (hidden as f64) < LEAST_HIDDEN * f64::from(outside);
        if items.len() <= MOST_SIDES || seen.count() == 0 || (is_idle && was_idle) {
            let seen = Arc::new(seen);
            return items.iter().map(|i| (i.0, seen.clone())).collect();
        }
        let size = (high - low).to_array();
        let axis = (0..3).fold(0, |most, k| if size[k] > size[most] { k } else { most });
        let place = |i: &Item| i.1.0[axis] + i.1.1[axis];
        let half = items.len() / 2;
        // Of equal places the number decides.
        items.select_nth_unstable_by(half, |a, b| {
            place(a).total_cmp(&place(b)).then(a.0.cmp(&b.0))
        });
        let (first, second) = items.split_at_mut(half);
        let halve = |items| self.halve(items, &seen, is_idle);
        let (mut all, rest) = rayon::join(|| halve(first), || halve(second));
        all.extend(rest);
        all
    }
}

/// What holds a side of a face, moved forwards by the weld distance: what lies in the face's plane hides nothing from its
/// front, and everything from behind.
fn box_of(scene: &Scene, face: FaceId, side: FaceSide) -> (DVec3, DVec3) {
    let ahead = scene.normal(face, side) * scene.weld_distance;
    let corners = scene.faces[face].loops.iter().flatten();
    bounds(corners.map(|&v| scene.vertices[v] + ahead))
}

/// The number of a side, and its box.
struct Item(u32, (DVec3, DVec3));
