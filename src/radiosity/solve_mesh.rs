//! The lit sides, and on each the coarse mesh at whose corners and edge midpoints the light is gathered for the solution.

use super::clusters::Clusters;
use super::locator::Locator;
use crate::geom::{Plane, even_point_in};
use crate::mesh::{FaceDomain, GridPoint, MeshError, ReceiverMesh};
use crate::quantity::Rgb;
use crate::scene::{EdgeId, FaceId, FaceSide};
use crate::visibility::{Region, Viewpoint};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// A face with a radius below this share of the solve mesh's spacing has one value: the mean of so many points.
const SMALL_SHARE: f64 = 0.25;
pub(super) const SPREAD_POINTS: u32 = 4;

/// With more sides than this cutting everything exactly costs more than the rest of the bake, and the mistakes of rays are
/// spread over so many of them that they cancel: what is not bright is told by rays, and so is what a small face receives.
/// Fewer are always cut exactly.
const MANY_SIDES: usize = 192;

/// Links are not asked to be more exact than for light that is reflected so many times over: where less than this is
/// absorbed, openings decide.
const LEAST_LOSS: f64 = 1e-4;

/// Distance of the row of points beside a graded edge, as a share of the spacing.
///
/// Near a concave edge the light goes like `B₀ − c r^γ`, γ from ½ to 1, and quadratic elements of even size are off by
/// `O(h^γ)` there. Grading with exponent `2/γ ≈ 3` would put ever more rows ever closer; but the field refines itself where it is
/// off, and a row at a sixteenth as well as at a quarter of the spacing cost more than it saved.
const EDGE_ROW: f64 = 0.25;

/// One side of one face in the solve mesh.
pub struct SolveFace {
    /// Geometry.
    pub domain: Arc<FaceDomain>,
    /// Its elements.
    pub mesh: Arc<ReceiverMesh>,
    /// Mean diffuse reflectance of this side.
    pub reflectance: Rgb,
    /// Plane, normal towards the lit side.
    pub plane: Plane,
    /// The triangles between its outline and its contact lines, frame coordinates.
    pub(super) roots: Vec<[DVec2; 3]>,
    /// Sphere around the bounding rectangle.
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    /// Whether it is so small that one value is enough for the solution.
    pub(super) is_small: bool,
    /// Area of the elements, m².
    pub(super) area: f64,
    /// The middle of the largest element, metres.
    pub(super) middle_point: DVec3,
    /// Bounding rectangle, counter-clockwise seen from the lit side.
    pub(super) rectangle: [DVec3; 4],
    pub(super) locator: Locator,
}

/// All sides that take part.
pub struct SolveMesh {
    /// The sides.
    pub faces: Vec<SolveFace>,
    /// Distance of neighbouring points, metres.
    pub spacing: f64,
    /// The sides that reflect, as a tree.
    pub(super) clusters: Clusters,
    /// The number of each side of each face of the scene, as far as they take part.
    numbers: Vec<[Option<u32>; 2]>,
}

/// For each side of the faces of the scene its number in `faces`: a ray asks for it, hundreds of them for each point.
fn numbers(faces: &[SolveFace]) -> Vec<[Option<u32>; 2]> {
    let last = faces.iter().map(|f| f.domain.face).max();
    let mut numbers = vec![[None; 2]; last.map_or(0, |f| f.0 as usize + 1)];
    for (number, SolveFace { domain, .. }) in (0_u32..).zip(faces) {
        numbers[domain.face.0 as usize][domain.side as usize] = Some(number);
    }
    numbers
}

impl SolveMesh {
    /// Meshes every domain with points `spacing` metres apart.
    ///
    /// # Errors
    /// [`MeshError`]: our own bug.
    pub fn new(domains: Vec<(Arc<FaceDomain>, Rgb)>, spacing: f64) -> Result<Self, MeshError> {
        Self::graded(domains, spacing, |_, _| false, |_| &[])
    }

