//! Which sides show the light that reaches them, and about how much there is.

use super::World;
use crate::direct::DirectLight;
use crate::discontinuity::{EventKind, FaceLines, LineMap};
use crate::geom::even_point_in;
use crate::radiosity::reached;
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;

/// How far beside a line light is looked for, as a share of its length.
const BESIDE_SHARE: f64 = 0.01;

/// Points that tell how strong the direct light is in the mean: to some ten per cent of it.
const GUESS_POINTS: u32 = 1024;

/// Which sides show light that reaches them: directly (it shows at coarse points, or draws a line), or by way of other
/// sides. A lamp that reflects nothing shows its own light alone.
pub(super) fn lit_sides(
    world: &World,
    direct: &DirectLight,
    lines: &LineMap,
    sides: &[(FaceId, FaceSide)],
    with_bounces: bool,
) -> Vec<bool> {
    let scene = &world.scene;
    let views: Vec<Vec<Viewpoint>> = sides
        .iter()
        .map(|&(face, side)| views(scene, face, side))
        .collect();
    let beside: Vec<Vec<Viewpoint>> = sides
        .par_iter()
        .map(|&(face, side)| beside_lines(scene, lines.of(face, side)))
        .collect();
    let spread = |lit: Vec<bool>| match with_bounces {
        true => reached(&world.blockers, sides, &views, &lit),
        false => lit,
    };
    let points = |i: usize| views[i].iter().chain(&beside[i]);
    let mut lit = spread(
        (0..sides.len())
            .into_par_iter()
            .map_init(Scratch::default, |scratch, i| {
                shows_emitter(direct, points(i), scratch)
            })
            .collect(),
    );
    // Exact cutting is dear, and few sides are left to it.
    let found: Vec<bool> = (0..sides.len())
        .into_par_iter()
        .map_init(Scratch::default, |scratch, i| {
            !lit[i] && shows_part_of_emitter(direct, points(i), scratch)
        })
        .collect();
    if found.contains(&true) {
        lit = spread(lit.iter().zip(found).map(|(&a, b)| a || b).collect());
    }
    for (lit, &(face, _)) in lit.iter_mut().zip(sides) {
        *lit &= !scene.faces[face].is_pure_emitter();
    }
    lit
}

/// The middles of a side's triangles.
fn views(scene: &Scene, face: FaceId, side: FaceSide) -> Vec<Viewpoint> {
    let f = &scene.faces[face];
    let middle = |t: &[_; 3]| t.map(|v| scene.vertices[v]).iter().sum::<DVec3>() / 3.0;
    let on_plane = |p: DVec3| f.frame.to_space(f.frame.to_plane(p));
    f.triangles
        .iter()
        .map(|t| Viewpoint::new(on_plane(middle(t)), scene.normal(face, side)))
        .collect()
}

/// Whether one of the viewpoints sees the middle of an emitter: most that is lit does.
fn shows_emitter<'v>(
    direct: &DirectLight,
    mut views: impl Iterator<Item = &'v Viewpoint>,
    scratch: &mut Scratch,
) -> bool {
    views.any(|v| direct.by_rays(v, scratch).mean() > 0.0)
}

/// Whether one of the viewpoints sees any of an emitter.
fn shows_part_of_emitter<'v>(
    direct: &DirectLight,
    mut views: impl Iterator<Item = &'v Viewpoint>,
    scratch: &mut Scratch,
) -> bool {
    views.any(|v| direct.rises(v) && direct.is_seen(v, scratch))
}

/// Viewpoints to both sides of the middle of each line: light that reaches a face only within a small patch draws lines
/// around it.
fn beside_lines(scene: &Scene, lines: &FaceLines) -> Vec<Viewpoint> {
    let contacts = lines.contacts.iter();
    contacts
        .filter(|l| l.kind != EventKind::Contact)
        .chain(&lines.candidates)
        .flat_map(|line| {
            let normal = scene.normal(line.face, line.side);
            let [a, b] = line.ends;
            let across = normal.cross(b - a) * BESIDE_SHARE;
            [1.0, -1.0].map(|s| Viewpoint::new(0.5 * (a + b) + across * s, normal))
        })
        .collect()
}

/// The mean irradiance of all sides if nothing were lost of what the emitters leave, W/m².
pub(super) fn greatest_mean(
    scene: &Scene,
    direct: &DirectLight,
    sides: &[(FaceId, FaceSide)],
) -> f64 {
    let exitance = |e| {
        let own = direct.polygons.iter().find(|p| p.emitter == e);
        own.map_or(0.0, |p| p.exitance.mean())
    };
    let emitters = scene.emitters.iter();
    let power: f64 = emitters
        .map(|(id, e)| exitance(id) * scene.faces[e.face].area)
        .sum();
    power / sides.iter().map(|s| scene.faces[s.0].area).sum::<f64>()
}

/// About the mean of the direct irradiance over the lit sides, W/m²: at points spread evenly over their area, by single
/// rays.
pub(super) fn guess_direct(
    scene: &Scene,
    direct: &DirectLight,
    sides: &[(FaceId, FaceSide)],
    is_lit: &[bool],
) -> f64 {
    let mut triangles = Vec::new();
    let mut area = 0.0;
    for (&(face, side), _) in sides.iter().zip(is_lit).filter(|(_, lit)| **lit) {
        for t in &scene.faces[face].triangles {
            let corners = t.map(|v| scene.vertices[v]);
            area += triangle_area(corners);
            triangles.push((area, corners, scene.normal(face, side)));
        }
    }
    if triangles.is_empty() {
        return 0.0;
    }
    let lights: Vec<f64> = (0..GUESS_POINTS)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, i| {
            let at = area * (f64::from(i) + 0.5) / f64::from(GUESS_POINTS);
            let k = triangles
                .partition_point(|t| t.0 <= at)
                .min(triangles.len() - 1);
            let (_, corners, normal) = triangles[k];
            let view = Viewpoint::new(even_point_in(corners, i), normal);
            direct.by_rays(&view, scratch).mean()
        })
        .collect();
    lights.iter().sum::<f64>() / f64::from(GUESS_POINTS)
}

fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}
