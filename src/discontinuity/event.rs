//! Enumerates the critical events, culls them, and has the rest traced.

use super::corner::Corners;
use super::span::LitSpans;
use super::trace::{self, Landing};
use super::wedge::{Apex, Wedge, side_of_face};
use super::{Cause, Discontinuity, DiscontinuityOrder, EventKind, SearchReport};
use crate::direct::DirectLight;
use crate::geom::Plane;
use crate::scene::{EdgeId, EmitterId, IdVec, Scene, VertexId};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;

/// One emitter vertex against all edges, or one emitter edge against all vertices.
#[derive(Clone, Copy, Debug)]
pub(super) enum Job {
    Vertex {
        emitter: EmitterId,
        vertex: VertexId,
        /// The neighbours along the emitter's outline.
        neighbours: [VertexId; 2],
    },
    Edge {
        emitter: EmitterId,
        ends: [VertexId; 2],
    },
}

/// The vertices and edges of all emitters' outlines.
pub(super) fn jobs(scene: &Scene) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (id, emitter) in scene.emitters.iter() {
        for points in &scene.faces[emitter.face].loops {
            let n = points.len();
            for i in 0..n {
                let (before, here, after) =
                    (points[(i + n - 1) % n], points[i], points[(i + 1) % n]);
                jobs.push(Job::Edge {
                    emitter: id,
                    ends: [here, after],
                });
                // A vertex in the middle of a straight edge is no corner of the outline.
                if !is_straight(scene, before, here, after) {
                    jobs.push(Job::Vertex {
                        emitter: id,
                        vertex: here,
                        neighbours: [before, after],
                    });
                }
            }
        }
    }
    jobs
}

fn is_straight(scene: &Scene, a: VertexId, b: VertexId, c: VertexId) -> bool {
    let [a, b, c] = [a, b, c].map(|v| scene.vertices[v]);
    let chord = c - a;
    (b - a).cross(chord).length() <= scene.weld_distance * chord.length()
}

/// What all jobs share.
pub(super) struct Search<'a> {
    scene: &'a Scene,
    light: &'a DirectLight<'a>,
    /// The edges that meet at each vertex.
    incident: IdVec<VertexId, Vec<EdgeId>>,
    corners: Corners,
}

impl<'a> Search<'a> {
    pub(super) fn new(scene: &'a Scene, light: &'a DirectLight<'a>) -> Self {
        let mut incident = IdVec::from(vec![Vec::new(); scene.vertices.len()]);
        for (id, edge) in scene.edges.iter() {
            for v in edge.ends {
                incident[v].push(id);
            }
        }
        Self {
            scene,
            light,
            incident,
            corners: Corners::new(scene, light.blockers),
        }
    }

    /// Traces every wedge of one job.
    pub(super) fn run(&self, job: &Job) -> (Vec<Discontinuity>, SearchReport) {
        match *job {
            Job::Vertex {
                emitter,
                vertex,
                neighbours,
            } => past_edges(self, emitter, vertex, neighbours),
            Job::Edge { emitter, ends } => past_vertices(self, emitter, ends),
        }
    }
}

/// The plane of an emitter, normal towards where it shines.
fn emitter_plane(scene: &Scene, emitter: EmitterId) -> Plane {
    let e = scene.emitters[emitter];
    Plane::new(
        scene.faces[e.face].frame.origin,
        scene.normal(e.face, e.side),
    )
}

/// VE wedges of one emitter vertex.
fn past_edges(
    search: &Search,
    emitter: EmitterId,
    vertex: VertexId,
    neighbours: [VertexId; 2],
) -> (Vec<Discontinuity>, SearchReport) {
    let (scene, light) = (search.scene, search.light);
    let plane = emitter_plane(scene, emitter);
    let (mut out, mut report) = (Vec::new(), SearchReport::default());
    let apex = Apex::Vertex(vertex, scene.vertices[vertex]);
    let tol = scene.weld_distance;
    for (id, edge) in scene.edges.iter() {
        let Some(rim) = in_front(scene, &plane, edge.ends) else {
            report.culled += 1;
            continue;
        };
        if edge.ends.contains(&vertex) {
            continue;
        }
        let wedge = Wedge::new(apex, rim, Some(edge.ends), tol)
            .filter(|w| is_silhouette(scene, &w.plane, id));
        let Some(wedge) = wedge else {
            report.culled += 1;
            continue;
        };
        report.wedges += 1;
        let landings = trace::past_edge(&wedge, scene, light.blockers);
        if landings.is_empty() {
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
            landings,
            &mut out,
        );
    }
    (out, report)
}

