//! Computes one load per sample at run time, as on a robot.
//!
//! Guarantees: unless the clock jumps, the loads equal those of [`Calibration::apply`] on the same samples, except for
//! rounding in a network. The longest time threshold t_th and the longest lag limit the memory. A bad sample is refused and
//! does not affect later samples. If the clock is reset, all states start anew after [`STRAYS`] samples. Exported code
//! behaves the same.

use crate::{
    calibration::{
        calibration::{Calibration, Rows, learned_inputs},
        error::CalibrationError,
        learned::LearnedScratch,
        status::Status,
    },
    features::{Design, FeatureStream, LiveLookBack, STORED_SAMPLES},
    recording::{
        Recording,
        gap::{LEAP_SECS, after_wrap},
    },
};

/// Number of consecutive samples with implausible times after which the clock counts as reset.
pub const STRAYS: u32 = 3;

/// Calibration at run time, with the state of its feature blocks.
#[derive(Debug)]
pub struct Estimator<'a> {
    calibration: &'a Calibration,
    design: &'a Design,
    stream: FeatureStream<'a>,
    /// Errors of the load that the unknown part of each block's states can cause; see [`Calibration::state_effects`].
    effects: Vec<Vec<f64>>,
    fade: Vec<Vec<f64>>,
    look_back: LiveLookBack,
    /// Time of the last accepted sample (s).
    last_secs: Option<f64>,
    /// Time that is added to the time of each sample, because a 32-bit time counter has wrapped to zero (s).
    wrapped_secs: f64,
    /// Time from which samples are remembered (s): that of the first sample, or of the first sample after a pause or clock
    /// reset.
    since_secs: f64,
    strays: u32,
    /// Offset that taring subtracts from each gauge.
    gauge_zero: Vec<f64>,
    /// Offset that the caller has already subtracted from each gauge.
    subtracted_before: Vec<f64>,
    gauges: Vec<f64>,
    raw: Vec<f64>,
    inputs: Vec<f64>,
    scratch: LearnedScratch,
    conventional: Vec<f64>,
    compensated: Vec<f64>,
}

/// Reason why a sample was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the error messages describe the fields")]
pub enum SampleError {
    #[error("the sample has {actual} gauges, but the calibration needs {expected}")]
    Gauges { expected: usize, actual: usize },
    #[error("the sample has {actual} auxiliary channels, but the calibration needs {expected}")]
    Auxiliary { expected: usize, actual: usize },
    #[error("the time, a gauge or an auxiliary channel is not a finite number")]
    NotFinite,
    #[error("the time {time} s is before or too far after that of the last sample, {last_secs} s")]
    OffTheClock { last_secs: f64, time: f64 },
}

impl SampleError {
    /// Returns the status of the refused sample.
    pub const fn status(&self) -> Status {
        match self {
            Self::OffTheClock { .. } => Status::REJECTED_TIME,
            Self::Gauges { .. } | Self::Auxiliary { .. } | Self::NotFinite => {
                Status::REJECTED_VALUE
            }
        }
    }
}

impl<'a> Estimator<'a> {
    /// Creates the estimator. `design` must be [`Calibration::design`] of this calibration. The error is [`CalibrationError`]
    /// if the calibration is not valid.
    pub fn new(calibration: &'a Calibration, design: &'a Design) -> Result<Self, CalibrationError> {
        calibration.validate()?;
        let n_axes = calibration.axes.len();
        Ok(Self {
            calibration,
            design,
            stream: FeatureStream::new(design),
            effects: calibration.state_effects(),
            fade: calibration.fade_of_states(),
            look_back: look_back(calibration),
            last_secs: None,
            wrapped_secs: 0.0,
            since_secs: 0.0,
            strays: 0,
            gauge_zero: vec![0.0; calibration.gauges.len()],
            subtracted_before: vec![0.0; calibration.gauges.len()],
            gauges: vec![0.0; calibration.gauges.len()],
            raw: vec![0.0; design.n_columns()],
            inputs: Vec::new(),
            scratch: LearnedScratch::default(),
            conventional: vec![0.0; n_axes],
            compensated: vec![0.0; n_axes],
        })
    }

    /// Tares with `mean`, the mean gauge readings of the unloaded sensor, and starts anew. On an error nothing changes. The
    /// error is [`SampleError`] unless `mean` is one finite number per gauge.
    pub fn tare(&mut self, mean: &[f64]) -> Result<(), SampleError> {
        self.check_numbers(mean, &[])?;
        let zero = mean.iter().zip(self.calibration.unloaded());
        self.gauge_zero = zero.map(|(mean, unloaded)| mean - unloaded).collect();
        self.reset();
        Ok(())
    }

