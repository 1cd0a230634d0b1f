//! What stands between the emitters and a small piece of a face, found once for all looks from there.
//!
//! Of hundreds of lamps in a house a floor sees those of its own room. That a wall hides a lamp from all of a piece of the
//! floor is proven once, and the piece never looks there again; where only a few things stand between, the piece's looks
//! need not search for them (shafts: Haines & Wallace 1991).
//!
//! Points on the piece's rim are taken for its own: at the foot of a wall they are behind it as all the piece is, though they
//! see the wall edge-on.

use super::DirectLight;
use crate::visibility::{FEW_SCREENS, Shaft, Target, clip_to_front};
use std::sync::atomic::Ordering;

/// So many screens before an emitter are kept; more are searched for by each look. A look passes them all, which costs as
/// much as a search that finds none among tens of thousands.
const MOST_KEPT: usize = 64;

/// The emitters that may be seen from a convex piece of a face.
#[derive(Clone, Debug, Default)]
pub struct Vantage {
    /// Ascending.
    sights: Vec<Sighted>,
    screens: Vec<u32>,
    /// Whether more is known than from the piece around.
    is_news: bool,
}

/// An emitter's polygon that may be seen.
#[derive(Clone, Copy, Debug)]
struct Sighted {
    number: u32,
    /// The range of those of the screens that may hide it, unless they are too many.
    screens: Option<[u32; 2]>,
}

impl Vantage {
    /// All of so many polygons may be seen.
    pub(super) fn of_all(count: usize) -> Self {
        let numbers = 0..count as u32;
        let sight = |number| Sighted {
            number,
            screens: None,
        };
        Self {
            sights: numbers.map(sight).collect(),
            ..Self::default()
        }
    }

    /// Leaves out the polygons, by number, that cannot be seen.
    pub(super) fn retain(&mut self, mut may_be_seen: impl FnMut(u32) -> bool) {
        self.sights.retain(|s| may_be_seen(s.number));
    }

    /// The numbers of the polygons, each with the screens that may hide it, if these are known.
    pub(super) fn sights(&self) -> impl Iterator<Item = (u32, Option<&[u32]>)> {
        let range = |[from, to]: [u32; 2]| &self.screens[from as usize..to as usize];
        self.sights
            .iter()
            .map(move |s| (s.number, s.screens.map(range)))
    }

    /// How many of the emitters' convex polygons may be seen.
    pub fn count(&self) -> usize {
        self.sights.len()
    }

    /// Whether more is known from here than from the piece around, or than nothing.
    pub fn is_news(&self) -> bool {
        self.is_news
    }

    /// Whether looks from a part of the piece would hardly cost less from a vantage of their own: few screens are before each
    /// emitter, or a crowd that is the same from everywhere.
    pub fn is_settled(&self) -> bool {
        let is_past_few = |s: &[u32]| s.len() <= FEW_SCREENS;
        !self.is_news || self.sights().all(|(_, s)| s.is_some_and(is_past_few))
    }
}

impl DirectLight<'_> {
    /// What is seen from `piece`, a convex piece of a face; `around` is that of a piece which holds it.
    pub fn vantage(&self, piece: Target, around: Option<&Vantage>) -> Vantage {
        let mut found = Vantage::default();
        match around {
            Some(around) => {
                for (number, screens) in around.sights() {
                    self.sight(piece, number, screens, &mut found);
                }
            }
            None => {
                for number in 0..self.polygons.len() as u32 {
                    self.sight(piece, number, None, &mut found);
                }
            }
        }
        found
    }

    /// How often an emitter was found to be hidden from all of a side of a face, or from all of a piece of it.
    pub fn hidden_sights(&self) -> usize {
        self.hidden_sights.load(Ordering::Relaxed)
    }

    /// Adds polygon `number` to `found` unless it cannot be seen from `piece`, past some of `around` if these are known.
    fn sight(&self, piece: Target, number: u32, around: Option<&[u32]>, found: &mut Vantage) {
        let polygon = &self.polygons[number as usize];
        // Neither is seen from behind the other.
        let above = clip_to_front(&polygon.corners, piece.plane);
        let ahead = clip_to_front(piece.corners, polygon.plane);
        if above.len() < 3 || ahead.len() < 3 {
            return;
        }
        let [piece, polygon_above] = [(&ahead, piece.plane), (&above, polygon.plane)]
            .map(|(corners, plane)| Target { corners, plane });
        let (blockers, shaft) = (self.blockers, Shaft::new(piece, polygon_above));
        if shaft.is_hidden_along_its_middle(polygon.face, blockers) {
            found.is_news = true;
            self.hidden_sights.fetch_add(1, Ordering::Relaxed);
            return;
        }
        let first = found.screens.len();
        let is_known = match around {
            Some(around) => {
                let may_hide = around.iter().filter(|&&s| shaft.may_hide(s, blockers));
                found.screens.extend(may_hide);
                true
            }
            None => shaft.collect_few_screens(MOST_KEPT, blockers, &mut found.screens),
        };
        found.is_news |= is_known;
        if !is_known {
            found.screens.truncate(first);
        }
        found.sights.push(Sighted {
            number,
            screens: is_known.then_some([first as u32, found.screens.len() as u32]),
        });
    }
}
