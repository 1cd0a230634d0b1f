//! NVE: a blocker's vertex and another blocker's edge on one sight line with the emitter behind.
//!
//! ```text
//!     ───────────── emitter          ───────────── emitter
//!          ╲                              ╲
//!        ───e     the edge first           ▼v       the vertex first
//!             ╲                              ╲
//!              ▼v                          ───e
//!   ─────────────x── receiver      ────────────x── receiver
//! ```
//!
//! Nothing is compared that does not meet: a vertex that sees the emitter looks along the cone of sight lines through it,
//! once towards the visible part of the emitter and once away from it, and the tree of blockers tells which edges cross.

use super::event::{Found, Search, is_silhouette};
use super::strength::{End, Feature, predicted_jump};
use super::trace::{self, Hiders};
use super::wedge::{Apex, Wedge};
use super::{Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::direct::EmitterPolygon;
use crate::geom::Plane;
use crate::scene::{EdgeId, EmitterId, VertexId};
use crate::visibility::{Region, Scratch, Target, Viewpoint};
use glam::DVec3;

/// A convex cone of sight lines through a vertex, towards the emitter: inward normals of its sides, with the round-off of
/// their product with a direction of unit length.
type Sight = Vec<(DVec3, f64)>;

/// Sides of the cone that the tree of blockers is asked with: of more corners some are left out, which widens the cone.
const FEW_SIDES: usize = 8;

/// All NVE wedges with their apex at `vertex`.
pub(super) fn through_vertex(search: &Search, vertex: VertexId, scratch: &mut Scratch) -> Found {
    let mut found = Found::default();
    if !search.can_be_grazed(vertex) {
        return found;
    }
    let (scene, light) = (search.scene, search.light);
    let eye = scene.vertices[vertex];
    let emitters = search.viewed_through(eye).into_iter();
    for polygon in emitters.flat_map(|e| light.polygons_of(e)) {
        if polygon.plane.distance(eye) <= scene.weld_distance
            || !search.is_within_reach(polygon.emitter, &[eye])
            || !search.is_vertex_worth(polygon.emitter, vertex, search.worth.view)
            || !search.may_be_grazed_towards(vertex, &polygon.corners)
        {
            continue;
        }
        let view = Viewpoint::new(eye, -polygon.plane.normal);
        let target = Target {
            corners: &polygon.corners,
            plane: polygon.plane,
        };
        if search.worth.is_partial() && is_cluttered(search, eye, &polygon.corners) {
            continue;
        }
        let mut sights: Vec<Sight> = Vec::new();
        scratch.visible_pieces(light.blockers, &view, target, |piece| {
            sights.push(sight(piece));
        });
        if sights.is_empty() {
            continue;
        }
        for is_ahead in [true, false] {
            let mut hiders = Hiders::default();
            let edges = edges_in_sight(search, vertex, polygon, &sights, is_ahead);
            let is_worth = |e: &EdgeId| search.is_worth(polygon.emitter, *e, search.worth.view);
            for edge in edges.into_iter().filter(is_worth) {
                past_edge(
                    search,
                    vertex,
                    edge,
                    (polygon.emitter, is_ahead),
                    &mut hiders,
                    &mut found,
                );
            }
        }
    }
    found
}

/// Whether too much stands between `eye` and an emitter.
fn is_cluttered(search: &Search, eye: DVec3, corners: &[DVec3]) -> bool {
    let region = Region::pyramid(eye, corners);
    let most = search.worth.most_in_the_way();
    search.light.blockers.are_more_than(most, &region)
}

/// The edges that sight lines through the vertex may cross on their way from the emitter (`is_ahead`) or from there on.
fn edges_in_sight(
    search: &Search,
    vertex: VertexId,
    polygon: &EmitterPolygon,
    sights: &[Sight],
    is_ahead: bool,
) -> Vec<EdgeId> {
    let (scene, blockers) = (search.scene, search.light.blockers);
    let eye = scene.vertices[vertex];
    let sign = if is_ahead { 1.0 } else { -1.0 };
    let mut region = Region::pyramid(eye, &polygon.corners);
    let step = region.planes.len().div_ceil(FEW_SIDES);
    let mut number = 0;
    region.planes.retain(|_| {
        number += 1;
        number % step == 0
    });
    if is_ahead {
        region.planes.push(polygon.plane);
    } else {
        for plane in &mut region.planes {
            *plane = Plane::new(eye, -plane.normal);
        }
        region.planes.push(Plane::new(eye, polygon.plane.normal));
        region.bounds = (DVec3::NEG_INFINITY, DVec3::INFINITY);
    }
    let mut edges = Vec::new();
    blockers.query(&region, |i| {
        let part = blockers.part(i);
        if region.may_meet_polygon(blockers.corners(part), -scene.weld_distance) {
            edges.extend(blockers.edges(part).iter().flatten());
        }
    });
    edges.sort_unstable();
    edges.dedup();
    edges.retain(|&e| {
        let ends = scene.edges[e].ends;
        !ends.contains(&vertex)
            && !search.is_certainly_no_silhouette(e, eye)
            && !search.share_a_face(vertex, e)
            && sights.iter().any(|sight| {
                let [a, b] = ends.map(|v| (scene.vertices[v] - eye) * sign);
                meets_cone(sight, a, b)
            })
    });
    edges
}

/// The cone through a convex polygon (directions, counter-clockwise seen from the apex).
fn sight(piece: &[DVec3]) -> Sight {
    (0..piece.len())
        .map(|i| {
            let (p, q) = (piece[i], piece[(i + 1) % piece.len()]);
            // Two roundings in each component of the cross product, three in the dot product.
            let slack = 8.0 * f64::EPSILON * p.length() * q.length();
            (q.cross(p), slack)
        })
        .collect()
}

/// True when the segment from `a` to `b` (directions) may meet a cone; along its sides is on the visible outline and counts.
fn meets_cone(sight: &Sight, a: DVec3, b: DVec3) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let longest = a.length().max(b.length());
    for (inwards, slack) in sight {
        let slack = slack * longest;
        let (ha, hb) = (inwards.dot(a) + slack, inwards.dot(b) + slack);
        if ha < 0.0 && hb < 0.0 {
            return false;
        } else if ha < 0.0 {
            from = from.max(ha / (ha - hb));
        } else if hb < 0.0 {
            to = to.min(ha / (ha - hb));
        }
    }
    from <= to
}