    /// Forgets all earlier samples, as after switching on, but keeps the tare.
    pub fn reset(&mut self) {
        self.forget();
        self.last_secs = None;
        self.wrapped_secs = 0.0;
    }

    /// Sets the offsets that the caller has already subtracted from the gauges. They are added again to detect clipping.
    pub(crate) fn set_subtracted_before(&mut self, offsets: impl Iterator<Item = f64>) {
        self.subtracted_before.clear();
        self.subtracted_before.extend(offsets);
    }

    /// Processes the next sample and returns its status and compensated load (N, N·m). The time is in s, the gauges are in the
    /// units of the training recordings.
    ///
    /// A time is implausible if it is before the last time, or more than [`LEAP_SECS`] after it, unless a 32-bit time counter
    /// has wrapped to zero. A sample with an implausible time is refused. The [`STRAYS`]th such sample in a row is accepted
    /// as the first sample after a clock reset. A repeated time counts as no elapsed time. A time step above
    /// [`Calibration::gap_secs`] counts as a pause, after which the states start anew that [`Calibration::keep_secs`] does not
    /// keep.
    ///
    /// # Errors
    /// [`SampleError`] if the sample cannot be used. The state then stays as after the last good sample.
    pub fn update(&mut self, time: f64, gauges: &[f64]) -> Result<(Status, &[f64]), SampleError> {
        self.update_with(time, gauges, &[])
    }

    /// Processes a sample like [`Self::update`], with auxiliary channels in the calibration's order and units.
    pub fn update_with(
        &mut self,
        time: f64,
        gauges: &[f64],
        auxiliary: &[f64],
    ) -> Result<(Status, &[f64]), SampleError> {
        let mut status = match self.judge(time, gauges, auxiliary) {
            Ok(status) => status,
            Err(error) => {
                self.conventional.fill(f64::NAN);
                return Err(error);
            }
        };
        let time = time + self.wrapped_secs;
        if status != Status::OK || self.last_secs.is_none() {
            self.since_secs = time;
        }
        self.take(time, gauges, auxiliary);
        if time - self.since_secs < self.calibration.features.window_secs()
            || self.stream.missing(&self.effects) > 1.0
        {
            status |= Status::FILLING;
        }
        let mut limits = self.compensated.iter().zip(&self.calibration.limits);
        if limits.any(|(load, limit)| *limit > 0.0 && load.abs() > *limit)
            || self.has_gauge_beyond(gauges)
            || self.calibration.has_auxiliary_beyond(auxiliary)
        {
            status |= Status::BEYOND;
        }
        Ok((status, &self.compensated))
    }

    /// Processes a sample like [`Self::update_with`], but returns NaN loads for a refused sample. `is_held` is true if an
    /// auxiliary channel has an outdated value.
    pub(crate) fn update_or_nan(
        &mut self,
        time: f64,
        gauges: &[f64],
        auxiliary: &[f64],
        is_held: bool,
    ) -> (Status, Vec<f64>) {
        match self.update_with(time, gauges, auxiliary) {
            Ok((mut status, loads)) => {
                if is_held {
                    status |= Status::AUXILIARY_HELD;
                }
                (status, loads.to_vec())
            }
            Err(error) => (error.status(), vec![f64::NAN; self.conventional.len()]),
        }
    }

    /// Returns true if a gauge is at or beyond its limits (clipped). Limits of a tared calibration are compared with tared
    /// readings, other limits with the readings as measured.
    fn has_gauge_beyond(&self, gauges: &[f64]) -> bool {
        if self.calibration.tare.is_some() {
            return self.calibration.has_gauge_beyond(self.gauges.iter().copied());
        }
        let as_measured = gauges.iter().zip(&self.subtracted_before);
        self.calibration.has_gauge_beyond(as_measured.map(|(gauge, less)| gauge + less))
    }

    fn forget(&mut self) {
        self.strays = 0;
        self.stream = FeatureStream::new(self.design);
        self.look_back = look_back(self.calibration);
    }

    fn check_numbers(&self, gauges: &[f64], auxiliary: &[f64]) -> Result<(), SampleError> {
        let (expected, actual) = (self.calibration.gauges.len(), gauges.len());
        if actual != expected {
            return Err(SampleError::Gauges { expected, actual });
        }
        if gauges.iter().chain(auxiliary).all(|number| number.is_finite()) {
            Ok(())
        } else {
            Err(SampleError::NotFinite)
        }
    }

