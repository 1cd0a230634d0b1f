//! One row of the transport: what a point sees of the solve mesh, exactly.
//!
//! Face by face: the parts that may stand between are found once for the face, their cones built once; an element that no
//! cone touches gets its form factor from the angles of its edges, each computed once for the two elements it borders;
//! only elements in partial view are clipped.

use super::reach::direction;
use super::solve_mesh::SolveTriangle;
use super::{SolveFace, SolveMesh};
use crate::direct::{edge_term, form_factor_of_directions};
use crate::mesh::barycentric;
use crate::scene::{FaceId, FaceSide};
use crate::visibility::{Blockers, Cone, Cones, Directions, Scratch, Target, Viewpoint};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A source face this many times farther than its radius is taken as a whole, with its mean radiosity: over it the
/// kernel then varies by less than an eighth.
const FAR_IN_RADII: f64 = 8.0;

/// Only a face this many times farther than its radius may be judged by one ray to its middle: its form factor is then
/// that of a point to a few per cent.
const NEAR_IN_RADII: f64 = 4.0;

/// A visible piece wider than this share of its distance is divided before its basis weights are read at its middle.
const PIECE_SHARE: f64 = 0.5;

/// Divisions of a piece at most: each halves its width, so that the last ones matter for 4⁻⁵ of the element.
const MAX_DIVISIONS: u32 = 5;

/// Up to so many blockers an element in partial view is clipped exactly, however small it looks.
const FEW_BLOCKERS: usize = 2;

/// Behind more blockers an element that looks this many times larger than what one ray is enough for is sampled at
/// sixteen points.
const MANY_BLOCKERS_FACTOR: f64 = 64.0;

/// Rays of a sampled row: evenly spread, they are right to about a per cent.
const ROW_RAYS: u32 = 512;

/// Coefficients of one row: `H = Σ weight · R[site] + Σ weight · mean R of a face`.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// (site, weight), sites ascending, each once.
    pub sites: Vec<(u32, f64)>,
    /// (index of the solve face, weight), ascending.
    pub faces: Vec<(u32, f64)>,
}

impl Row {
    /// Sum of all weights: the share of the hemisphere filled by reflecting elements (0…1).
    pub fn sum(&self) -> f64 {
        self.sites.iter().chain(&self.faces).map(|w| w.1).sum()
    }
}

/// Evaluates rows; holds the buffers of one thread.
pub struct Gatherer<'a> {
    mesh: &'a SolveMesh,
    blockers: &'a Blockers,
    scratch: Scratch,
    weights: Weights,
    candidates: Vec<u32>,
    cones: Cones,
    /// Of the face at hand: directions to its vertices, their heights above the horizon, the terms of its edges, and for
    /// each cone and vertex the sides of the cone that it lies beyond.
    directions: Vec<DVec3>,
    heights: Vec<f64>,
    terms: Vec<f64>,
    beyond: Vec<u64>,
    arrays: Directions,
    /// The cones that touch the element at hand.
    touching: Vec<u32>,
}

/// What the cones do to an element.
enum Sight {
    Clear,
    Hidden,
    Partial,
}

impl<'a> Gatherer<'a> {
    /// A gatherer from the elements of `mesh` past `blockers`.
    pub fn new(mesh: &'a SolveMesh, blockers: &'a Blockers) -> Self {
        Self {
            mesh,
            blockers,
            scratch: Scratch::default(),
            weights: Weights {
                values: vec![0.0; mesh.site_count()],
                touched: Vec::new(),
            },
            candidates: Vec::new(),
            cones: Cones::default(),
            directions: Vec::new(),
            heights: Vec::new(),
            terms: Vec::new(),
            beyond: Vec::new(),
            arrays: Directions::default(),
            touching: Vec::new(),
        }
    }

