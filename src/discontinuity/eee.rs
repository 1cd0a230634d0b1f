//! EEE: three edges on one sight line, the emitter's own among them or the emitter behind all three.
//!
//! The sight lines are rulings of a quadric. Along its parameter everything that can happen – a ruling meets a further
//! edge, or lies in a face at one of its own edges – is the root of a quadratic; between two such events one ruling
//! speaks for all. What lights a receiver there draws an arc of a conic on it.

use super::event::Search;
use super::strength::{End, Feature, predicted_jump};
use super::triple::Triple;
use super::wedge::side_of_face;
use super::{Arc, Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::geom::{Plane, Regulus};
use crate::scene::{EdgeId, FaceId, FaceSide};
use crate::visibility::Region;
use glam::DVec3;
use smallvec::SmallVec;

/// The arcs of one triple.
#[derive(Default)]
pub(super) struct Arcs {
    pub(super) arcs: Vec<Arc>,
    /// Triples that share a ruling with these arcs.
    pub(super) next: Vec<Triple>,
}

/// The rulings of a triple in one sense of direction, from the emitter to the receivers.
struct Swath<'a> {
    search: &'a Search<'a>,
    triple: Triple,
    regulus: Regulus,
    /// The edges in the order of `regulus`.
    edges: [EdgeId; 3],
    /// The same by their order along the sight line, as indices.
    order: [usize; 3],
    /// +1 when the sight line runs along the ruling's direction.
    sense: f64,
    is_rim_first: bool,
    /// The parts of faces that may stand in the way, ascending: between the outer edges, and from there to the emitter.
    parts: Vec<u32>,
}

/// A stretch of parameters.
type Span = (f64, f64);

/// What rulings may meet: at which parameters, and which edges there.
type Meetings = Vec<(f64, EdgeId)>;

/// Where a sight line meets a face, metres along it.
type Hit = (f64, FaceId);

/// What a ruling lights.
#[derive(Clone, Copy, PartialEq)]
struct Lit {
    face: FaceId,
    side: FaceSide,
}

/// Follows the rulings of a triple to the receivers.
pub(super) fn trace(search: &Search, triple: Triple) -> Arcs {
    let scene = search.scene;
    let mut out = Arcs::default();
    let mut edges = triple.edges;
    let rim = edges.iter().position(|&e| search.is_rim(triple.emitter, e));
    if let Some(i) = rim {
        edges.swap(0, i);
    }
    let segments = edges.map(|e| scene.edges[e].ends.map(|v| scene.vertices[v]));
    let Some(regulus) = Regulus::new(segments, scene.weld_distance) else {
        return out;
    };
    for (from, to) in regulus.ranges() {
        for sense in [1.0, -1.0] {
            let middle = regulus.ruling(0.5 * (from + to));
            let along = middle.points.map(|p| middle.direction.dot(p) * sense);
            let mut order = [0, 1, 2];
            order.sort_unstable_by(|&i, &j| along[i].total_cmp(&along[j]));
            if rim.is_some() && order[0] != 0 {
                continue;
            }
            let mut swath = Swath {
                search,
                triple,
                regulus: regulus.clone(),
                edges,
                order,
                sense,
                is_rim_first: rim.is_some(),
                parts: Vec::new(),
            };
            if swath.collect_parts((from, to)) {
                swath.follow((from, to), &mut out);
            }
        }
    }
    out.next.sort_unstable();
    out.next.dedup();
    out
}

