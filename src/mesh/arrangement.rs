//! Segments become a planar graph on the grid by iterated snap rounding, and every edge keeps its sources.
//!
//! A *pixel* is the half-open square `[x − ½, x + ½) × [y − ½, y + ½)` around a grid point; it is
//! *hot* when it holds an end point, a proper crossing or an isolated point. Each segment is
//! replaced by the chain through the centres of the hot pixels that it meets:
//!
//! ```text
//!   a ──────────────── b          a ────╲      ╱─── b
//!           □ hot           →            ╲─ v ─╱
//! ```
//!
//! Rounding all segments in this way creates no crossing (Hobby 1999; Guibas and Marimont 1998),
//! but it may push an edge into another hot pixel, so edges are routed again until none meets a
//! foreign pixel (Halperin and Packer 2002).
//!
//! **Why this ends.** The set of hot pixels is fixed before the first pass, because no pass makes
//! a crossing. Every point lies in exactly one pixel, and going along a line its pixel changes
//! monotonously in `x` and in `y`; so do the vertices of the chain. The chain's edges therefore have
//! together exactly the extent `|Δx| + |Δy|` of the edge that they replace, a whole number, and each at
//! least 1: an edge can be split only finitely often, and no cap on the passes is needed.
//! Half-open pixels matter: with closed ones a line through a corner is in two pixels side by side, the
//! chain takes a step aside, and the routing does not end.
//!
//! **How candidates are found.** Points and segments are sorted into horizontal slabs of equal
//! count, and by `x` inside a slab. Unlike square buckets, slabs keep working when all breaks
//! crowd into a corner of the face.

use super::grid::{GridPoint, LIMIT, orient};

/// A straight line on a face, before it is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// One end.
    pub a: GridPoint,
    /// Other end.
    pub b: GridPoint,
    /// What drew it; the edges that it becomes carry this number.
    pub source: u32,
}

/// A straight edge between two vertices, met by nothing else.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArrangedEdge {
    /// Indices into [`Arrangement::vertices`], the smaller first.
    pub ends: [u32; 2],
    /// Sources of all segments that run along this edge, ascending, each once.
    pub sources: Vec<u32>,
}

/// A planar graph on the grid: no two edges cross, and no vertex lies on or within a pixel of a foreign edge.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Arrangement {
    /// All vertices, ascending, each once.
    pub vertices: Vec<GridPoint>,
    /// All edges, ascending by [`ArrangedEdge::ends`], each once.
    pub edges: Vec<ArrangedEdge>,
}

/// The arrangement of `segments` and of the isolated `points` (vertices, whether or not a segment meets them).
///
/// Coordinates are at most 2²⁶ in magnitude, which [`super::Grid`] ensures. A segment without
/// length leaves only its vertex. The result depends neither on the order of the input nor on the
/// direction of a segment.
pub fn arrange(segments: &[Segment], points: &[GridPoint]) -> Arrangement {
    arrange_counted(segments, points).0
}

/// [`arrange`], and the number of routing passes that it took.
pub(super) fn arrange_counted(segments: &[Segment], points: &[GridPoint]) -> (Arrangement, usize) {
    let mut vertices: Vec<_> = points.to_vec();
    vertices.extend(segments.iter().flat_map(|s| [s.a, s.b]));
    debug_assert!(
        vertices
            .iter()
            .all(|v| v.x.abs() <= LIMIT && v.y.abs() <= LIMIT),
        "a coordinate exceeds the proven range"
    );
    let spans: Vec<_> = segments.iter().map(|s| Span::new(s.a, s.b)).collect();
    vertices.extend(crossings(&spans));
    vertices.sort_unstable();
    vertices.dedup();

    let vertex = |p: GridPoint| {
        let at = vertices.binary_search(&p).expect("end points are vertices");
        at as u32
    };
    let pieces = segments
        .iter()
        .zip(&spans)
        .filter(|(s, _)| s.a != s.b)
        .map(|(s, span)| Piece {
            ends: [vertex(span.left), vertex(span.right)],
            source: s.source,
        })
        .collect();
    let (pieces, passes) = route(pieces, &vertices);
    let edges = merge(pieces);
    (Arrangement { vertices, edges }, passes)
}

impl Arrangement {
    /// Checks what the type promises; for tests and for debug builds between stages.
    ///
    /// # Panics
    /// When a vertex or an edge is out of order, repeated or without a source, when two edges
    /// cross, or when an edge meets the pixel of a vertex that is not its own.
    pub fn check_invariants(&self) {
        let ascending = self.vertices.windows(2).all(|w| w[0] < w[1]);
        assert!(ascending, "vertices are not strictly ascending");
        let ascending = self.edges.windows(2).all(|w| w[0].ends < w[1].ends);
        assert!(ascending, "edges are not strictly ascending");

        let index = PixelIndex::new(&self.vertices);
        let mut met = Vec::new();
        for edge in &self.edges {
            let ([a, b], sources) = (edge.ends, &edge.sources);
            assert!(a < b, "{edge:?} runs backwards");
            assert!(!sources.is_empty(), "{edge:?} has no source");
            assert!(sources.windows(2).all(|w| w[0] < w[1]), "{edge:?}: sources");
            index.pixels_met(edge.ends, &mut met);
            assert!(met.is_empty(), "{edge:?} meets the pixels of {met:?}");
        }
        let spans: Vec<_> = self.edges.iter().map(|e| self.span(e)).collect();
        let crossing = crossings(&spans).first().copied();
        assert_eq!(crossing, None, "two edges cross");
    }