    /// The row of a small face by rays alone, every face it sees taken as a whole: what such a face reflects matters little,
    /// and the final gather is made afresh wherever it is looked at.
    pub(super) fn sampled_row(&mut self, view: &Viewpoint, own: FaceId) -> Row {
        let rays = self.blockers.rays();
        let mut seen: Vec<u32> = (0..ROW_RAYS)
            .filter_map(|i| {
                let hit = rays.nearest_where(
                    view.position,
                    direction(view.horizon.normal, i),
                    0.0,
                    f64::INFINITY,
                    |h| self.blockers.ray_owner(h.triangle) != own,
                )?;
                let side = if hit.is_front {
                    FaceSide::Front
                } else {
                    FaceSide::Back
                };
                let key = (self.blockers.ray_owner(hit.triangle), side);
                let index = self
                    .mesh
                    .faces
                    .binary_search_by_key(&key, |f| (f.domain.face, f.domain.side));
                index.ok().map(|k| k as u32)
            })
            .collect();
        seen.sort_unstable();
        let mut row = Row::default();
        for k in seen {
            match row.faces.last_mut() {
                Some(last) if last.0 == k => last.1 += 1.0 / f64::from(ROW_RAYS),
                _ => row.faces.push((k, 1.0 / f64::from(ROW_RAYS))),
            }
        }
        row
    }

    /// The row of `view`.
    pub fn row(&mut self, view: &Viewpoint) -> Row {
        let mut row = Row::default();
        let mesh = self.mesh;
        for (i, source) in mesh.faces.iter().enumerate() {
            if source.reflectance.is_black()
                || source.triangles.is_empty()
                || source.plane.distance(view.position) <= self.blockers.roundoff()
            {
                continue;
            }
            let to_centre = source.centre - view.position;
            if view.horizon.normal.dot(to_centre) <= -source.radius {
                continue;
            }
            if self.glance(view, source, i as u32, &mut row) || !self.look_at(view, source) {
                continue;
            }
            let is_far = to_centre.length() > FAR_IN_RADII * source.radius;
            let mut whole = 0.0;
            for (e, t) in source.triangles.iter().enumerate() {
                match self.sight(source, t) {
                    Sight::Hidden => {}
                    Sight::Clear => self.clear(view, source, e, is_far, &mut whole),
                    Sight::Partial => self.partial(view, source, e, is_far, &mut whole),
                }
            }
            if whole > 0.0 {
                row.faces.push((i as u32, whole));
            }
        }
        row.sites = self.weights.drain();
        row
    }

    /// Adds a face that fills too little of the hemisphere to be worth more than a few rays; false when it fills more.
    fn glance(&self, view: &Viewpoint, source: &SolveFace, index: u32, row: &mut Row) -> bool {
        let Some(middle) = source.middle_point else {
            return true;
        };
        let d = middle - view.position;
        let squared = d.length_squared();
        // Seen from nearby the face may look larger from elsewhere on it: only the far ones are judged by their middle.
        if squared < NEAR_IN_RADII * NEAR_IN_RADII * source.radius * source.radius {
            return false;
        }
        let cosines = view.horizon.normal.dot(d) * source.plane.distance(view.position) / squared;
        let f = cosines * source.area / (PI * squared);
        if f > source.sampled_below || source.sampled_below == 0.0 {
            return false;
        }
        if f > 0.0 && self.blockers.sees(view, middle, source.domain.face) {
            row.faces.push((index, f));
        }
        true
    }

    /// Prepares everything about one source face that its elements share; false when none of it is above the horizon.
    fn look_at(&mut self, view: &Viewpoint, source: &SolveFace) -> bool {
        self.directions.clear();
        self.directions
            .extend(source.positions.iter().map(|&p| p - view.position));
        self.heights.clear();
        self.heights
            .extend(self.directions.iter().map(|d| view.horizon.normal.dot(*d)));
        if !self.heights.iter().any(|&h| h > 0.0) {
            return false;
        }
        self.candidates.clear();
        self.blockers.collect(
            view,
            source.region(view),
            source.plane,
            &mut self.candidates,
        );
        let rectangle = source.rectangle.map(|p| p - view.position);
        let is_hidden = self.blockers.cones(
            &self.candidates,
            view,
            source.plane,
            &rectangle,
            &mut self.cones,
        );
        if is_hidden {
            return false;
        }
        self.arrays.set(&self.directions);
        self.beyond.clear();
        for cone in self.cones.iter() {
            cone.outside(&self.arrays, &mut self.beyond);
        }
        self.terms.clear();
        self.terms.extend(source.edges.iter().map(|&[a, b]| {
            edge_term(
                view.horizon.normal,
                self.directions[a as usize],
                self.directions[b as usize],
            )
        }));
        true
    }

