//! Converts a file of any supported encoding to UTF-8 text without byte order mark, whose lines end with `\n` or `\r\n`. The
//! error for a file that holds no text, such as an image, names the kind of the file.

use std::fmt;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use serde::Serialize;

use crate::formats::error::FileError;

/// Number of first bytes of a file from which its kind and encoding are detected.
const HEAD_BYTES: usize = 8 << 10;
/// A file with more than one control character in this number of bytes is not text. Fewer control characters are accidents of
/// a logger, which spoil only single rows.
const BYTES_PER_CONTROL_CHARACTER: usize = 20;
/// Minimum number of zero bytes in a row that are taken to come from a power failure, and not from binary data.
const ZEROS_OF_POWER_FAILURE: usize = 64;
const BYTE_ORDER_MARKS: [(&[u8], Encoding); 3] = [
    (b"\xef\xbb\xbf", Encoding::Utf8),
    (b"\xff\xfe", Encoding::Utf16LittleEndian),
    (b"\xfe\xff", Encoding::Utf16BigEndian),
];

#[derive(Clone, Copy, Debug, PartialEq, Serialize, strum::IntoStaticStr)]
#[serde(into = "&'static str")]
pub enum Encoding {
    /// UTF-8, or ASCII.
    #[strum(serialize = "UTF-8")]
    Utf8,
    /// UTF-16 with the low byte first.
    #[strum(serialize = "UTF-16 (little-endian)")]
    Utf16LittleEndian,
    /// UTF-16 with the high byte first.
    #[strum(serialize = "UTF-16 (big-endian)")]
    Utf16BigEndian,
    /// Code page, such as Windows-1252. Only the names of columns are decoded.
    #[strum(serialize = "code page")]
    CodePage,
    /// No text: the file holds arrays or columns of numbers.
    #[strum(serialize = "arrays")]
    Arrays,
}

impl Encoding {
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Returns the number of bytes that a plain (ASCII) character takes in the file.
    pub const fn bytes_per_character(self) -> u64 {
        match self {
            Self::Utf8 | Self::CodePage | Self::Arrays => 1,
            Self::Utf16LittleEndian | Self::Utf16BigEndian => 2,
        }
    }
}

/// Bytes that are read as text: a file, or bytes in memory.
trait Source: Read + Seek + fmt::Debug + Send + Sync {}

impl<T: Read + Seek + fmt::Debug + Send + Sync> Source for T {}

#[derive(Debug)]
pub struct Text {
    source: Box<dyn Source>,
    left_bytes: u64,
    /// Length of the file when it was opened (bytes).
    pub file_bytes: u64,
    /// Maximum number of bytes that are read: the length of the file or the caller's limit.
    pub read_bytes: u64,
    pub encoding: Encoding,
    /// True if some lines end with `\r` alone.
    has_bare_returns: bool,
    /// First bytes of a character whose other bytes are not yet read.
    half_character: Vec<u8>,
}

impl Text {
    /// Opens a file and checks that it is text. At most `limit_bytes` are read.
    pub fn open(path: &Path, limit_bytes: Option<u64>) -> Result<Self, FileError> {
        let file = File::open(path)?;
        let file_bytes = file.metadata()?.len();
        Self::of(Box::new(file), file_bytes, limit_bytes)
    }

    /// Checks that bytes in memory are text.
    pub fn of_bytes(bytes: Vec<u8>) -> Result<Self, FileError> {
        let n_bytes = bytes.len() as u64;
        Self::of(Box::new(Cursor::new(bytes)), n_bytes, None)
    }

    fn of(
        mut source: Box<dyn Source>,
        file_bytes: u64,
        limit_bytes: Option<u64>,
    ) -> Result<Self, FileError> {
        let mut head = Vec::with_capacity(HEAD_BYTES);
        (&mut source).take(HEAD_BYTES as u64).read_to_end(&mut head)?;
        if head.is_empty() {
            return Err(FileError::Empty);
        }
        let (encoding, mark_bytes) = encoding_of(&head)?;
        source.seek(SeekFrom::Start(mark_bytes as u64))?;
        let (head, _) = decoded(encoding, head.split_off(mark_bytes));
        let is_bare = |at| head.get(at + 1).is_some_and(|&next| next != b'\n');
        let limit_bytes = limit_bytes.unwrap_or(u64::MAX);
        Ok(Self {
            source,
            left_bytes: limit_bytes.saturating_sub(mark_bytes as u64),
            file_bytes,
            read_bytes: file_bytes.min(limit_bytes),
            encoding,
            has_bare_returns: memchr::memchr_iter(b'\r', &head).any(is_bare),
            half_character: Vec::new(),
        })
    }

