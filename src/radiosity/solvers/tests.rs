//! Systems whose solution is known, without any geometry.

use super::row::{Link, Row};
use super::shooting::Until;
use super::system::{Block, Leaf, System};
use super::{Corners, Outcome, Problem, Solver, TooManyUnknowns, shooting, solve};
use crate::radiosity::Basis;
use crate::radiosity::tests::random;
use glam::DVec3;
use rayon::ThreadPoolBuilder;

/// One face for each row of `form_factors`, each one element.
fn system(form_factors: &[Vec<f64>], reflectance: impl Fn(usize) -> DVec3) -> System {
    let n = form_factors.len();
    let blocks = (0..n)
        .map(|i| Block {
            nodes: i..i + 1,
            cells: i..i + 1,
            reflectance: reflectance(i),
            leaves: vec![Leaf {
                cell: 0,
                area: 1.0,
                nodes: vec![(i as u32, [1.0; 3])],
            }],
            parents: Vec::new(),
        })
        .collect();
    let rows: Vec<Row> = form_factors
        .iter()
        .map(|row| {
            let link = |(j, f): (usize, &f64)| Link {
                cell: j as u32,
                weights: [f / 3.0; 3],
            };
            let links = row.iter().enumerate().filter(|l| *l.1 > 0.0).map(link);
            Row::exact(links.collect())
        })
        .collect();
    System::new(Basis::Constant, blocks, rows)
}

fn even(light: &[f64]) -> Vec<Corners> {
    light.iter().map(|&b| [DVec3::splat(b); 3]).collect()
}

fn solved(system: &System, direct: &[Corners], tolerance: f64, solver: Solver) -> Outcome {
    let problem = Problem {
        system,
        direct,
        tolerance,
    };
    solve(&problem, solver).expect("a small system")
}

/// The inside of a sphere cut into `n` uneven parts: form factors are areas over the whole.
fn sphere(n: usize, seed: u64) -> Vec<f64> {
    let mut next = random(seed);
    let mut areas: Vec<f64> = (0..n).map(|_| 0.1 + next()).collect();
    let sum: f64 = areas.iter().sum();
    areas.iter_mut().for_each(|a| *a /= sum);
    areas
}

/// A closed scene: random exchanges, symmetric as reciprocity asks for, over areas that make rows sum to 1.
fn room(n: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut next = random(seed);
    let half: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..i).map(|_| next().powi(4)).collect())
        .collect();
    let exchange = |i: usize, j: usize| {
        if i == j {
            0.0
        } else {
            half[i.max(j)][i.min(j)]
        }
    };
    let row = |i: usize| (0..n).map(move |j| exchange(i, j));
    (0..n)
        .map(|i| {
            let area: f64 = row(i).sum();
            row(i).map(|x| x / area).collect()
        })
        .collect()
}

/// Ceiling, floor, four walls.
fn cube() -> Vec<Vec<f64>> {
    // Closed forms: parallel and perpendicular unit squares (fixtures/analytic/form_factors.txt).
    let (across, beside) = (0.199_824_895_700_0, 0.200_043_776_075_4);
    let opposite = [1, 0, 4, 5, 2, 3];
    (0..6)
        .map(|i| {
            let f = |j: usize| match j {
                j if j == i => 0.0,
                j if j == opposite[i] => across,
                _ => beside,
            };
            (0..6).map(f).collect()
        })
        .collect()
}

