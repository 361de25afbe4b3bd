//! Finds faulty samples of gauges and of the reference: saturated, stuck, dropped out, spikes, overload.
//!
//! Each channel has an expected value from other channels: a gauge from the reference loads, a load from the gauges, and a
//! gauge from the other gauges if there is no reference. So a sensor at rest does not count as saturated, and a blow does not
//! count as a spike.
//!
//! **Shapes** sample numbers count from the start of the recording.

mod fault;
mod watched;

use std::ops::Range;

use rayon::prelude::*;

pub use crate::scoring::faults::fault::{Fault, FaultKind};
use crate::{
    recording::{Channel, Judged, LeftOut, Recording, ValidRange},
    scoring::faults::watched::{Expected, Own, Watched, joined, push_runs},
};

/// Maximum share of samples in which an auxiliary channel drops out. A channel that drops out more often counts as a switch.
const DROPOUT_SHARE: f64 = 0.05;

#[derive(Debug, Default, PartialEq)]
pub struct Faults {
    /// All faults that were found, in order of kind, channel and time.
    pub found: Vec<Fault>,
    /// Lower and upper reading at which the logger clips each gauge, before taring; `None` for an unknown limit.
    pub unclipped: Vec<(Option<f64>, Option<f64>)>,
}

impl Faults {
    /// Returns the ranges of samples that cannot be used, in order of time and without overlap.
    pub fn samples(&self) -> Vec<Range<usize>> {
        let mut ranges: Vec<Range<usize>> =
            self.found.iter().map(|fault| fault.samples.clone()).collect();
        ranges.sort_by_key(|range| range.start);
        joined(ranges)
    }

    pub fn n_samples(&self) -> usize {
        self.samples().iter().map(ExactSizeIterator::len).sum()
    }

    /// Returns a text for each kind of fault, with the number of samples and the channels: `30 saturated (S3 S4)`.
    pub fn in_words(&self, recording: &Recording) -> Vec<String> {
        let kinds = self.found.chunk_by(|a, b| a.kind == b.kind);
        let words = kinds.map(|faults| {
            let kind = faults[0].kind;
            let mut channels: Vec<&str> =
                faults.iter().map(|fault| fault.channel.name(recording)).collect();
            channels.dedup();
            let named = match &channels[..] {
                [first, .., last] if channels.len() > 8 => format!("{first} … {last}"),
                all => all.join(" "),
            };
            let own = Self { found: faults.to_vec(), ..Self::default() };
            format!("{} {kind} ({named})", own.n_samples())
        });
        words.collect()
    }

    /// Returns the recording without its unusable samples. It is cut into several recordings where a look-back must not cross
    /// a gap. There is none if no sample remains.
    pub fn left_out_of(&self, recording: &Recording, range: &ValidRange) -> Vec<Recording> {
        let left_out = LeftOut {
            of: recording.name().to_owned(),
            judged: Judged { range: range.clone(), tared: recording.tare() },
            n_samples: self.n_samples(),
            unclipped: self.unclipped.clone(),
        };
        recording.without(&self.samples(), &left_out)
    }
}

/// Returns the faults of each of these recordings. Successive load cases of one table are checked together.
pub fn faults_of(recordings: &[&Recording], range: &ValidRange) -> Vec<Faults> {
    let of_table = |cases: &[&Recording]| {
        if let [recording] = cases {
            return vec![faults(recording, range)];
        }
        let Faults { found, unclipped } = faults(&Recording::table_of(cases), range);
        let mut end = 0;
        let of_case = cases.iter().map(|case| {
            let rows = end..end + case.n_samples();
            end = rows.end;
            let within = |fault: &Fault| {
                let [from, to] = [fault.samples.start, fault.samples.end]
                    .map(|at| at.clamp(rows.start, rows.end) - rows.start);
                (from < to).then(|| Fault { samples: from..to, ..fault.clone() })
            };
            let found = found.iter().filter_map(within).collect();
            Faults { found, unclipped: unclipped.clone() }
        });
        of_case.collect()
    };
    recordings.chunk_by(|a, b| are_of_one_table(a, b)).flat_map(of_table).collect()
}

/// Returns true if both recordings are load cases of one table.
pub(super) fn are_of_one_table(a: &Recording, b: &Recording) -> bool {
    let is_alike = a.axes() == b.axes() && a.n_gauges() == b.n_gauges();
    a.is_load_case() && b.is_load_case() && is_alike && a.source() == b.source()
}

