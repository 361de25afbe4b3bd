//! LoopScope: calibrate force/torque sensors and see what their past does to them.

pub mod analysis;
pub mod app;
pub mod calibration;
pub mod cli;
pub mod evaluation;
pub mod export;
pub mod features;
pub mod progress;
pub mod recording;
#[cfg(feature = "gui")]
pub mod ui;
pub mod worker;
