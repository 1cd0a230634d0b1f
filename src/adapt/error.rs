//! How far linear interpolation over one element is off.

/// Squared interpolation error over one element, from exact values at its edge midpoints, its centre, and on the
/// candidate lines that cross it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ElementError {
    /// Estimated integral of the squared error over the element, (W/m²)² m².
    pub(super) square: f64,
    /// Mean square of the error at each edge's midpoint, (W/m²)².
    pub(super) edges: [f64; 3],
}

/// Weights of the 7-point rule on a triangle (exact for cubics) at edge midpoints and centre, as shares of the area; the
/// vertices' weight (1/20 each) meets no error.
const MIDPOINT_WEIGHT: f64 = 2.0 / 15.0;
const CENTRE_WEIGHT: f64 = 9.0 / 20.0;

/// Share of the element for which the worst value on a crossing line speaks: a feature that the fixed points miss.
const LINE_WEIGHT: f64 = 0.25;

impl ElementError {
    /// Combines mean squared errors at the midpoints, at the centre and the worst on a crossing line.
    pub(super) fn new(area: f64, edges: [f64; 3], centre: f64, line: f64) -> Self {
        let rule = MIDPOINT_WEIGHT * edges.iter().sum::<f64>() + CENTRE_WEIGHT * centre;
        Self {
            square: area * rule.max(LINE_WEIGHT * line),
            edges,
        }
    }
}
