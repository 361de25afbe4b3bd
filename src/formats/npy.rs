//! NumPy's `.npy`: one array, read and written.
//!
//! **Source** the NPY format, versions 1.0 to 3.0: magic, length of the header, the header (a Python literal), the
//! numbers.

use std::io::{BufReader, Read};

use super::arrays::{Array, Entry};
use super::columns::{Column, Columns};
use super::error::{FileError, reading};
use super::format::{COLUMN_LIMIT, Format, Source};
use crate::progress::Progress;

pub(super) const FORMAT: Format = Format {
    name: "NumPy array",
    endings: &["npy"],
    signatures: &[MAGIC],
    read: columns,
};

const MAGIC: &[u8] = b"\x93NUMPY";
/// Headers of plain arrays are some hundred bytes.
const HEADER_LIMIT: usize = 1 << 16;
/// Numbers read at a time.
const BLOCK_NUMBERS: usize = 1 << 13;
/// What a NumPy time that is none is stored as.
const NOT_A_TIME: i64 = i64::MIN;

/// The numbers of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Float(usize),
    Int(usize),
    Uint(usize),
    Time,
}

impl Number {
    pub(super) const fn n_bytes(self) -> usize {
        match self {
            Self::Float(n_bytes) | Self::Int(n_bytes) | Self::Uint(n_bytes) => n_bytes,
            Self::Time => 8,
        }
    }

    /// The value of so many bytes, the least first.
    pub(super) fn value(self, bytes: &[u8]) -> f64 {
        let mut eight = [0; 8];
        eight[..bytes.len()].copy_from_slice(bytes);
        let unsigned = u64::from_le_bytes(eight);
        let shift = 64 - 8 * bytes.len() as u32;
        let signed = (unsigned << shift) as i64 >> shift;
        match self {
            Self::Uint(_) => unsigned as f64,
            Self::Time if signed == NOT_A_TIME => f64::NAN,
            Self::Int(_) | Self::Time => signed as f64,
            Self::Float(2) => half(unsigned as u16),
            Self::Float(4) => f64::from(f32::from_bits(unsigned as u32)),
            Self::Float(_) => f64::from_bits(unsigned),
        }
    }
}

/// A number of two bytes: a sign, 5 bits of exponent, 10 of fraction (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let fraction = f64::from(bits & 0x3ff);
    let size = match bits >> 10 & 0x1f {
        0 => fraction * 2_f64.powi(-24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        exponent => (1.0 + fraction / 1024.0) * 2_f64.powi(i32::from(exponent) - 15),
    };
    sign * size
}

#[derive(Debug)]
struct Header {
    number: Number,
    unit: &'static str,
    is_big_endian: bool,
    is_by_column: bool,
    shape: Vec<usize>,
}

/// A lone array: its columns have no names.
fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    const WHAT: &str = "the array";
    let mut file = BufReader::new(source.open()?);
    let array = read(WHAT, &mut file, source.n_bytes, source.progress)?;
    let (n_rows, n_columns) = match array.shape[..] {
        [n_rows] => (n_rows, 1),
        [n_rows, n_columns] if n_columns <= COLUMN_LIMIT => (n_rows, n_columns),
        _ => {
            return Err(FileError::NotATable {
                what: WHAT.to_owned(),
                shape: format!("{:?}", array.shape),
            });
        }
    };
    let columns = (0..n_columns).map(|column| Column {
        name: String::new(),
        unit: array.unit.to_owned(),
        values: array.column(n_rows, n_columns, column),
        ..Column::default()
    });
    Ok(Some(Columns {
        columns: columns.collect(),
        ..Columns::default()
    }))
}

