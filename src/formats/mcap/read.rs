//! Reads MCAP recordings of ROS 2: gauges from a topic of arrays, and the reference from a topic of wrenches, each with its
//! own clock.
//!
//! Guarantees: only one chunk (block of records) is in memory at a time. A recording that was cut off, because its recorder
//! was killed, is read as far as it goes. If several topics could be gauges or reference, the user can choose.

use std::collections::BTreeMap;
use std::io::{BufReader, Read};

use ::mcap::records::{MessageHeader, Record, op};
use ::mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{McapError, parse_record};

use super::{
    super::{
        columns::{Column, Columns, FilePart},
        error::FileError,
        format::{Budget, COLUMN_LIMIT, Source},
        number::Number,
        parts,
    },
    cdr::Cdr,
};
use crate::recording::Axis;

const FILE: &str = "the recording";
const NANOS: i64 = 1_000_000_000;
const DOUBLE: Number = Number::Float(8);
/// Maximum size that a chunk of records may declare (bytes). Real chunks have a few megabytes.
const CHUNK_LIMIT_BYTES: u64 = 1 << 30;

/// Reads all topics of a recording, and returns one or two of them (gauges, reference) as a table.
pub fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let mut topics = Topics::default();
    let mut file = BufReader::new(source.open()?);
    let limit_bytes = usize::try_from(source.n_bytes.min(CHUNK_LIMIT_BYTES)).unwrap_or(usize::MAX);
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(limit_bytes),
    );
    let mut ends_early = false;
    while let Some(event) = reader.next_event() {
        source.progress.check()?;
        match event {
            Ok(LinearReadEvent::ReadRequest(n_bytes)) => {
                let n_read = file.read(reader.insert(n_bytes.min(limit_bytes)))?;
                reader.notify_read(n_read);
            }
            Ok(LinearReadEvent::Record { opcode, data }) => match parsed(opcode, data)? {
                Some(Record::Chunk { header, data }) => {
                    let n_bytes = header.uncompressed_size;
                    let records = unpacked(&header.compression, &data, n_bytes)?;
                    let mut rest = &records[..];
                    while !rest.is_empty() {
                        let first = first_record(rest);
                        let (opcode, data, next) =
                            first.ok_or_else(|| FileError::cut_short(FILE))?;
                        if let Some(record) = parsed(opcode, data)? {
                            topics.take(record);
                        }
                        rest = next;
                    }
                }
                Some(record) => topics.take(record),
                None => {}
            },
            Err(McapError::UnexpectedEof | McapError::BadMagic)
                if topics.topics.values().any(|topic| !topic.samples.is_empty()) =>
            {
                ends_early = true;
                break;
            }
            Err(error) => return Err(damaged(error)),
        }
    }
    Ok(Some(Columns { ends_early, ..topics.columns(source.parts)? }))
}

/// Returns kind and content of the first record in `records`, and the bytes after it; `None` if the record is cut short.
fn first_record(records: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (kind, rest) = records.split_first()?;
    let (n_bytes, rest) = rest.split_first_chunk()?;
    let n_bytes = usize::try_from(u64::from_le_bytes(*n_bytes)).ok()?;
    let (content, rest) = rest.split_at_checked(n_bytes)?;
    Some((*kind, content, rest))
}

/// Returns the bytes after the text at the start of `bytes`; `None` if `bytes` ends within this text.
fn after_text(bytes: &[u8]) -> Option<&[u8]> {
    let (n_bytes, rest) = bytes.split_first_chunk()?;
    rest.get(u32::from_le_bytes(*n_bytes) as usize..)
}

/// Parses a schema, channel, message or chunk; `None` for any other record. The lengths of the record's texts are checked
/// first, because the crate allocates memory by these lengths.
fn parsed(kind: u8, content: &[u8]) -> Result<Option<Record<'_>>, FileError> {
    let (start, n_texts) = match kind {
        op::MESSAGE => (0, 0),
        op::SCHEMA => (2, 2),
        op::CHANNEL => (4, 2),
        op::CHUNK => (28, 1),
        _ => return Ok(None),
    };
    let fits = || {
        let mut rest = content.get(start..)?;
        for _ in 0..n_texts {
            rest = after_text(rest)?;
        }
        if kind == op::CHANNEL {
            // The metadata of a channel are a map of texts with its total length in front.
            let (n_bytes, metadata) = rest.split_first_chunk()?;
            rest = metadata.get(..u32::from_le_bytes(*n_bytes) as usize)?;
            while !rest.is_empty() {
                rest = after_text(rest)?;
            }
        }
        Some(())
    };
    let too_long = || FileError::damaged(FILE, "a text is longer than its record");
    fits().ok_or_else(too_long)?;
    parse_record(kind, content).map(Some).map_err(damaged)
}