    /// Checks the numbers and the time of a new sample, and returns its status. After a clock reset, all states are cleared;
    /// after a pause, those that are not kept.
    fn judge(
        &mut self,
        time: f64,
        gauges: &[f64],
        auxiliary: &[f64],
    ) -> Result<Status, SampleError> {
        let (expected, actual) = (self.calibration.features.auxiliary.len(), auxiliary.len());
        if actual != expected {
            return Err(SampleError::Auxiliary { expected, actual });
        }
        self.check_numbers(gauges, auxiliary)?;
        if !time.is_finite() {
            return Err(SampleError::NotFinite);
        }
        let Some(last_secs) = self.last_secs else {
            return Ok(Status::OK);
        };
        let gap_secs = self.calibration.gap_secs;
        let mut step = time + self.wrapped_secs - last_secs;
        if let Some(wrap) = after_wrap(step, gap_secs) {
            self.wrapped_secs += wrap;
            step += wrap;
        }
        if (0.0..=LEAP_SECS).contains(&step) {
            self.strays = 0;
            if step <= gap_secs {
                return Ok(Status::OK);
            }
            let is_kept = |memory| step <= self.calibration.keep_secs_of(memory);
            self.stream
                .resume(time + self.wrapped_secs, |block| block.memory().is_some_and(is_kept));
            if !is_kept(STORED_SAMPLES) {
                self.look_back = look_back(self.calibration);
            }
            return Ok(Status::AFTER_GAP);
        }
        self.strays += 1;
        if self.strays < STRAYS {
            return Err(SampleError::OffTheClock { last_secs, time });
        }
        self.forget();
        self.wrapped_secs = 0.0;
        Ok(Status::RESTARTED)
    }

    fn take(&mut self, time: f64, gauges: &[f64], auxiliary: &[f64]) {
        self.last_secs = Some(time);
        let Calibration { conventional, features, learned, .. } = self.calibration;
        let tared = gauges.iter().zip(&self.gauge_zero);
        self.gauges.clear();
        self.gauges.extend(tared.map(|(gauge, zero)| gauge - zero));
        let gauges = &self.gauges[..];
        conventional.apply(gauges, &mut self.conventional);
        self.look_back.push(time, gauges, &self.conventional);
        let past = |at: usize| self.look_back.past_gauges(features.look_backs[at]);
        self.stream.raw_row(time, gauges, auxiliary, past, &mut self.raw);
        if learned.is_some() {
            self.inputs.clear();
            learned_inputs(self.design, &self.raw, &mut self.inputs);
        }
        let share = (!self.fade.is_empty()).then(|| self.stream.share(&self.fade));
        let rows = Rows { raw: &self.raw, inputs: &self.inputs, shares: share.as_slice() };
        self.calibration.loads_of_rows(rows, &mut self.scratch, &mut self.compensated);
    }

    /// Processes sample `k` of a [prepared](Calibration::prepared) recording like [`Self::update_with`].
    pub(crate) fn update_at(
        &mut self,
        recording: &Recording,
        k: usize,
    ) -> Result<(Status, &[f64]), SampleError> {
        let auxiliary = recording.auxiliary().at(k);
        let auxiliary =
            &auxiliary[..self.calibration.features.auxiliary.len().min(auxiliary.len())];
        self.update_with(recording.times()[k], recording.gauges_at(k), auxiliary)
    }

    /// Returns what the samples so far do not tell of the states, with these factors of each state.
    pub(crate) fn unknown(&self, factors: &[Vec<f64>]) -> f64 {
        self.stream.missing(factors)
    }

    /// Returns the conventional load of the newest sample; NaN if the sample was refused.
    pub fn conventional(&self) -> &[f64] {
        &self.conventional
    }
}