    /// The same with a row of points close to those edges for which `is_graded(domain, edge)`, and one along the projection
    /// of each of `rims(domain)`: lines close to the domain, their ends in space.
    ///
    /// # Errors
    /// [`MeshError`]: our own bug.
    pub fn graded<'r>(
        domains: Vec<(Arc<FaceDomain>, Rgb)>,
        spacing: f64,
        is_graded: impl Fn(&FaceDomain, EdgeId) -> bool,
        rims: impl Fn(&FaceDomain) -> &'r [[DVec3; 2]],
    ) -> Result<Self, MeshError> {
        let mut faces = Vec::with_capacity(domains.len());
        for (domain, reflectance) in domains {
            let mut points = domain.seed_points(spacing);
            for (edge, ends) in domain.outline_edges() {
                if is_graded(&domain, edge) {
                    points.extend(row_beside(&domain, ends, spacing));
                }
            }
            for &rim in rims(&domain) {
                points.extend(row_along(&domain, rim, spacing));
            }
            points.sort_unstable();
            points.dedup();
            faces.push(SolveFace::new(domain, &points, reflectance, spacing)?);
        }
        Ok(Self {
            clusters: Clusters::new(&faces),
            numbers: numbers(&faces),
            faces,
            spacing,
        })
    }

    /// The number of a side among the faces; none when it takes no part.
    pub(super) fn number(&self, face: FaceId, side: FaceSide) -> Option<usize> {
        let sides = self.numbers.get(face.0 as usize)?;
        sides[side as usize].map(|f| f as usize)
    }

    /// Area of all faces, m².
    pub fn area(&self) -> f64 {
        self.faces.iter().map(|f| f.area).sum()
    }

    /// Whether there are so many sides that rays take part.
    pub fn is_crowded(&self) -> bool {
        self.faces.len() > MANY_SIDES
    }

    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.faces.iter().map(|f| f.mesh.elements.len()).sum()
    }

    /// The share of the light that is lost with each bounce, roughly (never 0: what no surface absorbs leaves by some opening,
    /// or nothing can be said of it).
    pub fn loss(&self) -> f64 {
        loss(self.mean_reflectance())
    }

    /// Area-weighted mean reflectance (largest channel), 0…1.
    pub fn mean_reflectance(&self) -> f64 {
        let area = self.area();
        let reflected: f64 = self
            .faces
            .iter()
            .map(|f| f.area * f.reflectance.0.max_element())
            .sum();
        if area > 0.0 { reflected / area } else { 0.0 }
    }
}

/// The share of the light that is lost with each bounce where this is the mean reflectance (0…1), never 0.
pub(crate) fn loss(mean_reflectance: f64) -> f64 {
    (1.0 - mean_reflectance).max(LEAST_LOSS)
}

/// Points `spacing` apart along an edge, [`EDGE_ROW`] of that inside the face; none beside an edge that is shorter.
fn row_beside(
    domain: &FaceDomain,
    [a, b]: [DVec2; 2],
    spacing: f64,
) -> impl Iterator<Item = GridPoint> + '_ {
    let length = a.distance(b);
    let count = (length / spacing).ceil().max(1.0) as u32;
    let across = (b - a).perp() * (EDGE_ROW * spacing / length);
    (1..count).filter_map(move |i| {
        let on_edge = a.lerp(b, f64::from(i) / f64::from(count));
        // The face lies on one side of its edge, or on both where it runs along it twice.
        [on_edge + across, on_edge - across]
            .into_iter()
            .find(|&p| domain.polygon().contains(p))
            .map(|p| domain.grid.snap(p))
    })
}

