//! Choice of the intervals of recordings whose traces are saved to a file.

use std::sync::Arc;

use crate::{
    calibration::Calibration,
    export::Interval,
    questions::{
        dataset::Datasets,
        errors::{query::Analysis, traces::TraceSet},
        request::Request,
    },
    recording::{Recording, RecordingSet},
    same::same_where,
};

/// Traces on screen, and the data from which they are computed.
#[derive(Clone, Debug)]
pub struct OnScreen {
    /// Calibration that computes the loads.
    pub calibration: Arc<Calibration>,
    /// The recordings with their roles (train, test or off).
    pub recordings: Arc<RecordingSet>,
    /// Decimation of the recordings, as in the analysis: every n-th sample is used.
    pub decimation: usize,
    /// Traces that the trace panes draw.
    pub traces: Arc<TraceSet>,
    /// Visible interval on the time axis of the trace panes (s); `None` for all samples.
    pub visible: Option<(f64, f64)>,
    /// Cache of the loads, which all requests about the same recordings share.
    pub datasets: Datasets,
}

same_where!(OnScreen: shared(calibration, recordings, traces) value(decimation, visible) besides(datasets));

impl OnScreen {
    /// Returns the traces of `analysis`, which must be the answer to `request`.
    pub fn of(request: &Request, analysis: &Analysis, visible: Option<(f64, f64)>) -> Self {
        Self {
            calibration: Arc::clone(&analysis.calibration),
            recordings: Arc::clone(&request.recordings),
            decimation: request.settings.decimation,
            traces: Arc::clone(&analysis.traces),
            visible,
            datasets: request.datasets.clone(),
        }
    }

    /// Returns the samples that the trace panes show.
    pub fn intervals(&self) -> Vec<Interval<'_>> {
        let shown = self.traces.on_screen(self.visible).into_iter();
        let intervals = shown.filter_map(|(recording, samples)| {
            let recording = &self.recordings.entries().get(recording)?.recording;
            Some(Interval { recording, decimation: self.decimation, samples })
        });
        intervals.filter(|interval| !interval.samples.is_empty()).collect()
    }
}

/// Returns the samples of every recording from `from_secs` to `to_secs` on the recording's own clock, decimated like the fit.
/// Recordings without a sample in this interval are omitted.
pub fn intervals_within<'a>(
    recordings: impl Iterator<Item = &'a Recording>,
    decimation: usize,
    (from_secs, to_secs): (f64, f64),
) -> Vec<Interval<'a>> {
    let intervals = recordings.map(|recording| {
        let times = recording.times().iter().step_by(decimation.max(1));
        let before = times.clone().take_while(|time| **time < from_secs).count();
        let until = times.take_while(|time| **time <= to_secs).count();
        Interval { recording, decimation, samples: before..until.max(before) }
    });
    intervals.filter(|interval| !interval.samples.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::FitSettings;
    use crate::progress::Progress;
    use crate::questions::errors::query::analyse;
    use crate::questions::request::View;
    use crate::recording::simulated;

    /// The panes' time and the first recording's clock both begin at zero. The second recording follows the first in the panes.
    #[test]
    fn visible_samples_are_counted_within_each_recording() {
        let set = simulated::recordings(1);
        let mut two = RecordingSet::default();
        for entry in &set.entries()[..2] {
            two.push(entry.clone()).unwrap();
        }
        let request = Request {
            view: View::All,
            ..Request::fit(Arc::new(two.clone()), FitSettings::default())
        };
        let analysis = analyse(&request, &Progress::default()).unwrap();
        let traces = &analysis.traces;
        let on_screen = |visible| OnScreen::of(&request, &analysis, Some(visible));
        let n = two.entries()[0].recording.n_samples();
        let end = traces.times[n + 9];
        let shown = on_screen((1.0, end));
        let shown = shown.intervals();
        let first = two.entries()[0].recording.times();
        let before = first.iter().filter(|time| **time - first[0] < 1.0).count();
        assert_eq!(shown[0].samples, before..n);
        assert_eq!(shown[1].samples, 0..10);
        let recordings = two.entries().iter().map(|entry| &*entry.recording);
        let within = intervals_within(recordings, 1, (first[0] + 1.0, f64::INFINITY));
        assert_eq!(within[0], shown[0]);
        assert_eq!(on_screen((1e9, 2e9)).intervals(), []);
    }
}
