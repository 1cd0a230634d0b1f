//! Random soups on a small lattice, where everything touches, overlaps and repeats: nothing panics, what comes out is valid.

use super::*;

/// Knuth's 64-bit linear congruential generator, high bits.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        u32::try_from(self.0 >> 33).expect("31 bits") % n
    }
}

/// Polygons of three to six corners over points of a lattice, each moved by up to `jitter`.
fn random_soup(seed: u64, size: [u32; 3], polygons: u32, jitter: f64) -> RawScene {
    let mut random = Random(seed);
    let mut raw = soup(&[], &[]);
    for _ in 0..polygons {
        let corners = 3 + random.below(4);
        let first = u32::try_from(raw.positions.len()).expect("few positions");
        for _ in 0..corners {
            let mut coordinate = |n: u32| {
                let noise = f64::from(random.below(1 << 20)) / f64::from(1 << 20) - 0.5;
                f64::from(random.below(n)) + 2.0 * jitter * noise
            };
            raw.positions.push(DVec3::from(size.map(&mut coordinate)));
        }
        raw.polygons.push(RawPolygon {
            corners: (first..first + corners).collect(),
            material: if random.below(2) == 0 {
                GREY
            } else {
                ONE_SIDED
            },
            group: 0,
        });
    }
    raw
}

fn check(raw: &RawScene, what: &str) {
    let Ok((scene, report, _)) = clean(raw, &CleanSettings::default()) else {
        return;
    };
    scene
        .check_invariants(report.planarity_m)
        .unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_separated(&scene);
}

#[test]
fn random_soups_come_out_valid() {
    for seed in 0..200 {
        for (size, polygons) in [([4, 4, 1], 6), ([3, 3, 3], 30), ([8, 8, 2], 60)] {
            for jitter in [0.0, 1e-9, 1e-6, 1e-5] {
                let raw = random_soup(seed, size, polygons, jitter);
                check(&raw, &format!("{seed} {size:?} {polygons} {jitter}"));
            }
        }
    }
}

#[test]
fn a_lattice_with_holes_and_pinches_keeps_its_area() {
    for seed in 0..50 {
        let mut random = Random(seed);
        let n = 6;
        let mut raw = soup(&[], &[]);
        let mut area = 0.0;
        for y in 0..n {
            for x in 0..n {
                // Leave cells out, so that holes and pinches of every kind occur.
                if random.below(3) == 0 {
                    continue;
                }
                area += 1.0;
                let first = u32::try_from(raw.positions.len()).expect("few positions");
                for (i, j) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                    raw.positions
                        .push(DVec3::new(f64::from(x + i), f64::from(y + j), 0.0));
                }
                let turn = random.below(4);
                let corner = |k: u32| first + (turn + k) % 4;
                for corners in [[0, 1, 2], [0, 2, 3]] {
                    raw.polygons.push(RawPolygon {
                        corners: corners.map(corner).to_vec(),
                        material: GREY,
                        group: 0,
                    });
                }
            }
        }
        let (scene, report) = cleaned(&raw);
        let got: f64 = scene.faces.iter().map(|(_, f)| f.area).sum();
        assert!((got - area).abs() < 1e-9, "seed {seed}: {got} of {area}");
        assert_eq!(
            (report.unmerged, report.self_crossing),
            (0, 0),
            "seed {seed}"
        );
    }
}
