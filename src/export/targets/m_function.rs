//! Calibration as a single MATLAB function without cell arrays and with fixed sizes, which Simulink accepts.

use crate::export::code::{CODE, Language};
use crate::export::target::Target;
use crate::export::text::ascii;

pub(super) static M_FUNCTION: Target = Target {
    name: "MATLAB function",
    endings: &["m"],
    write: |export, out| MATLAB.write(export, out),
    ..CODE
};

pub(super) static MATLAB: Language = Language {
    template: include_str!("../templates/calibration.m"),
    // Comments are in ASCII, because the meaning of other characters depends on the machine that reads the file.
    comment: ascii,
    breaks: (", ...\n    ", ";\n    "),
    is_taken,
    ..Language::PLAIN
};

/// Names that a function in MATLAB or Octave must not have.
const KEYWORDS: &str = "\
    break case catch classdef continue do else elseif end endfunction endif endwhile enumeration events for function \
    global if methods otherwise parfor persistent properties return spmd switch try until unwind_protect while \
    endfor end_try_catch";

/// Returns true if the code must not use this name. The code contains the name of its own function once; a second occurrence
/// means a function of MATLAB.
fn is_taken(name: &str, code: &str) -> bool {
    let is_of_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words = code
        .lines()
        .filter_map(|line| line.split('%').next())
        .flat_map(|line| line.split(|c| !is_of_word(c)));
    KEYWORDS.split(' ').any(|word| word == name) || words.filter(|word| *word == name).count() > 1
}
