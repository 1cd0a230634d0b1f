//! Random numbers, the same on every machine.

/// A permuted congruential generator (O'Neill 2014, XSH RR 64/32): the same points for the same seed on every machine.
pub(super) struct Pcg(u64);

impl Pcg {
    pub(super) fn new(seed: u64) -> Self {
        let mut rng = Self(0);
        rng.next();
        rng.0 = rng.0.wrapping_add(seed);
        rng.next();
        rng
    }

    pub(super) fn next(&mut self) -> u32 {
        let old = self.0;
        self.0 = old
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let shifted = (((old >> 18) ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        f64::from(self.next()) / 4_294_967_296.0
    }
}
