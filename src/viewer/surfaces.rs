//! The surfaces of a page: one list of vertices and triangles, part after part.

use crate::adapt::Illumination;
use crate::bad_input::BadInput;
use crate::lit_scene::{LitMesh, LitScene};
use crate::pipeline::Solution;
use crate::quantity::{Irradiance, Radiance, Rgb};
use crate::render::LitModel;
use crate::scene::{FaceId, FaceSide};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Triangles that share a material, and a side of a face where faces are known.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct PartOnPage {
    pub(super) name: String,
    pub(super) material: String,
    pub(super) face: Option<u32>,
    pub(super) side: &'static str,
    pub(super) reflectance: [f64; 3],
    pub(super) exitance: [f64; 3],
    pub(super) is_double_sided: bool,
    pub(super) first_triangle: usize,
    pub(super) triangles: usize,
}

/// All that is drawn of the surfaces. Positions are metres, local; triangles counter-clockwise seen from the lit side.
#[derive(Default)]
pub(super) struct Surfaces {
    pub(super) parts: Vec<PartOnPage>,
    pub(super) positions: Vec<DVec3>,
    pub(super) colours: Vec<Rgb>,
    pub(super) irradiance: Vec<Irradiance>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// m².
    pub(super) areas: Vec<f64>,
    pub(super) errors: Option<Vec<f64>>,
    /// Mean irradiance and area of each triangle that does not emit.
    pub(super) light: Vec<(Irradiance, f64)>,
}

impl Surfaces {
    pub(super) fn bounds(&self) -> Option<[DVec3; 2]> {
        let all = || self.positions.iter().copied();
        Some([all().reduce(DVec3::min)?, all().reduce(DVec3::max)?])
    }

    /// Adds the triangles of one part, whose vertices come next.
    fn add(&mut self, mut part: PartOnPage, positions: &[DVec3], triangles: &[[u32; 3]]) {
        part.first_triangle = self.triangles.len();
        part.triangles = triangles.len();
        let first =
            u32::try_from(self.positions.len()).expect("a page has fewer than 2³² vertices");
        self.positions.extend_from_slice(positions);
        for t in triangles {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            self.areas.push(0.5 * (b - a).cross(c - a).length());
            self.triangles.push(t.map(|i| first + i));
        }
        self.parts.push(part);
    }

    fn add_light(&mut self) {
        for part in self.parts.iter().filter(|p| p.exitance == [0.0; 3]) {
            for t in part.first_triangle..part.first_triangle + part.triangles {
                let [a, b, c] = self.triangles[t].map(|i| self.irradiance[i as usize]);
                self.light.push(((a + b + c) * (1.0 / 3.0), self.areas[t]));
            }
        }
    }
}

/// The surfaces of a lit file, relative to `origin`.
pub(super) fn of_model(model: &LitModel, origin: DVec3) -> Result<Surfaces, BadInput> {
    let mut all = Surfaces::default();
    for part in model.parts.iter().filter(|p| !p.triangles.is_empty()) {
        let on_page = PartOnPage {
            name: part.node.clone(),
            material: part.material.clone(),
            face: None,
            side: "",
            reflectance: part
                .emitter
                .map_or(part.base_colour, |e| e.reflectance)
                .to_array(),
            exitance: part.emitter.map_or([0.0; 3], |e| e.exitance.0.to_array()),
            is_double_sided: part.is_double_sided,
            first_triangle: 0,
            triangles: 0,
        };
        let positions: Vec<DVec3> = part.positions.iter().map(|p| *p - origin).collect();
        all.add(on_page, &positions, &part.triangles);
        for (i, colour) in part.colours.iter().enumerate() {
            all.colours.push(*colour * part.base_colour);
            all.irradiance
                .push(model.irradiance(part, i).ok_or_else(|| {
                    BadInput::new(
                        &model.source,
                        "does not state its exposure, so its colours are no light in W/m²",
                        "bake it again with umbrage",
                    )
                })?);
        }
    }
    all.add_light();
    Ok(all)
}

/// The surfaces of a lit world, with the error at the middle of each triangle.
pub(super) fn of_solution(solution: &Solution) -> Surfaces {
    let lit = solution.lit_scene();
    let scene = &solution.world.scene;
    let mut all = Surfaces::default();
    for mesh in &lit.meshes {
        let material = &lit.materials[mesh.material as usize];
        let face = FaceId(mesh.face);
        let part = PartOnPage {
            name: lit.groups[mesh.group as usize].clone(),
            material: material.name.clone(),
            face: Some(mesh.face),
            side: match side_of(solution, mesh) {
                FaceSide::Front => "front",
                FaceSide::Back => "back",
            },
            reflectance: scene.material_of(face).reflectance.to_array(),
            exitance: mesh.exitance.0.to_array(),
            is_double_sided: false,
            first_triangle: 0,
            triangles: 0,
        };
        all.add(part, &mesh.positions, &mesh.triangles);
        all.irradiance.extend_from_slice(&mesh.irradiance);
        all.colours
            .extend((0..mesh.positions.len()).map(|i| colour(&lit, mesh, i)));
    }
    all.add_light();
    all.errors = Some(
        lit.meshes
            .iter()
            .flat_map(|mesh| errors(solution, mesh))
            .collect(),
    );
    all
}

fn side_of(solution: &Solution, mesh: &LitMesh) -> FaceSide {
    let front = solution
        .world
        .scene
        .normal(FaceId(mesh.face), FaceSide::Front);
    if front.dot(mesh.normal) > 0.0 {
        FaceSide::Front
    } else {
        FaceSide::Back
    }
}

/// What a viewer of the lit file shows at vertex `i`: base colour × `COLOR_0`, linear.
fn colour(lit: &LitScene, mesh: &LitMesh, i: usize) -> Rgb {
    let exposed = |light: Radiance| Rgb((light.0.0 * lit.exposure).clamp(DVec3::ZERO, DVec3::ONE));
    if mesh.exitance.0.is_black() {
        exposed(Radiance(mesh.irradiance[i].0 * (1.0 / PI))) * mesh.reflectance
    } else {
        exposed(mesh.radiosity(i).to_radiance())
    }
}

/// RMS over the channels of shown − known light at the middle of each triangle, over the mean irradiance.
///
/// Direct light is exact there, indirect light that of the solution.
fn errors(solution: &Solution, mesh: &LitMesh) -> Vec<f64> {
    let key = (FaceId(mesh.face), side_of(solution, mesh));
    let receivers = &solution.receivers;
    let found = receivers.binary_search_by_key(&key, |r| (r.domain.face, r.domain.side));
    let mean = solution.summary.measured.mean;
    let Some(receiver) = found
        .ok()
        .map(|i| &receivers[i])
        .filter(|r| r.is_lit && mean > 0.0)
    else {
        return vec![0.0; mesh.triangles.len()];
    };
    let light = Illumination {
        direct: &solution.direct,
        tolerance: 0.0,
        indirect: solution.indirect.as_ref(),
    };
    mesh.triangles
        .par_iter()
        .map(|t| {
            let middle = t.iter().map(|&i| mesh.positions[i as usize]).sum::<DVec3>() / 3.0;
            let [a, b, c] = t.map(|i| mesh.irradiance[i as usize]);
            let shown = (a + b + c) * (1.0 / 3.0);
            let known = receiver.total(&light, receiver.domain.frame.to_plane(middle));
            (shown - known).0.mean_square().sqrt() / mean
        })
        .collect()
}
