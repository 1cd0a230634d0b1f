//! Constrained Delaunay triangulation of an arrangement, and what its labelled edges separate.
//!
//! The triangulation covers the convex hull. Which part of it is the face, which parts of the face
//! a break separates, and how many values a vertex needs are three questions with one answer each:
//! [`inside`], [`regions`] and [`sectors`].

use super::arrangement::Arrangement;
use super::grid::{GridPoint, orient};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

/// A triangulation could not be made. Arrangements are built such that it always can: this is our bug.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// An edge crosses another one, so the arrangement is not planar.
    #[error(
        "internal error: arrangement edge between vertices {} and {} crosses another; please report it",
        .ends[0], .ends[1]
    )]
    Conflict {
        /// Vertices of the edge.
        ends: [u32; 2],
    },
    /// An edge is missing from the triangulation, so a vertex lies on it or two vertices coincide.
    #[error(
        "internal error: arrangement edge between vertices {} and {} is not in the triangulation; please report it",
        .ends[0], .ends[1]
    )]
    LostEdge {
        /// Vertices of the edge.
        ends: [u32; 2],
    },
    /// A coordinate cannot be triangulated.
    #[error("internal error: a vertex has no valid position ({0}); please report it")]
    Position(#[from] spade::InsertionError),
}

/// Triangles over the convex hull of an [`Arrangement`], every one of its edges being an edge of theirs.
///
/// ```text
///        2
///       ╱ ╲        edge k of a triangle runs from corner k to corner (k + 1) % 3;
///   2  ╱   ╲  1    the triangle lies to its left, the neighbour k to its right
///     ╱     ╲
///    0 ───── 1
///        0
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Triangulation {
    /// The arrangement's vertices, same indices.
    pub vertices: Vec<GridPoint>,
    /// Corners, counter-clockwise, the smallest first; ascending.
    pub triangles: Vec<[u32; 3]>,
    /// The triangle across each edge; `None` on the hull.
    pub neighbours: Vec<[Option<u32>; 3]>,
    /// The arrangement's edge on each edge, if there is one.
    pub edges: Vec<[Option<u32>; 3]>,
}

/// Triangulates the convex hull of `arrangement`; without three vertices off a line there are no triangles.
///
/// The result is the constrained Delaunay triangulation; a polygon of unlabelled edges whose corners lie on one
/// circle is a fan around its smallest vertex. So it is unique.
///
/// # Errors
/// [`MeshError`] when the arrangement breaks its promises.
pub fn triangulate(arrangement: &Arrangement) -> Result<Triangulation, MeshError> {
    type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;
    let points = arrangement.vertices.iter();
    let points = points
        .map(|p| Point2::new(p.x as f64, p.y as f64))
        .collect();
    let edges = arrangement.edges.iter();
    let edges = edges.map(|e| e.ends.map(|v| v as usize)).collect();

    let mut conflict = None;
    let cdt = Cdt::try_bulk_load_cdt(points, edges, |ends| {
        conflict.get_or_insert(ends.map(|v| v as u32));
    })?;
    if let Some(ends) = conflict {
        return Err(MeshError::Conflict { ends });
    }

    let faces = cdt.inner_faces();
    let triangles = faces.map(|f| f.vertices().map(|v| v.fix().index() as u32));
    let mut triangulation = Triangulation::new(triangles.collect(), arrangement)?;
    if triangulation.settle_ties() {
        triangulation = Triangulation::new(triangulation.triangles, arrangement)?;
    }
    Ok(triangulation)
}

/// The same cycle of corners, starting at the smallest.
fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Where `d` lies from the circle through `a b c`, counter-clockwise: positive inside, 0 on it, exactly.
fn in_circle([a, b, c, d]: [GridPoint; 4]) -> i128 {
    // Relative to d, coordinates are below 2²⁷; minors and squares are below 2⁵⁵.
    let [a, b, c] = [a, b, c].map(|p| (p.x - d.x, p.y - d.y));
    let lift = |p: (i64, i64)| i128::from(p.0 * p.0 + p.1 * p.1);
    let minor = |p: (i64, i64), q: (i64, i64)| i128::from(p.0 * q.1 - p.1 * q.0);
    lift(a) * minor(b, c) + lift(b) * minor(c, a) + lift(c) * minor(a, b)
}

