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

/// A ray that all but grazes an L-shaped face may round to beyond it, or to beyond the notch.
#[test]
fn a_line_ends_with_its_face() {
    let corners = [(0., 0.), (4., 0.), (4., 1.), (1., 1.), (1., 4.), (0., 4.)];
    let face = Polygon2 {
        loops: vec![corners.map(DVec2::from).to_vec()],
    };
    let part = |a: (f64, f64), b: (f64, f64)| {
        let (d, ends) = line(a.into(), b.into());
        inside(&face, WELD, d, ends).map(|(_, ends)| ends.map(<(f64, f64)>::from))
    };
    assert_eq!(part((0.5, 0.5), (3.0, 0.5)), Some([(0.5, 0.5), (3.0, 0.5)]));
    assert_eq!(part((2.0, 2.0), (3.0, 3.0)), None);
    // From one arm over the notch into the other and out: the longer stretch.
    let [from, to] = part((0.5, 3.0), (5.5, -2.0)).expect("it begins inside");
    let is_near = |p: (f64, f64), q: (f64, f64)| DVec2::from(p).distance(q.into()) < WELD;
    assert!(
        is_near(from, (2.5, 1.0)) && is_near(to, (3.5, 0.0)),
        "{from:?} {to:?}"
    );
    // From the outline on, and off by less than the distance within which points are one.
    let near = part((0.5, -0.5 * WELD), (0.5, 2.0)).expect("it is on the face");
    assert_eq!(near[0], (0.5, -0.5 * WELD));
    let cut = part((0.5, -1.0), (0.5, 2.0)).expect("most of it is on the face");
    assert!(
        is_near(cut[0], (0.5, 0.0)) && cut[1] == (0.5, 2.0),
        "{cut:?}"
    );
}