fn look_back(calibration: &Calibration) -> LiveLookBack {
    let look_backs = calibration.features.look_backs.iter();
    let longest_secs = look_backs.map(|look_back| look_back.t_th_secs);
    LiveLookBack::new(
        &calibration.distance_weights(),
        longest_secs.fold(0.0, f64::max),
        calibration.gauges.len(),
        calibration.history_step_secs,
    )
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::kernel::KernelSettings;
    use crate::calibration::network::NetworkSettings;
    use crate::calibration::settings::{FitSettings, Regressor, RidgeChoice};
    use crate::features::{Blocks, FeatureSettings, FixedLag, Polynomial, Thresholds};
    use crate::progress::Progress;
    use crate::questions::{Request, train};
    use crate::recording::{Entry, RecordingSet, Role, simulated};

    fn some_built_in() -> RecordingSet {
        let all = simulated::recordings(7);
        let mut set = RecordingSet::default();
        for entry in all.entries().iter().step_by(25) {
            set.push(Entry {
                recording: Arc::new(entry.recording.decimated(3)),
                role: Role::Train,
                group: None,
            })
            .unwrap();
        }
        set
    }

    fn calibration(features: FeatureSettings, regressor: Regressor) -> Calibration {
        let settings = FitSettings {
            features,
            regressor,
            ridge: RidgeChoice::Auto,
            network: NetworkSettings {
                hidden: vec![8, 8],
                epochs: 2,
                ..NetworkSettings::default()
            },
            kernel: KernelSettings { landmarks: 20, length_scale: Some(1.0) },
            ..FitSettings::default()
        };
        let request = Request::fit(Arc::new(some_built_in()), settings);
        train(&request, &Progress::default(), &mut |_| {}).unwrap()
    }

    fn every_block() -> FeatureSettings {
        FeatureSettings {
            look_backs: [(3.0, 15.0), (8.0, 4.0)]
                .map(|(f_th, t_th_secs)| Thresholds { f_th, t_th_secs })
                .to_vec(),
            blocks: Blocks::every().with(&FixedLag, &[0.5, 2.0]).with(&Polynomial, &[3.0]),
            ..FeatureSettings::present()
        }
    }

    #[track_caller]
    fn assert_runs_as_applied(calibration: &Calibration, recording: &Recording, tolerance: f64) {
        let applied = calibration.apply(recording).unwrap();
        let design = calibration.design();
        let mut estimator = Estimator::new(calibration, &design).unwrap();
        let n_axes = calibration.axes.len();
        for (k, expected) in applied.compensated.chunks_exact(n_axes).enumerate() {
            let (status, load) =
                estimator.update(recording.times()[k], recording.gauges_at(k)).unwrap();
            assert!(!status.has(Status::AFTER_GAP) && !status.has(Status::RESTARTED));
            for ((actual, expected), scale) in
                load.iter().zip(expected).zip(&calibration.full_scale)
            {
                assert!((actual - expected).abs() <= tolerance * scale, "sample {k}");
            }
        }
    }

    #[test]
    fn one_sample_at_a_time_gives_the_numbers_of_the_whole_recording() {
        let recording = Arc::clone(&some_built_in().entries()[2].recording);
        let blocks = every_block();
        let alone = |change: &dyn Fn(&mut FeatureSettings)| {
            let mut settings = FeatureSettings::present();
            change(&mut settings);
            settings
        };
        let mut sets = vec![
            FeatureSettings::present(),
            alone(&|s| s.look_backs.clone_from(&blocks.look_backs)),
            alone(&|s| s.blocks.set(&Polynomial, vec![2.0])),
            blocks.clone(),
        ];
        for (block, values) in blocks.blocks.used() {
            sets.push(alone(&|s| s.blocks.set(block, values.to_vec())));
        }
        for features in sets {
            let calibration = calibration(features, Regressor::Linear);
            assert_runs_as_applied(&calibration, &recording, 0.0);
        }
    }

    #[test]
    fn every_regressor_runs_one_sample_at_a_time() {
        let recording = Arc::clone(&some_built_in().entries()[1].recording);
        for regressor in Regressor::ALL {
            let calibration = calibration(every_block(), regressor);
            assert_eq!(
                calibration.compensated.is_some(),
                regressor == Regressor::Linear || regressor.is_hybrid()
            );
            assert_runs_as_applied(&calibration, &recording, 1e-12);
        }
    }

    #[test]
    fn a_bad_sample_is_refused_and_changes_nothing() {
        let calibration = calibration(every_block(), Regressor::Linear);
        let design = calibration.design();
        let mut estimator = Estimator::new(&calibration, &design).unwrap();
        let mut undisturbed = Estimator::new(&calibration, &design).unwrap();
        let gauges = vec![0.1; 6];
        estimator.update(1.0, &gauges).unwrap();
        undisturbed.update(1.0, &gauges).unwrap();
        assert!(estimator.update(2.0, &gauges[1..]).is_err());
        assert!(estimator.update(f64::NAN, &gauges).is_err());
        assert!(estimator.update(2.0, &[f64::INFINITY; 6]).is_err());
        assert!(estimator.update(0.5, &gauges).is_err());
        assert!(estimator.update(1e9, &gauges).is_err());
        assert!(estimator.conventional().iter().all(|load| load.is_nan()));
        let next = vec![0.2; 6];
        let expected = undisturbed.update(3.0, &next).unwrap();
        assert_eq!(estimator.update(3.0, &next).unwrap(), expected);
        assert_eq!(estimator.conventional(), undisturbed.conventional());
    }

    /// From the third sample of the new clock on, the loads equal those of a new estimator.
    #[test]
    fn a_clock_reset_restarts_the_history() {
        let recording = Arc::clone(&some_built_in().entries()[1].recording);
        let calibration = calibration(every_block(), Regressor::Linear);
        let design = calibration.design();
        for start_secs in [0.0, -5.0, 1.7e9] {
            let mut estimator = Estimator::new(&calibration, &design).unwrap();
            let mut fresh = Estimator::new(&calibration, &design).unwrap();
            for k in 0..100 {
                let time = 1000.0 + recording.times()[k];
                estimator.update(time, recording.gauges_at(k)).unwrap();
            }
            for k in 0..recording.n_samples() {
                let (time, gauges) = (start_secs + recording.times()[k], recording.gauges_at(k));
                let actual = estimator.update(time, gauges);
                if k < 2 {
                    assert!(matches!(actual, Err(SampleError::OffTheClock { .. })));
                    continue;
                }
                let (status, actual) = actual.unwrap();
                assert_eq!(status.has(Status::RESTARTED), k == 2);
                assert_eq!(actual, fresh.update(time, gauges).unwrap().1, "sample {k}");
            }
        }
    }

    /// Bursts of samples with one time stamp give the same loads as `apply`.
    #[test]
    fn a_repeated_time_counts_as_no_elapsed_time() {
        let recording = Arc::clone(&some_built_in().entries()[1].recording);
        let times = recording.times().chunks(4).flat_map(|few| vec![few[0]; few.len()]);
        let stamped = Recording::new(
            "stamped",
            recording.source().clone(),
            times.collect(),
            recording.gauge_names().to_vec(),
            recording.gauges().to_vec(),
            recording.axes().to_vec(),
            recording.loads().to_vec(),
        );
        let calibration = calibration(every_block(), Regressor::Linear);
        assert_runs_as_applied(&calibration, &stamped.unwrap(), 0.0);
    }

    /// After a pause, the compensated load is at least as good as the conventional load, except for its noise.
    #[test]
    fn after_a_pause_the_load_is_no_worse_than_without_history() {
        let all = simulated::recordings(7);
        let entries = all.entries();
        let mut set = RecordingSet::default();
        for entry in entries.iter().step_by(9) {
            set.push(Entry::new((*entry.recording).clone(), Role::Train)).unwrap();
        }
        let set = Arc::new(set);
        let every = Blocks::every();
        let mut sets = vec![("look-back", FeatureSettings::default())];
        for (block, values) in every.used() {
            sets.push((
                block.name(),
                FeatureSettings {
                    blocks: Blocks::default().with(block, values),
                    ..FeatureSettings::present()
                },
            ));
        }
        sets.push(("all", FeatureSettings { blocks: every.clone(), ..FeatureSettings::default() }));
        for (name, features) in sets {
            let settings =
                FitSettings { features, ridge: RidgeChoice::Auto, ..FitSettings::default() };
            let request = Request::fit(Arc::clone(&set), settings);
            let calibration = train(&request, &Progress::default(), &mut |_| {}).unwrap();
            let design = calibration.design();
            for pause_secs in [0.0, 0.15, 1.5, 10.0] {
                let mut squares = [0.0, 0.0];
                let mut n = 0;
                for entry in entries.iter().skip(4).step_by(9) {
                    let recording = &entry.recording;
                    let times = recording.times();
                    for start_secs in [7.0, 13.0, 22.0, 31.0] {
                        let mut estimator = Estimator::new(&calibration, &design).unwrap();
                        let end_secs = start_secs + pause_secs;
                        for k in 0..recording.n_samples() {
                            let time = times[k] - times[0];
                            if time > start_secs && time < end_secs {
                                continue;
                            }
                            let (_, load) =
                                estimator.update(times[k], recording.gauges_at(k)).unwrap();
                            let load = load.to_vec();
                            if time >= end_secs && time < end_secs + 5.0 {
                                n += 1;
                                let reference = &recording.loads()[k * 6..][..6];
                                for axis in 0..6 {
                                    let scale = calibration.full_scale[axis];
                                    squares[0] += ((load[axis] - reference[axis]) / scale).powi(2);
                                    squares[1] += ((estimator.conventional()[axis]
                                        - reference[axis])
                                        / scale)
                                        .powi(2);
                                }
                            }
                        }
                    }
                }
                let rms = squares.map(|s: f64| 100.0 * (s / f64::from(6 * n)).sqrt());
                assert!(rms[0] < rms[1], "{name}, {pause_secs} s: {rms:?} % of full scale");
            }
        }
    }
}
