use super::*;
use crate::mesh::tests::{KINDS, Kind, Random, points, segments};

fn g(x: i64, y: i64) -> GridPoint {
    GridPoint::new(x, y)
}

fn lines(ends: &[[i64; 4]]) -> Vec<Segment> {
    let sources = 0..;
    sources
        .zip(ends)
        .map(|(source, &[ax, ay, bx, by])| Segment {
            a: g(ax, ay),
            b: g(bx, by),
            source,
        })
        .collect()
}

/// Distance of `p` from the segment, pixels.
fn distance(p: GridPoint, s: &Segment) -> f64 {
    let (dx, dy) = ((s.b.x - s.a.x) as f64, (s.b.y - s.a.y) as f64);
    let (px, py) = ((p.x - s.a.x) as f64, (p.y - s.a.y) as f64);
    let along = (px * dx + py * dy) / (dx * dx + dy * dy);
    let t = along.clamp(0.0, 1.0);
    (px - t * dx).hypot(py - t * dy)
}

/// Walks the edges that carry the segment's source (which must be its own) from end to end.
///
/// Returns the largest distance of their vertices from the segment, pixels: the drift.
fn walk(arrangement: &Arrangement, s: &Segment) -> f64 {
    let carrying = arrangement.edges.iter();
    let mut left: Vec<_> = carrying
        .filter(|e| e.sources.contains(&s.source))
        .map(|e| e.ends.map(|v| arrangement.vertices[v as usize]))
        .collect();
    let (mut at, mut drift) = (s.a, 0.0_f64);
    while at != s.b {
        let next = left.iter().position(|e| e.contains(&at));
        let [p, q] = left.swap_remove(next.expect("the path is interrupted"));
        at = if at == p { q } else { p };
        drift = drift.max(distance(at, s));
    }
    assert!(
        left.is_empty(),
        "edges off the path carry the source: {left:?}"
    );
    drift
}

/// The promise of the type, checked against all pairs instead of against the slabs.
fn check_all_pairs(arrangement: &Arrangement) {
    let spans: Vec<_> = arrangement
        .edges
        .iter()
        .map(|e| arrangement.span(e))
        .collect();
    for (i, span) in spans.iter().enumerate() {
        for other in &spans[..i] {
            assert_eq!(span.proper_crossing(other), None, "two edges cross");
        }
        for &p in &arrangement.vertices {
            let own = p == span.left || p == span.right;
            assert!(own || !span.meets_pixel(p), "an edge meets a foreign pixel");
        }
    }
}

/// Arranges and checks everything; returns passes and drift.
fn checked(segments: &[Segment], points: &[GridPoint]) -> (Arrangement, usize, f64) {
    let (arrangement, passes) = arrange_counted(segments, points);
    arrangement.check_invariants();
    let is_vertex = |p: &GridPoint| arrangement.vertices.binary_search(p).is_ok();
    assert!(points.iter().all(is_vertex), "an isolated point is lost");
    assert!(segments.iter().all(|s| is_vertex(&s.a) && is_vertex(&s.b)));
    let drift = segments.iter().map(|s| walk(&arrangement, s));
    let drift = drift.fold(0.0, f64::max);
    (arrangement, passes, drift)
}

#[test]
fn a_crossing_becomes_a_vertex_and_pieces_keep_their_source() {
    let (arrangement, ..) = checked(&lines(&[[0, 0, 10, 10], [0, 10, 10, 0]]), &[]);
    assert_eq!(arrangement.vertices.len(), 5);
    assert_eq!(arrangement.edges.len(), 4);
    assert!(arrangement.vertices.contains(&g(5, 5)));
}

#[test]
fn overlapping_stretches_unite_their_sources() {
    let (arrangement, ..) = checked(&lines(&[[0, 0, 9, 0], [12, 0, 3, 0], [3, 0, 9, 0]]), &[]);
    let sources: Vec<_> = arrangement.edges.iter().map(|e| &e.sources[..]).collect();
    assert_eq!(sources, [&[0][..], &[0, 1, 2], &[1]]);
}

#[test]
fn a_segment_without_length_leaves_a_vertex_that_cuts_others() {
    let (arrangement, ..) = checked(&lines(&[[4, 0, 4, 0], [0, 0, 9, 0]]), &[]);
    assert_eq!(arrangement.vertices, [g(0, 0), g(4, 0), g(9, 0)]);
    assert_eq!(arrangement.edges.len(), 2);
}

