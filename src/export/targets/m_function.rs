//! Calibration as a single MATLAB function that Simulink accepts, because it uses no cell arrays and only arrays of fixed
//! size.

use crate::export::{
    code::{CODE, Language},
    target::Target,
    text::ascii,
};

pub(super) static M_FUNCTION: Target = Target {
    name: "MATLAB function",
    purpose: "MATLAB",
    endings: &["m"],
    write: |export, out| MATLAB.write(export, out),
    ..CODE
};

pub(super) static MATLAB: Language = Language {
    template: include_str!("../templates/calibration.m"),
    // Comments are in ASCII only, because other characters depend on the text encoding of the machine that reads the file.
    comment: ascii,
    breaks: (", ...\n    ", ";\n    "),
    is_taken,
    ..Language::PLAIN
};

/// Words that MATLAB or Octave reserves, so that a function must not have one as its name.
const KEYWORDS: &str = "\
    break case catch classdef continue do else elseif end endfunction endif endwhile enumeration events for function \
    global if methods otherwise parfor persistent properties return spmd switch try until unwind_protect while \
    endfor end_try_catch";

/// Returns true if the function must not have this name. The code contains its own name once. A second occurrence means that
/// the code calls a MATLAB function of the same name.
fn is_taken(name: &str, code: &str) -> bool {
    let is_of_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words = code
        .lines()
        .filter_map(|line| line.split('%').next())
        .flat_map(|line| line.split(|c| !is_of_word(c)));
    KEYWORDS.split(' ').any(|word| word == name) || words.filter(|word| *word == name).count() > 1
}
