//! Calibration as a single Python file that needs only NumPy.

use crate::export::{
    code::{CODE, Language},
    target::Target,
};

pub(super) static PYTHON: Target = Target {
    name: "Python source",
    purpose: "Python",
    endings: &["py"],
    write: |export, out| LANGUAGE.write(export, out),
    ..CODE
};

pub(super) static LANGUAGE: Language =
    Language { template: include_str!("../templates/calibration.py"), ..Language::PLAIN };