impl Triangulation {
    /// Puts triangles into our own order, so that nothing depends on how the library numbers its faces.
    fn new(triangles: Vec<[u32; 3]>, arrangement: &Arrangement) -> Result<Self, MeshError> {
        let mut triangles: Vec<_> = triangles.into_iter().map(smallest_first).collect();
        triangles.sort_unstable();
        let count = triangles.len();
        let mut triangulation = Self {
            vertices: arrangement.vertices.clone(),
            triangles,
            neighbours: vec![[None; 3]; count],
            edges: vec![[None; 3]; count],
        };
        triangulation.connect(arrangement)?;
        Ok(triangulation)
    }

    /// Makes every polygon whose corners lie on one circle a fan around its smallest vertex; true when that changed something.
    ///
    /// On a grid such polygons abound, each of their triangulations is Delaunay, and which one the
    /// library finds may depend on its hash sets' random order. All other edges are unique.
    /// A flip towards the smallest corner of a quadrilateral raises the degree of that corner at
    /// the cost of larger ones, so the flips end; and as long as a polygon is not the fan, the side of a triangle
    /// opposite to its smallest vertex can be flipped. Leaves labels and order for [`Self::new`] to redo.
    fn settle_ties(&mut self) -> bool {
        let all = 0..self.triangles.len();
        let mut stack: Vec<_> = all.flat_map(|t| [(t, 0), (t, 1), (t, 2)]).collect();
        let mut changed = false;
        while let Some((t, k)) = stack.pop() {
            let (None, Some(u)) = (self.edges[t][k], self.neighbours[t][k]) else {
                continue;
            };
            let u = u as usize;
            let m = self.side_towards(u, t);
            let [a, b, c] = [k, k + 1, k + 2].map(|i| self.triangles[t][i % 3]);
            let d = self.triangles[u][(m + 2) % 3];
            let corners = [a, b, c, d].map(|v| self.vertices[v as usize]);
            if a.min(b) < c.min(d) || in_circle(corners) != 0 {
                continue;
            }
            self.flip((t, k), (u, m));
            stack.extend([(t, 0), (t, 1), (t, 2), (u, 0), (u, 1)]);
            changed = true;
        }
        changed
    }

    /// Replaces the edge between two triangles by the other diagonal.
    ///
    /// ```text
    ///      c                 c
    ///    ╱ t ╲             ╱ │ ╲
    ///   a ─── b     →     a t│u b
    ///    ╲ u ╱             ╲ │ ╱
    ///      d                 d
    /// ```
    fn flip(&mut self, (t, k): (usize, usize), (u, m): (usize, usize)) {
        let [a, b, c] = [k, k + 1, k + 2].map(|i| self.triangles[t][i % 3]);
        let d = self.triangles[u][(m + 2) % 3];
        let side = |of: usize, i: usize| (self.neighbours[of][i % 3], self.edges[of][i % 3]);
        let (bc, ca, ad, db) = (
            side(t, k + 1),
            side(t, k + 2),
            side(u, m + 1),
            side(u, m + 2),
        );

        // Two outer sides change hands.
        for (outer, old, new) in [(ad.0, u, t), (bc.0, t, u)] {
            if let Some(outer) = outer.map(|o| o as usize) {
                let back = self.side_towards(outer, old);
                self.neighbours[outer][back] = Some(new as u32);
            }
        }
        self.triangles[t] = [a, d, c];
        self.neighbours[t] = [ad.0, Some(u as u32), ca.0];
        self.edges[t] = [ad.1, None, ca.1];
        self.triangles[u] = [d, b, c];
        self.neighbours[u] = [db.0, bc.0, Some(t as u32)];
        self.edges[u] = [db.1, bc.1, None];
    }

    /// The edge of triangle `t` beyond which its neighbour `u` lies.
    fn side_towards(&self, t: usize, u: usize) -> usize {
        let side = (0..3).find(|&k| self.neighbours[t][k] == Some(u as u32));
        side.expect("neighbours know each other")
    }