    fn span(&self, edge: &ArrangedEdge) -> Span {
        let [left, right] = edge.ends.map(|v| self.vertices[v as usize]);
        Span { left, right }
    }
}

/// A straight line with its ends in order, so that a result cannot depend on its direction.
#[derive(Clone, Copy)]
struct Span {
    left: GridPoint,
    right: GridPoint,
}

impl Span {
    fn new(a: GridPoint, b: GridPoint) -> Self {
        Self {
            left: a.min(b),
            right: a.max(b),
        }
    }

    /// Lowest and highest `y`.
    fn y_range(&self) -> (i64, i64) {
        let (a, b) = (self.left.y, self.right.y);
        (a.min(b), a.max(b))
    }

    /// An interval of `x` that holds the part of the span within a pixel of `y0..=y1`, a pixel to spare at either end.
    ///
    /// Floating point is good enough to choose candidates: its error here is below 2⁻²⁰ pixels.
    fn x_range(&self, y0: i64, y1: i64) -> (i64, i64) {
        let (a, b) = (self.left, self.right);
        let (low, high) = self.y_range();
        if low == high {
            return (a.x, b.x);
        }
        let slope = (b.x - a.x) as f64 / (b.y - a.y) as f64;
        let x_at = |y: i64| (y.clamp(low, high) - a.y) as f64 * slope + a.x as f64;
        let (x0, x1) = (x_at(y0 - 1), x_at(y1 + 1));
        let (x0, x1) = (x0.min(x1).floor() as i64, x0.max(x1).ceil() as i64);
        ((x0 - 1).max(a.x), (x1 + 1).min(b.x))
    }

    /// True when the span meets the half-open pixel of `p`.
    ///
    /// With `o = orient(left, right, p)` the line is at `o + dx·v − dy·u` from the pixel's point
    /// `p + (u, v)`. That changes sign within the open pixel when `2|o| < |dx| + |dy|`; at equality the line
    /// only touches a corner, and just the lower left one, `u = v = −½`, belongs to the pixel.
    /// The ends are grid points, so where the line meets the pixel, the span does exactly if `p` is in its box.
    fn meets_pixel(&self, p: GridPoint) -> bool {
        let (a, b) = (self.left, self.right);
        let (low, high) = self.y_range();
        if p.x < a.x || p.x > b.x || p.y < low || p.y > high {
            return false;
        }
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let twice = 2 * orient(a, b, p);
        let reach = dx + dy.abs();
        twice.abs() < reach || (twice.abs() == reach && twice == dx - dy)
    }

    /// The pixel in which the interiors of two spans cross; `None` when they merely touch, overlap or miss.
    ///
    /// Touching needs no new vertex: there an end point lies on the other span, and is hot already.
    fn proper_crossing(&self, other: &Span) -> Option<GridPoint> {
        let (a, b, c, d) = (self.left, self.right, other.left, other.right);
        let opposite = |s: i64, t: i64| (s > 0 && t < 0) || (s < 0 && t > 0);
        if !opposite(orient(a, b, c), orient(a, b, d)) {
            return None;
        }
        let (from_a, from_b) = (orient(c, d, a), orient(c, d, b));
        if !opposite(from_a, from_b) {
            return None;
        }
        // The crossing is a + t (b − a) with t = from_a / (from_a − from_b); the fraction is below
        // 2⁵⁶ and its product with a difference below 2⁸³, so this rounds exactly, ties up.
        let (num, den) = (i128::from(from_a), i128::from(from_a - from_b));
        let (num, den) = if den < 0 { (-num, -den) } else { (num, den) };
        let along = |d: i64| ((2 * num * i128::from(d) + den).div_euclid(2 * den)) as i64;
        Some(GridPoint::new(
            a.x + along(b.x - a.x),
            a.y + along(b.y - a.y),
        ))
    }
}