impl Swath<'_> {
    /// Finds the parts that may hide the emitter from what lies beyond the last edge; false when no ruling comes from it, or too
    /// many are in the way.
    fn collect_parts(&mut self, span: Span) -> bool {
        let (scene, blockers) = (self.search.scene, self.search.light.blockers);
        let tol = blockers.weld_distance();
        let [near, far] = self.outer_edges(span);
        let passage = between(near, far, tol);
        if blockers.are_more_than(self.search.worth.most_in_the_way(), &passage) {
            return false;
        }
        let mut parts = Vec::new();
        if !self.is_rim_first {
            let emitter = scene.emitters[self.triple.emitter];
            let corners = scene.faces[emitter.face].loops.iter().flatten();
            let corners: SmallVec<[DVec3; 8]> = corners.map(|&v| scene.vertices[v]).collect();
            let mut towards = beyond(far, near, tol);
            if !towards.may_meet_polygon(&corners, 0.0) {
                return false;
            }
            towards.bounds = bounds(near.iter().chain(&corners), tol);
            self.collect(&towards, &mut parts);
        }
        self.collect(&passage, &mut parts);
        parts.sort_unstable();
        parts.dedup();
        self.parts = parts;
        true
    }

    /// The stretches of the first and of the last edge that rulings between two parameters meet.
    fn outer_edges(&self, (from, to): Span) -> [[DVec3; 2]; 2] {
        let [a, b] = [from, to].map(|t| self.regulus.ruling(t).points);
        [self.order[0], self.order[2]].map(|i| [a[i], b[i]])
    }

    /// Appends the parts that may meet a region and on which none of the three edges lies.
    fn collect(&self, region: &Region, parts: &mut Vec<u32>) {
        let blockers = self.search.light.blockers;
        let is_own = |e: &Option<EdgeId>| e.is_some_and(|e| self.edges.contains(&e));
        blockers.query(region, |i| {
            let part = blockers.part(i);
            if region.may_meet_polygon(blockers.corners(part), 0.0)
                && !blockers.edges(part).iter().any(is_own)
            {
                parts.push(i);
            }
        });
    }

    /// Follows the rulings between two parameters, event by event: first to the last edge, then those that got there.
    fn follow(&self, span: Span, out: &mut Arcs) {
        let mut others = self.meetings(&self.parts, span);
        let silhouettes = self.edges.iter().flat_map(|&e| {
            let faces = self.search.scene.edges[e].uses.iter().map(|u| u.face);
            faces.flat_map(|f| {
                let n = self.search.scene.faces[f].frame.n;
                self.regulus.parallels(n, span.0, span.1)
            })
        });
        let events = others.iter().map(|o| o.0).chain(silhouettes);
        let shone: Vec<(Span, ())> = constant(span, events, |t| self.is_shone(t).then_some(()));
        let mut lit_spans: Vec<Span> = Vec::new();
        for (span, ()) in shone {
            let [near, far] = self.outer_edges(span);
            let tol = self.search.light.blockers.weld_distance();
            let mut parts = Vec::new();
            self.collect(&beyond(near, far, tol), &mut parts);
            parts.sort_unstable();
            let met = self.meetings(&parts, span);
            let events = met.iter().map(|o| o.0);
            for (span, lit) in constant(span, events, |t| self.landing(t, &parts)) {
                lit_spans.extend(self.land(lit, span, &mut out.arcs).then_some(span));
            }
            others.extend(met);
        }
        // A fourth edge on a lit ruling shares it with each pair of the three.
        for (t, fourth) in others {
            if lit_spans.iter().any(|&(a, b)| a <= t && t <= b) {
                let [a, b, c] = self.edges;
                let next = [[a, b, fourth], [a, c, fourth], [b, c, fourth]];
                let emitter = self.triple.emitter;
                out.next.extend(
                    next.iter()
                        .filter_map(|&edges| Triple::new(self.search, emitter, edges)),
                );
            }
        }
    }

    /// At which parameters inside a span rulings meet edges of `parts`.
    fn meetings(&self, parts: &[u32], (from, to): Span) -> Meetings {
        let (scene, blockers) = (self.search.scene, self.search.light.blockers);
        let mut edges: Vec<EdgeId> = parts
            .iter()
            .flat_map(|&i| blockers.edges(blockers.part(i)).iter().flatten().copied())
            .filter(|e| !self.edges.contains(e))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let mut met = Meetings::new();
        for e in edges {
            let ends = scene.edges[e].ends.map(|v| scene.vertices[v]);
            let all = self.regulus.meetings(ends, from, to);
            let within = all.into_iter().filter(|&t| self.meets_within(t, ends));
            met.extend(within.map(|t| (t, e)));
        }
        met
    }

    /// True when the ruling at `t`, which meets the line through `ends`, does so between them, within the weld distance.
    fn meets_within(&self, t: f64, [a, b]: [DVec3; 2]) -> bool {
        let ruling = self.regulus.ruling(t);
        let (d, u, w) = (ruling.direction, b - a, ruling.points[0] - a);
        let normal = d.cross(u);
        let s = w.cross(d).dot(-normal) / normal.length_squared();
        let slack = self.search.scene.weld_distance / u.length();
        s >= -slack && s <= 1.0 + slack
    }

    /// The direction of light along the ruling at `t`, and where it meets the first and the last edge.
    fn sight_line(&self, t: f64) -> (DVec3, [DVec3; 2]) {
        let ruling = self.regulus.ruling(t);
        let ends = [self.order[0], self.order[2]].map(|i| ruling.points[i]);
        (ruling.direction * self.sense, ends)
    }

    /// True when the emitter shines along the ruling at `t` past three silhouettes.
    fn is_shone(&self, t: f64) -> bool {
        let (scene, blockers) = (self.search.scene, self.search.light.blockers);
        let (d, [start, end]) = self.sight_line(t);
        let emitter = scene.emitters[self.triple.emitter];
        let shines = scene.normal(emitter.face, emitter.side).dot(d) > 0.0;
        if !shines || !self.grazes(d) {
            return false;
        }
        let last = (end - start).dot(d);
        let mut source: Option<Hit> = None;
        let mut hits: SmallVec<[Hit; 8]> = SmallVec::new();
        for &i in &self.parts {
            let part = blockers.part(i);
            let Some(at) = hit(part.plane, blockers.corners(part), start, d) else {
                continue;
            };
            if at > 0.0 && at < last {
                return false;
            }
            if at <= 0.0 && !self.is_rim_first {
                if part.face == emitter.face {
                    source = Some((at, part.face));
                }
                hits.push((at, part.face));
            }
        }
        self.is_rim_first || source.is_some_and(|source| self.is_first(source, &hits))
    }

    /// What the ruling at `t` meets first of `parts` beyond the last edge, if that receives light.
    fn landing(&self, t: f64, parts: &[u32]) -> Option<Lit> {
        let (scene, blockers) = (self.search.scene, self.search.light.blockers);
        let (d, [_, start]) = self.sight_line(t);
        let hits = parts.iter().filter_map(|&i| {
            let part = blockers.part(i);
            let at = hit(part.plane, blockers.corners(part), start, d)?;
            (at >= 0.0).then_some((at, part.face))
        });
        let (_, face) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let side = if scene.faces[face].frame.n.dot(d) < 0.0 {
            FaceSide::Front
        } else {
            FaceSide::Back
        };
        scene.receives(face, side).then_some(Lit { face, side })
    }

    /// True when the hit on the emitter is the nearest behind, but for faces in its own plane.
    fn is_first(&self, (at, emitter): Hit, hits: &[Hit]) -> bool {
        let scene = self.search.scene;
        let plane = scene.faces[emitter].frame.plane();
        hits.iter().all(|&(other, face)| {
            other <= at
                || scene.faces[face]
                    .loops
                    .iter()
                    .flatten()
                    .all(|&v| plane.distance(scene.vertices[v]).abs() <= scene.weld_distance)
        })
    }

    /// True when a sight line in direction `d` leaves light on one side of each blocker's edge, and the emitter's own
    /// neighbours do not stand before it.
    fn grazes(&self, d: DVec3) -> bool {
        let scene = self.search.scene;
        self.edges.iter().enumerate().all(|(i, &e)| {
            let edge = &scene.edges[e];
            let [a, b] = edge.ends.map(|v| scene.vertices[v]);
            if i == 0 && self.is_rim_first {
                return self.is_rim_open(e, b - a, d);
            }
            let Some(normal) = (b - a).cross(d).try_normalize() else {
                return false;
            };
            let plane = Plane::new(a, normal);
            let (mut above, mut below) = (false, false);
            for u in &edge.uses {
                let tol = scene.weld_distance;
                match side_of_face(scene, &plane, e, u.face, u.is_forward, tol) {
                    1 => above = true,
                    -1 => below = true,
                    _ => {}
                }
            }
            above != below
        })
    }

    /// False when another face along the emitter's edge stands between the emitter and where the sight line goes.
    fn is_rim_open(&self, edge: EdgeId, along: DVec3, d: DVec3) -> bool {
        let scene = self.search.scene;
        let own = scene.emitters[self.triple.emitter].face;
        let inwards = |face: FaceId, is_forward: bool| {
            let along = if is_forward { along } else { -along };
            scene.faces[face].frame.n.cross(along)
        };
        let uses = &scene.edges[edge].uses;
        let Some(m) = uses
            .iter()
            .find(|u| u.face == own)
            .map(|u| inwards(u.face, u.is_forward))
        else {
            return false;
        };
        let turn = |a: DVec3, b: DVec3| a.cross(b).dot(along);
        let sense = turn(m, d);
        uses.iter().filter(|u| u.face != own).all(|u| {
            let g = inwards(u.face, u.is_forward);
            !(turn(m, g) * sense > 0.0 && turn(g, d) * sense > 0.0)
        })
    }

    /// Adds the arc that the rulings between two parameters draw; false when it is too short or too weak.
    fn land(&self, lit: Lit, (from, to): Span, arcs: &mut Vec<Arc>) -> bool {
        let (scene, search) = (self.search.scene, self.search);
        let arc = self
            .regulus
            .arc_on(&scene.faces[lit.face].frame.plane(), from, to);
        let middle = 0.5 * (from + to);
        let ruling = self.regulus.ruling(middle);
        let features = [0, 1, 2].map(|i| {
            let [a, b] = scene.edges[self.edges[i]].ends.map(|v| scene.vertices[v]);
            Feature {
                at: ruling.points[i],
                reach: b - a,
            }
        });
        let end = End {
            face: lit.face,
            side: lit.side,
            point: arc.at(middle),
        };
        let emitter = self.triple.emitter;
        let jump = predicted_jump(scene, search.light, emitter, end, &features, search.floor);
        let is_long = arc.at(from).distance(arc.at(to)) > scene.weld_distance;
        let Some(jump) = jump.filter(|j| is_long && *j >= search.least) else {
            return false;
        };
        arcs.push(Arc {
            conic: arc,
            line: Discontinuity {
                face: lit.face,
                side: lit.side,
                ends: [DVec3::ZERO; 2],
                order: DiscontinuityOrder::D2,
                kind: EventKind::Eee,
                emitter: Some(emitter),
                cause: Cause::Edges(self.triple.edges),
                jump,
            },
        });
        true
    }
}

