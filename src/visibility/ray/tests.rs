use super::*;
use crate::visibility::random::Random;
use std::collections::BTreeMap;

/// A unit sphere of 20 · 4ⁿ triangles, counter-clockwise from outside, and its vertices.
fn icosphere(levels: u32) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = Vec::new();
    for (s, t) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        points.push(DVec3::new(s, t * g, 0.0));
        points.push(DVec3::new(0.0, s, t * g));
        points.push(DVec3::new(t * g, 0.0, s));
    }
    // Every three mutually nearest points (distance 2) are a triangle.
    let mut faces = Vec::new();
    let near = |a: DVec3, b: DVec3| (a.distance(b) - 2.0).abs() < 1e-9;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [i, j, k].map(|v| points[v]);
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    faces.push(if outward { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    points.iter_mut().for_each(|p| *p = p.normalize());
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut split = Vec::new();
        for [a, b, c] in faces {
            let mut middle = |p: usize, q: usize| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    points.push((points[p] + points[q]).normalize());
                    points.len() - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            split.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        faces = split;
    }
    (points, faces)
}

#[test]
fn no_ray_from_inside_a_sphere_escapes_through_its_edges_and_vertices() {
    let (points, faces) = icosphere(3);
    assert_eq!(faces.len(), 20 * 64);
    let mut random = Random(1);
    // Far from the origin and tiny or huge: the boxes have their own frame.
    for (offset, scale) in [(0.0, 1.0), (1000.0, 1.0), (0.0, 1e-6), (0.0, 1e6)] {
        let place = |p: DVec3| p * scale + DVec3::splat(offset);
        let triangles: Vec<_> = faces.iter().map(|f| f.map(|i| place(points[i]))).collect();
        let caster = RayCaster::new(&triangles);
        let mut leaks = 0;
        for i in 0..100_000 {
            let origin = place(random.point(0.5));
            let [a, b, _] = triangles[i % triangles.len()];
            // A fifth of the rays aim at vertices, the rest anywhere on an edge.
            let target = a.lerp(b, if i % 5 == 0 { 0.0 } else { random.next() });
            let dir = target - origin;
            let seen = caster.nearest(origin, dir, 0.0, f64::INFINITY);
            let blocked = caster.is_blocked(origin, origin + dir * 1.5, 0.0, 1.0, |_| false);
            leaks += usize::from(seen.is_none_or(|hit| hit.is_front) || !blocked);
        }
        assert_eq!(leaks, 0, "offset {offset}, scale {scale}");
    }
}

#[test]
fn nearest_and_blocked_agree_with_trying_every_triangle() {
    let mut random = Random(7);
    let triangles: Vec<_> = (0..300)
        .map(|_| {
            let at = random.point(1.0);
            [(); 3].map(|()| at + random.point(0.2))
        })
        .collect();
    let caster = RayCaster::new(&triangles);
    for _ in 0..5000 {
        let (a, b) = (random.point(3.0), random.point(1.0));
        let woop = WoopRay::new(a, b - a);
        let all: Vec<Hit> = (0..)
            .zip(&triangles)
            .filter_map(|(i, t)| woop.hit(t, i))
            .collect();
        let expected = all
            .iter()
            .filter(|h| h.t > 0.1)
            .min_by(|p, q| p.t.total_cmp(&q.t))
            .copied();
        assert_eq!(caster.nearest(a, b - a, 0.1, f64::INFINITY), expected);
        let even = |i: u32| i.is_multiple_of(2);
        let expected = all
            .iter()
            .any(|h| h.t > 0.2 && h.t < 0.9 && !even(h.triangle));
        assert_eq!(caster.is_blocked(a, b, 0.2, 0.9, even), expected);
    }
}

#[test]
fn weights_and_t_lead_to_the_same_point() {
    let corners = [
        DVec3::new(0.0, 0.0, 1.0),
        DVec3::new(4.0, 0.0, 1.0),
        DVec3::new(0.0, 4.0, 2.0),
    ];
    let caster = RayCaster::new(&[corners]);
    let (origin, dir) = (DVec3::new(1.0, 1.5, 9.0), DVec3::new(0.0, 0.0, -2.0));
    let hit = caster
        .nearest(origin, dir, 0.0, f64::INFINITY)
        .expect("it points at the triangle");
    assert!(hit.is_front);
    let [a, b, c] = corners;
    let on_triangle = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
    assert!(on_triangle.distance(origin + dir * hit.t) < 1e-12);
    let from_below = caster.nearest(DVec3::new(1.0, 1.5, -9.0), -dir, 0.0, f64::INFINITY);
    assert!(!from_below.expect("hit from below").is_front);
}

fn floor(y: f64) -> [DVec3; 3] {
    [
        DVec3::new(-1.0, y, -1.0),
        DVec3::new(0.0, y, 1.0),
        DVec3::new(1.0, y, -1.0),
    ]
}

#[test]
fn both_sides_in_one_place_are_told_apart_and_ties_go_to_the_first() {
    let [a, b, c] = floor(0.0);
    let caster = RayCaster::new(&[[a, c, b], [a, b, c], [a, b, c]]);
    let down = |accept: &dyn Fn(&Hit) -> bool| {
        caster
            .nearest_where(DVec3::Y, DVec3::NEG_Y, 0.0, f64::INFINITY, accept)
            .map(|hit| hit.triangle)
    };
    assert_eq!(down(&|_| true), Some(0));
    assert_eq!(down(&|hit| hit.is_front), Some(1));
    assert_eq!(down(&|_| false), None);
}

#[test]
fn an_occluder_a_hair_above_its_receiver_blocks() {
    // A tiny triangle in a wide scene: its box lies within 1e-4 of the diagonal from the ray's start.
    let small = floor(0.0).map(|p| p * 1e-4 + DVec3::Y * 1e-6);
    let wide = floor(-1.0).map(|p| p * 10.0);
    let caster = RayCaster::new(&[wide, small]);
    let origin = DVec3::new(1e-6, 0.0, 2e-6);
    assert!(caster.is_blocked(origin, origin + DVec3::Y, 0.0, 1.0, |_| false));
    assert!(caster.is_blocked(origin, origin + DVec3::Y * 2e-6, 0.0, 1.0, |_| false));
    assert!(!caster.is_blocked(origin, origin + DVec3::Y * 5e-7, 0.0, 1.0, |_| false));
    let hit = caster.nearest(origin, DVec3::Y, 0.0, f64::INFINITY);
    assert_eq!(hit.map(|hit| hit.triangle), Some(1));
}

#[test]
fn touching_an_end_does_not_block() {
    let caster = RayCaster::new(&[floor(0.0)]);
    assert!(!caster.is_blocked(DVec3::ZERO, DVec3::Y, 0.0, 1.0, |_| false));
    assert!(!caster.is_blocked(DVec3::Y, DVec3::ZERO, 0.0, 1.0, |_| false));
    assert!(caster.is_blocked(DVec3::Y, DVec3::NEG_Y, 0.0, 1.0, |_| false));
    assert!(!caster.is_blocked(DVec3::Y, DVec3::NEG_Y, 0.0, 1.0, |i| i == 0));
}

#[test]
fn negative_zeros_in_a_direction_change_nothing() {
    let triangles: Vec<_> = (0..50).map(|i| floor(-f64::from(i) - 1.0)).collect();
    let caster = RayCaster::new(&triangles);
    let dir = DVec3::new(-0.0, -1.0, -0.0);
    let hit = caster.nearest(DVec3::new(0.1, 0.0, 0.1), dir, 0.0, f64::INFINITY);
    assert_eq!(hit.map(|hit| hit.triangle), Some(0));
}

#[test]
fn nothing_and_degenerate_triangles_are_never_hit() {
    assert_eq!(
        RayCaster::new(&[]).nearest(DVec3::ZERO, DVec3::X, 0.0, 1.0),
        None
    );
    let point = [DVec3::ONE; 3];
    let caster = RayCaster::new(&[point]);
    assert_eq!(
        caster.nearest(DVec3::ZERO, DVec3::ONE, 0.0, f64::INFINITY),
        None
    );
    assert!(!caster.is_blocked(DVec3::ZERO, DVec3::ZERO, 0.0, 1.0, |_| false));
}

#[test]
fn a_camera_far_away_sees_the_same_triangle() {
    let (points, faces) = icosphere(2);
    let triangles: Vec<_> = faces.iter().map(|f| f.map(|i| points[i])).collect();
    let caster = RayCaster::new(&triangles);
    for (i, corners) in (0..).zip(&triangles) {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let hit = caster.nearest(middle * 1e6, -middle, 0.0, f64::INFINITY);
        assert_eq!(hit.map(|hit| hit.triangle), Some(i));
    }
}