/// The pixels of all proper crossings, in no useful order and possibly repeated.
fn crossings(spans: &[Span]) -> Vec<GridPoint> {
    // Cut the plane into about √n slabs with equally many end points each.
    let mut ys: Vec<_> = spans.iter().flat_map(|s| [s.left.y, s.right.y]).collect();
    ys.sort_unstable();
    let slabs = spans.len().isqrt().max(1);
    let mut bounds: Vec<_> = (0..=slabs)
        .filter_map(|k| ys.get(k * ys.len().saturating_sub(1) / slabs).copied())
        .collect();
    bounds.dedup();

    // Enter each span, with its extent in x, into every slab that it reaches.
    let mut entries = Vec::new();
    for (at, span) in spans.iter().enumerate() {
        let (low, high) = span.y_range();
        let first = bounds.partition_point(|&y| y < low).saturating_sub(1);
        for (slab, w) in bounds.windows(2).enumerate().skip(first) {
            if w[0] > high {
                break;
            }
            let (x0, x1) = span.x_range(w[0], w[1]);
            entries.push((slab, x0, x1, at));
        }
    }
    entries.sort_unstable();

    // Two spans that cross within a slab overlap in x there.
    let mut found = Vec::new();
    for (i, &(slab, _, end, one)) in entries.iter().enumerate() {
        for &(other_slab, begin, _, other) in &entries[i + 1..] {
            if other_slab != slab || begin > end {
                break;
            }
            found.extend(spans[one].proper_crossing(&spans[other]));
        }
    }
    found
}

/// The hot pixels, to be asked which of them a span meets.
struct PixelIndex<'a> {
    vertices: &'a [GridPoint],
    /// Slab after slab from below; within a slab ascending.
    entries: Vec<(GridPoint, u32)>,
    /// Lowest and highest `y` of each slab.
    slabs: Vec<(i64, i64)>,
    slab_len: usize,
}

impl<'a> PixelIndex<'a> {
    fn new(vertices: &'a [GridPoint]) -> Self {
        let mut entries: Vec<_> = vertices.iter().copied().zip(0..).collect();
        entries.sort_unstable_by_key(|&(p, _)| (p.y, p.x));
        let slab_len = vertices.len().isqrt().max(1);
        let mut slabs = Vec::new();
        for slab in entries.chunks_mut(slab_len) {
            slabs.push((slab[0].0.y, slab[slab.len() - 1].0.y));
            slab.sort_unstable();
        }
        Self {
            vertices,
            entries,
            slabs,
            slab_len,
        }
    }

    /// Fills `met` with the vertices, other than its `ends`, whose pixels an edge meets, in order from its left end.
    fn pixels_met(&self, ends: [u32; 2], met: &mut Vec<u32>) {
        met.clear();
        let [left, right] = ends.map(|v| self.vertices[v as usize]);
        let span = Span { left, right };
        let (low, high) = span.y_range();
        let first = self.slabs.partition_point(|s| s.1 < low);
        for (slab, &(y0, y1)) in self.slabs.iter().enumerate().skip(first) {
            if y0 > high {
                break;
            }
            let (x0, x1) = span.x_range(y0, y1);
            let end = self.entries.len().min((slab + 1) * self.slab_len);
            let slab = &self.entries[slab * self.slab_len..end];
            let from = slab.partition_point(|(p, _)| p.x < x0);
            met.extend(
                slab[from..]
                    .iter()
                    .take_while(|(p, _)| p.x <= x1)
                    .filter(|&&(p, v)| !ends.contains(&v) && span.meets_pixel(p))
                    .map(|&(_, v)| v),
            );
        }
        // The pixels come monotonously in x and in y, so their centres lie in this order, no two at once.
        let (dx, dy) = (right.x - left.x, right.y - left.y);
        met.sort_unstable_by_key(|&v| {
            let p = self.vertices[v as usize];
            dx * (p.x - left.x) + dy * (p.y - left.y)
        });
    }
}

/// A stretch of one segment between two vertices, the smaller first; ordered as in the result.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Piece {
    ends: [u32; 2],
    source: u32,
}

/// Routes pieces through the hot pixels they meet until none meets a foreign one; also counts the passes.
///
/// A piece that meets nothing is finished: hot pixels never change, so later passes look only at
/// the pieces that the last one made.
fn route(mut pending: Vec<Piece>, vertices: &[GridPoint]) -> (Vec<Piece>, usize) {
    let index = PixelIndex::new(vertices);
    let (mut done, mut met, mut passes) = (Vec::new(), Vec::new(), 0);
    while !pending.is_empty() {
        passes += 1;
        let mut parts = Vec::new();
        // Nearly coincident segments share most of their edges: ask once for all sources.
        pending.sort_unstable();
        for same in pending.chunk_by(|p, q| p.ends == q.ends) {
            let ends = same[0].ends;
            index.pixels_met(ends, &mut met);
            let result = if met.is_empty() {
                &mut done
            } else {
                &mut parts
            };
            met.push(ends[1]);
            for piece in same {
                let mut from = ends[0];
                for &to in &met {
                    result.push(Piece {
                        ends: [from.min(to), from.max(to)],
                        source: piece.source,
                    });
                    from = to;
                }
            }
        }
        pending = parts;
    }
    (done, passes)
}

/// Unites pieces with the same ends into one edge with all their sources.
fn merge(mut pieces: Vec<Piece>) -> Vec<ArrangedEdge> {
    pieces.sort_unstable();
    pieces.dedup();
    pieces
        .chunk_by(|p, q| p.ends == q.ends)
        .map(|same| ArrangedEdge {
            ends: same[0].ends,
            sources: same.iter().map(|p| p.source).collect(),
        })
        .collect()
}

#[cfg(test)]
mod tests;
