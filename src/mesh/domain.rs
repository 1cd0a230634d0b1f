//! One side of one face as the mesher sees it: outline, contact lines and candidate lines on one grid.

use super::receiver::{ReceiverMesh, VertexOrigin};
use super::{
    Arrangement, Grid, GridPoint, Inset, MeshError, Segment, Sites, arrange, inside, sectors,
    triangulate,
};
use crate::discontinuity::Discontinuity;
use crate::geom::{AffineMap, PlaneFrame, Polygon2};
use crate::scene::{EdgeId, FaceId, FaceSide, Pattern, Scene, VertexId};
use crate::visibility::Viewpoint;
use glam::{DVec2, DVec3};
use std::sync::{Arc, OnceLock};

/// A stretch of the face's outline along one edge of the scene.
#[derive(Clone, Copy, Debug)]
struct OutlineEdge {
    edge: EdgeId,
    /// Ends in the edge's own direction.
    ends: [GridPoint; 2],
}

/// What does not change while a receiver is meshed anew.
pub struct FaceDomain {
    /// The face.
    pub face: FaceId,
    /// The side that is lit.
    pub side: FaceSide,
    /// Its plane.
    pub frame: PlaneFrame,
    /// Its grid.
    pub grid: Grid,
    /// Unit normal of the lit side.
    pub normal: DVec3,
    /// Its reflectance place by place, where that differs.
    pub pattern: Option<Arc<Pattern>>,
    /// The normal of the curved surface that the face stands for, on its front, if there is one.
    shading: Option<AffineMap<3>>,
    outline: Vec<OutlineEdge>,
    polygon: Polygon2,
    corners: Vec<(GridPoint, VertexId)>,
    contacts: Vec<[GridPoint; 2]>,
    covers: Vec<Polygon2>,
    lines: Vec<[GridPoint; 2]>,
    weld_distance: f64,
    /// The mesh along outline and contact lines alone, once it was asked for: on most of many faces the only one.
    bare: OnceLock<Arc<ReceiverMesh>>,
}

/// What a mesh edge lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeSource {
    /// An edge of the scene.
    Outline(EdgeId),
    /// Contact line number `i` of the domain.
    Contact(u32),
    /// Candidate line number `i` of the domain.
    Line(u32),
}

impl FaceDomain {
    /// Sets up the grid and snaps outline, contact lines and candidate lines to it.
    pub fn new(
        scene: &Scene,
        face: FaceId,
        side: FaceSide,
        contacts: &[Discontinuity],
        candidates: &[Discontinuity],
        covers: &[FaceId],
    ) -> Self {
        let f = &scene.faces[face];
        let (lo, hi) = f.outline.bounds();
        let grid = Grid::around(lo, hi);
        let snap = |p: DVec3| grid.snap(f.frame.to_plane(p));
        let outline = f
            .loop_edges
            .iter()
            .flatten()
            .map(|&edge| OutlineEdge {
                edge,
                ends: scene.edges[edge].ends.map(|v| snap(scene.vertices[v])),
            })
            .collect();
        let mut corners: Vec<_> = f
            .loops
            .iter()
            .flatten()
            .map(|&v| (snap(scene.vertices[v]), v))
            .collect();
        corners.sort_unstable();
        corners.dedup();
        let flat = |d: &Discontinuity| d.ends.map(snap);
        Self {
            face,
            side,
            frame: f.frame,
            grid,
            normal: scene.normal(face, side),
            pattern: f.pattern.clone(),
            shading: f.shading,
            outline,
            polygon: f.outline.clone(),
            corners,
            contacts: contacts.iter().map(flat).collect(),
            covers: covers
                .iter()
                .map(|&c| Polygon2 {
                    loops: scene.faces[c]
                        .loops
                        .iter()
                        .map(|l| {
                            l.iter()
                                .map(|&v| f.frame.to_plane(scene.vertices[v]))
                                .collect()
                        })
                        .collect(),
                })
                .collect(),
            lines: candidates.iter().map(flat).collect(),
            weld_distance: scene.weld_distance,
            bare: OnceLock::new(),
        }
    }

