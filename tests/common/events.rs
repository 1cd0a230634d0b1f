//! Which critical surfaces of a scene pass through a point, by brute force over vertices and edges.

use super::obj_lite::ObjMesh;
use super::reference::pairs;
use glam::DVec3;

/// A kind of critical surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Surface {
    /// A plane through an emitter's vertex and an edge, an emitter's edge and a vertex, or an emitter itself.
    EmitterPlane,
    /// The plane of a blocker that cuts an emitter.
    FacePlane,
    /// A plane through a vertex and an edge of two faces that do not emit.
    BlockerPlane,
    /// The lines that meet three skew edges.
    Quadric,
}

/// Something that vanishes on a surface.
type Height<'a> = &'a dyn Fn(DVec3) -> f64;

/// Vertices and edges of all polygons.
pub(crate) struct Events {
    vertices: Vec<(DVec3, bool)>,
    edges: Vec<([DVec3; 2], bool)>,
    emitters: Vec<(DVec3, DVec3)>,
    /// Planes of blockers that cut an emitter.
    planes: Vec<(DVec3, DVec3)>,
}

/// Step of the difference quotients, over the tolerance.
const STEP: f64 = 1e-2;

/// Edges count as meeting or parallel when their distance is below this share of their lengths.
const FLAT: f64 = 1e-9;

impl Events {
    /// Collects the features of a scene.
    pub(crate) fn new(mesh: &ObjMesh) -> Self {
        let mut events = Self {
            vertices: Vec::new(),
            edges: Vec::new(),
            emitters: Vec::new(),
            planes: Vec::new(),
        };
        for (i, polygon) in mesh.polygons.iter().enumerate() {
            let emits = mesh.surface_of(i).ke != DVec3::ZERO;
            let corners = &polygon.corners;
            events.vertices.extend(corners.iter().map(|&c| (c, emits)));
            let edges = pairs(corners).map(|(a, b)| ([a, b], emits));
            events.edges.extend(edges);
            if emits {
                events.emitters.push((corners[0], polygon.normal()));
            }
        }
        for polygon in &mesh.polygons {
            let (origin, n) = (polygon.corners[0], polygon.normal());
            let is_cut = |i: usize| {
                let corners = &mesh.polygons[i].corners;
                let heights = || corners.iter().map(|&c| n.dot(c - origin));
                let flat = FLAT * corners[0].distance(corners[1]);
                heights().any(|h| h > flat) && heights().any(|h| h < -flat)
            };
            let mut emitters =
                (0..mesh.polygons.len()).filter(|&i| mesh.surface_of(i).ke != DVec3::ZERO);
            if emitters.any(is_cut) {
                events.planes.push((origin, n));
            }
        }
        events
    }

    /// The first kind of surface that comes within `tolerance` of `p` along `direction` (a unit vector).
    pub(crate) fn through(&self, p: DVec3, direction: DVec3, tolerance: f64) -> Option<Surface> {
        let step = direction * (tolerance * STEP);
        // Where the linear continuation of `g` vanishes.
        let vanishes = |g: &dyn Fn(DVec3) -> f64| {
            let slope = (g(p + step) - g(p - step)) / (2.0 * STEP * tolerance);
            g(p).abs() <= slope.abs() * tolerance
        };
        if self
            .emitters
            .iter()
            .any(|&(origin, n)| vanishes(&|x| n.dot(x - origin)))
        {
            return Some(Surface::EmitterPlane);
        }
        if self
            .planes
            .iter()
            .any(|&(origin, n)| vanishes(&|x| n.dot(x - origin)))
        {
            return Some(Surface::FacePlane);
        }
        for wants_emitter in [true, false] {
            for &(v, emits) in &self.vertices {
                for &([a, b], edge_emits) in &self.edges {
                    let n = (b - a).cross(v - a);
                    let is_flat = n.length() <= FLAT * (b - a).length() * (v - a).length();
                    if (emits || edge_emits) == wants_emitter
                        && !is_flat
                        && vanishes(&|x| n.dot(x - a))
                    {
                        return Some(if wants_emitter {
                            Surface::EmitterPlane
                        } else {
                            Surface::BlockerPlane
                        });
                    }
                }
            }
        }
        self.is_on_quadric(&vanishes).then_some(Surface::Quadric)
    }

    fn is_on_quadric(&self, vanishes: &dyn Fn(Height) -> bool) -> bool {
        let edges = &self.edges;
        let skew = |i: usize, j: usize| are_skew(edges[i].0, edges[j].0);
        (0..edges.len()).any(|i| {
            (i + 1..edges.len()).filter(|&j| skew(i, j)).any(|j| {
                let rest = (j + 1..edges.len()).filter(|&k| skew(i, k) && skew(j, k));
                let mut triples = rest.map(|k| [edges[i].0, edges[j].0, edges[k].0]);
                // The planes through the point and each edge have a line in common.
                triples.any(|t| {
                    vanishes(&|x| {
                        let [l, m, n] = t.map(|[a, b]| (a - x).cross(b - x));
                        l.cross(m).dot(n)
                    })
                })
            })
        })
    }
}

fn are_skew([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> bool {
    let (u, v, w) = (b - a, d - c, c - a);
    let volume = u.cross(v).dot(w).abs();
    volume > FLAT * u.length() * v.length() * w.length().max(f64::MIN_POSITIVE)
}
