//! Every way to solve for the light between surfaces finds the same, and no power is lost.

use crate::common::bake::{bake, clean, raw, settings, surface_points, world};
use crate::common::fine_field::{direct_at, solve_mesh};
use glam::DVec3;
use rayon::ThreadPoolBuilder;
use umbrage::io::builtin::cornell_box;
use umbrage::io::write_glb;
use umbrage::pipeline::{LightError, Solution, World, light};
use umbrage::quantity::{Irradiance, Radiance, Rgb};
use umbrage::radiosity::{
    Basis, Bounces, IndirectField, Linking, Request, SolveReport, Solver, TooManyUnknowns,
};
use umbrage::scene::{Material, RawPolygon, RawScene};
use umbrage::settings::Settings;
use umbrage::visibility::{Scratch, Viewpoint};

/// Scenes of all kinds: rooms, open shadows, contacts, slats.
const FIXTURES: [&str; 10] = [
    "l-room",
    "furnace-cornell-r90",
    "furnace-box-r99",
    "box-on-table",
    "square-over-square",
    "two-emitters",
    "blocker-touching-floor",
    "wall-piercing-floor",
    "crossing-blockers",
    "emitter-with-hole",
];

/// What the solution of one fixture is asked for, in parts of the mean light.
fn request(solution: &Solution, solver: Solver) -> Request {
    let mean = solution.summary.measured.mean;
    Request {
        error: 0.05 * mean,
        ambient: solution.indirect.as_ref().map_or(0.0, IndirectField::mean),
        bounces: Bounces::All,
        tolerance: 1e-6,
        basis: Basis::Linear,
        linking: Linking::Hierarchical,
        solver,
    }
}

/// Solves anew on a mesh of its own.
fn solve<'a>(
    solution: &Solution<'a>,
    request: Request,
) -> Result<(IndirectField<'a>, SolveReport), TooManyUnknowns> {
    let mesh = solve_mesh(solution, 40.0).expect("the scene reflects");
    let blockers = &solution.world.blockers;
    IndirectField::solve(mesh, blockers, request, |face, _, p| {
        direct_at(solution, face, p)
    })
}

/// The indirect light at points of all faces.
fn readings(solution: &Solution, field: &IndirectField) -> Vec<DVec3> {
    surface_points(solution, 200, 5)
        .iter()
        .filter_map(|p| {
            let f = solution.receivers[p.receiver].solve_face?;
            Some(field.at(f, p.plane).0.0)
        })
        .collect()
}

fn largest(values: &[DVec3]) -> f64 {
    values
        .iter()
        .map(|v| v.abs().max_element())
        .fold(0.0, f64::max)
}

fn difference(a: &[DVec3], b: &[DVec3]) -> f64 {
    let off: Vec<DVec3> = a.iter().zip(b).map(|(a, b)| *a - *b).collect();
    largest(&off)
}

#[test]
fn all_solvers_agree_on_ten_fixtures() {
    for name in FIXTURES {
        let world = world(name);
        let solution = bake(&world, 0.3, Bounces::All);
        let bases = match name {
            "l-room" | "two-emitters" | "furnace-box-r99" => &Basis::ALL[..],
            _ => &Basis::ALL[..1],
        };
        for &basis in bases {
            let asked = request(&solution, Solver::Lu);
            let of = |solver| {
                let request = Request {
                    basis,
                    solver,
                    ..asked
                };
                let (field, report) = solve(&solution, request).expect("small enough");
                assert!(
                    report.is_settled,
                    "{name}: {} of {}",
                    solver.name(),
                    basis.name()
                );
                (readings(&solution, &field), report)
            };
            let (known, _) = of(Solver::Lu);
            for solver in Solver::ALL {
                let (found, report) = of(solver);
                // Shooting divides cells and refines links for the light that it has shot: what it solves is another system,
                // as good as is asked for. All others solve the same one.
                if solver == Solver::Progressive && basis != Basis::Constant {
                    let off = rms(&found, &known) / asked.error;
                    assert!(off <= 1.0, "{name}: shooting is off by {off} of the error");
                    continue;
                }
                // Of the largest radiosity, which direct light is part of.
                let off = difference(&found, &known) / largest(&known).max(f64::MIN_POSITIVE);
                assert!(
                    off <= 1e-5,
                    "{name}: {} of {} is off by {off:e} ({:?})",
                    solver.name(),
                    basis.name(),
                    report.residuals
                );
            }
        }
    }
}