/// Reads one array, called `name`, from a stream that cannot give more than `at_most_bytes`.
pub(super) fn read(
    name: &str,
    from: &mut impl Read,
    at_most_bytes: u64,
    progress: &Progress,
) -> Result<Array, FileError> {
    let header = header(name, from)?;
    let n_numbers = header
        .shape
        .iter()
        .try_fold(1_usize, |product, &length| product.checked_mul(length));
    let n_bytes = |n: usize| n.checked_mul(header.number.n_bytes());
    let Some(n_numbers) =
        n_numbers.filter(|&n| n_bytes(n).is_some_and(|b| b as u64 <= at_most_bytes))
    else {
        return Err(FileError::CutShort {
            what: name.to_owned(),
        });
    };
    Ok(Array {
        name: name.to_owned(),
        unit: header.unit,
        values: numbers(&header, n_numbers, from, progress).map_err(|error| match error {
            FileError::Io(error) => reading(name)(error),
            other => other,
        })?,
        shape: header.shape,
        is_by_column: header.is_by_column,
        labels: Vec::new(),
    })
}

fn numbers(
    header: &Header,
    n_numbers: usize,
    from: &mut impl Read,
    progress: &Progress,
) -> Result<Vec<f64>, FileError> {
    let n_bytes = header.number.n_bytes();
    let mut block = vec![0; BLOCK_NUMBERS * n_bytes];
    // Grows with what is there; what the header says may be anything.
    let mut values = Vec::new();
    while values.len() < n_numbers {
        progress.check()?;
        let n_next = BLOCK_NUMBERS.min(n_numbers - values.len());
        let block = &mut block[..n_next * n_bytes];
        from.read_exact(block)?;
        if header.is_big_endian {
            block.chunks_exact_mut(n_bytes).for_each(<[u8]>::reverse);
        }
        values.extend(
            block
                .chunks_exact(n_bytes)
                .map(|bytes| header.number.value(bytes)),
        );
    }
    Ok(values)
}

fn header(name: &str, from: &mut impl Read) -> Result<Header, FileError> {
    let damaged = |why: &str| FileError::Damaged {
        what: name.to_owned(),
        why: why.to_owned(),
    };
    let mut start = [0; 8];
    from.read_exact(&mut start).map_err(reading(name))?;
    if !start.starts_with(MAGIC) {
        return Err(damaged("it does not start as a NumPy array"));
    }
    let n_bytes = if start[6] == 1 {
        let mut length = [0; 2];
        from.read_exact(&mut length).map_err(reading(name))?;
        usize::from(u16::from_le_bytes(length))
    } else {
        let mut length = [0; 4];
        from.read_exact(&mut length).map_err(reading(name))?;
        u32::from_le_bytes(length) as usize
    };
    if n_bytes > HEADER_LIMIT {
        return Err(damaged("its header is too long for an array of numbers"));
    }
    let mut text = vec![0; n_bytes];
    from.read_exact(&mut text).map_err(reading(name))?;
    let text = String::from_utf8_lossy(&text);
    let value = |key: &str| {
        let (_, rest) = text.split_once(&format!("'{key}':"))?;
        Some(rest.trim_start())
    };
    let (Some(descr), Some(order), Some(shape)) =
        (value("descr"), value("fortran_order"), value("shape"))
    else {
        return Err(damaged("its header names no kind, order or shape"));
    };
    let shape = shape_of(shape).ok_or_else(|| damaged("its shape is none"))?;
    let (number, unit, is_big_endian) = number_of(descr).ok_or_else(|| FileError::NotNumbers {
        what: name.to_owned(),
        kind: kind_in_words(descr),
    })?;
    Ok(Header {
        number,
        unit,
        is_big_endian,
        is_by_column: order.starts_with("True"),
        shape,
    })
}

fn shape_of(text: &str) -> Option<Vec<usize>> {
    let (inside, _) = text.strip_prefix('(')?.split_once(')')?;
    let lengths = inside.split(',').map(str::trim);
    let lengths = lengths.filter(|length| !length.is_empty());
    lengths.map(|length| length.parse().ok()).collect()
}

