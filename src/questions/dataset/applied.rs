//! Loads that a calibration computes in recordings, with their time lags. All plots and tables share them.
//!
//! Guarantees: the loads of a recording and the lag of an output are computed once. While one thread computes, others wait, and
//! can be cancelled.

use std::collections::HashMap;
use std::hash::Hash;
use std::ops::{Deref, Range};
use std::sync::{Arc, Mutex, OnceLock, Weak};

use rayon::prelude::*;

use crate::{
    calibration::{AppliedLoads, Calibration, CalibrationError},
    column::column,
    progress::{Cancelled, Progress},
    questions::dataset::waited_for,
    recording::{Axis, Recording, RecordingSet, Role},
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
    pub set: Arc<RecordingSet>,
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

/// Part of one recording: its index, and a range of its samples.
#[derive(Clone, Debug)]
pub struct Part {
    pub recording: usize,
    pub samples: Range<usize>,
}

/// Loads of one calibration, with those that one request uses.
pub(crate) struct Source {
    applied: Arc<Applied>,
    /// Loads of each recording; `None` if the request does not need the recording.
    pub used: Vec<Option<Arc<AppliedLoads>>>,
}

impl Deref for Source {
    type Target = Applied;

    fn deref(&self) -> &Applied {
        &self.applied
    }
}

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
}

impl Source {
    pub fn new(applied: Arc<Applied>) -> Self {
        Self { used: vec![None; applied.recordings.len()], applied }
    }

    /// Adds the loads of these recordings to those that the request uses, and computes those that no request has computed yet.
    pub fn apply<E: From<Cancelled> + From<CalibrationError> + Send>(
        &mut self,
        recordings: impl Iterator<Item = usize>,
        progress: &Progress,
    ) -> Result<(), E> {
        let Self { applied, used } = self;
        let wanted: Vec<usize> = recordings.filter(|at| used[*at].is_none()).collect();
        if wanted.is_empty() {
            progress.check()?;
            return Ok(());
        }
        let mut all = waited_for(&applied.loads, progress)?;
        progress.add_total(wanted.len() as u64);
        let known: Vec<_> = wanted.iter().map(|at| all[*at].used.upgrade()).collect();
        let made = (wanted.par_iter().zip(known))
            .map(|(at, known)| {
                progress.check()?;
                let loads = match known {
                    Some(known) => known,
                    None => {
                        let found = applied.calibration.apply(&applied.recordings[*at])?;
                        // Plots do not need the indices of the earlier samples that the look-backs found.
                        Arc::new(AppliedLoads { past: Vec::new(), ..found })
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

    /// Returns the time lags of outputs behind their reference, measured in these recordings. All
    /// that are not known yet are measured together, because they share the slow part of the model: the states of hysteresis
    /// and creep that follow from the reference.
    pub fn lags(
        &self,
        recordings: &[usize],
        outputs: &[Output],
        progress: &Progress,
    ) -> Result<Vec<Result<Lag, NoLag>>, Cancelled> {
        let recordings = self.timed(recordings.iter().copied());
        let mut known = waited_for(&self.applied.lags, progress)?;
        let key = |output: &Output| (recordings.clone(), *output);
        let missing: Vec<Output> =
            outputs.iter().filter(|output| !known.contains_key(&key(output))).copied().collect();
        if !missing.is_empty() {
            let n_axes = self.calibration.axes.len();
            let rows = |at: &usize| -> Vec<f64> {
                let sources: Vec<(usize, &[f64])> = (missing.iter())
                    .map(|(axis, output)| (*axis, self.rows_of(*at, *output)))
                    .collect();
                let n = self.recordings[*at].n_samples();
                let row = |k| sources.iter().map(move |(axis, rows)| rows[k * n_axes + axis]);
                (0..n).flat_map(row).collect()
            };
            let rows: Vec<Vec<f64>> = recordings.par_iter().map(rows).collect();
            let runs = recordings
                .iter()
                .zip(&rows)
                .map(|(at, rows)| LagRun::of(&self.recordings[*at], rows));
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
        &mut self,
        (column, output): Output,
        reversal_threshold: f64,
        progress: &Progress,
    ) -> Result<OutputLag, E> {
        let applied = Arc::clone(&self.applied);
        let mut known = waited_for(&applied.output_lags, progress)?;
        if let Some(known) = known.get(&(column, output)) {
            return Ok(known.clone());
        }
        let usable = self.timed(0..self.recordings.len());
        let is_training = |at: &usize| self.set.entries()[*at].role == Role::Train;
        let training: Vec<usize> = usable.iter().copied().filter(is_training).collect();
        let chosen = if training.is_empty() { usable } else { training };
        self.apply::<E>(chosen.iter().copied(), progress)?;
        let lag = self.lags(&chosen, &[(column, output)], progress)?.swap_remove(0);
        progress.check()?;
        let runs =
            chosen.iter().map(|at| LagRun::of(&self.recordings[*at], self.rows_of(*at, output)));
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

    /// Returns the uncompensated or the compensated load (`output`) of a recording on all axes, row-major.
    fn rows_of(&self, at: usize, output: Trace) -> &[f64] {
        let loads = self.loads_of(at);
        match output {
            Trace::Conventional => &loads.conventional,
            _ => &loads.compensated,
        }
    }

    pub fn loads_of(&self, at: usize) -> &AppliedLoads {
        self.used[at].as_ref().expect("the loads of a recording are computed before their use")
    }

    /// Returns the reference load of an axis; `None` if the recording has no reference load for this axis.
    pub fn loads(&self, part: &Part, axis: Axis) -> Option<Vec<f64>> {
        let loads = self.recordings[part.recording].load(axis)?;
        Some(loads.skip(part.samples.start).take(part.samples.len()).collect())
    }

    /// Returns the reference load of an axis, delayed by the time lag of an output; `None` if the recording has no reference
    /// load.
    pub fn late_loads(&self, part: &Part, axis: Axis, lag: &InTime) -> Option<Vec<f64>> {
        let whole = Part { samples: 0..usize::MAX, ..part.clone() };
        let loads = self.loads(&whole, axis)?;
        let late = lag.reference(self.recordings[part.recording].times(), &loads);
        Some(late[part.samples.clone()].to_vec())
    }

    /// Returns the values of a gauge channel; `None` if there is no gauge with this index.
    pub fn gauge(&self, part: &Part, gauge: usize) -> Option<Vec<f64>> {
        let recording = &self.recordings[part.recording];
        let width = recording.n_gauges();
        (gauge < width).then(|| part_of(recording.gauges(), width, gauge, &part.samples))
    }

    pub fn output(&self, part: &Part, at: usize, output: Trace) -> Vec<f64> {
        let rows = self.rows_of(part.recording, output);
        part_of(rows, self.calibration.axes.len(), at, &part.samples)
    }

    /// Returns a load (`output`) after its gains are fitted again to the delayed reference load.
    pub fn refitted(&self, part: &Part, output: Trace, lag: &InTime) -> Vec<f64> {
        let rows = self.rows_of(part.recording, output);
        let width = self.calibration.axes.len();
        let rows = &rows[part.samples.start * width..part.samples.end * width];
        (0..part.samples.len()).map(|k| lag.output(rows, k)).collect()
    }
}

fn part_of(rows: &[f64], width: usize, at: usize, samples: &Range<usize>) -> Vec<f64> {
    let rows = &rows[(samples.start * width).min(rows.len())..];
    column(rows, width, at).take(samples.len()).collect()
}

impl Drop for Source {
    fn drop(&mut self) {
        self.forget_many();
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
