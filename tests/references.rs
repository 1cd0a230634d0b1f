//! The references that other tests trust, held against closed forms and against each other.

use crate::common::kinks::{Kink, KinkSettings, find_kinks};
use crate::common::obj_lite::ObjMesh;
use crate::common::path_tracer::{PathSettings, PathTracer};
use crate::common::reference::{DirectReference, lambert};
use crate::common::rng::Rng;
use crate::common::scenes::{FURNACES, SHADOW_SCENES, read_fixture, shared_scene};
use crate::common::tables::{rows, table};
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

const UP: DVec3 = DVec3::Y;

/// Exitance 1 W/m².
const UNIT_EXITANCE: f64 = 1.0 / PI;

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{what}: {found:.15} instead of {expected:.15} ± {tolerance:e}"
    );
}

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

/// Nodes and weights on [0, 1] of the Gauss-Legendre rule with `count` nodes.
fn gauss(count: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut p0, mut p1) = (1.0, x);
        for k in 2..=count {
            let k = k as f64;
            (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
        }
        (p1, count as f64 * (x * p1 - p0) / (x * x - 1.0))
    };
    (0..count)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
            for _ in 0..50 {
                let (p, slope) = legendre(x);
                x -= p / slope;
            }
            let slope = legendre(x).1;
            (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Mean of the irradiance over a square of the floor, cut at `breaks` along both axes.
fn mean_over_floor(scene: &DirectReference, breaks: &[f64]) -> f64 {
    let rule = gauss(16);
    let side = breaks[breaks.len() - 1] - breaks[0];
    let line: Vec<(f64, f64)> = breaks
        .windows(2)
        .flat_map(|w| {
            rule.iter()
                .map(|&(t, weight)| (w[0] + (w[1] - w[0]) * t, weight * (w[1] - w[0])))
        })
        .collect();
    let mut sum = 0.0;
    for &(x, wx) in &line {
        for &(z, wz) in &line {
            sum += wx * wz * scene.irradiance(DVec3::new(x, 0.0, z), UP).x;
        }
    }
    sum / (side * side)
}

// --- fixtures ---

#[test]
fn fixtures_are_convex_planar_and_complete() {
    let directory = crate::common::scenes::fixtures().join("scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(directory).expect("the fixtures are there") {
        let path = entry.expect("the entry is readable").path();
        if !path.is_dir() {
            continue;
        }
        let name = path.file_name().expect("it has a name").to_string_lossy();
        let mesh = read_fixture(&name);
        let (low, high) = mesh.bounds();
        // Coordinates moved by 10⁶ sizes keep ten digits; scaled ones are rounded once.
        let round_off = 4.0 * f64::EPSILON * low.abs().max(high.abs()).max_element();
        for polygon in &mesh.polygons {
            let n = polygon.normal();
            let corners = &polygon.corners;
            for (i, &a) in corners.iter().enumerate() {
                let (b, c) = (
                    corners[(i + 1) % corners.len()],
                    corners[(i + 2) % corners.len()],
                );
                let height = (a - polygon.centre()).dot(n);
                assert!(
                    height.abs() <= round_off,
                    "{name}: a face of {} bends by {height:e}",
                    polygon.object
                );
                assert!(
                    (b - a).cross(c - b).dot(n) > 0.0,
                    "{name}: a face of {} is not convex",
                    polygon.object
                );
            }
        }
        assert!(
            mesh.surfaces.iter().any(|s| s.ke != DVec3::ZERO),
            "{name}: no light"
        );
        count += 1;
    }
    assert_eq!(count, 44);
}

#[test]
fn rooms_are_closed_and_face_inwards() {
    let rooms = FURNACES.iter().copied().chain(["l-room", "blinds"]);
    for name in rooms {
        let mesh = read_fixture(name);
        let mut edges: BTreeMap<[[u64; 3]; 2], i32> = BTreeMap::new();
        let mut volume = 0.0;
        for polygon in mesh.polygons.iter().filter(|p| p.object == "room") {
            let key = |v: DVec3| (v + DVec3::ZERO).to_array().map(f64::to_bits);
            let corners = &polygon.corners;
            for (i, &a) in corners.iter().enumerate() {
                let b = corners[(i + 1) % corners.len()];
                *edges.entry([key(a), key(b)]).or_default() += 1;
                *edges.entry([key(b), key(a)]).or_default() -= 1;
            }
            volume += polygon.area() * polygon.normal().dot(polygon.centre()) / 3.0;
        }
        assert!(!edges.is_empty(), "{name}: no room");
        assert!(
            edges.values().all(|&uses| uses == 0),
            "{name}: the room is open"
        );
        assert!(volume < 0.0, "{name}: the room faces outwards");
    }
}

#[test]
fn moved_fixtures_are_the_same_bits() {
    for (name, size) in [
        ("square-over-square", 8.0),
        ("rotated-blocker", 8.0),
        ("box-on-table", 8.0),
        ("blinds", 4.0),
    ] {
        let plain = read_fixture(name);
        for (suffix, times) in [("t1e4", 1e4), ("t1e6", 1e6)] {
            let moved = read_fixture(&format!("{name}-{suffix}"));
            assert_eq!(plain.polygons.len(), moved.polygons.len());
            for (a, b) in plain.polygons.iter().zip(&moved.polygons) {
                let back: Vec<DVec3> = b
                    .corners
                    .iter()
                    .map(|&c| c - DVec3::splat(size * times))
                    .collect();
                assert_eq!(a.corners, back, "{name}-{suffix}");
            }
        }
    }
}

#[test]
fn a_missing_shared_scene_is_none() {
    assert!(shared_scene("no-such-scene/no-such-file.obj").is_none());
}

#[test]
fn random_numbers_are_uniform_and_repeat() {
    let mut rng = Rng::new(1);
    // First outputs of SplitMix64 for seed 1 are the same on every machine.
    let first = rng.next_u64();
    assert_eq!(first, Rng::new(1).next_u64());
    let mut counts = [0_u32; 6];
    for _ in 0..6000 {
        counts[rng.below(6)] += 1;
    }
    assert!(
        counts.iter().all(|&c| (880..1120).contains(&c)),
        "{counts:?}"
    );
}

// --- direct irradiance: closed forms ---

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

// --- direct irradiance: exact against ray casting ---

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

// --- kinks ---

/// Smooth light with breaks `(position, order, size)` added: `size (t - position)^order` to the right of each.
fn broken(t: f64, breaks: &[(f64, i32, f64)]) -> f64 {
    let smooth = (1.3 * t).sin() + 1.0 / (1.0 + 2.0 * (t - 0.4) * (t - 0.4));
    let added = breaks
        .iter()
        .filter(|b| t > b.0)
        .map(|&(at, order, size)| size * (t - at).powi(order));
    smooth + added.sum::<f64>()
}

fn kinks_of(breaks: &[(f64, i32, f64)]) -> Vec<Kink> {
    find_kinks(&|t| broken(t, breaks), (0.0, 1.0), &KinkSettings::default())
}

#[test]
fn smooth_functions_have_no_kinks() {
    let functions: [fn(f64) -> f64; 5] = [
        |t| broken(t, &[]),
        |t| (20.0 * t).sin(),
        |_| 3.0,
        |t| (-40.0 * (t - 0.3) * (t - 0.3)).exp(),
        |t| 1.0 / (0.01 + t * t),
    ];
    for (i, f) in functions.iter().enumerate() {
        let found = find_kinks(f, (0.0, 1.0), &KinkSettings::default());
        assert!(found.is_empty(), "function {i}: {found:?}");
    }
}

#[test]
fn kinks_of_each_order_are_found_and_measured() {
    for (order, sizes) in [
        (0, [1.0, 1e-3, 1e-6, 1e-9, 1e-11]),
        (1, [1.0, 1e-2, 1e-4, 1e-6, 1e-8]),
        (2, [10.0, 1.0, 1e-1, 1e-2, 1e-3]),
    ] {
        for size in sizes {
            for at in [0.123_456_789, 0.5, std::f64::consts::FRAC_1_PI * 2.7] {
                let found = kinks_of(&[(at, order, size)]);
                let what = format!("order {order}, size {size}, at {at}: {found:?}");
                assert_eq!(found.len(), 1, "{what}");
                let kink = found[0];
                assert_eq!(i32::from(kink.order), order, "{what}");
                assert!((kink.t - at).abs() <= kink.uncertainty.max(1e-9), "{what}");
                // Half of the second derivative is the factor of the square; values are scaled to a maximum of 1.
                let scale = (0..=64)
                    .map(|i| broken(f64::from(i) / 64.0, &[(at, order, size)]).abs())
                    .fold(0.0, f64::max);
                let expected = if order == 2 { 2.0 * size } else { size } / scale;
                let jump = kink.jumps[usize::from(kink.order)];
                assert!(
                    (jump / expected - 1.0).abs() < 0.05,
                    "{what}: jump {jump:e} for {expected:e}"
                );
            }
        }
    }
}

#[test]
fn kinks_close_to_each_other_are_told_apart() {
    for distance in [0.1, 0.03, 0.01, 0.003] {
        let breaks = [
            (0.31, 1, 0.5),
            (0.31 + distance, 2, 3.0),
            (0.31 + 2.0 * distance, 0, 0.01),
        ];
        let found = kinks_of(&breaks);
        let orders: Vec<u8> = found.iter().map(|k| k.order).collect();
        assert_eq!(orders, [1, 2, 0], "at a distance of {distance}: {found:?}");
        for (kink, (at, ..)) in found.iter().zip(breaks) {
            assert!(
                (kink.t - at).abs() < 0.02 * distance,
                "at a distance of {distance}: {found:?}"
            );
        }
    }
}

#[test]
fn kinks_are_found_wherever_they_are() {
    let mut rng = Rng::new(43);
    for order in 0..=2 {
        for _ in 0..100 {
            let at = rng.range(0.05, 0.95);
            let found = kinks_of(&[(at, order, 0.3)]);
            let orders: Vec<i32> = found.iter().map(|k| i32::from(k.order)).collect();
            assert_eq!(orders, [order], "at {at}: {found:?}");
        }
    }
}

#[test]
fn kinks_of_a_penumbra_are_where_the_geometry_says() {
    let scene = DirectReference::new(&read_fixture("square-over-square"));
    // Along x at z = 0.1: the penumbra's ends, all of them coplanar edges, and nothing in between.
    let along = |x: f64| scene.irradiance(DVec3::new(x, 0.0, 0.1), UP).x;
    let found = find_kinks(&along, (-2.7, 2.9), &KinkSettings::default());
    let expected = [-1.5, -0.5, 0.5, 1.5];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (kink, at) in found.iter().zip(expected) {
        assert_eq!(kink.order, 1, "{found:?}");
        assert!((kink.t - at).abs() < 1e-9, "{found:?}");
    }
}

#[test]
fn kinks_of_generic_penumbrae_lie_on_critical_planes() {
    for name in ["rotated-blocker", "tilted-triangle"] {
        let mesh = read_fixture(name);
        let scene = DirectReference::new(&mesh);
        let corners = |object: &str| -> Vec<DVec3> {
            let polygon = mesh.polygons.iter().find(|p| p.object == object);
            polygon.expect("the object is there").corners.clone()
        };
        let (emitter, blocker) = (corners("lamp"), corners("blocker"));
        let mut most = 0;
        for z in [0.1, -0.43, 0.77] {
            // Where a plane through a corner of one and an edge of the other meets the line.
            let mut planes = Vec::new();
            for (points, edges) in [(&emitter, &blocker), (&blocker, &emitter)] {
                for &p in points {
                    for (i, &a) in edges.iter().enumerate() {
                        let n = (a - p).cross(edges[(i + 1) % edges.len()] - a);
                        planes.push(n.dot(p - DVec3::new(0.0, 0.0, z)) / n.x);
                    }
                }
            }
            let along = |x: f64| scene.irradiance(DVec3::new(x, 0.0, z), UP).x;
            let found = find_kinks(&along, (-2.7, 2.9), &KinkSettings::default());
            most = most.max(found.len());
            for kink in &found {
                assert_eq!(kink.order, 2, "{name}, z = {z}: {kink:?}");
                let off = |plane: &f64| (plane - kink.t).abs();
                let nearest = planes.iter().map(off).fold(f64::INFINITY, f64::min);
                assert!(
                    nearest <= 1e-7,
                    "{name}, z = {z}: {kink:?} is {nearest:e} m off"
                );
            }
        }
        assert!(most >= 6, "{name}: at most {most} kinks on a line");
    }
}

#[test]
fn contact_line_and_horizon_are_breaks_of_value_and_slope() {
    let scene = DirectReference::new(&read_fixture("wall-piercing-floor"));
    let along = |x: f64| scene.irradiance(DVec3::new(x, 0.0, 0.0), UP).x;
    let found = find_kinks(&along, (-1.3, 1.6), &KinkSettings::default());
    let contact: Vec<_> = found.iter().filter(|k| k.order == 0).collect();
    assert_eq!(contact.len(), 1, "{found:?}");
    assert!(contact[0].t.abs() < 1e-7, "{found:?}");

    let scene = DirectReference::new(&read_fixture("emitter-plane-on-receiver"));
    let along = |x: f64| scene.irradiance(DVec3::new(x, 0.0, 0.3), UP).x;
    let found = find_kinks(&along, (-2.7, 2.9), &KinkSettings::default());
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].order, 1, "{found:?}");
    assert!((found[0].t + 0.5).abs() < 1e-9, "{found:?}");
}

