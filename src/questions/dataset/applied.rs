//! Loads that a calibration computes in recordings, with their time lags. All plots and tables share them.
//!
//! Guarantees: the loads of a recording and the lag of an output are computed once. While one thread computes, others wait, and
//! can be cancelled.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, OnceLock, Weak};

use rayon::prelude::*;

use crate::{
    calibration::{AppliedLoads, Calibration, CalibrationError},
    progress::{Cancelled, Progress},
    questions::dataset::waited_for,
    recording::{Recording, RecordingSet, Role},
    report::Trace,
    scoring::{
        MANY_SAMPLES,
        lag::{InTime, Lag, LagEquations, LagRun, NoLag, WORTH_REMOVING, Widths, widths},
        loops::{LoadExtent, extents_of_set},
    },
};

/// Time lag of one output (uncompensated or compensated load) behind its reference load.
#[derive(Clone, Debug)]
pub struct OutputLag {
    /// Measured time lag, or the reason why the lag is unknown.
    pub lag: Result<Lag, NoLag>,
    /// Widths of the loop with and without the lag; `None` if there is no lag or no loop.
    pub widths: Option<Widths>,
    /// Correction that removes the lag; `None` if there is no lag, or if the lag is too uncertain.
    pub(crate) in_time: Option<InTime>,
}

impl OutputLag {
    /// Returns true if the lag is known accurately enough to compute the width of the loop without the lag.
    pub fn is_removable(&self) -> bool {
        self.in_time.is_some()
    }

    /// Returns true if the lag can be removed and explains more than a tenth of the loop's width.
    pub fn is_worth_removing(&self) -> bool {
        self.is_removable()
            && self.lag.as_ref().is_ok_and(Lag::is_significant)
            && self.widths.is_some_and(|widths| widths.explained_share() > WORTH_REMOVING)
    }
}

/// An output of the sensor: the position of its axis in the calibration, and whether it is compensated.
type Output = (usize, Trace);

/// Measured time lags, by the recordings in which they were measured.
type MeasuredLags = HashMap<(Vec<usize>, Output), Result<Lag, NoLag>>;

/// Equations of the lag in some recordings, or the reason why there are none.
type EquationsOf = (Vec<usize>, Result<LagEquations, NoLag>);

/// Loads of one calibration in all recordings, for all requests about them.
#[derive(Debug)]
pub(crate) struct Applied {
    set: Arc<RecordingSet>,
    decimation: usize,
    pub calibration: Arc<Calibration>,
    pub recordings: Vec<Arc<Recording>>,
    loads: Mutex<Vec<Loads>>,
    extents: OnceLock<Vec<LoadExtent>>,
    /// Equations of the newest measurement of a lag. They depend only on the recordings.
    equations: Arc<Mutex<Option<EquationsOf>>>,
    lags: Mutex<MeasuredLags>,
    output_lags: Mutex<HashMap<Output, OutputLag>>,
}

/// Loads of one recording, as long as a request uses them or they are kept for the next one.
#[derive(Debug, Default)]
struct Loads {
    used: Weak<AppliedLoads>,
    kept: Option<Arc<AppliedLoads>>,
}

/// Loads that one request uses, for each recording; `None` if the request does not need the recording.
pub(crate) type UsedLoads = Vec<Option<Arc<AppliedLoads>>>;

impl Applied {
    /// Makes the place of the loads, still without loads. Results in `before` that do not depend on the calibration are kept.
    pub fn new(
        set: &Arc<RecordingSet>,
        decimation: usize,
        calibration: &Arc<Calibration>,
        before: Option<Arc<Self>>,
    ) -> Self {
        let mut made = Self {
            set: Arc::clone(set),
            decimation,
            calibration: Arc::clone(calibration),
            recordings: Vec::new(),
            loads: Mutex::default(),
            extents: OnceLock::new(),
            equations: Arc::default(),
            lags: Mutex::default(),
            output_lags: Mutex::default(),
        };
        let before = before.filter(|before| Arc::ptr_eq(&before.set, set));
        let is_as_before = before.as_ref().is_some_and(|before| before.decimation == decimation);
        if let Some(before) = before {
            if before.calibration.axes == calibration.axes {
                made.extents = before.extents.clone();
            }
            if is_as_before && before.calibration.conventional == calibration.conventional {
                made.lags = uncompensated(&before.lags, |(_, (_, output))| *output);
                made.output_lags = uncompensated(&before.output_lags, |(_, output)| *output);
            }
            if is_as_before {
                made.recordings = before.recordings.clone();
                made.equations = Arc::clone(&before.equations);
            }
        }
        if made.recordings.len() != set.entries().len() {
            let decimated = set.entries().iter().map(|entry| match decimation {
                0 | 1 => Arc::clone(&entry.recording),
                step => Arc::new(entry.recording.decimated(step)),
            });
            made.recordings = decimated.collect();
        }
        made.loads = Mutex::new(made.recordings.iter().map(|_| Loads::default()).collect());
        made
    }

