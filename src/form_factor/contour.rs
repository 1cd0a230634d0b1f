//! Two polygons in full view of each other: `A₁ F₁₂ = 1/2π ∮∮ ln r dx₁·dx₂` around both (Sparrow 1963).

use super::edge_pair::{Bounded, integral};
use super::patch::{ROUNDINGS, extent};
use super::{Exchange, Patch};
use std::cmp::Ordering;
use std::f64::consts::TAU;

/// What `first` and `second` exchange when nothing hides them from each other, each counting only as far as it lies in front
/// of the other. The form factor of the smaller one is off by less than `tolerance` as far as round-off allows, and by less
/// than [`Exchange::error`] in any case.
pub fn between(first: &Patch, second: &Patch, tolerance: f64) -> Exchange {
    let areas = [first.area, second.area];
    let permitted = tolerance * areas[0].min(areas[1]);
    // One order for both ways round, so that both are the same to the last bit.
    let found = match order(first, second) {
        Ordering::Greater => exchange(second, first, permitted),
        _ => exchange(first, second, permitted),
    };
    Exchange::new(found.value, found.error, true, areas)
}

/// The smaller patch first, and an arbitrary order of equal ones.
pub(super) fn order(a: &Patch, b: &Patch) -> Ordering {
    let numbers = |p: &Patch| -> Vec<f64> { p.corners.iter().flat_map(|c| c.to_array()).collect() };
    let (x, y) = (numbers(a), numbers(b));
    let both = x.iter().zip(&y).map(|(x, y)| x.total_cmp(y));
    let first = a.area.total_cmp(&b.area).then(x.len().cmp(&y.len()));
    both.fold(first, Ordering::then)
}

/// `A₁ F₁₂`, m².
pub(super) fn exchange(a: &Patch, b: &Patch, permitted: f64) -> Bounded {
    let size = extent(&[a.corners.as_slice(), b.corners.as_slice()].concat());
    let roundoff = ROUNDINGS * size;
    let (Some(a), Some(b)) = (
        a.in_front_of(b.plane, roundoff),
        b.in_front_of(a.plane, roundoff),
    ) else {
        return Bounded::default();
    };
    // Any unit of length will do, as both contours are closed; with this one the logarithms are small.
    let middle = |p: &Patch| p.corners.iter().sum::<glam::DVec3>() / p.corners.len() as f64;
    let distance = middle(&a).distance(middle(&b));
    let unit = if distance > roundoff { distance } else { size };
    let pairs = (a.corners.len() * b.corners.len()) as f64;
    let mut sum = Bounded::default();
    for p in a.edges() {
        for q in b.edges() {
            sum.add(integral(p, q, unit, TAU * permitted / pairs));
        }
    }
    Bounded {
        value: sum.value / TAU,
        error: sum.error / TAU,
    }
}
