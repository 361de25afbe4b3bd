//! A block in exported code: its numbers, what it remembers, and its update in C, Rust, Python and MATLAB.
//!
//! In an update `row` begins with the present gauges less their centre; what a block appends follows from `next` on, histories
//! less the present gauges (in Python rows are appended; in MATLAB `next` is the column before). Numbers and memory are declared by whoever writes the program; texts,
//! which are Jinja templates, may name `{{ prefix }}`, `{{ n_gauges }}`, `{{ n_auxiliary }}` and `{{ sets }}`, the number of the block's values; `auxiliary` holds the sample's auxiliary channels. In C an update stands in braces of its
//! own, and `g` counts gauges.

use serde::Serialize;

use crate::features::channel::AuxiliaryChannel;
use crate::features::gauge_scale::GaugeScale;

/// The gauges that a block is run on.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Over the training recordings.
    pub scale: &'a GaugeScale,
    /// What makes standardised gauges of gauges less centre: factor and constant.
    pub standardise: &'a [(f64, f64)],
    /// What comes beside them.
    pub channels: &'a [AuxiliaryChannel],
}

impl Rows<'_> {
    /// Factors and constants that standardise gauges, under these names.
    pub fn standard(&self, [factor, constant]: [&'static str; 2]) -> [Constant; 2] {
        let pairs = self.standardise.iter();
        [
            Constant::reals(factor, pairs.clone().map(|(factor, _)| *factor)),
            Constant::reals(constant, pairs.map(|(_, constant)| *constant)),
        ]
    }
}

/// What a block contributes to a program.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Source {
    /// Its numbers.
    pub constants: Vec<Constant>,
    /// What it remembers between samples, zero at first.
    pub memory: Vec<Memory>,
    /// In C.
    pub c: Code,
    /// In Rust.
    pub rust: Code,
    /// In Python, which needs no declared memory.
    pub python: Code,
    /// In MATLAB, which declares the memory that is named here.
    pub matlab: Code,
}

impl Source {
    /// A block whose updates in C, Rust, Python and MATLAB need no functions of their own.
    pub fn new(constants: Vec<Constant>, memory: Vec<Memory>, updates: [&str; 4]) -> Self {
        let [c, rust, python, matlab] = updates.map(Code::update);
        Self { constants, memory, c, rust, python, matlab }
    }
}

/// Texts of one language.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Code {
    /// Functions of its own; in Rust and Python methods of the state.
    pub functions: &'static str,
    /// Takes a sample and writes its columns.
    pub update: String,
}

impl Code {
    /// An update that needs no function of its own.
    pub fn update(text: impl Into<String>) -> Self {
        Self { functions: "", update: text.into() }
    }
}

/// How a number is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// In the program's own type, which may be single precision.
    Real,
    /// As a time (s), which a C program may count in ticks.
    Clock,
    /// As a count of samples.
    Index,
}

/// Numbers that never change.
#[derive(Clone, Debug, Serialize)]
pub struct Constant {
    /// In small letters.
    pub name: &'static str,
    /// How they are kept.
    pub precision: Precision,
    /// The numbers.
    pub numbers: Numbers,
}

impl Constant {
    /// A list of numbers of the program's own type.
    pub fn reals(name: &'static str, values: impl Iterator<Item = f64>) -> Self {
        Self { name, precision: Precision::Real, numbers: Numbers::List(values.collect()) }
    }
}

/// One list, or one for each value.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    /// A list.
    List(Vec<f64>),
    /// One row of gauges for each value.
    Rows(Vec<Vec<f64>>),
}

/// What is remembered between samples.
#[derive(Clone, Debug, Serialize)]
pub struct Memory {
    /// In small letters.
    pub name: &'static str,
    /// How it is kept.
    pub precision: Precision,
    /// How many there are: one for each value.
    pub sets: usize,
    /// Whether each is a set of gauges, not a number.
    pub of_gauges: bool,
    /// What is to be said of it.
    pub comment: &'static str,
}

impl Memory {
    /// A set of gauges for each value.
    pub fn of_gauges(name: &'static str, sets: usize) -> Self {
        Self { of_gauges: true, ..Self::single(name, sets) }
    }

    /// A number for each value.
    pub fn single(name: &'static str, sets: usize) -> Self {
        Self { name, precision: Precision::Real, sets, of_gauges: false, comment: "" }
    }

    pub fn about(self, comment: &'static str) -> Self {
        Self { comment, ..self }
    }
}
