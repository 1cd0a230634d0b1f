//! VE and EV: the wedges that start at a corner or an edge of an emitter.

use super::event::{Found, Search, is_silhouette};
use super::landing::Landing;
use super::trace::{self, Hiders, Traced};
use super::wedge::{Apex, Wedge};
use super::{Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::geom::Plane;
use crate::scene::{EmitterId, Scene, VertexId};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;

/// The plane of an emitter, normal towards where it shines.
fn emitter_plane(scene: &Scene, emitter: EmitterId) -> Plane {
    let e = scene.emitters[emitter];
    Plane::new(
        scene.faces[e.face].frame.origin,
        scene.normal(e.face, e.side),
    )
}

/// VE wedges of one emitter vertex.
pub(super) fn past_edges(
    search: &Search,
    emitter: EmitterId,
    vertex: VertexId,
    neighbours: [VertexId; 2],
) -> Found {
    let (scene, light) = (search.scene, search.light);
    let plane = emitter_plane(scene, emitter);
    let mut found = Found::default();
    let mut hiders = Hiders::default();
    let apex_position = scene.vertices[vertex];
    let apex = Apex::Vertex(vertex, apex_position);
    let tol = scene.weld_distance;
    for id in search.edges_near(emitter) {
        let edge = &scene.edges[id];
        let ends = edge.ends.map(|v| scene.vertices[v]);
        let rim = in_front(scene, &plane, edge.ends).filter(|_| {
            search.is_within_reach(emitter, &ends)
                && search.is_worth(emitter, id, search.worth.wedge)
        });
        let Some(rim) = rim else {
            continue;
        };
        if edge.ends.contains(&vertex) || search.is_certainly_no_silhouette(id, apex_position) {
            continue;
        }
        let wedge = Wedge::new(apex, rim, Some(edge.ends), tol)
            .filter(|w| is_silhouette(scene, &w.plane, id));
        let Some(wedge) = wedge else {
            continue;
        };
        found.wedges += 1;
        let traced = trace::past_edge(&wedge, scene, light.blockers, &mut hiders);
        if traced.is_nothing() {
            continue;
        }
        let order = if neighbours
            .iter()
            .any(|&v| wedge.plane.distance(scene.vertices[v]).abs() <= tol)
        {
            DiscontinuityOrder::D1
        } else {
            DiscontinuityOrder::D2
        };
        let cause = Cause::VertexEdge(vertex, id);
        push(
            search,
            emitter,
            order,
            EventKind::Ve,
            cause,
            traced,
            &mut found,
        );
    }
    found.culled = scene.edges.len() - found.wedges;
    found
}

/// EV wedges of one emitter edge.
pub(super) fn past_vertices(search: &Search, emitter: EmitterId, ends: [VertexId; 2]) -> Found {
    let (scene, light) = (search.scene, search.light);
    let plane = emitter_plane(scene, emitter);
    let mut found = Found::default();
    let mut hiders = Hiders::default();
    let rim = ends.map(|v| scene.vertices[v]);
    let tol = scene.weld_distance;
    for vertex in search.vertices_near(emitter) {
        let position = scene.vertices[vertex];
        if plane.distance(position) <= tol
            || ends.contains(&vertex)
            || !search.can_be_grazed(vertex)
            || !search.is_within_reach(emitter, &[position])
            || !search.is_vertex_worth(emitter, vertex, search.worth.wedge)
        {
            continue;
        }
        let Some(wedge) = Wedge::new(Apex::Vertex(vertex, position), rim, Some(ends), tol) else {
            continue;
        };
        let lit = search.grazing(vertex, rim);
        if lit.is_empty() {
            continue;
        }
        found.wedges += 1;
        let traced = trace::past_vertex(&wedge, lit, scene, light.blockers, &mut hiders);
        if traced.is_nothing() {
            continue;
        }
        let order = if search.runs_in_plane(vertex, &wedge.plane) {
            DiscontinuityOrder::D1
        } else {
            DiscontinuityOrder::D2
        };
        let cause = Cause::EdgeVertex(ends, vertex);
        push(
            search,
            emitter,
            order,
            EventKind::Ev,
            cause,
            traced,
            &mut found,
        );
    }
    found.culled = scene.vertices.len() - found.wedges;
    found
}

/// The part of an edge in front of the emitter; none when there is none.
fn in_front(scene: &Scene, plane: &Plane, ends: [VertexId; 2]) -> Option<[DVec3; 2]> {
    let [a, b] = ends.map(|v| scene.vertices[v]);
    let (da, db) = (plane.distance(a), plane.distance(b));
    let tol = scene.weld_distance;
    if da <= tol && db <= tol {
        return None;
    }
    let cut = a + (b - a) * (da / (da - db));
    Some([
        if da < -tol { cut } else { a },
        if db < -tol { cut } else { b },
    ])
}

/// Turns landings into lines with their predicted jump.
fn push(
    search: &Search,
    emitter: EmitterId,
    order: DiscontinuityOrder,
    kind: EventKind,
    cause: Cause,
    traced: Traced,
    found: &mut Found,
) {
    found.touch(emitter, cause, traced.touches);
    let mut scratch = Scratch::default();
    for l in traced.landings {
        let jump = predicted_jump(search, emitter, &l, &mut scratch)
            * match order {
                DiscontinuityOrder::D2 => 0.5,
                _ => 1.0,
            };
        if jump > 0.0 && jump >= search.least {
            found.lines.push(Discontinuity {
                face: l.face,
                side: l.side,
                ends: l.ends,
                order,
                kind,
                emitter: Some(emitter),
                cause,
                jump,
            });
        }
    }
}

/// What the whole emitter gives, unoccluded, at the middle of the line.
fn predicted_jump(
    search: &Search,
    emitter: EmitterId,
    landing: &Landing,
    scratch: &mut Scratch,
) -> f64 {
    let middle = 0.5 * (landing.ends[0] + landing.ends[1]);
    let normal = search.scene.normal(landing.face, landing.side);
    search
        .light
        .unoccluded_from(emitter, &Viewpoint::new(middle, normal), scratch)
        .mean()
}
