//! Enumerates the critical events, culls them, and has the rest traced.

use super::corner::Corners;
use super::from_emitter::{past_edges, past_vertices};
use super::reach::{Balls, Reach};
use super::span::LitSpans;
use super::trace::Touch;
use super::wedge::side_of_face;
use super::worth::{Worth, length};
use super::{Cause, Discontinuity, LineTolerance};
use crate::direct::DirectLight;
use crate::geom::Plane;
use crate::scene::{EdgeId, EdgeUse, EmitterId, FaceId, IdVec, Scene, VertexId};
use crate::visibility::Region;
use glam::DVec3;

/// What exceeds a threshold so many times does so whatever rounding did.
const CLEAR: f64 = 2.0;

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

/// What the wedges of one job found.
#[derive(Default)]
pub(super) struct Found {
    pub(super) lines: Vec<Discontinuity>,
    /// Generators of critical surfaces that start at the ends of these lines.
    pub(super) touches: Vec<Touched>,
    pub(super) wedges: usize,
    pub(super) culled: usize,
}

/// A ray of a wedge, with light along it, that touches another feature.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touched {
    pub(super) emitter: EmitterId,
    pub(super) cause: Cause,
    pub(super) touch: Touch,
}

impl Found {
    /// Adds what the rays of the wedge of `cause` touch.
    pub(super) fn touch(&mut self, emitter: EmitterId, cause: Cause, touches: Vec<Touch>) {
        let touched = touches.into_iter().map(|touch| Touched {
            emitter,
            cause,
            touch,
        });
        self.touches.extend(touched);
    }
}

