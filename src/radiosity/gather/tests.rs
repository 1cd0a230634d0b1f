//! Gathers by rays against gathers by exact cutting.

use super::*;
use crate::mesh::FaceDomain;
use crate::quantity::{Radiosity, Rgb};
use crate::radiosity::Basis;
use crate::radiosity::cells::{FollowLimits, follow_all};
use crate::radiosity::sweep::RAYS;
use crate::scene::{CleanSettings, FaceSide, Material, RawPolygon, RawScene, Scene, clean};

const REFLECTANCE: f64 = 0.5;

/// Plates along each edge of the room.
const PLATES: usize = 5;

/// A room of 1 m with a lattice of plates that hang in it, each turned its own way.
fn scene() -> Scene {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let mut positions: Vec<DVec3> = (0..8).map(corner).collect();
    let mut faces: Vec<Vec<u32>> = [
        [2, 3, 7, 6],
        [0, 4, 5, 1],
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ]
    .map(Vec::from)
    .into();
    for i in 0..PLATES.pow(3) {
        let at = [i % PLATES, i / PLATES % PLATES, i / PLATES.pow(2)].map(|k| k as f64 + 0.5);
        let turn = i as f64;
        let n = DVec3::new(turn.sin(), turn.cos(), (0.7 * turn).sin()).normalize();
        let u = n.any_orthonormal_vector() * 0.07;
        let v = n.cross(u);
        let middle = DVec3::from(at) / PLATES as f64;
        let first = positions.len() as u32;
        positions.extend([-u - v, u - v, u + v, v - u].map(|d| middle + d));
        faces.push((first..first + 4).collect());
    }
    let polygon = |corners| RawPolygon {
        corners,
        material: 0,
        group: 0,
    };
    let raw = RawScene {
        source: "plates".to_owned(),
        positions,
        polygons: faces.into_iter().map(polygon).collect(),
        materials: vec![Material {
            name: "grey".to_owned(),
            reflectance: Rgb::grey(REFLECTANCE),
            reflects_back: true,
            ..Material::default()
        }],
        groups: vec!["room".to_owned()],
        ..RawScene::default()
    };
    clean(&raw, &CleanSettings::default()).expect("a room").0
}

/// Irradiance at a point of each wall and plate.
fn gathered(
    mesh: &SolveMesh,
    trees: &[FaceCells],
    blockers: &Blockers,
    oracle: &Oracle,
) -> Vec<f64> {
    let mut gatherer = Gatherer::new(mesh, trees, blockers);
    mesh.faces
        .iter()
        .map(|face| {
            let view = face.view(face.mesh.centre(0));
            let mut sum = 0.0;
            gatherer.visit(&view, oracle, &mut |f, c, weights| {
                let corners = &oracle.sources.faces[f].cells[c].corners;
                let sent = corners.iter().zip(weights).map(|(b, w)| b.mean() * w);
                sum += sent.sum::<f64>();
            });
            sum
        })
        .collect()
}

#[test]
fn rays_and_cutting_are_as_good_as_they_say() {
    let scene = scene();
    let blockers = Blockers::new(&scene);
    let sides = scene.faces.ids().flat_map(|f| {
        [FaceSide::Front, FaceSide::Back].map(|side| {
            let domain = FaceDomain::new(&scene, f, side, &[], &[], &[]);
            (domain.into(), Rgb::grey(REFLECTANCE))
        })
    });
    let mesh = SolveMesh::new(sides.collect(), 0.25).expect("it can be meshed");
    assert!(mesh.is_crowded());
    let tree = |f| FaceCells::new(f, mesh.spacing, Basis::Linear);
    let mut trees: Vec<FaceCells> = mesh.faces.iter().map(tree).collect();
    let limits = FollowLimits {
        error: 0.05,
        smallest: 0.05,
    };
    // Plates of all strengths, one in seven of them bright; walls brighter towards one corner.
    let sent = follow_all(&mut trees, &mesh.faces, limits, |f, p| {
        let own = (f as f64 * 0.618).fract();
        let bright = if f % 7 == 0 { 20.0 } else { 1.0 };
        Radiosity(Rgb::grey(own * bright + 0.3 * p.length_squared()))
    });
    let sources = Sources::new(&mesh, sent, 0.0);
    let of = |error: f64| Oracle {
        sources: &sources,
        link: error,
        ray: error,
        sweep: (error > 0.0).then_some(Sweep {
            noise: error,
            together: f64::INFINITY,
            rays: RAYS,
        }),
    };
    let known = gathered(&mesh, &trees, &blockers, &of(0.0));
    let mut last = f64::INFINITY;
    for error in [0.1, 0.01, 0.001] {
        let found = gathered(&mesh, &trees, &blockers, &of(error));
        let squares = known.iter().zip(&found).map(|(k, f)| (k - f).powi(2));
        let rms = (squares.sum::<f64>() / known.len() as f64).sqrt();
        // A dozen parts in half view are each off by so much.
        assert!(rms <= 4.0 * error, "{rms} for {error}");
        assert!(rms < 0.5 * last, "{rms} after {last}");
        last = rms;
    }
    // None is cut however bright it is: then the rays have to agree among themselves.
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    for share in [0.03, 0.01] {
        let together = share * mean;
        let oracle = Oracle {
            sweep: Some(Sweep {
                noise: f64::INFINITY,
                together,
                rays: RAYS,
            }),
            ..of(0.001)
        };
        let found = gathered(&mesh, &trees, &blockers, &oracle);
        let squares = known.iter().zip(&found).map(|(k, f)| (k - f).powi(2));
        let rms = (squares.sum::<f64>() / known.len() as f64).sqrt();
        // Four runs tell their own spread to a factor of about two.
        assert!(
            (0.1..2.0).contains(&(rms / together)),
            "{rms} for {together}"
        );
    }
}
