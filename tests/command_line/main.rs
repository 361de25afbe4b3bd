//! Runs the command line as users do, and checks output, files and errors of each job.

#[path = "../support/program.rs"]
mod program;
#[path = "../support/table.rs"]
mod table;
#[path = "../support/tools.rs"]
mod tools;
mod workshop;

mod apply;
mod auxiliary;
mod best;
mod blocks;
mod built_in;
mod check;
mod export;
mod faults;
mod first_steps;
mod fit;
mod inspect;
mod load_cases;
mod many_sensors;
mod metrology;
mod one_session;
mod outputs;
mod plot;
mod python;
mod refusals;
mod report;
mod sensor;
mod streams;
mod sweep;
mod traces;
mod usage;
