//! NumPy's `.npy`: one array of numbers or of records, read and written.
//!
//! **Source** NPY format, versions 1.0 to 3.0: magic bytes, length of the header, header (a Python literal), numbers.

use std::io::{BufReader, Read};

use super::arrays::{self, Array, Entry};
use super::columns::{Column, Columns};
use super::error::{FileError, reading};
use super::format::{COLUMN_LIMIT, Format, Source};
use super::number::{Field, FromOrigin, Number};
use crate::progress::Progress;

pub const FORMAT: Format =
    Format { name: "NumPy array", endings: &["npy"], signatures: &[MAGIC], read: columns };

const MAGIC: &[u8] = b"\x93NUMPY";
/// Maximum length of a file's header (bytes), so that a damaged file cannot fill the memory. Usual headers have a few hundred
/// bytes.
const HEADER_LIMIT: usize = 1 << 16;
/// Number of bytes that are read at a time. A longer record is read as a whole.
const BLOCK_BYTES: usize = 1 << 16;
const DEPTH_LIMIT: usize = 8;

/// Layout of one element of an array: one number, or the fields of a record.
#[derive(Debug, Default)]
struct Record {
    fields: Vec<Field>,
    /// Names of the fields that hold no numbers.
    left_out: Vec<String>,
    n_bytes: usize,
}

#[derive(Debug)]
struct Header {
    record: Record,
    is_records: bool,
    is_by_column: bool,
    shape: Vec<usize>,
}

#[derive(Debug)]
pub struct Content {
    /// The array of a file, or, if its elements are records, one array per field with the name of the field.
    pub arrays: Vec<Array>,
    pub is_records: bool,
    pub left_out: Vec<String>,
}

/// Reads a file as columns. The fields of records name their columns; the columns of a plain array have no names.
fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    const WHAT: &str = "the array";
    let mut file = BufReader::new(source.open()?);
    let mut content = read(WHAT, &mut file, source.n_bytes, source.progress)?;
    if content.is_records {
        let columns = arrays::columns(content.arrays, content.left_out);
        return Ok(Some(columns));
    }
    let array = content.arrays.remove(0);
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
        since: array.since,
        values: array.column(n_rows, n_columns, column),
        texts: None,
    });
    Ok(Some(Columns { columns: columns.collect(), ..Columns::default() }))
}

pub fn read(
    name: &str,
    from: &mut impl Read,
    at_most_bytes: u64,
    progress: &Progress,
) -> Result<Content, FileError> {
    let header = header(name, from)?;
    let n_bytes =
        header.shape.iter().try_fold(header.record.n_bytes, |n, &length| n.checked_mul(length));
    let Some(n_bytes) = n_bytes.filter(|n_bytes| *n_bytes as u64 <= at_most_bytes) else {
        return Err(FileError::cut_short(name));
    };
    let values = numbers(name, &header.record, n_bytes, from, progress)?;
    let array = |(mut field, values): (Field, FromOrigin)| {
        if !header.is_records {
            name.clone_into(&mut field.name);
        }
        Array {
            is_by_column: header.is_by_column && field.n_each == 1,
            ..field.array(&header.shape, values)
        }
    };
    let fields = header.record.fields.into_iter();
    Ok(Content {
        arrays: fields.zip(values).map(array).collect(),
        is_records: header.is_records,
        left_out: header.record.left_out,
    })
}

fn numbers(
    name: &str,
    record: &Record,
    n_bytes: usize,
    from: &mut impl Read,
    progress: &Progress,
) -> Result<Vec<FromOrigin>, FileError> {
    let at_a_time = (BLOCK_BYTES / record.n_bytes).max(1) * record.n_bytes;
    // Memory grows with the bytes that are read, because a wrong header may declare any size.
    let mut block = Vec::new();
    let mut values = vec![FromOrigin::default(); record.fields.len()];
    for start in (0..n_bytes).step_by(at_a_time) {
        progress.check()?;
        let n_next = at_a_time.min(n_bytes - start);
        block.clear();
        let n_read = from.by_ref().take(n_next as u64).read_to_end(&mut block);
        if n_read.map_err(reading(name))? < n_next {
            return Err(FileError::cut_short(name));
        }
        for (field, values) in record.fields.iter().zip(&mut values) {
            field.append(&block, record.n_bytes, values);
        }
    }
    Ok(values)
}