fn damaged(error: McapError) -> FileError {
    match error {
        McapError::UnexpectedEof => FileError::cut_short(FILE),
        other => FileError::damaged(FILE, other.to_string()),
    }
}

fn unpacked(compression: &str, packed: &[u8], n_bytes: u64) -> Result<Vec<u8>, FileError> {
    const CHUNK: &str = "a chunk";
    Budget::of_file(0).take(CHUNK, n_bytes, 1)?;
    let damaged = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::UnexpectedEof => FileError::cut_short(CHUNK),
        // The decoders report damaged input as errors of several kinds, all of which mean damage here.
        _ => FileError::damaged(CHUNK, error.to_string()),
    };
    let decoder: Box<dyn Read + '_> = match compression {
        "" => Box::new(packed),
        "zstd" => Box::new(zstd::Decoder::new(packed).map_err(damaged)?),
        "lz4" => Box::new(lz4_flex::frame::FrameDecoder::new(packed)),
        other => {
            return Err(FileError::Compression {
                what: CHUNK.to_owned(),
                codec: other.to_owned(),
                instead: "zstd, lz4 or no compression",
            });
        }
    };
    // Packed data may have an end mark behind the records, so no more than the declared size is read.
    let limit_bytes = if compression.is_empty() { u64::MAX } else { n_bytes };
    let mut records = Vec::new();
    decoder.take(limit_bytes).read_to_end(&mut records).map_err(damaged)?;
    if records.len() as u64 != n_bytes {
        let why = "its unpacked size differs from the declared size";
        return Err(FileError::damaged(CHUNK, why));
    }
    Ok(records)
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    WrenchStamped,
    Wrench,
    Array(Number),
    One(Number),
    JointState,
}

impl Shape {
    fn of_schema(name: &str) -> Option<Self> {
        let (package, message) = name.split_once('/')?;
        let message = message.strip_prefix("msg/").unwrap_or(message);
        let scalar = |name: &str| {
            let kind = name.trim_end_matches(|c: char| c.is_ascii_digit());
            let n_bytes = name[kind.len()..].parse::<usize>().ok()? / 8;
            let kinds = [("Int", 'i'), ("UInt", 'u'), ("Float", 'f')];
            let (_, letter) = kinds.into_iter().find(|(known, _)| *known == kind)?;
            Number::of_kind(letter, n_bytes)
        };
        match (package, message) {
            ("geometry_msgs", "WrenchStamped") => Some(Self::WrenchStamped),
            ("geometry_msgs", "Wrench") => Some(Self::Wrench),
            ("sensor_msgs", "JointState") => Some(Self::JointState),
            ("std_msgs" | "example_interfaces", other) => match other.strip_suffix("MultiArray") {
                Some(kind) => scalar(kind).map(Self::Array),
                None => scalar(other).map(Self::One),
            },
            _ => None,
        }
    }

    /// Returns the numbers of a message, and its time stamp (ns) if it has one.
    fn read(self, message: &[u8]) -> Option<(Option<i64>, Vec<f64>)> {
        let mut cdr = Cdr::new(message)?;
        let wrench =
            |cdr: &mut Cdr| -> Option<Vec<f64>> { (0..6).map(|_| cdr.number(DOUBLE)).collect() };
        Some(match self {
            Self::WrenchStamped => (Some(cdr.header_nanosecs()?), wrench(&mut cdr)?),
            Self::Wrench => (None, wrench(&mut cdr)?),
            Self::One(number) => (None, vec![cdr.number(number)?]),
            Self::Array(number) => {
                for _ in 0..cdr.length()? {
                    cdr.skip_text()?;
                    cdr.length()?;
                    cdr.length()?;
                }
                let n_before = cdr.length()?;
                let mut values = cdr.sequence(number)?;
                values.drain(..n_before.min(values.len()));
                (None, values)
            }
            Self::JointState => {
                let time = cdr.header_nanosecs()?;
                cdr.skip_texts()?;
                let position = cdr.sequence(DOUBLE)?;
                let velocity = cdr.sequence(DOUBLE)?;
                let effort = cdr.sequence(DOUBLE)?;
                let lists = [position, effort, velocity];
                let filled = lists.into_iter().find(|list| !list.is_empty());
                (Some(time), filled.unwrap_or_default())
            }
        })
    }
}

#[derive(Debug)]
struct Sample {
    /// Time stamp inside the message (ns), if it has one.
    stamp_nanosecs: Option<i64>,
    logged_nanosecs: i64,
    values: Vec<f64>,
}