// --- path tracing ---

#[test]
fn furnaces_receive_one_watt_everywhere() {
    for name in FURNACES {
        let mesh = read_fixture(name);
        let tracer = PathTracer::new(&mesh);
        let settings = |from_emitters| PathSettings {
            // Paths at a reflectance of 0.99 are a hundred reflections long.
            paths: if name.ends_with("r99") { 100 } else { 1000 },
            bounces: 5000,
            seed: 17,
            from_emitters,
        };
        let floor = DVec3::new(0.07, 0.0, 0.83);
        for from_emitters in [false, true] {
            let found = tracer.irradiance(floor, UP, &settings(from_emitters));
            let z = found.z(DVec3::ONE, 1e-9);
            assert!(
                z < 4.0,
                "{name}, from emitters {from_emitters}: {found:?} is {z} standard errors off"
            );
        }
    }
}

#[test]
fn paths_without_reflection_give_the_direct_light() {
    for name in ["rotated-blocker", "two-emitters", "box-on-table", "blinds"] {
        let mesh = read_fixture(name);
        let (exact, tracer) = (DirectReference::new(&mesh), PathTracer::new(&mesh));
        for (i, x) in [DVec3::new(0.9, 0.0, 0.4), DVec3::new(1.8, 0.0, 1.1)]
            .into_iter()
            .enumerate()
        {
            for from_emitters in [false, true] {
                let settings = PathSettings {
                    paths: 20_000,
                    bounces: 0,
                    seed: 23 + i as u64,
                    from_emitters,
                };
                let (expected, found) =
                    (exact.irradiance(x, UP), tracer.irradiance(x, UP, &settings));
                let z = found.z(expected, 1e-12);
                assert!(
                    z < 4.0,
                    "{name} at {x}, from emitters {from_emitters}: {found:?} for {expected}"
                );
            }
        }
    }
}

