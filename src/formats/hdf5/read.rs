//! Reads HDF5 files: a dataset of numbers becomes an array, a dataset of records becomes columns. Each group is a table of
//! its own, unless all groups together form one table.
//!
//! Guarantees: the total size of all datasets is checked before memory is allocated. Values that were never written become NaN.

use std::collections::{BTreeMap, HashSet};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use hdf5_pure::{
    AttrValue, Chunk, CompoundMember, Dataset, Datatype, DatatypeByteOrder, Error, File,
    Group as Node, Layout,
};

use super::super::arrays::Array;
use super::super::columns::Columns;
use super::super::error::FileError;
use super::super::format::{Budget, COLUMN_LIMIT, Source};
use super::super::number::{Field, FromOrigin, Number};
use super::super::parts::{self, Group};

/// Maximum number of nested groups that are read, since groups may contain each other in a circle.
const DEPTH_LIMIT: usize = 6;
/// Maximum number of datasets and groups that are read, so that a damaged file cannot take endless time.
const MEMBER_LIMIT: usize = 10_000;
/// Maximum total length of an array's column names (bytes), so that a damaged file cannot fill the memory.
const LABELS_LIMIT_BYTES: u64 = 1 << 20;

pub fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let file = File::open(source.path).map_err(damaged)?;
    let mut reading = Reading {
        source,
        budget: Budget::of_file(source.n_bytes),
        groups: Vec::new(),
        group_hashes: HashSet::new(),
        left_out: Vec::new(),
        n_members: 0,
    };
    reading.group(&file.root(), "", 0)?;
    let Reading { groups, left_out, .. } = reading;
    parts::of_groups(groups, '/', left_out, source.parts).map(Some)
}

fn damaged(error: Error) -> FileError {
    FileError::Hdf5 { why: error.to_string() }
}

