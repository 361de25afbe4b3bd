//! Calibrations as source code for machines without this program: a C99 header, a Rust file, a Python file.
//!
//! Guarantees: one [`Program`] and one set of names for the three, which differ in their templates and in how numbers are
//! written; text of the user stands in comments only, and cannot leave them.

mod blocks;
mod program;
mod template;

use std::fmt::Write as _;

use self::blocks::blocks;
use self::program::Affine;
pub(super) use self::program::{LearnedProgram, Program};
use self::template::{Scope, Value, render};
use crate::calibration::network::Layer;
use crate::calibration::{Calibration, Kernel, LEAP_SECS, Learned, Network, STRAYS};
use crate::export::facts::Fact;
use crate::export::text::{for_block_comment, identifier};
use crate::features::Precision;
use crate::shown::printable;

/// The rate for which a C file keeps room where neither it nor the calibration says another (Hz) …
const DEFAULT_RATE_HZ: u64 = 1000;
/// … and what it keeps room for at most: no sensor is read faster.
const HIGHEST_RATE_HZ: f64 = 1e6;
/// A longer past fills the memory of what runs such files, and none reaches over a leap of the clock.
pub(super) const LONGEST_WINDOW_SECS: f64 = LEAP_SECS;

/// What source code is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Language {
    C,
    Rust,
    Python,
}

impl Language {
    fn template(self) -> &'static str {
        match self {
            Self::C => include_str!("../templates/calibration.h"),
            Self::Rust => include_str!("../templates/calibration.rs.in"),
            Self::Python => include_str!("../templates/calibration.py"),
        }
    }

    fn comment(self, text: &str) -> String {
        match self {
            Self::C => for_block_comment(text),
            Self::Rust | Self::Python => printable(text).into_owned(),
        }
    }

    fn brackets(self) -> (char, char) {
        match self {
            Self::C => ('{', '}'),
            Self::Rust | Self::Python => ('[', ']'),
        }
    }

    /// A single-precision weight, written so that no language rounds it twice.
    fn weight(self, weight: f32) -> String {
        match self {
            Self::C => format!("{weight:?}f"),
            Self::Rust => format!("{weight:?}"),
            Self::Python => format!("{:?}", f64::from(weight)),
        }
    }

    fn flag(self, is_set: bool) -> Value {
        text(match self {
            Self::C => {
                if is_set {
                    "1"
                } else {
                    "0"
                }
            }
            Self::Rust => {
                if is_set {
                    "true"
                } else {
                    "false"
                }
            }
            Self::Python => {
                if is_set {
                    "True"
                } else {
                    "False"
                }
            }
        })
    }

    /// A list of literals, cut into lines.
    fn list(self, items: impl IntoIterator<Item = String>) -> String {
        const PER_LINE: usize = 6;
        let (open, close) = self.brackets();
        let mut out = String::from(open);
        for (at, item) in items.into_iter().enumerate() {
            out.push_str(match at {
                0 => "",
                at if at % PER_LINE == 0 => ",\n    ",
                _ => ", ",
            });
            out.push_str(&item);
        }
        out.push(close);
        out
    }

    fn numbers<'a>(self, values: impl IntoIterator<Item = &'a f64>) -> Value {
        Value::Text(self.list(values.into_iter().map(|value| format!("{value:?}"))))
    }

    fn rows(self, rows: &[Vec<f64>]) -> Value {
        let (open, close) = self.brackets();
        let rows: Vec<String> = (rows.iter())
            .map(|row| self.list(row.iter().map(|value| format!("{value:?}"))))
            .collect();
        Value::Text(format!("{open}\n    {}\n{close}", rows.join(",\n    ")))
    }

    fn weights(self, weights: impl IntoIterator<Item = f32>) -> Value {
        Value::Text(self.list(weights.into_iter().map(|weight| self.weight(weight))))
    }
}

