//! What the rays of a picture meet first, without casting them: triangles drawn onto the grid of the rays' directions.
//!
//! All rays start at one eye. From there, a ray in the direction `d` passes between the corners a, b, c of a triangle where
//! `d · (c × b)`, `d · (a × c)` and `d · (b × a)` have one sign: these are the corners' weights, up to a factor. Along a row of the
//! picture they are linear, and so is the inverse of the distance. What crosses the plane of the eye needs no clipping.
//!
//! Two triangles that share an edge compute exactly opposite values for it, and zero belongs to both: nothing shows through.
//!
//! Paper: M. Olano & T. Greer, *Triangle scan conversion using 2D homogeneous coordinates*, 1997.

use crate::geom::Plane;
use crate::visibility::{Hit, clip_to_front};
use glam::{DMat3, DVec3};
use smallvec::SmallVec;
use std::ops::Range;

/// The rays of a picture: `columns` × `rows` of them, even over what lies between −1 and 1 to the right and upwards.
pub(super) struct Rays {
    pub(super) eye: DVec3,
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// The direction of the middle.
    pub(super) forward: DVec3,
    /// Half the width and half the height of the picture at distance 1, as vectors.
    pub(super) half_right: DVec3,
    pub(super) half_up: DVec3,
}

/// A triangle from the eye.
struct Facet {
    /// Its number in the list that the raster was made from.
    triangle: u32,
    /// The corners' weights are the products of a direction with these, positive inside.
    weights: [DVec3; 3],
    /// The inverse of the distance is the product of a direction with this.
    plane: DVec3,
    is_front: bool,
    is_cut_out: bool,
    /// Rays that may meet it.
    columns: Range<u32>,
    rows: Range<u32>,
}

/// The triangles that are seen, ready to be drawn row by row.
pub(super) struct Raster {
    rays: Rays,
    facets: Vec<Facet>,
    /// Those that each row may meet, in the order of the triangles.
    of_row: Vec<Vec<u32>>,
}

/// What the rays of one row meet.
#[derive(Default)]
pub(super) struct Row {
    /// The inverse of the distance, and the facet; zero where nothing is met.
    nearest: Vec<(f64, u32)>,
}

impl Rays {
    /// The direction of one ray.
    pub(super) fn direction(&self, column: u32, row: u32) -> DVec3 {
        self.start_of(row) + self.half_right * middle(column, self.columns)
    }

    /// The direction in the middle of a row.
    fn start_of(&self, row: u32) -> DVec3 {
        self.forward - self.half_up * middle(row, self.rows)
    }
}

/// Where part `index` of `count` has its middle, from −1 at the first edge to 1 at the last.
fn middle(index: u32, count: u32) -> f64 {
    (2.0 * f64::from(index) + 1.0) / f64::from(count) - 1.0
}

/// The parts of `count` whose middles may lie in `from..=to`: one more at each end, for rounding.
fn parts(from: f64, to: f64, count: u32) -> Range<u32> {
    let index = |x: f64| 0.5 * ((x + 1.0) * f64::from(count) - 1.0);
    // What lies outside of the picture, or nowhere, ends at its border.
    let first = (index(from).floor() - 1.0) as u32;
    let end = (index(to).ceil() + 2.0) as u32;
    first.min(count)..end.min(count)
}

impl Raster {
    /// `triangles` come with what is seen of them.
    pub(super) fn new(rays: Rays, triangles: impl Iterator<Item = ([DVec3; 3], Side)>) -> Self {
        let to_picture = DMat3::from_cols(rays.half_right, rays.half_up, rays.forward).inverse();
        let mut facets = Vec::new();
        let mut of_row = vec![Vec::new(); rays.rows as usize];
        for (triangle, (corners, side)) in (0..).zip(triangles) {
            let corners = corners.map(|p| p - rays.eye);
            if let Some(facet) = Facet::new(triangle, corners, side, &rays, to_picture) {
                for row in facet.rows.clone() {
                    of_row[row as usize].push(facets.len() as u32);
                }
                facets.push(facet);
            }
        }
        Self {
            rays,
            facets,
            of_row,
        }
    }

    pub(super) fn rays(&self) -> &Rays {
        &self.rays
    }

