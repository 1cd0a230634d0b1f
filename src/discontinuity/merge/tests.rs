//! Lines that are parts of one line are found to be.

use super::*;
use crate::discontinuity::{Cause, EventKind};
use crate::scene::{FaceId, FaceSide};

/// So little across that a direction along the x axis rounds to half a turn or to none.
const TINY: f64 = 1e-17;

/// Nearer ends are one, metres.
const WELD: f64 = 1e-9;

fn line(a: DVec2, b: DVec2) -> (Discontinuity, [DVec2; 2]) {
    let line = Discontinuity {
        face: FaceId(0),
        side: FaceSide::Front,
        ends: [a, b].map(|p| p.extend(0.0)),
        order: DiscontinuityOrder::D1,
        kind: EventKind::Horizon,
        emitter: None,
        cause: Cause::EmitterPlane,
        jump: 1.0,
    };
    (line, [a, b])
}

/// The direction of the second is half a turn once it is rounded, that of the third none.
#[test]
fn a_line_is_found_from_both_its_ends() {
    let others = || [line(DVec2::new(9.0, 9.0), DVec2::new(8.0, 1.0))];
    for (from, to) in [(0.0, TINY), (TINY, 0.0)] {
        let mut lines = vec![line(DVec2::ZERO, DVec2::new(4.0, 0.0))];
        lines.push(line(DVec2::new(3.0, from), DVec2::new(1.0, to)));
        lines.push(line(DVec2::new(1.5, to), DVec2::new(2.5, from)));
        lines.extend(others());
        assert_eq!(merge(lines, WELD).len(), 2, "{from} {to}");
    }
}
