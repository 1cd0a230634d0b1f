//! Elements whose links have no say in what they send: those in a gap between two boards that all but touch.
//!
//! Light comes into a gap by its rim and is gone a few times the gap's width from there. The nodes of the solve mesh lie on
//! that very rim, far apart: between them it would shine as brightly all the way through, and go to and fro as often as
//! the boards reflect. Whatever a correction finds out then, its light leaves again only bounce by bounce. So such an
//! element is held: in the solution it swallows what it receives from others. The corrections, whose gathers see what
//! there is, bring its light in from the rim, where it does not have far to go.

use super::SolveFace;
use super::cells::{Cell, FaceCells, FaceLight};
use super::sweep::met;
use crate::geom::even_point_in;
use crate::visibility::Blockers;

/// Rays that look for something close, from as many points of an element.
const RAYS: u32 = 8;

/// What is nearer than this share of the width of an element is close: its nodes do not tell what happens there.
const CLOSE_SHARE: f64 = 1.0 / 16.0;

/// An element looks into a gap when this share of what it sees is close.
const GAP_SHARE: f64 = 0.5;

/// One element.
#[derive(Clone, Copy, Debug)]
struct Element {
    /// Its cell.
    cell: usize,
    is_held: bool,
    /// The square of the last residual, W²/m².
    residual: Option<f64>,
}

/// The elements of one side of one face.
#[derive(Clone, Debug)]
pub(super) struct Held(Vec<Element>);

impl Held {
    /// Those elements of a tree for which `is_held`.
    pub(super) fn new(tree: &FaceCells, is_held: impl Fn(&Cell) -> bool) -> Self {
        let element = |cell| Element {
            cell,
            is_held: is_held(&tree.cells[cell]),
            residual: None,
        };
        Self(tree.elements().map(element).collect())
    }

    /// Holds the elements whose residual has grown since the last one: their links lead away from the solution. Tells
    /// whether there are any.
    pub(super) fn note(&mut self, tree: &FaceCells, residual: &FaceLight) -> bool {
        let mut has_grown = false;
        for element in &mut self.0 {
            let square = residual.square(tree, element.cell);
            let is_larger = element.residual.is_some_and(|last| square > last);
            has_grown |= is_larger && !element.is_held;
            element.is_held |= is_larger;
            element.residual = Some(square);
        }
        has_grown
    }

    /// Forgets the last residuals: the next ones are those of a finer field, which sees what that one did not.
    pub(super) fn forget(&mut self) {
        self.0.iter_mut().for_each(|e| e.residual = None);
    }

    /// For each cell of a tree that has at least these elements, whether it lies in one that is held.
    pub(super) fn cells(&self, tree: &FaceCells) -> Vec<bool> {
        let mut is_held = vec![false; tree.cells.len()];
        for element in &self.0 {
            is_held[element.cell] = element.is_held;
        }
        // Parents come before their children.
        for (i, cell) in tree.cells.iter().enumerate() {
            if let (true, Some(child)) = (is_held[i], cell.first_child()) {
                is_held[child] = true;
                is_held[child + 1] = true;
            }
        }
        is_held
    }

    /// Whether any is.
    pub(super) fn any(&self) -> bool {
        self.0.iter().any(|e| e.is_held)
    }
}

/// Whether a cell of `face` looks into a gap; one of a small face, which looks out all over, does not.
pub(super) fn looks_into_gap(face: &SolveFace, cell: &Cell, blockers: &Blockers) -> bool {
    if face.is_small {
        return false;
    }
    let close = CLOSE_SHARE * cell.area.sqrt();
    let is_close = |i: &u32| {
        let view = face.view(even_point_in(cell.flat, *i));
        met(blockers, &view, *i..*i + 1).any(|(_, _, p)| p.distance(view.position) < close)
    };
    (0..RAYS).filter(is_close).count() as f64 >= GAP_SHARE * f64::from(RAYS)
}
