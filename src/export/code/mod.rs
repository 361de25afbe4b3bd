//! Calibrations as source code for machines without this program. All languages share one [`Program`] and its names. Each has
//! its own template and notation of numbers. Texts of the user appear only in comments, and are escaped so that they cannot
//! end a comment.

mod program;

use std::fmt;
use std::io;

use minijinja::value::{Serde, merge_maps};
use minijinja::{State, Value, context};

pub(in crate::export) use self::program::Program;
use crate::{
    calibration::{Calibration, Learned, STRAYS, Status, network::Layer},
    export::{
        target::{Export, Target},
        template::environment,
        text::identifier,
    },
    features::{MOST_RISE, Numbers, Precision},
    recording::gap::{LEAP_SECS, WRAPS_SECS},
    shown::{joined, printable},
};

/// Maximum time that exported code looks back (s), which limits its memory. A longer step in time counts as a reset of the
/// clock, which no look-back crosses.
const LONGEST_WINDOW_SECS: f64 = LEAP_SECS;

/// Explanations of the sample's status flags, for the comments of the code in every language.
const STATUSES: &str = include_str!("../templates/statuses.txt");

#[derive(Clone, Copy)]
pub(in crate::export) struct Language {
    pub template: &'static str,
    /// Escapes a text of the user for a comment of the language.
    pub comment: fn(&str) -> String,
    /// Opening and closing bracket of lists in the language.
    pub brackets: (char, char),
    /// Separator where a list of numbers continues in the next line, and separator between the rows of a matrix.
    pub breaks: (&'static str, &'static str),
    pub number: fn(f64) -> String,
    pub time: fn(f64) -> String,
    /// Writes a single-precision weight so that every language reads exactly this number.
    pub weight: fn(f32) -> String,
    /// Returns true if the language reserves a name, or if the code already uses the name. The arguments are the name and the
    /// code.
    pub is_taken: fn(&str, &str) -> bool,
}

pub(in crate::export) const CODE: Target = Target {
    holds: "conventional and compensated load with all feature blocks",
    leaves_out: |calibration| match calibration.learned {
        Some(Learned::Kernel(_)) => "the uncertainty band of the kernel",
        _ => "nothing",
    },
    refusal: |outline| {
        let window_secs = outline.features.window_secs();
        let too_long = format!(
            "the blocks look back {window_secs} s, so exported code would have to store all samples of this time \
             (at most {LONGEST_WINDOW_SECS} s); fit with a smaller t_th or lag, or use .json"
        );
        (window_secs > LONGEST_WINDOW_SECS).then_some(too_long)
    },
    ..Target::PLAIN
};

impl Language {
    /// Language with Rust's notation of numbers and without reserved names, from which the others differ.
    pub const PLAIN: Self = Self {
        template: "",
        comment: |text| printable(text).into_owned(),
        brackets: ('[', ']'),
        breaks: (",\n    ", ",\n    "),
        number: plain,
        time: plain,
        weight: |weight| format!("{:?}", f64::from(weight)),
        is_taken: |_, _| false,
    };

    pub fn write(self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        out.write_all(self.source(export).1.as_bytes())
    }

    /// Returns the identifier of the calibration in the exported code, and this code.
    pub fn source(self, export: &Export<'_>) -> (String, String) {
        let mut name = identifier(export.name);
        let mut code = named_code(export, self, &name);
        if (self.is_taken)(&name, &code) {
            name = format!("cal_{name}");
            code = named_code(export, self, &name);
        }
        (name, code)
    }

    fn list(self, items: impl IntoIterator<Item = String>) -> String {
        const PER_LINE: usize = 6;
        let ((open, close), (goes_on, _)) = (self.brackets, self.breaks);
        let mut out = String::from(open);
        for (at, item) in items.into_iter().enumerate() {
            out.push_str(match at {
                0 => "",
                at if at % PER_LINE == 0 => goes_on,
                _ => ", ",
            });
            out.push_str(&item);
        }
        out.push(close);
        out
    }

    fn numbers(self, values: &[f64]) -> String {
        self.list(values.iter().map(|value| (self.number)(*value)))
    }

    fn rows(self, rows: &[Vec<f64>]) -> String {
        let ((open, close), (_, between)) = (self.brackets, self.breaks);
        let rows = joined(between, rows.iter().map(|row| self.numbers(row)));
        format!("{open}\n    {rows}\n{close}")
    }