#[derive(Debug)]
struct Topic {
    name: String,
    kind: String,
    shape: Option<Shape>,
    samples: Vec<Sample>,
    n_messages: usize,
}

#[derive(Debug, Default)]
struct Topics {
    schemas: BTreeMap<u16, String>,
    topics: BTreeMap<u16, Topic>,
}

impl Topics {
    fn take(&mut self, record: Record) {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let kind = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let is_cdr = channel.message_encoding == "cdr";
                self.topics.entry(channel.id).or_insert_with(|| Topic {
                    name: channel.topic,
                    shape: Shape::of_schema(&kind).filter(|_| is_cdr),
                    kind,
                    samples: Vec::new(),
                    n_messages: 0,
                });
            }
            Record::Message { header, data } => self.message(&header, &data),
            _ => {}
        }
    }

    fn message(&mut self, header: &MessageHeader, data: &[u8]) {
        let Some(topic) = self.topics.get_mut(&header.channel_id) else {
            return;
        };
        topic.n_messages += 1;
        if let Some(shape) = topic.shape
            && let Some((stamp_nanosecs, values)) = shape.read(data)
            && (1..=COLUMN_LIMIT).contains(&values.len())
        {
            topic.samples.push(Sample {
                stamp_nanosecs,
                logged_nanosecs: i64::try_from(header.log_time).unwrap_or(i64::MAX),
                values,
            });
        }
    }

    /// Returns the topics `wanted` as columns; if none is wanted, one topic of arrays and one of wrenches. Lists the topics
    /// that are left out.
    fn columns(self, wanted: &[String]) -> Result<Columns, FileError> {
        let readable: Vec<(u16, &Topic)> = self
            .topics
            .iter()
            .filter(|(_, topic)| !topic.samples.is_empty())
            .map(|(id, topic)| (*id, topic))
            .collect();
        parts::check_wanted(wanted, readable.iter().map(|(_, topic)| topic.name.as_str()))?;
        if wanted.len() > 2 {
            return Err(FileError::TooManyTopics { topics: wanted.to_vec() });
        }
        let mut chosen: Vec<u16> = if wanted.is_empty() {
            let of_kind = [false, true].into_iter();
            of_kind.filter_map(|is_wrench| Topic::most_likely(&readable, is_wrench)).collect()
        } else {
            let named = |name: &String| readable.iter().find(|(_, topic)| topic.name == *name);
            wanted.iter().filter_map(named).map(|(id, _)| *id).collect()
        };
        // The reference comes last.
        chosen.sort_by_key(|id| self.topics[id].is_wrench());
        let is_rival = |topic: &Topic| {
            let mut others = chosen.iter().map(|id| &self.topics[id]);
            others.any(|other| {
                other.is_wrench() == topic.is_wrench() && other.is_list() <= topic.is_list()
            })
        };
        let mut others = readable.iter().filter(|(id, _)| !chosen.contains(id));
        let has_rivals = others.any(|(_, topic)| is_rival(topic));
        let parts = readable.iter().map(|(id, topic)| FilePart {
            name: topic.name.clone(),
            what: format!("{}, {} messages", topic.kind, topic.samples.len()),
            is_used: chosen.contains(id),
        });
        let mut table = Columns {
            is_named: true,
            is_guessed_part: wanted.is_empty() && has_rivals,
            parts: if has_rivals || !wanted.is_empty() { parts.collect() } else { Vec::new() },
            ..Columns::default()
        };
        let mut topics = self.topics;
        for id in chosen {
            let Some(topic) = topics.remove(&id) else { continue };
            let is_second = !table.columns.is_empty();
            if is_second {
                table.reference_time = Some(table.columns.len());
            }
            let time = if is_second { "time_reference" } else { "time" };
            let axis = |column: usize| Axis::ALL[column.min(5)].symbol().to_owned();
            let path = topic.name.clone();
            if topic.is_wrench() && (is_second || wanted.len() < 2) {
                topic.add_to(&mut table, time, axis);
            } else if is_second || topic.is_wrench() {
                // It is unknown whether this topic holds gauges or the reference, so its columns are named by topic and
                // index.
                topic.add_to(&mut table, time, |column| format!("{path}[{column}]"));
            } else {
                topic.add_to(&mut table, time, |column| format!("S{}", column + 1));
            }
        }
        table.left_out = topics
            .into_values()
            .filter(|topic| topic.n_messages > 0)
            .map(|topic| format!("{} ({})", topic.name, topic.kind))
            .collect();
        Ok(table)
    }
}

impl Topic {
    fn is_wrench(&self) -> bool {
        matches!(self.shape, Some(Shape::WrenchStamped | Shape::Wrench))
    }