    /// Returns true if the file is longer than the part that is read.
    pub fn is_sample(&self) -> bool {
        self.file_bytes > self.read_bytes
    }

    /// Appends the text of the next `wanted_bytes` of the file to `text`. Returns true if more text may follow.
    pub fn read_into(&mut self, text: &mut Vec<u8>, wanted_bytes: usize) -> io::Result<bool> {
        let wanted_bytes = self.left_bytes.min(wanted_bytes as u64);
        let start = text.len();
        let mut raw = std::mem::take(&mut self.half_character);
        // Text with one byte per character needs no conversion.
        let into = if self.encoding.bytes_per_character() == 1 { &mut *text } else { &mut raw };
        let n_bytes = (&mut self.source).take(wanted_bytes).read_to_end(into)? as u64;
        self.left_bytes -= n_bytes;
        let has_more = n_bytes == wanted_bytes && self.left_bytes > 0;
        let (mut new, half_character) = decoded(self.encoding, raw);
        self.half_character = half_character;
        text.append(&mut new);
        if self.has_bare_returns {
            // The text read before may end with `\r`, and only now is it known whether `\n` follows.
            mend_line_ends(&mut text[start.saturating_sub(1)..], has_more);
        }
        Ok(has_more)
    }

    /// Returns the text of `n_bytes` bytes from byte `at` on, independently of [`Self::read_into`]. Characters at both ends
    /// may be cut.
    pub fn part(&self, path: &Path, at: u64, n_bytes: usize) -> io::Result<Vec<u8>> {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(at - at % self.encoding.bytes_per_character()))?;
        let mut raw = Vec::new();
        file.take(n_bytes as u64).read_to_end(&mut raw)?;
        let (mut text, _) = decoded(self.encoding, raw);
        if self.has_bare_returns {
            mend_line_ends(&mut text, false);
        }
        Ok(text)
    }
}

/// Replaces each `\r` that no `\n` follows by `\n`, except a `\r` at the end of a text if `has_more` says that more follows.
fn mend_line_ends(text: &mut [u8], has_more: bool) {
    for at in 0..text.len() {
        let next = text.get(at + 1);
        if text[at] == b'\r' && next != Some(&b'\n') && (next.is_some() || !has_more) {
            text[at] = b'\n';
        }
    }
}

/// Converts bytes in this encoding to UTF-8 text. Returns the text, and the bytes of an incomplete last character.
pub fn decoded(encoding: Encoding, mut raw: Vec<u8>) -> (Vec<u8>, Vec<u8>) {
    let unit = match encoding {
        Encoding::Utf8 | Encoding::CodePage | Encoding::Arrays => return (raw, Vec::new()),
        Encoding::Utf16LittleEndian => u16::from_le_bytes,
        Encoding::Utf16BigEndian => u16::from_be_bytes,
    };
    let mut units: Vec<u16> = raw.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
    let is_first_half = |unit: &u16| (0xd800..0xdc00).contains(unit);
    if units.last().is_some_and(is_first_half) {
        units.pop();
    }
    let rest = raw.split_off(2 * units.len());
    let text: String = char::decode_utf16(units)
        .map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect();
    (text.into_bytes(), rest)
}

