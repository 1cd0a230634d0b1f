//! The links of all nodes: what each sees of the cells.

use super::cells::{Cell, FaceCells};
use super::gather::Oracle;
use super::nodes::{FaceNodes, inset};
use super::solvers::{Link, Row, check};
use super::{Basis, Gatherer, SolveFace, SolveMesh, Solver, TooManyUnknowns};
use crate::direct::form_factor;
use crate::form_factor::{FLAT, Patch, RADON, between};
use crate::visibility::{Blockers, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// What all rows are made from.
pub(super) struct Rows<'r> {
    pub(super) mesh: &'r SolveMesh,
    pub(super) trees: &'r [FaceCells],
    pub(super) blockers: &'r Blockers,
    pub(super) oracle: &'r Oracle<'r>,
    /// Number of the first cell of each face.
    pub(super) first_cell: &'r [usize],
}

/// An element with one value: a share of the face's triangles.
struct Element<'r> {
    face: &'r SolveFace,
    tree: &'r FaceCells,
    cells: Vec<usize>,
}

/// What one point of an element sees of a cell.
struct Seen {
    cell: u32,
    from: DVec3,
    /// Weight of the point.
    share: f64,
    form_factor: f64,
}

/// Form factors are right to this after cutting behind a few blockers: what agrees so well with that of the whole cell is not
/// cut at all.
const ROW_ROUNDOFF: f64 = 1e-9;

/// Between triangles farther apart than this many times their radii Radon's rule, of degree 5, is right to 10⁻⁶.
const NEAR_RADII: f64 = 6.0;

/// Permitted error of the closed form.
const EXACT: f64 = 1e-12;

impl Rows<'_> {
    /// Nodes at the corners and edge midpoints of the solve mesh, each linked with what is seen from it; those of faces for
    /// which `rays` gives a number by so many rays.
    pub(super) fn of_points(
        &self,
        rays: impl Fn(&SolveFace) -> Option<u32> + Sync,
    ) -> (Vec<FaceNodes>, Vec<Row>) {
        let (nodes, views) = point_nodes(self.mesh, self.blockers);
        // The nodes of a face share one set of rays.
        let owner: Vec<(&SolveFace, u32)> = self
            .mesh
            .faces
            .iter()
            .zip(&nodes)
            .flat_map(|(face, nodes)| (0..nodes.range.len() as u32).map(move |i| (face, i)))
            .collect();
        let rows = views
            .par_iter()
            .zip(&owner)
            .map_init(
                || self.gatherer(),
                |gatherer, (view, (face, i))| {
                    let mut row = Vec::new();
                    let rays = rays(face).map(|n| i * n..(i + 1) * n);
                    let are_by_rays = rays.is_some();
                    self.row(gatherer, view, rays, &mut |link| row.push(link));
                    merge(&mut row);
                    if are_by_rays {
                        Row::means(row)
                    } else if self.oracle.sweep.is_some() {
                        Row::short(row)
                    } else {
                        Row::exact(row)
                    }
                },
            )
            .collect();
        (nodes, rows)
    }

    /// One node for each triangle that the spacing of the solve mesh asks for, or for a face that is no wider than that; each
    /// linked with the mean of what is seen from it: in closed form where all that is near is open, else by Radon's rule.
    pub(super) fn of_elements(
        &self,
        rays: impl Fn(&SolveFace) -> Option<u32> + Sync,
    ) -> (Vec<FaceNodes>, Vec<Row>) {
        let (mut nodes, mut elements) = (Vec::new(), Vec::new());
        for (face, tree) in self.mesh.faces.iter().zip(self.trees) {
            let cells: Vec<usize> = tree.elements().collect();
            let is_one = is_one_element(face, self.mesh);
            let flat = cells.iter().map(|&c| tree.cells[c].flat).collect();
            nodes.push(FaceNodes::of_elements(flat, is_one, elements.len()));
            let parts = if is_one {
                vec![cells]
            } else {
                cells.into_iter().map(|c| vec![c]).collect()
            };
            elements.extend(parts.into_iter().map(|cells| Element { face, tree, cells }));
        }
        let rows = elements
            .par_iter()
            .map_init(
                || self.gatherer(),
                |gatherer, element| {
                    Row::exact(self.element_row(gatherer, element, rays(element.face)))
                },
            )
            .collect();
        (nodes, rows)
    }

    fn gatherer(&self) -> Gatherer<'_> {
        Gatherer::new(self.mesh, self.trees, self.blockers)
    }

    /// Calls `sink` with every link of `view`.
    fn row(
        &self,
        gatherer: &mut Gatherer,
        view: &Viewpoint,
        rays: Option<Range<u32>>,
        sink: &mut impl FnMut(Link),
    ) {
        let mut found = |f: usize, c: usize, weights| {
            let cell = (self.first_cell[f] + c) as u32;
            sink(Link { cell, weights });
        };
        match rays {
            Some(rays) => gatherer.visit_by_rays(view, rays, &mut found),
            None => gatherer.visit(view, self.oracle, &mut found),
        }
    }

    fn element_row(
        &self,
        gatherer: &mut Gatherer,
        element: &Element,
        rays: Option<u32>,
    ) -> Vec<Link> {
        let cells = || element.cells.iter().map(|&c| &element.tree.cells[c]);
        let area: f64 = cells().map(|c| c.area).sum();
        let mut all: Vec<Seen> = Vec::new();
        for cell in cells() {
            for (w, weight) in RADON {
                let view = element.face.view(cell.at(w));
                let share = weight * cell.area / area;
                let rays = rays.map(|n| 0..n);
                self.row(gatherer, &view, rays, &mut |link: Link| {
                    all.push(Seen {
                        cell: link.cell,
                        from: view.position,
                        share,
                        form_factor: link.weights.iter().sum(),
                    });
                });
            }
        }
        // Stable: equal cells stay in the order of the points.
        all.sort_by_key(|l| l.cell);
        let cells: Vec<&[Seen]> = all.chunk_by(|a, b| a.cell == b.cell).collect();
        // All or none: the mistakes of Radon's rule for cells that touch cancel in the sum of the row, which is exact.
        let is_exact = cells
            .iter()
            .all(|same| !self.is_near(element, same) || self.is_open(element, same));
        cells
            .iter()
            .map(|same| {
                let exact = (is_exact && self.is_near(element, same))
                    .then(|| self.exact(element, area, same))
                    .flatten();
                let by_points = || same.iter().map(|s| s.share * s.form_factor).sum();
                let form_factor: f64 = exact.unwrap_or_else(by_points);
                Link {
                    cell: same[0].cell,
                    weights: [form_factor / 3.0; 3],
                }
            })
            .collect()
    }

    /// The cell that was seen.
    fn cell(&self, seen: &[Seen]) -> &Cell {
        let number = seen[0].cell as usize;
        let f = self.first_cell.partition_point(|&first| first <= number) - 1;
        &self.trees[f].cells[number - self.first_cell[f]]
    }

    /// Whether a cell is so near to `element` that Radon's rule may be off by per cents.
    fn is_near(&self, element: &Element, seen: &[Seen]) -> bool {
        let source = self.cell(seen);
        element.cells.iter().any(|&c| {
            let cell = &element.tree.cells[c];
            let reach = NEAR_RADII * (cell.radius + source.radius);
            cell.centre.distance_squared(source.centre) <= reach * reach
        })
    }

    /// Whether nothing hides a cell from any point of `element`.
    fn is_open(&self, element: &Element, seen: &[Seen]) -> bool {
        let source = self.cell(seen);
        let normal = element.face.domain.normal;
        seen.len() == RADON.len() * element.cells.len()
            && seen.iter().all(|s| {
                let known = form_factor(s.from, normal, &source.corners);
                (known - s.form_factor).abs() <= ROW_ROUNDOFF
            })
    }

    /// The mean form factor of a cell in full view, in closed form.
    fn exact(&self, element: &Element, area: f64, seen: &[Seen]) -> Option<f64> {
        let target = Patch::new(&self.cell(seen).corners, FLAT).ok()?;
        let mut sum = 0.0;
        for &c in &element.cells {
            let cell = &element.tree.cells[c];
            let patch = Patch::new(&cell.corners, FLAT).ok()?;
            sum += cell.area * between(&patch, &target, EXACT).from_first().value;
        }
        Some(sum / area)
    }
}