/// RMS over points and channels, W/m².
fn rms(a: &[DVec3], b: &[DVec3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| a.distance_squared(*b));
    (squares.sum::<f64>() / (3 * a.len()) as f64).sqrt()
}

#[test]
fn the_hierarchy_is_as_good_as_its_links_are_asked_to_be() {
    for name in ["l-room", "furnace-cornell-r90", "box-on-table"] {
        let world = world(name);
        let solution = bake(&world, 0.3, Bounces::All);
        let asked = request(&solution, Solver::Lu);
        let of = |linking, error| {
            let request = Request {
                linking,
                error,
                ..asked
            };
            let (field, report) = solve(&solution, request).expect("small enough");
            (readings(&solution, &field), report.links)
        };
        for error in [asked.error, 0.2 * asked.error] {
            let (dense, all) = of(Linking::Leaves, error);
            let (hierarchical, few) = of(Linking::Hierarchical, error);
            let off = rms(&dense, &hierarchical);
            eprintln!(
                "{name}: {few} links for {all}, {:.4} of the error",
                off / error
            );
            assert!(few < all, "{name}: {few} links for {all}");
            assert!(off <= error, "{name}: off by {off} for {error}");
        }
    }
}

/// What the nodes of that solve mesh receive from cells divided for a twentieth of `asked.error`, W/m²: the default solver,
/// corrected by its own residual, which knows nothing of shots. Each correction leaves at most the reflectance's share.
fn on_fine_cells(solution: &Solution, asked: Request) -> Vec<DVec3> {
    let request = Request {
        error: 0.05 * asked.error,
        solver: Solver::default(),
        ..asked
    };
    let (mut field, _) = solve(solution, request).expect("it has no limit");
    for _ in 0..3 {
        let change = field.correct(|face, _, p| direct_at(solution, face, p));
        eprintln!("corrected by {:.4} of the error", change / asked.error);
    }
    readings(solution, &field)
}

#[test]
fn shooting_refines_links_where_its_light_asks_for_it() {
    for name in [
        "l-room",
        "furnace-cornell-r90",
        "box-on-table",
        "two-emitters",
        "crossing-blockers",
    ] {
        let world = world(name);
        let solution = bake(&world, 0.3, Bounces::All);
        let asked = request(&solution, Solver::Progressive);
        let known = on_fine_cells(&solution, asked);
        for error in [asked.error, 0.2 * asked.error] {
            let of = |linking, solver| {
                let request = Request {
                    error,
                    linking,
                    solver,
                    ..asked
                };
                let (field, report) = solve(&solution, request).expect("it has no limit");
                assert!(report.is_settled, "{name}: {}", report.method);
                (readings(&solution, &field), report)
            };
            // The same cells, all leaves linked on the last level.
            let (all, uniform) = of(Linking::Leaves, Solver::Progressive);
            let (at_once, fixed) = of(Linking::Hierarchical, Solver::default());
            let (found, shot) = of(Linking::Hierarchical, Solver::Progressive);
            let off = [&found, &all, &at_once].map(|x| rms(x, &known) / error);
            let by_links = rms(&found, &all) / error;
            eprintln!(
                "{name}: {} of {} over {} cells, at once {} over {}; off by {off:.4?}, {by_links:.4} by links, in parts of the error",
                shot.reason, uniform.links, shot.cells, fixed.links, fixed.cells,
            );
            assert_eq!(shot.cells, uniform.cells, "{name}");
            assert!(shot.links < uniform.links, "{name}");
            assert!(by_links <= 1.0, "{name}: off by {by_links} of the error");
            assert!(off[0] <= 1.0, "{name}: off by {} of the error", off[0]);
        }
    }
}

