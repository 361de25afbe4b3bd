//! Finds faulty samples of recordings, which the window marks.

use std::ops::Range;
use std::sync::Arc;

use crate::questions::dataset::Datasets;
use crate::questions::question::{Answered, Query, Work};
use crate::questions::request::Request;
use crate::recording::{Entry, Recording, RecordingSet, ValidRange};
use crate::same::same_where;
use crate::scoring::faults::Faults;

#[derive(Clone, Debug)]
pub struct FindFaults {
    pub recordings: Arc<RecordingSet>,
    /// Limits of the sensor's gauges and loads, outside which a sample is faulty.
    pub range: ValidRange,
    pub datasets: Datasets,
}

#[derive(Debug)]
pub struct FaultyRecording {
    /// Number of samples of the recording that cannot be used.
    pub n_samples: usize,
    /// For each kind of fault, a text that describes where it occurs.
    pub words: Vec<String>,
    /// Start and end (s) of each fault, on the recording's own clock.
    pub intervals: Vec<(f64, f64)>,
}

impl FaultyRecording {
    fn of(recording: &Recording, faults: &Faults) -> Self {
        let (samples, times) = (faults.samples(), recording.times());
        let interval = |samples: &Range<usize>| (times[samples.start], times[samples.end - 1]);
        Self {
            n_samples: faults.n_samples(),
            words: faults.in_words(recording),
            intervals: samples.iter().map(interval).collect(),
        }
    }
}

impl FindFaults {
    pub fn of(request: &Request, range: ValidRange) -> Self {
        let recordings = Arc::clone(&request.recordings);
        Self { recordings, range, datasets: request.datasets.clone() }
    }
}

same_where!(FindFaults: shared(recordings) value(range) besides(datasets));

impl Query for FindFaults {
    type Answer = Vec<Arc<FaultyRecording>>;
    type Cache = ();

    fn title(&self) -> String {
        "Looking for faulty samples".to_owned()
    }

    fn compute(&self, work: Work<'_, Self>) -> Answered<Self> {
        let found = (self.datasets).faults(&self.recordings, &self.range, work.progress)?;
        let entries = self.recordings.entries().iter().zip(&found);
        let of = |entry: &Entry, found: &Faults| FaultyRecording::of(&entry.recording, found);
        Ok(entries.map(|(entry, found)| Arc::new(of(entry, found))).collect())
    }
}
