//! The mesh on which the indirect light is solved.

use super::locator::Locator;
use super::{LightSample, project};
use crate::geom::Plane;
use crate::mesh::{FaceDomain, GridPoint, MeshError, ReceiverMesh};
use crate::quantity::{Irradiance, Rgb};
use crate::scene::FaceSide;
use crate::visibility::{Region, Viewpoint};
use glam::{DVec2, DVec3};

/// Share of the error asked for that a face may contribute to a form factor sum and be judged by one ray. The mistakes of
/// hundreds of such faces add like random steps; rows weigh 1/(1 − ρ) in the solution, so that factor is taken off.
const SAMPLED_SHARE: f64 = 0.05;

/// With so many sides exact clipping everywhere costs more than the rest of the bake, and the mistakes of sampling are spread
/// over so many of them that they cancel; fewer are always clipped exactly, so that rows sum to 1 to round-off.
pub const MANY_SIDES: usize = 256;

/// Rounds of halving at most: a shadow line is followed down to a sixteenth of the spacing.
const MAX_HALVINGS: usize = 4;

/// Weight of squared distances in elements that touch neither the outline nor a contact line: no other surface is near,
/// and from afar only the power of an element counts, which the projection keeps.
const INNER_WEIGHT: f64 = 0.1;

/// Elements narrower than this share of the spacing are not halved.
const SMALLEST_SHARE: f64 = 1.0 / 8.0;

/// Share of the permitted squared distance that may stay in elements that are not halved.
const UNMARKED_SHARE: f64 = 0.5;

/// A face with a radius below this share of the solve mesh's spacing has one value.
const SMALL_SHARE: f64 = 0.25;

/// One side of one face in the solve mesh.
pub struct SolveFace {
    /// Geometry.
    pub domain: FaceDomain,
    /// Its elements.
    pub mesh: ReceiverMesh,
    /// Diffuse reflectance of this side.
    pub reflectance: Rgb,
    /// Index of its first site among all sites.
    pub first_site: usize,
    /// Plane, normal towards the lit side.
    pub plane: Plane,
    /// Vertices in space, metres.
    pub(super) positions: Vec<DVec3>,
    /// Elements, counter-clockwise seen from the lit side, with the value sites of these corners.
    pub(super) triangles: Vec<SolveTriangle>,
    /// Edges between vertices, each once.
    pub(super) edges: Vec<[u32; 2]>,
    /// Sphere around all elements.
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    /// Whether it is so small that one value is enough for the solution.
    pub(super) is_small: bool,
    /// A form factor below this is estimated by sampling.
    pub(super) sampled_below: f64,
    /// Area of the elements, m².
    pub(super) area: f64,
    /// The middle of the largest element, metres.
    pub(super) middle_point: Option<DVec3>,
    /// Bounding rectangle, counter-clockwise seen from the lit side.
    pub(super) rectangle: [DVec3; 4],
    locator: Locator,
    /// Points that its elements pass through.
    points: Vec<GridPoint>,
}

/// An element ready for form factors.
#[derive(Clone, Copy, Debug)]
pub(super) struct SolveTriangle {
    pub(super) vertices: [u32; 3],
    pub(super) sites: [u32; 3],
    /// The edge from each corner to the next, and whether it runs that way.
    pub(super) edges: [(u32, bool); 3],
    /// Square of its longest edge, m².
    pub(super) width_squared: f64,
}

/// All sides that take part.
pub struct SolveMesh {
    /// The sides.
    pub faces: Vec<SolveFace>,
    sites: usize,
    spacing: f64,
}

impl SolveMesh {
    /// Meshes every domain with points `spacing` metres apart; `error` is the relative error asked for.
    ///
    /// # Errors
    /// [`MeshError`]: our own bug.
    pub fn new(
        domains: Vec<(FaceDomain, Rgb)>,
        spacing: f64,
        error: f64,
    ) -> Result<Self, MeshError> {
        let mut faces = Vec::with_capacity(domains.len());
        let area: f64 = domains.iter().map(|(d, _)| d.polygon().area()).sum();
        let reflected: f64 = domains
            .iter()
            .map(|(d, rho)| d.polygon().area() * rho.0.max_element())
            .sum();
        let sampled_below = if domains.len() > MANY_SIDES {
            SAMPLED_SHARE * error * (1.0 - reflected / area)
        } else {
            0.0
        };
        let mut sites = 0;
        for (domain, reflectance) in domains {
            let points = domain.seed_points(spacing);
            let face = SolveFace::new(domain, points, reflectance, sites, spacing, sampled_below)?;
            sites += face.mesh.site_vertices.len();
            faces.push(face);
        }
        Ok(Self {
            faces,
            sites,
            spacing,
        })
    }

