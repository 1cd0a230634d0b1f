//! The light where the refinement asks for it, each point once.

use super::misfit::Misfit;
use super::mix::Map;
use super::{Illumination, Receiver};
use crate::direct::Look;
use crate::mesh::{GridPoint, Inset, ReceiverMesh, barycentric};
use crate::quantity::Irradiance;
use crate::scene::Size;
use crate::visibility::Scratch;
use glam::DVec2;
use rayon::prelude::*;
use std::cell::RefCell;

/// Share of the element for which the worst value on a crossing line speaks: a feature that the fixed points miss.
const LINE_WEIGHT: f64 = 0.25;

/// Light agrees with its interpolation when it is off by this share of the error asked for.
const AGREEMENT: f64 = 0.25;

/// Barycentric coordinates of the middle of each edge.
const HALVES: [[f64; 3]; 3] = [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];

/// Fewer looks than this are made by one thread: sharing them would cost more.
const SHARED_LOOKS: usize = 64;

/// A point that several elements ask about, on the doubled grid: a vertex or the middle of an edge; or, with the ends of an
/// edge on a border of the values, the point beside its middle, to its left; or a point beside a vertex there.
type Key = [i64; 4];

/// No coordinate is as large: the key of a point and not of an edge.
const NO_EDGE: i64 = i64::MAX;

/// The key of the middle between two vertices, which may be the same.
fn point(a: GridPoint, b: GridPoint) -> Key {
    [a.x + b.x, a.y + b.y, NO_EDGE, NO_EDGE]
}

/// The key of a point beside a border of the values, which lies on no grid.
fn beside(p: DVec2) -> Key {
    [p.x.to_bits() as i64, p.y.to_bits() as i64, NO_EDGE, 0]
}

/// Light at one point.
struct Known {
    light: [Irradiance; 2],
    /// How often the indirect light had changed before.
    changes: usize,
}

/// What is known of the light.
#[derive(Default)]
pub(super) struct Samples {
    points: Map<Key, Known>,
    changes: usize,
    /// Elements that a later mesh may hold again, by their number among those that were measured last.
    elements: Map<[GridPoint; 3], u32>,
    /// The errors of these, once the mesh has become another one, and how often the indirect light had changed before them.
    pub(super) measured: Vec<ElementError>,
    measured_after: usize,
    /// Exact evaluations of direct light so far.
    pub(super) evaluations: usize,
}

thread_local! {
    /// One a thread and not one a receiver: what stands before a single point can fill a megabyte.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Samples {
    /// Forgets all light.
    pub(super) fn forget(&mut self) {
        self.points.clear();
        self.elements.clear();
    }

    /// Forgets what depends on the indirect light.
    pub(super) fn forget_indirect(&mut self) {
        self.changes += 1;
    }
}

/// What was found inside one element.
struct Inside {
    /// Direct light at its centre less what is interpolated there, W/m².
    centre: Irradiance,
    /// Whether the middles of its edges need no look.
    is_smooth: bool,
    /// On the line that breaks most across it, if any could matter.
    line: Option<OnLine>,
}

/// A point on a line.
#[derive(Clone, Copy, Debug)]
struct OnLine {
    place: DVec2,
    /// Direct light there less what is interpolated, W/m².
    direct: Irradiance,
}

/// How far one element is off.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ElementError {
    /// Of the interpolated direct light.
    pub(super) direct: Misfit,
    /// Of the interpolated indirect light.
    pub(super) indirect: Misfit,
    /// On the line that breaks most across it, if any could matter.
    line: Option<OnLine>,
    /// Light there less what is interpolated, squared, (W/m²)².
    line_square: f64,
    /// What is not known of it, squared, (W/m²)².
    doubt: f64,
    /// Estimated integral of the squared error over the element after the fit, (W/m²)² m².
    pub(super) square: f64,
}

impl ElementError {
    /// Estimates the squared error with values `added` to the light at the corners.
    pub(super) fn estimate(&mut self, area: f64, added: [Irradiance; 3]) {
        let misfit = self.direct + self.indirect;
        self.square = area
            * misfit
                .mean_square(added)
                .max(LINE_WEIGHT * self.line_square)
                .max(self.doubt);
    }

    /// Mean square of the misfit at the middle of each edge, (W/m²)².
    pub(super) fn edges(&self) -> [f64; 3] {
        (self.direct + self.indirect)
            .edges
            .map(|m| m.0.mean_square())
    }
}

