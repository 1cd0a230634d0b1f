//! The exact direct light, held against closed forms and ray casting.

use super::{UP, assert_near};
use crate::common::obj_lite::ObjMesh;
use crate::common::quadrature::gauss_between;
use crate::common::reference::{DirectReference, lambert};
use crate::common::rng::Rng;
use crate::common::scenes::{SHADOW_SCENES, fixture_names, read_fixture};
use crate::common::tables::{rows, table};
use glam::DVec3;
use std::f64::consts::PI;

/// Exitance 1 W/m².
const UNIT_EXITANCE: f64 = 1.0 / PI;

/// A rectangle at height `y` that faces down.
fn facing_down(x: [f64; 2], z: [f64; 2], y: f64) -> [[f64; 3]; 4] {
    [
        [x[0], y, z[0]],
        [x[1], y, z[0]],
        [x[1], y, z[1]],
        [x[0], y, z[1]],
    ]
}

/// A unit square emitter of exitance 1 at height 1 over the origin, and whatever else.
fn under_unit_square(blockers: &[&[[f64; 3]]]) -> DirectReference {
    let mut mesh = ObjMesh::default();
    mesh.add(
        &facing_down([-0.5, 0.5], [-0.5, 0.5], 1.0),
        0.0,
        UNIT_EXITANCE,
    );
    for blocker in blockers {
        mesh.add(blocker, 0.3, 0.0);
    }
    DirectReference::new(&mesh)
}

/// Mean of the irradiance over a square of the floor, cut at `breaks` along both axes.
fn mean_over_floor(scene: &DirectReference, breaks: &[f64]) -> f64 {
    let side = breaks[breaks.len() - 1] - breaks[0];
    let line = gauss_between(breaks, 16);
    let mut sum = 0.0;
    for &(x, wx) in &line {
        for &(z, wz) in &line {
            sum += wx * wz * scene.irradiance(DVec3::new(x, 0.0, z), UP).x;
        }
    }
    sum / (side * side)
}

#[test]
fn point_under_a_unit_square() {
    let centre = under_unit_square(&[]);
    let at =
        |scene: &DirectReference, x: f64, z: f64| scene.irradiance(DVec3::new(x, 0.0, z), UP).x;
    assert_near(
        at(&centre, 0.0, 0.0),
        rows("point_factors", "below_centre")[0][0],
        1e-15,
        "below the centre",
    );
    assert_near(
        at(&centre, 0.5, 0.5),
        rows("point_factors", "below_corner")[0][0],
        1e-15,
        "below a corner",
    );
}

#[test]
fn half_plane_hides_half_of_the_emitter() {
    let half_plane = [
        [-1e3, 0.5, 1e3],
        [0.0, 0.5, 1e3],
        [0.0, 0.5, -1e3],
        [-1e3, 0.5, -1e3],
    ];
    let scene = under_unit_square(&[&half_plane]);
    let expected = rows("point_factors", "below_centre_half_hidden")[0][0];
    assert_near(
        scene.irradiance(DVec3::ZERO, UP).x,
        expected,
        1e-15,
        "under the half-plane's edge",
    );
}

#[test]
fn point_beside_an_upright_square() {
    // Factor from a point to a rectangle a x b that stands at distance c on the point's own plane, one corner at its
    // foot point: (atan(1/Y) - Y / sqrt(X² + Y²) atan(1 / sqrt(X² + Y²))) / 2π with X = a/b, Y = c/b (b along the floor).
    let (height, width, distance) = (0.7, 1.3, 0.4);
    let (x, y) = (height / width, distance / width);
    let slant = f64::hypot(x, y);
    let expected = ((1.0 / y).atan() - y / slant * (1.0 / slant).atan()) / (2.0 * PI);
    let wall = |bottom: f64| {
        [
            DVec3::new(distance, bottom, 0.0),
            DVec3::new(distance, bottom, width),
            DVec3::new(distance, height, width),
            DVec3::new(distance, height, 0.0),
        ]
    };
    assert_near(
        lambert(UP, &wall(0.0)) / PI,
        expected,
        1e-15,
        "wall on the floor",
    );
    // The part of a wall below the horizon gives nothing.
    let mut mesh = ObjMesh::default();
    mesh.add(&wall(-0.5).map(|p| p.to_array()), 0.0, UNIT_EXITANCE);
    if mesh.polygons[0].normal().x > 0.0 {
        mesh.polygons[0].corners.reverse();
    }
    let found = DirectReference::new(&mesh).irradiance(DVec3::ZERO, UP).x;
    assert_near(found, expected, 1e-15, "wall through the floor");
}