    fn is_list(&self) -> bool {
        matches!(self.shape, Some(Shape::Array(_)))
    }

    /// Returns the topic that most likely holds the reference, or the gauges: by its kind, its name, then its number of
    /// samples.
    fn most_likely(topics: &[(u16, &Self)], is_wrench: bool) -> Option<u16> {
        const REFERENCES: [&str; 6] = ["ati", "ref", "reference", "truth", "gt", "load"];
        const GAUGES: [&str; 8] =
            ["gauge", "gauges", "strain", "strains", "raw", "adc", "channels", "sg"];
        let names: &[&str] = if is_wrench { &REFERENCES } else { &GAUGES };
        let rank = |(_, topic): &&(u16, &Self)| {
            let name = topic.name.to_lowercase();
            let is_named = name.split(['/', '_']).any(|word| names.contains(&word));
            (topic.is_list(), is_named, topic.samples.len())
        };
        let of_kind = topics.iter().rev().filter(|(_, topic)| topic.is_wrench() == is_wrench);
        // `max_by_key` returns the last of equal elements, so the order is reversed to get the first.
        of_kind.max_by_key(rank).map(|(id, _)| *id)
    }

    /// Appends a column of times to the table, and one column for each number of the topic's messages. Rows are sorted by
    /// time.
    fn add_to(mut self, table: &mut Columns, time: &str, name: impl Fn(usize) -> String) {
        // Drivers that do not know the time set the time stamp to zero.
        let is_stamped = |sample: &Sample| sample.stamp_nanosecs.is_some_and(|stamp| stamp != 0);
        let has_stamps = self.samples.iter().any(is_stamped);
        let nanosecs = |sample: &Sample| match sample.stamp_nanosecs {
            Some(stamp) if has_stamps => stamp,
            _ => sample.logged_nanosecs,
        };
        self.samples.sort_by_key(nanosecs);
        let n_columns = self.samples.first().map_or(0, |sample| sample.values.len());
        // Whole seconds are subtracted first, so that equal times of two topics give the same number.
        let since = self.samples.first().map_or(0, |first| nanosecs(first) / NANOS);
        let secs = |sample: &Sample| (nanosecs(sample) - since * NANOS) as f64 / NANOS as f64;
        table.columns.push(Column {
            name: time.to_owned(),
            unit: "s".to_owned(),
            since,
            values: self.samples.iter().map(secs).collect(),
            texts: None,
        });
        for column in 0..n_columns {
            // A number that is missing in a shorter message becomes NaN.
            let value = |sample: &Sample| sample.values.get(column).copied().unwrap_or(f64::NAN);
            let values = self.samples.iter().map(value);
            table.columns.push(Column {
                name: name(column),
                values: values.collect(),
                ..Column::default()
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Message in CDR: each number is aligned to a multiple of its size, counted after the first four bytes.
    #[derive(Default)]
    struct Writer(Vec<u8>);

    impl Writer {
        fn put<const N: usize>(&mut self, bytes: [u8; N]) {
            self.0.resize(self.0.len().next_multiple_of(N), 0);
            self.0.extend(bytes);
        }

        fn text(&mut self, text: &str) {
            self.put((text.len() as u32 + 1).to_le_bytes());
            self.0.extend(text.bytes());
            self.0.push(0);
        }

        fn numbers(&mut self, values: &[f64]) {
            self.put((values.len() as u32).to_le_bytes());
            values.iter().for_each(|value| self.put(value.to_le_bytes()));
        }
    }

    fn joint_state(position: &[f64], velocity: &[f64], effort: &[f64]) -> Vec<u8> {
        let mut message = Writer::default();
        message.put(3_i32.to_le_bytes());
        message.put(250_000_000_u32.to_le_bytes());
        message.text("base");
        message.put(2_u32.to_le_bytes());
        message.text("elbow");
        message.text("a");
        for list in [position, velocity, effort] {
            message.numbers(list);
        }
        [&[0, 1, 0, 0][..], &message.0].concat()
    }

    #[test]
    fn joint_states_give_their_first_list_that_is_not_empty() {
        let shape = Shape::of_schema("sensor_msgs/msg/JointState").unwrap();
        let time = Some(3_250_000_000);
        let full = joint_state(&[1.5, -2.5], &[7.0], &[8.0]);
        assert_eq!(shape.read(&full), Some((time, vec![1.5, -2.5])));
        let torques = joint_state(&[], &[7.0], &[8.0, 9.0]);
        assert_eq!(shape.read(&torques), Some((time, vec![8.0, 9.0])));
        let truncated = &full[..full.len() - 3];
        assert_eq!(shape.read(truncated), None);
    }
}
