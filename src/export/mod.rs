//! Outputs of the program, each written atomically: calibration files, source code that runs calibrations, and tables of
//! loads.

mod arrays;
mod atomic;
mod calibration_file;
mod code;
mod facts;
mod fields;
mod format;
mod hash;
mod sources;
mod target;
mod targets;
mod template;
mod text;
mod traces;
mod writable;

pub use atomic::clean_up_when_asked_to_end;
pub(crate) use atomic::{
    Together, WriteError, clean_up_in, interrupt_stops, interrupted_code, write_atomically,
};
pub(crate) use calibration_file::{
    ReadCalibrationError, add_calibration, caution, file_sizes, read_with_notes,
};
pub use calibration_file::{read_calibration, write_calibration};
pub use code::Footprint;
pub(crate) use code::bytes_in_float;
pub(crate) use facts::settings_of;
pub(crate) use format::FileFormat;
pub use hash::sha256;
pub(crate) use sources::used_recordings;
pub use sources::with_sources;
pub use target::Export;
pub(crate) use target::{Held, Outline, PARTS, Target};
pub use targets::{TARGETS, name_gauges, target_for};
pub(crate) use targets::{known_target, listed_targets, names_gauges, target_endings};
pub(crate) use template::filled_markup;
pub use traces::Interval;
pub(crate) use traces::{LiveSample, LoadRows, TRACE_FORMATS, write_loads_csv, write_traces};
pub(crate) use writable::{TargetError, check_targets};
