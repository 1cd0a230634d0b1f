//! Closed rooms in which every surface leaves 1 W/m² whatever its reflectance: no mesh, row or sweep may lose light.

use crate::common::bake::{bake, settings, surface_points, world};
use crate::common::obj_lite::ObjMesh;
use crate::common::scenes::read_fixture;
use glam::{DVec2, DVec3, Vec3Swizzles};
use umbrage::lit_scene::LitScene;
use umbrage::pipeline::{Solution, light};
use umbrage::quantity::Irradiance;
use umbrage::radiosity::{Basis, Bounces};
use umbrage::scene::FaceSide;
use umbrage::settings::Settings;
use umbrage::visibility::{Scratch, Viewpoint};

/// Of B = M + ρE, relative.
const TOLERANCE: f64 = 1e-3;

/// Of Σ F = 1 over all that a point sees: round-off, grown by cutting behind two boxes to 1.3e-8.
const ROW_TOLERANCE: f64 = 1e-7;

/// Random points in each room.
const PROBES: usize = 300;

const REFLECTANCES: [(&str, f64); 4] = [("r10", 0.1), ("r50", 0.5), ("r90", 0.9), ("r99", 0.99)];

/// Where the boxes without bottom stand on the floor: nothing outside sees the floor there.
struct Footprints(Vec<Vec<DVec2>>);

impl Footprints {
    fn new(mesh: &ObjMesh) -> Self {
        let tops = mesh
            .polygons
            .iter()
            .filter(|p| p.object.ends_with("-box") && p.normal().y > 0.5);
        Self(
            tops.map(|p| p.corners.iter().map(|c| c.xz()).collect())
                .collect(),
        )
    }

    fn area(&self) -> f64 {
        self.0.iter().map(|p| shoelace(p).abs()).sum()
    }

    /// True for a point of the floor under a box.
    fn cover(&self, p: DVec3) -> bool {
        p.y.abs() < 1e-9
            && self.0.iter().any(|f| {
                let sign = shoelace(f).signum();
                (0..f.len()).all(|i| {
                    let (a, b) = (f[i], f[(i + 1) % f.len()]);
                    sign * (b - a).perp_dot(p.xz() - a) > 0.0
                })
            })
    }
}

fn shoelace(p: &[DVec2]) -> f64 {
    (0..p.len())
        .map(|i| p[i].perp_dot(p[(i + 1) % p.len()]) / 2.0)
        .sum()
}

/// `error` is what the bake is asked for; where the light is the same everywhere it costs no accuracy.
fn check(shape: &str, error: f64) {
    check_basis(shape, error, Basis::default());
}

fn check_basis(shape: &str, error: f64, basis: Basis) {
    for (suffix, reflectance) in REFLECTANCES {
        let name = format!("{shape}-{suffix}");
        let mesh = read_fixture(&name);
        let footprints = Footprints::new(&mesh);
        let world = world(&name);
        let settings = Settings {
            basis,
            ..settings(error, Bounces::All)
        };
        let solution = light(&world, &settings, &mut |_| {}).expect("a room");
        let seen = check_vertices(&name, &solution.lit_scene(), &footprints);
        // Everything was looked at but what stands under the boxes.
        let area: f64 = mesh.polygons.iter().map(|p| p.area()).sum();
        let expected = area - footprints.area();
        assert!(
            (seen - expected).abs() <= 1e-6 * expected,
            "{name}: looked at {seen} m² of {expected}"
        );
        check_probes(&name, &solution, &footprints, reflectance);
    }
}

/// Radiosity at all vertices of all fronts; the area of their triangles.
fn check_vertices(name: &str, lit: &LitScene, footprints: &Footprints) -> f64 {
    let mut seen = 0.0;
    for mesh in lit.meshes.iter().filter(|m| !m.exitance.0.is_black()) {
        for t in &mesh.triangles {
            let corners = t.map(|i| mesh.positions[i as usize] + lit.origin);
            if footprints.cover(corners.iter().sum::<DVec3>() / 3.0) {
                continue;
            }
            let [a, b, c] = corners;
            seen += (b - a).cross(c - a).length() / 2.0;
            for &i in t {
                let found = mesh.radiosity(i as usize).mean();
                assert!(
                    (found - 1.0).abs() <= TOLERANCE,
                    "{name}: {found} W/m² at {}",
                    mesh.positions[i as usize] + lit.origin
                );
            }
        }
    }
    seen
}

