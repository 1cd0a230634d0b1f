//! The meshes of neighbouring faces made to share their vertices along common edges: no T-junctions, no cracks.
//!
//! Each face is meshed by itself. Along an edge of the scene its vertices are known by their parameter; the vertices of
//! all faces along that edge are united, equal ones (within the weld distance) become one, and each mesh gets those it
//! lacks: the elements along the edge are divided there, which changes no other element.

use super::Solution;
use super::smooth::{self, SeamKey};
use crate::adapt::{Illumination, Receiver};
use crate::lit_scene::LitMesh;
use crate::mesh::{EdgeSource, Inset, VertexOrigin, barycentric};
use crate::quantity::{Exitance, Irradiance};
use crate::scene::{EdgeId, FaceSide, IdVec, Scene};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// For each edge the sorted parameters of all vertices inside it.
type Stations = IdVec<EdgeId, Vec<f64>>;

/// One lit mesh for each receiver.
pub(super) fn lit_meshes(solution: &Solution) -> Vec<LitMesh> {
    let scene = &solution.world.scene;
    let stations = stations(scene, &solution.receivers);
    let built: Vec<_> = solution
        .receivers
        .par_iter()
        .enumerate()
        .filter(|(_, r)| !r.mesh.elements.is_empty())
        .map(|(i, r)| {
            let mut builder = Builder::new(solution, &stations, r);
            if let Some(errors) = &solution.site_errors {
                builder.out.errors.clone_from(&errors[i]);
            }
            builder.build()
        })
        .collect();
    let (mut meshes, mut seams) = (Vec::with_capacity(built.len()), Vec::new());
    for (index, (mesh, touches)) in built.into_iter().enumerate() {
        seams.extend(touches.into_iter().map(|(key, v)| (key, (index, v))));
        meshes.push(mesh);
    }
    smooth::share(&mut meshes, seams);
    meshes
}

fn stations(scene: &Scene, receivers: &[Receiver]) -> Stations {
    let mut stations: Stations = vec![Vec::new(); scene.edges.len()].into();
    for r in receivers {
        for origin in &r.mesh.origins {
            if let VertexOrigin::OnEdge(edge, t) = *origin {
                stations[edge].push(t);
            }
        }
    }
    for edge in scene.edges.ids() {
        let tol = scene.weld_distance / length(scene, edge);
        let list = &mut stations[edge];
        list.sort_unstable_by(f64::total_cmp);
        // The first of each cluster stands for it.
        list.dedup_by(|b, a| *b - *a <= tol);
    }
    stations
}

fn length(scene: &Scene, edge: EdgeId) -> f64 {
    let [a, b] = scene.edges[edge].ends.map(|v| scene.vertices[v]);
    a.distance(b)
}

fn on_edge(scene: &Scene, edge: EdgeId, t: f64) -> DVec3 {
    let [a, b] = scene.edges[edge].ends.map(|v| scene.vertices[v]);
    a + (b - a) * t
}

/// The station that stands for a vertex at parameter `t`.
fn station_of(stations: &[f64], t: f64) -> f64 {
    let i = stations.partition_point(|&s| s <= t);
    stations[i.saturating_sub(1)]
}

/// Builds one mesh; vertices are the receiver's sites first, then those that were inserted.
struct Builder<'a> {
    solution: &'a Solution<'a>,
    stations: &'a Stations,
    receiver: &'a Receiver,
    plane: Vec<DVec2>,
    out: LitMesh,
    /// Vertices on edges inside curved surfaces.
    touches: Vec<(SeamKey, Corner)>,
}

/// A corner on the way round an element: its vertex in `out`, and where it stands.
type Corner = u32;

impl<'a> Builder<'a> {
    fn new(solution: &'a Solution, stations: &'a Stations, receiver: &'a Receiver) -> Self {
        let scene = &solution.world.scene;
        let (face, side) = (receiver.domain.face, receiver.domain.side);
        let f = &scene.faces[face];
        let emits = scene
            .emitters
            .iter()
            .any(|(_, e)| e.face == face && e.side == side);
        let mut out = LitMesh {
            group: f.group,
            material: f.material,
            face: face.0,
            normal: scene.normal(face, side),
            reflectance: f.reflectance,
            exitance: if emits {
                Exitance::from_radiance(f.emission)
            } else {
                Exitance::ZERO
            },
            ..LitMesh::default()
        };
        let mesh = &receiver.mesh;
        for (s, &v) in mesh.site_vertices.iter().enumerate() {
            out.positions.push(match mesh.origins[v as usize] {
                VertexOrigin::Corner(id) => scene.vertices[id],
                VertexOrigin::OnEdge(edge, t) => {
                    on_edge(scene, edge, station_of(&stations[edge], t))
                }
                VertexOrigin::Inner => f.frame.to_space(mesh.plane[v as usize]),
            });
            out.irradiance.push(receiver.site_total(s));
        }
        Self {
            plane: mesh
                .site_vertices
                .iter()
                .map(|&v| mesh.plane[v as usize])
                .collect(),
            solution,
            stations,
            receiver,
            out,
            touches: Vec::new(),
        }
    }