/// Points half of `spacing` apart along the projection of a rim; none where the outline is closer than the rim itself.
fn row_along(
    domain: &FaceDomain,
    rim: [DVec3; 2],
    spacing: f64,
) -> impl Iterator<Item = GridPoint> + '_ {
    let [a, b] = rim.map(|p| domain.frame.to_plane(p));
    let plane = domain.frame.plane();
    let height = rim.map(|p| plane.distance(p).abs());
    let height = height[0].max(height[1]);
    let count = (2.0 * a.distance(b) / spacing).ceil().max(1.0) as u32;
    (0..=count)
        .map(move |i| a.lerp(b, f64::from(i) / f64::from(count)))
        .filter(move |&p| {
            domain.polygon().contains(p) && domain.polygon().distance_to_outline(p) > height
        })
        .map(|p| domain.grid.snap(p))
}

impl SolveFace {
    fn new(
        domain: Arc<FaceDomain>,
        points: &[GridPoint],
        reflectance: Rgb,
        spacing: f64,
    ) -> Result<Self, MeshError> {
        let outline = domain.mesh(&[], &[])?;
        let mesh = domain.mesh(&[], points)?;
        let (lo, hi) = domain.polygon().bounds();
        let mut rectangle = [lo, DVec2::new(hi.x, lo.y), hi, DVec2::new(lo.x, hi.y)]
            .map(|p| domain.frame.to_space(p));
        if domain.side == FaceSide::Back {
            rectangle.reverse();
        }
        let centre = domain.frame.to_space(0.5 * (lo + hi));
        let radius = 0.5 * lo.distance(hi);
        let largest =
            (0..mesh.elements.len()).max_by(|&a, &b| mesh.area(a).total_cmp(&mesh.area(b)));
        Ok(Self {
            plane: Plane::new(domain.frame.origin, domain.normal),
            roots: (0..outline.elements.len())
                .map(|e| outline.corners(e))
                .collect(),
            locator: Locator::new(&mesh),
            centre,
            radius,
            is_small: radius < SMALL_SHARE * spacing,
            area: (0..mesh.elements.len()).map(|e| mesh.area(e)).sum(),
            middle_point: largest.map_or(centre, |e| domain.frame.to_space(mesh.centre(e))),
            rectangle,
            domain,
            mesh,
            reflectance,
        })
    }

    /// Reflectance at frame coordinates `p`.
    pub(super) fn reflectance_at(&self, p: DVec2) -> Rgb {
        let pattern = self.domain.pattern.as_ref();
        pattern.map_or(self.reflectance, |pattern| pattern.at(p))
    }

    /// A bound of the form factor of the whole face as seen from `view` (0…1); 0 when it is not seen. `roundoff` (metres)
    /// is how far in front of the face's plane a point must lie to be in front of it.
    pub(super) fn largest_form_factor(&self, view: &Viewpoint, roundoff: f64) -> f64 {
        let across = self.plane.distance(view.position);
        if across <= roundoff {
            return 0.0;
        }
        let d = self.centre - view.position;
        let above = view.horizon.normal.dot(d) + self.radius;
        if above <= 0.0 {
            return 0.0;
        }
        let nearest = (d.length() - self.radius).max(across);
        let cosines = (above / nearest).min(1.0) * (across / nearest).min(1.0);
        (self.area * cosines / (PI * nearest * nearest)).min(1.0)
    }

    /// A convex region that holds every line of sight from `view` to this face: the pyramid over its bounding rectangle.
    pub(super) fn region(&self, view: &Viewpoint) -> Region {
        Region::pyramid(view.position, &self.rectangle)
    }

    /// [`SPREAD_POINTS`] points, one in each equal share of its area, frame coordinates.
    pub(super) fn spread_points(&self) -> impl Iterator<Item = DVec2> + '_ {
        let mut element = 0;
        let mut before = 0.0;
        (0..SPREAD_POINTS).map(move |i| {
            let at = self.area * (f64::from(i) + 0.5) / f64::from(SPREAD_POINTS);
            while before + self.mesh.area(element) < at && element + 1 < self.mesh.elements.len() {
                before += self.mesh.area(element);
                element += 1;
            }
            even_point_in(self.mesh.corners(element), i)
        })
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
