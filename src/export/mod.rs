//! What leaves the program: calibration files and tables of loads, each written whole or not at all.

mod atomic;
mod calibration_file;
mod loads_csv;
mod metrology_csv;

pub use atomic::{WriteError, write_atomically};
pub use calibration_file::{
    CalibrationFormat, ReadCalibrationError, look_back_text, read_calibration, write_calibration,
};
pub use loads_csv::write_loads_csv;
pub use metrology_csv::write_metrology_csv;
