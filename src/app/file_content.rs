//! What can be written into a file, and what to do when the file is there already.

use std::sync::Arc;

use crate::analysis::{ComparedRow, Request, TraceSet};
use crate::app::{Mark, Session};
use crate::calibration::{Calibration, Undetermined};
use crate::evaluation::metrology::Metrology;
use crate::evaluation::threshold_study::{Measure, ThresholdMap};
use crate::recording::RecordingSet;

/// What is to be written into a file; where there is a choice, the ending of its name says how.
#[derive(Clone, Debug)]
pub enum FileContent {
    /// A calibration, with what it was fitted to.
    Calibration(Arc<Calibration>, Option<Arc<RecordingSet>>),
    /// A report on what is asked for, with the notes.
    Report(Box<Request>, String),
    /// Loads and errors over time.
    Traces(Box<TracesToWrite>),
    /// The comparison of regressors as CSV.
    Comparison(Vec<ComparedRow>),
    /// The metrology table as CSV.
    Metrology(Arc<Metrology>),
    /// The map of thresholds with its curves.
    Thresholds(Arc<ThresholdMap>, Measure),
    /// A session, with the mark that it is saved under.
    Session(Box<Session>, Box<Mark>),
    /// A finished file, such as a picture.
    Bytes(Arc<[u8]>),
}

/// The traces on screen, and what they are made of.
#[derive(Clone, Debug)]
pub struct TracesToWrite {
    /// What makes loads of the gauges.
    pub calibration: Arc<Calibration>,
    /// The recordings.
    pub recordings: Arc<RecordingSet>,
    /// Every so many-th sample is used.
    pub decimation: usize,
    /// The traces.
    pub traces: Arc<TraceSet>,
    /// The stretch of their time that is written; `None`: all.
    pub visible: Option<(f64, f64)>,
}

/// What to do with a file that is there already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Ask before it is replaced.
    Ask,
    /// Replace it: somebody was asked.
    Replace,
}

/// Why somebody is asked before a file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// It is there already.
    IsThere,
    /// The fit that it would hold says nothing; what to do afterwards with a file that is there.
    Undetermined(Undetermined, Existing),
}
