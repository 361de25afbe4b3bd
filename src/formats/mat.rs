//! Reads numeric matrices of MATLAB files (`.mat`, versions 4 and 5), also compressed ones and those in structs. Writes
//! version 5 without compression.
//!
//! **Source** MAT-File Format (The MathWorks). Level 5: a header of 128 bytes, then one element per variable: a kind, a
//! length and that number of bytes. A matrix is an element made of elements: class, dimensions, name, numbers. Numbers may
//! be stored in a smaller kind than their class. Level 4: five integers per variable, then its name and its numbers. The
//! decimal digits of the first integer mean: 1000 for big-endian, 10 for each step in the list of kinds, 1 for text, 2 for
//! a sparse matrix.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

use super::arrays::{Array, Entry};
use super::columns::Columns;
use super::error::{FileError, reading};
use super::format::{Budget, COLUMN_LIMIT, Format, Source};
use super::hdf5;
use super::number::Number;
use super::parts::{self, Group};

pub(super) const FORMAT: Format = Format {
    name: "MATLAB file",
    endings: &["mat"],
    signatures: &[
        b"MATLAB 5.0",
        NEWER,
        // First bytes of files of version 4: the first integer in the header of a variable.
        b"\x00\0\0\0",
        b"\x01\0\0\0",
        b"\x02\0\0\0",
        b"\x0a\0\0\0",
        b"\x0b\0\0\0",
        b"\x0c\0\0\0",
        b"\x14\0\0\0",
        b"\x15\0\0\0",
        b"\x16\0\0\0",
        b"\x1e\0\0\0",
        b"\x1f\0\0\0",
        b"\x20\0\0\0",
        b"\x28\0\0\0",
        b"\x29\0\0\0",
        b"\x2a\0\0\0",
        b"\x32\0\0\0",
        b"\x33\0\0\0",
        b"\x34\0\0\0",
        b"\0\0\x03",
        b"\0\0\x04",
    ],
    read: columns,
};

/// First bytes of a file of version 7.3, which is HDF5.
const NEWER: &[u8] = b"MATLAB 7.3";

const HEADER_BYTES: usize = 128;
const MI_INT8: u32 = 1;
const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const MI_DOUBLE: u32 = 9;
const MI_UTF16: u32 = 17;
const MX_CHAR: u32 = 4;
const MX_DOUBLE: u32 = 6;
const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;
const COMPLEX_FLAG: u32 = 0x0800;
const FILE: &str = "the file";

fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    if source.head.starts_with(NEWER) {
        return (hdf5::FORMAT.read)(source).map_err(|error| match error {
            FileError::Hdf5 { why } => FileError::Mat73 { why },
            FileError::NotBuilt { feature, .. } => FileError::Mat73 {
                why: format!("this program was built without the feature `{feature}`"),
            },
            other => other,
        });
    }
    let is_old = !source.head.starts_with(b"MATLAB");
    if is_old && OlderHeader::read(source.head).is_none() {
        return Ok(None);
    }
    let mut file = Vec::new();
    source.open()?.read_to_end(&mut file)?;
    let (mut top, mut groups) = (Fields::default(), vec![Group::default()]);
    if is_old {
        older(&file, source, &mut top)?;
    } else {
        newer(&file, source, &mut top, &mut groups)?;
    }
    groups[0].arrays = top.arrays;
    parts::of_groups(groups, '.', top.left_out, source.parts).map(Some)
}

/// Reads the variables of a file of version 5. Each struct becomes a group of its own.
fn newer(
    file: &[u8],
    source: &Source<'_>,
    top: &mut Fields,
    groups: &mut Vec<Group>,
) -> Result<(), FileError> {
    let Some((header, bytes)) = file.split_at_checked(HEADER_BYTES) else {
        return Err(FileError::cut_short(FILE));
    };
    let is_big_endian = header.ends_with(b"MI");
    if !is_big_endian && !header.ends_with(b"IM") {
        let why = "its header does not tell whether numbers are little-endian or big-endian";
        return Err(FileError::damaged(FILE, why));
    }
    let mut variables = Elements { bytes, is_big_endian };
    while !variables.bytes.is_empty() {
        source.progress.check()?;
        let compressed;
        let mut matrix = variables.next(FILE)?;
        if let (MI_COMPRESSED, bytes) = matrix {
            compressed = unpacked(bytes)?;
            matrix = Elements { bytes: &compressed, is_big_endian }.next(FILE)?;
        }
        let (MI_MATRIX, bytes) = matrix else { continue };
        let (name, content) = content(Elements { bytes, is_big_endian }, None, 0)?;
        // A matrix without a name holds what objects and functions of the other variables need.
        if name.is_empty() && matches!(content, Content::Array(..)) {
            continue;
        }
        let Content::Struct(elements) = content else {
            top.take(name, content);
            continue;
        };
        let is_table = |fields: &Fields| fields.arrays.iter().any(|array| array.values.len() > 1);
        if !elements.iter().any(is_table) {
            top.leave_out(&name, "a struct");
            continue;
        }
        let is_single = elements.len() == 1;
        for (at, fields) in elements.into_iter().enumerate() {
            top.left_out.extend(fields.left_out.iter().map(|what| format!("{name}.{what}")));
            let name = if is_single { name.clone() } else { format!("{name}({})", at + 1) };
            groups.push(Group { name, arrays: fields.arrays });
        }
    }
    Ok(())
}