#[test]
fn every_solver_lights_the_cube() {
    let text = include_str!("../../../fixtures/analytic/cube.txt");
    for line in text.lines().filter(|l| l.starts_with("cube")) {
        let known: Vec<f64> = line
            .split_whitespace()
            .skip(1)
            .map(|word| word.parse().expect("a number"))
            .collect();
        let [rho, ceiling, floor, wall] = known[..] else {
            panic!("{line}");
        };
        let system = system(&cube(), |_| DVec3::splat(rho));
        for solver in Solver::ALL {
            let direct = even(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let found = solved(&system, &direct, 1e-11, solver);
            assert!(found.is_settled, "{}", solver.name());
            for (i, b) in [ceiling, floor, wall, wall, wall, wall]
                .into_iter()
                .enumerate()
            {
                let own = direct[i][0].x + rho * found.x[i].x;
                assert!(
                    (own - b).abs() <= 1e-9,
                    "{} at ρ = {rho}: {own} for {b}",
                    solver.name()
                );
            }
        }
    }
}

#[test]
fn the_inside_of_a_sphere_is_lit_evenly() {
    // CIE 171:2006, sphere theory: E = Φ ρ / (S (1 − ρ)) besides the direct light, the same everywhere.
    let areas = sphere(50, 3);
    for rho in [0.1, 0.5, 0.9, 0.999] {
        let system = system(&vec![areas.clone(); 50], |_| DVec3::splat(rho));
        let mut light = vec![0.0; 50];
        light[7] = rho / areas[7];
        for solver in Solver::ALL {
            let found = solved(&system, &even(&light), 1e-10, solver);
            let known = rho / (1.0 - rho);
            for x in &found.x {
                assert!(
                    (x.x / known - 1.0).abs() < 1e-7,
                    "{} at ρ = {rho}: {} for {known}",
                    solver.name(),
                    x.x
                );
            }
        }
    }
}

#[test]
fn all_solvers_agree_on_random_rooms() {
    for seed in 1..4 {
        let n = 40;
        let mut next = random(100 + seed);
        // Channels that differ, faces that reflect nothing, light that differs by 10¹².
        let reflectances: Vec<DVec3> = (0..n)
            .map(|i| DVec3::new(next(), 0.95 * next(), if i % 3 == 0 { 0.0 } else { 0.9 }))
            .collect();
        let system = system(&room(n, seed), |i| reflectances[i]);
        let light: Vec<f64> = (0..n).map(|_| 10_f64.powf(12.0 * next() - 12.0)).collect();
        let known = solved(&system, &even(&light), 1e-10, Solver::Lu);
        let largest = known.x.iter().map(|x| x.max_element()).fold(1.0, f64::max);
        for solver in Solver::ALL {
            let found = solved(&system, &even(&light), 1e-10, solver);
            assert!(found.is_settled, "{}", solver.name());
            for (a, b) in found.x.iter().zip(&known.x) {
                let off = (*a - *b).abs().max_element() / largest;
                assert!(off < 1e-9, "{}: {a} for {b}", solver.name());
            }
        }
    }
}

#[test]
fn stiff_rooms_need_gmres() {
    let (n, rho) = (25, 0.9999);
    let rows = room(n, 11);
    let system = system(&rows, |_| DVec3::splat(rho));
    let light = vec![1.0 - rho; n];
    let tolerance = 1e-5;
    let by_sweeps = solved(&system, &even(&light), tolerance, Solver::GaussSeidel);
    let by_choice = solved(&system, &even(&light), tolerance, Solver::Hierarchical);
    let by_gmres = solved(&system, &even(&light), tolerance, Solver::Gmres);
    for outcome in [&by_sweeps, &by_choice, &by_gmres] {
        // M = 1 − ρ everywhere: B = 1 everywhere.
        for x in &outcome.x {
            let b = 1.0 - rho + rho * x.x;
            assert!((b - 1.0).abs() < 1e-3, "{}: {b}", outcome.method.name());
        }
    }
    assert_eq!(by_choice.method, Solver::Gmres, "{}", by_choice.reason);
    assert!(
        by_sweeps.residuals.len() > 2000,
        "{}",
        by_sweeps.residuals.len()
    );
    assert!(
        by_gmres.residuals.len() <= 60,
        "{}",
        by_gmres.residuals.len()
    );
    assert!(
        by_choice.residuals.len() <= 60,
        "{}",
        by_choice.residuals.len()
    );
}

#[test]
fn light_that_nothing_absorbs_is_not_said_to_be_settled() {
    let system = system(&room(20, 5), |_| DVec3::ONE);
    let light = even(&[1.0; 20]);
    for solver in [Solver::Gmres, Solver::Hierarchical, Solver::Lu] {
        let found = solved(&system, &light, 1e-4, solver);
        assert!(!found.is_settled, "{}", solver.name());
    }
}

#[test]
fn no_light_is_no_work() {
    let system = system(&room(20, 6), |_| DVec3::splat(0.5));
    for solver in Solver::ALL {
        let found = solved(&system, &even(&[0.0; 20]), 1e-6, solver);
        assert!(found.is_settled && found.x.iter().all(|x| *x == DVec3::ZERO));
        assert!(
            found.residuals.len() <= 2 && found.shots == 0,
            "{}",
            solver.name()
        );
    }
}

#[test]
fn threads_change_no_bit_of_any_solver() {
    let system = system(&room(90, 8), |i| {
        DVec3::new(0.3, 0.6, 0.99 - 0.01 * i as f64)
    });
    let light: Vec<f64> = (0..90).map(|i| 1.0 / (1.0 + i as f64)).collect();
    for solver in Solver::ALL {
        let run = |threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.expect("threads can be started");
            pool.install(|| solved(&system, &even(&light), 1e-8, solver))
        };
        let (one, three) = (run(1), run(3));
        assert_eq!(one.residuals, three.residuals, "{}", solver.name());
        assert!(one.x == three.x, "{}", solver.name());
    }
}

