//! LoopScope calibrates force/torque sensors and compensates their hysteresis.
//!
//! This page describes the modules, in the order in which a calibration is made. Each module may use the modules above it in
//! this table, but none below. The files and folders directly in a module do not use each other in a circle. The tests in
//! `tests/house.rs` hold both rules.
//!
//! | module | contents | start reading at |
//! |---|---|---|
//! | [`recording`] | recordings with their roles (training or test), axes, units and tare; the built-in simulated sensor | [`recording::Recording`] |
//! | [`formats`] | files of numbers as named columns, read and written; one source file for each format | [`formats::FORMATS`] |
//! | [`import`] | recordings from columns: column maps, given or guessed; clocks, pauses, loads from a pose | [`import::read`] |
//! | [`features`] | features of the gauges, one file for each kind: look-back (earlier gauge values; Eq. 9-12 of Koike et al., 2019) and others | [`features::Design`] |
//! | [`calibration`] | loads from gauges: least squares (Eq. 3-8 of the same paper) and its sums, network, kernel, and the resulting calibration | [`calibration::Calibration`] |
//! | [`scoring`] | computations that several requests share: cross-validation, held-out sums, faults, loops, dwells | [`scoring::cross_validation`] |
//! | [`report`] | tables and figures as plain data, the same for window, command line, report and files | [`report::Table`], [`report::figure::Figure`] |
//! | [`export`] | calibrations as files and as code, one source file for each format; traces; each file written completely or not at all | [`export::TARGETS`] |
//! | [`questions`] | the prepared recordings, and one folder for each kind of request: errors, expected error, thresholds, loops, metrology, models, check of the data | [`questions::analyse`] |
//! | [`engine`] | the open document with its edits and undo, computation in the background, saved sessions | [`engine::Engine`] |
//! | [`cli`] | the command line | [`cli::Job`] |
//! | `ui` | the window (cargo feature `gui`), one file for each pane, which requests results, draws them and sends edits | `ui::Shell` |
//!
//! [`finding`] contains the sentences by which the program reports what it found in the data. [`progress`] reports the
//! progress of slow computations and cancels them. [`min_max`] computes the smallest and the largest of some numbers.
//!
//! Other programs can use the functions of this example: read recordings, fit a calibration, compute its errors, write and
//! read it, and run it sample by sample. All other items are internal.
//!
//! ```
//! use std::sync::Arc;
//! use loopscope::questions::{Request, analyse};
//! use loopscope::calibration::{Estimator, FitSettings};
//! use loopscope::export::{read_calibration, write_calibration};
//! use loopscope::import::read;
//! use loopscope::progress::Progress;
//! use loopscope::recording::{Entry, RecordingSet, simulated};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Recordings of the built-in simulated sensor.
//! let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
//!
//! // Fit a conventional calibration, and one that a look-back (earlier gauge values) compensates for hysteresis.
//! let settings = FitSettings { decimation: 10, ..FitSettings::default() };
//! let analysis = analyse(&Request::fit(recordings, settings), &Progress::default())?;
//! let quality = &analysis.calibration.quality;
//! let (conventional, compensated) = (&quality.conventional, &quality.compensated);
//! assert!(compensated.test_rmse.as_ref().unwrap()[0] < conventional.test_rmse.as_ref().unwrap()[0]);
//!
//! // Write the calibration, read it, and compute a load as a robot would.
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("calibration.json");
//! write_calibration(&analysis.calibration, &path)?;
//! let calibration = read_calibration(&path)?;
//! let design = calibration.design();
//! let mut estimator = Estimator::new(&calibration, &design)?;
//! let (_, load) = estimator.update(0.0, &[0.0; 6])?;
//! assert_eq!(load.len(), 6);
//!
//! // Read a recording. The names of its columns show which is the time, a gauge or a load.
//! let path = folder.path().join("press.csv");
//! std::fs::write(&path, "t [s],S1,S2,Fz [N]\n0,0.1,0.2,1\n0.1,0.2,0.3,2\n0.2,0.3,0.4,3\n")?;
//! let loaded = read(&path, None, &[], &Progress::default())?;
//! assert_eq!(loaded.recordings[0].gauge_names(), ["S1", "S2"]);
//! let mut set = RecordingSet::default();
//! set.push(Entry::with_default_role(loaded.recordings[0].clone()))?;
//! # Ok(())
//! # }
//! ```

// In a build without the window, some items are unused.
#![cfg_attr(not(feature = "gui"), allow(dead_code, unused_imports))]

mod about;
pub mod calibration;
pub mod cli;
mod column;
mod dot;
pub mod engine;
pub mod export;
pub mod features;
pub mod finding;
pub mod formats;
pub mod import;
mod lanes;
pub mod logged;
pub mod min_max;
mod outward;
pub(crate) mod panicked;
pub mod progress;
pub mod questions;
mod random;
pub mod recording;
pub mod report;
mod same;
pub mod scoring;
mod shown;
mod small_file;
#[cfg(feature = "gui")]
pub mod ui;
mod vectorised;
