//! A planar critical surface, and its sections with the faces that cross it.
//!
//! A wedge is the fan of rays through its apex and a rim edge. With `A`, `B` the rim's ends relative to the apex, a point
//! of the wedge's plane is `apex + α A + β B`; `s = β/(α+β)` says which ray it lies on and `w = 1/(α+β)` how near it is
//! (`w = 1` on the rim, larger nearer to the apex). Lines of the plane are lines in (s, w): `w` is linear in `s`, so
//! occlusion along the wedge is a one-dimensional upper envelope.
//!
//! ```text
//!   VE: apex on the emitter, rim = blocker edge.       EV: rim = emitter edge, apex = blocker vertex.
//!       w > 1 before the edge (hides it)                   front rays (α, β ≥ 0), w > 1: between vertex and emitter
//!       w < 1 behind it (may be lit)                       back rays (α, β ≤ 0): behind the vertex, largest |w| first
//! ```

use crate::geom::Plane;
use crate::scene::{EdgeId, FaceId, Scene, VertexId};
use crate::visibility::{Blockers, Part, Region};
use glam::DVec3;
use smallvec::SmallVec;

/// The box around everything.
const UNBOUNDED: (DVec3, DVec3) = (DVec3::NEG_INFINITY, DVec3::INFINITY);

/// Where the rays of a wedge start or meet.
#[derive(Clone, Copy, Debug)]
pub(super) enum Apex {
    /// A vertex of the scene and its position.
    Vertex(VertexId, DVec3),
    /// Any other point.
    Point(DVec3),
}

impl Apex {
    fn position(self) -> DVec3 {
        match self {
            Self::Vertex(_, p) | Self::Point(p) => p,
        }
    }

    fn is_corner_of(self, vertices: &[VertexId]) -> bool {
        match self {
            Self::Vertex(v, _) => vertices.contains(&v),
            Self::Point(_) => false,
        }
    }
}

/// The fan of rays from `apex` through the rim.
#[derive(Clone, Debug)]
pub(super) struct Wedge {
    pub(super) apex: DVec3,
    generator: Apex,
    pub(super) rim: [DVec3; 2],
    /// The scene's vertices at the rim's ends; none when the rim is no edge of the scene.
    pub(super) rim_vertices: Option<[VertexId; 2]>,
    pub(super) plane: Plane,
    /// Length of the cross product of the rim's ends relative to the apex: twice the triangle's area.
    normal_length: f64,
    /// Where all rays are parallel, the way from the source (`w = 2`) to the rim; the apex is no point then.
    parallel: Option<DVec3>,
    /// In units of w: what lies within the weld distance of the rim is on it.
    pub(super) rim_slack: f64,
}

/// What of the scene ends a section: where a ray of the wedge touches it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    /// An edge of the scene that crosses the wedge's plane.
    Edge(EdgeId),
    /// A vertex that lies in it.
    Vertex(VertexId),
    /// Nothing: the section goes on in another part of its face, or beyond the wedge.
    Inside,
}

/// A piece of a face in the wedge's plane: `w` runs linearly from `w0` at `s0` to `w1` at `s1`, `s0 < s1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    pub(super) s0: f64,
    pub(super) w0: f64,
    pub(super) s1: f64,
    pub(super) w1: f64,
    /// The face, where a line may be drawn on it; none where the wedge passes exactly through an edge between faces,
    /// which stops the light but lies on the border of both meshes already.
    pub(super) face: Option<FaceId>,
    /// What ends it at `s0` and at `s1`.
    pub(super) marks: [Mark; 2],
}

/// A segment in a wedge's plane: its ends, each with what it lies on.
pub(super) struct Cut {
    pub(super) ends: [(DVec3, Mark); 2],
    /// As in [`Section`].
    pub(super) face: Option<FaceId>,
}

impl Section {
    /// `w` at parameter `s`.
    pub(super) fn w(&self, s: f64) -> f64 {
        self.w0 + (self.w1 - self.w0) * ((s - self.s0) / (self.s1 - self.s0))
    }
}

/// Sections on the rays' front half (towards the rim) and on the back half (beyond the apex, `w` taken positive).
#[derive(Default)]
pub(super) struct Sections {
    pub(super) front: Vec<Section>,
    pub(super) back: Vec<Section>,
}

impl Wedge {
    /// None when apex and rim are collinear within the weld distance.
    pub(super) fn new(
        generator: Apex,
        rim: [DVec3; 2],
        rim_vertices: Option<[VertexId; 2]>,
        weld_distance: f64,
    ) -> Option<Self> {
        let apex = generator.position();
        let (a, b) = (rim[0] - apex, rim[1] - apex);
        let cross = a.cross(b);
        let longest = a.length().max(b.length()).max(a.distance(b));
        if cross.length() <= weld_distance * longest {
            return None;
        }
        let nearest = cross.length() / a.distance(b);
        Some(Self {
            apex,
            generator,
            rim,
            rim_vertices,
            plane: Plane::new(apex, cross.normalize()),
            normal_length: cross.length(),
            parallel: None,
            rim_slack: weld_distance / nearest,
        })
    }