    fn build(mut self) -> (LitMesh, Vec<(SeamKey, Corner)>) {
        let mesh = &self.receiver.mesh;
        for e in 0..mesh.elements.len() {
            let between = [0, 1, 2].map(|k| self.missing(e, k));
            self.divide(e, mesh.sites[e], between);
        }
        let (face, side) = (self.receiver.domain.face, self.receiver.domain.side);
        let face = &self.solution.world.scene.faces[face];
        let positions = &self.out.positions;
        self.out.uvs = positions.iter().filter_map(|&p| face.uv_at(p)).collect();
        if face.shading.is_some() {
            let normal = |&p: &DVec3| face.shading_normal(p) * side.sign();
            self.out.normals = positions.iter().map(normal).collect();
        }
        if side == FaceSide::Back {
            for t in &mut self.out.triangles {
                t.swap(1, 2);
            }
        }
        (self.out, self.touches)
    }

    /// The stations strictly between the ends of edge `k` of element `e`, from its start to its end, as new vertices.
    fn missing(&mut self, e: usize, k: usize) -> Vec<Corner> {
        let mesh = &self.receiver.mesh;
        let Some(label) = mesh.edges[e][k] else {
            return Vec::new();
        };
        let Some(edge) = mesh.labels[label as usize].iter().find_map(|s| match s {
            EdgeSource::Outline(edge) => Some(*edge),
            _ => None,
        }) else {
            return Vec::new();
        };
        let scene = &self.solution.world.scene;
        let list = &self.stations[edge];
        let parameter = |v: u32| match mesh.origins[v as usize] {
            VertexOrigin::OnEdge(other, t) if other == edge => Some(station_of(list, t)),
            VertexOrigin::Corner(id) => {
                let ends = scene.edges[edge].ends;
                ends.iter()
                    .position(|&end| end == id)
                    .map(|i| if i == 0 { 0.0 } else { 1.0 })
            }
            _ => None,
        };
        let corners = mesh.elements[e];
        let (Some(from), Some(to)) = (parameter(corners[k]), parameter(corners[(k + 1) % 3]))
        else {
            return Vec::new();
        };
        let (lo, hi) = (from.min(to), from.max(to));
        let mut inner: Vec<f64> = list.iter().copied().filter(|&t| t > lo && t < hi).collect();
        if from > to {
            inner.reverse();
        }
        let new: Vec<Corner> = inner.iter().map(|&t| self.insert(e, edge, t)).collect();
        let is_contact = |s: &EdgeSource| matches!(s, EdgeSource::Contact(_));
        if scene.edges[edge].is_smooth && !mesh.labels[label as usize].iter().any(is_contact) {
            let sites = mesh.sites[e];
            let ends = [(from, sites[k]), (to, sites[(k + 1) % 3])];
            let side = self.receiver.domain.side;
            self.touches.extend(SeamKey::along(edge, side, &ends));
            for (&t, &v) in inner.iter().zip(&new) {
                self.touches
                    .extend(SeamKey::at(edge, side, t).map(|key| (key, v)));
            }
        }
        new
    }

    /// A new vertex on the border of element `e`, with its own light.
    fn insert(&mut self, e: usize, edge: EdgeId, t: f64) -> Corner {
        let scene = &self.solution.world.scene;
        let r = self.receiver;
        let position = on_edge(scene, edge, t);
        let p = r.domain.frame.to_plane(position);
        let inside = r.mesh.inset(e, p, Inset::limit(scene.weld_distance));
        let value = if r.is_lit {
            let light = Illumination {
                direct: &self.solution.direct,
                tolerance: self.solution.tolerance,
                indirect: self.solution.indirect.as_ref(),
            };
            r.total(&light, inside)
        } else {
            Irradiance::ZERO
        };
        debug_assert!(
            barycentric(r.mesh.corners(e), inside)
                .iter()
                .all(|b| b.is_finite())
        );
        self.out.positions.push(position);
        self.out.irradiance.push(value);
        if !self.out.errors.is_empty() {
            // Between two vertices of the element's border its corners tell.
            let corners = r.mesh.sites[e].map(|s| self.out.errors[s as usize]);
            let weights = barycentric(r.mesh.corners(e), p);
            let error: f64 = corners.iter().zip(weights).map(|(c, w)| c * w).sum();
            self.out.errors.push(error.max(0.0));
        }
        self.plane.push(p);
        (self.out.positions.len() - 1) as Corner
    }

    /// Triangles over an element whose edges carry extra vertices.
    fn divide(&mut self, e: usize, corners: [Corner; 3], between: [Vec<Corner>; 3]) {
        let _ = e;
        let [ab, bc, ca] = between;
        let [a, b, c] = corners;
        if ab.is_empty() && bc.is_empty() && ca.is_empty() {
            self.out.triangles.push(corners);
            return;
        }
        // Put an edge with extra vertices first, then fan it out from the opposite corner: only the first and the last
        // triangle of the fan touch the other two edges.
        if ab.is_empty() {
            return self.divide(e, [b, c, a], [bc, ca, ab]);
        }
        let chain: Vec<Corner> = std::iter::once(a).chain(ab).chain([b]).collect();
        let last = chain.len() - 2;
        for i in 0..=last {
            let right = if i == last { bc.clone() } else { Vec::new() };
            let left = if i == 0 { ca.clone() } else { Vec::new() };
            self.divide(e, [chain[i], chain[i + 1], c], [Vec::new(), right, left]);
        }
    }
}
