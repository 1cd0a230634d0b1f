//! Which features are looked at where there are too many of them.
//!
//! Every corner of every emitter makes a wedge with every edge within its reach. A hundred lamps over a hundred thousand
//! edges make ten million wedges, most of them for lines shorter than the elements between them. So a feature is ranked
//! before anything is traced: by its length times the most that the emitter can give there, `M A / (π d²)`. The first ones
//! are looked at, as far as the count allows, and the summary says what was not.

use super::reach::{Lamp, Reach};
use super::triple::Triple;
use crate::scene::{EdgeId, EmitterId, Face, IdVec, Scene, VertexId};
use glam::DVec3;
use rayon::prelude::*;

/// Wedges of emitters that are looked at, silhouettes or not: a second or two of work. Scenes of a few thousand faces under a
/// few lamps have fewer.
const MOST_WEDGES: usize = 400_000;

/// Views of an emitter through a vertex: each has to be cut exactly, and looks at many edges.
const MOST_VIEWS: usize = 30_000;

/// Planes of faces that are followed from an emitter.
const MOST_PLANES: usize = 40_000;

/// Triples of edges that are followed.
const MOST_TRIPLES: usize = 50_000;

/// Ranks that are told one by one; of more an even choice stands for all.
const MOST_RANKED: usize = 20_000_000;

/// Parts in the way of one view, plane or ruling from which on, in scenes of too many features, it is not followed: light comes
/// through in bits too small for any line that they draw.
const CLUTTER: usize = 256;

/// Ranks are told apart by this many steps to a factor of two, over so many factors.
const STEPS: f64 = 8.0;
const FACTORS: f64 = 64.0;

/// The ranks from which on features are looked at; 0 where all are.
#[derive(Clone, Debug)]
pub(super) struct Worth {
    lamps: IdVec<EmitterId, Lamp>,
    /// Of all features, metres.
    longest: f64,
    /// Of edges and vertices in wedges from the emitter.
    pub(super) wedge: f64,
    /// Of vertices through which the emitter is seen, and of the edges seen with it.
    pub(super) view: f64,
    /// Of the planes of faces.
    pub(super) plane: f64,
}

impl Worth {
    /// `longest_at(vertex)` is the length of the longest edge there.
    pub(super) fn new(
        scene: &Scene,
        reach: &Reach,
        longest_at: impl Fn(VertexId) -> f64 + Sync,
    ) -> Self {
        let edges: Vec<EdgeId> = scene.edges.ids().collect();
        let longest = edges.iter().map(|&e| length(scene, e));
        let mut worth = Self {
            lamps: reach.lamps.clone(),
            longest: longest.fold(0.0, f64::max),
            wedge: 0.0,
            view: 0.0,
            plane: 0.0,
        };
        let ids: Vec<EmitterId> = scene.emitters.ids().collect();
        let corners = |e: EmitterId| -> usize {
            let face = &scene.faces[scene.emitters[e].face];
            face.loops.iter().map(Vec::len).sum()
        };
        // Rank of a feature for every emitter within whose reach it is, with how often it is looked at.
        let ranks = |points: &[DVec3], length: f64, count: &dyn Fn(EmitterId) -> usize| {
            let within = ids.iter().filter(|&&e| reach.holds(e, points));
            let ranked = within.map(|&e| (worth.rank(e, points, length), count(e)));
            ranked.collect::<Vec<_>>()
        };
        let position = |v: VertexId| scene.vertices[v];
        let vertices: Vec<VertexId> = scene.vertices.ids().collect();
        let along_edge = |&e: &EdgeId| {
            let ends = scene.edges[e].ends.map(position);
            ranks(&ends, ends[0].distance(ends[1]), &corners)
        };
        let at_vertex = |&v: &VertexId| ranks(&[position(v)], longest_at(v), &corners);
        let through_vertex = |&v: &VertexId| ranks(&[position(v)], longest_at(v), &|_| 1);
        let of_face = |face: &Face| {
            let points: Vec<DVec3> = face.loops.iter().flatten().map(|&v| position(v)).collect();
            ranks(&points, face.area.sqrt(), &|_| 1)
        };
        let all: usize = ids.iter().map(|&e| corners(e)).sum();
        // Every so many-th feature stands for those up to the next one.
        let step = |features: usize| (ids.len() * features).div_ceil(MOST_RANKED).max(1);
        let wedge = if all * (edges.len() + vertices.len()) > MOST_WEDGES {
            let step = step(edges.len() + vertices.len());
            let edges = edges.par_iter().step_by(step).flat_map_iter(along_edge);
            let vertices = vertices.par_iter().step_by(step);
            least(
                edges.chain(vertices.flat_map_iter(at_vertex)),
                MOST_WEDGES / step,
            )
        } else {
            0.0
        };
        let view = if ids.len() * vertices.len() > MOST_VIEWS {
            let step = step(vertices.len());
            let vertices = vertices.par_iter().step_by(step);
            least(vertices.flat_map_iter(through_vertex), MOST_VIEWS / step)
        } else {
            0.0
        };
        let plane = if ids.len() * scene.faces.len() > MOST_PLANES {
            let step = step(scene.faces.len());
            let faces = scene.faces.as_slice().par_iter().step_by(step);
            least(faces.flat_map_iter(of_face), MOST_PLANES / step)
        } else {
            0.0
        };
        (worth.wedge, worth.view, worth.plane) = (wedge, view.max(wedge), plane);
        worth
    }