    /// Rays in one direction past a rim. `way` is as long as anything in the scene, so that slacks mean the same as in fans:
    /// `w` falls by one along it. None when the rim runs along the rays within the weld distance.
    pub(super) fn parallel(
        way: DVec3,
        rim: [DVec3; 2],
        ends: [VertexId; 2],
        tol: f64,
    ) -> Option<Self> {
        let cross = way.cross(rim[1] - rim[0]);
        if cross.length() <= tol * way.length() {
            return None;
        }
        let apex = rim[0] - way;
        Some(Self {
            apex,
            generator: Apex::Point(apex),
            rim,
            rim_vertices: Some(ends),
            plane: Plane::new(rim[0], cross.normalize()),
            normal_length: cross.length(),
            parallel: Some(way),
            rim_slack: tol / way.length(),
        })
    }

    /// The ray that passes the rim at `s`: a point before it, and the point on it.
    pub(super) fn ray_past_rim(&self, s: f64) -> (DVec3, DVec3) {
        let through = self.rim_at(s);
        (
            self.parallel.map_or(self.apex, |way| through - way),
            through,
        )
    }

    /// True when a section lies within the weld distance of the point that all rays come from.
    pub(super) fn is_at_source(&self, section: &Section) -> bool {
        self.parallel.is_none() && section.w0.min(section.w1) * self.rim_slack >= 1.0
    }

    fn rim_point(&self, s: f64) -> DVec3 {
        self.rim[0] + (self.rim[1] - self.rim[0]) * s
    }

    /// The rim at parameter `s`; its ends exactly.
    pub(super) fn rim_at(&self, s: f64) -> DVec3 {
        if s >= 1.0 {
            self.rim[1]
        } else {
            self.rim_point(s)
        }
    }

    /// (α, β) of a point of the plane.
    fn coordinates(&self, p: DVec3) -> (f64, f64) {
        let (a, b, p) = (
            self.rim[0] - self.apex,
            self.rim[1] - self.apex,
            p - self.apex,
        );
        let n = self.plane.normal;
        (
            p.cross(b).dot(n) / self.normal_length,
            a.cross(p).dot(n) / self.normal_length,
        )
    }

    /// The half-spaces that hold the rays towards a stretch of the rim (`sign` 1) or beyond the apex (−1), and a box around them.
    fn region(&self, slack: f64, sign: f64, bounds: (DVec3, DVec3), stretch: (f64, f64)) -> Region {
        let mut planes = SmallVec::new();
        let n = self.plane.normal;
        planes.push(Plane::new(self.apex - n * slack, n));
        planes.push(Plane::new(self.apex + n * slack, -n));
        let along = |r: DVec3| self.parallel.unwrap_or(r - self.apex).normalize() * sign;
        let rim = [self.rim_at(stretch.0), self.rim_at(stretch.1)];
        let [a, b] = rim.map(along);
        let [p, q] = self.parallel.map_or([self.apex; 2], |_| rim);
        planes.push(Plane::new(p - n.cross(a) * slack, n.cross(a)));
        planes.push(Plane::new(q - b.cross(n) * slack, b.cross(n)));
        Region { planes, bounds }
    }

    /// Sections with the faces near the triangle of apex and rim: all that can lie before the rim.
    pub(super) fn sections_before_rim(&self, scene: &Scene, blockers: &Blockers) -> Vec<Section> {
        let region = self.region_before_rim(blockers.weld_distance());
        self.sections_in(scene, blockers, &region).front
    }

    /// What holds the triangle of apex and rim.
    pub(super) fn region_before_rim(&self, slack: f64) -> Region {
        let pad = DVec3::splat(slack);
        let [a, b] = self.rim;
        let bounds = match self.parallel {
            Some(_) => UNBOUNDED,
            None => (self.apex.min(a).min(b) - pad, self.apex.max(a).max(b) + pad),
        };
        self.region(slack, 1.0, bounds, (0.0, 1.0))
    }

    /// The section of one part with the rays towards the rim.
    pub(super) fn section_ahead(
        &self,
        scene: &Scene,
        blockers: &Blockers,
        part: &Part,
    ) -> Option<Section> {
        let mut out = Sections::default();
        self.clip(&self.section(scene, blockers, part)?, &mut out);
        out.front.pop()
    }

