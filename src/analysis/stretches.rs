//! Which samples are written where somebody asks for traces as a file.

use crate::analysis::TraceSet;
use crate::export::Stretch;
use crate::recording::{Recording, RecordingSet};

/// All samples of every recording whose times, on the recording's own clock, lie from `from_secs` to `to_secs`.
///
/// `decimation` is that of the fit. Recordings without such a sample are left out.
#[must_use]
pub fn stretches_within<'a>(
    recordings: impl Iterator<Item = &'a Recording>,
    decimation: usize,
    (from_secs, to_secs): (f64, f64),
) -> Vec<Stretch<'a>> {
    let stretches = recordings.map(|recording| {
        let times = recording.times().iter().step_by(decimation.max(1));
        let before = times.clone().take_while(|time| **time < from_secs).count();
        let until = times.take_while(|time| **time <= to_secs).count();
        Stretch {
            recording,
            decimation,
            samples: before..until.max(before),
        }
    });
    stretches
        .filter(|stretch| !stretch.samples.is_empty())
        .collect()
}

/// The samples that the trace panes show: all, or those within a stretch of the traces' time.
#[must_use]
pub fn stretches_on_screen<'a>(
    recordings: &'a RecordingSet,
    decimation: usize,
    traces: &TraceSet,
    visible: Option<(f64, f64)>,
) -> Vec<Stretch<'a>> {
    let shown = traces.on_screen(visible).into_iter();
    let stretches = shown.filter_map(|(recording, samples)| {
        let entry = recordings.entries().get(recording)?;
        Some(Stretch {
            recording: &entry.recording,
            decimation,
            samples,
        })
    });
    stretches
        .filter(|stretch| !stretch.samples.is_empty())
        .collect()
}