/// Header of one matrix in a MATLAB file of version 4.
struct OlderHeader {
    is_big_endian: bool,
    number: Number,
    /// 0 for numbers, 1 for text, 2 for a sparse matrix.
    class: u32,
    is_complex: bool,
    shape: [usize; 2],
    name: String,
    n_bytes: usize,
}

impl OlderHeader {
    fn read(bytes: &[u8]) -> Option<Self> {
        const NUMBERS: [Number; 6] = [
            Number::Float(8),
            Number::Float(4),
            Number::Int(4),
            Number::Int(2),
            Number::Uint(2),
            Number::Uint(1),
        ];
        // The digits of the first number say how the matrix is stored. In big-endian files they start with 1.
        let is_big_endian = bytes.starts_with(&[0, 0]) && bytes.get(2) != Some(&0);
        let parts = Elements { bytes, is_big_endian };
        let integers = bytes.get(..20)?.chunks_exact(4);
        let integers: Option<Vec<u32>> = integers.map(|part| parts.uint32(part)).collect();
        let [digits, n_rows, n_columns, is_complex @ (0 | 1), name_bytes] = integers?[..] else {
            return None;
        };
        let digits = digits.checked_sub(if is_big_endian { 1000 } else { 0 })?;
        let n_bytes = 20_usize.checked_add(name_bytes as usize)?;
        let name = bytes.get(20..n_bytes)?.split(|byte| *byte == 0).next()?;
        let is_of_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let is_name = !name.is_empty() && name.iter().all(is_of_name);
        (is_name && digits % 10 <= 2).then_some(Self {
            is_big_endian,
            number: *NUMBERS.get(digits as usize / 10)?,
            class: digits % 10,
            is_complex: is_complex == 1,
            shape: [n_rows as usize, n_columns as usize],
            name: String::from_utf8_lossy(name).into_owned(),
            n_bytes,
        })
    }
}

/// Reads the matrices of a MATLAB file of version 4.
fn older(file: &[u8], source: &Source<'_>, top: &mut Fields) -> Result<(), FileError> {
    let mut rest = file;
    while !rest.is_empty() {
        source.progress.check()?;
        let Some(header) = OlderHeader::read(rest) else {
            return Err(if rest.len() < HEADER_BYTES {
                FileError::cut_short(FILE)
            } else {
                FileError::damaged(FILE, "the data behind a matrix are not another matrix")
            });
        };
        let OlderHeader { shape: [n_rows, n_columns], name, .. } = header;
        let parts = 1 + usize::from(header.is_complex);
        let lengths = [n_rows, n_columns, header.number.n_bytes(), parts];
        let n_bytes = lengths.into_iter().try_fold(1, usize::checked_mul);
        let numbers = n_bytes.and_then(|n_bytes| rest[header.n_bytes..].get(..n_bytes));
        let numbers = numbers.ok_or_else(|| FileError::cut_short(&name))?;
        rest = &rest[header.n_bytes + numbers.len()..];
        let content = match header.class {
            1 => Content::Other("text"),
            2 => Content::Other("a sparse matrix"),
            _ if header.is_complex => Content::Other("complex numbers"),
            _ => {
                let values = header.number.all(numbers, header.is_big_endian);
                Content::Array(vec![n_rows, n_columns], values)
            }
        };
        top.take(name, content);
    }
    Ok(())
}

fn unpacked(packed: &[u8]) -> Result<Vec<u8>, FileError> {
    let mut budget = Budget::of_file(packed.len() as u64);
    let mut unpacked = Vec::new();
    ZlibDecoder::new(packed)
        .take(budget.limit_bytes + 1)
        .read_to_end(&mut unpacked)
        .map_err(reading(FILE))?;
    budget.take(FILE, unpacked.len() as u64, 1)?;
    Ok(unpacked)
}

/// Content of a variable, or of a field of a struct.
enum Content {
    /// Shape and values, column by column.
    Array(Vec<usize>, Vec<f64>),
    /// Fields of each element of a struct array.
    Struct(Vec<Fields>),
    /// Description of a content that is not read.
    Other(&'static str),
}

/// Variables of a file, or fields of a struct. A field of a struct within a struct is named `struct.field`.
#[derive(Default)]
struct Fields {
    arrays: Vec<Array>,
    left_out: Vec<String>,
}

impl Fields {
    fn leave_out(&mut self, name: &str, what: &str) {
        let named = format!("{name} ({what})");
        self.left_out.push(if name.is_empty() { what.to_owned() } else { named });
    }

