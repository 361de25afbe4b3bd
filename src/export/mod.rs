//! What leaves the program: calibration files, source code that runs them, and tables of loads, each written whole or not at
//! all.

mod arrays;
mod atomic;
mod cal;
mod calibration_csv;
mod calibration_file;
mod code;
mod comparison_csv;
mod facts;
mod format;
mod loads_csv;
mod mat;
mod metrology_csv;
mod npz;
mod onnx;
mod text;
mod yaml;

pub use atomic::{WriteError, write_atomically};
pub use cal::{CalError, name_gauges};
pub use calibration_file::{ReadCalibrationError, read_calibration, write_calibration};
pub use comparison_csv::{ComparisonRow, comparison_records, write_comparison_csv};
pub use format::{CalibrationFormat, FormatError};
pub use loads_csv::write_loads_csv;
pub use metrology_csv::write_metrology_csv;