/// Whether the solution on `mesh` is small enough for `solver`; known before any light is.
///
/// # Errors
/// [`TooManyUnknowns`] of the dense solver.
pub fn check_size(
    mesh: &SolveMesh,
    blockers: &Blockers,
    solver: Solver,
    basis: Basis,
) -> Result<(), TooManyUnknowns> {
    if solver != Solver::Lu {
        return Ok(());
    }
    check(match basis {
        Basis::Linear | Basis::Wavelet => point_nodes(mesh, blockers).1.len(),
        Basis::Constant => mesh
            .faces
            .iter()
            .map(|face| match is_one_element(face, mesh) {
                true => 1,
                false => FaceCells::new(face, mesh.spacing, basis).elements().count(),
            })
            .sum(),
    })
}

/// One link for all to the same cell.
fn merge(row: &mut Vec<Link>) {
    // Stable, so that sums do not depend on how it sorts.
    row.sort_by_key(|l| l.cell);
    row.dedup_by(|link, first| {
        let is_same = link.cell == first.cell;
        if is_same {
            for (sum, w) in first.weights.iter_mut().zip(link.weights) {
                *sum += w;
            }
        }
        is_same
    });
}

/// Whether a face is no wider than elements are anyway.
fn is_one_element(face: &SolveFace, mesh: &SolveMesh) -> bool {
    2.0 * face.radius <= mesh.spacing
}

/// Nodes at the corners and edge midpoints of the solve mesh, and the viewpoints there.
pub(super) fn point_nodes(
    mesh: &SolveMesh,
    blockers: &Blockers,
) -> (Vec<FaceNodes>, Vec<Viewpoint>) {
    let mut views: Vec<Viewpoint> = Vec::new();
    let nodes = mesh
        .faces
        .iter()
        .map(|face| FaceNodes::new(face, inset(blockers.weld_distance()), &mut views))
        .collect();
    (nodes, views)
}
