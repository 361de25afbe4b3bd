//! Calibration as a single Rust file that needs only the standard library.

use crate::export::{
    code::{CODE, Language},
    target::Target,
};

pub(super) static RUST: Target = Target {
    name: "Rust source",
    purpose: "Rust",
    endings: &["rs"],
    write: |export, out| LANGUAGE.write(export, out),
    ..CODE
};

pub(super) static LANGUAGE: Language = Language {
    template: include_str!("../templates/calibration.rs.in"),
    weight: |weight| format!("{weight:?}"),
    ..Language::PLAIN
};
