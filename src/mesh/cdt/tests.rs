use super::*;
use crate::mesh::tests::{KINDS, Random, points, segments};
use crate::mesh::{Segment, arrange};

/// Sources of outline segments start here; breaks are numbered from 0.
const OUTLINE: u32 = 1000;

fn is_outline(source: u32) -> bool {
    source >= OUTLINE
}

fn is_break(source: u32) -> bool {
    source < OUTLINE
}

/// Closed loops as segments with outline sources, each its own.
fn outline(loops: &[&[[i64; 2]]]) -> Vec<Segment> {
    let sides = loops.iter().flat_map(|l| {
        let next = l.iter().cycle().skip(1);
        l.iter().zip(next)
    });
    sides
        .zip(OUTLINE..)
        .map(|((a, b), source)| segment(*a, *b, source))
        .collect()
}

fn segment([ax, ay]: [i64; 2], [bx, by]: [i64; 2], source: u32) -> Segment {
    Segment {
        a: GridPoint::new(ax, ay),
        b: GridPoint::new(bx, by),
        source,
    }
}

/// A face from end to end.
struct Face {
    arrangement: Arrangement,
    triangulation: Triangulation,
    inside: Vec<bool>,
}

impl Face {
    fn new(loops: &[&[[i64; 2]]], breaks: &[[[i64; 2]; 2]]) -> Self {
        let mut all = outline(loops);
        all.extend(breaks.iter().zip(0..).map(|([a, b], s)| segment(*a, *b, s)));
        Self::of(&all, &[])
    }

    fn of(segments: &[Segment], points: &[GridPoint]) -> Self {
        let arrangement = arrange(segments, points);
        let triangulation = triangulate(&arrangement).expect("arrangements triangulate");
        check(&triangulation, &arrangement);
        let inside = inside(&triangulation, &arrangement, is_outline);
        Self {
            arrangement,
            triangulation,
            inside,
        }
    }

    /// Twice the area of the inside triangles, square pixels.
    fn area2(&self) -> i128 {
        let inside = self.inside.iter().zip(&self.triangulation.triangles);
        inside
            .filter(|(i, _)| **i)
            .map(|(_, t)| area2(&self.triangulation, *t))
            .sum()
    }

    /// Twice the area of each region.
    fn region_areas2(&self, is_barrier: impl Fn(u32) -> bool) -> Vec<i128> {
        let (t, a) = (&self.triangulation, &self.arrangement);
        let mut areas = Vec::new();
        for (region, corners) in regions(t, a, &self.inside, is_barrier)
            .iter()
            .zip(&t.triangles)
        {
            let Some(r) = region.map(|r| r as usize) else {
                continue;
            };
            areas.resize(areas.len().max(r + 1), 0);
            areas[r] += area2(t, *corners);
        }
        areas
    }

    fn sites(&self, is_barrier: impl Fn(u32) -> bool) -> Sites {
        sectors(
            &self.triangulation,
            &self.arrangement,
            &self.inside,
            is_barrier,
        )
    }

    /// How many sites the vertex at `(x, y)` has with the breaks as barriers.
    fn sites_at(&self, x: i64, y: i64) -> usize {
        let vertices = self.sites(is_break).vertices;
        let here = |v: &u32| self.triangulation.vertices[*v as usize] == GridPoint::new(x, y);
        vertices.iter().filter(|v| here(v)).count()
    }
}

fn area2(triangulation: &Triangulation, corners: [u32; 3]) -> i128 {
    let [a, b, c] = corners.map(|v| triangulation.vertices[v as usize]);
    i128::from(orient(a, b, c))
}

/// Invariants; every vertex and edge is there; Euler; and the constrained Delaunay property, exactly.
fn check(triangulation: &Triangulation, arrangement: &Arrangement) {
    triangulation.check_invariants();
    if triangulation.triangles.is_empty() {
        return;
    }
    let mut used: Vec<_> = triangulation.triangles.concat();
    used.sort_unstable();
    used.dedup();
    assert_eq!(
        used.len(),
        arrangement.vertices.len(),
        "a vertex is in no triangle"
    );

    let mut found = vec![false; arrangement.edges.len()];
    for (t, edges) in triangulation.edges.iter().enumerate() {
        for (k, e) in edges.iter().enumerate() {
            let (a, b) = (
                triangulation.triangles[t][k],
                triangulation.triangles[t][(k + 1) % 3],
            );
            match e {
                Some(e) => {
                    assert_eq!(arrangement.edges[*e as usize].ends, [a.min(b), a.max(b)]);
                    found[*e as usize] = true;
                }
                None => assert!(is_the_right_diagonal(triangulation, t, k)),
            }
        }
    }
    assert!(found.iter().all(|&f| f), "an edge is on no triangle");

    let hull = triangulation
        .neighbours
        .iter()
        .flatten()
        .filter(|n| n.is_none())
        .count();
    let (v, t) = (used.len(), triangulation.triangles.len());
    assert_eq!(t, 2 * v - 2 - hull, "Euler");
}

