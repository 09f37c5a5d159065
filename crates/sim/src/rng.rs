//! Random numbers of the world: one seed, the same sequence on every machine and version.

/// Numbers that one [`Rng::noise`] draws.
pub(crate) const NOISE_DRAWS: u64 = 12;

/// SplitMix64 (Steele, Lea, Flood: "Fast splittable pseudorandom number generators", 2014).
///
/// State s += 0x9E3779B97F4A7C15; the output is s mixed by two xor-shift-multiplies. Period 2⁶⁴.
/// Written out here because its sequence is part of the traces and must never change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rng(u64);

impl Rng {
    /// A sequence that depends on the seed alone.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub const fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A whole number in 0 ≤ n < `end`; `end` is not 0.
    pub const fn below(&mut self, end: u64) -> u64 {
        self.bits() % end
    }

    /// Leaves out so many numbers.
    pub const fn skip(&mut self, numbers: u64) {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15_u64.wrapping_mul(numbers));
    }

    /// Uniform in 0 ≤ x < 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Noise of mean 0 and standard deviation 1, never beyond ±3.47: twelve uniform numbers added.
    pub fn noise(&mut self) -> f64 {
        let sum: f64 = (0..NOISE_DRAWS).map(|_| self.unit()).sum();
        (sum - 6.0).clamp(-3.47, 3.47)
    }

    /// True with the given probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }
}

#[cfg(test)]
mod tests {
    use super::Rng;

    /// The reference values of SplitMix64 for the seed 1234567.
    #[test]
    fn reference() {
        let mut rng = Rng::new(1_234_567);
        let expected =
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423_u64];
        assert_eq!([rng.bits(), rng.bits(), rng.bits()], expected);
    }

    #[test]
    fn noise_has_the_moments_it_claims() {
        let mut rng = Rng::new(7);
        let samples: Vec<f64> = (0..20_000).map(|_| rng.noise()).collect();
        let mean = samples.iter().sum::<f64>() / 20_000.0;
        let variance = samples.iter().map(|x| x * x).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.05, "{mean} {variance}");
    }
}