/// What all jobs share.
pub(super) struct Search<'a> {
    pub(super) scene: &'a Scene,
    pub(super) light: &'a DirectLight<'a>,
    /// Lines of the second kind below this share of what the whole emitter gives are left out.
    pub(super) floor: f64,
    /// The edges that meet at each vertex.
    pub(super) incident: IdVec<VertexId, Vec<EdgeId>>,
    /// Lines that break by less than this are left out, W/m².
    pub(super) least: f64,
    reach: Reach,
    /// As far as views through vertices are looked at.
    views: Balls,
    /// As far as they matter.
    mattering: Balls,
    /// What is looked at where there is too much.
    pub(super) worth: Worth,
    corners: Corners,
    /// The edges of each emitter's outline, sorted.
    rims: IdVec<EmitterId, Vec<EdgeId>>,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        light: &'a DirectLight<'a>,
        tolerance: LineTolerance,
    ) -> Self {
        let mut incident = IdVec::from(vec![Vec::new(); scene.vertices.len()]);
        for (id, edge) in scene.edges.iter() {
            for v in edge.ends {
                incident[v].push(id);
            }
        }
        let rims = scene
            .emitters
            .iter()
            .map(|(_, e)| {
                let edges = scene.faces[e.face].loop_edges.iter().flatten();
                let mut edges: Vec<EdgeId> = edges.copied().collect();
                edges.sort_unstable();
                edges
            })
            .collect::<Vec<_>>();
        let reach = Reach::new(scene, tolerance.least);
        let longest_at = |v: VertexId| {
            let lengths = incident[v].iter().map(|&e| length(scene, e));
            lengths.fold(0.0, f64::max)
        };
        let worth = Worth::new(scene, &reach, longest_at);
        let radius_of_views = |e| reach.radius(e).min(worth.radius(e, worth.view));
        Self {
            scene,
            light,
            floor: tolerance.floor,
            least: tolerance.least,
            views: Balls::new(scene, &reach, radius_of_views),
            mattering: Balls::new(scene, &reach, |e| reach.radius(e)),
            worth,
            reach,
            incident,
            corners: Corners::new(scene, light.blockers),
            rims: IdVec::from(rims),
        }
    }

    /// True when the edge belongs to the emitter's outline.
    pub(super) fn is_rim(&self, emitter: EmitterId, edge: EdgeId) -> bool {
        self.rims[emitter].binary_search(&edge).is_ok()
    }

    /// The edge of the emitter's outline with these ends.
    pub(super) fn rim_edge(&self, emitter: EmitterId, [a, b]: [VertexId; 2]) -> Option<EdgeId> {
        let ends = [a.min(b), a.max(b)];
        let mut rim = self.rims[emitter].iter().copied();
        rim.find(|&e| self.scene.edges[e].ends == ends)
    }

    /// Traces every wedge of one job.
    pub(super) fn run(&self, job: &Job) -> Found {
        match *job {
            Job::Vertex {
                emitter,
                vertex,
                neighbours,
            } => past_edges(self, emitter, vertex, neighbours),
            Job::Edge { emitter, ends } => past_vertices(self, emitter, ends),
        }
    }

    /// False when the emitter gives too little there, or beyond, for any line: farther from it than it matters.
    pub(super) fn is_within_reach(&self, emitter: EmitterId, points: &[DVec3]) -> bool {
        self.reach.holds(emitter, points)
    }

    /// The box around all that the emitter gives enough light for lines that matter.
    pub(super) fn bounds(&self, emitter: EmitterId) -> (DVec3, DVec3) {
        self.box_around(emitter, self.reach.radius(emitter))
    }

    fn box_around(&self, emitter: EmitterId, radius: f64) -> (DVec3, DVec3) {
        let middle = self.reach.lamps[emitter].middle;
        let radius = DVec3::splat(radius + self.scene.weld_distance);
        (middle - radius, middle + radius)
    }

    /// The parts of blockers whose edges and vertices may make wedges with the emitter.
    fn parts_near(&self, emitter: EmitterId) -> Vec<u32> {
        let worth = self.worth.radius(emitter, self.worth.wedge);
        let region = Region {
            planes: [].into_iter().collect(),
            bounds: self.box_around(emitter, self.reach.radius(emitter).min(worth)),
        };
        let mut parts = Vec::new();
        self.light.blockers.query(&region, |i| parts.push(i));
        parts
    }

    /// The edges that may make wedges with the emitter, ascending.
    pub(super) fn edges_near(&self, emitter: EmitterId) -> Vec<EdgeId> {
        let blockers = self.light.blockers;
        let parts = self.parts_near(emitter).into_iter();
        let edges = parts.flat_map(|i| blockers.edges(blockers.part(i)).iter().flatten().copied());
        let mut edges: Vec<EdgeId> = edges.collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The vertices that may make wedges with the emitter, ascending.
    pub(super) fn vertices_near(&self, emitter: EmitterId) -> Vec<VertexId> {
        let blockers = self.light.blockers;
        let parts = self.parts_near(emitter).into_iter();
        let vertices = parts.flat_map(|i| blockers.vertices(blockers.part(i)).iter().copied());
        let mut vertices: Vec<VertexId> = vertices.collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// The emitters that may be looked at through a vertex, ascending.
    pub(super) fn viewed_through(&self, position: DVec3) -> Vec<EmitterId> {
        self.views.around(&[position])
    }

    /// The emitters that may matter somewhere in the box around these points, ascending.
    pub(super) fn that_reach(&self, points: &[DVec3]) -> Vec<EmitterId> {
        self.mattering.around(points)
    }

    /// False when an edge ranks too low for the emitter, among so many.
    pub(super) fn is_worth(&self, emitter: EmitterId, edge: EdgeId, least: f64) -> bool {
        let ends = self.scene.edges[edge].ends.map(|v| self.scene.vertices[v]);
        let length = ends[0].distance(ends[1]);
        least == 0.0 || self.worth.rank(emitter, &ends, length) > least
    }

    /// False when the longest edge at a vertex ranks too low there for the emitter.
    pub(super) fn is_vertex_worth(&self, emitter: EmitterId, vertex: VertexId, least: f64) -> bool {
        let length = || self.longest_edge_at(vertex).length();
        let position = self.scene.vertices[vertex];
        least == 0.0 || self.worth.rank(emitter, &[position], length()) > least
    }

    /// False when the plane of a face with these corners ranks too low for the emitter.
    pub(super) fn is_plane_worth(
        &self,
        emitter: EmitterId,
        face: FaceId,
        corners: &[DVec3],
    ) -> bool {
        let width = self.scene.faces[face].area.sqrt();
        let least = self.worth.plane;
        least == 0.0 || self.worth.rank(emitter, corners, width) > least
    }

    /// False when no ray can graze the vertex: nothing ends there, or a face covers it.
    pub(super) fn can_be_grazed(&self, vertex: VertexId) -> bool {
        !self.corners.is_unused(vertex) && !self.corners.is_covered(vertex)
    }

    /// False when no ray through the vertex and the convex polygon `target` grazes the faces at the vertex.
    pub(super) fn may_be_grazed_towards(&self, vertex: VertexId, target: &[DVec3]) -> bool {
        let position = self.scene.vertices[vertex];
        self.corners.may_be_grazed_towards(vertex, position, target)
    }

    /// True when a ray through `eye` that meets the edge clearly passes between its two faces, or comes from between them:
    /// `eye` lies before both of them or behind both. What is not clear is left to [`is_silhouette`].
    pub(super) fn is_certainly_no_silhouette(&self, edge: EdgeId, eye: DVec3) -> bool {
        let scene = self.scene;
        let e = &scene.edges[edge];
        let [f, g] = e.uses.as_slice() else {
            return false;
        };
        let [a, b] = e.ends.map(|v| scene.vertices[v]);
        // A face leaves the plane of eye and edge by this much over the edge's length.
        let clear = CLEAR * scene.weld_distance * eye.distance(a) / a.distance(b);
        let height = |u: &EdgeUse| {
            let h = scene.faces[u.face].frame.plane().distance(eye);
            if u.is_forward { h } else { -h }
        };
        let (f, g) = (height(f), height(g));
        // Neighbours in a surface run along the edge in opposite senses.
        (f > clear && g < -clear) || (f < -clear && g > clear)
    }

    /// False when a ray along `direction` that meets the edge has faces to both sides there.
    pub(super) fn may_graze(&self, edge: EdgeId, direction: DVec3) -> bool {
        let [a, b] = self.scene.edges[edge].ends.map(|v| self.scene.vertices[v]);
        let Some(normal) = (b - a).cross(direction).try_normalize() else {
            return true;
        };
        let plane = Plane::new(a, normal);
        let sides = |side: i8| {
            self.scene.edges[edge].uses.iter().any(|u| {
                let tol = self.scene.weld_distance;
                side_of_face(self.scene, &plane, edge, u.face, u.is_forward, tol) == side
            })
        };
        !(sides(1) && sides(-1))
    }

    /// The stretches of a rim from which a ray grazes the faces at a vertex.
    pub(super) fn grazing(&self, vertex: VertexId, rim: [DVec3; 2]) -> LitSpans {
        grazing(&self.corners, vertex, self.scene.vertices[vertex], rim)
    }

    /// True when a face has both the vertex and the edge on its outline.
    pub(super) fn share_a_face(&self, vertex: VertexId, edge: EdgeId) -> bool {
        let faces = |e: EdgeId| self.scene.edges[e].uses.iter().map(|u| u.face);
        self.incident[vertex]
            .iter()
            .any(|&e| faces(e).any(|f| faces(edge).any(|g| f == g)))
    }

    /// True when a silhouette edge at the vertex lies in a plane through it.
    pub(super) fn runs_in_plane(&self, vertex: VertexId, plane: &Plane) -> bool {
        let scene = self.scene;
        self.incident[vertex].iter().any(|&e| {
            let mut ends = scene.edges[e].ends.iter();
            ends.all(|&v| plane.distance(scene.vertices[v]).abs() <= scene.weld_distance)
                && is_silhouette(scene, plane, e)
        })
    }

    /// The longest edge at a vertex, metres.
    pub(super) fn longest_edge_at(&self, vertex: VertexId) -> DVec3 {
        let along = |&e: &EdgeId| {
            let [a, b] = self.scene.edges[e].ends.map(|v| self.scene.vertices[v]);
            b - a
        };
        let edges = self.incident[vertex].iter().map(along);
        edges
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
            .unwrap_or(DVec3::ZERO)
    }
}

/// True when the faces along `edge` that do not lie in `plane` are all on one side of it, and there is one: light
/// grazes the edge on the other side. A concave edge of a solid never qualifies, a border always does.
pub(super) fn is_silhouette(scene: &Scene, plane: &Plane, edge: EdgeId) -> bool {
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