    fn take(&mut self, name: String, content: Content) {
        match content {
            Content::Array(shape, values) => {
                let array = Array { name, shape, is_by_column: true, values, ..Array::default() };
                self.arrays.push(array);
            }
            Content::Struct(mut elements) if elements.len() == 1 => {
                let inner = elements.remove(0);
                let within = |what: &String| format!("{name}.{what}");
                self.left_out.extend(inner.left_out.iter().map(within));
                let arrays = inner.arrays.into_iter();
                self.arrays
                    .extend(arrays.map(|array| Array { name: within(&array.name), ..array }));
            }
            Content::Struct(_) => self.leave_out(&name, "structs within a struct"),
            Content::Other(what) => self.leave_out(&name, what),
        }
    }
}

/// Maximum number of structs within structs that are read.
const DEPTH_LIMIT: usize = 8;

/// Returns the fields of each element of a struct array. `parts` holds the bytes after the name of the struct.
fn structs(
    mut parts: Elements<'_>,
    n_elements: usize,
    depth: usize,
) -> Result<Vec<Fields>, FileError> {
    let is_big_endian = parts.is_big_endian;
    let (_, length) = parts.next(FILE)?;
    let length = parts.uint32(length).filter(|length| *length > 0);
    let length = length.ok_or_else(|| FileError::cut_short(FILE))? as usize;
    let (_, names) = parts.next(FILE)?;
    let name = |name: &[u8]| {
        let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
        String::from_utf8_lossy(name).into_owned()
    };
    let names: Vec<String> = names.chunks(length).map(name).collect();
    let mut elements = Vec::new();
    while elements.len() < n_elements && !parts.bytes.is_empty() && !names.is_empty() {
        let mut fields = Fields::default();
        for name in &names {
            let (kind, bytes) = parts.next(FILE)?;
            if kind == MI_MATRIX && !bytes.is_empty() && fields.arrays.len() < COLUMN_LIMIT {
                let field = Elements { bytes, is_big_endian };
                let (name, content) = content(field, Some(name), depth + 1)?;
                fields.take(name, content);
            }
        }
        elements.push(fields);
    }
    Ok(elements)
}

/// Returns the name and the content of a variable, or of the field `field` of a struct. `depth` is the number of structs
/// around it.
fn content(
    mut parts: Elements<'_>,
    field: Option<&str>,
    depth: usize,
) -> Result<(String, Content), FileError> {
    let (_, flags) = parts.next(FILE)?;
    let flags = parts.uint32(flags).ok_or_else(|| FileError::cut_short(FILE))?;
    let class = flags & 0xff;
    if !(1..=15).contains(&class) {
        let what = "an object, such as a table or timetable: save it as `S = table2struct(T, \"ToScalar\", true)`, or with writetable";
        return Ok((field.unwrap_or_default().to_owned(), Content::Other(what)));
    }
    let (_, dimensions) = parts.next(FILE)?;
    let (_, own_name) = parts.next(FILE)?;
    let name = field.map_or_else(|| String::from_utf8_lossy(own_name).into_owned(), str::to_owned);
    let lengths = dimensions.chunks_exact(4);
    let shape: Option<Vec<usize>> =
        lengths.map(|length| Some(parts.uint32(length)? as usize)).collect();
    let shape = shape.unwrap_or_default();
    let n_declared = shape.iter().copied().try_fold(1, usize::checked_mul);
    let content = match class {
        1 => Content::Other("cells"),
        2 if depth < DEPTH_LIMIT => {
            Content::Struct(structs(parts, n_declared.unwrap_or(usize::MAX), depth)?)
        }
        2 => Content::Other("a struct"),
        3 => Content::Other("an object"),
        4 => Content::Other("text"),
        5 => Content::Other("a sparse matrix"),
        _ if flags & COMPLEX_FLAG != 0 => Content::Other("complex numbers"),
        _ => {
            let (kind, numbers) = parts.next(&name)?;
            let unknown = || FileError::damaged(&name, "its numbers have an unknown data type");
            let values = number_of(kind).ok_or_else(unknown)?.all(numbers, parts.is_big_endian);
            if n_declared != Some(values.len()) {
                return Err(FileError::cut_short(&name));
            }
            Content::Array(shape, values)
        }
    };
    Ok((name, content))
}

fn number_of(kind: u32) -> Option<Number> {
    Some(match kind {
        1 => Number::Int(1),
        2 => Number::Uint(1),
        3 => Number::Int(2),
        4 => Number::Uint(2),
        5 => Number::Int(4),
        6 => Number::Uint(4),
        7 => Number::Float(4),
        9 => Number::Float(8),
        12 => Number::Int(8),
        13 => Number::Uint(8),
        _ => return None,
    })
}

struct Elements<'a> {
    bytes: &'a [u8],
    is_big_endian: bool,
}

