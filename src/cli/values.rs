//! How single values are written on the command line.

use std::error::Error;
use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PathBufValueParser, PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::features::Range;

/// A file's name; nothing is read from standard input or written to standard output in place of one.
pub fn named_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.as_os_str() == "-" {
        true => Err("standard input and output do not do here; name a file"),
        false => Ok(path),
    })
}

/// Takes a number in this range.
pub fn number_in(
    range: Range,
) -> impl Fn(&str) -> Result<f64, Box<dyn Error + Send + Sync>> + Clone + Send + Sync {
    move |text| {
        let number: f64 = text.trim().parse()?;
        match range.contains(number) {
            true => Ok(number),
            false => Err(format!("this is not {range}").into()),
        }
    }
}

/// Numbers with commas between them.
#[derive(Clone, Debug, PartialEq)]
pub struct List(pub Vec<f64>);

impl FromStr for List {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.split(',')
            .map(|cell| {
                let cell = cell.trim();
                cell.parse().map_err(|_| {
                    format!("{cell:?} is not a number; write numbers with commas between them")
                })
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

/// Takes one of a few things by its name; the last of each says what it is.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = (T, &'static str, &'static str)>,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<_> = all.into_iter().collect();
    let names =
        all.iter().map(|(_, name, explanation)| PossibleValue::new(*name).help(*explanation));
    let parser = PossibleValuesParser::new(names.collect::<Vec<_>>());
    parser.map(move |name| {
        let named = all.iter().find(|(_, own, _)| *own == name);
        named.expect("no other name passes").0
    })
}