/// True when the corner beyond edge `k` of `t` lies outside the circle through the corners of `t`, or on it and
/// the smallest of the four corners is an end of the edge. Written without the code under test.
fn is_the_right_diagonal(triangulation: &Triangulation, t: usize, k: usize) -> bool {
    let Some(u) = triangulation.neighbours[t][k] else {
        return true;
    };
    let corners = triangulation.triangles[t];
    let beyond = triangulation.triangles[u as usize];
    let beyond = beyond
        .into_iter()
        .find(|v| !corners.contains(v))
        .expect("one corner differs");
    let p = triangulation.vertices[beyond as usize];
    let [a, b, c] = corners.map(|v| {
        let q = triangulation.vertices[v as usize];
        let (x, y) = (i128::from(q.x - p.x), i128::from(q.y - p.y));
        (x, y, x * x + y * y)
    });
    let minor = |p: (i128, i128, i128), q: (i128, i128, i128)| p.0 * q.1 - p.1 * q.0;
    let within = a.2 * minor(b, c) - b.2 * minor(a, c) + c.2 * minor(a, b);
    let smallest = corners.into_iter().chain([beyond]).min();
    let ends = [corners[k], corners[(k + 1) % 3]];
    within < 0 || (within == 0 && smallest.is_some_and(|v| ends.contains(&v)))
}

#[test]
fn a_polygon_on_a_circle_is_a_fan_around_its_smallest_vertex() {
    // All twelve grid points on the circle of radius 5, and a lattice, where every cell is tied.
    let ring = [[5, 0], [4, 3], [3, 4], [0, 5], [-3, 4], [-4, 3]];
    let ring = ring.into_iter().flat_map(|[x, y]| [[x, y], [-x, -y]]);
    let ring: Vec<_> = ring.map(|[x, y]| GridPoint::new(x, y)).collect();
    let fan = Face::of(&[], &ring).triangulation.triangles;
    assert_eq!(fan.len(), 10);
    assert!(fan.iter().all(|t| t[0] == 0));

    let lattice: Vec<_> = (0..400).map(|i| GridPoint::new(i / 20, i % 20)).collect();
    assert_eq!(
        Face::of(&[], &lattice).triangulation.triangles.len(),
        2 * 19 * 19
    );
}

const SQUARE: [[i64; 2]; 4] = [[0, 0], [100, 0], [100, 100], [0, 100]];
/// Clockwise, though that does not matter for even–odd.
const HOLE: [[i64; 2]; 4] = [[40, 40], [40, 60], [60, 60], [60, 40]];

#[test]
fn the_four_segments_that_break_incremental_splitting_triangulate() {
    let breaks = [
        [[5, 0], [6, 8]],
        [[2, 2], [4, 4]],
        [[2, 6], [1, 4]],
        [[0, 7], [8, 1]],
    ];
    for scale in [1, 1000] {
        let breaks = breaks.map(|s| s.map(|p| p.map(|c| c * scale)));
        let square = SQUARE.map(|p| p.map(|c| c / 10 * scale));
        let face = Face::new(&[&square], &breaks);
        assert_eq!(face.area2(), 200 * i128::from(scale * scale));
    }
}

#[test]
fn too_few_points_give_no_triangles() {
    for breaks in [
        &[][..],
        &[[[0, 0], [5, 5]]],
        &[[[0, 0], [5, 5]], [[2, 2], [9, 9]]],
    ] {
        assert!(Face::new(&[], breaks).triangulation.triangles.is_empty());
    }
}

