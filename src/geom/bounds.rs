//! Boxes along the axes.

use glam::DVec3;

/// The smallest box around `points`, from its lowest to its highest corner; without points from +∞ to −∞.
pub(crate) fn bounds(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let around = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
    points.into_iter().fold(nothing, around)
}
