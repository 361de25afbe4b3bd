//! What leaves the program: calibration files, source code that runs them, tables and pictures, each written whole or not at
//! all.

mod arrays;
mod atomic;
mod calibration_file;
mod code;
mod facts;
mod fields;
mod hash;
mod mat;
mod npz;
mod report;
mod sources;
mod target;
mod targets;
mod text;
mod threshold_csv;
mod threshold_pictures;
mod traces;
mod writable;

pub use atomic::{WriteError, clean_up_when_asked_to_end, write_atomically};
pub use calibration_file::{ReadCalibrationError, read_calibration, write_calibration};
pub use hash::sha256;
pub use report::{ReportCurves, ReportData, ReportErrors, ReportRecording, utc, write_report};
pub use sources::{used_recordings, with_sources};
pub use target::{Export, Outline, ReadBack, Refusal, Target};
pub use targets::{TARGETS, listed_targets, name_gauges, names_gauges, target_endings, target_for};
pub use threshold_csv::write_threshold_csv;
pub use threshold_pictures::{
    curves_over_f_th, curves_over_t_th, f_th_label, threshold_heat_map, threshold_map_files,
    write_threshold_map, write_threshold_svg,
};
pub use traces::{Stretch, TraceFormat, write_loads_csv, write_traces};
pub use writable::{TargetError, check_targets};