/// Returns the encoding of a file and the length of its byte order mark. The error for a file without text names the kind of
/// the file.
pub fn encoding_of(head: &[u8]) -> Result<(Encoding, usize), FileError> {
    if let Some(other) = other_kind(head) {
        return Err(other);
    }
    let marked = BYTE_ORDER_MARKS.iter().find(|(mark, _)| head.starts_with(mark));
    if let Some((mark, encoding)) = marked {
        return Ok((*encoding, mark.len()));
    }
    // Tables are mostly digits. In UTF-16, every other byte of a digit is zero.
    let zeros_from = |start: usize| head.iter().skip(start).step_by(2).filter(|b| **b == 0).count();
    let (even, odd) = (zeros_from(0), zeros_from(1));
    let is_most_of_half = |zeros: usize| zeros > 4 && zeros * 20 > head.len() * 9;
    if even == 0 && is_most_of_half(odd) {
        return Ok((Encoding::Utf16LittleEndian, 0));
    }
    if odd == 0 && is_most_of_half(even) {
        return Ok((Encoding::Utf16BigEndian, 0));
    }
    // A block of zeros that a power failure left in a text spoils only one row.
    let runs = head.chunk_by(|byte, next| byte == next);
    let written = runs.filter(|run| run[0] != 0 || run.len() < ZEROS_OF_POWER_FAILURE).flatten();
    let is_control = |byte: &&u8| **byte < b' ' && !b"\t\n\x0b\x0c\r\x1b".contains(byte);
    let (n_written, n_controls) = (written.clone().count(), written.filter(is_control).count());
    if n_written == 0 || n_controls * BYTES_PER_CONTROL_CHARACTER > n_written {
        return Err(FileError::NotText {
            what: "binary data",
            instead: "unpack it, or export the recording as CSV",
        });
    }
    // The inspected first bytes of the file may end in the middle of a character.
    let is_utf8 =
        std::str::from_utf8(head).map_or_else(|error| error.error_len().is_none(), |_| true);
    let encoding = if is_utf8 { Encoding::Utf8 } else { Encoding::CodePage };
    Ok((encoding, 0))
}

