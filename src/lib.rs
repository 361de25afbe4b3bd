//! LoopScope: calibrate force/torque sensors and see what their past does to them.
//!
//! This page is the map of the house. The rooms follow the method; each may use those above it in this table, never those below.
//!
//! | room | what is in it | where to begin |
//! |---|---|---|
//! | [`recording`] | what was measured: recordings and their roles, axes, units, tare, the simulated sensor | [`recording::Recording`] |
//! | [`formats`] | files of numbers, one file a format: named columns, read and written | [`formats::FORMATS`] |
//! | [`import`] | columns → recordings: column maps and guessing them, clocks, pauses, loads from a pose | [`import::read`] |
//! | [`features`] | what a sample is described by, one file a block: look-back (Eq. 9-12) and the others | [`features::Design`] |
//! | [`calibration`] | gauges → load: sums, least squares (Eq. 3-8), network, kernel, the calibration that comes of it | [`calibration::Calibration`] |
//! | [`evaluation`] | how good it is: errors, cross-validation, threshold study, loops, dwells, metrology | [`evaluation::cross_validation`] |
//! | [`report`] | what is shown, as plain data: tables and figures, described once for window, command line, report and files | [`report::Table`], [`report::figure::Figure`] |
//! | [`export`] | what leaves the program, whole or not at all: calibrations, one file a target, code that runs them, traces | [`export::TARGETS`] |
//! | [`analysis`] | recordings and settings in, everything that is shown out | [`analysis::analyse`] |
//! | [`engine`] | a document, its edits and undo, questions answered off the window's thread, sessions | [`engine::Engine`] |
//! | [`cli`] | the command line | [`cli::Job`] |
//! | `ui` | the window (feature `gui`), one file a pane: panes ask questions, draw answers, push edits | `ui::Shell` |
//!
//! [`progress`] is how slow work is watched and cancelled.
//!
//! ```
//! use std::sync::Arc;
//! use loopscope::analysis::{Request, analyse};
//! use loopscope::calibration::FitSettings;
//! use loopscope::progress::Progress;
//! use loopscope::recording::simulated;
//!
//! let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
//! let settings = FitSettings { decimation: 10, ..FitSettings::default() };
//! let request = Request::fit(recordings, settings);
//! let analysis = analyse(&request, &Progress::default())?;
//! let quality = &analysis.calibration.quality;
//! let (conventional, compensated) = (&quality.conventional, &quality.compensated);
//! assert!(compensated.test_rmse.as_ref().unwrap()[0] < conventional.test_rmse.as_ref().unwrap()[0]);
//! # Ok::<(), loopscope::analysis::AnalysisError>(())
//! ```

pub mod analysis;
pub mod calibration;
pub mod cli;
pub mod engine;
pub mod evaluation;
pub mod export;
pub mod features;
pub mod formats;
pub mod import;
pub mod panicked;
pub mod progress;
mod random;
pub mod recording;
pub mod report;
mod shown;
mod small_file;
#[cfg(feature = "gui")]
pub mod ui;
