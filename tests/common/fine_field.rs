//! Indirect light from a solution of its own, finer than the one under test and without its display mesh.

use glam::DVec2;
use umbrage::pipeline::Solution;
use umbrage::quantity::Irradiance;
use umbrage::radiosity::{
    Basis, Bounces, Gatherer, IndirectField, Linking, Request, SolveFace, SolveMesh, Solver,
};
use umbrage::visibility::{Scratch, Viewpoint};

/// The error for which the fine solution is made, relative to the mean irradiance.
const FINE_ERROR: f64 = 5e-4;

/// The solution is corrected by its own residual so many times: each leaves at most the reflectance's share of the error.
const CORRECTIONS: usize = 3;

/// A solve mesh of about `elements` elements over the same sides as that of `solution`; `None` where it has none.
pub(crate) fn solve_mesh(solution: &Solution, elements: f64) -> Option<SolveMesh> {
    let scene = &solution.world.scene;
    let faces = &solution.indirect.as_ref()?.mesh().faces;
    let area: f64 = faces.iter().map(|f| scene.faces[f.domain.face].area).sum();
    let domains = faces
        .iter()
        .map(|f| {
            let (face, side) = (f.domain.face, f.domain.side);
            let receiver = solution
                .receivers
                .iter()
                .find(|r| (r.domain.face, r.domain.side) == (face, side))
                .expect("every side of the solve mesh is a receiver");
            (receiver.domain.clone(), f.reflectance)
        })
        .collect();
    let spacing = (area / (0.433 * elements)).sqrt();
    Some(SolveMesh::new(domains, spacing).expect("the scene can be meshed"))
}

/// Exact direct light at frame coordinates `p` of a face, W/m².
pub(crate) fn direct_at(solution: &Solution, face: &SolveFace, p: DVec2) -> Irradiance {
    let view = face.view(p);
    solution.direct.irradiance(&view, &mut Scratch::default())
}

/// A converged solution on `elements` elements and many more cells.
pub(crate) struct FineField<'a> {
    field: IndirectField<'a>,
}

impl<'a> FineField<'a> {
    /// Solves on about `elements` elements over the same sides as `solution`; `None` when that has no indirect light.
    pub(crate) fn new(solution: &Solution<'a>, elements: f64) -> Option<Self> {
        Self::to_error(solution, elements, FINE_ERROR)
    }

    /// The same to an error of one's own, relative to the mean irradiance.
    pub(crate) fn to_error(
        solution: &Solution<'a>,
        elements: f64,
        relative_error: f64,
    ) -> Option<Self> {
        let coarse = solution.indirect.as_ref()?;
        let mesh = solve_mesh(solution, elements)?;
        let direct = |face: &SolveFace, _: usize, p: DVec2| direct_at(solution, face, p);
        let error = relative_error * solution.summary.measured.mean;
        let request = Request {
            error,
            ambient: coarse.mean(),
            bounces: Bounces::All,
            tolerance: 1e-7,
            basis: Basis::default(),
            linking: Linking::default(),
            solver: Solver::default(),
        };
        let blockers = &solution.world.blockers;
        let (mut field, _) = IndirectField::solve(mesh, blockers, request, direct)
            .expect("the default solver has no limit");
        for _ in 0..CORRECTIONS {
            field
                .refine(3.0 * error, || false, |_| true)
                .expect("the faces can be meshed");
            field.correct(direct);
        }
        Some(Self { field })
    }

    /// What was solved.
    pub(crate) fn field(&self) -> &IndirectField<'a> {
        &self.field
    }

    /// A gatherer for [`FineField::irradiance`].
    pub(crate) fn gatherer(&self) -> Gatherer<'_> {
        self.field.gatherer()
    }

    /// Indirect irradiance at `view`, W/m².
    pub(crate) fn irradiance(&self, gatherer: &mut Gatherer, view: &Viewpoint) -> Irradiance {
        self.field.gather(gatherer, view)
    }
}