/// The stretches of `span` over which `found` is the same and not none, where that may change at `events` only.
fn constant<T: Copy + PartialEq>(
    span: Span,
    events: impl Iterator<Item = f64>,
    found: impl Fn(f64) -> Option<T>,
) -> Vec<(Span, T)> {
    let mut cuts: Vec<f64> = events.chain([span.0, span.1]).collect();
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.dedup();
    let mut out: Vec<(Span, T)> = Vec::new();
    for pair in cuts.windows(2) {
        let Some(now) = found(0.5 * (pair[0] + pair[1])) else {
            continue;
        };
        match out.last_mut() {
            Some(((_, end), before)) if *end == pair[0] && *before == now => *end = pair[1],
            _ => out.push(((pair[0], pair[1]), now)),
        }
    }
    out
}

/// Where a ray from `start` in direction `d` (unit) meets a convex polygon, metres along it, in front or behind.
fn hit(plane: Plane, corners: &[DVec3], start: DVec3, d: DVec3) -> Option<f64> {
    let at = -plane.distance(start) / plane.normal.dot(d);
    let p = start + d * at;
    let is_inside = (0..corners.len()).all(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        (b - a).cross(p - a).dot(plane.normal) >= 0.0
    });
    (at.is_finite() && is_inside).then_some(at)
}

