//! Samples that are written when traces are saved to a file.

use crate::export::Interval;
use crate::questions::errors::traces::TraceSet;
use crate::recording::{Recording, RecordingSet};

/// Returns all samples of every recording from `from_secs` to `to_secs` on the recording's own clock.
///
/// `decimation` is that of the fit. Recordings without such a sample are left out.
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

/// Returns the samples that the trace panes show: all, or those within an interval of the traces' time.
pub fn intervals_on_screen<'a>(
    recordings: &'a RecordingSet,
    decimation: usize,
    traces: &TraceSet,
    visible: Option<(f64, f64)>,
) -> Vec<Interval<'a>> {
    let shown = traces.on_screen(visible).into_iter();
    let intervals = shown.filter_map(|(recording, samples)| {
        let entry = recordings.entries().get(recording)?;
        Some(Interval { recording: &entry.recording, decimation, samples })
    });
    intervals.filter(|interval| !interval.samples.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::calibration::FitSettings;
    use crate::progress::Progress;
    use crate::questions::errors::query::analyse;
    use crate::questions::errors::view::View;
    use crate::questions::request::Request;
    use crate::recording::simulated;

    /// The time of the panes and the clock of the first recording both begin at zero, so both intervals choose the same
    /// samples of it. The panes show the second recording after the first.
    #[test]
    fn what_is_on_screen_is_counted_within_each_recording() {
        let set = simulated::recordings(1);
        let mut two = RecordingSet::default();
        for entry in &set.entries()[..2] {
            two.push(entry.clone()).unwrap();
        }
        let request = Request {
            view: View::All,
            ..Request::fit(Arc::new(two.clone()), FitSettings::default())
        };
        let traces = analyse(&request, &Progress::default()).unwrap().traces;
        let n = two.entries()[0].recording.n_samples();
        let end = traces.times[n + 9];
        let shown = intervals_on_screen(&two, 1, &traces, Some((1.0, end)));
        let first = two.entries()[0].recording.times();
        let before = first.iter().filter(|time| **time - first[0] < 1.0).count();
        assert_eq!(shown[0].samples, before..n);
        assert_eq!(shown[1].samples, 0..10);
        let recordings = two.entries().iter().map(|entry| &*entry.recording);
        let within = intervals_within(recordings, 1, (first[0] + 1.0, f64::INFINITY));
        assert_eq!(within[0], shown[0]);
        assert_eq!(intervals_on_screen(&two, 1, &traces, Some((1e9, 2e9))), []);
    }
}