    pub fn is_of(&self, set: &Arc<RecordingSet>) -> bool {
        Arc::ptr_eq(&self.set, set)
    }

    pub fn is(
        &self,
        set: &Arc<RecordingSet>,
        decimation: usize,
        calibration: &Arc<Calibration>,
    ) -> bool {
        self.is_of(set)
            && self.decimation == decimation
            && Arc::ptr_eq(&self.calibration, calibration)
    }

    /// Returns the noise and the range of each axis' load over all samples before decimation, so that the reversal threshold
    /// does not depend on the decimation.
    pub fn extents(&self) -> &[LoadExtent] {
        self.extents.get_or_init(|| extents_of_set(&self.set, &self.calibration.axes))
    }

    /// Adds the loads of these recordings to `used`, and computes those that no request has computed yet.
    pub fn apply<E: From<Cancelled> + From<CalibrationError> + Send>(
        &self,
        recordings: impl Iterator<Item = usize>,
        used: &mut UsedLoads,
        progress: &Progress,
    ) -> Result<(), E> {
        used.resize(self.recordings.len(), None);
        let wanted: Vec<usize> = recordings.filter(|at| used[*at].is_none()).collect();
        if wanted.is_empty() {
            progress.check()?;
            return Ok(());
        }
        let mut all = waited_for(&self.loads, progress)?;
        progress.add_total(wanted.len() as u64);
        let known: Vec<_> = wanted.iter().map(|at| all[*at].used.upgrade()).collect();
        let made = (wanted.par_iter().zip(known))
            .map(|(at, known)| {
                progress.check()?;
                let loads = match known {
                    Some(known) => known,
                    None => {
                        let applied = self.calibration.apply(&self.recordings[*at])?;
                        // Plots do not need the indices of the earlier samples that the look-backs found.
                        Arc::new(AppliedLoads { past: Vec::new(), ..applied })
                    }
                };
                progress.advance(1);
                Ok(loads)
            })
            .collect::<Result<Vec<_>, E>>()?;
        for (at, loads) in wanted.into_iter().zip(made) {
            all[at] = Loads { used: Arc::downgrade(&loads), kept: Some(Arc::clone(&loads)) };
            used[at] = Some(loads);
        }
        Ok(())
    }

    /// Drops the loads that no request uses, if all loads together take too much memory. If another request is computing loads,
    /// that request drops them when it ends.
    pub fn forget_many(&self) {
        let Ok(mut all) = self.loads.try_lock() else { return };
        let kept = self.recordings.iter().zip(&*all).filter(|(_, loads)| loads.kept.is_some());
        if kept.map(|(recording, _)| recording.n_samples()).sum::<usize>() > MANY_SAMPLES {
            all.iter_mut().for_each(|loads| loads.kept = None);
        }
    }

    /// Returns the recordings in which lags are measured: those with times and a reference for every axis.
    fn timed(&self, recordings: impl Iterator<Item = usize>) -> Vec<usize> {
        let is_usable = |at: &usize| {
            let recording = &self.recordings[*at];
            !recording.is_static() && *recording.axes() == self.calibration.axes
        };
        recordings.filter(is_usable).collect()
    }

    fn lag_run<'a>(&'a self, at: usize, outputs: &'a [f64]) -> LagRun<'a> {
        LagRun::of(&self.recordings[at], outputs)
    }