    /// Halves elements over which the light of `samples` departs from the basis, until its RMS distance from its own
    /// projection over all faces is below `target` (W/m²). `fallback` gives the light at a local site of a face that no
    /// sample reaches.
    ///
    /// What a face reflects onto its neighbours near a contact or a corner depends on the light within an element: sharp
    /// shadows must not be smeared over coarse elements there.
    ///
    /// # Errors
    /// [`MeshError`]: our own bug.
    pub fn follow(
        mut self,
        samples: &[LightSample],
        fallback: impl Fn(&SolveFace, usize) -> Irradiance,
        target: f64,
    ) -> Result<Self, MeshError> {
        let area: f64 = self.faces.iter().map(|f| f.area).sum();
        let allowed = target * target * area;
        for _ in 0..MAX_HALVINGS {
            let errors = self.projection_errors(samples, &fallback);
            let mut sorted: Vec<f64> = errors.iter().flatten().copied().collect();
            sorted.sort_unstable_by(f64::total_cmp);
            if sorted.iter().sum::<f64>() <= allowed {
                break;
            }
            let mut unmarked = 0.0;
            let limit = sorted
                .iter()
                .find(|&&e| {
                    unmarked += e;
                    unmarked > UNMARKED_SHARE * allowed
                })
                .copied()
                .unwrap_or(f64::INFINITY);
            let mut sites = 0;
            let mut faces = Vec::with_capacity(self.faces.len());
            for (mut face, errors) in self.faces.into_iter().zip(&errors) {
                face.first_site = sites;
                let face = face.halve(errors, limit, self.spacing)?;
                sites += face.mesh.site_vertices.len();
                faces.push(face);
            }
            self.faces = faces;
            self.sites = sites;
        }
        Ok(self)
    }

    /// For each element the integral of the squared distance of the light from its projection.
    fn projection_errors(
        &self,
        samples: &[LightSample],
        fallback: &impl Fn(&SolveFace, usize) -> Irradiance,
    ) -> Vec<Vec<f64>> {
        let nodal = project(self, samples.iter().copied(), |f, s| {
            fallback(&self.faces[f], s)
        });
        let mut errors: Vec<Vec<f64>> = self
            .faces
            .iter()
            .map(|f| vec![0.0; f.mesh.elements.len()])
            .collect();
        for sample in samples {
            let face = &self.faces[sample.face as usize];
            if face.is_small {
                continue;
            }
            if let Some((e, weights)) = face.locate(sample.point) {
                let mut linear = Irradiance::ZERO;
                for (&s, w) in face.mesh.sites[e].iter().zip(weights) {
                    linear += nodal[face.first_site + s as usize] * w;
                }
                let sites = face.mesh.sites[e];
                let is_inner = !sites.iter().any(|&s| face.mesh.is_limit[s as usize]);
                let weight = if is_inner { INNER_WEIGHT } else { 1.0 };
                errors[sample.face as usize][e] +=
                    weight * sample.area * (sample.irradiance - linear).0.mean_square();
            }
        }
        errors
    }

    /// Number of sites: unknowns a channel.
    pub fn site_count(&self) -> usize {
        self.sites
    }

    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.faces.iter().map(|f| f.mesh.elements.len()).sum()
    }

    /// Reflectance at every site.
    pub(super) fn reflectances(&self) -> Vec<Rgb> {
        let mut all = Vec::with_capacity(self.sites);
        for f in &self.faces {
            all.extend(f.mesh.site_vertices.iter().map(|_| f.reflectance));
        }
        all
    }
}