pub fn faults(recording: &Recording, range: &ValidRange) -> Faults {
    let (n_gauges, n_axes) = (recording.n_gauges(), recording.axes().len());
    let channels = (0..n_gauges).map(Channel::Gauge).chain((0..n_axes).map(Channel::Load));
    let channels: Vec<(Channel, Vec<f64>)> =
        channels.map(|channel| (channel, channel.values(recording))).collect();
    let own: Vec<Own> = (channels.par_iter())
        .map(|(channel, values)| Own::of(*channel, values, recording.is_static()))
        .collect();
    let moving: Vec<&Own> = own.iter().filter(|own| own.high > own.low).collect();
    let held = moving.iter().map(|own| own.held).max().unwrap_or(1);
    let is_load = |channel: Channel| matches!(channel, Channel::Load(_));
    let has_loads = moving.iter().any(|own| is_load(own.channel));
    let of_channel = |(own, (channel, values)): (&Own, &(Channel, Vec<f64>))| {
        let mut found: Vec<Fault> = Vec::new();
        if own.high <= own.low {
            return (found, (None, None));
        }
        let by_loads = !is_load(*channel) && has_loads;
        let others = moving.iter().map(|other| other.channel);
        let others = others.filter(|other| is_load(*other) == by_loads && other != channel);
        let expected = Expected::of(recording, own, &others.collect::<Vec<Channel>>());
        let watched = Watched { recording, own, values, expected: expected.as_ref(), held };
        let unclipped = watched.clipped(range.gauges.as_ref(), &mut found);
        watched.stuck(&mut found);
        // Load cases have no order in time, so a jump from one to the next is no fault.
        if !recording.is_static() {
            watched.jumps(&mut found);
        }
        (found, unclipped)
    };
    let watched: Vec<_> = own.par_iter().zip(&channels).map(of_channel).collect();
    let (found, mut unclipped): (Vec<_>, Vec<_>) = watched.into_iter().unzip();
    let mut found = found.concat();
    if !recording.is_static() {
        let auxiliary = (0..recording.auxiliary().len()).map(Channel::Auxiliary);
        found.extend(auxiliary.flat_map(|channel| dropouts(recording, channel)));
    }
    unclipped.truncate(n_gauges);
    for (axis, rated) in range.rated.iter().enumerate().take(n_axes) {
        let Some(most) = rated.map(|rated| range.overload_above(rated)) else { continue };
        let loads = recording.loads()[axis..].iter().step_by(n_axes);
        let is_over = loads.map(|load| load.abs() > most);
        push_runs(is_over, FaultKind::Overload, Channel::Load(axis), &mut found);
    }
    if unclipped.iter().all(|limits| *limits == (None, None)) {
        unclipped.clear();
    }
    // While a gauge is faulty, the load computed from the gauges is wrong.
    let of_gauges = found.iter().filter(|fault| matches!(fault.channel, Channel::Gauge(_)));
    let of_gauges: Vec<Range<usize>> = of_gauges.map(|fault| fault.samples.clone()).collect();
    found.retain(|fault| {
        let Range { start, end } = fault.samples;
        let is_judged = !is_load(fault.channel) || fault.kind != FaultKind::Stuck;
        is_judged || of_gauges.iter().all(|gauge| gauge.end <= start || end <= gauge.start)
    });
    found.sort_by_key(|fault| (fault.kind, fault.channel, fault.samples.start));
    Faults { found, unclipped }
}

