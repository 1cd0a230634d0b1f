//! The discontinuity lines of a lit scene as records: what was found, and what the meshes hold.

use super::Solution;
use crate::adapt::Receiver;
use crate::discontinuity::{Cause, Discontinuity, DiscontinuityOrder, EventKind};
use crate::scene::{EmitterId, FaceId, FaceSide};
use glam::DVec3;

/// One line on one side of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct LineRecord {
    /// The face that it lies on.
    pub face: FaceId,
    /// The side of the face.
    pub side: FaceSide,
    /// What jumps across it.
    pub order: DiscontinuityOrder,
    /// The kind of critical surface that made it.
    pub kind: EventKind,
    /// Ends, metres, world.
    pub ends: [DVec3; 2],
    /// Break of the irradiance, W/m², mean of the channels: measured for kept candidates, else predicted.
    pub jump: f64,
    /// The emitter, where there is one.
    pub emitter: Option<EmitterId>,
    /// What made it.
    pub cause: Cause,
    /// Whether the mesh holds it.
    pub is_kept: bool,
}

/// How many lines of one order and kind there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct LineCount {
    /// 0, 1 or 2: which derivative of the irradiance jumps.
    pub order: u8,
    /// As in [`kind_name`].
    pub kind: &'static str,
    /// Lines after merging collinear overlaps.
    pub found: usize,
    /// Lines that the display meshes hold.
    pub kept: usize,
}

/// 0, 1 or 2: which derivative of the irradiance jumps.
pub fn order_number(order: DiscontinuityOrder) -> u8 {
    match order {
        DiscontinuityOrder::D0 => 0,
        DiscontinuityOrder::D1 => 1,
        DiscontinuityOrder::D2 => 2,
    }
}

/// The name of a kind in tables.
pub fn kind_name(kind: EventKind) -> &'static str {
    match kind {
        EventKind::Ve => "ve",
        EventKind::Ev => "ev",
        // The plane of a blocker's face is spanned by its own vertices and edges: an NVE wedge of one blocker.
        EventKind::EdgeOn | EventKind::Nve => "nve",
        EventKind::Eee => "eee",
        EventKind::Contact => "contact",
        EventKind::Horizon => "horizon",
    }
}

/// Every line of every lit side: by face and side, contact lines before candidates, as they were found.
pub fn line_records(solution: &Solution) -> Vec<LineRecord> {
    let origin = solution.world.scene.origin;
    solution
        .receivers
        .iter()
        .flat_map(|r| records_of(r, origin))
        .collect()
}

fn records_of(receiver: &Receiver, origin: DVec3) -> Vec<LineRecord> {
    let record = |line: &Discontinuity, measured: Option<f64>, is_kept| LineRecord {
        face: line.face,
        side: line.side,
        order: line.order,
        kind: line.kind,
        ends: line.ends.map(|p| origin + p),
        jump: measured.unwrap_or(line.jump),
        emitter: line.emitter,
        cause: line.cause,
        is_kept,
    };
    let lines = &receiver.lines;
    let mut breaks = vec![None; lines.candidates.len()];
    for (i, measured) in receiver.kept() {
        breaks[i] = Some(measured);
    }
    // Contact lines are in every mesh from the start.
    let contacts = lines.contacts.iter().map(|line| record(line, None, true));
    let candidates = lines.candidates.iter().zip(&breaks);
    contacts
        .chain(candidates.map(|(line, &b)| record(line, b, b.is_some())))
        .collect()
}

/// Counts by order and kind, sorted; only those that occur.
pub(super) fn line_counts(solution: &Solution) -> Vec<LineCount> {
    let mut counts: Vec<LineCount> = Vec::new();
    for line in line_records(solution) {
        let (order, kind) = (order_number(line.order), kind_name(line.kind));
        let kept = usize::from(line.is_kept);
        match counts
            .iter_mut()
            .find(|c| (c.order, c.kind) == (order, kind))
        {
            Some(count) => {
                count.found += 1;
                count.kept += kept;
            }
            None => counts.push(LineCount {
                order,
                kind,
                found: 1,
                kept,
            }),
        }
    }
    counts.sort_unstable_by_key(|c| (c.order, c.kind));
    counts
}
