//! The mesh on which the indirect light is solved.

use super::locator::Locator;
use crate::geom::Plane;
use crate::mesh::{FaceDomain, MeshError, ReceiverMesh};
use crate::quantity::Rgb;
use crate::scene::FaceSide;
use crate::visibility::{Region, Viewpoint};
use glam::{DVec2, DVec3};

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
    /// Elements' corners in space, counter-clockwise seen from the lit side.
    pub(super) triangles: Vec<[DVec3; 3]>,
    /// Sphere around all elements.
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    /// Bounding rectangle, counter-clockwise seen from the lit side.
    rectangle: [DVec3; 4],
    locator: Locator,
}

/// All sides that take part.
pub struct SolveMesh {
    /// The sides.
    pub faces: Vec<SolveFace>,
    sites: usize,
}

impl SolveMesh {
    /// Meshes every domain with points `spacing` metres apart.
    ///
    /// # Errors
    /// [`MeshError`]: our own bug.
    pub fn new(domains: Vec<(FaceDomain, Rgb)>, spacing: f64) -> Result<Self, MeshError> {
        let mut faces = Vec::with_capacity(domains.len());
        let mut sites = 0;
        for (domain, reflectance) in domains {
            let points = domain.seed_points(spacing);
            let mesh = domain.mesh(&[], &points)?;
            let face = SolveFace::new(domain, mesh, reflectance, sites);
            sites += face.mesh.site_vertices.len();
            faces.push(face);
        }
        Ok(Self { faces, sites })
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
    fn new(domain: FaceDomain, mesh: ReceiverMesh, reflectance: Rgb, first_site: usize) -> Self {
        let is_front = domain.side == FaceSide::Front;
        let triangles: Vec<[DVec3; 3]> = (0..mesh.elements.len())
            .map(|e| {
                let mut t = mesh.corners(e).map(|p| domain.frame.to_space(p));
                if !is_front {
                    t.swap(1, 2);
                }
                t
            })
            .collect();
        let corners = || triangles.iter().flatten().copied();
        let lo = corners().fold(DVec3::INFINITY, DVec3::min);
        let hi = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (lo2, hi2) = domain.polygon().bounds();
        let mut rectangle = [lo2, DVec2::new(hi2.x, lo2.y), hi2, DVec2::new(lo2.x, hi2.y)]
            .map(|p| domain.frame.to_space(p));
        if !is_front {
            rectangle.reverse();
        }
        Self {
            plane: Plane::new(domain.frame.origin, domain.normal),
            locator: Locator::new(&mesh),
            centre: 0.5 * (lo + hi),
            radius: 0.5 * lo.distance(hi),
            triangles,
            rectangle,
            domain,
            mesh,
            reflectance,
            first_site,
        }
    }

    /// A convex region that holds every line of sight from `view` to this face: the pyramid over its bounding rectangle.
    pub(super) fn region(&self, view: &Viewpoint) -> Region {
        Region::pyramid(view.position, &self.rectangle)
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