    /// Farther than this from the middle of an emitter no edge, and no vertex, ranks above `least`, metres.
    pub(super) fn radius(&self, emitter: EmitterId, least: f64) -> f64 {
        let lamp = self.lamps[emitter];
        lamp.radius + (lamp.power * self.longest / least).sqrt()
    }

    /// Whether something ranks too low to be looked at.
    pub(super) fn is_partial(&self) -> bool {
        self.wedge > 0.0 || self.view > 0.0 || self.plane > 0.0
    }

    /// The most parts that may stand in the way of what is followed.
    pub(super) fn most_in_the_way(&self) -> usize {
        if self.is_partial() {
            CLUTTER
        } else {
            usize::MAX
        }
    }

    /// The most that the emitter can give at the nearest of the box around `points`, times `length`, W/m.
    pub(super) fn rank(&self, emitter: EmitterId, points: &[DVec3], length: f64) -> f64 {
        let lamp = self.lamps[emitter];
        let distance = (lamp.distance(points) - lamp.radius).max(lamp.radius);
        lamp.power * length / (distance * distance)
    }
}

/// The rank from which on no more than `most` are counted, of ranks with their counts, in steps of an eighth of a factor of
/// two; 0 where all are within that. The same for any order and any unit.
fn least(ranks: impl ParallelIterator<Item = (f64, usize)> + Clone, most: usize) -> f64 {
    let greatest = ranks.clone().map(|r| r.0).reduce(|| 0.0, f64::max);
    let steps = (STEPS * FACTORS) as usize;
    let step_of = |rank: f64| {
        let below = (greatest / rank).log2() * STEPS;
        (below.max(0.0) as usize).min(steps)
    };
    let counts = ranks
        .fold(
            || vec![0usize; steps + 1],
            |mut counts, (rank, count)| {
                counts[step_of(rank)] += count;
                counts
            },
        )
        .reduce(
            || vec![0; steps + 1],
            |a, b| a.iter().zip(&b).map(|(x, y)| x + y).collect(),
        );
    let mut sum = 0;
    let over = counts.iter().position(|c| {
        sum += c;
        sum > most
    });
    over.map_or(0.0, |step| greatest * (-(step as f64) / STEPS).exp2())
}

/// Keeps the triples with the longest edges, as far as the count of all triples allows, `known` of which are not new; true
/// when some are left out.
pub(super) fn keep_longest(scene: &Scene, triples: &mut Vec<Triple>, known: usize) -> bool {
    let most = MOST_TRIPLES.saturating_sub(known);
    if triples.len() <= most {
        return false;
    }
    // The shortest of the three bounds what all of them draw.
    let shortest = |t: &Triple| {
        let lengths = t.edges.map(|e| length(scene, e));
        lengths.into_iter().fold(f64::INFINITY, f64::min)
    };
    let lengths = triples.par_iter().map(|t| (shortest(t), 1));
    let least = least(lengths, most);
    triples.retain(|t| shortest(t) > least);
    true
}

/// Length of an edge, metres.
pub(super) fn length(scene: &Scene, edge: EdgeId) -> f64 {
    let [a, b] = scene.edges[edge].ends.map(|v| scene.vertices[v]);
    a.distance(b)
}

#[cfg(test)]
mod tests {
    use super::least;
    use rayon::prelude::*;

    #[test]
    fn the_first_are_in_as_far_as_the_count_allows() {
        let items = [(4.0, 2), (2.0, 3), (1.0, 4)];
        let above = |most| {
            let least = least(items.par_iter().copied(), most);
            items.iter().filter(|i| i.0 > least).count()
        };
        assert_eq!(above(9), 3);
        assert_eq!(above(8), 2);
        assert_eq!(above(5), 2);
        assert_eq!(above(4), 1);
        assert_eq!(above(1), 0);
    }
}