fn header(name: &str, from: &mut impl Read) -> Result<Header, FileError> {
    let damaged = |why: &str| FileError::damaged(name, why);
    let mut start = [0; 8];
    from.read_exact(&mut start).map_err(reading(name))?;
    if !start.starts_with(MAGIC) {
        return Err(damaged("it does not start with the first bytes of a NumPy array"));
    }
    let mut length = [0; 4];
    let length_bytes = if start[6] == 1 { 2 } else { 4 };
    from.read_exact(&mut length[..length_bytes]).map_err(reading(name))?;
    let n_bytes = u32::from_le_bytes(length) as usize;
    if n_bytes > HEADER_LIMIT {
        return Err(damaged("its header is too long for an array of numbers"));
    }
    let mut text = vec![0; n_bytes];
    from.read_exact(&mut text).map_err(reading(name))?;
    // NumPy writes UTF-8 only in version 3.0; before, names such as "T [°C]" are in Latin-1.
    let text = String::from_utf8(text)
        .unwrap_or_else(|other| other.into_bytes().into_iter().map(char::from).collect());
    let value = |key: &str| Some(Literal(text.split_once(&format!("'{key}':"))?.1));
    let (Some(mut descr), Some(order), Some(mut shape)) =
        (value("descr"), value("fortran_order"), value("shape"))
    else {
        return Err(damaged("its header does not give data type, order of values and shape"));
    };
    let not_numbers =
        |kind: &str| FileError::NotNumbers { what: name.to_owned(), kind: kind.to_owned() };
    // An array of Python objects is stored as a pickle, which is refused.
    if text.contains("'|O'") {
        return Err(not_numbers("Python objects"));
    }
    let shape = shape.lengths().ok_or_else(|| damaged("the shape in its header cannot be read"))?;
    let is_records = descr.0.trim_start().starts_with('[');
    let record =
        descr.record(0).ok_or_else(|| damaged("the data type in its header cannot be read"))?;
    if record.fields.is_empty() {
        return Err(match (is_records, record.left_out.first()) {
            (false, Some(kind)) => not_numbers(kind),
            _ => not_numbers("records without numbers"),
        });
    }
    Ok(Header { record, is_records, is_by_column: order.0.trim_start().starts_with("True"), shape })
}

/// Python literal of a file's header, from the next unread character on.
struct Literal<'a>(&'a str);

impl<'a> Literal<'a> {
    /// Skips the character `mark` and returns true, if it comes next.
    fn has(&mut self, mark: char) -> bool {
        let rest = self.0.trim_start().strip_prefix(mark);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    fn expect(&mut self, mark: char) -> Option<()> {
        self.has(mark).then_some(())
    }

    fn text(&mut self) -> Option<&'a str> {
        let rest = self.0.trim_start();
        let quote = rest.chars().next().filter(|mark| "'\"".contains(*mark))?;
        let (text, rest) = rest[1..].split_once(quote)?;
        self.0 = rest;
        Some(text)
    }

    fn lengths(&mut self) -> Option<Vec<usize>> {
        let inside = self.0.trim_start().strip_prefix('(')?;
        let (inside, rest) = inside.split_once(')')?;
        self.0 = rest;
        inside
            .split(',')
            .map(str::trim)
            .filter(|length| !length.is_empty())
            .map(|length| length.parse().ok())
            .collect()
    }

