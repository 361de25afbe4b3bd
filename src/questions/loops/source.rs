//! Data of the plots: the recordings of the analysis, with the loads that the calibration computes.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::calibration::{AppliedLoads, Calibration};
use crate::progress::Progress;
use crate::questions::loops::error::LookError;
use crate::questions::loops::output::Span;
use crate::questions::loops::request::LookRequest;
use crate::questions::metrology::{MetrologySettings, Rules, Run};
use crate::recording::{Axis, Recording, RecordingSet, Role};
use crate::report::Trace;
use crate::scoring::MANY_SAMPLES;
use crate::scoring::lag::{InTime, Lag, LagRun, NoLag, WORTH_REMOVING, Widths, lag_of, widths};
use crate::scoring::loops::{LoadExtent, extents_of_set};

/// Part of one recording: its index, and a range of its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    pub(crate) recording: usize,
    pub(crate) samples: Range<usize>,
}

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

/// Recordings of the analysis, with the loads that were computed for the requests so far.
#[derive(Debug)]
pub(crate) struct Source {
    set: Arc<RecordingSet>,
    decimation: usize,
    pub(crate) calibration: Arc<Calibration>,
    pub(crate) recordings: Vec<Arc<Recording>>,
    applied: Vec<Option<AppliedLoads>>,
    /// Noise and range of each axis' load over all samples before decimation, so that the reversal threshold does not depend
    /// on the decimation.
    extents: Vec<LoadExtent>,
    /// Measured time lags, by the axis' position in the calibration and by the output (uncompensated or compensated load).
    lags: HashMap<(usize, Trace), OutputLag>,
}

impl Source {
    /// Makes the plot data for this request. Results in `before` (data of the previous request) that are still valid are
    /// kept. The loads in `before` are dropped first, because two sets of loads may not fit in memory.
    pub(crate) fn of(request: &LookRequest, before: Option<Self>) -> Self {
        let loads = &request.loads;
        let (mut extents, mut lags) = (None, HashMap::new());
        if let Some(before) = before.filter(|own| Arc::ptr_eq(&own.set, &loads.recordings)) {
            let (old, new) = (&before.calibration, &loads.calibration);
            extents = (old.axes == new.axes).then_some(before.extents);
            if before.decimation == loads.decimation && old.conventional == new.conventional {
                lags = before.lags;
                lags.retain(|(_, output), _| *output == Trace::Conventional);
            }
        }
        let recordings: Vec<_> = (loads.recordings.entries().iter())
            .map(|entry| match loads.decimation {
                0 | 1 => Arc::clone(&entry.recording),
                step => Arc::new(entry.recording.decimated(step)),
            })
            .collect();
        Self {
            set: Arc::clone(&loads.recordings),
            decimation: loads.decimation,
            calibration: Arc::clone(&loads.calibration),
            applied: recordings.iter().map(|_| None).collect(),
            recordings,
            extents: extents
                .unwrap_or_else(|| extents_of_set(&loads.recordings, &loads.calibration.axes)),
            lags,
        }
    }

    /// Returns the time lag of an output behind its reference; the first call measures it. The lag is measured on the
    /// training recordings with a reference for every axis. If there is no such training recording, all recordings with a
    /// reference for every axis are used.
    pub(crate) fn lag(
        &mut self,
        column: usize,
        output: Trace,
        reversal_threshold: f64,
        progress: &Progress,
    ) -> Result<OutputLag, LookError> {
        if let Some(known) = self.lags.get(&(column, output)) {
            return Ok(known.clone());
        }
        let usable: Vec<usize> = (0..self.recordings.len())
            .filter(|at| !self.recordings[*at].is_static())
            .filter(|at| self.recordings[*at].axes() == self.calibration.axes)
            .collect();
        let is_training = |at: &usize| self.set.entries()[*at].role == Role::Train;
        let training: Vec<usize> = usable.iter().copied().filter(is_training).collect();
        let chosen = if training.is_empty() { usable } else { training };
        self.apply(chosen.iter().copied(), progress)?;
        let runs: Vec<LagRun<'_>> = (chosen.iter())
            .map(|at| {
                let recording = &self.recordings[*at];
                LagRun {
                    times: recording.times(),
                    gauges: recording.gauges(),
                    loads: recording.loads(),
                    outputs: self.output_rows(*at, output),
                }
            })
            .collect();
        let lag = lag_of(&runs, column);
        progress.check()?;
        let known = lag.as_ref().ok();
        let widths = known.and_then(|lag| widths(lag, column, &runs, reversal_threshold));
        let full_scale = self.calibration.full_scale[column];
        let is_certain = widths.is_none_or(|own| !own.is_uncertain(full_scale));
        let found = OutputLag {
            widths,
            in_time: known.filter(|_| is_certain).map(|lag| InTime::of(lag, column, &runs)),
            lag,
        };
        self.lags.insert((column, output), found.clone());
        Ok(found)
    }

    pub(crate) fn rules<'a>(&'a self, measuring: &'a MetrologySettings) -> Rules<'a> {
        Rules {
            axes: &self.calibration.axes,
            full_scale: &self.calibration.full_scale,
            settings: measuring,
            extents: &self.extents,
        }
    }

    pub(crate) fn holds(&self, request: &LookRequest) -> bool {
        Arc::ptr_eq(&self.set, &request.loads.recordings)
            && Arc::ptr_eq(&self.calibration, &request.loads.calibration)
            && self.decimation == request.loads.decimation
    }

