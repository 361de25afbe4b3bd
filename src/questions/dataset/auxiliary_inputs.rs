//! Finds the auxiliary channels (such as temperature) that a fit can use.

use std::sync::Arc;

use crate::{
    features::AuxiliaryChannel,
    recording::{Entry, Role, in_role},
};

#[derive(Clone, Debug, Default)]
pub(crate) struct AuxiliaryInputs {
    pub channels: Vec<AuxiliaryChannel>,
    /// For each auxiliary channel that the fit cannot use, a sentence with the reason.
    pub unused: Vec<String>,
}

impl AuxiliaryInputs {
    /// Finds the auxiliary channels of the recordings that a fit can use, and removes the others from the recordings. A
    /// channel is removed if a recording lacks it, or if it hardly varies in the training recordings. Afterwards all
    /// recordings have the same channels in the same order.
    pub fn prepare(entries: &mut [Entry]) -> Self {
        let mut inputs = Self::default();
        let channels = |entry: &Entry| -> Vec<(String, String)> {
            let table = entry.recording.auxiliary();
            table.names().iter().cloned().zip(table.units().iter().cloned()).collect()
        };
        let mut all = Vec::new();
        for channel in entries.iter().flat_map(channels) {
            if !all.contains(&channel) {
                all.push(channel);
            }
        }
        let mut kept: Vec<String> = Vec::new();
        for channel in all {
            let lacks = entries.iter().find(|entry| !channels(entry).contains(&channel));
            let (name, unit) = channel;
            if let Some(entry) = lacks {
                let of_unit = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
                inputs.unused.push(format!(
                    "the recording {} has no auxiliary channel {name}{of_unit}, so the fit cannot use this channel; record the channel in all recordings, or close this recording",
                    entry.recording.name(),
                ));
                continue;
            }
            match AuxiliaryChannel::measure(&in_role(entries, Role::Train), &name) {
                Ok(channel) => {
                    kept.push(name);
                    inputs.channels.push(channel);
                }
                Err(reason) => inputs.unused.push(reason),
            }
        }
        for entry in entries {
            if entry.recording.auxiliary().names() != kept
                && let Ok(picked) = entry.recording.with_auxiliary_of(&kept)
            {
                entry.recording = Arc::new(picked);
            }
        }
        inputs
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use faer::Mat;
    use faer::linalg::solvers::SolveLstsq as _;

    use crate::calibration::{Calibration, Estimator, FitSettings, Regressor, RidgeChoice, Status};
    use crate::features::{Auxiliary, Blocks, Column, Creep, FeatureSettings, Polynomial};
    use crate::finding::Face;
    use crate::progress::Progress;
    use crate::questions::errors::query::{Analysis, analyse};
    use crate::questions::models::training::train;
    use crate::questions::request::Request;
    use crate::random::Random;
    use crate::recording::{Axis, Entry, Recording, RecordingSet, Role, Source};

    const NOISE: f64 = 0.02;
    const N: usize = 400;

    /// Returns the temperature of recording `at` at sample `k`. The temperature varies by about `moves` degrees between the
    /// recordings.
    fn temperature(at: usize, k: usize, moves: f64) -> f64 {
        let within = (k as f64 / 70.0 + at as f64).sin();
        20.0 + moves * (0.2 * at as f64 + 0.1 * within)
    }

    /// Returns a recording of two gauges with the load `3 s₁ − 2 s₂ + (T − 20) (0.4 + 0.02 s₁)` plus noise: zero and
    /// sensitivity drift with temperature.
    fn recording(at: usize, moves: f64) -> Recording {
        let mut random = Random::new(11, &[at as u64]);
        let (mut gauges, mut loads, mut auxiliary) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..N {
            let [a, b, noise] = [(); 3].map(|()| random.normal());
            let (a, b) = (50.0 + 4.0 * a, 0.5 * b);
            let warm = temperature(at, k, moves);
            gauges.extend([a, b]);
            auxiliary.extend([5.0, warm]);
            loads.push(3.0 * a - 2.0 * b + (warm - 20.0) * (0.4 + 0.02 * a) + NOISE * noise);
        }
        let recording = Recording::new(
            format!("r{at}"),
            Source::Simulated,
            (0..N).map(|k| k as f64 * 0.05).collect(),
            vec!["S1".into(), "S2".into()],
            gauges,
            vec![Axis::Fz],
            loads,
        );
        let (names, units) = (["U", "T"], ["V", "°C"]);
        let [names, units] = [names, units].map(|texts| texts.map(str::to_owned).to_vec());
        recording.unwrap().with_auxiliary(names, units, auxiliary).unwrap()
    }

    fn set(recordings: Vec<Recording>) -> Arc<RecordingSet> {
        let last = recordings.len() - 1;
        let mut set = RecordingSet::default();
        for (at, recording) in recordings.into_iter().enumerate() {
            let role = if at < last { Role::Train } else { Role::Test };
            set.push(Entry::new(recording, role)).unwrap();
        }
        Arc::new(set)
    }

    fn drifting(moves: f64) -> Vec<Recording> {
        [0, 2, 4, 1, 3].map(|at| recording(at, moves)).to_vec()
    }

    fn asked(recordings: &Arc<RecordingSet>, change: impl Fn(&mut FitSettings)) -> Request {
        let mut settings = FitSettings {
            features: FeatureSettings {
                blocks: Blocks::default().with(&Auxiliary, &[0.0]),
                ..FeatureSettings::present()
            },
            ..FitSettings::default()
        };
        change(&mut settings);
        Request::fit(Arc::clone(recordings), settings)
    }

    fn fitted(recordings: &Arc<RecordingSet>, change: impl Fn(&mut FitSettings)) -> Analysis {
        analyse(&asked(recordings, change), &Progress::default()).unwrap()
    }

    fn test_rmse(calibration: &Calibration) -> f64 {
        calibration.quality.compensated.test_rmse.as_ref().unwrap()[0]
    }

    /// The temperature T shifts the load by 0.4 N per degree and scales it by 0.02 per degree. A fit without T therefore errs by up
    /// to 0.02 · 50 N + 0.4 N per degree.
    #[test]
    fn temperature_drift_is_removed_down_to_the_noise() {
        let recordings = set(drifting(30.0));
        let with = fitted(&recordings, |_| {});
        let without = fitted(&recordings, |settings| {
            settings.features.blocks = Blocks::default();
        });
        assert!(test_rmse(&with.calibration) < 1.1 * NOISE);
        assert!(test_rmse(&without.calibration) > 50.0 * NOISE);
        let cv = with.calibration.quality.compensated.cv_rmse.as_ref().unwrap();
        assert!(cv[0] < 1.15 * NOISE, "{cv:?}");
        // The supply voltage U is constant, so the fit does not use it and reports the reason.
        let channels = &with.calibration.features.auxiliary;
        assert_eq!((channels.len(), &*channels[0].name), (1, "T"));
        assert!((channels[0].min - 17.0).abs() < 0.1 && channels[0].max > 40.0);
        let texts: Vec<String> =
            with.findings.iter().map(|finding| finding.text(Face::Page)).collect();
        assert!(texts.iter().any(|text| text.contains("channel U left out")), "{texts:?}");
    }

    /// At 30 °C the load is `(3 + 0.02 · 10) s₁ − 2 s₂ + 0.4 · 10`.
    #[test]
    fn matrix_and_offset_are_those_at_the_reference_that_was_entered() {
        let recordings = set(drifting(30.0));
        let with = |reference: Option<f64>| {
            fitted(&recordings, |settings| {
                let entered = reference.map(|value| ("T".to_owned(), value));
                settings.auxiliary_references = entered.into_iter().collect();
            })
        };
        let (mean, entered) = (with(None), with(Some(30.0)));
        let map = entered.calibration.compensated.as_ref().unwrap();
        let of = |kind: &dyn Fn(&Column) -> bool| {
            let at = map.columns.iter().position(kind).unwrap();
            map.matrix[0][at]
        };
        assert!((of(&|column| *column == Column::Gauge(0)) - 3.2).abs() < 1e-3);
        assert!((of(&|column| *column == Column::Offset) - 4.0).abs() < 0.1);
        let tested = &recordings.entries()[4].recording;
        let [a, b] = [&mean, &entered]
            .map(|analysis| analysis.calibration.apply(tested).unwrap().compensated);
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-7));
        assert!(entered.findings.len() == mean.findings.len());
        let far = with(Some(-20.0));
        let texts: Vec<String> =
            far.findings.iter().map(|finding| finding.text(Face::Page)).collect();
        assert!(
            texts.iter().any(|text| text.contains("T: the reference value is -20 °C")),
            "{texts:?}"
        );
    }

    /// Expected values come from the same least squares by QR on `[s₁, s₂, 1, T, T s₁, T s₂]`.
    #[test]
    fn predictions_are_those_of_a_qr_solution() {
        let recordings = set(drifting(30.0));
        let calibration = fitted(&recordings, |_| {}).calibration;
        let training: Vec<_> =
            recordings.entries()[..4].iter().map(|entry| &entry.recording).collect();
        let row = |recording: &Recording, k: usize| {
            let (s, t) = (recording.gauges_at(k), recording.auxiliary().at(k)[1]);
            [s[0], s[1], 1.0, t, t * s[0], t * s[1]]
        };
        let n = 4 * N;
        let x = Mat::from_fn(n, 6, |i, j| row(training[i / N], i % N)[j]);
        let y = Mat::from_fn(n, 1, |i, _| training[i / N].loads()[i % N]);
        let solution = x.col_piv_qr().solve_lstsq(&y);
        let tested = &recordings.entries()[4].recording;
        let loads = calibration.apply(tested).unwrap().compensated;
        for (k, load) in loads.iter().enumerate() {
            let expected: f64 =
                row(tested, k).iter().enumerate().map(|(j, x)| x * solution[(j, 0)]).sum();
            assert!((load - expected).abs() < 1e-7, "sample {k}: {load} instead of {expected}");
        }
    }

    /// A temperature noise of a few hundredths of a degree must not cause corrections at another temperature.
    #[test]
    fn a_temperature_that_hardly_moved_is_left_out_and_reported() {
        let mut recordings = drifting(0.5);
        recordings[4] = recording(3, 30.0);
        let analysis = fitted(&set(recordings), |_| {});
        let quality = &analysis.calibration.quality;
        assert_eq!(quality.compensated, quality.conventional);
        assert!(analysis.calibration.features.auxiliary.is_empty());
        let texts: Vec<String> =
            analysis.findings.iter().map(|finding| finding.text(Face::Page)).collect();
        let about = texts.iter().find(|text| text.contains("channel T left out")).unwrap();
        assert!(about.contains("at least 1 °C"), "{about}");
    }

    #[test]
    fn a_channel_that_one_recording_lacks_is_reported_and_not_used() {
        let mut recordings = drifting(30.0);
        let bare = &recordings[1];
        let only = ["U".to_owned()];
        recordings[1] = bare.with_auxiliary_of(&only).unwrap();
        let analysis = fitted(&set(recordings), |_| {});
        let texts: Vec<String> =
            analysis.findings.iter().map(|finding| finding.text(Face::Page)).collect();
        assert!(
            texts
                .iter()
                .any(|text| text.contains("the recording r2 has no auxiliary channel T in °C")),
            "{texts:?}"
        );
        assert!(analysis.calibration.features.auxiliary.is_empty());
    }

    #[test]
    fn a_recording_without_the_channel_is_refused_by_name() {
        let recordings = set(drifting(30.0));
        let calibration = fitted(&recordings, |_| {}).calibration;
        let only = ["U".to_owned()];
        let bare = recordings.entries()[4].recording.with_auxiliary_of(&only);
        let error = calibration.apply(&bare.unwrap()).unwrap_err().to_string();
        assert!(
            error.starts_with(
                "r3 has no auxiliary channel T [°C], which the calibration needs (its channels: U [V])"
            ),
            "{error}"
        );
    }

    #[test]
    fn a_file_and_an_estimator_give_the_numbers_of_a_whole_recording() {
        let recordings = set(drifting(30.0));
        for regressor in [Regressor::Linear, Regressor::HybridKernel, Regressor::Network] {
            let request = asked(&recordings, |settings| {
                settings.regressor = regressor;
                settings.network.epochs = 2;
                settings.kernel.landmarks = 20;
                settings.features.blocks = Blocks::default()
                    .with(&Auxiliary, &[0.0, 4.0])
                    .with(&Creep, &[1.0])
                    .with(&Polynomial, &[2.0]);
            });
            let calibration = train(&request, &Progress::default(), &mut |_| {}).unwrap();
            let text = serde_json::to_vec(&calibration.in_file()).unwrap();
            let read = Calibration::from_json(&text).unwrap();
            // A calibration file does not store values that only the fit knows.
            let mut kept = calibration.clone();
            kept.quality.free_coefficients = None;
            assert_eq!(read, kept);
            let names = read.feature_names();
            assert!(names.contains(&"aux1".to_owned()) && names.contains(&"aux1_4s*S2".to_owned()));
            let (first, rest) = recordings.entries()[4].recording.split(0.4).unwrap();
            let design = read.design();
            for part in [&first, &rest] {
                let mut estimator = Estimator::new(&read, &design).unwrap();
                let expected = read.apply(part).unwrap().compensated;
                for (k, expected) in expected.iter().enumerate() {
                    let warm = [part.auxiliary().at(k)[1]];
                    let updated = estimator.update_with(part.times()[k], part.gauges_at(k), &warm);
                    let load = updated.unwrap().1[0];
                    assert!(
                        (load - expected).abs() < 1e-9,
                        "{regressor:?}, sample {k}: {load} {expected}"
                    );
                }
            }
            let mut estimator = Estimator::new(&read, &design).unwrap();
            let (time, gauges) = (1e2, [50.0, 0.0]);
            assert!(estimator.update(time, &gauges).is_err());
            assert!(estimator.update_with(time, &gauges, &[f64::NAN]).is_err());
            let (status, _) = estimator.update_with(time, &gauges, &[90.0]).unwrap();
            assert!(status.has(Status::BEYOND));
        }
    }

    /// Without the drift, creep could only learn noise, which the ridge shrinks away.
    #[test]
    fn an_automatic_ridge_is_chosen_for_the_channels_by_themselves() {
        let recordings = set(drifting(30.0));
        let calibration = fitted(&recordings, |settings| {
            settings.ridge = RidgeChoice::Auto;
            settings.features.blocks.set(&Creep, vec![1.0]);
        })
        .calibration;
        let blocks = &calibration.quality.ridge_by_block;
        let names: Vec<&str> = blocks.iter().map(|ridge| ridge.block.as_str()).collect();
        assert_eq!(names, ["creep 1 s", "auxiliary T, 0 s"]);
        assert!(blocks[1].strengths[0].unwrap() < 1e-3);
        assert!(test_rmse(&calibration) < 1.2 * NOISE);
    }
}
