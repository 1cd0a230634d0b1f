use super::super::random::Random;
use super::super::screen::Screen;
use super::super::{Blockers, Cones, Region, Viewpoint};
use crate::geom::Plane;
use crate::scene::{CleanSettings, FaceId, Material, RawPolygon, RawScene, Scene, clean};
use glam::{DQuat, DVec3};

/// The faces of a box, corner number `x + 2 y + 4 z`, counter-clockwise from outside: left, right, bottom, top, back, front.
const FACES: [[u32; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

#[derive(Default)]
struct Builder(RawScene);

impl Builder {
    /// Adds the given faces of a box; turned inside out on request.
    fn add(&mut self, centre: DVec3, half: DVec3, turn: DQuat, faces: &[usize], is_room: bool) {
        let first = self.0.positions.len() as u32;
        for i in 0..8 {
            let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let corner = DVec3::new(sign(0), sign(1), sign(2)) * half;
            self.0.positions.push(centre + turn * corner);
        }
        for &f in faces {
            let mut corners = FACES[f].map(|c| first + c).to_vec();
            if is_room {
                corners.reverse();
            }
            self.0.polygons.push(RawPolygon {
                corners,
                material: 0,
                group: 0,
            });
        }
    }

    fn scene(mut self) -> Scene {
        self.0.materials = vec![Material::default()];
        self.0.groups = vec!["all".to_owned()];
        clean(&self.0, &CleanSettings::default())
            .expect("boxes are clean")
            .0
    }
}

/// A room, boxes in it of which some have no bottom or neither top nor bottom, and one with its lid ajar.
fn boxes(random: &mut Random) -> Scene {
    let mut builder = Builder::default();
    let all = [0, 1, 2, 3, 4, 5];
    builder.add(DVec3::ZERO, DVec3::splat(4.0), DQuat::IDENTITY, &all, true);
    for (i, faces) in [
        &all[..],
        &[0, 1, 3, 4, 5],
        &[0, 1, 4, 5],
        &all[..],
        &[0, 1, 4],
    ]
    .iter()
    .enumerate()
    {
        let centre = DVec3::new(i as f64 * 1.2 - 2.4, 0.0, 0.0) + random.point(0.2);
        let turn = DQuat::from_scaled_axis(random.point(1.0));
        let half = DVec3::splat(0.15) + random.point(0.1);
        builder.add(centre, half, turn, faces, false);
    }
    builder.scene()
}

#[test]
fn boxes_are_solids_and_rooms_are_not() {
    let scene = boxes(&mut Random(3));
    let blockers = Blockers::new(&scene);
    // The last one, with three faces, has no flat lid.
    let faces: Vec<usize> = blockers
        .screens
        .solids
        .iter()
        .map(|s| s.parts.len())
        .collect();
    assert_eq!(faces, [6, 5, 4, 6]);
    assert_eq!(blockers.screen_count(), 4 + 6 + 3);
}

/// A target that is no face of the scene.
struct Window {
    plane: Plane,
    corners: [DVec3; 4],
}

/// Somewhere in the room, facing `eye` (else none); often it cuts through boxes.
fn window(random: &mut Random, eye: DVec3) -> Option<Window> {
    let middle = random.point(2.5);
    let normal = (eye - middle + random.point(1.0)).try_normalize()?;
    if normal.dot(eye - middle) < 0.1 {
        return None;
    }
    let (u, v) = normal.any_orthonormal_pair();
    // u × v = normal: counter-clockwise seen from the eye's side.
    let corners = [-u - v, u - v, u + v, -u + v].map(|d| middle + d * 0.8);
    Some(Window {
        plane: Plane::new(middle, normal),
        corners,
    })
}

#[test]
fn cones_hide_what_rays_do_not_reach() {
    let mut random = Random(11);
    let (mut hidden, mut seen, mut solids) = (0, 0, 0);
    for _ in 0..20 {
        let scene = boxes(&mut random);
        let blockers = Blockers::new(&scene);
        let mut cones = Cones::default();
        for _ in 0..40 {
            let eye = random.point(3.0);
            let Some(window) = window(&mut random, eye) else {
                continue;
            };
            let view = Viewpoint::new(eye, -window.plane.normal);
            let base = window.corners.map(|c| c - eye);
            let mut screens = Vec::new();
            let region = Region::pyramid(eye, &window.corners);
            blockers.collect_screens(&view, &region, window.plane, &mut screens);
            let is_solid =
                |&&s: &&u32| matches!(blockers.screens.all[s as usize], Screen::Solid(_));
            solids += screens.iter().filter(is_solid).count();
            blockers.cones(&screens, &view, window.plane, &base, &mut cones);
            for _ in 0..20 {
                let (s, t) = (random.next(), random.next());
                let [a, b, _, d] = window.corners;
                let p = a + (b - a) * s + (d - a) * t;
                let is_hidden = cones.iter().any(|c| c.hides(p - eye));
                let is_seen = blockers.sees(&view, p, FaceId(u32::MAX));
                assert_eq!(is_hidden, !is_seen, "from {eye} to {p}");
                if is_hidden { hidden += 1 } else { seen += 1 }
            }
        }
    }
    assert!(
        hidden > 100 && seen > 1000 && solids > 100,
        "{hidden} {seen} {solids}"
    );
}