/// Traces the wedge through a vertex and an edge.
fn past_edge(
    search: &Search,
    vertex: VertexId,
    edge: EdgeId,
    (emitter, is_ahead): (EmitterId, bool),
    hiders: &mut Hiders,
    found: &mut Found,
) {
    let (scene, light) = (search.scene, search.light);
    let apex = scene.vertices[vertex];
    let ends = scene.edges[edge].ends;
    let rim = ends.map(|v| scene.vertices[v]);
    let wedge = Wedge::new(
        Apex::Vertex(vertex, apex),
        rim,
        Some(ends),
        scene.weld_distance,
    )
    .filter(|w| is_silhouette(scene, &w.plane, edge));
    let lit = wedge
        .as_ref()
        .map(|_| search.grazing(vertex, rim))
        .filter(|lit| !lit.is_empty());
    let (Some(wedge), Some(lit)) = (wedge, lit) else {
        found.culled += 1;
        return;
    };
    found.wedges += 1;
    let face = scene.emitters[emitter].face;
    let traced = trace::past_both(&wedge, lit, (face, is_ahead), scene, light.blockers, hiders);
    let order = if search.runs_in_plane(vertex, &wedge.plane) {
        DiscontinuityOrder::D1
    } else {
        DiscontinuityOrder::D2
    };
    let cause = Cause::VertexEdge(vertex, edge);
    let mut is_strong = false;
    for l in traced.landings {
        let point = 0.5 * (l.ends[0] + l.ends[1]);
        let features = [
            Feature {
                at: apex,
                reach: search.longest_edge_at(vertex),
            },
            Feature {
                at: wedge.rim_at(l.middle),
                reach: rim[1] - rim[0],
            },
        ];
        let end = End {
            face: l.face,
            side: l.side,
            point,
        };
        let jump = predicted_jump(scene, light, emitter, end, &features, search.floor);
        let Some(jump) = jump.filter(|j| *j >= search.least) else {
            continue;
        };
        is_strong = true;
        found.lines.push(Discontinuity {
            face: l.face,
            side: l.side,
            ends: l.ends,
            order,
            kind: EventKind::Nve,
            emitter: Some(emitter),
            cause,
            jump,
        });
    }
    if is_strong {
        found.touch(emitter, cause, traced.touches);
    }
}