/// Radiosity and row sums at random points of all fronts, without any interpolation.
fn check_probes(name: &str, solution: &Solution, footprints: &Footprints, reflectance: f64) {
    let field = solution.indirect.as_ref().expect("the room reflects");
    let (mut scratch, mut gatherer) = (Scratch::default(), field.gatherer());
    let mut count = 0;
    for p in surface_points(solution, PROBES, 3) {
        let view = p.view(solution);
        let place = view.position + solution.world.scene.origin;
        let side = solution.receivers[p.receiver].domain.side;
        if side == FaceSide::Back || footprints.cover(place) {
            continue;
        }
        count += 1;
        let direct = solution.direct.irradiance(&view, &mut scratch).mean();
        assert!(
            (direct / (1.0 - reflectance) - 1.0).abs() <= ROW_TOLERANCE,
            "{name}: direct light {direct} at {place}"
        );
        let row = gatherer.row_sum(&view);
        assert!(
            (row - 1.0).abs() <= ROW_TOLERANCE,
            "{name}: row sum {row:.12} at {place}"
        );
        let indirect = field.gather(&mut gatherer, &view).mean();
        let found = 1.0 - reflectance + reflectance * (direct + indirect);
        assert!(
            (found - 1.0).abs() <= TOLERANCE,
            "{name}: {found} W/m² at {place}"
        );
    }
    assert!(count > PROBES / 2, "{name}: {count} points");
}

#[test]
fn box_is_an_even_furnace() {
    check("furnace-box", 0.01);
}

#[test]
fn l_room_is_an_even_furnace() {
    check("furnace-l-room", 0.01);
}

#[test]
fn cornell_room_is_an_even_furnace() {
    check("furnace-cornell", 0.01);
}

#[test]
fn rooms_are_even_furnaces_in_every_basis() {
    for basis in Basis::ALL.into_iter().filter(|&b| b != Basis::default()) {
        check_basis("furnace-l-room", 0.05, basis);
    }
}

/// A point of a closed room sees the lamp or something that reflects, in every direction.
fn check_closed(
    name: &str,
    error: f64,
    radiance: f64,
    tolerance: f64,
    is_open: impl Fn(DVec3) -> bool,
) {
    let world = world(name);
    let solution = bake(&world, error, Bounces::All);
    let field = solution.indirect.as_ref().expect("the room reflects");
    let (mut scratch, mut gatherer) = (Scratch::default(), field.gatherer());
    let mut worst = (0.0, DVec3::ZERO);
    let mut count = 0;
    for p in surface_points(&solution, PROBES, 7) {
        let view: Viewpoint = p.view(&solution);
        let place = view.position + world.scene.origin;
        // Backs lie outside of the room or inside of something.
        let side = solution.receivers[p.receiver].domain.side;
        if side == FaceSide::Back || !is_open(place) {
            continue;
        }
        count += 1;
        let direct: Irradiance = solution.direct.irradiance(&view, &mut scratch);
        let lamp = direct.mean() / (radiance * std::f64::consts::PI);
        let off = (gatherer.row_sum(&view) + lamp - 1.0).abs();
        if off > worst.0 {
            worst = (off, place);
        }
    }
    assert!(count > PROBES / 4, "{name}: {count} points");
    assert!(
        worst.0 <= tolerance,
        "{name}: row and lamp miss 1 by {:e} at {}",
        worst.0,
        worst.1
    );
    eprintln!("{name}: row and lamp miss 1 by at most {:e}", worst.0);
}

#[test]
fn rows_and_lamp_fill_the_hemisphere_in_the_l_room() {
    // The lamp's back is black; below the lamp nobody sees it.
    check_closed("l-room", 0.03, 1.0, ROW_TOLERANCE, |p| p.y < 2.25);
}

#[test]
fn rows_and_window_fill_the_hemisphere_behind_the_blinds() {
    // The window's back is black; it faces the wall. Legs and boxes without bottom enclose some of the floor.
    // Between the slats, millimetres apart, round-off has grown to 5e-8.
    check_closed("blinds", 0.3, 20.0, 1e-6, |p| {
        p.x > 1.0 / 64.0 && p.y > 1e-9
    });
}
