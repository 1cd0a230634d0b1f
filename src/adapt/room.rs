//! Room for elements, where their number is limited.

use super::{ELEMENTS_A_MARK, Receiver};
use crate::budget::Meter;
use crate::mesh::GridPoint;

/// What makes the mesh of one receiver.
struct Kept {
    points: Vec<GridPoint>,
    lines: Vec<bool>,
    breaks: Vec<f64>,
}

/// How many elements more there may be. A mesh that has grown beyond is taken back, and grows by less.
pub(super) struct Room<'m> {
    meter: &'m Meter,
    /// Elements that may be marked at once.
    most: usize,
    before: Vec<Kept>,
}

impl<'m> Room<'m> {
    pub(super) fn new(meter: &'m Meter) -> Self {
        meter.lacks_elements(false);
        Self {
            meter,
            most: usize::MAX,
            before: Vec::new(),
        }
    }

    /// Whether there is a limit.
    pub(super) fn is_limited(&self) -> bool {
        self.meter.most_elements() != usize::MAX
    }

    /// Elements have been removed.
    pub(super) fn reopen(&mut self) {
        self.most = usize::MAX;
    }

    /// What an error of `rms` comes down to with all the elements that there may be: errors fall as elements grow in number.
    pub(super) fn attainable(&self, receivers: &[Receiver], rms: f64) -> f64 {
        rms * elements(receivers) as f64 / self.meter.most_elements() as f64
    }

    /// How many elements of `receivers` may be marked; none ends the refinement.
    pub(super) fn marks(&mut self, receivers: &[Receiver]) -> usize {
        let most = self.meter.most_elements();
        if most == usize::MAX {
            return most;
        }
        let marks = most.saturating_sub(elements(receivers)) / ELEMENTS_A_MARK;
        self.most = self.most.min(marks);
        self.meter.lacks_elements(self.most == 0);
        self.before = receivers.iter().map(Kept::of).collect();
        self.most
    }

    /// Takes back what the marks have brought when that is too much; returns whether it was.
    pub(super) fn is_exceeded(&mut self, receivers: &mut [Receiver]) -> bool {
        if self.before.is_empty() || elements(receivers) <= self.meter.most_elements() {
            return false;
        }
        self.most /= 2;
        for (r, before) in receivers.iter_mut().zip(self.before.drain(..)) {
            before.restore(r);
        }
        true
    }
}

fn elements(receivers: &[Receiver]) -> usize {
    receivers.iter().map(|r| r.mesh.elements.len()).sum()
}

impl Kept {
    fn of(r: &Receiver) -> Self {
        Self {
            points: r.points.clone(),
            lines: r.kept.clone(),
            breaks: r.breaks.clone(),
        }
    }

    fn restore(self, r: &mut Receiver) {
        r.is_stale |= r.points != self.points || r.kept != self.lines;
        (r.points, r.kept, r.breaks) = (self.points, self.lines, self.breaks);
    }
}