    /// Finds what the rays of row number `row` meet first; of cut-out triangles what `is_there`. Of hits at the same distance
    /// the triangle that was listed first.
    pub(super) fn draw(&self, row: u32, is_there: impl Fn(&Hit, DVec3) -> bool, out: &mut Row) {
        let rays = &self.rays;
        let (start, step) = (rays.start_of(row), rays.half_right);
        out.nearest.clear();
        out.nearest.resize(rays.columns as usize, (0.0, 0));
        for &number in &self.of_row[row as usize] {
            let facet = &self.facets[number as usize];
            let lines = facet.weights.map(|w| [w.dot(start), w.dot(step)]);
            let depth = [facet.plane.dot(start), facet.plane.dot(step)];
            for column in facet.columns_between(lines, rays.columns) {
                let across = middle(column, rays.columns);
                let nearest = &mut out.nearest[column as usize];
                let inverse = depth[0] + depth[1] * across;
                if inverse > nearest.0
                    && lines.iter().all(|[at, by]| at + by * across >= 0.0)
                    && (!facet.is_cut_out || {
                        let d = rays.direction(column, row);
                        facet.hit(d).is_some_and(|hit| is_there(&hit, d))
                    })
                {
                    *nearest = (inverse, number);
                }
            }
        }
    }

    /// What one ray meets, as found by [`Raster::draw`] of its row, and its direction.
    pub(super) fn hit(&self, found: &Row, column: u32, row: u32) -> Option<(Hit, DVec3)> {
        let (inverse, number) = found.nearest[column as usize];
        if inverse <= 0.0 {
            return None;
        }
        let direction = self.rays.direction(column, row);
        let hit = self.facets[number as usize].hit(direction)?;
        Some((hit, direction))
    }
}

/// What is seen of a triangle.
#[derive(Clone, Copy)]
pub(super) struct Side {
    /// Its back as well as its front.
    pub(super) is_double: bool,
    /// Not all of it is there.
    pub(super) is_cut_out: bool,
}

impl Facet {
    /// None when nothing of the triangle with these corners, from the eye, is seen.
    fn new(
        triangle: u32,
        [a, b, c]: [DVec3; 3],
        side: Side,
        rays: &Rays,
        to_picture: DMat3,
    ) -> Option<Self> {
        let normal = (b - a).cross(c - a);
        let height = normal.dot(a);
        // The front's normal points to the eye. Edge-on nothing is seen.
        let is_front = height < 0.0;
        if !(is_front || side.is_double && height > 0.0) {
            return None;
        }
        let turn = if is_front { 1.0 } else { -1.0 };
        let (columns, rows) = bounds([a, b, c].map(|p| to_picture * p), rays)?;
        Some(Self {
            triangle,
            weights: [c.cross(b), a.cross(c), b.cross(a)].map(|w| w * turn),
            plane: normal / height,
            is_front,
            is_cut_out: side.is_cut_out,
            columns,
            rows,
        })
    }

    /// The columns in which none of the `lines` (value in the middle, slope) is clearly negative.
    fn columns_between(&self, lines: [[f64; 2]; 3], count: u32) -> Range<u32> {
        let (mut from, mut to) = (-1.0_f64, 1.0_f64);
        for [at, by] in lines {
            if by > 0.0 {
                from = from.max(-at / by);
            } else if by < 0.0 {
                to = to.min(-at / by);
            } else if at < 0.0 {
                return 0..0;
            }
        }
        let found = parts(from, to, count);
        found.start.max(self.columns.start)..found.end.min(self.columns.end)
    }

    /// Where a ray in the direction `d`, that is known to pass through it, meets it.
    fn hit(&self, d: DVec3) -> Option<Hit> {
        let [a, b, c] = self.weights.map(|w| w.dot(d));
        let (sum, inverse) = (a + b + c, self.plane.dot(d));
        (sum > 0.0 && inverse > 0.0).then(|| Hit {
            t: 1.0 / inverse,
            triangle: self.triangle,
            u: b / sum,
            v: c / sum,
            is_front: self.is_front,
        })
    }
}

/// The columns and rows of rays that may meet a triangle, given to the right, upwards and forward of the eye, in units of half
/// the picture at distance 1.
fn bounds(corners: [DVec3; 3], rays: &Rays) -> Option<(Range<u32>, Range<u32>)> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut add = |p: &DVec3| {
        let place = p / p.z;
        (low, high) = (low.min(place), high.max(place));
    };
    if corners.iter().all(|p| p.z > 0.0) {
        corners.iter().for_each(&mut add);
    } else {
        // What lies within the picture lies before the eye.
        let borders = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y];
        let mut inside: SmallVec<[DVec3; 8]> = SmallVec::from_slice(&corners);
        for side in borders {
            let border = Plane::new(DVec3::ZERO, (side + DVec3::Z).normalize());
            inside = clip_to_front(&inside, border);
        }
        if inside.iter().any(|p| p.z <= 0.0) {
            return Some((0..rays.columns, 0..rays.rows));
        }
        inside.iter().for_each(&mut add);
    }
    let columns = parts(low.x, high.x, rays.columns);
    let rows = parts(-high.y, -low.y, rays.rows);
    (!columns.is_empty() && !rows.is_empty()).then_some((columns, rows))
}
