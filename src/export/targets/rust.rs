//! One Rust file on the standard library.

use crate::export::code::{COMMAS, Code, Language, plain};
use crate::shown::printable;

/// `.rs`.
pub(super) static RUST: Code = Code {
    name: "Rust source",
    endings: &["rs"],
    language: Language {
        template: include_str!("../templates/calibration.rs.in"),
        comment: |text| printable(text).into_owned(),
        brackets: ('[', ']'),
        breaks: COMMAS,
        number: plain,
        time: plain,
        weight: |weight| format!("{weight:?}"),
        is_taken: |_, _| false, // names are made of it, or it is not used
    },
};
