//! Reproducible random numbers. The same seed and keys always give the same numbers.

use std::f64::consts::TAU;

/// Generator SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Random {
    state: u64,
    spare_normal: Option<f64>,
}

impl Random {
    /// Returns the generator for a seed and a list of keys. Different keys give independent numbers.
    pub(crate) fn new(seed: u64, keys: &[u64]) -> Self {
        let mut stream = Self { state: seed, spare_normal: None };
        for key in keys {
            stream.state = stream.next() ^ key;
        }
        stream
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Returns a uniformly distributed random number in [0, 1).
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Puts the items of a slice in random order (Fisher and Yates 1938, Durstenfeld 1964).
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// Returns a uniformly distributed random integer in `0..bound`: the high half of the product of `bound` and a 64-bit
    /// random number. Its bias is below `bound / 2⁶⁴`.
    fn below(&mut self, bound: usize) -> usize {
        ((u128::from(self.next()) * bound as u128) >> 64) as usize
    }

    /// Returns a random number with standard normal distribution (Box and Muller 1958).
    pub(crate) fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare_normal.take() {
            return spare;
        }
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt(); // 1 − u is never 0
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        self.spare_normal = Some(radius * sin);
        radius * cos
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the published first numbers of SplitMix64 from seed 0.
    #[test]
    fn the_stream_is_splitmix64() {
        let mut random = Random::new(0, &[]);
        assert_eq!(random.next(), 0xE220_A839_7B1D_CDAF);
        assert_eq!(random.next(), 0x6E78_9E6A_A1B9_65F4);
    }

    #[test]
    fn keys_in_another_order_give_another_stream() {
        assert_ne!(Random::new(1, &[2, 3]).next(), Random::new(1, &[3, 2]).next());
        assert_ne!(Random::new(1, &[2]).next(), Random::new(2, &[1]).next());
    }

    /// In 6,000 shuffles of three, each of the six orders is expected 1,000 times with a standard deviation of 29. The
    /// tolerance is five standard deviations.
    #[test]
    fn every_order_is_equally_likely() {
        let mut random = Random::new(3, &[]);
        let mut counts = std::collections::BTreeMap::new();
        for _ in 0..6000 {
            let mut order = [0, 1, 2];
            random.shuffle(&mut order);
            *counts.entry(order).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 6);
        assert!(counts.values().all(|count| (850..=1150).contains(count)));
    }

    /// For 40,000 numbers, the standard errors are 0.005 (mean) and 0.007 (variance). The tolerance is five standard errors.
    #[test]
    fn normals_have_zero_mean_and_unit_variance() {
        let mut random = Random::new(5, &[]);
        let draws: Vec<f64> = (0..40_000).map(|_| random.normal()).collect();
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / draws.len() as f64;
        assert!(mean.abs() < 0.025 && (variance - 1.0).abs() < 0.035);
    }
}