#[test]
fn both_ways_of_tracing_agree_around_a_corner() {
    let mesh = read_fixture("l-room");
    let tracer = PathTracer::new(&mesh);
    let x = DVec3::new(1.2, 0.0, 3.8);
    let direct = DirectReference::new(&mesh).irradiance(x, UP);
    assert_near(direct.x, 0.0, 1e-15, "no direct light around the corner");
    let estimate = |from_emitters, paths| {
        let settings = PathSettings {
            paths,
            bounces: 100,
            seed: 29,
            from_emitters,
        };
        tracer.irradiance(x, UP, &settings)
    };
    let (hits, emitters) = (estimate(false, 60_000), estimate(true, 20_000));
    let error = hits.standard_error.x.hypot(emitters.standard_error.x);
    assert!(hits.mean.x > 0.0);
    assert!(
        (hits.mean.x - emitters.mean.x).abs() < 4.0 * error,
        "{hits:?} and {emitters:?}"
    );
}

// --- what the references cost and can see: cargo test -- --ignored --nocapture measure ---

#[test]
#[ignore = "prints measurements"]
fn measure_the_exact_irradiance() {
    for name in [
        "square-over-square",
        "rotated-blocker",
        "box-on-table",
        "blinds",
    ] {
        let scene = DirectReference::new(&read_fixture(name));
        let mut rng = Rng::new(13);
        let points: Vec<DVec3> = (0..500)
            .map(|_| DVec3::new(rng.range(0.2, 2.8), 0.0, rng.range(0.2, 2.8)))
            .collect();
        let start = std::time::Instant::now();
        let sum: DVec3 = points.iter().map(|&x| scene.irradiance(x, UP)).sum();
        let each = start.elapsed().as_secs_f64() * 1e6 / points.len() as f64;
        eprintln!(
            "{name}: {each:.1} µs a point (mean irradiance {:.6})",
            sum.x / points.len() as f64
        );
        // The light is linear over a nanometre: what the third difference shows is round-off.
        let step = DVec3::X * 1e-9;
        let mut worst: f64 = 0.0;
        let mut squares = 0.0;
        for &x in &points {
            let at = |k: f64| scene.irradiance(x + step * k, UP).x;
            let third = at(3.0) - 3.0 * at(2.0) + 3.0 * at(1.0) - at(0.0);
            worst = worst.max(third.abs());
            squares += third * third / 20.0;
        }
        let rms = (squares / points.len() as f64).sqrt();
        eprintln!("  round-off {rms:.1e} rms, worst third difference {worst:.1e}");
    }
    let scene = DirectReference::new(&read_fixture("blinds"));
    let tracer = PathTracer::new(&read_fixture("blinds"));
    for x in [DVec3::new(1.2, 0.0, 0.46), DVec3::new(2.7, 0.0, 1.4)] {
        let exact = scene.irradiance(x, UP).x;
        let settings = PathSettings {
            paths: 1_000_000,
            bounces: 0,
            seed: 37,
            from_emitters: true,
        };
        let traced = tracer.irradiance(x, UP, &settings);
        let (off, error) = (traced.mean.x / exact - 1.0, traced.standard_error.x / exact);
        eprintln!("blinds, a million random points: off by {off:.1e} ± {error:.1e}");
        for least in 5..=8 {
            let cast = scene.irradiance_by_casting(x, UP, least..=9).x;
            eprintln!(
                "blinds, cast from depth {least}: off by {:.1e}",
                cast / exact - 1.0
            );
        }
    }
}

