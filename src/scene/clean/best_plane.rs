//! The plane of a set of points with a known area vector.

use crate::geom::PlaneFrame;
use glam::DVec3;

/// The frame along `area` through the point that lies nearest to the middle of all points' distances along it.
///
/// A point of the set rather than a mean: the points of an exact plane then have the distance zero exactly.
pub(super) fn best_plane(
    area: DVec3,
    points: impl Iterator<Item = DVec3> + Clone,
) -> Option<PlaneFrame> {
    let normal = area.try_normalize()?;
    let height = |p: DVec3| normal.dot(p);
    let (lo, hi) = points
        .clone()
        .map(height)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), h| {
            (lo.min(h), hi.max(h))
        });
    let off_middle = |p: DVec3| (height(p) - lo.midpoint(hi)).abs();
    let origin = points.min_by(|&p, &q| off_middle(p).total_cmp(&off_middle(q)))?;
    Some(PlaneFrame::new(origin, normal))
}
