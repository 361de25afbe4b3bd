//! Calibration as a single C99 file, whose code allocates no memory on the heap.

use crate::export::{
    code::{CODE, Language},
    target::Target,
    text::for_block_comment,
};

pub(super) static C_HEADER: Target = Target {
    name: "C header",
    purpose: "C on a controller",
    endings: &["h"],
    write: |export, out| C.write(export, out),
    ..CODE
};

pub(super) static C: Language = Language {
    template: include_str!("../templates/calibration.h"),
    comment: for_block_comment,
    brackets: ('{', '}'),
    number: |value| format!("LOOPSCOPE_N({value:?})"),
    time: |secs| format!("LOOPSCOPE_SECS({secs:?})"),
    weight: |weight| format!("{weight:?}f"),
    ..Language::PLAIN
};
