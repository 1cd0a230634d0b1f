//! A hash of integers for maps whose keys are ours, so that nobody chooses them to collide.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Mixes the words of a key.
#[derive(Default)]
pub(super) struct Mixer(u64);

/// 2⁶⁴ over the golden ratio, odd: its multiples spread over all bits.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl Hasher for Mixer {
    /// Slices of integers come as their bytes.
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        for &w in words {
            self.write_u64(u64::from_le_bytes(w));
        }
        for &b in rest {
            self.write_u64(u64::from(b));
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(GOLDEN);
    }

    fn write_i64(&mut self, word: i64) {
        self.write_u64(word as u64);
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }

    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }
}

/// A map by such hashes.
pub(super) type Map<K, V> = HashMap<K, V, BuildHasherDefault<Mixer>>;