impl Receiver {
    /// Finds what the middle of a tiny face sees of the emitters.
    pub(super) fn look_out(&mut self, light: &Illumination, mesh: &ReceiverMesh) {
        let area = |&e: &usize| mesh.area(e);
        let largest = (0..mesh.elements.len()).max_by(|a, b| area(a).total_cmp(&area(b)));
        let Some(middle) = largest.map(|e| mesh.centre(e)) else {
            return;
        };
        self.samples.evaluations += 1;
        let (view, tolerance) = (self.view(middle), self.size.accuracy() * light.tolerance);
        let around = self.around.as_deref();
        let found = SCRATCH.with_borrow_mut(|s| light.direct.outlook(&view, around, tolerance, s));
        self.outlook = Some(found);
    }

    /// How many of so many looks at the direct light were made: through an outlook none is.
    fn counted(&self, looks: usize) -> usize {
        if self.outlook.is_none() { looks } else { 0 }
    }

    /// A look at the direct light at a point of the plane that is counted.
    pub(super) fn look(&mut self, light: &Illumination, p: DVec2) -> Look {
        self.samples.evaluations += self.counted(1);
        self.look_at(light, p)
    }

    /// Direct irradiance at a point of the plane as exactly as the refinement needs it, W/m².
    pub(super) fn direct_at(&self, light: &Illumination, p: DVec2) -> Irradiance {
        self.look_at(light, p).light
    }

    fn look_at(&self, light: &Illumination, p: DVec2) -> Look {
        let (view, direct) = (self.view(p), light.direct);
        SCRATCH.with_borrow_mut(|scratch| match &self.outlook {
            Some(outlook) => Look {
                light: direct.irradiance_through(outlook, &view, scratch),
                is_exact: false,
            },
            None => {
                let tolerance = self.size.accuracy() * light.tolerance;
                let vantage = self.vantages.at(p).or(self.around.as_deref());
                direct.look_within(&view, vantage, tolerance, scratch)
            }
        })
    }

    /// Indirect irradiance at a point of the plane.
    pub(super) fn indirect_at(&self, light: &Illumination, p: DVec2) -> Irradiance {
        match (light.indirect, self.solve_face) {
            (Some(field), Some(f)) => field.at(f, p),
            _ => Irradiance::ZERO,
        }
    }

    /// Light at a point, looked at once. Through an outlook a look costs less than the memory for it: of hundreds of thousands
    /// of tiny faces that is what there is most of.
    fn remembered(&mut self, light: &Illumination, key: Key, p: DVec2) -> [Irradiance; 2] {
        if self.outlook.is_some() {
            return [self.direct_at(light, p), self.indirect_at(light, p)];
        }
        let changes = self.samples.changes;
        let direct = match self.samples.points.get(&key) {
            Some(known) if known.changes == changes => return known.light,
            Some(known) => known.light[0],
            None => self.look(light, p).light,
        };
        let light = [direct, self.indirect_at(light, p)];
        self.samples.points.insert(key, Known { light, changes });
        light
    }

    /// Looks at the direct light of all that is not known yet of `points`.
    fn remember(&mut self, light: &Illumination, points: impl Iterator<Item = (Key, DVec2)>) {
        if self.outlook.is_some() {
            return;
        }
        let known = &self.samples.points;
        let mut missing: Vec<(Key, DVec2)> = points.filter(|p| !known.contains_key(&p.0)).collect();
        missing.sort_unstable_by_key(|p| p.0);
        missing.dedup_by_key(|p| p.0);
        let found = all(&missing, |&(_, p)| {
            [self.direct_at(light, p), self.indirect_at(light, p)]
        });
        self.samples.evaluations += self.counted(missing.len());
        let changes = self.samples.changes;
        for ((key, _), light) in missing.into_iter().zip(found) {
            self.samples.points.insert(key, Known { light, changes });
        }
    }

    /// Direct and indirect light at every site of `mesh`, W/m².
    pub(super) fn light_at_sites(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
    ) -> [Vec<Irradiance>; 2] {
        let sites: Vec<(Key, DVec2)> = (0..mesh.site_points.len())
            .map(|s| {
                let p = mesh.site_points[s];
                if mesh.is_limit[s] {
                    return (beside(p), p);
                }
                let g = mesh.vertices[mesh.site_vertices[s] as usize];
                (point(g, g), p)
            })
            .collect();
        self.remember(light, sites.iter().copied());
        let both = sites.iter().map(|&(key, p)| self.remembered(light, key, p));
        let (direct, indirect) = both.map(|[d, i]| (d, i)).unzip();
        [direct, indirect]
    }

