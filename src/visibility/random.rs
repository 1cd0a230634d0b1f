//! Random numbers for the tests of this module.

use glam::DVec3;

/// Numbers in 0…1 from a seed (splitmix64): enough for tests, no dependency.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point of the cube of half width `reach` around the origin.
    pub(super) fn point(&mut self, reach: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| (self.next() * 2.0 - 1.0) * reach))
    }
}
