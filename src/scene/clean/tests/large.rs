//! Large soups.

use super::*;
use std::time::Instant;

/// A grid of `n × n` cells of two triangles each over `height`.
fn terrain(n: u32, height: impl Fn(u32, u32) -> f64) -> RawScene {
    let mut raw = soup(&[], &[]);
    for y in 0..=n {
        for x in 0..=n {
            raw.positions
                .push(DVec3::new(f64::from(x), height(x, y), -f64::from(y)));
        }
    }
    for y in 0..n {
        for x in 0..n {
            let a = y * (n + 1) + x;
            for corners in [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]] {
                raw.polygons.push(RawPolygon {
                    corners: corners.to_vec(),
                    material: GREY,
                    group: 0,
                });
            }
        }
    }
    raw
}

/// A cheap hash to [0, 1): no two neighbouring cells are coplanar.
fn noise(x: u32, y: u32) -> f64 {
    let h = (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663)).wrapping_mul(2_654_435_761);
    f64::from(h >> 8) / f64::from(1 << 24)
}

#[test]
fn only_the_flat_part_of_a_terrain_merges() {
    let n = 200;
    let flat_to = 100;
    let raw = terrain(n, |x, y| if x <= flat_to { 0.0 } else { noise(x, y) });
    // At the default planarity some forty of 60 000 rough neighbours would be flat enough by chance.
    let exact = CleanSettings {
        planarity: Some(1e-9),
        ..CleanSettings::default()
    };
    let (_, report, _) = clean(&raw, &exact).expect("it has faces");
    let rough_triangles = 2 * (n - flat_to) * n;
    assert_eq!(report.faces, 1 + rough_triangles as usize);
}

#[test]
#[ignore = "measures time"]
fn three_hundred_thousand_triangles() {
    let mut raw = terrain(380, |x, y| if x <= 100 { 0.0 } else { noise(x, y) });
    for i in 0..1000_u32 {
        let shift = DVec3::new(f64::from(i % 40) * 9.0, 5.0, -f64::from(i / 40) * 9.0);
        let first = u32::try_from(raw.positions.len()).expect("few positions");
        let one = cube();
        raw.positions
            .extend(one.positions.iter().map(|&p| p + shift));
        raw.polygons.extend(one.polygons.into_iter().map(|mut p| {
            p.corners.iter_mut().for_each(|c| *c += first);
            p
        }));
    }
    let start = Instant::now();
    let (scene, report, _) = clean(&raw, &CleanSettings::default()).expect("it has faces");
    eprintln!(
        "{} polygons in {:?}: {report:?}",
        raw.polygons.len(),
        start.elapsed()
    );
    scene
        .check_invariants(report.planarity_m)
        .expect("the scene is valid");
}