#[test]
fn wavelets_tell_the_same_by_fewer_links() {
    for name in [
        "l-room",
        "furnace-cornell-r90",
        "box-on-table",
        "two-emitters",
    ] {
        let world = world(name);
        let solution = bake(&world, 0.3, Bounces::All);
        let asked = request(&solution, Solver::Gmres);
        let of = |basis, linking, error| {
            let request = Request {
                basis,
                linking,
                error,
                ..asked
            };
            let (field, report) = solve(&solution, request).expect("it has no limit");
            assert!(report.is_settled, "{name}: {}", basis.name());
            (readings(&solution, &field), report)
        };
        for error in [asked.error, 0.2 * asked.error] {
            // Where nothing may be left out it is the same system in another basis.
            let (all, dense) = of(Basis::Linear, Linking::Leaves, error);
            let (same, _) = of(Basis::Wavelet, Linking::Leaves, error);
            let off = difference(&same, &all) / largest(&all);
            assert!(off <= 1e-5, "{name}: another basis is off by {off:e}");
            let (_, linear) = of(Basis::Linear, Linking::Hierarchical, error);
            let (found, report) = of(Basis::Wavelet, Linking::Hierarchical, error);
            let off = rms(&found, &all);
            let left_out = report.wavelets.expect("that is the basis");
            eprintln!(
                "{name}: {} links for {} of {}, {:.4} of the error; {left_out:?}",
                report.links,
                linear.links,
                dense.links,
                off / error
            );
            assert!(off <= error, "{name}: off by {off} for {error}");
            assert!(report.links < linear.links, "{name}");
            assert!(left_out.dropped_functions < left_out.functions, "{name}");
        }
    }
}

/// A closed room of which all surfaces reflect `rho` and one polygon shines with 1 W/(m² sr).
fn closed(
    name: &str,
    positions: Vec<DVec3>,
    polygons: Vec<Vec<u32>>,
    lamp: usize,
    rho: f64,
) -> RawScene {
    let material = |name: &str, radiance| Material {
        name: name.to_owned(),
        reflectance: Rgb::grey(rho),
        emission: Radiance(Rgb::grey(radiance)),
        ..Material::default()
    };
    RawScene {
        source: name.to_owned(),
        positions,
        polygons: polygons
            .into_iter()
            .enumerate()
            .map(|(i, corners)| RawPolygon {
                corners,
                material: u32::from(i == lamp),
                group: 0,
            })
            .collect(),
        materials: vec![material("wall", 0.0), material("lamp", 1.0)],
        groups: vec!["room".to_owned()],
        ..RawScene::default()
    }
}

/// The inside of a sphere of 4ᵏ · 8 facets, radius 1.
fn sphere(divisions: u32, rho: f64) -> RawScene {
    let axes = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
    let mut triangles = Vec::new();
    for k in 0..4 {
        let (a, b) = (axes[k], axes[(k + 1) % 4]);
        // Counter-clockwise seen from inside.
        triangles.push([b, a, DVec3::Z]);
        triangles.push([a, b, DVec3::NEG_Z]);
    }
    for _ in 0..divisions {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [x, y, z] = [
                    (a + b).normalize(),
                    (b + c).normalize(),
                    (c + a).normalize(),
                ];
                [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
            })
            .collect();
    }
    let index = |i: usize| u32::try_from(3 * i).expect("few triangles");
    let polygons = (0..triangles.len()).map(|i| (0..3).map(|k| index(i) + k).collect());
    let polygons: Vec<Vec<u32>> = polygons.collect();
    closed("sphere", triangles.concat(), polygons, 0, rho)
}

/// Mean of the channels over random points, and the largest distance from it.
fn indirect(solution: &Solution) -> (f64, f64) {
    let field = solution.indirect.as_ref().expect("the room reflects");
    let mut gatherer = field.gatherer();
    let found: Vec<f64> = surface_points(solution, 400, 9)
        .iter()
        .map(|p| field.gather(&mut gatherer, &p.view(solution)).mean())
        .collect();
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let off = found.iter().map(|e| (e - mean).abs()).fold(0.0, f64::max);
    (mean, off)
}

/// Mean indirect irradiance of a closed room whose surfaces all reflect alike (CIE 171:2006, sphere theory), W/m².
fn sphere_theory(solution: &Solution, rho: f64) -> f64 {
    let area: f64 = solution.receivers.iter().map(|r| r.area()).sum();
    let flux: f64 = solution
        .direct
        .polygons
        .iter()
        .map(|lamp| {
            let c = &lamp.corners;
            let twice: DVec3 = (0..c.len()).map(|i| c[i].cross(c[(i + 1) % c.len()])).sum();
            lamp.exitance.mean() * 0.5 * twice.length()
        })
        .sum();
    flux * rho / (area * (1.0 - rho))
}

