//! Rows of a table of load cases that contradict the rest: a figure that was misread, mistyped, or has the wrong sign.
//!
//! A row in which one gauge is off has that gauge misread; one in which most of them are, its load.

use crate::recording::Recording;
use crate::scoring::faults::fault::{Channel, Fault, FaultKind};
use crate::scoring::faults::watched::{Expected, Own};

/// So many standard deviations of what a straight line leaves …
const FAR: f64 = 12.0;
/// … and this share of the channel's range.
const LEAST_SHARE: f64 = 0.08;
/// More of a table than this share is no misreading: the sensor is no straight line there.
const MOST_ROWS: f64 = 0.1;

/// The channel that is off in each row, where the others say one thing of it.
pub(crate) fn misread(recording: &Recording, channels: &[(&Own, Option<&Expected>)]) -> Vec<Fault> {
    let n = recording.n_samples();
    let off = |(own, expected): &(&Own, Option<&Expected>), k: usize| {
        let expected = (*expected)?;
        let off = (own.channel.of(recording, k) - expected.at(recording, k)).abs();
        let least = (FAR * expected.sigma)
            .max(LEAST_SHARE * own.span)
            .max(4.0 * own.resolution.min(own.span));
        (off > least && own.span > 0.0).then_some((own.channel, off / own.span))
    };
    let of_row = |k: usize| {
        let (mut gauges, mut loads) = (Vec::new(), Vec::new());
        for channel in channels {
            match off(channel, k) {
                Some(own @ (Channel::Gauge(_), _)) => gauges.push(own),
                Some(own @ (Channel::Load(_), _)) => loads.push(own),
                Some((Channel::Auxiliary(_), _)) | None => {}
            }
        }
        let suspects = match gauges.len() {
            0 => return None,
            1 => gauges,
            _ => loads,
        };
        let farthest = suspects.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        farthest.map(|(channel, _)| Fault { kind: FaultKind::Spike, channel, samples: k..k + 1 })
    };
    let found: Vec<Fault> = (0..n).filter_map(of_row).collect();
    match found.len() as f64 <= MOST_ROWS * n as f64 {
        true => found,
        false => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use crate::random::Random;
    use crate::recording::{Axis, Recording, Source, ValidRange};
    use crate::scoring::faults::faults_of;

    /// Load cases of three rows each, of a sensor that bends by two per cent; `spoil` may change a row's gauges and loads.
    fn table(spoil: impl Fn(usize, &mut [f64], &mut [f64])) -> Vec<Recording> {
        let mut random = Random::new(5, &[]);
        let mut cases = Vec::new();
        for case in 0..20 {
            let mut loads = [f64::from(case % 5) * 10.0 - 20.0, f64::from(case / 5) * 4.0 - 6.0];
            let (mut all, mut gauges) = (Vec::new(), Vec::new());
            for row in 0..3 {
                let [x, z] = loads;
                let bent = x + 0.001 * x * x;
                let mut own = [(1.0, 0.5), (-0.4, 2.0), (0.7, -1.5)]
                    .map(|(a, b)| a * bent + b * z + 0.01 * random.normal());
                let mut said = loads;
                spoil(3 * case as usize + row, &mut own, &mut said);
                gauges.extend(own);
                all.extend(said);
                loads = [x, z];
            }
            let names = ["S1", "S2", "S3"].map(str::to_owned).to_vec();
            let times = vec![0.0, 1.0, 2.0];
            let axes = vec![Axis::Fx, Axis::Fz];
            let source = Source::File("table.csv".into());
            let name = format!("case {case}");
            let case = Recording::new(name, source, times, names, gauges, axes, all).unwrap();
            cases.push(case.without_times());
        }
        cases
    }

    fn words(cases: &[Recording]) -> Vec<String> {
        let all: Vec<&Recording> = cases.iter().collect();
        let found = faults_of(&all, &ValidRange::default());
        let found = found.iter().zip(&all);
        found
            .flat_map(|(found, case)| {
                let words = found.in_words(case).into_iter();
                words.map(|words| format!("{}: {words}", case.name()))
            })
            .collect()
    }

    #[test]
    fn a_figure_that_was_misread_is_named_and_a_bent_sensor_is_not() {
        assert_eq!(words(&table(|_, _, _| {})), [""; 0]);
        let gauge = table(|row, gauges, _| {
            if row == 31 {
                gauges[1] += 9.0;
            }
        });
        assert_eq!(words(&gauge), ["case 10: 1 spikes (S2)"]);
        let sign = table(|row, _, loads| {
            if row / 3 == 14 {
                loads[0] = -loads[0];
            }
        });
        assert_eq!(words(&sign), ["case 14: 3 spikes (Fx)"]);
        let every = table(|row, gauges, _| gauges[0] += if row % 4 == 0 { 15.0 } else { 0.0 });
        assert_eq!(words(&every), [""; 0], "too many to be slips");
    }
}
