//! What leaves the program: calibration files, tables and pictures, each written whole or not at all.

mod atomic;
mod calibration_file;
mod comparison_csv;
mod loads_csv;
mod loop_svg;
mod metrology_csv;
pub mod svg;
mod threshold_csv;
mod threshold_pictures;

pub use atomic::{WriteError, write_atomically};
pub use calibration_file::{
    CalibrationFormat, ReadCalibrationError, read_calibration, write_calibration,
};
pub use comparison_csv::{ComparisonRow, comparison_records, write_comparison_csv};
pub use loads_csv::write_loads_csv;
pub use loop_svg::{Drawing, DrawnLine, Scale, write_drawing_svg};
pub use metrology_csv::write_metrology_csv;
pub use threshold_csv::write_threshold_csv;
pub use threshold_pictures::{
    curves_over_f_th, curves_over_t_th, f_th_label, threshold_heat_map, write_threshold_map,
};
