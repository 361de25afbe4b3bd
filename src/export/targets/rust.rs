//! One Rust file on the standard library.

use crate::export::code::{Code, Language, plain};
use crate::shown::printable;

/// `.rs`.
pub(super) static RUST: Code = Code {
    name: "Rust source",
    endings: &["rs"],
    language: Language {
        template: include_str!("../templates/calibration.rs.in"),
        comment: |text| printable(text).into_owned(),
        brackets: ('[', ']'),
        number: plain,
        time: plain,
        weight: |weight| format!("{weight:?}"),
    },
};