/// The calibration in a language; names in it are made of `name`.
pub(super) fn source_code(
    calibration: &Calibration,
    facts: &[Fact],
    language: Language,
    name: &str,
) -> String {
    let program = Program::new(calibration);
    let mut scope = sizes(&program, rate_hz(calibration), language);
    let prefix = identifier(name);
    scope.extend(look_back(&program, language));
    scope.extend(blocks(&program, language, &prefix));
    scope.extend(linear(&program, language));
    scope.extend(learned(&program, language));
    scope.insert("PREFIX", Value::Text(prefix.to_ascii_uppercase()));
    scope.insert("prefix", Value::Text(prefix));
    let facts = facts.iter().map(|(name, text)| {
        let fact = language.comment(&format!("{name}: {text}"));
        Scope::from([("fact", Value::Text(fact))])
    });
    scope.insert("facts", Value::List(facts.collect()));
    render(language.template(), &scope)
}

fn text(value: impl ToString) -> Value {
    Value::Text(value.to_string())
}

/// Counts, flags, and what an update costs.
fn sizes(program: &Program, rate_hz: u64, language: Language) -> Scope {
    let n_gauges = program.centre.len();
    let mut at_rate = String::new();
    let mut search_cost = String::new();
    if program.keeps_samples() {
        at_rate = format!(" at {rate_hz} Hz");
    }
    if !program.look_backs.is_empty() {
        write!(
            search_cost,
            " and, for each of {} look-back(s), a search that skips boxes of 256 and 16 samples: about 10 to 100 steps, never more \
             than the samples in {} s",
            program.look_backs.len(),
            program.window_secs()
        )
        .expect("writing to a text cannot fail");
    }
    let state_bytes = |real| state_bytes(program, rate_hz, real);
    Scope::from([
        ("n_gauges", text(n_gauges)),
        ("n_axes", text(program.conventional.base.len())),
        ("n_columns", text(program.n_columns)),
        ("n_look_backs", text(program.look_backs.len())),
        ("n_measured", text(program.measured.len())),
        ("ring", Value::Flag(program.keeps_samples())),
        ("look_back", Value::Flag(!program.look_backs.is_empty())),
        ("appends", Value::Flag(program.n_columns > n_gauges)),
        ("window_secs", text(format!("{:?}", program.window_secs()))),
        ("window_ms", text(window_ms(program))),
        ("rate_hz", text(rate_hz)),
        ("leap_secs", text(format!("{LEAP_SECS:?}"))),
        ("strays", text(STRAYS)),
        ("products", text(program.n_products())),
        ("search_cost", Value::Text(language.comment(&search_cost))),
        ("at_rate", Value::Text(at_rate)),
        ("bytes_double", text(state_bytes(8))),
        ("bytes_float", text(state_bytes(4))),
    ])
}

fn window_ms(program: &Program) -> u64 {
    (program.window_secs() * 1000.0).ceil() as u64
}

/// The whole rate that is not below that of the recordings.
fn rate_hz(calibration: &Calibration) -> u64 {
    match calibration.rate_hz {
        // A clock's last digits must not make one more of it.
        Some(rate) => ((rate * (1.0 - 1e-6)).ceil()).clamp(1.0, HIGHEST_RATE_HZ) as u64,
        None => DEFAULT_RATE_HZ,
    }
}

/// How large a state is in C with numbers of `real` bytes: what the template declares, at this rate.
fn state_bytes(program: &Program, rate_hz: u64, real: usize) -> usize {
    let (n_gauges, n_axes) = (program.centre.len(), program.conventional.base.len());
    let in_window = (window_ms(program) * rate_hz).div_ceil(1000) as usize;
    let boxes = match program.keeps_samples() {
        true => (in_window * 17 / 16 + 2).div_ceil(256) + 1,
        false => 0,
    };
    let mut of_sample = 8 + real * n_gauges;
    let mut of_box = 0;
    if !program.look_backs.is_empty() {
        of_sample += real * program.measured.len();
        of_box = 17 * 2 * real * program.measured.len();
    }
    let memory = program.blocks.iter().flat_map(|(_, block)| &block.memory);
    let of_blocks = memory.map(|memory| {
        let bytes = match memory.precision {
            Precision::Real => real,
            Precision::Double | Precision::Index => 8,
        };
        bytes * memory.sets * if memory.of_gauges { n_gauges } else { 1 }
    });
    32 + 4 * real * n_axes + boxes * (256 * of_sample + of_box) + of_blocks.sum::<usize>()
}

