//! A face in convex pieces, as small as its elements ask for, each with what stands between it and the emitters.

use crate::direct::{DirectLight, Vantage};
use crate::geom::{Plane, convex_hull};
use crate::mesh::{FaceDomain, ReceiverMesh};
use crate::scene::FaceSide;
use crate::visibility::{Target, clip_to_front};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// On a face of fewer elements each look searches for itself. Finding what a piece sees costs as much as several looks from it,
/// and an element asks for three.
const LEAST_ELEMENTS: usize = 4;

/// A piece that holds more elements than this is halved.
const MOST_ELEMENTS: usize = 6;

/// The pieces of one face, in a tree of halves.
#[derive(Default)]
pub(super) struct Vantages {
    /// None when nothing is known from the face as a whole.
    nodes: Vec<Node>,
    is_known: bool,
}

/// A piece.
struct Node {
    /// Corners, counter-clockwise seen from the side that looks, metres.
    corners: Vec<DVec3>,
    vantage: Vantage,
    /// How it was halved.
    halves: Option<Halves>,
}

struct Halves {
    /// Along the first coordinate.
    is_x: bool,
    /// What lies below this belongs to the first half.
    at: f64,
    /// The other one follows it.
    first: u32,
}

impl Vantages {
    /// The vantage of the smallest piece around a point.
    pub(super) fn at(&self, p: DVec2) -> Option<&Vantage> {
        (!self.nodes.is_empty()).then(|| &self.nodes[self.leaf_at(p)].vantage)
    }

    fn leaf_at(&self, p: DVec2) -> usize {
        let mut i = 0;
        while let Some(halves) = &self.nodes[i].halves {
            let place = if halves.is_x { p.x } else { p.y };
            i = halves.first as usize + usize::from(place >= halves.at);
        }
        i
    }

    /// Halves the pieces that hold too many elements of `mesh`; what may be seen from around the face is known to be `around`.
    pub(super) fn refine(
        &mut self,
        direct: &DirectLight,
        domain: &FaceDomain,
        mesh: &ReceiverMesh,
        around: Option<&Vantage>,
    ) {
        if !self.is_known {
            if mesh.elements.len() < LEAST_ELEMENTS {
                return;
            }
            self.is_known = true;
            let hull = convex_hull(domain.polygon().loops.iter().flatten().copied());
            if hull.len() < 3 {
                return;
            }
            let mut corners: Vec<DVec3> = hull.iter().map(|&p| domain.frame.to_space(p)).collect();
            if domain.side == FaceSide::Back {
                corners.reverse();
            }
            let whole = Node::new(corners, around, direct, domain);
            if whole.vantage.is_news() {
                self.nodes.push(whole);
            }
        }
        if self.nodes.is_empty() {
            return;
        }
        let mut held = vec![Vec::new(); self.nodes.len()];
        for e in 0..mesh.elements.len() {
            let centre = mesh.centre(e);
            held[self.leaf_at(centre)].push(centre);
        }
        let mut full: Vec<(usize, Vec<DVec2>)> = held.into_iter().enumerate().collect();
        loop {
            full.retain(|(i, held)| {
                held.len() > MOST_ELEMENTS && !self.nodes[*i].vantage.is_settled()
            });
            if full.is_empty() {
                return;
            }
            let halves: Vec<_> = full
                .par_iter()
                .map(|(i, _)| self.nodes[*i].halved(direct, domain))
                .collect();
            let mut next = Vec::with_capacity(2 * full.len());
            for ((i, held), (is_x, at, nodes)) in full.into_iter().zip(halves) {
                let first = self.nodes.len();
                self.nodes.extend(nodes);
                let node = &mut self.nodes[i];
                // Nobody asks the whole any more.
                node.vantage = Vantage::default();
                node.halves = Some(Halves {
                    is_x,
                    at,
                    first: first as u32,
                });
                let (below, above) = held
                    .into_iter()
                    .partition(|c| if is_x { c.x < at } else { c.y < at });
                next.extend([(first, below), (first + 1, above)]);
            }
            full = next;
        }
    }
}

impl Node {
    /// A piece with these corners, within one of which the vantage is known to be `around`.
    fn new(
        corners: Vec<DVec3>,
        around: Option<&Vantage>,
        direct: &DirectLight,
        domain: &FaceDomain,
    ) -> Self {
        let piece = Target {
            corners: &corners,
            plane: Plane::new(domain.frame.origin, domain.normal),
        };
        Self {
            vantage: direct.vantage(piece, around),
            corners,
            halves: None,
        }
    }

    /// Its halves, across where it is longer: what lies below which coordinate, and the rest.
    fn halved(&self, direct: &DirectLight, domain: &FaceDomain) -> (bool, f64, [Self; 2]) {
        let frame = &domain.frame;
        let places = self.corners.iter().map(|&c| frame.to_plane(c));
        let (lo, hi) = places.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), p| {
            (lo.min(p), hi.max(p))
        });
        let (middle, size) = (lo.midpoint(hi), hi - lo);
        let is_x = size.x >= size.y;
        let (at, axis) = match is_x {
            true => (middle.x, frame.u),
            false => (middle.y, frame.v),
        };
        let half = |away: DVec3| {
            let corners = clip_to_front(&self.corners, Plane::new(frame.to_space(middle), away));
            Self::new(corners.to_vec(), Some(&self.vantage), direct, domain)
        };
        (is_x, at, [half(-axis), half(axis)])
    }
}