    /// A viewpoint on the lit side at frame coordinates `p`, metres, with the normal of the curved surface if there is one.
    pub fn view(&self, p: DVec2) -> Viewpoint {
        let position = self.frame.to_space(p);
        let curved = self
            .shading
            .and_then(|map| DVec3::from(map.at(position)).try_normalize());
        match curved {
            Some(normal) => Viewpoint::on_curve(position, self.normal, normal * self.side.sign()),
            None => Viewpoint::new(position, self.normal),
        }
    }

    /// Candidate line `i` in frame coordinates, metres.
    pub fn line(&self, i: usize) -> [DVec2; 2] {
        self.lines[i].map(|g| self.grid.to_plane(g))
    }

    /// Number of candidate lines.
    pub fn line_count(&self) -> usize {
        self.lines.len()
    }

    /// The outline in frame coordinates.
    pub fn polygon(&self) -> &Polygon2 {
        &self.polygon
    }

    /// Starting points about `spacing` metres apart: along every outline edge (the same from both of its faces) and on a
    /// staggered lattice inside, no nearer to the outline than half the spacing.
    pub fn seed_points(&self, spacing: f64) -> Vec<GridPoint> {
        let mut points = Vec::new();
        for o in &self.outline {
            let [a, b] = o.ends.map(|g| self.grid.to_plane(g));
            let n = (a.distance(b) / spacing).ceil().max(1.0) as u32;
            for i in 1..n {
                points.push(self.grid.snap(a.lerp(b, f64::from(i) / f64::from(n))));
            }
        }
        let (lo, hi) = self.polygon.bounds();
        let row = spacing * 0.75_f64.sqrt();
        let (columns, rows) = ((hi - lo).x / spacing, (hi - lo).y / row);
        for j in 0..rows.ceil() as i64 {
            for i in 0..columns.ceil() as i64 {
                let shift = if j % 2 == 0 { 0.25 } else { 0.75 };
                let p = lo + DVec2::new((i as f64 + shift) * spacing, (j as f64 + 0.5) * row);
                if self.polygon.contains(p) && self.polygon.distance_to_outline(p) > 0.5 * spacing {
                    points.push(self.grid.snap(p));
                }
            }
        }
        points.sort_unstable();
        points.dedup();
        points
    }

