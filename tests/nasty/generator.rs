//! Seeded scenes in which as much coincides as can be, or nearly so.

use crate::common::library::raw_of_mesh;
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use crate::lines::cities::add_box;
use glam::{DQuat, DVec3};
use umbrage::scene::RawScene;

/// What a scene is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Nasty {
    /// Boxes on a raster: on, in and beside each other.
    City,
    /// Rows of equal slats that line up with each other and with the lamp.
    Slats,
    /// Sheets in one plane, or 1e-12 … 1e-2 m beside it.
    Stack,
    /// Triangles a thousand to a million times as long as wide.
    Needles,
    /// Blockers that touch the lamp or cut it.
    Lamp,
    /// Edges in line with the lamp's corners and edges.
    EndOn,
    /// Something of everything.
    Mixed,
}

impl Nasty {
    pub(crate) const ALL: [Self; 7] = [
        Self::City,
        Self::Slats,
        Self::Stack,
        Self::Needles,
        Self::Lamp,
        Self::EndOn,
        Self::Mixed,
    ];
}

/// Coordinates on a raster, metres.
const RASTER: f64 = 0.25;

/// A scene of one kind: a floor, a lamp over it, and what is between them; turned, or a million metres off, or of another
/// size, now and then.
pub(crate) fn nasty_scene(nasty: Nasty, rng: &mut Rng) -> RawScene {
    let mut mesh = ObjMesh::default();
    sheet(&mut mesh, [0.0, 0.0], [4.0, 4.0], 0.0, true, 0.0);
    let lamp = lamp(&mut mesh, rng);
    match nasty {
        Nasty::City => city(&mut mesh, rng, 5),
        Nasty::Slats => slats(&mut mesh, rng, lamp),
        Nasty::Stack => stack(&mut mesh, rng, 5),
        Nasty::Needles => needles(&mut mesh, rng, 6),
        Nasty::Lamp => at_lamp(&mut mesh, rng, lamp),
        Nasty::EndOn => end_on(&mut mesh, rng, lamp, 3),
        Nasty::Mixed => {
            city(&mut mesh, rng, 2);
            stack(&mut mesh, rng, 2);
            needles(&mut mesh, rng, 2);
            end_on(&mut mesh, rng, lamp, 1);
        }
    }
    let mut raw = raw_of_mesh("nasty", &mesh);
    let turn = match rng.below(4) {
        0 => {
            DQuat::from_rotation_y(rng.range(0.0, 6.0))
                * DQuat::from_rotation_x(rng.range(0.0, 6.0))
        }
        _ => DQuat::IDENTITY,
    };
    let (scale, shift) = match rng.below(4) {
        0 => (1.0, 1e6),
        1 => ([1e-3, 1e3][rng.below(2)], 0.0),
        _ => (1.0, 0.0),
    };
    for p in &mut raw.positions {
        *p = turn * *p * scale + DVec3::splat(shift);
    }
    raw
}

fn raster(rng: &mut Rng, from: usize, to: usize) -> f64 {
    (from + rng.below(to - from)) as f64 * RASTER
}

/// A horizontal rectangle that looks up or down.
fn sheet(mesh: &mut ObjMesh, [x, z]: [f64; 2], [w, d]: [f64; 2], y: f64, is_up: bool, ke: f64) {
    let mut corners = [[x, y, z + d], [x + w, y, z + d], [x + w, y, z], [x, y, z]];
    if !is_up {
        corners.reverse();
    }
    mesh.add(&corners, 0.5, ke);
}

/// The lamp: low corner and size; it hangs at a height of the raster and looks down.
type Lamp = (DVec3, DVec3);

fn lamp(mesh: &mut ObjMesh, rng: &mut Rng) -> Lamp {
    let low = DVec3::new(raster(rng, 2, 10), raster(rng, 10, 14), raster(rng, 2, 10));
    let size = DVec3::new(raster(rng, 1, 5), 0.0, raster(rng, 1, 5));
    sheet(mesh, [low.x, low.z], [size.x, size.z], low.y, false, 1.0);
    (low, size)
}

fn city(mesh: &mut ObjMesh, rng: &mut Rng, boxes: usize) {
    for _ in 0..1 + rng.below(boxes) {
        let (x, z) = (raster(rng, 0, 14), raster(rng, 0, 14));
        let (w, h, d) = (raster(rng, 1, 6), raster(rng, 1, 6), raster(rng, 1, 6));
        let y = if rng.below(4) == 0 { h } else { 0.0 };
        add_box(mesh, [x, y, z], [x + w, y + h, z + d], rng.below(2) == 0);
    }
}