    /// Sections with the faces that rays past the rim between two parameters meet behind it.
    pub(super) fn sections_behind_rim(
        &self,
        scene: &Scene,
        blockers: &Blockers,
        stretch: (f64, f64),
    ) -> Vec<Section> {
        let slack = blockers.weld_distance();
        let mut region = self.region(slack, 1.0, UNBOUNDED, stretch);
        let [a, b] = self.rim;
        let away = self.plane.normal.cross(b - a).normalize();
        let way = self.parallel.unwrap_or(a - self.apex);
        let away = away * away.dot(way).signum();
        region.planes.push(Plane::new(a - away * slack, away));
        self.sections_in(scene, blockers, &region).front
    }

    /// Sections with all faces that the rays towards the rim and on from there meet.
    pub(super) fn sections_ahead(&self, scene: &Scene, blockers: &Blockers) -> Vec<Section> {
        let region = self.region(blockers.weld_distance(), 1.0, UNBOUNDED, (0.0, 1.0));
        self.sections_in(scene, blockers, &region).front
    }

    /// Sections with all faces that rays from the rim between two parameters meet beyond the apex.
    pub(super) fn sections_beyond(
        &self,
        scene: &Scene,
        blockers: &Blockers,
        stretch: (f64, f64),
    ) -> Vec<Section> {
        let region = self.region(blockers.weld_distance(), -1.0, UNBOUNDED, stretch);
        self.sections_in(scene, blockers, &region).back
    }

    fn sections_in(&self, scene: &Scene, blockers: &Blockers, region: &Region) -> Sections {
        let mut parts = Vec::new();
        blockers.query(region, |i| parts.push(i));
        parts.sort_unstable();
        let mut out = Sections::default();
        for i in parts {
            let part = blockers.part(i);
            if let Some(cut) = self.section(scene, blockers, part) {
                self.clip(&cut, &mut out);
            }
        }
        out
    }

    /// The segment in which a convex part crosses the plane.
    fn section(&self, scene: &Scene, blockers: &Blockers, part: &Part) -> Option<Cut> {
        let vertices = blockers.vertices(part);
        let is_on_rim = |v: &VertexId| self.rim_vertices.is_some_and(|r| r.contains(v));
        // A face through the apex meets the wedge in a single ray, a face along the rim only there.
        if self.generator.is_corner_of(vertices)
            || self
                .rim_vertices
                .is_some_and(|r| r.iter().all(|r| vertices.contains(r)))
        {
            return None;
        }
        cut_of_part(scene, blockers, part, &self.plane, |v| is_on_rim(v))
    }

    /// The part of a segment that parallel rays past the rim meet.
    fn parallel_section(
        &self,
        way: DVec3,
        ends: [(DVec3, Mark); 2],
        face: Option<FaceId>,
    ) -> Option<Section> {
        let n = self.plane.normal;
        let along = self.rim[1] - self.rim[0];
        let place = |p: DVec3| {
            let p = p - self.rim[0];
            let s = way.cross(p).dot(n) / self.normal_length;
            let t = p.cross(along).dot(n) / self.normal_length;
            (s, 1.0 - t)
        };
        let [p, q] = ends.map(|e| place(e.0));
        let (mut from, mut to) = ((p, ends[0].1), (q, ends[1].1));
        if from.0.0 > to.0.0 {
            std::mem::swap(&mut from, &mut to);
        }
        let ((s0, w0), (s1, w1)) = (from.0, to.0);
        let w = |s: f64| w0 + (w1 - w0) * ((s - s0) / (s1 - s0));
        let clipped = (s0.max(0.0), s1.min(1.0));
        // A section along a ray hides nothing.
        (clipped.1 - clipped.0 > f64::EPSILON).then(|| Section {
            s0: clipped.0,
            w0: if s0 < 0.0 { w(0.0) } else { w0 },
            s1: clipped.1,
            w1: if s1 > 1.0 { w(1.0) } else { w1 },
            face,
            marks: [
                if s0 < 0.0 { Mark::Inside } else { from.1 },
                if s1 > 1.0 { Mark::Inside } else { to.1 },
            ],
        })
    }