/// The numbers of the look-back, and where gauges count from.
fn look_back(program: &Program, language: Language) -> Scope {
    let indices = program.measured.iter().map(|(axis, _)| axis.to_string());
    Scope::from([
        ("centre", language.numbers(&program.centre)),
        (
            "measured_weight",
            language.numbers(program.measured.iter().map(|(_, weight)| weight)),
        ),
        ("measured_axis", Value::Text(language.list(indices))),
        (
            "f_th_squared",
            language.numbers(program.look_backs.iter().map(|(squared, _)| squared)),
        ),
        (
            "t_th_secs",
            language.numbers(program.look_backs.iter().map(|(_, t_th)| t_th)),
        ),
    ])
}

fn linear(program: &Program, language: Language) -> Scope {
    let mut scope = Scope::from([
        ("conventional", language.rows(&program.conventional.matrix)),
        (
            "conventional_base",
            language.numbers(&program.conventional.base),
        ),
        ("linear", Value::Flag(program.linear.is_some())),
    ]);
    if let Some(Affine { matrix, base }) = &program.linear {
        scope.insert("linear_matrix", language.rows(matrix));
        scope.insert("linear_base", language.numbers(base));
    }
    scope
}

fn learned(program: &Program, language: Language) -> Scope {
    let mut scope = Scope::from([
        ("learned", Value::Flag(program.learned.is_some())),
        ("network", Value::Flag(false)),
        ("kernel", Value::Flag(false)),
        (
            "mutable",
            text(if program.learned.is_some() {
                "mut "
            } else {
                ""
            }),
        ),
    ]);
    let Some(LearnedProgram { inputs, regression }) = &program.learned else {
        return scope;
    };
    let factors = inputs.iter().map(|(factor, _)| factor);
    let constants = inputs.iter().map(|(_, constant)| constant);
    scope.insert("input_factor", language.numbers(factors));
    scope.insert("input_constant", language.numbers(constants));
    scope.extend(match regression {
        Learned::Network(network) => of_network(network, language),
        Learned::Kernel(kernel) => of_kernel(kernel, language),
    });
    scope
}

fn of_network(network: &Network, language: Language) -> Scope {
    let n_layers = network.layers.len();
    let widths = network.layers.iter().map(|layer| layer.biases.len());
    let widest = widths.chain([network.n_inputs()]).max().unwrap_or(0);
    let layers = network.layers.iter().enumerate().map(|(at, layer)| {
        let is_last = at + 1 == n_layers;
        Scope::from([
            ("layer", text(at)),
            ("inputs", text(n_inputs(layer))),
            ("outputs", text(layer.biases.len())),
            ("n_weights", text(n_inputs(layer) * layer.biases.len())),
            ("weights", language.weights(input_by_input(layer))),
            ("biases", language.weights(layer.biases.iter().copied())),
            ("rectified", language.flag(!is_last)),
            ("from", text(at % 2)),
            ("to", text((at + 1) % 2)),
        ])
    });
    Scope::from([
        ("network", Value::Flag(true)),
        ("layers", Value::List(layers.collect())),
        ("widest", text(widest)),
        ("answer", text(n_layers % 2)),
        ("target_scale", language.numbers(&network.target_scale)),
        ("target_shift", language.numbers(&network.target_shift)),
    ])
}

fn n_inputs(layer: &Layer) -> usize {
    layer.weights.first().map_or(0, Vec::len)
}

/// All weights from the first input, then those from the second, and so on.
pub(super) fn input_by_input(layer: &Layer) -> impl Iterator<Item = f32> + '_ {
    (0..n_inputs(layer)).flat_map(|input| layer.weights.iter().map(move |row| row[input]))
}

fn of_kernel(kernel: &Kernel, language: Language) -> Scope {
    let factor = -0.5 / (kernel.length_scale * kernel.length_scale);
    Scope::from([
        ("kernel", Value::Flag(true)),
        ("n_landmarks", text(kernel.landmarks.len())),
        ("landmarks", language.rows(&kernel.landmarks)),
        ("kernel_weights", language.rows(&kernel.weights)),
        ("kernel_offset", language.numbers(&kernel.offset)),
        ("kernel_factor", text(format!("{factor:?}"))),
    ])
}
