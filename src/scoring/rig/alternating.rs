//! Finds gauges whose values alternate from sample to sample, for example because the values of two channels are in one
//! column.

use crate::{
    finding::{Finding, Id, Verdict},
    recording::Recording,
    scoring::numbers::percent,
    shown::first_clauses,
};

/// Share of samples that are turning points (greater or smaller than both neighbours) above which a gauge is reported. It is
/// halfway between independent noise (2/3) and strict alternation (1).
const ALTERNATES: f64 = 5.0 / 6.0;
/// Minimum number of samples for which a gauge is examined. For this number, the share of turning points of pure noise
/// (variance 16 / (90 n)) is five standard deviations below [`ALTERNATES`].
const FEWEST_SAMPLES: usize = 160;
const NAMED: usize = 6;

pub(super) fn finding(recordings: &[&Recording]) -> Option<Finding> {
    let alternates = |recording: &&Recording| {
        let n_gauges = recording.gauge_names().len();
        let of = move |gauge: &usize| {
            let values = recording.gauges().iter().skip(*gauge).step_by(n_gauges);
            turning_share(values.copied()).filter(|share| *share > ALTERNATES)
        };
        let gauges = if recording.is_static() { 0 } else { n_gauges };
        (0..gauges).filter_map(|gauge| Some((gauge, of(&gauge)?))).collect::<Vec<_>>()
    };
    let found = recordings.iter().map(|own| (own, alternates(own)));
    let all: Vec<_> = found.filter(|(_, gauges)| !gauges.is_empty()).collect();
    let seen = all.iter().map(|(recording, gauges)| {
        let names = gauges.iter().map(|(gauge, share)| {
            let name = &recording.gauge_names()[*gauge];
            format!("the gauge {name} reverses its direction at {} of the samples", percent(*share))
        });
        format!("{}: {}", recording.name(), first_clauses(NAMED, names.collect::<Vec<_>>()))
    });
    let seen = first_clauses(NAMED, seen.collect::<Vec<_>>());
    (!all.is_empty()).then(|| Finding::new(Id::Alternates, Verdict::Doubtful, seen))
}

/// Returns the share of turning points: samples that are greater or smaller than both neighbours. `None` with too few
/// samples.
fn turning_share(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    let turns = |three: &&[f64]| (three[1] - three[0]) * (three[2] - three[1]) < 0.0;
    let n = values.len();
    (n >= FEWEST_SAMPLES).then(|| values.windows(3).filter(turns).count() as f64 / (n - 2) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn share(value: impl Fn(usize, &mut Random) -> f64) -> f64 {
        let mut random = Random::new(5, &[1]);
        turning_share((0..2000).map(|k| value(k, &mut random))).expect("enough samples")
    }

    #[test]
    fn multiplexed_channels_alternate() {
        let of = |k: usize, random: &mut Random| {
            let load = (0.01 * k as f64).sin();
            let offset = if k.is_multiple_of(2) { 0.0 } else { 10.0 };
            load + offset + 0.1 * random.normal()
        };
        assert!(share(of) > 0.98);
    }

    #[test]
    fn noise_coarse_steps_and_constant_gauges_do_not_alternate() {
        assert!(share(|_, random| random.normal()) < ALTERNATES);
        assert!(share(|_, random| random.normal().signum()) < ALTERNATES, "one digit of a logger");
        assert!(share(|k, _| (0.01 * k as f64).sin()) < 0.1);
        assert!(share(|_, _| 1.0) < ALTERNATES);
        // Differenced noise is the strongest alternation of a filter: 1/2 + asin(2/3) / π of the samples turn.
        let mut last = 0.0;
        let mut random = Random::new(6, &[1]);
        let differences = std::iter::repeat_with(|| {
            let next = random.normal();
            next - std::mem::replace(&mut last, next)
        });
        assert!(turning_share(differences.take(2000)).expect("enough samples") < ALTERNATES);
    }
}