    /// Adds the parts of a segment in front of and behind the apex to `out`.
    fn clip(&self, cut: &Cut, out: &mut Sections) {
        let [(first, first_mark), (last, last_mark)] = cut.ends;
        if let Some(way) = self.parallel {
            let ends = [(first, first_mark), (last, last_mark)];
            out.front.extend(self.parallel_section(way, ends, cut.face));
            return;
        }
        let (p, q) = (self.coordinates(first), self.coordinates(last));
        for (sign, list) in [(1.0, &mut out.front), (-1.0, &mut out.back)] {
            let (p, q) = ((sign * p.0, sign * p.1), (sign * q.0, sign * q.1));
            // Cut to the quadrant α, β ≥ 0.
            let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
            for (a, b) in [(p.0, q.0), (p.1, q.1)] {
                if a < 0.0 && b < 0.0 {
                    t1 = -1.0;
                } else if a < 0.0 {
                    t0 = t0.max(a / (a - b));
                } else if b < 0.0 {
                    t1 = t1.min(a / (a - b));
                }
            }
            if t0 >= t1 {
                continue;
            }
            let at = |t: f64| {
                let (a, b) = (p.0 + (q.0 - p.0) * t, p.1 + (q.1 - p.1) * t);
                let sum = a + b;
                ((b / sum).clamp(0.0, 1.0), 1.0 / sum)
            };
            let ((mut s0, mut w0), (mut s1, mut w1)) = (at(t0), at(t1));
            let own = |is_whole: bool, mark| if is_whole { mark } else { Mark::Inside };
            let mut marks = [own(t0 <= 0.0, first_mark), own(t1 >= 1.0, last_mark)];
            if s0 > s1 {
                std::mem::swap(&mut s0, &mut s1);
                std::mem::swap(&mut w0, &mut w1);
                marks.swap(0, 1);
            }
            // A section along a ray hides nothing.
            if s1 - s0 > f64::EPSILON && w0.is_finite() && w1.is_finite() {
                list.push(Section {
                    s0,
                    w0,
                    s1,
                    w1,
                    face: cut.face,
                    marks,
                });
            }
        }
    }
}

/// The segment in which a convex part crosses `plane`; vertices that are known to lie in it do so to the last digit.
pub(super) fn cut_of_part(
    scene: &Scene,
    blockers: &Blockers,
    part: &Part,
    plane: &Plane,
    is_known: impl Fn(&VertexId) -> bool,
) -> Option<Cut> {
    let (corners, vertices) = (blockers.corners(part), blockers.vertices(part));
    let d: SmallVec<[f64; 8]> = corners
        .iter()
        .zip(vertices)
        .map(|(&c, v)| {
            let d = plane.distance(c);
            if is_known(v) || d.abs() <= blockers.weld_distance() {
                0.0
            } else {
                d
            }
        })
        .collect();
    let (above, below) = (d.iter().any(|&d| d > 0.0), d.iter().any(|&d| d < 0.0));
    let n = corners.len();
    if above && below {
        let mut ends = SmallVec::<[(DVec3, Mark); 2]>::new();
        for i in 0..n {
            let j = (i + 1) % n;
            if d[i] == 0.0 {
                ends.push((corners[i], Mark::Vertex(vertices[i])));
            } else if d[i] * d[j] < 0.0 {
                let p = corners[i] + (corners[j] - corners[i]) * (d[i] / (d[i] - d[j]));
                let edge = blockers.edges(part)[i];
                ends.push((p, edge.map_or(Mark::Inside, Mark::Edge)));
            }
        }
        return (ends.len() == 2).then(|| Cut {
            ends: [ends[0], ends[1]],
            face: Some(part.face),
        });
    }
    if !above {
        return None;
    }
    // The part touches the plane from above along one of its edges: the light stops there when something touches the
    // same edge from below. On a diagonal that is the other part of the same face.
    let k = (0..n).find(|&i| d[i] == 0.0 && d[(i + 1) % n] == 0.0)?;
    let ends = [k, (k + 1) % n].map(|i| (corners[i], Mark::Vertex(vertices[i])));
    match blockers.edges(part)[k] {
        None => Some(Cut {
            ends,
            face: Some(part.face),
        }),
        Some(edge) => is_crossed_at(scene, plane, edge, blockers.weld_distance())
            .then_some(Cut { ends, face: None }),
    }
}

/// True when faces along `edge` lie on both sides of a plane through it.
fn is_crossed_at(scene: &Scene, plane: &Plane, edge: EdgeId, tol: f64) -> bool {
    let (mut above, mut below) = (false, false);
    for u in &scene.edges[edge].uses {
        let side = side_of_face(scene, plane, edge, u.face, u.is_forward, tol);
        above |= side > 0;
        below |= side < 0;
    }
    above && below
}

/// On which side of `plane` (through `edge`) a face along that edge lies: +1, −1, or 0 when it lies in the plane within `tol`.
pub(super) fn side_of_face(
    scene: &Scene,
    plane: &Plane,
    edge: EdgeId,
    face: FaceId,
    is_forward: bool,
    tol: f64,
) -> i8 {
    let [a, b] = scene.edges[edge].ends.map(|v| scene.vertices[v]);
    let along = if is_forward { b - a } else { a - b };
    // Seen from the front the inside lies to the left of the edge.
    let inwards = scene.faces[face].frame.n.cross(along);
    let height = plane.normal.dot(inwards);
    // `inwards` is as long as the edge: the face leaves the plane by `height` over that length.
    if height.abs() <= tol {
        0
    } else if height > 0.0 {
        1
    } else {
        -1
    }
}