/// EV wedges of one emitter edge.
fn past_vertices(
    search: &Search,
    emitter: EmitterId,
    ends: [VertexId; 2],
) -> (Vec<Discontinuity>, SearchReport) {
    let (scene, light) = (search.scene, search.light);
    let plane = emitter_plane(scene, emitter);
    let (mut out, mut report) = (Vec::new(), SearchReport::default());
    let rim = ends.map(|v| scene.vertices[v]);
    let tol = scene.weld_distance;
    for (vertex, &position) in scene.vertices.iter() {
        let edges = &search.incident[vertex];
        if plane.distance(position) <= tol
            || ends.contains(&vertex)
            || search.corners.is_unused(vertex)
            || search.corners.is_covered(vertex)
        {
            report.culled += 1;
            continue;
        }
        let Some(wedge) = Wedge::new(Apex::Vertex(vertex, position), rim, Some(ends), tol) else {
            report.culled += 1;
            continue;
        };
        let lit = grazing(&search.corners, vertex, position, rim);
        if lit.is_empty() {
            report.culled += 1;
            continue;
        }
        report.wedges += 1;
        let landings = trace::past_vertex(&wedge, lit, scene, light.blockers);
        if landings.is_empty() {
            continue;
        }
        let is_coplanar = edges.iter().any(|&e| {
            scene.edges[e]
                .ends
                .iter()
                .all(|&v| wedge.plane.distance(scene.vertices[v]).abs() <= tol)
                && is_silhouette(scene, &wedge.plane, e)
        });
        let order = if is_coplanar {
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
            landings,
            &mut out,
        );
    }
    (out, report)
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

/// True when the faces along `edge` that do not lie in `plane` are all on one side of it, and there is one: light
/// grazes the edge on the other side. A concave edge of a solid never qualifies, a border always does.
fn is_silhouette(scene: &Scene, plane: &Plane, edge: EdgeId) -> bool {
    let (mut above, mut below) = (false, false);
    for u in &scene.edges[edge].uses {
        match side_of_face(
            scene,
            plane,
            edge,
            u.face,
            u.is_forward,
            scene.weld_distance,
        ) {
            1 => above = true,
            -1 => below = true,
            _ => {}
        }
    }
    above != below
}

/// The stretches of an emitter's edge (`rim`) from which a ray grazes the faces at a vertex.
fn grazing(corners: &Corners, vertex: VertexId, position: DVec3, rim: [DVec3; 2]) -> LitSpans {
    let mut lit = LitSpans::whole();
    for pair in corners.changes(vertex, position, rim).windows(2) {
        let eye = rim[0].lerp(rim[1], 0.5 * (pair[0] + pair[1]));
        if !corners.is_grazed(vertex, position - eye) {
            lit.remove(pair[0], pair[1]);
        }
    }
    lit
}

/// Turns landings into lines with their predicted jump.
fn push(
    search: &Search,
    emitter: EmitterId,
    order: DiscontinuityOrder,
    kind: EventKind,
    cause: Cause,
    landings: Vec<Landing>,
    out: &mut Vec<Discontinuity>,
) {
    let mut scratch = Scratch::default();
    for l in landings {
        let jump = predicted_jump(search, emitter, &l, &mut scratch)
            * match order {
                DiscontinuityOrder::D2 => 0.5,
                _ => 1.0,
            };
        if jump > 0.0 {
            out.push(Discontinuity {
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