    fn fill(self, values: Value) -> Result<String, minijinja::Error> {
        let mut templates = environment(true);
        templates.add_filter("comment", move |text: String| (self.comment)(&text));
        templates.add_filter("plain", plain);
        templates.add_filter("number", move |value: f64| (self.number)(value));
        templates.add_filter("numbers", move |values: Vec<f64>| self.numbers(&values));
        templates.add_filter("time", move |value: f64| (self.time)(value));
        templates.add_filter("times", move |values: Vec<f64>| {
            self.list(values.into_iter().map(self.time))
        });
        templates.add_filter("rows", move |rows: Vec<Vec<f64>>| self.rows(&rows));
        templates.add_filter("weights", move |weights: Vec<f32>| {
            self.list(weights.into_iter().map(self.weight))
        });
        templates.add_filter("indices", move |indices: Vec<usize>| {
            self.list(indices.iter().map(usize::to_string))
        });
        templates.add_filter("filled", filled);
        let statuses = templates.render_str(STATUSES, &values)?;
        let statuses: Vec<String> = statuses.lines().map(str::to_owned).collect();
        templates.render_str(self.template, context! { statuses, ..values })
    }
}

/// Fills the template of a feature block's source code with the names of the program and the number of the block's values.
fn filled(state: &State<'_, '_>, text: &str, sets: usize) -> Result<String, minijinja::Error> {
    let names = context! {
        prefix => state.lookup("prefix"),
        PREFIX => state.lookup("PREFIX"),
        n_gauges => state.lookup("n_gauges"),
        n_auxiliary => state.lookup("n_auxiliary"),
        fades => state.lookup("fades"),
        most_rise => MOST_RISE,
        sets,
    };
    state.env().render_str(text.trim_matches('\n'), names)
}

fn plain(value: f64) -> String {
    format!("{value:?}")
}

/// Returns the filled template of a language. The template reads the fields of [`Program`], and the numbers that are computed
/// here.
fn named_code(export: &Export<'_>, language: Language, prefix: &str) -> String {
    let program = Program::new(export.calibration);
    let mut search_cost = String::new();
    if !program.look_backs.is_empty() {
        search_cost = format!(
            " and, for each of {} look-back(s), a search that skips boxes of 256 and 16 samples: at most {} boxes and 30 samples",
            program.look_backs.len(),
            program.ring_samples() / 16
        );
    }
    let any_block_has =
        |word| program.blocks.iter().any(|block| block.source.rust.update.contains(word));
    let counted = context! {
        PREFIX => prefix.to_ascii_uppercase(),
        prefix,
        facts => export.lines(str::to_owned).collect::<Vec<_>>(),
        n_gauges => program.centre.len(),
        n_auxiliary => program.auxiliary.len(),
        n_axes => program.conventional.base.len(),
        ring => program.keeps_samples(),
        uses_dt => program.keeps_samples() || any_block_has("started"),
        uses_exp => any_block_has("exp_m1"),
        kept => kept(export.calibration),
        window_ms => (program.window_secs * 1000.0).ceil() as u64,
        ring_samples => program.ring_samples(),
        wraps_secs => WRAPS_SECS,
        leap_secs => LEAP_SECS,
        strays => STRAYS,
        most_rise => MOST_RISE,
        flags => Status::EXPORTED.map(|(name, flag)| (name, flag.bits())),
        products => program.n_products(),
        search_cost,
        bytes_double => state_bytes(&program, 8),
        bytes_float => state_bytes(&program, 4),
    };
    let learned = program.learned.as_ref().map_or_else(
        || context! { network => (), kernel => () },
        |learned| of_learned(&learned.regression),
    );
    language
        .fill(merge_maps([Serde(&program).into(), counted, learned]))
        .expect("the templates are this program's own")
}

/// Returns a line for each memory that is kept through pauses which are longer than a gap.
fn kept(calibration: &Calibration) -> Vec<String> {
    let memories = calibration.features.memories().into_iter();
    let longest = memories.map(|memory| (memory, calibration.keep_secs_of(memory)));
    let kept = longest.filter(|(_, secs)| *secs > calibration.gap_secs);
    let kept: Vec<_> = kept.collect();
    let end = |at| if at + 1 == kept.len() { "." } else { "," };
    let line = |(at, (memory, secs)): (usize, &(&str, f64))| {
        format!("{memory} up to {secs:?} s{}", end(at))
    };
    kept.iter().enumerate().map(line).collect()
}

fn of_learned(learned: &Learned) -> Value {
    match learned {
        Learned::Network(network) => {
            let widths = network.layers.iter().map(|layer| layer.biases.len());
            let layers = network.layers.iter().map(|layer| {
                context! {
                    inputs => n_inputs(layer),
                    weights => input_by_input(layer).collect::<Vec<_>>(),
                    biases => layer.biases.clone(),
                }
            });
            context! {
                network => Serde(network),
                kernel => (),
                widest => widths.chain([network.n_inputs()]).max(),
                layers => layers.collect::<Vec<_>>(),
            }
        }
        Learned::Kernel(kernel) => context! {
            network => (),
            kernel => Serde(kernel),
            kernel_factor => -0.5 / (kernel.length_scale * kernel.length_scale),
        },
    }
}