    /// Light at the middle of edge `k` of element `e`, direct and indirect, W/m².
    fn at_middle(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        e: usize,
        k: usize,
    ) -> [Irradiance; 2] {
        let (key, p) = self.middle_point(mesh, e, k);
        self.remembered(light, key, p)
    }

    /// The middle of edge `k` of element `e` and its key.
    fn middle_point(&self, mesh: &ReceiverMesh, e: usize, k: usize) -> (Key, DVec2) {
        let [a, b] = [k, (k + 1) % 3].map(|c| mesh.vertices[mesh.elements[e][c] as usize]);
        let key = match mesh.is_barrier(e, k) {
            true => [a.x, a.y, b.x, b.y],
            false => point(a, b),
        };
        (key, self.middle(mesh, e, k))
    }

    /// The middle of edge `k` of element `e`; of one across which values may differ, just inside the element.
    fn middle(&self, mesh: &ReceiverMesh, e: usize, k: usize) -> DVec2 {
        let p = mesh.corners(e);
        let middle = p[k].midpoint(p[(k + 1) % 3]);
        match mesh.is_barrier(e, k) {
            true => mesh.inset(e, middle, Inset::limit(self.weld_distance)),
            false => middle,
        }
    }

    /// Exact light at corner `k` of element `e`.
    fn at_corner(&self, mesh: &ReceiverMesh, e: usize, k: usize) -> Irradiance {
        let s = mesh.sites[e][k] as usize;
        self.exact[0][s] + self.exact[1][s]
    }

    /// Misfit of linear interpolation at the middle of edge `k` of element `e`, W/m².
    pub(super) fn edge_misfit(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        e: usize,
        k: usize,
    ) -> Irradiance {
        let [direct, indirect] = self.at_middle(light, mesh, e, k);
        let ends = self.at_corner(mesh, e, k) + self.at_corner(mesh, e, (k + 1) % 3);
        direct + indirect - ends * 0.5
    }

    /// The same at the middle of a chord between two corners, each given by its element and number.
    pub(super) fn chord_misfit(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        ends: [(usize, usize); 2],
    ) -> Irradiance {
        let [a, b] = ends.map(|(e, k)| mesh.vertices[mesh.elements[e][k] as usize]);
        let [p, q] = ends.map(|(e, k)| mesh.corners(e)[k]);
        let key = point(a, b);
        let [direct, indirect] = self.remembered(light, key, p.midpoint(q));
        let [u, v] = ends.map(|(e, k)| self.at_corner(mesh, e, k));
        direct + indirect - (u + v) * 0.5
    }

    /// Linear interpolation over element `e` of the exact light at its corners, direct and indirect.
    fn interpolate(&self, mesh: &ReceiverMesh, e: usize, weights: [f64; 3]) -> [Irradiance; 2] {
        [0, 1].map(|i| {
            let [a, b, c] = mesh.sites[e].map(|s| self.exact[i][s as usize]);
            a * weights[0] + b * weights[1] + c * weights[2]
        })
    }

