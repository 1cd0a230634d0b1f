//! Classic radiosity of a room that is known on paper, geometry and all.

use super::cells::{FaceCells, FaceLight, FollowLimits, follow_all};
use super::clusters::Sources;
use super::gather::Oracle;
use super::solve::{Method, Transport};
use super::{Basis, Bounces, SolveMesh, Solver};
use crate::mesh::FaceDomain;
use crate::quantity::{Radiosity, Rgb};
use crate::scene::{CleanSettings, FaceSide, Material, RawPolygon, RawScene, Scene, clean};
use crate::visibility::Blockers;
use glam::DVec3;

/// A unit cube seen from inside, its first face the ceiling.
pub(super) fn cube(rho: f64) -> Scene {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let faces = [
        [2, 3, 7, 6],
        [0, 4, 5, 1],
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    let corners = (0..8).map(corner).collect();
    scene_of(corners, faces.map(Vec::from).into(), rho)
}

/// Polygons of one reflectance.
pub(super) fn scene_of(positions: Vec<DVec3>, polygons: Vec<Vec<u32>>, rho: f64) -> Scene {
    let polygon = |corners| RawPolygon {
        corners,
        material: 0,
        group: 0,
    };
    let raw = RawScene {
        source: "test".to_owned(),
        positions,
        polygons: polygons.into_iter().map(polygon).collect(),
        materials: vec![Material {
            name: "wall".to_owned(),
            reflectance: Rgb::grey(rho),
            ..Material::default()
        }],
        groups: vec!["polygons".to_owned()],
        ..RawScene::default()
    };
    clean(&raw, &CleanSettings::default()).expect("a scene").0
}

/// The fronts of a scene, all of one reflectance, with points `spacing` metres apart.
pub(super) fn mesh_of(scene: &Scene, rho: f64, spacing: f64) -> SolveMesh {
    let sides = scene.faces.ids().map(|f| {
        let domain = FaceDomain::new(scene, f, FaceSide::Front, &[], &[], &[]);
        (domain.into(), Rgb::grey(rho))
    });
    SolveMesh::new(sides.collect(), spacing).expect("a clean scene can be meshed")
}

/// Random numbers 0…1 (Steele, Lea & Flood 2014, SplitMix64).
pub(super) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Wider than the faces of the cube: each is one element.
const WIDE: f64 = 2.0;

/// The mesh of the cube.
pub(super) fn cube_mesh(rho: f64) -> SolveMesh {
    mesh_of(&cube(rho), rho, WIDE)
}

#[test]
fn one_element_a_face_lights_the_cube() {
    let text = include_str!("../../fixtures/analytic/cube.txt");
    for line in text.lines().filter(|l| l.starts_with("cube")) {
        let words = line.split_whitespace().skip(1);
        let known: Vec<f64> = words.map(|w| w.parse().expect("a number")).collect();
        let [rho, ceiling, floor, wall] = known[..] else {
            panic!("{line}");
        };
        let scene = cube(rho);
        let blockers = Blockers::new(&scene);
        let mesh = mesh_of(&scene, rho, WIDE);
        let cells = |f| FaceCells::new(f, mesh.spacing, Basis::Constant);
        let mut trees: Vec<FaceCells> = mesh.faces.iter().map(cells).collect();
        let is_up = |f: usize| mesh.faces[f].domain.normal.y < -0.5;
        let limits = FollowLimits {
            error: 1.0,
            smallest: 1.0,
        };
        let sent: Vec<FaceLight> = follow_all(&mut trees, &mesh.faces, limits, |f, _| {
            Radiosity(Rgb::grey(f64::from(u8::from(is_up(f)))))
        });
        let oracle = Oracle {
            sources: &Sources::new(&mesh, sent.clone(), 1.0),
            link: 0.0,
            ray: 0.0,
            sweep: None,
        };
        let transport =
            Transport::new(&mesh, &trees, &blockers, &oracle, Basis::Constant, |_| None);
        for solver in Solver::ALL {
            let method = Method {
                solver,
                bounces: Bounces::All,
                tolerance: 1e-11,
            };
            let solved = transport.solve(&mesh, &sent, method);
            let solved = solved.expect("six unknowns");
            assert_eq!(solved.report.nodes, 6);
            for (f, e) in solved.values.iter().enumerate() {
                let normal = mesh.faces[f].domain.normal.y;
                let (own, expected) = match normal {
                    y if y < -0.5 => (1.0, ceiling),
                    y if y > 0.5 => (0.0, floor),
                    _ => (0.0, wall),
                };
                let found = own + rho * e.mean();
                assert!(
                    (found - expected).abs() <= 1e-9,
                    "{} at ρ = {rho}: {found} for {expected}",
                    solver.name()
                );
            }
        }
    }
}