#[test]
#[ignore = "prints measurements"]
fn measure_what_kinks_can_be_seen() {
    for noise in [1e-15, 1e-14, 1e-12, 1e-10] {
        for order in 0..=2 {
            let (mut smallest, mut misplaced) = (f64::INFINITY, 0.0);
            for tenth in 0..=130 {
                let size = 10_f64.powf(1.0 - f64::from(tenth) / 10.0);
                let mut rng = Rng::new(31);
                let all = (0..30).all(|_| {
                    let at = rng.range(0.1, 0.9);
                    let wobble = std::cell::RefCell::new(rng.clone());
                    let f = |t: f64| {
                        broken(t, &[(at, order, size)])
                            + noise * wobble.borrow_mut().range(-1.0, 1.0)
                    };
                    let settings = KinkSettings {
                        noise: noise.max(1e-14),
                        ..KinkSettings::default()
                    };
                    let found = find_kinks(&f, (0.0, 1.0), &settings);
                    let is_right = found.len() == 1 && i32::from(found[0].order) == order;
                    if is_right {
                        misplaced = f64::max(misplaced, (found[0].t - at).abs());
                    }
                    is_right
                });
                if !all {
                    break;
                }
                smallest = size;
            }
            eprintln!(
                "noise {noise:e}, order {order}: jumps down to {smallest:.1e} seen (at most {misplaced:.1e} away)"
            );
        }
    }
    for orders in [[1, 1], [1, 2], [2, 2], [0, 0]] {
        // The greatest distance at which some of fifty pairs are not seen as what they are.
        let mut worst = (0.0, Vec::new());
        let mut rng = Rng::new(41);
        for step in 0..50 {
            let distance = 0.1 * 0.87_f64.powi(step);
            for _ in 0..50 {
                let at = rng.range(0.2, 0.7);
                let breaks = [(at, orders[0], 1.0), (at + distance, orders[1], 1.0)];
                let found: Vec<i32> = kinks_of(&breaks)
                    .iter()
                    .map(|k| i32::from(k.order))
                    .collect();
                if found != orders && distance > worst.0 {
                    worst = (distance, found);
                }
            }
        }
        eprintln!(
            "orders {orders:?}: all told apart above a distance of {:.1e} (there: {:?})",
            worst.0, worst.1
        );
    }
    let scene = DirectReference::new(&read_fixture("rotated-blocker"));
    let count = std::cell::Cell::new(0);
    let along = |x: f64| {
        count.set(count.get() + 1);
        scene.irradiance(DVec3::new(x, 0.0, 0.1), UP).x
    };
    let found = find_kinks(&along, (-2.7, 2.9), &KinkSettings::default());
    eprintln!(
        "rotated-blocker, one line: {} kinks in {} evaluations",
        found.len(),
        count.get()
    );
    for kink in found {
        eprintln!("  {kink:?}");
    }
}