/// Returns the error for a file whose first bytes show that it is no text, with a way to convert it.
fn other_kind(head: &[u8]) -> Option<FileError> {
    const UNPACK: &str = "unpack it";
    const EXPORT: &str = "export the recording as CSV";
    const SIGNATURES: [(&[u8], &str, &str); 19] = [
        (
            b"version https://git-lfs",
            "a pointer of Git LFS to the file",
            "fetch the file: `git lfs pull`",
        ),
        (
            b"\x02P",
            "a C3D file of motion capture",
            "in Python: `import ezc3d, pandas`, then `c = ezc3d.c3d(\"FILE.c3d\")`, and `pandas.DataFrame(c[\"data\"][\"analogs\"][0].T, columns=c[\"parameters\"][\"ANALOG\"][\"LABELS\"][\"value\"]).to_csv(\"FILE.csv\", index=False)` for its analogue channels",
        ),
        (b"\x1f\x8b", "a gzip archive", UNPACK),
        (
            b"PK\x03\x04",
            "a zip archive or a spreadsheet",
            "unpack it, or save the sheet as .xlsx or CSV",
        ),
        (
            b"\x89HDF",
            "an HDF5 file",
            "in Python: `import h5py, numpy; f = h5py.File(\"FILE\")`, then `numpy.savez(\"FILE.npz\", t=f[\"t\"], S=f[\"S\"], F=f[\"F\"])` with the names of its datasets",
        ),
        (b"\x28\xb5\x2f\xfd", "a Zstandard archive", UNPACK),
        (b"BZh", "a bzip2 archive", UNPACK),
        (b"\xfd7zXZ", "an xz archive", UNPACK),
        (b"7z\xbc\xaf", "a 7-Zip archive", UNPACK),
        (
            b"#ROSBAG",
            "a ROS 1 recording (.bag)",
            "write each topic as a CSV file, which this program reads: `rostopic echo -b FILE.bag -p /TOPIC > TOPIC.csv`",
        ),
        (
            b"TDSm",
            "a TDMS file of LabVIEW",
            "in Python: `from nptdms import TdmsFile`, then `TdmsFile.read(\"FILE.tdms\").as_dataframe().to_csv(\"FILE.csv\", index=False)`; or let LabVIEW write .lvm",
        ),
        (
            b"SQLite format",
            "a database (.db3 of ROS 2)",
            "convert it to an MCAP recording: `mcap convert FILE.db3 FILE.mcap`, or `ros2 bag convert`",
        ),
        (
            b"ARROW1",
            "an Arrow file",
            "in Python: `import pandas`, then `pandas.read_feather(\"FILE\").to_parquet(\"FILE.parquet\")`",
        ),
        (
            b"MDF ",
            "an MDF recording",
            "in Python: `import asammdf`, then `asammdf.MDF(\"FILE\").to_dataframe().to_csv(\"FILE.csv\", index_label=\"t\")`",
        ),
        (
            b"\x80\x04\x95",
            "a pickle of Python",
            "in Python: `import pickle, numpy; d = pickle.load(open(\"FILE\", \"rb\"))`, then `numpy.savez(\"FILE.npz\", t=d[\"t\"], S=d[\"S\"], F=d[\"F\"])` with the names of its entries",
        ),
        (b"{\\rtf", "a document of a word processor", "save it as plain text, or as CSV"),
        (b"%PDF", "a PDF document", EXPORT),
        (b"\x89PNG", "a picture", EXPORT),
        (b"\xff\xd8\xff", "a picture", EXPORT),
    ];
    let is_array_of = |rest: &[u8]| rest.trim_ascii_start().starts_with(b"{");
    if head.strip_prefix(b"[").is_some_and(is_array_of) {
        return Some(FileError::NotText {
            what: "a JSON array",
            instead: "write one object per line (.jsonl), or in Python: `import pandas`, then `pandas.read_json(\"FILE\").to_csv(\"FILE.csv\", index=False)`",
        });
    }
    let named = SIGNATURES.iter().find(|(start, ..)| head.starts_with(start));
    named.map(|&(_, what, instead)| FileError::NotText { what, instead })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(content: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), content).unwrap();
        file
    }

    fn utf16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    /// Returns the text of a file with this content, read in steps of `step` bytes, and its encoding.
    fn read(content: &[u8], step: usize) -> (String, Encoding) {
        let mut text = Text::open(file(content).path(), None).unwrap();
        let mut all = Vec::new();
        while text.read_into(&mut all, step).unwrap() {}
        (String::from_utf8(all).unwrap(), text.encoding)
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "t [µs],S1,Fx\r\n0,1,2 𝄞\n";
        let with_mark = format!("\u{feff}{text}");
        for step in 1..40 {
            for (content, encoding) in [
                (text.as_bytes().to_vec(), Encoding::Utf8),
                (with_mark.as_bytes().to_vec(), Encoding::Utf8),
                (utf16(&with_mark, u16::to_le_bytes), Encoding::Utf16LittleEndian),
                (utf16(&with_mark, u16::to_be_bytes), Encoding::Utf16BigEndian),
                (utf16(text, u16::to_le_bytes), Encoding::Utf16LittleEndian),
                (utf16(text, u16::to_be_bytes), Encoding::Utf16BigEndian),
            ] {
                assert_eq!(read(&content, step), (text.to_owned(), encoding), "{step}");
            }
        }
    }

    #[test]
    fn bare_returns_end_lines() {
        for step in 1..20 {
            let (text, _) = read(b"t,S1\r0,1\r\n0,2\n\r0,3\r", step);
            assert_eq!(text, "t,S1\n0,1\r\n0,2\n\n0,3\n", "{step}");
        }
    }

    #[test]
    fn no_more_than_the_limit_is_read() {
        let mut text = Text::open(file(b"t,S1\n0,1\n").path(), Some(6)).unwrap();
        let mut all = Vec::new();
        while text.read_into(&mut all, 4).unwrap() {}
        assert_eq!((all.as_slice(), text.read_bytes), (&b"t,S1\n0"[..], 6));
    }

    #[test]
    fn the_kind_of_a_file_without_text_is_named() {
        for (content, what) in [
            (&b"\x1f\x8b\x08rest"[..], "a gzip archive"),
            (b"PK\x03\x04rest", "a zip archive or a spreadsheet"),
            (b"\x89HDF\r\n\x1a\n", "an HDF5 file"),
            (b"t,S1\n0,\0", "binary data"),
            (b"\x7fELF\x02\x01\x01", "binary data"),
            (b"\x02P\x0a\0\x30\0", "a C3D file of motion capture"),
            (&[0; 500], "binary data"),
            (b"[\n  {\"t\": 0, \"S1\": 1}]", "a JSON array"),
        ] {
            let error = Text::open(file(content).path(), None).unwrap_err();
            assert!(matches!(error, FileError::NotText { what: expected, .. } if expected == what));
        }
        let few_zeros = [&b"t,S1\n0,\0\n"[..], b"0.1,1.25\n".repeat(20).as_slice()].concat();
        assert_eq!(encoding_of(&few_zeros).unwrap(), (Encoding::Utf8, 0));
        let zeros_at_the_end = [&b"t,S1\n0,1\n0.1,2\n"[..], &[0; 500]].concat();
        assert_eq!(encoding_of(&zeros_at_the_end).unwrap(), (Encoding::Utf8, 0));
        assert_eq!(encoding_of(b"t,F [N\xb7m]\n").unwrap(), (Encoding::CodePage, 0));
    }
}
