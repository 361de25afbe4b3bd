//! Parsers of argument values on the command line.

use std::error::Error;
use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PathBufValueParser, PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::features::Range;

/// Returns a parser of file names that rejects "-", which stands for standard input or output.
pub fn named_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        if path.as_os_str() == "-" {
            Err("standard input and output cannot be used here; name a file")
        } else {
            Ok(path)
        }
    })
}

/// Returns a parser of file names that accepts only these endings, of which the first is the usual one.
pub fn file_in(endings: &'static [&'static str]) -> impl TypedValueParser<Value = PathBuf> {
    named_file().try_map(|path| {
        let ending = path.extension().unwrap_or_default();
        if endings.iter().any(|known| ending.eq_ignore_ascii_case(known)) {
            Ok(path)
        } else {
            Err(format!("choose a name that ends in .{}", endings[0]))
        }
    })
}

pub fn number_in(
    range: Range,
) -> impl Fn(&str) -> Result<f64, Box<dyn Error + Send + Sync>> + Clone + Send + Sync {
    move |text| {
        let number: f64 = text.trim().parse()?;
        if range.contains(number) { Ok(number) } else { Err(format!("this is not {range}").into()) }
    }
}

#[derive(Clone, Debug)]
pub struct List(pub Vec<f64>);

impl FromStr for List {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::split(text, ',')
    }
}

impl List {
    pub fn split(text: &str, separator: char) -> Result<Self, String> {
        let number = |cell: &str| {
            let wrong = || format!("{cell:?} is not a number; write numbers separated by commas");
            cell.parse().map_err(|_| wrong())
        };
        text.split(separator).map(str::trim).map(number).collect::<Result<_, _>>().map(Self)
    }
}

/// Returns a parser that accepts only the names in `all`. Each entry is the parsed value, its name, and its explanation for
/// the help text.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = (T, &'static str, &'static str)>,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<_> = all.into_iter().collect();
    let names =
        all.iter().map(|(_, name, explanation)| PossibleValue::new(*name).help(*explanation));
    let parser = PossibleValuesParser::new(names.collect::<Vec<_>>());
    parser.map(move |name| {
        let named = all.iter().find(|(_, known, _)| *known == name);
        named.expect("no other name passes").0
    })
}