    /// Returns the parts of recordings that `span` selects, and computes their loads.
    pub(crate) fn parts(
        &mut self,
        span: Span,
        request: &LookRequest,
        progress: &Progress,
    ) -> Result<Vec<Part>, LookError> {
        let whole = |recording: usize| Part { recording, samples: 0..usize::MAX };
        let wanted = match span {
            Span::All => (0..self.recordings.len()).map(whole).collect(),
            Span::One(recording) => vec![whole(recording)],
            Span::Of(of) => {
                let entries = self.set.entries().iter().enumerate();
                let chosen = entries.filter(|(_, entry)| of.includes(entry.role));
                chosen.map(|(at, _)| whole(at)).collect()
            }
            Span::Visible => {
                let shown = request.loads.traces.on_screen(request.loads.visible).into_iter();
                let parts = shown.map(|(recording, samples)| Part { recording, samples });
                parts.collect()
            }
        };
        let there = wanted.into_iter().filter_map(|part| {
            let n = self.recordings.get(part.recording)?.n_samples();
            let samples = part.samples.start.min(n)..part.samples.end.min(n);
            (!samples.is_empty()).then_some(Part { samples, ..part })
        });
        let parts: Vec<Part> = there.collect();
        if parts.is_empty() {
            return Err(LookError::NoSamples);
        }
        self.apply(parts.iter().map(|part| part.recording), progress)?;
        Ok(parts)
    }

    pub(crate) fn apply(
        &mut self,
        recordings: impl Iterator<Item = usize>,
        progress: &Progress,
    ) -> Result<(), LookError> {
        let missing: Vec<usize> = recordings.filter(|at| self.applied[*at].is_none()).collect();
        progress.add_total(missing.len() as u64);
        let made = (missing.par_iter())
            .map(|at| {
                progress.check()?;
                let applied = self.calibration.apply(&self.recordings[*at])?;
                progress.advance(1);
                // Plots do not need the indices of the earlier samples that the look-backs found.
                Ok(AppliedLoads { past: Vec::new(), ..applied })
            })
            .collect::<Result<Vec<_>, LookError>>()?;
        for (at, applied) in missing.into_iter().zip(made) {
            self.applied[at] = Some(applied);
        }
        Ok(())
    }

    /// Drops the computed loads if they take too much memory.
    pub(crate) fn forget_many(&mut self) {
        let kept = self.recordings.iter().zip(&self.applied);
        let kept = kept.filter(|(_, applied)| applied.is_some());
        let n_samples: usize = kept.map(|(recording, _)| recording.n_samples()).sum();
        if n_samples > MANY_SAMPLES {
            self.applied.fill_with(|| None);
        }
    }

    fn applied(&self, at: usize) -> &AppliedLoads {
        self.applied[at].as_ref().expect("the loads of a recording are computed before its plot")
    }

    /// Returns the uncompensated or the compensated load (`output`) of a recording on all axes, row-major.
    fn output_rows(&self, at: usize, output: Trace) -> &[f64] {
        match output {
            Trace::Conventional => &self.applied(at).conventional,
            _ => &self.applied(at).compensated,
        }
    }

    pub(crate) fn run(&self, at: usize) -> Run<'_> {
        Run::new(&self.recordings[at], self.applied(at))
    }

    /// Returns the reference load of an axis; `None` if the recording has no reference load for this axis.
    pub(crate) fn loads(&self, part: &Part, axis: Axis) -> Option<Vec<f64>> {
        let recording = &self.recordings[part.recording];
        let at = recording.axes().iter().position(|own| *own == axis)?;
        Some(column(recording.loads(), recording.axes().len(), at, &part.samples))
    }

    /// Returns the reference load of an axis, delayed by the time lag of an output; `None` if the recording has no reference
    /// load.
    pub(crate) fn late_loads(&self, part: &Part, axis: Axis, lag: &InTime) -> Option<Vec<f64>> {
        let whole = Part { samples: 0..usize::MAX, ..part.clone() };
        let loads = self.loads(&whole, axis)?;
        let late = lag.reference(self.recordings[part.recording].times(), &loads);
        Some(late[part.samples.clone()].to_vec())
    }

    /// Returns the values of a gauge channel; `None` if there is no gauge with this index.
    pub(crate) fn gauge(&self, part: &Part, gauge: usize) -> Option<Vec<f64>> {
        let recording = &self.recordings[part.recording];
        let width = recording.n_gauges();
        (gauge < width).then(|| column(recording.gauges(), width, gauge, &part.samples))
    }

    pub(crate) fn output(&self, part: &Part, at: usize, output: Trace) -> Vec<f64> {
        let rows = self.output_rows(part.recording, output);
        column(rows, self.calibration.axes.len(), at, &part.samples)
    }

    /// Returns a load (`output`) after its gains are fitted again to the delayed reference load.
    pub(crate) fn refitted(&self, part: &Part, output: Trace, lag: &InTime) -> Vec<f64> {
        let rows = self.output_rows(part.recording, output);
        let width = self.calibration.axes.len();
        lag.output(&rows[part.samples.start * width..part.samples.end * width])
    }
}

fn column(values: &[f64], width: usize, at: usize, samples: &Range<usize>) -> Vec<f64> {
    let column = values.iter().skip(samples.start * width + at).step_by(width);
    column.take(samples.len()).copied().collect()
}