struct Reading<'a> {
    source: &'a Source<'a>,
    budget: Budget,
    groups: Vec<Group>,
    group_hashes: HashSet<u64>,
    left_out: Vec<String>,
    n_members: usize,
}

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
        let mut group = Group { name: path.to_owned(), ..Group::default() };
        // Listing opens all members of a group at once. Opening each member by its name would search the list every time.
        let (datasets, mut inner) = match (node.iter_datasets(), node.iter_groups()) {
            (Ok(datasets), Ok(groups)) => {
                (datasets.collect::<BTreeMap<_, _>>(), groups.collect::<BTreeMap<_, _>>())
            }
            (Err(error), _) | (_, Err(error)) if path.is_empty() => return Err(damaged(error)),
            // A group that cannot be listed is left out, and reading goes on, unless the group is the root.
            _ => {
                self.left_out.push(format!("{path} (not readable)"));
                return Ok(());
            }
        };
        for (at, (name, dataset)) in datasets.iter().enumerate() {
            self.source.progress.check()?;
            self.n_members += 1;
            if self.n_members > MEMBER_LIMIT {
                let more = datasets.len() - at;
                self.left_out.push(format!("{more} more datasets"));
                break;
            }
            let content = self.dataset(&path_of(name), name, dataset)?;
            match content {
                Content::Array(mut array) => {
                    array.labels = labels(&datasets, name);
                    group.arrays.push(array);
                }
                Content::Records(arrays) => self.groups.push(Group { name: path_of(name), arrays }),
                Content::Other(what) => self.left_out.push(format!("{} ({what})", path_of(name))),
            }
        }
        // A group with the same arrays as an earlier group is a link to that group and is not read again.
        if !group.arrays.is_empty() && !self.group_hashes.insert(hash_of(&group.arrays)) {
            return Ok(());
        }
        self.groups.push(group);
        if depth == DEPTH_LIMIT {
            return Ok(());
        }
        // MATLAB keeps the contents of cell arrays and objects in these groups, which are not read.
        inner.retain(|name, _| !["#refs#", "#subsystem#"].contains(&name.as_str()));
        for (name, node) in inner {
            self.n_members += 1;
            if self.n_members > MEMBER_LIMIT {
                self.left_out.push(format!("{} (not read)", path_of(&name)));
                break;
            }
            self.group(&node, &path_of(&name), depth + 1)?;
        }
        Ok(())
    }

    fn dataset(&mut self, path: &str, name: &str, dataset: &Dataset) -> Result<Content, FileError> {
        let other = |what| Ok(Content::Other(what));
        let (Ok(shape), Ok(datatype)) = (dataset.shape(), dataset.datatype()) else {
            return other("not readable");
        };
        let attributes = dataset.attrs().unwrap_or_default();
        let class = match attributes.get("MATLAB_class") {
            Some(AttrValue::String(class) | AttrValue::AsciiString(class)) => Some(class.as_str()),
            Some(_) => Some(""),
            None => None,
        };
        match class {
            Some("char") => return other("text"),
            Some("cell") => return other("cells"),
            _ if attributes.contains_key("MATLAB_object_decode") => return other("an object"),
            _ if attributes.contains_key("MATLAB_empty") => return other("empty"),
            _ => {}
        }
        let field = field_of(name, 0, &datatype).filter(|field| field.n_each == 1);
        let bytes_each = match (&datatype, &field) {
            (Datatype::Compound { members, .. }, _) if is_complex(members) => {
                return other("complex numbers");
            }
            // In the worst case each byte of a record is a number, so the memory is estimated from that.
            (Datatype::Compound { size, .. }, _) => u64::from(*size) * size_of::<f64>() as u64,
            (_, Some(_)) => size_of::<f64>() as u64,
            (Datatype::String { .. } | Datatype::VariableLength { is_string: true, .. }, _) => {
                return other("text");
            }
            (Datatype::Reference { .. }, _) => return other("references"),
            _ => return other("no numbers"),
        };
        let n_values = n_values(&shape);
        let chunks = match dataset.layout() {
            _ if n_values == 0 => None,
            Ok(Layout::Contiguous { address: None, .. }) => return other("never written"),
            Ok(Layout::Contiguous { size, .. }) if size > self.source.n_bytes => {
                return Err(FileError::cut_short(name));
            }
            Ok(Layout::Chunked { chunk_shape, .. }) => match dataset.chunks() {
                Ok(chunks) if chunks.is_empty() => return other("never written"),
                Ok(chunks) => Some((chunk_shape, chunks)),
                Err(_) => return other("not readable"),
            },
            _ => None,
        };
        self.budget.take(name, n_values, bytes_each)?;
        let Ok(raw) = dataset.read_raw() else {
            return other("not readable: its storage or compression is not supported");
        };
        let n_values = n_values as usize;
        let gaps = chunks.and_then(|(chunk_shape, chunks)| Gaps::of(&shape, &chunk_shape, &chunks));
        if let Some(gaps) = &gaps {
            let n = (0..n_values).filter(|&at| gaps.has(at)).count();
            self.left_out.push(format!("{path} ({n} of {n_values} values were never written)"));
        }
        if let Datatype::Compound { size, members } = &datatype {
            let mut arrays = records(members, *size as usize, n_values, &raw);
            for array in &mut arrays {
                let n_each = array.values.len() / n_values.max(1);
                gaps.iter().for_each(|gaps| gaps.mark(&mut array.values, n_each));
            }
            return Ok(Content::Records(arrays));
        }
        let Some(field) = field else {
            return other("not readable");
        };
        let mut values = FromOrigin::default();
        field.append(&raw, field.number.n_bytes(), &mut values);
        if values.0.len() != n_values {
            return Err(FileError::cut_short(name));
        }
        gaps.iter().for_each(|gaps| gaps.mark(&mut values.0, 1));
        let mut shape: Vec<usize> = shape.iter().map(|length| *length as usize).collect();
        if class.is_some() {
            // MATLAB stores arrays column by column, so the lengths of the dimensions are in reverse order.
            shape.reverse();
        }
        Ok(Content::Array(Array { is_by_column: class.is_some(), ..field.array(&shape, values) }))
    }
}

/// Chunks (separately stored blocks) of a dataset that were never written.
struct Gaps {
    /// Length of the dataset and length of one chunk in each dimension (elements).
    shape: Vec<(u64, u64)>,
    is_written: Vec<bool>,
}

impl Gaps {
    /// Returns the chunks of a dataset that are missing in the list `chunks`, or `None` if none is missing.
    fn of(shape: &[u64], chunk_shape: &[u64], chunks: &[Chunk]) -> Option<Self> {
        let chunk_shape = chunk_shape.iter().map(|length| (*length).max(1));
        let shape: Vec<(u64, u64)> = shape.iter().copied().zip(chunk_shape).collect();
        let n_chunks: u64 = shape.iter().map(|(length, chunk)| length.div_ceil(*chunk)).product();
        let mut gaps = Self { shape, is_written: vec![false; n_chunks as usize] };
        for chunk in chunks {
            let mut at = Some(0);
            for ((length, _), offset) in gaps.shape.iter().zip(&chunk.offset) {
                // A dataset that was shortened may keep chunks beyond its end.
                at = at.filter(|_| offset < length).map(|at| at * length + offset);
            }
            if let Some(at) = at {
                let chunk = gaps.chunk(at as usize);
                gaps.is_written[chunk] = true;
            }
        }
        gaps.is_written.contains(&false).then_some(gaps)
    }