    /// Returns the time lags of outputs behind their reference, measured in these recordings, whose loads are in `used`. All
    /// that are not known yet are measured together, because they share the slow part of the model: the states of hysteresis
    /// and creep that follow from the reference.
    pub fn lags(
        &self,
        recordings: &[usize],
        outputs: &[Output],
        used: &UsedLoads,
        progress: &Progress,
    ) -> Result<Vec<Result<Lag, NoLag>>, Cancelled> {
        let recordings = self.timed(recordings.iter().copied());
        let mut known = waited_for(&self.lags, progress)?;
        let key = |output: &Output| (recordings.clone(), *output);
        let missing: Vec<Output> =
            outputs.iter().filter(|output| !known.contains_key(&key(output))).copied().collect();
        if !missing.is_empty() {
            let n_axes = self.calibration.axes.len();
            let rows = |at: &usize| -> Vec<f64> {
                let sources: Vec<(usize, &[f64])> = (missing.iter())
                    .map(|(axis, output)| (*axis, rows_of(used, *at, *output)))
                    .collect();
                let n = self.recordings[*at].n_samples();
                let row = |k| sources.iter().map(move |(axis, rows)| rows[k * n_axes + axis]);
                (0..n).flat_map(row).collect()
            };
            let rows: Vec<Vec<f64>> = recordings.par_iter().map(rows).collect();
            let runs = recordings.iter().zip(&rows).map(|(at, rows)| self.lag_run(*at, rows));
            let runs: Vec<LagRun<'_>> = runs.collect();
            let mut equations = waited_for(&self.equations, progress)?;
            if equations.as_ref().is_none_or(|(known, _)| *known != recordings) {
                *equations = Some((recordings.clone(), LagEquations::of(&runs)));
            }
            let (_, equations) = equations.as_ref().expect("the equations were prepared above");
            let found = match equations {
                Ok(equations) => equations.lags(&runs, progress)?,
                Err(reason) => vec![Err(*reason); missing.len()],
            };
            known.extend(missing.iter().map(key).zip(found));
        }
        Ok(outputs.iter().map(|output| known[&key(output)].clone()).collect())
    }

    /// Returns the time lag of one output behind its reference, with the loop's width without the lag. It is measured in the
    /// training recordings with a reference for every axis. If there is no such training recording, all recordings with a
    /// reference for every axis are used.
    pub fn output_lag<E: From<Cancelled> + From<CalibrationError> + Send>(
        &self,
        (column, output): Output,
        reversal_threshold: f64,
        used: &mut UsedLoads,
        progress: &Progress,
    ) -> Result<OutputLag, E> {
        let mut known = waited_for(&self.output_lags, progress)?;
        if let Some(known) = known.get(&(column, output)) {
            return Ok(known.clone());
        }
        let usable = self.timed(0..self.recordings.len());
        let is_training = |at: &usize| self.set.entries()[*at].role == Role::Train;
        let training: Vec<usize> = usable.iter().copied().filter(is_training).collect();
        let chosen = if training.is_empty() { usable } else { training };
        self.apply::<E>(chosen.iter().copied(), used, progress)?;
        let lag = self.lags(&chosen, &[(column, output)], used, progress)?.swap_remove(0);
        progress.check()?;
        let runs = chosen.iter().map(|at| self.lag_run(*at, rows_of(used, *at, output)));
        let runs: Vec<LagRun<'_>> = runs.collect();
        let measured = lag.as_ref().ok();
        let widths = measured.and_then(|lag| widths(lag, column, &runs, reversal_threshold));
        let full_scale = self.calibration.full_scale[column];
        let is_certain = widths.is_none_or(|widths| !widths.is_uncertain(full_scale));
        let found = OutputLag {
            widths,
            in_time: measured.filter(|_| is_certain).map(|lag| InTime::of(lag, column, &runs)),
            lag,
        };
        known.insert((column, output), found.clone());
        Ok(found)
    }
}

/// Returns the results about the uncompensated load. Lags that another thread is still measuring are not waited for.
fn uncompensated<K: Clone + Eq + Hash, V: Clone>(
    lags: &Mutex<HashMap<K, V>>,
    output: impl Fn(&K) -> Trace,
) -> Mutex<HashMap<K, V>> {
    let known = lags.try_lock().map_or_else(|_| HashMap::new(), |known| known.clone());
    let known = known.into_iter().filter(|(key, _)| output(key) == Trace::Conventional);
    Mutex::new(known.collect())
}

/// Returns the uncompensated or the compensated load (`output`) of a recording on all axes, row-major.
pub(crate) fn rows_of(used: &UsedLoads, at: usize, output: Trace) -> &[f64] {
    let loads = used[at].as_ref().expect("the loads of a recording are computed before their use");
    match output {
        Trace::Conventional => &loads.conventional,
        _ => &loads.compensated,
    }
}