/// The tetrahedron of two segments: every line that meets both lies in it between them.
fn between(near: [DVec3; 2], far: [DVec3; 2], slack: f64) -> Region {
    let points = [near[0], near[1], far[0], far[1]];
    let mut region = tetrahedron(points, [1.0; 4], slack);
    region.bounds = bounds(points.iter(), slack);
    region
}

/// The box around `points` and `slack` beyond.
fn bounds<'a>(points: impl Iterator<Item = &'a DVec3>, slack: f64) -> (DVec3, DVec3) {
    let whole = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(whole, |(low, high), &p| (low.min(p), high.max(p)));
    (low - slack, high + slack)
}

/// What lines from `near` through `far` can reach beyond: there the tetrahedron's coordinates of `near` are negative.
fn beyond(near: [DVec3; 2], far: [DVec3; 2], slack: f64) -> Region {
    tetrahedron(
        [near[0], near[1], far[0], far[1]],
        [-1.0, -1.0, 1.0, 1.0],
        slack,
    )
}

/// The points whose barycentric coordinates have the given signs.
fn tetrahedron(p: [DVec3; 4], signs: [f64; 4], slack: f64) -> Region {
    let mut planes = SmallVec::new();
    for i in 0..4 {
        let [a, b, c] = [1, 2, 3].map(|k| p[(i + k) % 4]);
        let Some(n) = (b - a).cross(c - a).try_normalize() else {
            continue;
        };
        let n = n * (n.dot(p[i] - a) * signs[i]).signum();
        planes.push(Plane::new(a - n * slack, n));
    }
    Region {
        planes,
        bounds: (DVec3::NEG_INFINITY, DVec3::INFINITY),
    }
}