/// Finds the dropouts of an auxiliary channel, such as a temperature, which changes slowly and has no expected value.
fn dropouts(recording: &Recording, channel: Channel) -> Vec<Fault> {
    let values = channel.values(recording);
    let own = Own::of(channel, &values, recording.is_static());
    let mut found = Vec::new();
    let watched = Watched { recording, own: &own, values: &values, expected: None, held: own.held };
    watched.jumps(&mut found);
    found.retain(|fault| fault.kind == FaultKind::Dropout);
    let n_away: usize = found.iter().map(|fault| fault.samples.len()).sum();
    if n_away as f64 > DROPOUT_SHARE * recording.n_samples() as f64 {
        found.clear();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::recording::{Axis, GaugeRange, Source, simulated};

    const N: usize = 2000;

    /// Returns gauges and loads: two axes at 100 Hz that move independently, the first with rests, and three gauges with some
    /// hysteresis and noise. With `counts`, the gauges are rounded to steps of this size.
    pub fn sensor(counts: Option<f64>) -> (Vec<f64>, Vec<f64>) {
        let mut random = Random::new(3, &[]);
        let (mut gauges, mut loads) = (Vec::new(), Vec::new());
        let mut play = 0.0_f64;
        for k in 0..N {
            let t = k as f64 / 100.0;
            let x = (20.0 * (0.7 * t).sin()).max(-5.0);
            let y = 3.0 * (1.3 * t + 1.0).sin() + 1.0 * (0.31 * t).cos();
            play = play.clamp(x - 1.0, x + 1.0);
            for (a, b) in [(1.0, 0.5), (-0.4, 2.0), (0.7, -1.5)] {
                let value = a * x + b * y + 0.05 * play + 0.02 * random.normal();
                gauges.push(counts.map_or(value, |counts| (value * counts).round()));
            }
            loads.extend([x, y]);
        }
        (gauges, loads)
    }

    pub fn recording(gauges: Vec<f64>, loads: Vec<f64>) -> Recording {
        let axes = match loads.len() / N {
            0 => Vec::new(),
            _ => vec![Axis::Fx, Axis::Fz],
        };
        let times = (0..N).map(|k| k as f64 / 100.0).collect();
        let names = ["S1", "S2", "S3"].map(str::to_owned).to_vec();
        Recording::new("r", Source::Simulated, times, names, gauges, axes, loads).unwrap()
    }

    pub fn words(recording: &Recording) -> Vec<String> {
        faults(recording, &ValidRange::default()).in_words(recording)
    }

    #[test]
    fn nothing_is_wrong_with_a_sensor_that_rests_turns_or_is_coarse() {
        for counts in [None, Some(1000.0), Some(10.0), Some(1.0)] {
            let (gauges, loads) = sensor(counts);
            for loads in [loads, Vec::new()] {
                let recording = recording(gauges.clone(), loads);
                assert_eq!(words(&recording), Vec::<String>::new(), "{counts:?}");
            }
        }
        for recording in simulated::recordings(simulated::DEFAULT_SEED).entries() {
            assert_eq!(words(&recording.recording), Vec::<String>::new());
        }
    }

    #[test]
    fn a_clipped_gauge_is_found_with_and_without_a_reference() {
        let (mut gauges, loads) = sensor(Some(100.0));
        for row in gauges.chunks_exact_mut(3) {
            row[0] = row[0].min(1500.0);
        }
        let clipped = gauges.iter().step_by(3).filter(|value| **value == 1500.0);
        let expected = format!("{} saturated (S1)", clipped.count());
        for loads in [loads, Vec::new()] {
            let recording = recording(gauges.clone(), loads);
            assert_eq!(words(&recording), [expected.as_str()]);
            let found = faults(&recording, &ValidRange::default());
            assert_eq!(found.unclipped[0], (None, Some(1500.0)));
            let rest = found.left_out_of(&recording, &ValidRange::default());
            assert!(rest.len() > 1, "the load goes on for longer than a gap");
            let left: usize = rest.iter().map(Recording::n_samples).sum();
            assert_eq!(left + found.n_samples(), N);
            assert!(rest.iter().all(|part| part.left_out().is_some()));
        }
    }

    #[test]
    fn limits_that_were_entered_are_those_of_the_logger_whatever_was_tared() {
        let (gauges, loads) = sensor(None);
        let range = ValidRange {
            gauges: Some(GaugeRange::All((-12.0, 12.0))),
            rated: vec![Some(19.0), None],
            overload_tolerance: Some(0.0),
        };
        let recording = recording(gauges.clone(), loads.clone());
        let found = faults(&recording, &range);
        let outside = gauges.chunks_exact(3).zip(loads.chunks_exact(2));
        let outside = outside.filter(|(gauges, loads)| {
            gauges.iter().any(|gauge| gauge.abs() >= 12.0) || loads[0] > 19.0
        });
        assert_eq!(found.n_samples(), outside.count());
        assert!(found.in_words(&recording)[1].contains("overloaded (Fx)"));
        let tared = recording.tared("0:1".parse().unwrap()).unwrap().0;
        assert_eq!(faults(&tared, &range), found);
    }

    #[test]
    fn a_gauge_that_stands_still_over_load_cases_is_told() {
        let table = |change: &dyn Fn(usize, &mut [f64])| {
            let mut random = Random::new(8, &[]);
            let (mut gauges, mut loads) = (Vec::new(), Vec::new());
            for case in 0..24_usize {
                let load = [(case % 5) as f64 - 2.0, (case * 7 % 9) as f64 - 4.0];
                let mut row = [(1.0, 0.5), (-0.4, 2.0), (0.7, -1.5)]
                    .map(|(a, b)| (1e3 * (a * load[0] + b * load[1]) + random.normal()).round());
                change(case, &mut row);
                gauges.extend(row);
                loads.extend(load);
            }
            let recording = Recording::new(
                "cases",
                Source::Simulated,
                (0..24).map(f64::from).collect(),
                ["S1", "S2", "S3"].map(str::to_owned).to_vec(),
                gauges,
                vec![Axis::Fx, Axis::Fz],
                loads,
            );
            words(&recording.unwrap().without_times())
        };
        assert_eq!(table(&|_, _| {}), Vec::<String>::new());
        let stuck = table(&|case, row| {
            if (10..16).contains(&case) {
                row[1] = 512.0;
            }
        });
        assert_eq!(stuck, ["6 stuck (S2)"]);
    }

    #[test]
    fn spikes_dropouts_and_stuck_channels_are_told_from_blows() {
        let (mut gauges, mut loads) = sensor(None);
        gauges[3 * 300] += 15.0; // a spike
        let far = |from: usize| (from..).find(|k| gauges[3 * k + 1].abs() > 4.0).unwrap();
        let (first, second) = (far(500), far(900));
        for k in [first, first + 1, second] {
            gauges[3 * k + 1] = 0.0;
        }
        for k in 1300..1400 {
            gauges[3 * k] = gauges[3 * 1300];
        }
        for k in 1500..1502 {
            // A blow moves all channels, so it is no spike.
            loads[2 * k] += 20.0;
            for (gauge, factor) in [1.0, -0.4, 0.7].into_iter().enumerate() {
                gauges[3 * k + gauge] += 20.0 * factor;
            }
        }
        loads[2 * 1700 + 1] = -999.0; // a value that is missing
        let recording = recording(gauges.clone(), loads.clone());
        assert_eq!(
            words(&recording),
            ["100 stuck (S1)", "3 dropped out (S2)", "2 in spikes (S1 Fz)"]
        );
    }

    #[test]
    fn a_gauge_that_shows_zero_for_long_has_dropped_out() {
        for (from, to) in [(900, 1100), (0, 300), (1800, N)] {
            let (mut gauges, loads) = sensor(None);
            for (k, row) in gauges.chunks_exact_mut(3).enumerate() {
                row.iter_mut().for_each(|gauge| *gauge += 500.0);
                if (from..to).contains(&k) {
                    row[1] = 0.0;
                }
            }
            let found = words(&recording(gauges, loads));
            assert_eq!(found, [format!("{} dropped out (S2)", to - from)]);
        }
    }

    /// The longer the channel is stuck, the fewer samples show what its value should be.
    #[test]
    fn a_channel_stuck_for_most_of_a_recording_is_found() {
        for stuck in [200, 600, 1400, 1800] {
            let (mut gauges, mut loads) = sensor(None);
            for k in 100..100 + stuck {
                gauges[3 * k] = gauges[300];
            }
            let found = words(&recording(gauges, loads.clone()));
            assert_eq!(found, [format!("{stuck} stuck (S1)")]);
            if stuck > 200 {
                // A load that stands still for longer may be held, as on a bench.
                continue;
            }
            let (gauges, _) = sensor(None);
            for k in 100..100 + stuck {
                loads[2 * k] = loads[200];
            }
            let found = words(&recording(gauges, loads));
            assert!(found.iter().any(|own| own.contains("stuck (Fx)")), "{found:?}");
        }
    }

    /// One axis after the other is loaded with dead weights; each gauge responds to both axes.
    #[test]
    fn a_reference_that_stands_between_steps_is_not_stuck() {
        let (mut gauges, mut loads) = (Vec::new(), Vec::new());
        let mut random = Random::new(3, &[]);
        let mut play = 0.0_f64;
        for k in 0..N {
            let step = f64::from([0, 1, 2, 3, 2, 1, 0, 0][k / 50 % 8]);
            let (x, y) = if k < N / 2 { (step, 0.0) } else { (0.0, step) };
            play = play.clamp(x + y - 1.0, x + y + 1.0);
            for (a, b) in [(1.0, 0.2), (0.2, 1.0), (0.3, -0.4)] {
                gauges.push(a * x + b * y + 1.5 * play * a + 1e-4 * random.normal());
            }
            loads.extend([x, y]);
        }
        assert_eq!(words(&recording(gauges, loads)), [""; 0]);
    }

    #[test]
    fn a_thermometer_that_drops_out_is_told_from_one_that_warms_switches_or_is_coarse() {
        let (gauges, loads) = sensor(None);
        let told = |channel: &dyn Fn(usize) -> f64| {
            let values = (0..N).map(channel).collect();
            let recording = recording(gauges.clone(), loads.clone());
            let with = recording.with_auxiliary(vec!["T".into()], vec!["°C".into()], values);
            words(&with.unwrap())
        };
        let mut random = Random::new(6, &[]);
        let noise: Vec<f64> = (0..N).map(|_| 0.02 * random.normal()).collect();
        let warms = |k: usize| 20.0 + 0.01 * k as f64 + noise[k];
        let coarse = |k: usize| (10.0 * warms(k)).round() / 10.0;
        let now_and_then = |k: usize| warms(k / 100 * 100);
        let is_out = |k: usize| [500, 1200, 1700].iter().any(|from| (*from..from + 7).contains(&k));
        for channel in [&warms as &dyn Fn(usize) -> f64, &coarse, &now_and_then, &|_| 21.5] {
            assert_eq!(told(channel), [""; 0]);
            for value in [0.0, -40.0] {
                let with_outs = |k: usize| if is_out(k) { value } else { channel(k) };
                // A channel that is constant except for these jumps may be a switch.
                if value == 0.0 || channel(0) != channel(N - 1) {
                    assert_eq!(told(&with_outs), ["21 dropped out (T)"], "{value}");
                }
            }
        }
        let switch = |k: usize| f64::from((k / 30).is_multiple_of(4));
        assert_eq!(told(&switch), [""; 0]);
        let pulses = |k: usize| if is_out(k) { 1.0 } else { 0.0 };
        assert_eq!(told(&pulses), [""; 0]);
    }

    #[test]
    fn load_cases_of_a_table_are_judged_together() {
        let (gauges, loads) = sensor(Some(100.0));
        let cases: Vec<Recording> = (0..60)
            .map(|case| {
                let k = 31 * case;
                let mut gauges = gauges[3 * k..3 * k + 3].to_vec();
                gauges[0] = gauges[0].min(1200.0);
                let axes = vec![Axis::Fx, Axis::Fz];
                let names = ["S1", "S2", "S3"].map(str::to_owned).to_vec();
                let loads = loads[2 * k..2 * k + 2].to_vec();
                let own =
                    Recording::new("c", Source::Simulated, vec![0.0], names, gauges, axes, loads);
                own.unwrap().without_times()
            })
            .collect();
        let all: Vec<&Recording> = cases.iter().collect();
        let found = faults_of(&all, &ValidRange::default());
        let clipped = |at: &usize| cases[*at].gauges()[0] == 1200.0;
        let expected: Vec<usize> = (0..60).filter(clipped).collect();
        assert!(expected.len() > 5, "{expected:?}");
        let actual: Vec<usize> = (0..60).filter(|at| found[*at].n_samples() > 0).collect();
        assert_eq!(actual, expected);
        let left = found[expected[0]].left_out_of(&cases[expected[0]], &ValidRange::default());
        assert!(left.is_empty(), "nothing is left of that case");
    }

    /// A reference at rest flickers by one step of its converter, once. Its gauges show noise.
    #[test]
    fn a_single_flicker_of_the_converter_is_no_spike() {
        for steps in [1.0, -3.0] {
            let (mut gauges, _) = sensor(None);
            let mut random = Random::new(5, &[]);
            gauges.iter_mut().for_each(|gauge| *gauge = 3.4 + 0.001 * random.normal());
            let mut loads = [2.9, 3.1].repeat(N);
            loads[2 * 700 + 1] += 0.0102 * steps;
            assert_eq!(words(&recording(gauges.clone(), loads.clone())), [""; 0]);
            loads[2 * 700 + 1] = 0.0;
            assert_eq!(words(&recording(gauges, loads)), ["1 dropped out (Fz)"]);
        }
    }

    #[test]
    fn next_to_nothing_says_nothing() {
        let one = |values: Vec<f64>| {
            let times = (0..values.len()).map(|k| k as f64).collect();
            let loads = values.iter().map(|value| 2.0 * value).collect();
            let names = vec!["S1".to_owned()];
            let recording =
                Recording::new("r", Source::Simulated, times, names, values, vec![Axis::Fz], loads);
            words(&recording.unwrap())
        };
        assert_eq!(one(vec![1.0]), Vec::<String>::new());
        assert_eq!(one(vec![1.0; 50]), Vec::<String>::new());
        assert_eq!(one(vec![1.0, 2.0, 2.0, 2.0]), Vec::<String>::new());
        let steps = (0..60).map(|k| f64::from(k / 20)).collect();
        assert_eq!(one(steps), Vec::<String>::new());
    }
}