    /// The edges of the scene that the outline runs along, their ends (frame coordinates, metres) in the edge's own direction.
    pub fn outline_edges(&self) -> impl Iterator<Item = (EdgeId, [DVec2; 2])> + '_ {
        let ends = |o: &OutlineEdge| o.ends.map(|g| self.grid.to_plane(g));
        self.outline.iter().map(move |o| (o.edge, ends(o)))
    }

    /// The mesh along outline, contact lines, the candidate lines listed in `kept`, and through `points`.
    ///
    /// # Errors
    /// [`MeshError`]: our own bug.
    pub fn mesh(&self, kept: &[u32], points: &[GridPoint]) -> Result<Arc<ReceiverMesh>, MeshError> {
        if !(kept.is_empty() && points.is_empty()) {
            return Ok(Arc::new(self.mesh_anew(kept, points)?));
        }
        if let Some(mesh) = self.bare.get() {
            return Ok(mesh.clone());
        }
        let mesh = Arc::new(self.mesh_anew(kept, points)?);
        Ok(self.bare.get_or_init(|| mesh).clone())
    }

    fn mesh_anew(&self, kept: &[u32], points: &[GridPoint]) -> Result<ReceiverMesh, MeshError> {
        let (outlines, contacts) = (self.outline.len(), self.contacts.len());
        let source = |i: usize| u32::try_from(i).expect("fewer than 2³² lines on a face");
        let mut segments: Vec<Segment> = Vec::with_capacity(outlines + contacts + kept.len());
        let mut push = |[a, b]: [GridPoint; 2], source| segments.push(Segment { a, b, source });
        for (i, o) in self.outline.iter().enumerate() {
            push(o.ends, source(i));
        }
        for (i, &c) in self.contacts.iter().enumerate() {
            push(c, source(outlines + i));
        }
        for &k in kept {
            push(self.lines[k as usize], source(outlines + contacts) + k);
        }
        let arrangement = arrange(&segments, points);
        let triangulation = triangulate(&arrangement)?;
        let is_outline = |s: u32| (s as usize) < outlines;
        let is_barrier = |s: u32| (s as usize) < outlines + contacts;
        let mut is_in = inside(&triangulation, &arrangement, is_outline);
        for (t, corners) in triangulation.triangles.iter().enumerate() {
            let centre = corners
                .iter()
                .map(|&c| self.grid.to_plane(triangulation.vertices[c as usize]))
                .sum::<DVec2>()
                / 3.0;
            is_in[t] &= !self.covers.iter().any(|c| c.contains(centre));
        }
        let sites = sectors(&triangulation, &arrangement, &is_in, is_barrier);
        Ok(self.collect(&arrangement, &triangulation, &is_in, &sites))
    }

    /// Keeps the inside triangles and what they lie on.
    fn collect(
        &self,
        arrangement: &Arrangement,
        triangulation: &super::Triangulation,
        is_in: &[bool],
        sites: &Sites,
    ) -> ReceiverMesh {
        let mut mesh = ReceiverMesh {
            vertices: triangulation.vertices.clone(),
            plane: triangulation
                .vertices
                .iter()
                .map(|&g| self.grid.to_plane(g))
                .collect(),
            site_vertices: sites.vertices.clone(),
            origins: vec![VertexOrigin::Inner; triangulation.vertices.len()],
            ..ReceiverMesh::default()
        };
        for edge in &arrangement.edges {
            for &s in &edge.sources {
                if let EdgeSource::Outline(id) = self.source(s) {
                    for v in edge.ends {
                        mesh.origins[v as usize] =
                            self.origin(s as usize, id, mesh.vertices[v as usize]);
                    }
                }
            }
        }
        let mut element_of = vec![None; is_in.len()];
        for (t, corners) in sites.corners.iter().enumerate() {
            if let (true, Some(corners)) = (is_in[t], corners) {
                element_of[t] = Some(mesh.elements.len() as u32);
                mesh.elements.push(triangulation.triangles[t]);
                mesh.sites.push(*corners);
            }
        }
        mesh.labels = arrangement
            .edges
            .iter()
            .map(|e| e.sources.iter().map(|&s| self.source(s)).collect())
            .collect();
        for t in (0..is_in.len()).filter(|&t| element_of[t].is_some()) {
            mesh.edges.push(triangulation.edges[t]);
            mesh.neighbours
                .push(triangulation.neighbours[t].map(|n| n.and_then(|n| element_of[n as usize])));
        }
        mesh.place_sites(Inset::limit(self.weld_distance));
        mesh.compact();
        mesh
    }

    fn source(&self, s: u32) -> EdgeSource {
        let (outlines, contacts) = (self.outline.len() as u32, self.contacts.len() as u32);
        if s < outlines {
            EdgeSource::Outline(self.outline[s as usize].edge)
        } else if s < outlines + contacts {
            EdgeSource::Contact(s - outlines)
        } else {
            EdgeSource::Line(s - outlines - contacts)
        }
    }

    /// A vertex of the outline: a corner by identity, else a parameter along its edge.
    fn origin(&self, outline: usize, edge: EdgeId, g: GridPoint) -> VertexOrigin {
        if let Ok(i) = self.corners.binary_search_by_key(&g, |c| c.0) {
            return VertexOrigin::Corner(self.corners[i].1);
        }
        let [a, b] = self.outline[outline].ends.map(|e| self.grid.to_plane(e));
        let d = b - a;
        let t = (self.grid.to_plane(g) - a).dot(d) / d.length_squared();
        VertexOrigin::OnEdge(edge, t)
    }
}