#[test]
fn an_arrangement_with_a_crossing_is_reported_as_our_bug() {
    let edge = |a, b| crate::mesh::ArrangedEdge {
        ends: [a, b],
        sources: vec![0],
    };
    let corners = [[0, 0], [0, 9], [9, 0], [9, 9]].map(|[x, y]| GridPoint::new(x, y));
    let crossed = Arrangement {
        vertices: corners.to_vec(),
        edges: vec![edge(0, 3), edge(1, 2)],
    };
    assert!(matches!(
        triangulate(&crossed),
        Err(MeshError::Conflict { .. })
    ));
    let through_a_vertex = Arrangement {
        vertices: [[0, 0], [0, 9], [4, 4], [9, 9]]
            .map(|[x, y]| GridPoint::new(x, y))
            .to_vec(),
        edges: vec![edge(0, 3)],
    };
    let lost = triangulate(&through_a_vertex);
    assert_eq!(lost, Err(MeshError::LostEdge { ends: [0, 3] }));
}

#[test]
fn a_chord_separates_a_square_into_two_regions() {
    let face = Face::new(&[&SQUARE], &[[[0, 0], [100, 50]]]);
    assert_eq!(face.area2(), 20_000);
    let mut areas = face.region_areas2(is_break);
    areas.sort_unstable();
    assert_eq!(areas, [5_000, 15_000]);
    assert_eq!(face.region_areas2(|_| false), [20_000]);
    // Both ends and all of the chord have a site per side, other corners one.
    assert_eq!(face.sites(is_break).vertices.len(), 5 + 2);
    assert_eq!(face.sites(|_| false).vertices.len(), 5);
}

#[test]
fn a_hole_is_outside_and_so_is_what_a_concave_outline_leaves_of_the_hull() {
    let face = Face::new(&[&SQUARE, &HOLE], &[]);
    assert_eq!(face.area2(), 20_000 - 800);
    let island: [[i64; 2]; 3] = [[45, 45], [55, 45], [50, 55]];
    let face = Face::new(&[&SQUARE, &HOLE, &island], &[]);
    assert_eq!(face.area2(), 20_000 - 800 + 100);
    assert_eq!(face.region_areas2(|_| false).len(), 2);
    let notched = [[0, 0], [100, 0], [100, 100], [50, 20], [0, 100]];
    assert_eq!(Face::new(&[&notched], &[]).area2(), 12_000);
    let apart = SQUARE.map(|[x, y]| [x + 200, y + 30]);
    assert_eq!(Face::new(&[&SQUARE, &apart], &[]).area2(), 40_000);
}

#[test]
fn a_slit_lies_inside_and_separates_only_as_a_barrier() {
    // From the lower side up to (50, 60) and back along the same line.
    let slit = [
        [0, 0],
        [50, 0],
        [50, 60],
        [50, 0],
        [100, 0],
        [100, 100],
        [0, 100],
    ];
    let face = Face::new(&[&slit], &[]);
    assert_eq!(face.area2(), 20_000);
    assert_eq!(face.sites(|_| false).vertices.len(), 7 - 1);
    // As a barrier: two sites at its foot, one at its tip.
    assert_eq!(face.sites(is_outline).vertices.len(), 7);
    assert_eq!(face.region_areas2(is_outline), [20_000]);
}

#[test]
fn two_parts_that_touch_at_a_vertex_have_a_site_each() {
    let bow_tie = [[0, 0], [50, 50], [100, 0], [100, 100], [50, 50], [0, 100]];
    let face = Face::new(&[&bow_tie], &[]);
    assert_eq!(face.area2(), 10_000);
    assert_eq!(face.sites_at(50, 50), 2);
}

#[test]
fn a_wall_that_ends_inside_splits_its_line_but_not_its_end() {
    let face = Face::new(&[&SQUARE], &[[[0, 50], [30, 50]], [[30, 50], [60, 50]]]);
    assert_eq!(face.sites_at(0, 50), 2);
    assert_eq!(face.sites_at(30, 50), 2);
    assert_eq!(face.sites_at(60, 50), 1);
    assert_eq!(face.region_areas2(is_break), [20_000]);
    // Free on both ends.
    let face = Face::new(&[&SQUARE], &[[[20, 50], [80, 50]]]);
    assert_eq!((face.sites_at(20, 50), face.sites_at(80, 50)), (1, 1));
    assert_eq!(face.sites(is_break).vertices.len(), 6);
}

