//! Slopes of curves on paper with two logarithmic scales.

/// The exponent `p` of `y ∝ xᵖ` that fits the points best (least squares of the logarithms); none for fewer than two
/// different places.
pub fn exponent(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> = points
        .iter()
        .filter(|p| p[0] > 0.0 && p[1] > 0.0)
        .map(|p| p.map(f64::ln))
        .collect();
    let n = logs.len() as f64;
    let mean = |k: usize| logs.iter().map(|l| l[k]).sum::<f64>() / n;
    let (x, y) = (mean(0), mean(1));
    let (mut xx, mut xy) = (0.0, 0.0);
    for l in &logs {
        xx += (l[0] - x) * (l[0] - x);
        xy += (l[0] - x) * (l[1] - y);
    }
    (logs.len() > 1 && xx > 0.0).then(|| xy / xx)
}

/// The abscissa at which the curve through `points` passes `y`, along straight lines between logarithms; none where it
/// does not come so far.
pub fn crossing(points: &[[f64; 2]], y: f64) -> Option<f64> {
    points.windows(2).find_map(|w| {
        let [[x0, y0], [x1, y1]] = [w[0], w[1]].map(|p| p.map(f64::ln));
        let t = (y.ln() - y0) / (y1 - y0);
        (0.0..=1.0).contains(&t).then(|| (x0 + (x1 - x0) * t).exp())
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    #[test]
    fn powers_are_found_and_less_than_two_points_have_none() {
        let curve = |p: f64| [1.0, 3.0, 10.0, 50.0].map(|x: f64| [x, 7.0 * x.powf(p)]);
        for p in [-1.5, 0.0, 2.0] {
            assert!((exponent(&curve(p)).unwrap() - p).abs() < 1e-12);
        }
        assert!(exponent(&curve(1.0)[..1]).is_none());
        assert!(exponent(&[[2.0, 1.0], [2.0, 3.0]]).is_none());
        let at = crossing(&curve(-2.0), 7.0 / 25.0).unwrap();
        assert!((at - 5.0).abs() < 1e-12);
        assert!(crossing(&curve(-2.0), 8.0).is_none());
    }
}