impl<'a> Elements<'a> {
    fn uint32(&self, bytes: &[u8]) -> Option<u32> {
        Some(Number::Uint(4).value(bytes.get(..4)?, self.is_big_endian) as u32)
    }

    fn next(&mut self, what: &str) -> Result<(u32, &'a [u8]), FileError> {
        let ends = || FileError::cut_short(what);
        let kind = self.uint32(self.bytes).ok_or_else(ends)?;
        // A small element holds up to four bytes of data in place of its length. The length is then the upper half of the
        // element's kind.
        if kind >> 16 != 0 {
            let n_bytes = (kind >> 16) as usize;
            let four = self.bytes.get(4..8).ok_or_else(ends)?;
            let too_long = || FileError::damaged(what, "an element is longer than its space");
            let small = four.get(..n_bytes).ok_or_else(too_long)?;
            self.bytes = &self.bytes[8..];
            return Ok((kind & 0xffff, small));
        }
        let rest = &self.bytes[4..];
        let n_bytes = self.uint32(rest).ok_or_else(ends)? as usize;
        let rest = &rest[4..];
        let element = rest.get(..n_bytes).ok_or_else(ends)?;
        let padded = if kind == MI_COMPRESSED { n_bytes } else { n_bytes.next_multiple_of(8) };
        self.bytes = rest.get(padded..).unwrap_or_default();
        Ok((kind, element))
    }
}

/// Writes each entry as a matrix of a MATLAB file. A list of texts becomes a matrix of characters, one row per text, padded
/// with blanks.
pub fn write(entries: &[Entry], out: &mut dyn io::Write) -> io::Result<()> {
    let title = concat!("MATLAB 5.0 MAT-file, written by LoopScope ", env!("CARGO_PKG_VERSION"));
    let mut header = title.as_bytes().to_vec();
    header.resize(124, b' ');
    header.extend([0x00, 0x01]); // version; all numbers of the file are little-endian
    header.extend(b"IM");
    out.write_all(&header)?;
    for entry in entries {
        out.write_all(&written(entry)?)?;
    }
    Ok(())
}

fn written(entry: &Entry) -> io::Result<Vec<u8>> {
    let (class, rows, columns, kind, data) = match entry {
        Entry::Numbers(Array { shape, values, .. }) => {
            // An array with one dimension is written as one row.
            let columns = shape.last().copied().unwrap_or(1);
            let rows = values.len().checked_div(columns).unwrap_or(0);
            let data = column_by_column(rows, columns, |row, column| {
                values[row * columns + column].to_le_bytes()
            });
            (MX_DOUBLE, rows, columns, MI_DOUBLE, data)
        }
        Entry::Texts { texts, .. } => {
            let texts: Vec<Vec<u16>> =
                texts.iter().map(|text| text.encode_utf16().collect()).collect();
            let columns = texts.iter().map(Vec::len).max().unwrap_or(0);
            let blank = u16::from(b' ');
            let data = column_by_column(texts.len(), columns, |row, column| {
                texts[row].get(column).unwrap_or(&blank).to_le_bytes()
            });
            (MX_CHAR, texts.len(), columns, MI_UTF16, data)
        }
    };
    let mut parts = Vec::new();
    element(&mut parts, MI_UINT32, &[class.to_le_bytes(), [0; 4]].concat())?;
    let dimensions = [length(rows)?.to_le_bytes(), length(columns)?.to_le_bytes()];
    element(&mut parts, MI_INT32, &dimensions.concat())?;
    element(&mut parts, MI_INT8, entry.name().as_bytes())?;
    element(&mut parts, kind, &data)?;
    let mut variable = Vec::new();
    element(&mut variable, MI_MATRIX, &parts)?;
    Ok(variable)
}

fn column_by_column<const BYTES: usize>(
    rows: usize,
    columns: usize,
    entry: impl Fn(usize, usize) -> [u8; BYTES],
) -> Vec<u8> {
    let entry = &entry;
    (0..columns).flat_map(|column| (0..rows).flat_map(move |row| entry(row, column))).collect()
}

fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) -> io::Result<()> {
    out.extend(kind.to_le_bytes());
    out.extend(length(data.len())?.to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    Ok(())
}

fn length(length: usize) -> io::Result<u32> {
    u32::try_from(length).map_err(|_| {
        io::Error::other(
            "an array of more than 4 GB is too large for .mat; use .json, or fewer landmarks",
        )
    })
}