    /// Finds the neighbours and the arrangement's edges by sorting the triangles' sides by their ends.
    fn connect(&mut self, arrangement: &Arrangement) -> Result<(), MeshError> {
        let mut sides = Vec::with_capacity(3 * self.triangles.len());
        for (corners, t) in self.triangles.iter().zip(0_u32..) {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], t, k as u32));
            }
        }
        sides.sort_unstable();

        // Both lists ascend by ends: walk them together.
        let mut labels = arrangement.edges.iter().zip(0..).peekable();
        for both in sides.chunk_by(|p, q| p.0 == q.0) {
            let ends = both[0].0;
            let label = labels.next_if(|(edge, _)| edge.ends <= ends);
            if let Some((edge, _)) = label.filter(|(edge, _)| edge.ends < ends) {
                return Err(MeshError::LostEdge { ends: edge.ends });
            }
            for &(_, t, k) in both {
                self.edges[t as usize][k as usize] = label.map(|(_, e)| e);
            }
            if let [(_, t, k), (_, u, m)] = *both {
                self.neighbours[t as usize][k as usize] = Some(u);
                self.neighbours[u as usize][m as usize] = Some(t);
            }
        }
        match labels.next() {
            Some((edge, _)) if !sides.is_empty() => Err(MeshError::LostEdge { ends: edge.ends }),
            _ => Ok(()),
        }
    }

    /// Checks what the type promises; for tests and for debug builds between stages.
    ///
    /// # Panics
    /// When a triangle is not counter-clockwise or out of order, or when two neighbours disagree
    /// about the edge between them.
    pub fn check_invariants(&self) {
        let ascending = self.triangles.windows(2).all(|w| w[0] < w[1]);
        assert!(ascending, "triangles are not strictly ascending");
        for (t, corners) in self.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|v| self.vertices[v as usize]);
            assert!(orient(a, b, c) > 0, "{corners:?} is not counter-clockwise");
            assert_eq!(*corners, smallest_first(*corners));
            for k in 0..3 {
                let Some(u) = self.neighbours[t][k].map(|u| u as usize) else {
                    continue;
                };
                let m = self.side_towards(u, t);
                let edge = [corners[k], corners[(k + 1) % 3]];
                let theirs = [self.triangles[u][(m + 1) % 3], self.triangles[u][m]];
                assert_eq!(edge, theirs, "neighbours {t} and {u} share no edge");
                assert_eq!(self.edges[t][k], self.edges[u][m], "{t} and {u}: labels");
            }
        }
    }

    /// The triangle across edge `k` of triangle `t`, if both are `inside` and the edge is not a `barrier`.
    fn beyond(&self, t: usize, k: usize, inside: &[bool], barrier: &[bool]) -> Option<usize> {
        let is_barrier = self.edges[t][k].is_some_and(|e| barrier[e as usize]);
        let u = self.neighbours[t][k]? as usize;
        (!is_barrier && inside[u]).then_some(u)
    }

    /// The next corner around the vertex of corner `(t, c)`, counter-clockwise or clockwise, if [`Self::beyond`] is.
    ///
    /// Edge `c` leaves the vertex, with the triangle to its left, so crossing it turns clockwise; edge `c + 2` arrives.
    fn turn(
        &self,
        (t, c): (usize, usize),
        counter_clockwise: bool,
        inside: &[bool],
        barrier: &[bool],
    ) -> Option<(usize, usize)> {
        let k = if counter_clockwise { (c + 2) % 3 } else { c };
        let u = self.beyond(t, k, inside, barrier)?;
        let vertex = self.triangles[t][c];
        let corner = self.triangles[u].iter().position(|&v| v == vertex);
        Some((u, corner.expect("the crossed edge ends at the vertex")))
    }
}

/// For each edge of the arrangement, whether one of its sources `is` (or, with `odd`, an odd number of them are).
fn labelled(arrangement: &Arrangement, is: impl Fn(u32) -> bool, odd: bool) -> Vec<bool> {
    let count = |sources: &[u32]| sources.iter().filter(|&&s| is(s)).count();
    let edges = arrangement.edges.iter().map(|e| count(&e.sources));
    edges
        .map(|n| if odd { n % 2 == 1 } else { n > 0 })
        .collect()
}

