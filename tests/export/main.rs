//! Exported code: each language is built, run over a recording and compared with the program's own loads.

mod c;
mod cal;
mod calibration_file;
mod data_files;
mod m_function;
mod matrices;
mod package;
mod python;
mod report;
mod rust;
mod support;