fn n_inputs(layer: &Layer) -> usize {
    layer.weights.first().map_or(0, Vec::len)
}

/// Returns the weights of a network layer by input: all weights of the first input, then all weights of the second, and so
/// on.
pub(in crate::export) fn input_by_input(layer: &Layer) -> impl Iterator<Item = f32> + '_ {
    (0..n_inputs(layer)).flat_map(|input| layer.weights.iter().map(move |row| row[input]))
}

/// Returns the memory that a calibration needs on a robot (bytes): constants and state in single precision, at the
/// recordings' sample rate.
pub(crate) fn bytes_in_float(calibration: &Calibration) -> usize {
    let program = Program::new(calibration);
    4 * calibration.n_coefficients() + state_bytes(&program, 4)
}

/// Memory that an exported calibration in C needs on a Cortex-M4F.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footprint {
    /// Size of the state of one sensor in single precision (bytes).
    pub memory: usize,
    /// Approximate size of the machine code and of the coefficients (bytes).
    pub program: usize,
}

impl Footprint {
    /// Returns true if the state is larger than the memory of many small controllers.
    pub fn is_large(self) -> bool {
        self.memory > 65_536
    }

    /// Returns the memory that this calibration needs.
    pub fn of(calibration: &Calibration) -> Self {
        let program = Program::new(calibration);
        Self {
            memory: state_bytes(&program, 4),
            program: 4 * n_constants(&program) + code_bytes(&program),
        }
    }
}

impl fmt::Display for Footprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kilobytes = |bytes: usize| format!("{:.1} kB", bytes as f64 / 1000.0);
        write!(
            f,
            "as C code in float on a Cortex-M4F: {} of memory per sensor, about {} of program",
            kilobytes(self.memory),
            kilobytes(self.program)
        )
    }
}

fn n_constants(program: &Program) -> usize {
    let (n_gauges, n_axes) = (program.centre.len(), program.conventional.base.len());
    let of_blocks =
        program.blocks.iter().flat_map(|block| &block.source.constants).map(|constant| {
            match &constant.numbers {
                Numbers::List(numbers) => numbers.len(),
                Numbers::Rows(rows) => rows.iter().map(Vec::len).sum(),
            }
        });
    let mut n = 2 * n_gauges + n_axes * (n_gauges + 2) + 2 + of_blocks.sum::<usize>();
    if program.keeps_samples() {
        n += 2;
    }
    if !program.look_backs.is_empty() {
        n += 2 * (program.measured.len() + program.look_backs.len());
    }
    if program.linear.is_some() {
        n += n_axes * (program.n_columns + 1);
    }
    if let Some(learned) = &program.learned {
        n += 2 * program.n_columns + learned.regression.n_numbers();
    }
    n
}

/// Returns the estimated size of the update function's machine code (bytes), as compiled with -O2. A test compares the
/// estimate with a compiler's output.
fn code_bytes(program: &Program) -> usize {
    let mut bytes = 460 + 230 * program.blocks.len();
    if program.keeps_samples() {
        bytes += 400;
    }
    if !program.look_backs.is_empty() {
        bytes += 1200;
    }
    if program.learned.is_some() {
        bytes += 600;
    }
    bytes
}

/// Returns the size of a sensor's state in C (bytes), as the template declares it. `real` is the size of a number (bytes).
pub(in crate::export) fn state_bytes(program: &Program, real: usize) -> usize {
    let (n_gauges, n_axes) = (program.centre.len(), program.conventional.base.len());
    let clock = real; // as wide as a number, in single and in double precision
    let memory = program.blocks.iter().flat_map(|block| &block.source.memory);
    let of_blocks = memory.map(|memory| {
        let bytes = match memory.precision {
            Precision::Real => real,
            Precision::Clock => clock,
            Precision::Index => 4,
        };
        bytes * memory.sets * if memory.of_gauges { n_gauges } else { 1 }
    });
    let mut bytes = 2 * 8
        + 4
        + clock
        + 2 * 4
        + real * (1 + 2 * usize::from(program.fades) + 4 * n_axes + n_gauges)
        + of_blocks.sum::<usize>();
    if program.keeps_samples() {
        let ring = program.ring_samples();
        bytes += 2 * clock + 4 * 4 + ring * (clock + real * n_gauges);
        if !program.look_backs.is_empty() {
            let of_point = real * program.measured.len();
            bytes += ring * of_point + (ring / 16 + ring / 256) * 2 * of_point;
        }
    }
    bytes.next_multiple_of(8)
}