/// For each triangle, whether it lies inside the closed loops of the outline (even–odd rule).
///
/// A walk from beyond the hull toggles at each edge with an odd number of outline sources. So loops
/// may be nested, and where two stretches of the outline coincide, as at a slit or where rounding closed a thin neck, they cancel.
/// For that each segment of the outline needs **a source of its own**: [`super::ArrangedEdge::sources`]
/// lists a source once. If the loops are not closed, which triangles are inside depends on the walk, though always in the same way.
pub fn inside(
    triangulation: &Triangulation,
    arrangement: &Arrangement,
    is_outline: impl Fn(u32) -> bool,
) -> Vec<bool> {
    let outline = labelled(arrangement, is_outline, true);
    let toggles = |t: usize, k: usize| {
        let edge = triangulation.edges[t][k];
        edge.is_some_and(|e| outline[e as usize])
    };
    let mut state = vec![None; triangulation.triangles.len()];
    let mut stack = Vec::new();

    // Enter from outside through every side of the hull, then spread.
    for (t, across) in triangulation.neighbours.iter().enumerate() {
        for (k, neighbour) in across.iter().enumerate() {
            if neighbour.is_none() && state[t].is_none() {
                state[t] = Some(toggles(t, k));
                stack.push(t);
            }
        }
    }
    while let Some(t) = stack.pop() {
        for k in 0..3 {
            let Some(u) = triangulation.neighbours[t][k] else {
                continue;
            };
            if state[u as usize].is_none() {
                state[u as usize] = state[t].map(|s| s != toggles(t, k));
                stack.push(u as usize);
            }
        }
    }
    state.into_iter().map(|s| s == Some(true)).collect()
}

/// For each inside triangle the number of its region: inside triangles that are connected without crossing a barrier.
///
/// An edge is a barrier when any of its sources is one. Regions are numbered from 0 by their first
/// triangle. A slit of the outline lies within the face; it separates only if its sources are barriers, too.
pub fn regions(
    triangulation: &Triangulation,
    arrangement: &Arrangement,
    inside: &[bool],
    is_barrier: impl Fn(u32) -> bool,
) -> Vec<Option<u32>> {
    let barrier = labelled(arrangement, is_barrier, false);
    let mut region = vec![None; triangulation.triangles.len()];
    let mut count = 0;
    for first in (0..region.len()).filter(|&t| inside[t]) {
        if region[first].is_some() {
            continue;
        }
        region[first] = Some(count);
        let mut stack = vec![first];
        while let Some(t) = stack.pop() {
            for k in 0..3 {
                if let Some(u) = triangulation.beyond(t, k, inside, &barrier)
                    && region[u].is_none()
                {
                    region[u] = Some(count);
                    stack.push(u);
                }
            }
        }
        count += 1;
    }
    region
}

/// Where values live: one site for each vertex and each sector of inside triangles around it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sites {
    /// For each triangle the sites of its corners; `None` outside.
    pub corners: Vec<Option<[u32; 3]>>,
    /// For each site its vertex.
    pub vertices: Vec<u32>,
}

/// Groups the inside triangles around each vertex into sectors between barrier edges and gives each sector a site.
///
/// ```text
///   A │ B        a barrier through a vertex: two sites;  T: three;  X: four
///  ───●───       a barrier that ends at a vertex: one site, since the sector goes around the end
///   C │ D        no barrier: one site
/// ```
///
/// The border of the inside separates like a barrier, so two parts of a face that touch at a
/// vertex only have a site each. Sites are numbered from 0 by their first triangle and corner.
pub fn sectors(
    triangulation: &Triangulation,
    arrangement: &Arrangement,
    inside: &[bool],
    is_barrier: impl Fn(u32) -> bool,
) -> Sites {
    let barrier = labelled(arrangement, is_barrier, false);
    let mut site = vec![[None; 3]; triangulation.triangles.len()];
    let mut vertices = Vec::new();
    for first in (0..site.len()).filter(|&t| inside[t]) {
        for c in 0..3 {
            if site[first][c].is_some() {
                continue;
            }
            let id = vertices.len() as u32;
            vertices.push(triangulation.triangles[first][c]);
            site[first][c] = Some(id);
            // Turn to the one end of the sector, then to the other; a full turn ends the first walk.
            for counter_clockwise in [true, false] {
                let mut at = (first, c);
                while let Some(next) = triangulation.turn(at, counter_clockwise, inside, &barrier) {
                    if site[next.0][next.1].is_some() {
                        break;
                    }
                    site[next.0][next.1] = Some(id);
                    at = next;
                }
            }
        }
    }
    let corners = site
        .into_iter()
        .map(|[a, b, c]| Some([a?, b?, c?]))
        .collect();
    Sites { corners, vertices }
}

#[cfg(test)]
mod tests;