/// Thin boxes or sheets, equally spaced, in rows one above the other; their ends in line with the lamp's.
fn slats(mesh: &mut ObjMesh, rng: &mut Rng, (low, size): Lamp) {
    let (count, rows) = (2 + rng.below(4), 1 + rng.below(2));
    let (step, is_box) = (raster(rng, 1, 3), rng.below(2) == 0);
    let thickness = [0.0, 1e-9, 1e-3, 0.05][rng.below(4)];
    for row in 0..rows {
        let y = 1.0 + 0.5 * row as f64;
        for i in 0..count {
            let x = low.x + i as f64 * step;
            let (z, w, d) = (low.z, step * [0.5, 1.0][rng.below(2)], size.z);
            if is_box && thickness > 0.0 {
                add_box(mesh, [x, y, z], [x + w, y + thickness, z + d], true);
            } else {
                sheet(mesh, [x, z], [w, d], y, rng.below(2) == 0, 0.0);
            }
        }
    }
}

/// Sheets in one plane or nearly so, overlapping, one inside another, back to back.
fn stack(mesh: &mut ObjMesh, rng: &mut Rng, sheets: usize) {
    let level = [0.0, 0.0, 1.0][rng.below(3)];
    for _ in 0..2 + rng.below(sheets) {
        let off = [0.0, 0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2][rng.below(8)];
        let (x, z) = (raster(rng, 0, 12), raster(rng, 0, 12));
        let (w, d) = (raster(rng, 1, 8), raster(rng, 1, 8));
        sheet(mesh, [x, z], [w, d], level + off, rng.below(4) > 0, 0.0);
    }
}

fn needles(mesh: &mut ObjMesh, rng: &mut Rng, count: usize) {
    for _ in 0..1 + rng.below(count) {
        let mut any = || {
            DVec3::new(
                rng.range(0.2, 3.8),
                rng.range(0.1, 2.2),
                rng.range(0.2, 3.8),
            )
        };
        let (a, b, c) = (any(), any(), any());
        let width = [1e-3, 1e-4, 1e-6][rng.below(3)];
        let third = a.lerp(b, rng.unit()) + (c - a) * width;
        mesh.add(&[a, b, third].map(|p| p.to_array()), 0.5, 0.0);
    }
}

/// Walls down from the lamp's edge or through it, a box that touches it, a sheet in its plane.
fn at_lamp(mesh: &mut ObjMesh, rng: &mut Rng, (low, size): Lamp) {
    let high = low + size;
    let drop = raster(rng, 1, 6);
    for _ in 0..1 + rng.below(3) {
        match rng.below(4) {
            0 => {
                // A wall from one edge of the lamp or from a line across it.
                let x = low.x + size.x * [0.0, 0.5, 1.0][rng.below(3)];
                let corners = [
                    [x, low.y - drop, low.z],
                    [x, low.y - drop, high.z],
                    [x, low.y, high.z],
                    [x, low.y, low.z],
                ];
                mesh.add(&corners, 0.5, 0.0);
            }
            1 => {
                // A box that touches it from below, with a corner in its middle.
                let middle = low + 0.5 * size;
                let top = [middle.x + RASTER, low.y, middle.z + RASTER];
                add_box(mesh, [middle.x, low.y - RASTER, middle.z], top, true);
            }
            2 => sheet(mesh, [high.x, low.z], [RASTER, size.z], low.y, false, 0.0),
            _ => {
                // A wall that goes through it.
                let z = low.z + 0.5 * size.z;
                let corners = [
                    [low.x, low.y - drop, z],
                    [high.x, low.y - drop, z],
                    [high.x, low.y + RASTER, z],
                    [low.x, low.y + RASTER, z],
                ];
                mesh.add(&corners, 0.5, 0.0);
            }
        }
    }
}

/// Triangles with an edge on a line through a corner of the lamp, or in a plane with one of its edges.
fn end_on(mesh: &mut ObjMesh, rng: &mut Rng, (low, size): Lamp, count: usize) {
    for _ in 0..1 + rng.below(count) {
        let corner = low + size * DVec3::new(rng.below(2) as f64, 0.0, rng.below(2) as f64);
        let foot = DVec3::new(raster(rng, 1, 15), 0.0, raster(rng, 1, 15));
        let on = |t: f64| corner.lerp(foot, t);
        let third = on(0.5) + DVec3::new(raster(rng, 1, 4), 0.0, raster(rng, 0, 3));
        mesh.add(&[on(0.25), on(0.75), third].map(|p| p.to_array()), 0.5, 0.0);
        // In a plane with the lamp's edge along x.
        let along = DVec3::X * raster(rng, 1, 4);
        let quad = [on(0.5), on(0.5) + along, on(0.75) + along, on(0.75)];
        if rng.below(2) == 0 {
            mesh.add(&quad.map(|p| p.to_array()), 0.5, 0.0);
        }
    }
}
