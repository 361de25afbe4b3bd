//! The program as a person runs it: what each job says, writes and refuses.

#[path = "../support/program.rs"]
mod program;
#[path = "../support/table.rs"]
mod table;
mod workshop;

mod apply;
mod auxiliary;
mod best;
mod blocks;
mod built_in;
mod certificate;
mod check;
mod drift;
mod export;
mod faults;
mod first_steps;
mod fit;
mod inspect;
mod load_cases;
mod metrology;
mod one_session;
mod outputs;
mod refusals;
mod report;
mod streams;
mod sweep;
mod traces;
mod usage;