#[test]
fn an_isolated_point_catches_the_segment_through_its_pixel_only() {
    let segments = lines(&[[0, 0, 100, 1]]);
    let (arrangement, _, drift) = checked(&segments, &[g(20, 0), g(80, 1), g(50, 0), g(20, 1)]);
    // At x = 50 the line is at y = ½, the border that belongs to the upper pixel.
    let routed: Vec<_> = arrangement.edges.iter().map(|e| e.ends).collect();
    let at = |p| arrangement.vertices.binary_search(&p).expect("is there") as u32;
    let (a, p, q, b) = (at(g(0, 0)), at(g(20, 0)), at(g(80, 1)), at(g(100, 1)));
    assert!(routed.contains(&[a, p]) && routed.contains(&[q, b]));
    assert!(!routed.iter().flatten().any(|&v| v == at(g(20, 1))));
    assert!(drift <= 0.5 * 2.0_f64.sqrt());
}

#[test]
fn nothing_gives_nothing() {
    assert_eq!(arrange(&[], &[]), Arrangement::default());
    assert_eq!(arrange(&[], &[g(1, 2), g(1, 2)]).vertices, [g(1, 2)]);
}

#[test]
fn pixels_are_half_open() {
    // Lines of slope ±1 through the corners of the pixel at the origin, each touching just one.
    let touches = |ax, ay, bx, by| Span::new(g(ax, ay), g(bx, by)).meets_pixel(g(0, 0));
    assert!(touches(-1, 0, 0, -1), "lower left belongs to it");
    assert!(!touches(0, 1, 1, 0), "upper right");
    assert!(!touches(-1, 0, 0, 1), "upper left");
    assert!(!touches(0, -1, 1, 0), "lower right");
}

#[test]
fn crossings_round_ties_up() {
    let x = Span::new(g(0, 0), g(1, 1)).proper_crossing(&Span::new(g(0, 1), g(1, 0)));
    assert_eq!(x, Some(g(1, 1)));
    let x = Span::new(g(-1, -1), g(0, 0)).proper_crossing(&Span::new(g(-1, 0), g(0, -1)));
    assert_eq!(x, Some(g(0, 0)));
}

#[test]
fn crossings_are_exact_at_the_limit() {
    let (a, b) = (g(-LIMIT, -LIMIT), g(LIMIT, LIMIT));
    let (c, d) = (g(-LIMIT, LIMIT), g(LIMIT, -LIMIT));
    assert_eq!(
        Span::new(a, b).proper_crossing(&Span::new(c, d)),
        Some(g(0, 0))
    );
    // Off by one pixel at one end: the crossing moves by a quarter of one.
    let d = g(LIMIT, -LIMIT + 1);
    assert_eq!(
        Span::new(a, b).proper_crossing(&Span::new(c, d)),
        Some(g(0, 0))
    );
}

#[test]
fn order_and_direction_of_the_input_do_not_matter() {
    let mut random = Random::new(5);
    for kind in KINDS {
        let mut input = segments(kind, 20, 300, &mut random);
        let mut spots = points(10, 300, &input, &mut random);
        let one = arrange(&input, &spots);
        input.reverse();
        spots.reverse();
        for s in &mut input {
            std::mem::swap(&mut s.a, &mut s.b);
        }
        assert_eq!(one, arrange(&input, &spots), "{kind:?}");
    }
}

/// Half-width in pixels, and the most passes and drift (pixels) that we accept there.
///
/// In 16 000 other cases per scale: 8 passes and 2.9 px on the smallest grid, 14 and 4.2 px on the
/// largest. Nothing in theory bounds the drift but the length of a chain of adjoining hot pixels.
const SCALES: [(i64, usize, f64); 5] = [
    (8, 8, 4.0),
    (128, 16, 4.0),
    (1 << 12, 20, 5.0),
    (1 << 20, 20, 5.0),
    (1 << 25, 20, 5.0),
];

#[test]
fn trouble_of_every_kind_keeps_the_invariants() {
    let cases = 120;
    for (size, most_passes, most_drift) in SCALES {
        let (mut worst_passes, mut worst_drift) = (0, 0.0_f64);
        for kind in KINDS {
            for seed in 0..cases {
                let random = &mut Random::new(seed * 8 + kind as u64);
                let input = segments(kind, 4 + seed as usize % 24, size, random);
                let spots = points(seed as usize % 13, size, &input, random);
                let (arrangement, passes, drift) = checked(&input, &spots);
                if seed % 4 == 0 {
                    check_all_pairs(&arrangement);
                }
                worst_passes = worst_passes.max(passes);
                worst_drift = worst_drift.max(drift);
            }
        }
        eprintln!("±{size} px: {worst_passes} passes, drift {worst_drift:.2} px");
        assert!(worst_passes <= most_passes, "{size}: {worst_passes} passes");
        assert!(worst_drift <= most_drift, "{size}: drift {worst_drift}");
    }
}

#[test]
fn a_fan_of_many_shadow_edges_keeps_the_invariants() {
    for seed in 0..4 {
        let random = &mut Random::new(seed);
        let input = segments(Kind::BoxShadow, 48 * 4, 1 << 25, random);
        let spots = points(500, 1 << 25, &input, random);
        checked(&input, &spots);
    }
}