    /// What the cones do to an element; lists those that touch it.
    fn sight(&mut self, source: &SolveFace, t: &SolveTriangle) -> Sight {
        self.touching.clear();
        let corners = t.vertices.map(|v| v as usize);
        let heights = corners.map(|v| self.heights[v]);
        if heights.iter().all(|&h| h <= 0.0) {
            return Sight::Hidden;
        }
        let n = source.positions.len();
        let directions = corners.map(|v| self.directions[v]);
        for (i, cone) in self.cones.iter().enumerate() {
            let [x, y, z] = corners.map(|v| self.beyond[i * n + v]);
            // A cone is convex: with all corners inside it the whole element is.
            if x | y | z == 0 && cone.is_simple() {
                return Sight::Hidden;
            }
            if x & y & z == 0 && !cone.is_beyond_edge_of(&directions) {
                self.touching.push(i as u32);
            }
        }
        if self.touching.is_empty() && heights.iter().all(|&h| h >= 0.0) {
            Sight::Clear
        } else {
            Sight::Partial
        }
    }

    /// Adds an element in full view.
    fn clear(
        &mut self,
        view: &Viewpoint,
        source: &SolveFace,
        e: usize,
        is_far: bool,
        whole: &mut f64,
    ) {
        let t = &source.triangles[e];
        let corners = t.vertices.map(|v| self.directions[v as usize]);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        if !is_far && t.width_squared > PIECE_SHARE * PIECE_SHARE * middle.length_squared() {
            let mut sum = [0.0; 3];
            let weigh = weights_on(source, view, e);
            accumulate(view.horizon.normal, corners, 0, &weigh, &mut sum);
            self.weights.add(source, source.mesh.sites[e], sum);
            return;
        }
        let f = t
            .edges
            .iter()
            .map(|&(edge, is_along)| {
                let term = self.terms[edge as usize];
                if is_along { term } else { -term }
            })
            .sum::<f64>()
            / TAU;
        if is_far {
            *whole += f;
        } else {
            // At the middle of an undivided element the three basis functions are equal.
            self.weights.add(source, t.sites, [f / 3.0; 3]);
        }
    }

    /// Adds what is visible of an element in partial view.
    fn partial(
        &mut self,
        view: &Viewpoint,
        source: &SolveFace,
        e: usize,
        is_far: bool,
        whole: &mut f64,
    ) {
        let t = &source.triangles[e];
        let corners = t.vertices.map(|v| source.positions[v as usize]);
        let target = Target {
            corners: &corners,
            plane: source.plane,
        };
        let cones = || self.touching.iter().map(|&i| self.cones.get(i as usize));
        let mut sum = [0.0; 3];
        let normal = view.horizon.normal;
        let looks = t.width_squared / self.directions[t.vertices[0] as usize].length_squared();
        if self.touching.len() > FEW_BLOCKERS && looks < MANY_BLOCKERS_FACTOR * source.sampled_below
        {
            let f = sampled(
                normal,
                t.vertices.map(|v| self.directions[v as usize]),
                cones,
            );
            if is_far {
                *whole += f;
            } else {
                self.weights.add(source, t.sites, [f / 3.0; 3]);
            }
            return;
        }
        let weigh = weights_on(source, view, e);
        let up = source.plane.normal;
        self.scratch
            .visible_past(self.blockers, cones(), view, target, |piece| {
                if is_far {
                    *whole += form_factor_of_directions(normal, piece);
                } else {
                    accumulate_piece(normal, up, piece, &weigh, &mut sum);
                }
            });
        self.weights.add(source, source.mesh.sites[e], sum);
    }
}

/// The row under construction: a dense buffer of weights and the sites it holds.
#[derive(Default)]
struct Weights {
    values: Vec<f64>,
    touched: Vec<u32>,
}

impl Weights {
    fn add(&mut self, source: &SolveFace, sites: [u32; 3], weights: [f64; 3]) {
        for (s, w) in sites.into_iter().zip(weights) {
            if w != 0.0 {
                let site = source.first_site + s as usize;
                self.touched.push(site as u32);
                self.values[site] += w;
            }
        }
    }

    /// The nonzero weights in order; the buffer is empty again.
    fn drain(&mut self) -> Vec<(u32, f64)> {
        self.touched.sort_unstable();
        self.touched.dedup();
        let mut out = Vec::with_capacity(self.touched.len());
        for s in self.touched.drain(..) {
            out.push((s, std::mem::take(&mut self.values[s as usize])));
        }
        out
    }
}

