//! One row of the transport: what a point sees of the solve mesh, exactly.

use super::{SolveFace, SolveMesh};
use crate::direct::form_factor_of_directions;
use crate::mesh::barycentric;
use crate::visibility::{Blockers, Scratch, Target, Viewpoint};
use glam::DVec3;

/// A source face this many times farther than its radius is taken as a whole, with its mean radiosity: over it the
/// kernel then varies by less than an eighth.
const FAR_IN_RADII: f64 = 8.0;

/// A visible piece wider than this share of its distance is divided before its basis weights are read at its middle.
const PIECE_SHARE: f64 = 0.5;

/// Divisions of a piece at most: each halves its width, so that the last ones matter for 4⁻⁵ of the element.
const MAX_DIVISIONS: u32 = 5;

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
    weights: Vec<f64>,
    touched: Vec<u32>,
    candidates: Vec<u32>,
}

impl<'a> Gatherer<'a> {
    /// A gatherer from the elements of `mesh` past `blockers`.
    pub fn new(mesh: &'a SolveMesh, blockers: &'a Blockers) -> Self {
        Self {
            mesh,
            blockers,
            scratch: Scratch::default(),
            weights: vec![0.0; mesh.site_count()],
            touched: Vec::new(),
            candidates: Vec::new(),
        }
    }

    /// The row of `view`.
    pub fn row(&mut self, view: &Viewpoint) -> Row {
        let mut row = Row::default();
        let mesh = self.mesh;
        for (i, source) in mesh.faces.iter().enumerate() {
            if source.reflectance.is_black() || source.triangles.is_empty() {
                continue;
            }
            let to_centre = source.centre - view.position;
            if source.plane.distance(view.position) <= self.blockers.roundoff()
                || view.horizon.normal.dot(to_centre) <= -source.radius
            {
                continue;
            }
            let mut candidates = std::mem::take(&mut self.candidates);
            candidates.clear();
            self.blockers
                .collect(view, source.region(view), source.plane, &mut candidates);
            if to_centre.length() > FAR_IN_RADII * source.radius {
                let f = self.whole(view, source, &candidates);
                if f > 0.0 {
                    row.faces.push((i as u32, f));
                }
            } else {
                for e in 0..source.triangles.len() {
                    self.element(view, source, e, &candidates);
                }
            }
            self.candidates = candidates;
        }
        self.touched.sort_unstable();
        self.touched.dedup();
        for s in self.touched.drain(..) {
            row.sites.push((s, self.weights[s as usize]));
            self.weights[s as usize] = 0.0;
        }
        row
    }

    /// Form factor of what is visible of all elements of a face.
    fn whole(&mut self, view: &Viewpoint, source: &SolveFace, candidates: &[u32]) -> f64 {
        let mut f = 0.0;
        for triangle in &source.triangles {
            let target = Target {
                corners: triangle,
                plane: source.plane,
            };
            self.scratch
                .visible_pieces_past(self.blockers, candidates, view, target, |piece| {
                    f += form_factor_of_directions(view.horizon.normal, piece);
                });
        }
        f.max(0.0)
    }

    /// Adds the weights of one element's sites.
    fn element(&mut self, view: &Viewpoint, source: &SolveFace, e: usize, candidates: &[u32]) {
        let corners = source.mesh.corners(e);
        let weigh =
            |d: DVec3| barycentric(corners, source.domain.frame.to_plane(view.position + d));
        let target = Target {
            corners: &source.triangles[e],
            plane: source.plane,
        };
        let mut sum = [0.0; 3];
        self.scratch
            .visible_pieces_past(self.blockers, candidates, view, target, |piece| {
                if piece.len() == 3 {
                    accumulate(
                        view.horizon.normal,
                        [piece[0], piece[1], piece[2]],
                        0,
                        &weigh,
                        &mut sum,
                    );
                } else {
                    for i in 1..piece.len().saturating_sub(1) {
                        let fan = [piece[0], piece[i], piece[i + 1]];
                        accumulate(view.horizon.normal, fan, 0, &weigh, &mut sum);
                    }
                }
            });
        for (k, &s) in source.mesh.sites[e].iter().enumerate() {
            if sum[k] != 0.0 {
                let site = source.first_site + s as usize;
                self.touched.push(site as u32);
                self.weights[site] += sum[k];
            }
        }
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