/// The kind of numbers, what a time counts, and whether the high byte comes first.
fn number_of(descr: &str) -> Option<(Number, &'static str, bool)> {
    let (kind, _) = descr.strip_prefix('\'')?.split_once('\'')?;
    let is_big_endian = kind.starts_with('>');
    let kind = kind.trim_start_matches(['<', '>', '|', '=']);
    let number = match kind {
        "f2" => Number::Float(2),
        "f4" => Number::Float(4),
        "f8" => Number::Float(8),
        "i1" => Number::Int(1),
        "i2" => Number::Int(2),
        "i4" => Number::Int(4),
        "i8" => Number::Int(8),
        "b1" | "u1" => Number::Uint(1),
        "u2" => Number::Uint(2),
        "u4" => Number::Uint(4),
        "u8" => Number::Uint(8),
        "M8[s]" | "m8[s]" | "M8[ms]" | "m8[ms]" | "M8[us]" | "m8[us]" | "M8[ns]" | "m8[ns]" => {
            Number::Time
        }
        _ => return None,
    };
    let units = [("[s]", "s"), ("[ms]", "ms"), ("[us]", "us"), ("[ns]", "ns")];
    let unit = units.iter().find(|(ending, _)| kind.ends_with(ending));
    Some((number, unit.map_or("", |(_, unit)| unit), is_big_endian))
}

fn kind_in_words(descr: &str) -> String {
    let kind = descr.trim_start_matches(['\'', '<', '>', '|', '=']);
    match kind.chars().next() {
        Some('O') => "Python objects".to_owned(),
        Some('U' | 'S') => "texts".to_owned(),
        Some('c') => "complex numbers".to_owned(),
        Some('[') => "records of several fields".to_owned(),
        _ => format!(
            "numbers of the kind {}",
            kind.split('\'').next().unwrap_or_default()
        ),
    }
}

/// The file of one array: magic, header padded to a multiple of 64 bytes, little-endian numbers or characters.
pub(super) fn written(entry: &Entry) -> Vec<u8> {
    let mut data = Vec::new();
    let (kind, shape) = match entry {
        Entry::Numbers(Array { shape, values, .. }) => {
            data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
            let shape = match shape.len() {
                1 => format!("({})", lengths.trim_end()),
                _ => format!("({})", lengths.trim_end_matches(", ")),
            };
            ("<f8".to_owned(), shape)
        }
        Entry::Texts { texts, .. } => {
            let longest = texts.iter().map(|text| text.chars().count()).max();
            let width = longest.unwrap_or(0).max(1);
            for text in texts {
                let codes = text.chars().map(u32::from).chain(std::iter::repeat(0));
                data.extend(codes.take(width).flat_map(u32::to_le_bytes));
            }
            (format!("<U{width}"), format!("({},)", texts.len()))
        }
    };
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let unpadded = 10 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    let length = u16::try_from(header.len()).expect("a header is some hundred bytes");
    [
        MAGIC,
        b"\x01\x00",
        &length.to_le_bytes()[..],
        header.as_bytes(),
        &data,
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of IEEE 754 binary16 as its table of examples gives them.
    #[test]
    fn numbers_of_two_bytes_are_those_of_the_standard() {
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 2_f64.powi(-24)),
            (0x0400, 2_f64.powi(-14)),
            (0x3555, 0.333_251_953_125),
            (0xfc00, f64::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), value, "{bits:#x}");
        }
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn signed_numbers_of_any_size_keep_their_sign() {
        assert_eq!(Number::Int(1).value(&[0xff]), -1.0);
        assert_eq!(Number::Int(2).value(&[0x00, 0x80]), -32768.0);
        assert_eq!(Number::Int(8).value(&(-5_i64).to_le_bytes()), -5.0);
        assert_eq!(Number::Uint(4).value(&[0xff; 4]), 4_294_967_295.0);
        assert!(Number::Time.value(&i64::MIN.to_le_bytes()).is_nan());
    }
}