#[test]
fn form_factors_of_squares() {
    for row in rows("form_factors", "parallel_unit_squares") {
        let mut mesh = ObjMesh::default();
        mesh.add(
            &facing_down([0.0, 1.0], [0.0, 1.0], row[0]),
            0.0,
            UNIT_EXITANCE,
        );
        let found = mean_over_floor(&DirectReference::new(&mesh), &[0.0, 0.5, 1.0]);
        assert_near(
            found,
            row[1],
            6e-11,
            &format!("parallel squares at {}", row[0]),
        );
    }
}

#[test]
fn form_factors_past_a_blocker() {
    let obstructed = |x: [f64; 2], height: f64, breaks: &[f64]| {
        let mut mesh = ObjMesh::default();
        mesh.add(
            &facing_down([0.0, 1.0], [0.0, 1.0], 1.0),
            0.0,
            UNIT_EXITANCE,
        );
        mesh.add(&facing_down(x, x, height), 0.3, 0.0);
        mean_over_floor(&DirectReference::new(&mesh), breaks)
    };
    // Edges of the shadow lie where a line over an edge of each square meets the floor.
    let known = |name: &str| rows("form_factors", name)[0][0];
    assert_near(
        obstructed([0.25, 0.75], 0.75, &[0.0, 1.0]),
        known("shapiro"),
        6e-11,
        "Shapiro's squares",
    );
    assert_near(
        obstructed([0.25, 0.75], 0.5, &[0.0, 0.5, 1.0]),
        known("centred_blocker_at_half"),
        6e-11,
        "centred",
    );
    assert_near(
        obstructed([0.0, 0.5], 0.5, &[0.0, 0.5, 1.0]),
        known("corner_blocker_at_half"),
        6e-11,
        "corner",
    );

    let [_, to_blocker, from_blocker] = rows("form_factors", "shapiro")[0][..] else {
        panic!("three numbers")
    };
    let mut mesh = ObjMesh::default();
    mesh.add(
        &facing_down([0.25, 0.75], [0.25, 0.75], 0.75),
        0.0,
        UNIT_EXITANCE,
    );
    let found = mean_over_floor(&DirectReference::new(&mesh), &[0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_near(found, to_blocker, 6e-11, "Shapiro's floor to his blocker");
    assert_near(found / 0.25, from_blocker, 2e-10, "and back");
}

#[test]
fn cube_table_solves_its_own_system() {
    let parallel = rows("form_factors", "parallel_unit_squares")[2][1];
    let beside = rows("form_factors", "perpendicular_unit_squares")[0][0];
    assert_near(parallel + 4.0 * beside, 1.0, 1e-12, "closed cube");
    for row in rows("cube", "cube") {
        let [rho, ceiling, floor, wall] = row[..] else {
            panic!("cube rows have four numbers")
        };
        assert_near(
            1.0 + rho * (parallel * floor + 4.0 * beside * wall),
            ceiling,
            2e-10,
            "ceiling",
        );
        assert_near(
            rho * (parallel * ceiling + 4.0 * beside * wall),
            floor,
            2e-10,
            "floor",
        );
        assert_near(
            rho * (beside * (ceiling + floor) + (parallel + 2.0 * beside) * wall),
            wall,
            2e-10,
            "wall",
        );
    }
}

#[test]
fn corner_exponents_solve_their_equation() {
    // K(g) = ½ ∫ t^(1+g) (1 + t²)^(-3/2) dt over t > 0, with t = tan s: ½ ∫ sin^(1+g) s cos^(-g) s ds over (0, π/2);
    // s = π/2 - u^m removes the singularity at the end.
    for row in table("corner_exponents") {
        let [rho, g] = row.numbers[..] else {
            panic!("two numbers a row")
        };
        let m = 40.0;
        let end = (PI / 2.0).powf(1.0 / m);
        let steps = 20_000;
        let sum: f64 = (0..steps)
            .map(|i| {
                let u = end * (f64::from(i) + 0.5) / f64::from(steps);
                let rest = u.powf(m);
                rest.cos().powf(1.0 + g) * rest.sin().powf(-g) * m * u.powf(m - 1.0)
            })
            .sum();
        let kernel = 0.5 * sum * end / f64::from(steps);
        assert_near(
            rho * kernel,
            1.0,
            1e-5,
            &format!("exponent for reflectance {rho}"),
        );
    }
}

#[test]
fn penumbra_of_a_square_begins_and_ends_where_similar_triangles_say() {
    let scene = DirectReference::new(&read_fixture("square-over-square"));
    let mut open = read_fixture("square-over-square");
    open.polygons.retain(|p| p.object != "blocker");
    let open = DirectReference::new(&open);
    for row in rows("penumbra", "square_over_square") {
        let [a, emitter_y, b, y, outer, umbra] = row[..] else {
            panic!("six numbers a row")
        };
        let reach = y / (emitter_y - y);
        assert_near(
            b / 2.0 * (1.0 + reach) + a / 2.0 * reach,
            outer,
            1e-15,
            "outer",
        );
        assert_near(
            b / 2.0 * (1.0 + reach) - a / 2.0 * reach,
            umbra,
            1e-15,
            "umbra",
        );
        let at = |scene: &DirectReference, x: f64| scene.irradiance(DVec3::new(x, 0.0, 0.1), UP).x;
        let step = 1e-6;
        assert_near(at(&scene, umbra - step), 0.0, 1e-15, "inside the umbra");
        assert!(at(&scene, umbra + step) > 1e-9, "just out of the umbra");
        assert!(
            at(&scene, outer - step) < at(&open, outer - step) - 1e-9,
            "just in the penumbra"
        );
        assert_near(
            at(&scene, outer + step),
            at(&open, outer + step),
            1e-15,
            "out of the penumbra",
        );
    }
}

#[test]
fn penumbra_sets_in_with_the_slope_or_the_curvature() {
    for (name, turn) in [("onset_parallel", 0.0_f64), ("onset_turned", 0.3)] {
        let [power, factor] = rows("point_factors", name)[0][..] else {
            panic!("two numbers a row")
        };
        // A half-plane at height ½ covers everything left of a line through the axis; the light that comes
        // first passes over the line from the emitter's right edge or corner.
        let (c, s) = (turn.cos(), turn.sin());
        let corner = |x: f64, z: f64| [c * x + s * z, 0.5, -s * x + c * z];
        let half_plane = [
            corner(-4.0, 4.0),
            corner(0.0, 4.0),
            corner(0.0, -4.0),
            corner(-4.0, -4.0),
        ];
        let scene = under_unit_square(&[&half_plane]);
        let across = DVec3::new(c, 0.0, -s);
        let reach = 0.5 * (c + s);
        let d = 1e-5;
        let light = scene.irradiance(across * (d - reach), UP).x;
        assert_near(light / d.powf(power), factor, 1e-5, name);
        assert_near(
            scene.irradiance(across * (-d - reach), UP).x,
            0.0,
            1e-15,
            name,
        );
    }
}

#[test]
fn light_of_two_emitters_is_the_sum_of_each() {
    let both = read_fixture("two-emitters");
    let only = |object: &str| {
        let mut mesh = both.clone();
        mesh.polygons
            .retain(|p| !p.object.ends_with("-lamp") || p.object == object);
        DirectReference::new(&mesh)
    };
    let (sum, red, blue) = (
        DirectReference::new(&both),
        only("red-lamp"),
        only("blue-lamp"),
    );
    let mut rng = Rng::new(7);
    for _ in 0..50 {
        let x = DVec3::new(rng.range(-3.0, 3.0), 0.0, rng.range(-3.0, 3.0));
        let difference = sum.irradiance(x, UP) - red.irradiance(x, UP) - blue.irradiance(x, UP);
        assert!(difference.abs().max_element() < 1e-15, "{x}: {difference}");
    }
}

#[test]
fn moving_and_scaling_keeps_the_light() {
    let mut rng = Rng::new(11);
    for (name, size) in [
        ("square-over-square", 8.0),
        ("rotated-blocker", 8.0),
        ("box-on-table", 8.0),
        ("blinds", 4.0),
    ] {
        let plain = DirectReference::new(&read_fixture(name));
        let variants = [
            ("t1e4", 1.0, size * 1e4),
            ("t1e6", 1.0, size * 1e6),
            ("s1e-3", 1e-3, 0.0),
            ("s1e3", 1e3, 0.0),
        ];
        let variants = variants.map(|(suffix, scale, offset)| {
            (
                suffix,
                scale,
                offset,
                DirectReference::new(&read_fixture(&format!("{name}-{suffix}"))),
            )
        });
        for _ in 0..8 {
            // A grid of 2⁻¹⁰ m, so that the moved point is exact.
            let snap = |x: f64| (x * 1024.0).round() / 1024.0;
            let x = DVec3::new(snap(rng.range(0.1, 2.9)), 0.0, snap(rng.range(0.1, 2.9)));
            let expected = plain.irradiance(x, UP);
            for (suffix, scale, offset, scene) in &variants {
                let found = scene.irradiance(x * *scale + DVec3::splat(*offset), UP);
                let error = (found - expected).abs().max_element();
                let limit = 1e-13 * expected.max_element().max(0.01);
                assert!(error <= limit, "{name}-{suffix} at {x}: off by {error:e}");
            }
        }
    }
}

#[test]
fn exact_and_cast_irradiance_agree() {
    let mut rng = Rng::new(3);
    let mut worst: f64 = 0.0;
    for name in SHADOW_SCENES {
        let mesh = read_fixture(name);
        let scene = DirectReference::new(&mesh);
        let floor = &mesh.polygons[0];
        let (low, high) = floor
            .corners
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &c| {
                (l.min(c), h.max(c))
            });
        let mut brightest: f64 = 1e-3;
        let mut errors: f64 = 0.0;
        for _ in 0..25 {
            let x = DVec3::new(rng.range(low.x, high.x), 0.0, rng.range(low.z, high.z)) * 0.7;
            let exact = scene.irradiance(x, UP);
            let cast = scene.irradiance_by_casting(x, UP, 5..=9);
            brightest = brightest.max(exact.max_element());
            errors = errors.max((exact - cast).abs().max_element());
        }
        assert!(
            errors <= 1e-3 * brightest,
            "{name}: {errors:e} of {brightest}"
        );
        worst = worst.max(errors / brightest);
    }
    assert!(worst > 0.0, "the two must not share their geometry");
}

#[test]
fn exact_and_cast_irradiance_agree_behind_blinds() {
    let scene = DirectReference::new(&read_fixture("blinds"));
    let mut rng = Rng::new(5);
    for _ in 0..4 {
        let x = DVec3::new(rng.range(0.5, 3.5), 0.0, rng.range(0.2, 2.8));
        let (exact, cast) = (
            scene.irradiance(x, UP),
            scene.irradiance_by_casting(x, UP, 7..=9),
        );
        let error = (exact - cast).abs().max_element();
        assert!(
            error <= 0.01 * exact.max_element(),
            "{x}: {exact} and {cast}"
        );
    }
}

#[test]
fn irradiance_lies_between_none_and_all_on_every_face() {
    for name in fixture_names() {
        let mesh = read_fixture(&name);
        let scene = DirectReference::new(&mesh);
        let mut lights = mesh.clone();
        lights
            .polygons
            .retain(|p| mesh.surfaces[p.surface].ke != DVec3::ZERO);
        let open = DirectReference::new(&lights);
        let brightest = mesh
            .surfaces
            .iter()
            .fold(DVec3::ZERO, |m, s| m.max(s.ke * PI));
        for polygon in &mesh.polygons {
            // The centre, a corner and the middle of an edge, as nodes of a mesh have them, on both sides.
            let corners = &polygon.corners;
            let middle = corners[0] + (corners[1] - corners[0]) / 2.0;
            for x in [polygon.centre(), corners[0], middle] {
                for n in [polygon.normal(), -polygon.normal()] {
                    let found = scene.irradiance(x, n);
                    let limit = open.irradiance(x, n).min(brightest) + brightest * 1e-13;
                    let is_bounded = found.cmpge(brightest * -1e-13) & found.cmple(limit);
                    assert!(
                        found.is_finite() && is_bounded.all(),
                        "{name}: {found} at {x} on {}, at most {limit}",
                        polygon.object
                    );
                }
            }
        }
    }
}
