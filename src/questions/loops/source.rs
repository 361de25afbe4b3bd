//! Data of the plots: the recordings of the analysis, with the loads that the calibration computes.

use std::ops::Range;
use std::sync::Arc;

use crate::{
    calibration::Calibration,
    column::column,
    progress::{Cancelled, Progress},
    questions::{
        dataset::applied::{Applied, OutputLag, UsedLoads, rows_of},
        errors::intervals::OnScreen,
        loops::request::{LookError, LookRequest, Span},
        metrology::{Lags, MetrologySettings, Rules, Run},
    },
    recording::{Axis, Recording, RecordingSet},
    report::Trace,
    scoring::lag::InTime,
};

/// Part of one recording: its index, and a range of its samples.
#[derive(Clone, Debug)]
pub struct Part {
    pub recording: usize,
    pub samples: Range<usize>,
}

/// Recordings of the analysis, with the loads that one request uses.
pub struct Source {
    set: Arc<RecordingSet>,
    applied: Arc<Applied>,
    used: UsedLoads,
}

impl Source {
    pub(crate) fn of(loads: &OnScreen) -> Self {
        let OnScreen { recordings, decimation, calibration, datasets, .. } = loads;
        let applied = datasets.applied(recordings, *decimation, calibration);
        Self { set: Arc::clone(recordings), applied, used: UsedLoads::new() }
    }

    pub(crate) fn calibration(&self) -> &Calibration {
        &self.applied.calibration
    }

    pub(crate) fn recordings(&self) -> &[Arc<Recording>] {
        &self.applied.recordings
    }

    /// Returns the time lag of an output behind its reference.
    pub(crate) fn lag(
        &mut self,
        column: usize,
        output: Trace,
        reversal_threshold: f64,
        progress: &Progress,
    ) -> Result<OutputLag, LookError> {
        let Self { applied, used, .. } = self;
        applied.output_lag((column, output), reversal_threshold, used, progress)
    }

    /// Returns the time lags of the uncompensated and the compensated load on each axis, measured in these recordings.
    pub(crate) fn lags(
        &self,
        recordings: &[usize],
        progress: &Progress,
    ) -> Result<Lags, Cancelled> {
        let n_axes = self.calibration().axes.len();
        let outputs =
            Trace::OUTPUTS.into_iter().flat_map(|output| (0..n_axes).map(move |at| (at, output)));
        let outputs: Vec<_> = outputs.collect();
        let mut lags = self.applied.lags(recordings, &outputs, &self.used, progress)?;
        let compensated = lags.split_off(n_axes);
        Ok([lags, compensated])
    }

    pub(crate) fn rules<'a>(&'a self, measuring: &'a MetrologySettings) -> Rules<'a> {
        Rules {
            axes: &self.calibration().axes,
            full_scale: &self.calibration().full_scale,
            settings: measuring,
            extents: self.applied.extents(),
        }
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
            Span::All => (0..self.recordings().len()).map(whole).collect(),
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
            let n = self.recordings().get(part.recording)?.n_samples();
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
        self.applied.apply(recordings, &mut self.used, progress)
    }

    pub(crate) fn run(&self, at: usize) -> Run<'_> {
        let applied = self.used[at].as_ref();
        let applied = applied.expect("the loads of a recording are computed before its plot");
        Run::new(&self.recordings()[at], applied)
    }

    /// Returns the reference load of an axis; `None` if the recording has no reference load for this axis.
    pub(crate) fn loads(&self, part: &Part, axis: Axis) -> Option<Vec<f64>> {
        let loads = self.recordings()[part.recording].load(axis)?;
        Some(loads.skip(part.samples.start).take(part.samples.len()).collect())
    }

    /// Returns the reference load of an axis, delayed by the time lag of an output; `None` if the recording has no reference
    /// load.
    pub(crate) fn late_loads(&self, part: &Part, axis: Axis, lag: &InTime) -> Option<Vec<f64>> {
        let whole = Part { samples: 0..usize::MAX, ..part.clone() };
        let loads = self.loads(&whole, axis)?;
        let late = lag.reference(self.recordings()[part.recording].times(), &loads);
        Some(late[part.samples.clone()].to_vec())
    }

    /// Returns the values of a gauge channel; `None` if there is no gauge with this index.
    pub(crate) fn gauge(&self, part: &Part, gauge: usize) -> Option<Vec<f64>> {
        let recording = &self.recordings()[part.recording];
        let width = recording.n_gauges();
        (gauge < width).then(|| part_of(recording.gauges(), width, gauge, &part.samples))
    }

    pub(crate) fn output(&self, part: &Part, at: usize, output: Trace) -> Vec<f64> {
        let rows = rows_of(&self.used, part.recording, output);
        part_of(rows, self.calibration().axes.len(), at, &part.samples)
    }

    /// Returns a load (`output`) after its gains are fitted again to the delayed reference load.
    pub(crate) fn refitted(&self, part: &Part, output: Trace, lag: &InTime) -> Vec<f64> {
        let rows = rows_of(&self.used, part.recording, output);
        let width = self.calibration().axes.len();
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
        self.applied.forget_many();
    }
}