impl SolveFace {
    fn new(
        domain: FaceDomain,
        points: Vec<GridPoint>,
        reflectance: Rgb,
        first_site: usize,
        spacing: f64,
        sampled_below: f64,
    ) -> Result<Self, MeshError> {
        let mesh = domain.mesh(&[], &points)?;
        let is_front = domain.side == FaceSide::Front;
        let positions: Vec<DVec3> = mesh
            .plane
            .iter()
            .map(|&p| domain.frame.to_space(p))
            .collect();
        let (triangles, edges) = connect(&mesh, &positions, is_front);
        let corners = || {
            let used = triangles.iter().flat_map(|t| t.vertices);
            used.map(|v| positions[v as usize])
        };
        let lo = corners().fold(DVec3::INFINITY, DVec3::min);
        let hi = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (lo2, hi2) = domain.polygon().bounds();
        let mut rectangle = [lo2, DVec2::new(hi2.x, lo2.y), hi2, DVec2::new(lo2.x, hi2.y)]
            .map(|p| domain.frame.to_space(p));
        if !is_front {
            rectangle.reverse();
        }
        Ok(Self {
            plane: Plane::new(domain.frame.origin, domain.normal),
            locator: Locator::new(&mesh),
            centre: 0.5 * (lo + hi),
            radius: 0.5 * lo.distance(hi),
            is_small: 0.5 * lo.distance(hi) < SMALL_SHARE * spacing,
            sampled_below,
            area: (0..mesh.elements.len()).map(|e| mesh.area(e)).sum(),
            middle_point: largest(&mesh).map(|e| domain.frame.to_space(mesh.centre(e))),
            positions,
            triangles,
            edges,
            rectangle,
            domain,
            mesh,
            reflectance,
            first_site,
            points,
        })
    }

    /// Divides the elements whose error is at least `limit` at the midpoints of their edges, down to a few halvings of
    /// `spacing`.
    fn halve(self, errors: &[f64], limit: f64, spacing: f64) -> Result<Self, MeshError> {
        let mut points = self.points.clone();
        let before = points.len();
        for (e, &error) in errors.iter().enumerate() {
            if error < limit || self.triangles[e].width_squared.sqrt() < SMALLEST_SHARE * spacing {
                continue;
            }
            let p = self.mesh.corners(e);
            for k in 0..3 {
                points.push(self.domain.grid.snap(p[k].midpoint(p[(k + 1) % 3])));
            }
        }
        if points.len() == before {
            return Ok(self);
        }
        points.sort_unstable();
        points.dedup();
        Self::new(
            self.domain,
            points,
            self.reflectance,
            self.first_site,
            spacing,
            self.sampled_below,
        )
    }

    /// A convex region that holds every line of sight from `view` to this face: the pyramid over its bounding rectangle.
    pub(super) fn region(&self, view: &Viewpoint) -> Region {
        Region::pyramid(view.position, &self.rectangle)
    }

    /// The middle of the largest element.
    pub(super) fn middle(&self) -> Option<DVec2> {
        largest(&self.mesh).map(|e| self.mesh.centre(e))
    }

    /// Where the value of local site `s` is taken.
    pub fn site_view(&self, s: usize) -> Viewpoint {
        self.view(self.mesh.site_points[s])
    }

    /// A viewpoint on this side at frame coordinates `p`.
    pub fn view(&self, p: DVec2) -> Viewpoint {
        Viewpoint::new(self.domain.frame.to_space(p), self.domain.normal)
    }

    /// The element that holds `p` (frame coordinates, metres) and the barycentric coordinates there; outside all elements
    /// the one that comes nearest. None when there is no element.
    pub fn locate(&self, p: DVec2) -> Option<(usize, [f64; 3])> {
        self.locator.locate(&self.mesh, p)
    }
}

/// Elements and edges by vertex, counter-clockwise seen from the lit side.
fn connect(
    mesh: &ReceiverMesh,
    positions: &[DVec3],
    is_front: bool,
) -> (Vec<SolveTriangle>, Vec<[u32; 2]>) {
    let order = if is_front { [0, 1, 2] } else { [0, 2, 1] };
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * mesh.elements.len());
    for corners in &mesh.elements {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.push([a.min(b), a.max(b)]);
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let triangles = mesh
        .elements
        .iter()
        .zip(&mesh.sites)
        .map(|(corners, sites)| {
            let vertices = order.map(|k| corners[k]);
            let along = [0, 1, 2].map(|k| (vertices[k], vertices[(k + 1) % 3]));
            SolveTriangle {
                vertices,
                sites: order.map(|k| sites[k]),
                edges: along.map(|(a, b)| {
                    let edge = edges
                        .binary_search(&[a.min(b), a.max(b)])
                        .expect("every edge of an element was listed");
                    (edge as u32, a < b)
                }),
                width_squared: along
                    .map(|(a, b)| positions[a as usize].distance_squared(positions[b as usize]))
                    .into_iter()
                    .fold(0.0, f64::max),
            }
        })
        .collect();
    (triangles, edges)
}

/// The largest element.
fn largest(mesh: &ReceiverMesh) -> Option<usize> {
    (0..mesh.elements.len()).max_by(|&a, &b| mesh.area(a).total_cmp(&mesh.area(b)))
}