    /// Returns the index of the chunk that holds the element with this index.
    fn chunk(&self, at: usize) -> usize {
        let (mut rest, mut place, mut stride) = (at as u64, 0, 1);
        for (length, chunk) in self.shape.iter().rev() {
            place += rest % length / chunk * stride;
            rest /= length;
            stride *= length.div_ceil(*chunk);
        }
        place as usize
    }

    fn has(&self, at: usize) -> bool {
        !self.is_written[self.chunk(at)]
    }

    /// Replaces elements of the dataset that were never written by NaN; each element has `n_each` values.
    fn mark(&self, values: &mut [f64], n_each: usize) {
        for (at, row) in values.chunks_mut(n_each.max(1)).enumerate() {
            if self.has(at) {
                row.fill(f64::NAN);
            }
        }
    }
}

fn is_complex(members: &[CompoundMember]) -> bool {
    let is_part =
        |member: &CompoundMember| ["r", "i", "real", "imag"].contains(&member.name.as_str());
    members.len() == 2 && members.iter().all(is_part)
}

/// Returns the number of values of a dataset with this shape, or the largest number if the product overflows.
fn n_values(shape: &[u64]) -> u64 {
    shape.iter().fold(1, |n: u64, length| n.saturating_mul(*length))
}

fn hash_of(arrays: &[Array]) -> u64 {
    let mut hasher = DefaultHasher::new();
    for array in arrays {
        (&array.name, &array.shape).hash(&mut hasher);
        array.values.iter().for_each(|value| value.to_bits().hash(&mut hasher));
    }
    hasher.finish()
}

/// Returns the column names that pandas stores for an array in another dataset. The names for `block0_values` are in
/// `block0_items`.
fn labels(datasets: &BTreeMap<String, Dataset>, name: &str) -> Vec<String> {
    let items = name.strip_suffix("_values");
    let items = items.and_then(|block| datasets.get(&format!("{block}_items")));
    let is_small = |items: &&Dataset| {
        items.shape().ok().zip(items.element_size().ok()).is_some_and(|(shape, bytes)| {
            n_values(&shape).saturating_mul(bytes) <= LABELS_LIMIT_BYTES
        })
    };
    items.filter(is_small).and_then(|items| items.read_string().ok()).unwrap_or_default()
}

fn records(
    members: &[CompoundMember],
    record_bytes: usize,
    n_records: usize,
    raw: &[u8],
) -> Vec<Array> {
    let raw = &raw[..raw.len().min(n_records.saturating_mul(record_bytes))];
    let array = |member: &CompoundMember| {
        let offset = usize::try_from(member.byte_offset).ok()?;
        let field = field_of(&member.name, offset, &member.datatype)?;
        let n_bytes = field.n_each.checked_mul(field.number.n_bytes())?;
        let end = offset.checked_add(n_bytes)?;
        let mut values = FromOrigin::default();
        (0 < end && end <= record_bytes).then(|| field.append(raw, record_bytes, &mut values))?;
        Some(field.array(&[n_records], values))
    };
    members.iter().filter_map(array).take(COLUMN_LIMIT).collect()
}

/// Returns how the numbers of a dataset, or of a field of its records, are stored; `None` if it does not hold numbers.
fn field_of(name: &str, offset: usize, datatype: &Datatype) -> Option<Field> {
    let (number, order) = match datatype {
        Datatype::FixedPoint { size, byte_order, layout } => {
            let kind = if layout.signed { 'i' } else { 'u' };
            (Number::of_kind(kind, *size as usize)?, byte_order)
        }
        Datatype::FloatingPoint { size, byte_order, .. } => {
            (Number::of_kind('f', *size as usize)?, byte_order)
        }
        // HDF5 stores booleans as enumerations with a numeric base type.
        Datatype::Enumeration { base_type, .. } => return field_of(name, offset, base_type),
        Datatype::Array { base_type, dimensions } => {
            let one = field_of(name, offset, base_type).filter(|field| field.n_each == 1)?;
            let n_each =
                dimensions.iter().map(|length| *length as usize).try_fold(1, usize::checked_mul)?;
            return Some(Field { n_each, ..one });
        }
        _ => return None,
    };
    let is_big_endian = match order {
        DatatypeByteOrder::LittleEndian => false,
        DatatypeByteOrder::BigEndian => true,
        _ => return None,
    };
    Some(Field { name: name.to_owned(), number, unit: "", is_big_endian, offset, n_each: 1 })
}
