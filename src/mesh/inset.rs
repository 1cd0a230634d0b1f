//! How far inside an element the values at its borders are taken.

/// One-sided limits are taken this many weld distances inside: beyond what welding and the grid may have moved.
const LEAST_IN_WELD_DISTANCES: f64 = 4.0;

/// At most this share of the way to the middle of the element.
const MOST_SHARE: f64 = 0.25;

/// How far inside an element the value of a point on its border is taken.
#[derive(Clone, Copy, Debug)]
pub struct Inset {
    /// At least so many metres.
    least: f64,
    /// And at least this share of the way to the middle of the element.
    share: f64,
}

impl Inset {
    /// As close to the border as one-sided limits can be told there, for positions welded within `weld_distance` metres.
    pub fn limit(weld_distance: f64) -> Self {
        Self::share(0.0, weld_distance)
    }

    /// At least this `share` of the way to the middle of the element.
    pub fn share(share: f64, weld_distance: f64) -> Self {
        Self {
            least: LEAST_IN_WELD_DISTANCES * weld_distance,
            share,
        }
    }

    /// The step where the middle is so far from the border; all in metres.
    pub(super) fn step(self, distance: f64) -> f64 {
        let step = self.least.max(self.share * distance);
        step.min(MOST_SHARE * distance)
    }

    /// Whether a value that was taken `step` metres inside will do where the middle of an element is `distance` away.
    pub(crate) fn accepts(self, step: f64, distance: f64) -> bool {
        step <= self.least.max(MOST_SHARE * distance)
    }
}
