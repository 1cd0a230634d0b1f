//! Sorted disjoint parameter intervals: the part of a wedge's edge along which light still passes.

/// Sorted, disjoint, non-empty intervals within [0, 1].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LitSpans(Vec<(f64, f64)>);

impl LitSpans {
    /// The whole edge.
    pub(super) fn whole() -> Self {
        Self(vec![(0.0, 1.0)])
    }

    /// Nothing is lit any more.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// From the first to the last lit parameter.
    pub(super) fn hull(&self) -> (f64, f64) {
        let first = self.0.first().map_or(0.0, |s| s.0);
        (first, self.0.last().map_or(first, |s| s.1))
    }

    /// True when `s` lies in an interval or at one of its ends.
    pub(super) fn holds(&self, s: f64) -> bool {
        self.0.iter().any(|&(a, b)| a <= s && s <= b)
    }

    /// The intervals in order.
    pub(super) fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.0.iter().copied()
    }

    /// Takes the open interval (`from`, `to`) away.
    pub(super) fn remove(&mut self, from: f64, to: f64) {
        if from >= to {
            return;
        }
        let mut kept = Vec::with_capacity(self.0.len() + 1);
        for &(a, b) in &self.0 {
            if to <= a || from >= b {
                kept.push((a, b));
                continue;
            }
            if a < from {
                kept.push((a, from));
            }
            if to < b {
                kept.push((to, b));
            }
        }
        self.0 = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn removal_splits_trims_and_clears() {
        let mut s = LitSpans::whole();
        s.remove(0.25, 0.5);
        s.remove(-1.0, 0.125);
        s.remove(0.75, 0.75);
        assert_eq!(s.iter().collect::<Vec<_>>(), [(0.125, 0.25), (0.5, 1.0)]);
        s.remove(0.0, 1.0);
        assert!(s.is_empty());
    }
}
