//! Ages of the earlier samples that a look-back finds with the force threshold F_th and the time threshold t_th.

use std::fmt;

use serde::Serialize;

use crate::scoring::numbers::significant;

/// Upper end of the histogram of ages, as a multiple of the time threshold t_th.
const REACH: usize = 2;

/// Bin of a histogram of the ages of earlier samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AgeBin {
    /// Lower limit of the ages in the bin (s). Only the first bin includes its lower limit.
    pub from_secs: f64,
    /// Upper limit of the ages in the bin, which the bin includes (s).
    pub to_secs: f64,
    pub count: u64,
}

/// Ages of the earlier samples that a look-back finds with one pair of thresholds F_th and t_th.
///
/// Each sample is in one of three classes:
/// * the look-back finds an earlier sample;
/// * the load differed by F_th, but longer ago than t_th;
/// * the load has not yet differed by F_th since the start of the recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PastAges {
    pub n_samples: u64,
    pub n_found: u64,
    /// Number of samples whose earlier sample is older than t_th, so that the look-back does not use it.
    pub n_cut_off: u64,
    /// Histogram of the ages from zero to twice t_th. A border between bins is at t_th. Empty if t_th is zero.
    pub ages: Vec<AgeBin>,
    /// Number of samples whose earlier sample is older than twice t_th, where the histogram ends.
    pub n_beyond: u64,
}

impl PastAges {
    /// Creates a histogram with counts of zero: `bins` bins up to t_th, and as many bins above t_th.
    pub fn new(t_th_secs: f64, bins: usize) -> Self {
        let edge = |at: usize| t_th_secs * at as f64 / bins as f64;
        let n_bins = if t_th_secs > 0.0 { REACH * bins } else { 0 };
        Self {
            ages: (0..n_bins)
                .map(|at| AgeBin { from_secs: edge(at), to_secs: edge(at + 1), count: 0 })
                .collect(),
            ..Self::default()
        }
    }

    /// Adds the samples of one recording to the counts. For each sample, `past` contains the index of the earlier sample that
    /// a look-back without the limit t_th finds. If it finds none, this is the sample's own index.
    pub fn count(&mut self, times: &[f64], past: &[u32], t_th_secs: f64) {
        self.n_samples += times.len() as u64;
        for (k, &past) in past.iter().enumerate() {
            if past as usize == k {
                continue;
            }
            let age = times[k] - times[past as usize];
            if age <= t_th_secs {
                self.n_found += 1;
            } else {
                self.n_cut_off += 1;
            }
            let bin = self.ages.partition_point(|bin| bin.to_secs < age);
            match self.ages.get_mut(bin) {
                Some(bin) => bin.count += 1,
                None => self.n_beyond += 1,
            }
        }
    }

    /// Returns the share of the samples for which the look-back finds an earlier sample; zero without samples.
    pub fn share_found(&self) -> f64 {
        self.share(self.n_found)
    }

    /// Returns the share of the samples whose earlier sample is older than t_th; zero without samples.
    pub fn share_beyond_t_th(&self) -> f64 {
        self.share(self.n_cut_off)
    }

    fn share(&self, count: u64) -> f64 {
        count as f64 / self.n_samples.max(1) as f64
    }

    /// Returns the age that the share `share` of the found earlier samples does not exceed, rounded up to the end of a bin
    /// (s). `None` if no earlier sample is found.
    pub fn age_quantile_secs(&self, share: f64) -> Option<f64> {
        let wanted = share * self.n_found as f64;
        let mut counted = 0;
        let mut bins = self.ages.iter().filter(|_| self.n_found > 0);
        bins.find(|bin| {
            counted += bin.count;
            counted as f64 >= wanted && counted > 0
        })
        .map(|bin| bin.to_secs)
    }
}

impl fmt::Display for PastAges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| significant(100.0 * share, 3);
        write!(
            f,
            "{} % of the training samples find an earlier sample",
            percent(self.share_found())
        )?;
        let ages = [0.5, 0.95].map(|share| self.age_quantile_secs(share));
        if let [Some(half), Some(most)] = ages.map(|age| Some(significant(age?, 3))) {
            write!(f, " (half of these are at most {half} s old, 95 % at most {most} s)")?;
        }
        let beyond = percent(self.share_beyond_t_th());
        write!(f, "; for {beyond} % the earlier sample is older than t_th")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first sample has no earlier sample, and the other samples have earlier samples of age 1, 2, 3 and 7 s. t_th is 2
    /// s, in two bins of one second.
    #[test]
    fn every_sample_is_found_cut_off_or_never_differed() {
        let mut past_ages = PastAges::new(2.0, 2);
        past_ages.count(&[0.0, 1.0, 2.0, 3.0, 7.0], &[0, 0, 0, 0, 0], 2.0);
        assert_eq!((past_ages.n_samples, past_ages.n_found, past_ages.n_cut_off), (5, 2, 2));
        let counts: Vec<u64> = past_ages.ages.iter().map(|bin| bin.count).collect();
        assert_eq!((counts, past_ages.n_beyond), (vec![1, 1, 1, 0], 1));
        assert_eq!((past_ages.share_found(), past_ages.share_beyond_t_th()), (0.4, 0.4));
        assert_eq!(past_ages.age_quantile_secs(0.5), Some(1.0));
        assert_eq!(past_ages.age_quantile_secs(1.0), Some(2.0));
    }

    #[test]
    fn a_time_threshold_of_zero_cuts_all_off() {
        let mut past_ages = PastAges::new(0.0, 4);
        past_ages.count(&[0.0, 1.0], &[0, 0], 0.0);
        assert_eq!((past_ages.n_found, past_ages.n_cut_off, past_ages.n_beyond), (0, 1, 1));
        assert_eq!(past_ages.age_quantile_secs(0.5), None);
        assert_eq!(PastAges::default().share_found(), 0.0);
    }
}
