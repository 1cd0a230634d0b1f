//! The greatest of the numbers that many threads find.

use std::sync::atomic::{AtomicU32, Ordering};

/// The greatest number found so far, 0 at first: the same for any number of threads.
#[derive(Debug, Default)]
pub(super) struct Greatest(AtomicU32);

impl Greatest {
    /// Takes note of `x`, which is not negative.
    pub(super) fn note(&self, x: f64) {
        // The bits of numbers that are not negative are in the order of the numbers.
        let bits = (x as f32).to_bits();
        // Most of what is found is smaller: reading does not take the line of the cache from other threads.
        if bits > self.0.load(Ordering::Relaxed) {
            self.0.fetch_max(bits, Ordering::Relaxed);
        }
    }

    pub(super) fn get(&self) -> f64 {
        f64::from(f32::from_bits(self.0.load(Ordering::Relaxed)))
    }
}

impl Clone for Greatest {
    fn clone(&self) -> Self {
        Self(AtomicU32::new(self.0.load(Ordering::Relaxed)))
    }
}
