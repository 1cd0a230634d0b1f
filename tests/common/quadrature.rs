//! Gauss-Legendre rules.

use std::f64::consts::PI;

/// Nodes and weights on [0, 1] of the Gauss-Legendre rule with `count` nodes.
pub(crate) fn gauss(count: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut p0, mut p1) = (1.0, x);
        for k in 2..=count {
            let k = k as f64;
            (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
        }
        (p1, count as f64 * (x * p1 - p0) / (x * x - 1.0))
    };
    (0..count)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
            for _ in 0..50 {
                let (p, slope) = legendre(x);
                x -= p / slope;
            }
            let slope = legendre(x).1;
            (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Nodes and weights of the rule with `count` nodes on each piece between `breaks`.
pub(crate) fn gauss_between(breaks: &[f64], count: usize) -> Vec<(f64, f64)> {
    let rule = gauss(count);
    breaks
        .windows(2)
        .flat_map(|w| {
            let length = w[1] - w[0];
            rule.iter()
                .map(move |&(t, weight)| (w[0] + length * t, weight * length))
        })
        .collect()
}