#[test]
fn the_first_shots_and_the_ambient_estimate_are_a_preview() {
    let n = 40;
    let system = system(&room(n, 21), |_| DVec3::splat(0.7));
    let mut next = random(22);
    let light: Vec<f64> = (0..n).map(|_| next().powi(8)).collect();
    let direct = even(&light);
    let known = solved(&system, &direct, 1e-10, Solver::Lu);
    let problem = Problem {
        system: &system,
        direct: &direct,
        tolerance: 1e-10,
    };
    let off = |outcome: &Outcome| -> f64 {
        let squares = outcome
            .x
            .iter()
            .zip(&known.x)
            .map(|(a, b)| (a.x - b.x).powi(2));
        let all: f64 = known.x.iter().map(|b| b.x * b.x).sum();
        (squares.sum::<f64>() / all).sqrt()
    };
    let mut last = f64::INFINITY;
    for shots in [1, 5, 20, 80] {
        let (bare, ambient) = shooting::solve(&problem, None, Until::Shots(shots));
        assert_eq!(bare.shots, shots);
        let mut preview = bare.clone();
        preview.x.iter_mut().for_each(|x| *x += ambient);
        let (found, without) = (off(&preview), off(&bare));
        assert!(
            found < 0.5 * without,
            "{shots} shots: {found} and {without}"
        );
        assert!(found < last, "{shots} shots: {found} after {last}");
        last = found;
    }
    assert!(last < 0.02, "{last}");
}

#[test]
fn shots_go_to_the_brightest_face_first() {
    let n = 12;
    let system = system(&room(n, 31), |_| DVec3::splat(0.5));
    let mut light = vec![1e-3; n];
    light[4] = 1.0;
    let direct = even(&light);
    let problem = Problem {
        system: &system,
        direct: &direct,
        tolerance: 1e-6,
    };
    // All that has come after one shot is what the brightest face sends.
    let (preview, _) = shooting::solve(&problem, None, Until::Shots(1));
    let rows = room(n, 31);
    for (x, row) in preview.x.iter().zip(&rows) {
        assert!((x.x - row[4]).abs() < 1e-12);
    }
}

#[test]
fn a_dense_matrix_has_a_limit() {
    let n = 5001;
    let system = system(&vec![Vec::new(); n], |_| DVec3::splat(0.5));
    let direct = even(&vec![1.0; n]);
    let problem = Problem {
        system: &system,
        direct: &direct,
        tolerance: 1e-4,
    };
    let refused = solve(&problem, Solver::Lu).expect_err("too many unknowns");
    assert_eq!(refused, TooManyUnknowns { unknowns: n });
    assert!(refused.to_string().contains("limit 5000"), "{refused}");
}

#[test]
fn shooting_goes_on_from_what_has_arrived() {
    let n = 30;
    let (rows, next) = (room(n, 41), &mut random(42));
    let system = system(&rows, |_| DVec3::splat(0.8));
    let light: Vec<f64> = (0..n).map(|_| next()).collect();
    let direct = even(&light);
    let problem = Problem {
        system: &system,
        direct: &direct,
        tolerance: 1e-10,
    };
    let (known, _) = shooting::solve(&problem, None, Until::Settled);
    // From what other links, a tenth off, have brought: too much here, too little there.
    let other = known.x.iter().map(|x| *x * (0.9 + 0.2 * next())).collect();
    let (found, left) = shooting::solve(&problem, Some(other), Until::Settled);
    assert!(found.is_settled && found.shots < known.shots);
    assert!(left.max_element() < 1e-8, "{left}");
    for (a, b) in found.x.iter().zip(&known.x) {
        assert!(a.distance(*b) < 1e-8, "{a} for {b}");
    }
    // Enough is less than all.
    let (some, left) = shooting::solve(&problem, None, Until::Ambient(0.01));
    assert!(left.max_element() <= 0.01 && some.shots < known.shots);
}
