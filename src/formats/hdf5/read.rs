//! Datasets of numbers as arrays, records as columns; a group is a table of its own where they are not all one.

use hdf5_pure::{AttrValue, Dataset, Datatype, DatatypeByteOrder, Error, File, Group as Node};

use super::super::arrays::Array;
use super::super::columns::Columns;
use super::super::error::FileError;
use super::super::format::{COLUMN_LIMIT, Source, unpacked_limit};
use super::super::npy::Number;
use super::super::parts::{self, Group};
use crate::recording::Day;

/// Groups may hold each other in a circle.
const DEPTH_LIMIT: usize = 6;
/// More members are no recording.
const MEMBER_LIMIT: usize = 10_000;

/// The datasets of a file as a table.
pub(crate) fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let file = File::open(source.path).map_err(damaged)?;
    let mut reading = Reading {
        source,
        limit_bytes: unpacked_limit(source.n_bytes),
        groups: Vec::new(),
        left_out: Vec::new(),
        n_members: 0,
    };
    reading.group(&file.root(), "", 0)?;
    let Reading {
        groups, left_out, ..
    } = reading;
    let columns = parts::of_groups(groups, '/', left_out, source.parts)?;
    let day = day_of(&file.root());
    Ok(Some(Columns { day, ..columns }))
}

/// The day that an attribute of the file names.
fn day_of(root: &Node) -> Option<Day> {
    let attributes = root.attrs().unwrap_or_default();
    attributes.iter().find_map(|(name, value)| match value {
        AttrValue::String(text) | AttrValue::AsciiString(text) => {
            Day::in_header(&format!("{name}: {text}"))
        }
        _ => None,
    })
}

fn damaged(error: Error) -> FileError {
    FileError::Hdf5 {
        why: error.to_string(),
    }
}

struct Reading<'a> {
    source: &'a Source<'a>,
    limit_bytes: u64,
    groups: Vec<Group>,
    left_out: Vec<String>,
    n_members: usize,
}

/// What a dataset is.
enum Content {
    Array(Array),
    Records(Vec<Array>),
    Other(&'static str),
}

impl Reading<'_> {
    fn group(&mut self, node: &Node, path: &str, depth: usize) -> Result<(), FileError> {
        let path_of = |name: &str| match path {
            "" => name.to_owned(),
            path => format!("{path}/{name}"),
        };
        let mut group = Group {
            name: path.to_owned(),
            ..Group::default()
        };
        // Below the root a group that cannot be listed is left out alone.
        let listed = |found: Result<Vec<String>, Error>| match found {
            Err(error) if path.is_empty() => Err(damaged(error)),
            found => Ok(found.ok().map(|mut names| {
                names.sort();
                names
            })),
        };
        let (datasets, groups) = (listed(node.datasets())?, listed(node.groups())?);
        let (Some(names), Some(mut inner)) = (datasets, groups) else {
            self.left_out.push(format!("{path} (not readable)"));
            return Ok(());
        };
        for name in &names {
            self.source.progress.check()?;
            self.n_members += 1;
            if self.n_members > MEMBER_LIMIT {
                return Ok(());
            }
            let content = match node.dataset(name) {
                Ok(dataset) => self.dataset(name, &dataset)?,
                Err(_) => Content::Other("not readable"),
            };
            match content {
                Content::Array(mut array) => {
                    array.labels = labels(node, name);
                    group.arrays.push(array);
                }
                Content::Records(arrays) => self.groups.push(Group {
                    name: path_of(name),
                    arrays,
                }),
                Content::Other(what) => self.left_out.push(format!("{} ({what})", path_of(name))),
            }
        }
        // A link leads to what is there already.
        if self
            .groups
            .iter()
            .any(|other| !group.arrays.is_empty() && other.arrays == group.arrays)
        {
            return Ok(());
        }
        self.groups.push(group);
        if depth == DEPTH_LIMIT {
            return Ok(());
        }
        // Where MATLAB keeps what cells and objects refer to.
        inner.retain(|name| !["#refs#", "#subsystem#"].contains(&name.as_str()));
        for name in inner {
            self.n_members += 1;
            match node.group(&name) {
                Ok(inner) if self.n_members <= MEMBER_LIMIT => {
                    self.group(&inner, &path_of(&name), depth + 1)?;
                }
                _ => self
                    .left_out
                    .push(format!("{} (not readable)", path_of(&name))),
            }
        }
        Ok(())
    }

