//! One Python file on NumPy.

use crate::export::code::{COMMAS, Code, Language, plain};
use crate::shown::printable;

/// `.py`.
pub(super) static PYTHON: Code = Code {
    name: "Python source",
    endings: &["py"],
    language: Language {
        template: include_str!("../templates/calibration.py"),
        comment: |text| printable(text).into_owned(),
        brackets: ('[', ']'),
        breaks: COMMAS,
        number: plain,
        time: plain,
        weight: |weight| format!("{:?}", f64::from(weight)),
        is_taken: |_, _| false, // names are made of it, or it is not used
    },
};