    /// Reads a NumPy data type: a kind such as `<f8`, or a list of fields `(name, kind)` or `(name, kind, shape)`. The name
    /// may be `(title, name)`.
    fn record(&mut self, depth: usize) -> Option<Record> {
        if !self.has('[') {
            return of_kind(self.text()?);
        }
        let mut record = Record::default();
        while !self.has(']') {
            self.expect('(').filter(|()| depth < DEPTH_LIMIT)?;
            let has_title = self.has('(');
            let mut name = self.text()?;
            if has_title {
                self.expect(',')?;
                name = self.text()?;
                self.expect(')')?;
            }
            self.expect(',')?;
            let is_record = self.0.trim_start().starts_with('[');
            let inner = self.record(depth + 1)?;
            let lengths = if self.has(',') { self.lengths()? } else { Vec::new() };
            self.expect(')')?;
            self.has(',');
            let n_each = lengths.into_iter().try_fold(1, usize::checked_mul)?;
            let start = record.n_bytes;
            record.n_bytes = start.checked_add(inner.n_bytes.checked_mul(n_each)?)?;
            let within = |what: &str| {
                if is_record { format!("{name}.{what}") } else { format!("{name} ({what})") }
            };
            if name.is_empty() {
                // A field without a name is padding between other fields.
            } else if n_each != 1 && is_record {
                record.left_out.push(format!("{name} (lists of records)"));
            } else if n_each > 0 && record.fields.len() + inner.fields.len() <= COLUMN_LIMIT {
                record.left_out.extend(inner.left_out.iter().map(|what| within(what)));
                record.fields.extend(inner.fields.into_iter().map(|field| Field {
                    name: if is_record { within(&field.name) } else { name.to_owned() },
                    offset: start + field.offset,
                    n_each: field.n_each * n_each,
                    ..field
                }));
            }
        }
        Some(record)
    }
}

/// Returns the layout of one element of this NumPy kind, without a field if the element is no number. Returns `None` if the
/// size of the element is unknown.
fn of_kind(kind: &str) -> Option<Record> {
    let is_big_endian = kind.starts_with('>');
    let kind = kind.trim_start_matches(['<', '>', '|', '=']);
    let letter = kind.chars().next()?;
    let size = &kind[letter.len_utf8()..];
    let (size, unit) = size.split_once('[').unwrap_or((size, ""));
    let size: usize = size.parse().ok()?;
    let unit =
        ["s", "ms", "us", "ns"].into_iter().find(|known| unit.strip_suffix(']') == Some(known));
    let number = match (letter, size, unit) {
        ('b', 1, _) => Some(Number::Uint(1)),
        ('M' | 'm', 8, Some(_)) => Some(Number::Time),
        _ => Number::of_kind(letter, size),
    };
    let other = match letter {
        _ if number.is_some() => None,
        'U' | 'S' => Some("texts".to_owned()),
        'c' => Some("complex numbers".to_owned()),
        _ => Some(format!("numbers of the data type {kind}")),
    };
    let field = number.map(|number| Field {
        name: String::new(),
        number,
        unit: unit.unwrap_or_default(),
        is_big_endian,
        offset: 0,
        n_each: 1,
    });
    let bytes_each = if letter == 'U' { 4 } else { 1 };
    Some(Record {
        left_out: other.into_iter().collect(),
        fields: field.into_iter().collect(),
        n_bytes: size.checked_mul(bytes_each)?,
    })
}

/// Returns the bytes of a file with one array: magic bytes, header padded to a multiple of 64 bytes, little-endian numbers or
/// characters.
pub fn written(entry: &Entry) -> Vec<u8> {
    let mut data = Vec::new();
    let (kind, shape) = match entry {
        Entry::Numbers(Array { shape, values, .. }) => {
            data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            let shape = match &shape[..] {
                [length] => format!("({length},)"),
                _ => format!("{shape:?}").replace('[', "(").replace(']', ")"),
            };
            ("<f8".to_owned(), shape)
        }
        Entry::Texts { texts, .. } => {
            let longest = texts.iter().map(|text| text.chars().count()).max();
            let width = longest.unwrap_or(0).max(1);
            for text in texts {
                data.extend(
                    text.chars()
                        .map(u32::from)
                        .chain(std::iter::repeat(0))
                        .take(width)
                        .flat_map(u32::to_le_bytes),
                );
            }
            (format!("<U{width}"), format!("({},)", texts.len()))
        }
    };
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let unpadded = 10 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    let length = u16::try_from(header.len()).expect("a header has a few hundred bytes");
    [MAGIC, b"\x01\x00", &length.to_le_bytes()[..], header.as_bytes(), &data].concat()
}
