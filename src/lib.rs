//! LoopScope: calibrate force/torque sensors and see what their past does to them.

pub mod progress;
pub mod recording;