#[test]
fn the_inside_of_a_sphere_is_lit_evenly() {
    for (basis, rho) in [
        (Basis::Linear, 0.5),
        (Basis::Constant, 0.8),
        (Basis::Wavelet, 0.8),
    ] {
        let world = clean(&sphere(2, rho));
        let settings = Settings {
            basis,
            ..settings(0.02, Bounces::All)
        };
        let solution = light(&world, &settings, &mut |_| {}).expect("a room");
        assert_eq!(
            solution.summary.lit_sides,
            world.scene.faces.len(),
            "outsides are dark"
        );
        let (mean, off) = indirect(&solution);
        let known = sphere_theory(&solution, rho);
        eprintln!("{}: {mean} for {known}, within {off}", basis.name());
        assert!((mean / known - 1.0).abs() < 0.01, "{mean} for {known}");
        // Facets are not the sphere: what they send each other is uneven by their width.
        assert!(off < 0.06 * known, "{off} about {mean}");
    }
}

#[test]
fn a_box_room_has_the_mean_of_sphere_theory() {
    for rho in [0.2, 0.5, 0.8, 0.95] {
        let corner = |i: u32| {
            DVec3::new(
                f64::from(i & 1) * 4.0,
                f64::from(i >> 1 & 1) * 3.0,
                f64::from(i >> 2) * 3.0,
            )
        };
        let polygons: Vec<Vec<u32>> = [
            [2, 3, 7, 6], // the ceiling shines
            [0, 4, 5, 1],
            [0, 1, 3, 2],
            [4, 6, 7, 5],
            [0, 2, 6, 4],
            [1, 5, 7, 3],
        ]
        .map(Vec::from)
        .into();
        let raw = closed("box", (0..8).map(corner).collect(), polygons, 0, rho);
        let world = clean(&raw);
        let solution = bake(&world, 0.01, Bounces::All);
        let (mean, _) = indirect(&solution);
        let known = sphere_theory(&solution, rho);
        assert!(
            (mean / known - 1.0).abs() < 0.01,
            "ρ = {rho}: {mean} for {known}"
        );
        let energy = solution.summary.energy.as_ref().expect("all bounces");
        assert!(
            energy.is_balanced && energy.escaped_w == [0.0; 3],
            "{energy:?}"
        );
    }
}

/// The room of a furnace with another reflectance: everywhere B = 1 W/m².
fn furnace(name: &str, rho: f64) -> World {
    let mut raw = raw(name);
    for material in &mut raw.materials {
        material.reflectance = Rgb::grey(rho);
        material.emission = Radiance(Rgb::grey((1.0 - rho) / std::f64::consts::PI));
    }
    clean(&raw)
}

#[test]
fn furnaces_that_lose_next_to_nothing_take_few_steps() {
    for name in ["furnace-box-r99", "furnace-l-room-r99"] {
        let rho = 0.9999;
        let world = furnace(name, rho);
        let solution = bake(&world, 0.01, Bounces::All);
        let solve = &solution.summary.solve;
        eprintln!(
            "{name}: {} steps of {}",
            solve.residuals.len(),
            solve.method
        );
        assert_eq!(solve.method, "gmres", "{name}: {}", solve.reason);
        assert!(solve.residuals.len() <= 60, "{name}: {:?}", solve.residuals);
        let (mut scratch, field) = (Scratch::default(), solution.indirect.as_ref());
        let field = field.expect("the room reflects");
        let mut gatherer = field.gatherer();
        for p in surface_points(&solution, 200, 3) {
            let view: Viewpoint = p.view(&solution);
            let direct: Irradiance = solution.direct.irradiance(&view, &mut scratch);
            let arriving = direct + field.gather(&mut gatherer, &view);
            let b = 1.0 - rho + rho * arriving.mean();
            assert!(
                (b - 1.0).abs() <= 1e-3,
                "{name}: {b} W/m² at {}",
                view.position
            );
        }
    }
}