/// The form factor of a triangle of directions by the share of its sixteen equal parts whose middles no cone hides.
fn sampled<'c, I: Iterator<Item = Cone<'c>>>(
    n: DVec3,
    t: [DVec3; 3],
    cones: impl Fn() -> I,
) -> f64 {
    if t.iter().any(|d| n.dot(*d) < 0.0) {
        // Near the horizon the cosine is next to nothing.
        return 0.0;
    }
    let seen = SAMPLE_WEIGHTS
        .iter()
        .filter(|w| {
            let d = t[0] * w[0] + t[1] * w[1] + t[2] * w[2];
            !cones().any(|c| c.hides(d))
        })
        .count();
    form_factor_of_directions(n, &t) * seen as f64 / SAMPLE_WEIGHTS.len() as f64
}

/// Middles of the sixteen triangles that two halvings of the edges make: barycentric coordinates.
const SAMPLE_WEIGHTS: [[f64; 3]; 16] = {
    let mut w = [[0.0; 3]; 16];
    let (mut k, mut i) = (0, 0);
    while i < 4 {
        let mut j = 0;
        while i + j < 4 {
            // Upright triangles, then the inverted ones between them.
            let (a, b) = (i as f64, j as f64);
            w[k] = [
                (a + 1.0 / 3.0) / 4.0,
                (b + 1.0 / 3.0) / 4.0,
                1.0 - (a + b + 2.0 / 3.0) / 4.0,
            ];
            k += 1;
            if i + j < 3 {
                w[k] = [
                    (a + 2.0 / 3.0) / 4.0,
                    (b + 2.0 / 3.0) / 4.0,
                    1.0 - (a + b + 4.0 / 3.0) / 4.0,
                ];
                k += 1;
            }
            j += 1;
        }
        i += 1;
    }
    w
};

/// The basis functions of element `e` in a direction from `view`, in the order of the mesh's own corners.
fn weights_on(source: &SolveFace, view: &Viewpoint, e: usize) -> impl Fn(DVec3) -> [f64; 3] {
    let (corners, frame, eye) = (source.mesh.corners(e), source.domain.frame, view.position);
    move |d| barycentric(corners, frame.to_plane(eye + d))
}

/// Splits the form factor of a convex polygon of directions, in a plane with unit normal `up`, by the basis functions.
fn accumulate_piece(
    n: DVec3,
    up: DVec3,
    piece: &[DVec3],
    weigh: &impl Fn(DVec3) -> [f64; 3],
    sum: &mut [f64; 3],
) {
    let fan = || (2..piece.len()).map(|i| [piece[0], piece[i - 1], piece[i]]);
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for [a, b, c] in fan() {
        let twice = (b - a).cross(c - a).dot(up);
        area += twice;
        moment += (a + b + c) * twice;
    }
    let middle = if area > 0.0 {
        moment / (3.0 * area)
    } else {
        piece[0]
    };
    let radius_squared = piece
        .iter()
        .map(|p| p.distance_squared(middle))
        .fold(0.0, f64::max);
    // The polygon is at most two radii wide.
    let share = 0.5 * PIECE_SHARE;
    if radius_squared > share * share * middle.length_squared() {
        for t in fan() {
            accumulate(n, t, 0, weigh, sum);
        }
        return;
    }
    let f = form_factor_of_directions(n, piece);
    for (s, w) in sum.iter_mut().zip(weigh(middle)) {
        *s += f * w;
    }
}

/// Splits the form factor of a triangle of directions by the basis functions at its middle, dividing wide ones.
fn accumulate(
    n: DVec3,
    t: [DVec3; 3],
    depth: u32,
    weigh: &impl Fn(DVec3) -> [f64; 3],
    sum: &mut [f64; 3],
) {
    let middle = (t[0] + t[1] + t[2]) / 3.0;
    let width = t[0]
        .distance_squared(t[1])
        .max(t[1].distance_squared(t[2]))
        .max(t[2].distance_squared(t[0]));
    if depth < MAX_DIVISIONS && width > PIECE_SHARE * PIECE_SHARE * middle.length_squared() {
        let m = [
            0.5 * (t[0] + t[1]),
            0.5 * (t[1] + t[2]),
            0.5 * (t[2] + t[0]),
        ];
        for part in [
            [t[0], m[0], m[2]],
            [m[0], t[1], m[1]],
            [m[2], m[1], t[2]],
            m,
        ] {
            accumulate(n, part, depth + 1, weigh, sum);
        }
        return;
    }
    let f = form_factor_of_directions(n, &t);
    for (s, w) in sum.iter_mut().zip(weigh(middle)) {
        *s += f * w;
    }
}
