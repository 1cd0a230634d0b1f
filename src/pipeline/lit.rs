//! Which sides show the light that reaches them.

use super::World;
use crate::direct::{DirectLight, Vantage};
use crate::discontinuity::{EventKind, FaceLines, LineMap};
use crate::quantity::Exitance;
use crate::radiosity::reached;
use crate::scene::{FaceId, FaceSide, Scene};
use crate::visibility::{Scratch, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// How far beside a line light is looked for, as a share of its length.
const BESIDE_SHARE: f64 = 0.01;

/// Which sides show light that reaches them: directly (it shows at coarse points, or draws a line), or by way of other
/// sides. A lamp that reflects nothing shows its own light alone.
///
/// `vantages` tells which emitters may be seen from each side, if that is known.
pub(super) fn lit_sides(
    world: &World,
    direct: &DirectLight,
    lines: &LineMap,
    sides: &[(FaceId, FaceSide)],
    vantages: Option<&[Arc<Vantage>]>,
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
    let vantage = |i: usize| vantages.map(|v| v[i].as_ref());
    let mut lit = spread(
        // Most that is lit sees the middle of an emitter.
        (0..sides.len())
            .into_par_iter()
            .map(|i| points(i).any(|v| direct.sees_a_middle(v, vantage(i))))
            .collect(),
    );
    // Exact cutting is dear, and few sides are left to it.
    let found: Vec<bool> = (0..sides.len())
        .into_par_iter()
        .map_init(Scratch::default, |scratch, i| {
            let mut is_seen =
                |v: &Viewpoint| direct.rises(v) && direct.is_seen(v, vantage(i), scratch);
            !lit[i] && points(i).any(&mut is_seen)
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
pub(super) fn greatest_mean(scene: &Scene, sides: &[(FaceId, FaceSide)]) -> f64 {
    let faces = scene.emitters.iter().map(|(_, e)| &scene.faces[e.face]);
    let power: f64 = faces
        .map(|f| Exitance::from_radiance(f.emission).mean() * f.area)
        .sum();
    power / sides.iter().map(|s| scene.faces[s.0].area).sum::<f64>()
}
