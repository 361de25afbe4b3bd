//! Exported code of each language is built and run on a recording. The printed loads are compared with the loads of the program.

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
#[path = "../support/tools.rs"]
mod tools;
