//! One C99 file, without a heap.

use crate::export::code::{COMMAS, Code, Language};
use crate::export::text::for_block_comment;

/// `.h`.
pub(super) static C_HEADER: Code = Code {
    name: "C header",
    endings: &["h"],
    language: Language {
        template: include_str!("../templates/calibration.h"),
        comment: for_block_comment,
        brackets: ('{', '}'),
        breaks: COMMAS,
        number: |value| format!("LOOPSCOPE_N({value:?})"),
        time: |secs| format!("LOOPSCOPE_SECS({secs:?})"),
        weight: |weight| format!("{weight:?}f"),
        is_taken: |_, _| false, // names are made of it, or it is not used
    },
};
