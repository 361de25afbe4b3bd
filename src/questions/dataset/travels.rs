//! Range of readings that a gauge has covered since the start of a recording. Once it is large enough, the state of a play
//! operator (hysteresis element) driven by the gauge is known.

use crate::{features::GaugeScale, min_max::MinMax, questions::dataset::Dataset, recording::Role};

/// Maximum share of a group's samples in which the state of a play operator (hysteresis element) may be unknown.
pub(crate) const MOST_UNKNOWN: f64 = 0.1;

/// Range of readings that each gauge has covered from the start of a recording to each sample.
pub(crate) struct Travels {
    /// One list per group of recordings, with an entry for each recording and gauge: the covered range up to each sample, in
    /// standard deviations σ of the gauge, and the weight of the gauge.
    groups: Vec<Vec<(Vec<f32>, f64)>>,
}

impl Travels {
    /// Measures the range that every gauge has covered up to each sample of the training recordings.
    pub fn of(data: &Dataset, scale: &GaugeScale) -> Self {
        let n_groups = data.groups.of.iter().max().map_or(0, |last| last + 1);
        let mut groups = vec![Vec::new(); n_groups];
        let training = data.entries.iter().zip(&data.groups.of);
        for (entry, group) in training.filter(|(entry, _)| entry.role == Role::Train) {
            let recording = &entry.recording;
            for (gauge, deviation) in scale.deviation.iter().enumerate() {
                let mut range = MinMax::NONE;
                let (mut sum, mut squares) = (0.0, 0.0);
                let travel = (0..recording.n_samples()).map(|k| {
                    let reading = recording.gauges_at(k)[gauge] / deviation.max(f64::MIN_POSITIVE);
                    range = range.with(reading);
                    (sum, squares) = (sum + reading, squares + reading * reading);
                    range.span() as f32
                });
                let travel: Vec<f32> = travel.collect();
                let moved = squares - sum * sum / travel.len().max(1) as f64;
                groups[*group].push((travel, moved.max(0.0)));
            }
        }
        Self { groups }
    }

    /// Returns the share of samples at which a gauge has not yet covered the range `travel` (σ), for the group with the
    /// largest share. Gauges are weighted by the sum of their squared deviations.
    pub fn unknown(&self, travel: f64) -> f64 {
        let of_group = |gauges: &Vec<(Vec<f32>, f64)>| {
            let (mut unknown, mut all) = (0.0, 0.0);
            for (travels, moved) in gauges {
                let before = travels.partition_point(|covered| f64::from(*covered) < travel);
                unknown += moved * before as f64 / travels.len().max(1) as f64;
                all += moved;
            }
            if all > 0.0 { unknown / all } else { 0.0 }
        };
        self.groups.iter().map(of_group).fold(0.0, f64::max)
    }
}
