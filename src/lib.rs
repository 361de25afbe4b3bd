//! LoopScope: calibrate force/torque sensors and see what their past does to them.
//!
//! This page is the map of the house. The rooms follow the method; each may use those below it, never those above.
//!
//! | room | what is in it | where to begin |
//! |---|---|---|
//! | [`recording`] | what was measured: recordings and their roles, any logger's text by column maps, two clocks, the simulated sensor | [`recording::Recording`] |
//! | [`features`] | what a sample is described by: look-back (Eq. 9-12) and the other blocks | [`features::Design`] |
//! | [`calibration`] | gauges → load: sums, least squares (Eq. 3-8), network, kernel, the calibration that comes of it | [`calibration::Calibration`] |
//! | [`evaluation`] | how good it is: errors, cross-validation by recording, threshold study, loops, rests, the certificate's figures | [`evaluation::cross_validation`] |
//! | [`report`] | what is shown, as plain data: tables and figures, described once for window, command line, report and files | [`report::Table`], [`report::figure::Figure`] |
//! | [`export`] | what leaves the program, whole or not at all: calibrations in many formats, one file each, code that runs them, tables, pictures | [`export::write_calibration`] |
//! | [`analysis`] | recordings and settings in, everything that is shown out | [`analysis::analyse`] |
//! | [`app`] | the window's state and the one function that changes it; no drawing, no files | [`app::AppState::apply`] |
//! | `ui` | the window (feature `gui`): panels that read the state and push commands | `ui::Shell` |
//! | [`cli`] | the command line | [`cli::Job`] |
//!
//! Beside them stand [`worker`], which keeps slow work off the window's thread and knows nothing of what it carries, and
//! [`progress`], how such work is watched and cancelled.
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
pub mod app;
pub mod calibration;
pub mod cli;
pub mod evaluation;
pub mod export;
pub mod features;
pub mod panicked;
pub mod progress;
mod random;
pub mod recording;
pub mod report;
mod shown;
mod small_file;
#[cfg(feature = "gui")]
pub mod ui;
pub mod worker;