#[test]
fn threads_change_no_byte_of_any_solver() {
    let world = world("l-room");
    for (solver, basis) in Solver::ALL
        .map(|s| (s, Basis::Linear))
        .into_iter()
        .chain([Basis::Constant, Basis::Wavelet].map(|b| (Solver::Hierarchical, b)))
    {
        let bytes = |threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build();
            let settings = Settings {
                solver,
                basis,
                ..settings(0.2, Bounces::All)
            };
            pool.expect("threads can be started").install(|| {
                let solution = light(&world, &settings, &mut |_| {}).expect("a room");
                assert!(solution.summary.solve.is_settled);
                (write_glb(&solution.lit_scene()), solution.summary.energy)
            })
        };
        let (one, three) = (bytes(1), bytes(3));
        assert!(one == three, "{} of {}", solver.name(), basis.name());
    }
}

#[test]
fn power_is_neither_lost_nor_made() {
    let error = 0.03;
    let mut worlds: Vec<World> = FIXTURES.map(world).into();
    worlds.push(clean(&cornell_box()));
    for world in &worlds {
        for bounces in [Bounces::All, Bounces::Count(0)] {
            let solution = bake(world, error, bounces);
            let energy = solution.summary.energy.as_ref().expect("an account");
            eprintln!(
                "{} {bounces:?}: off by {:.3} %",
                world.scene.source,
                100.0 * energy.imbalance
            );
            assert!(energy.is_balanced, "{}: {energy:?}", world.scene.source);
            assert_eq!(energy.is_balanced, energy.imbalance.abs() <= error);
        }
    }
}

#[test]
fn light_that_is_made_up_shows_in_the_account() {
    let world = clean(&cornell_box());
    let mut solution = bake(&world, 0.02, Bounces::All);
    assert!(solution.energy().expect("an account").is_balanced);
    for receiver in &mut solution.receivers {
        for e in &mut receiver.indirect {
            *e = *e * 1.2;
        }
    }
    let energy = solution.energy().expect("an account");
    assert!(
        !energy.is_balanced && energy.imbalance < -0.05,
        "{energy:?}"
    );
    assert!(
        bake(&world, 0.2, Bounces::Count(2))
            .summary
            .energy
            .is_none()
    );
}

#[test]
fn what_misses_a_square_escapes() {
    // Unit squares 1 m apart: 0.1998248957 of the lamp's light meets the other one.
    let mut positions = Vec::new();
    for y in [0.0, 1.0] {
        for (x, z) in [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)] {
            positions.push(DVec3::new(x, y, z));
        }
    }
    let polygons = vec![vec![0, 1, 2, 3], vec![7, 6, 5, 4]];
    let mut raw = closed("two squares", positions, polygons, 1, 0.0);
    raw.materials[0].reflectance = Rgb::BLACK;
    let world = clean(&raw);
    let solution = bake(&world, 0.01, Bounces::All);
    let energy = solution.summary.energy.as_ref().expect("an account");
    let share = energy.escaped_w[0] / energy.emitted_w[0];
    assert!((share - (1.0 - 0.199_824_895_7)).abs() < 2e-3, "{share}");
    assert!((energy.emitted_w[0] - std::f64::consts::PI).abs() < 1e-12);
    assert!(energy.is_balanced, "{energy:?}");
}

#[test]
fn light_that_nothing_absorbs_is_refused() {
    let mut raw = raw("furnace-box-r99");
    for material in &mut raw.materials {
        material.reflectance = Rgb::grey(1.0);
        material.emission = Radiance(Rgb::grey(1.0));
    }
    let world = clean(&raw);
    let refused = light(&world, &settings(0.1, Bounces::All), &mut |_| {});
    let Err(LightError::Input(refused)) = refused else {
        panic!("not refused");
    };
    let text = refused.to_string();
    assert!(text.contains("lower the reflectances"), "{text}");
}

#[test]
fn too_many_unknowns_for_a_dense_matrix_are_refused() {
    let world = clean(&cornell_box());
    let settings = Settings {
        solver: Solver::Lu,
        ..settings(1e-6, Bounces::All)
    };
    // Told before the display mesh is made, which would take minutes.
    let Err(LightError::Input(refused)) = light(&world, &settings, &mut |_| {}) else {
        panic!("not refused");
    };
    let text = refused.to_string();
    assert!(text.contains("limit 5000"), "{text}");
    assert!(text.contains("--solver gmres"), "{text}");
}