    fn dataset(&self, name: &str, dataset: &Dataset) -> Result<Content, FileError> {
        let (Ok(shape), Ok(datatype)) = (dataset.shape(), dataset.datatype()) else {
            return Ok(Content::Other("not readable"));
        };
        let attributes = dataset.attrs().unwrap_or_default();
        let class = match attributes.get("MATLAB_class") {
            Some(AttrValue::String(class) | AttrValue::AsciiString(class)) => Some(class.as_str()),
            Some(_) => Some(""),
            None => None,
        };
        match class {
            Some("char") => return Ok(Content::Other("text")),
            Some("cell") => return Ok(Content::Other("cells")),
            _ if attributes.contains_key("MATLAB_object_decode") => {
                return Ok(Content::Other("an object"));
            }
            _ if attributes.contains_key("MATLAB_empty") => return Ok(Content::Other("empty")),
            _ => {}
        }
        let n_values = shape
            .iter()
            .try_fold(1_u64, |n, length| n.checked_mul(*length));
        let element_bytes = dataset.element_size().unwrap_or(1).max(1);
        let n_bytes = n_values.and_then(|n| n.checked_mul(element_bytes));
        if n_bytes.is_none_or(|n_bytes| n_bytes > self.limit_bytes) {
            return Err(FileError::UnpacksTooLarge {
                what: name.to_owned(),
                limit_bytes: self.limit_bytes,
            });
        }
        let n_values = n_values.unwrap_or(0) as usize;
        let mut shape: Vec<usize> = shape.iter().map(|length| *length as usize).collect();
        if class.is_some() {
            // MATLAB's columns are rows here.
            shape.reverse();
        }
        if let Datatype::Compound { size, members } = &datatype {
            let is_complex = members.len() == 2
                && members
                    .iter()
                    .all(|member| ["r", "i", "real", "imag"].contains(&member.name.as_str()));
            return match is_complex {
                true => Ok(Content::Other("complex numbers")),
                false => {
                    let Ok(raw) = dataset.read_raw() else {
                        return Ok(Content::Other("not readable"));
                    };
                    let fields = members.iter().map(|member| {
                        let offset = usize::try_from(member.byte_offset).unwrap_or(usize::MAX);
                        (member.name.as_str(), offset, &member.datatype)
                    });
                    Ok(Content::Records(records(
                        fields,
                        *size as usize,
                        n_values,
                        &raw,
                    )))
                }
            };
        }
        let Some(number) = number_of(&datatype) else {
            return Ok(Content::Other(match datatype {
                Datatype::String { .. }
                | Datatype::VariableLength {
                    is_string: true, ..
                } => "text",
                Datatype::Reference { .. } => "references",
                _ => "no numbers",
            }));
        };
        let Ok(raw) = dataset.read_raw() else {
            return Ok(Content::Other(
                "not readable: stored or packed in a way that is not known here",
            ));
        };
        let elements = raw.chunks_exact(number.0.n_bytes());
        let values: Vec<f64> = elements.map(|bytes| value(number, bytes)).collect();
        if values.len() != n_values {
            return Err(FileError::CutShort {
                what: name.to_owned(),
            });
        }
        Ok(Content::Array(Array {
            name: name.to_owned(),
            shape,
            is_by_column: class.is_some(),
            values,
            ..Array::default()
        }))
    }
}

/// Where pandas keeps the names of the columns of an array: `block0_values` has those in `block0_items`.
fn labels(node: &Node, name: &str) -> Vec<String> {
    let items = name
        .strip_suffix("_values")
        .map(|block| format!("{block}_items"));
    let items = items.and_then(|items| node.dataset(&items).ok()?.read_string().ok());
    items.unwrap_or_default()
}

/// The fields of records that hold numbers.
fn records<'a>(
    fields: impl Iterator<Item = (&'a str, usize, &'a Datatype)>,
    record_bytes: usize,
    n_records: usize,
    raw: &[u8],
) -> Vec<Array> {
    let field = |(name, offset, datatype): (&str, usize, &Datatype)| {
        let (number, n_each) = match datatype {
            Datatype::Array {
                base_type,
                dimensions,
            } => (
                number_of(base_type)?,
                dimensions
                    .iter()
                    .try_fold(1_usize, |n, length| n.checked_mul(*length as usize))?,
            ),
            other => (number_of(other)?, 1),
        };
        let n_bytes = n_each.checked_mul(number.0.n_bytes())?;
        let mut values = Vec::new();
        for record in raw.chunks_exact(record_bytes.max(1)).take(n_records) {
            let bytes = record.get(offset..offset.checked_add(n_bytes)?)?;
            for element in bytes.chunks_exact(number.0.n_bytes()) {
                values.push(value(number, element));
            }
        }
        Some(Array {
            name: name.to_owned(),
            shape: match n_each {
                1 => vec![n_records],
                _ => vec![n_records, n_each],
            },
            values,
            ..Array::default()
        })
    };
    fields.filter_map(field).take(COLUMN_LIMIT).collect()
}

/// How a number is stored, and whether its high byte comes first.
fn number_of(datatype: &Datatype) -> Option<(Number, bool)> {
    let (number, order) = match datatype {
        Datatype::FixedPoint {
            size: size @ (1 | 2 | 4 | 8),
            byte_order,
            layout,
        } => match layout.signed {
            true => (Number::Int(*size as usize), byte_order),
            false => (Number::Uint(*size as usize), byte_order),
        },
        Datatype::FloatingPoint {
            size: size @ (2 | 4 | 8),
            byte_order,
            ..
        } => (Number::Float(*size as usize), byte_order),
        // What is true or false.
        Datatype::Enumeration { base_type, .. } => return number_of(base_type),
        _ => return None,
    };
    match order {
        DatatypeByteOrder::LittleEndian => Some((number, false)),
        DatatypeByteOrder::BigEndian => Some((number, true)),
        _ => None,
    }
}

fn value((number, is_big_endian): (Number, bool), bytes: &[u8]) -> f64 {
    let mut word = [0_u8; 8];
    let word = &mut word[..bytes.len()];
    word.copy_from_slice(bytes);
    if is_big_endian {
        word.reverse();
    }
    number.value(word)
}
