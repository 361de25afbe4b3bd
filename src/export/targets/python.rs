//! One Python file on NumPy.

use crate::export::code::{Code, Language, plain};
use crate::shown::printable;

/// `.py`.
pub(super) static PYTHON: Code = Code {
    name: "Python source",
    endings: &["py"],
    language: Language {
        template: include_str!("../templates/calibration.py"),
        comment: |text| printable(text).into_owned(),
        brackets: ('[', ']'),
        number: plain,
        time: plain,
        weight: |weight| format!("{:?}", f64::from(weight)),
    },
};
