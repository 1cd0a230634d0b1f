//! What the lines are worth: elements against a uniform mesh with the same error.

use crate::common::bake::{bake, world};
use crate::common::rng::Rng;
use rayon::prelude::*;
use umbrage::adapt::Receiver;
use umbrage::direct::DirectLight;
use umbrage::mesh::{FaceDomain, ReceiverMesh};
use umbrage::pipeline::Solution;
use umbrage::quantity::Irradiance;
use umbrage::radiosity::Bounces;
use umbrage::visibility::{Scratch, Viewpoint};

/// Scenes at an error of 1 %, and how many times as many elements a uniform mesh needs at least.
///
/// Lines pay where the light or its slope jumps. At D2 lines only the curvature does: linear elements converge there as fast
/// without them, and what is saved is what adaptation saves anywhere.
const SCENES: [(&str, f64); 6] = [
    ("blocker-touching-floor", 10.0),
    ("box-on-table", 8.0),
    ("square-over-square", 4.0),
    ("crossing-blockers", 2.5),
    ("rotated-blocker", 1.6),
    ("tilted-triangle", 1.6),
];

/// Points at which both meshes are measured.
const POINTS: usize = 4000;

/// RMS error over one face of linear interpolation between `values` at the sites of `mesh`, W/m².
fn rms(
    light: &DirectLight,
    domain: &FaceDomain,
    mesh: &ReceiverMesh,
    values: &[Irradiance],
) -> f64 {
    let mut sums = vec![0.0];
    for e in 0..mesh.elements.len() {
        sums.push(sums[e] + mesh.area(e));
    }
    let total = sums[mesh.elements.len()];
    let mut rng = Rng::new(19);
    let points: Vec<(usize, [f64; 3])> = (0..POINTS)
        .map(|i| {
            let at = total * (i as f64 + rng.unit()) / POINTS as f64;
            let e = sums.partition_point(|&s| s <= at) - 1;
            let (mut a, mut b) = (rng.unit(), rng.unit());
            if a + b > 1.0 {
                (a, b) = (1.0 - a, 1.0 - b);
            }
            (e.min(mesh.elements.len() - 1), [1.0 - a - b, a, b])
        })
        .collect();
    let squares: Vec<f64> = points
        .par_iter()
        .map_init(Scratch::default, |scratch, &(e, w)| {
            let corners = mesh.corners(e);
            let p = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
            let exact = light.irradiance(&view(domain, p), scratch);
            let [a, b, c] = mesh.sites[e].map(|s| values[s as usize]);
            (a * w[0] + b * w[1] + c * w[2] - exact).0.mean_square()
        })
        .collect();
    (squares.iter().sum::<f64>() / POINTS as f64).sqrt()
}

fn view(domain: &FaceDomain, p: glam::DVec2) -> Viewpoint {
    Viewpoint::new(domain.frame.to_space(p), domain.normal)
}

/// The face that the shadow falls on: the largest lit one.
fn floor<'a>(solution: &'a Solution) -> &'a Receiver {
    let lit = solution.receivers.iter().filter(|r| r.is_lit);
    lit.max_by(|a, b| a.area().total_cmp(&b.area()))
        .expect("something is lit")
}

/// Elements of the first uniform mesh, spacings falling by 7 %, that is at least as good as `target`; its RMS error.
fn uniform(light: &DirectLight, domain: &FaceDomain, start: f64, target: f64) -> (usize, f64) {
    let mut spacing = start;
    loop {
        let points = domain.seed_points(spacing);
        let mesh = domain.mesh(&[], &points).expect("the face can be meshed");
        let values: Vec<Irradiance> = mesh
            .site_points
            .par_iter()
            .map_init(Scratch::default, |scratch, &p| {
                light.irradiance(&view(domain, p), scratch)
            })
            .collect();
        let found = rms(light, domain, &mesh, &values);
        if found <= target {
            return (mesh.elements.len(), found);
        }
        spacing *= 0.93;
    }
}

fn ratio(name: &str, error: f64) -> f64 {
    let world = world(name);
    let solution = bake(&world, error, Bounces::Count(0));
    let floor = floor(&solution);
    let (light, domain) = (&solution.direct, &floor.domain);
    let target = rms(light, domain, &floor.mesh, &floor.direct);
    let (count, found) = uniform(light, domain, world.scene.diagonal / 12.0, target);
    let own = floor.mesh.elements.len();
    let ratio = count as f64 / own as f64;
    eprintln!(
        "{name} at {error}: {own} elements along {} lines ({target:.2e} W/m²), {count} uniform ones ({found:.2e}): {ratio:.1} times",
        floor.kept().count()
    );
    ratio
}

#[test]
fn uniform_meshes_need_many_more_elements() {
    for (name, least) in SCENES {
        let found = ratio(name, 0.01);
        assert!(found >= least, "{name}: only {found:.1} times");
    }
}

#[test]
#[ignore = "prints how the ratio grows as the error shrinks"]
fn ratios_at_other_errors() {
    for (name, _) in SCENES {
        for error in [0.1, 0.03, 0.01, 0.003] {
            ratio(name, error);
        }
    }
}