#[test]
fn barriers_meeting_in_t_and_x_have_a_site_per_sector() {
    let bar = [[0, 50], [100, 50]];
    let t = Face::new(&[&SQUARE], &[bar, [[50, 50], [50, 100]]]);
    assert_eq!((t.sites_at(50, 50), t.sites_at(50, 100)), (3, 2));
    assert_eq!(t.region_areas2(is_break).len(), 3);
    let x = Face::new(&[&SQUARE], &[bar, [[50, 0], [50, 100]]]);
    assert_eq!(x.sites_at(50, 50), 4);
    assert_eq!(x.region_areas2(is_break), [5_000; 4]);
    // A break that is no barrier splits nothing.
    let sites = x.sites(|s| s == 0).vertices;
    assert_eq!(sites.len(), x.triangulation.vertices.len() + 3);
}

#[test]
fn every_site_belongs_to_its_vertex_and_outside_has_none() {
    let face = Face::new(
        &[&SQUARE, &HOLE],
        &[[[0, 0], [90, 70]], [[10, 90], [100, 0]]],
    );
    let sites = face.sites(is_break);
    for (t, corners) in sites.corners.iter().enumerate() {
        assert_eq!(corners.is_some(), face.inside[t]);
        for (c, &s) in corners.iter().flatten().enumerate() {
            assert_eq!(
                sites.vertices[s as usize],
                face.triangulation.triangles[t][c]
            );
        }
    }
}

#[test]
fn trouble_of_every_kind_triangulates_and_fills_its_square() {
    for size in [8, 300, 1 << 20, 1 << 25] {
        let square = [[-size, -size], [size, -size], [size, size], [-size, size]];
        for kind in KINDS {
            for seed in 0..60 {
                let random = &mut Random::new(seed * 8 + kind as u64);
                let mut all = segments(kind, 4 + seed as usize % 20, size, random);
                let spots = points(seed as usize % 13, size, &all, random);
                all.extend(outline(&[&square]));
                let face = Face::of(&all, &spots);
                assert_eq!(face.area2(), 8 * i128::from(size) * i128::from(size));
                let regions = face.region_areas2(is_break);
                assert_eq!(regions.iter().sum::<i128>(), face.area2());
            }
        }
    }
}

/// Twice the area within the chains that the outline's segments became.
fn routed_area2(arrangement: &Arrangement, outline: &[Segment]) -> i128 {
    let mut sum = 0;
    for s in outline {
        let carrying = arrangement
            .edges
            .iter()
            .filter(|e| e.sources.contains(&s.source));
        for e in carrying {
            let [p, q] = e.ends.map(|v| arrangement.vertices[v as usize]);
            // A chain is monotone, so each of its edges runs the segment's way or exactly against it.
            let (dx, dy) = (s.b.x - s.a.x, s.b.y - s.a.y);
            let forward = dx * (q.x - p.x) + dy * (q.y - p.y) > 0;
            let cross = i128::from(p.x) * i128::from(q.y) - i128::from(p.y) * i128::from(q.x);
            sum += if forward { cross } else { -cross };
        }
    }
    sum
}

#[test]
fn the_inside_of_a_star_with_a_hole_is_exactly_what_its_rounded_outline_encloses() {
    for size in [1_i64 << 10, 1 << 20, 1 << 25] {
        for seed in 0..150 {
            let random = &mut Random::new(seed);
            let count = 5 + seed as usize % 20;
            let mut ring = |inner: f64, outer: f64| -> Vec<[i64; 2]> {
                let at = |k: usize| k as f64 / count as f64 * std::f64::consts::TAU;
                let mut point = |k| {
                    let r = (inner + (outer - inner) * random.unit()) * size as f64;
                    [(r * f64::cos(at(k))) as i64, (r * f64::sin(at(k))) as i64]
                };
                (0..count).map(&mut point).collect()
            };
            let star = ring(0.6, 1.0);
            // Within the star: its inner circle touches 0.6 cos 36° > 0.48 at the fewest.
            let mut hole = ring(0.1, 0.45);
            hole.reverse();
            let rim = outline(&[&star, &hole]);
            let kind = KINDS[seed as usize % KINDS.len()];
            let mut all = segments(kind, 20, size, random);
            all.extend(&rim);
            let spots = points(40, size, &all, random);
            let face = Face::of(&all, &spots);
            assert_eq!(
                face.area2(),
                routed_area2(&face.arrangement, &rim),
                "{seed}"
            );
        }
    }
}
