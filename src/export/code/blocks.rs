//! What the blocks of the list contribute to a program: declarations of their numbers and memory, functions, updates.

use super::Language;
use super::program::Program;
use super::template::{Scope, Value, render};
use crate::features::{Code, Constant, Memory, Numbers, Precision, Source};

/// The lists that templates repeat for the blocks.
pub(super) fn blocks(program: &Program, language: Language, prefix: &str) -> Scope {
    let n_gauges = program.centre.len();
    let text = |text: &str| Value::Text(text.to_owned());
    let mut lists: [Vec<Scope>; 4] = Default::default();
    for (sets, block) in &program.blocks {
        let [constants, memory, functions, updates] = &mut lists;
        constants.extend(block.constants.iter().map(|constant| {
            Scope::from([
                (
                    "declaration",
                    Value::Text(language.constant(constant, prefix)),
                ),
                (
                    "numbers",
                    match &constant.numbers {
                        Numbers::List(values) => language.numbers(values),
                        Numbers::Rows(rows) => language.rows(rows),
                    },
                ),
            ])
        }));
        memory.extend(block.memory.iter().map(|memory| {
            Scope::from([
                (
                    "declaration",
                    Value::Text(language.memory(memory, prefix, n_gauges)),
                ),
                ("name", text(memory.name)),
                ("zero", Value::Text(zero(memory))),
            ])
        }));
        let own = Scope::from([
            ("prefix", text(prefix)),
            ("PREFIX", text(&prefix.to_ascii_uppercase())),
            ("n_gauges", text(&n_gauges.to_string())),
            ("sets", text(&sets.to_string())),
        ]);
        let written = |template: &str| {
            let code = render(template.trim_matches('\n'), &own);
            Scope::from([("code", text(code.trim_end_matches('\n')))])
        };
        let code = language.code(block);
        functions.extend((!code.functions.is_empty()).then(|| written(code.functions)));
        updates.push(written(&code.update));
    }
    let names = ["constants", "memory", "functions", "updates"];
    names.into_iter().zip(lists.map(Value::List)).collect()
}

impl Language {
    fn code(self, block: &Source) -> &Code {
        match self {
            Self::C => &block.c,
            Self::Rust => &block.rust,
            Self::Python => &block.python,
        }
    }

    /// The name of a constant with its type, where the language wants one.
    fn constant(self, constant: &Constant, prefix: &str) -> String {
        let name = constant.name;
        let dimensions = match &constant.numbers {
            Numbers::List(values) => vec![values.len()],
            Numbers::Rows(rows) => vec![rows.len(), rows.first().map_or(0, Vec::len)],
        };
        match self {
            Self::C => c_array(constant.precision, prefix, name, &dimensions),
            Self::Rust => {
                let kind = rust_array(constant.precision, &dimensions);
                format!("const {}: {kind}", name.to_ascii_uppercase())
            }
            Self::Python => name.to_ascii_uppercase(),
        }
    }

    /// What is remembered, with its type; nothing in Python.
    fn memory(self, memory: &Memory, prefix: &str, n_gauges: usize) -> String {
        let mut dimensions = vec![memory.sets];
        dimensions.extend(memory.of_gauges.then_some(n_gauges));
        let (name, comment) = (memory.name, memory.comment);
        match self {
            Self::C => {
                let array = c_array(memory.precision, prefix, name, &dimensions);
                match comment {
                    "" => format!("{array};"),
                    _ => format!("{array}; /* {comment} */"),
                }
            }
            Self::Rust => {
                let kind = rust_array(memory.precision, &dimensions);
                match comment {
                    "" => format!("{name}: {kind},"),
                    _ => format!("// {comment}\n    {name}: {kind},"),
                }
            }
            Self::Python => String::new(),
        }
    }
}

fn c_array(precision: Precision, prefix: &str, name: &str, dimensions: &[usize]) -> String {
    let kind = match precision {
        Precision::Real => format!("{prefix}_real"),
        Precision::Double => "double".to_owned(),
        Precision::Index => "long".to_owned(),
    };
    let dimensions: String = dimensions.iter().map(|n| format!("[{n}]")).collect();
    format!("{kind} {name}{dimensions}")
}

fn rust_array(precision: Precision, dimensions: &[usize]) -> String {
    let number = match precision {
        Precision::Real => "Real",
        Precision::Double => "f64",
        Precision::Index => "usize",
    };
    let within = dimensions.iter().rev();
    within.fold(number.to_owned(), |inner, n| format!("[{inner}; {n}]"))
}

/// Zeros for a memory in Rust.
fn zero(memory: &Memory) -> String {
    let number = match memory.precision {
        Precision::Real | Precision::Double => "0.0",
        Precision::Index => "0",
    };
    match memory.of_gauges {
        true => format!("[[{number}; GAUGES]; {}]", memory.sets),
        false => format!("[{number}; {}]", memory.sets),
    }
}
