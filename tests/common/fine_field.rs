//! Indirect light from a solution of its own, finer than the one under test and without its display mesh.

use rayon::prelude::*;
use umbrage::mesh::FaceDomain;
use umbrage::pipeline::Solution;
use umbrage::quantity::{Irradiance, Radiosity};
use umbrage::radiosity::{Bounces, Gatherer, LightSample, SolveMesh, Transport, project};
use umbrage::visibility::{Blockers, Scratch, Viewpoint};

/// The direct light of an element is sampled at so many points along each of its sides.
const SAMPLES_A_SIDE: usize = 4;

/// A converged solution on `elements` elements.
pub(crate) struct FineField<'a> {
    mesh: SolveMesh,
    radiosity: Vec<Radiosity>,
    means: Vec<Radiosity>,
    blockers: &'a Blockers,
}

/// The error for which the fine mesh is made: faces are hardly ever judged by a ray.
const FINE_ERROR: f64 = 1e-4;

impl<'a> FineField<'a> {
    /// Solves on about `elements` elements over the same sides as `solution`; `None` when that has no indirect light.
    pub(crate) fn new(solution: &Solution<'a>, elements: f64) -> Option<Self> {
        let scene = &solution.world.scene;
        let coarse = solution.indirect.as_ref()?.mesh();
        let area: f64 = coarse
            .faces
            .iter()
            .map(|f| scene.faces[f.domain.face].area)
            .sum();
        let domains = coarse
            .faces
            .iter()
            .map(|f| {
                let (face, side) = (f.domain.face, f.domain.side);
                let receiver = solution
                    .receivers
                    .iter()
                    .find(|r| (r.domain.face, r.domain.side) == (face, side))
                    .expect("every side of the solve mesh is a receiver");
                let lines = &receiver.lines;
                let domain =
                    FaceDomain::new(scene, face, side, &lines.contacts, &[], &lines.covers);
                (domain, f.reflectance)
            })
            .collect();
        let spacing = (area / (0.433 * elements)).sqrt();
        let mesh = SolveMesh::new(domains, spacing, FINE_ERROR).expect("the scene can be meshed");
        let blockers = &solution.world.blockers;
        let transport = Transport::new(&mesh, blockers);
        let direct = direct_light(&mesh, solution);
        let (radiosity, _) = transport.solve(&mesh, &direct, Bounces::All, 1e-9);
        Some(Self {
            means: transport.face_means(&radiosity),
            radiosity,
            mesh,
            blockers,
        })
    }

    /// A gatherer for [`FineField::irradiance`].
    pub(crate) fn gatherer(&self) -> Gatherer<'_> {
        Gatherer::new(&self.mesh, self.blockers)
    }

    /// Indirect irradiance at `view`, W/m².
    pub(crate) fn irradiance(&self, gatherer: &mut Gatherer, view: &Viewpoint) -> Irradiance {
        let row = gatherer.row(view);
        let mut sum = Irradiance::ZERO;
        for (s, w) in row.sites {
            sum += Irradiance(self.radiosity[s as usize].0 * w);
        }
        for (f, w) in row.faces {
            sum += Irradiance(self.means[f as usize].0 * w);
        }
        sum
    }
}

/// Exact direct light at a regular set of points of each element, projected to the sites.
fn direct_light(mesh: &SolveMesh, solution: &Solution) -> Vec<Irradiance> {
    let n = SAMPLES_A_SIDE;
    let samples: Vec<LightSample> = mesh
        .faces
        .par_iter()
        .enumerate()
        .flat_map_iter(|(f, face)| {
            let mut scratch = Scratch::default();
            let mut found = Vec::new();
            for e in 0..face.mesh.elements.len() {
                let [a, b, c] = face.mesh.corners(e);
                let area = face.mesh.area(e) / (n * n) as f64;
                // Middles of the n² triangles that the element is divided into.
                for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
                    for third in [1.0, 2.0] {
                        if third == 2.0 && i + j + 2 > n {
                            continue;
                        }
                        let [u, v] = [i, j].map(|k| (k as f64 + third / 3.0) / n as f64);
                        let point = a + (b - a) * u + (c - a) * v;
                        let view = face.view(point);
                        found.push(LightSample {
                            face: f as u32,
                            point,
                            area,
                            irradiance: solution.direct.irradiance(&view, &mut scratch),
                        });
                    }
                }
            }
            found
        })
        .collect();
    project(mesh, samples.into_iter(), |_, _| Irradiance::ZERO)
}