    /// Errors of the elements of `mesh`, from earlier or new; `target` as for [`Receiver::look_inside`].
    pub(super) fn measure_all(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        target: f64,
    ) -> Vec<ElementError> {
        let key = |e: usize| mesh.elements[e].map(|v| mesh.vertices[v as usize]);
        let known = &self.samples.elements;
        let new: Vec<usize> = (0..mesh.elements.len())
            .filter(|&e| !known.contains_key(&key(e)))
            .collect();
        let insides = all(&new, |&e| self.look_inside(light, mesh, e, target));
        let looks = insides.iter().map(|i| 1 + usize::from(i.line.is_some()));
        let looks = looks.sum();
        self.samples.evaluations += self.counted(looks);
        let rough = new.iter().zip(&insides).filter(|(_, i)| !i.is_smooth);
        let middles: Vec<(Key, DVec2)> = rough
            .flat_map(|(&e, _)| [0, 1, 2].map(|k| self.middle_point(mesh, e, k)))
            .collect();
        self.remember(light, middles.into_iter());
        let mut measured = new.iter().zip(&insides).peekable();
        let is_current = self.samples.measured_after == self.samples.changes;
        let is_kept = self.outlook.is_none();
        let room = if is_kept { mesh.elements.len() } else { 0 };
        let mut kept = Map::with_capacity_and_hasher(room, Default::default());
        let errors = (0..mesh.elements.len())
            .map(|e| {
                let error = match measured.next_if(|(new, _)| **new == e) {
                    Some((_, inside)) => {
                        let direct = self.direct_misfit(light, mesh, e, inside);
                        self.error(light, mesh, e, direct, inside.line)
                    }
                    None => {
                        let known = self.samples.measured[self.samples.elements[&key(e)] as usize];
                        match is_current {
                            true => known,
                            false => self.error(light, mesh, e, known.direct, known.line),
                        }
                    }
                };
                if is_kept {
                    kept.insert(key(e), e as u32);
                }
                error
            })
            .collect();
        self.samples.elements = kept;
        self.samples.measured = Vec::new();
        self.samples.measured_after = self.samples.changes;
        errors
    }

    /// Looks at the direct light inside one element: at its centre, and on the line across it that matters most to errors of
    /// `target` (W/m²). On a minor face where it agrees at the centre, it is taken to be as smooth at the edges.
    fn look_inside(
        &self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        e: usize,
        target: f64,
    ) -> Inside {
        let off = |p: DVec2, weights: [f64; 3]| {
            self.direct_at(light, p) - self.interpolate(mesh, e, weights)[0]
        };
        let centre = off(mesh.centre(e), [1.0 / 3.0; 3]);
        let agrees = centre.0.mean_square() <= (AGREEMENT * target).powi(2);
        let p = mesh.corners(e);
        let strongest = self.open_lines_in(p, target, 1).pop();
        let line = strongest.map(|(_, stretch)| {
            let place = stretch.middle();
            let direct = off(place, barycentric(p, place));
            OnLine { place, direct }
        });
        Inside {
            centre,
            is_smooth: self.size < Size::Major && agrees,
            line,
        }
    }

    /// How far the direct light over one element is off.
    fn direct_misfit(
        &mut self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        e: usize,
        inside: &Inside,
    ) -> Misfit {
        let edges = [0, 1, 2].map(|k| match inside.is_smooth {
            // What equal quadratics along the edges add up to at the centre: 4/9 of each.
            true => inside.centre * 0.75,
            false => self.at_middle(light, mesh, e, k)[0] - self.interpolate(mesh, e, HALVES[k])[0],
        });
        Misfit::new(edges, inside.centre)
    }

    /// How far the indirect light over one element is off.
    fn indirect_misfit(&self, light: &Illumination, mesh: &ReceiverMesh, e: usize) -> Misfit {
        let off = |p: DVec2, weights: [f64; 3]| {
            self.indirect_at(light, p) - self.interpolate(mesh, e, weights)[1]
        };
        let edges = [0, 1, 2].map(|k| off(self.middle(mesh, e, k), HALVES[k]));
        Misfit::new(edges, off(mesh.centre(e), [1.0 / 3.0; 3]))
    }

    /// How far one element is off whose direct light is off by `direct`, and on `line` as told there.
    fn error(
        &self,
        light: &Illumination,
        mesh: &ReceiverMesh,
        e: usize,
        direct: Misfit,
        line: Option<OnLine>,
    ) -> ElementError {
        let square = |line: OnLine| {
            let weights = barycentric(mesh.corners(e), line.place);
            let indirect = self.indirect_at(light, line.place);
            let off = line.direct + indirect - self.interpolate(mesh, e, weights)[1];
            off.0.mean_square()
        };
        ElementError {
            direct,
            indirect: self.indirect_misfit(light, mesh, e),
            line,
            line_square: line.map_or(0.0, square),
            doubt: self.outlook.as_ref().map_or(0.0, |o| o.doubt),
            square: 0.0,
        }
    }
}

/// `look` at all `items`, in order. Many are shared among threads: one face may have more to look at than all the others.
fn all<T: Sync, U: Send>(items: &[T], look: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
    if items.len() < SHARED_LOOKS {
        return items.iter().map(look).collect();
    }
    let shared = items.par_iter().with_min_len(SHARED_LOOKS / 4);
    shared.map(look).collect()
}
