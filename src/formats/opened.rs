//! Open file of any format. It looks the same to its readers whether it holds text or columns of numbers.

use std::fs::File;
use std::io::Read as _;
use std::ops::Range;
use std::path::Path;

use super::columns::{Columns, FilePart, PLACES, ROWS_AT_A_PLACE, Sample};
use super::error::FileError;
use super::format::{Format, Source};
use super::json_lines::{self, LineKeys};
use super::text::{Encoding, Head, TextFile, TextLayout};
use crate::{panicked, progress::Progress};

/// Number of first bytes that are read to detect the format: the signature, and the name of an archive's first file.
const SIGNATURE_BYTES: u64 = 512;
/// Number of first rows that are inspected in a file that holds columns of numbers instead of text.
const HEAD_ROWS: usize = 200;
/// Number of rows that are parsed at a time in a file that holds columns of numbers instead of text.
const PART_ROWS: usize = 1 << 14;

#[derive(Debug)]
pub struct Opened {
    /// Name of the format; `None` for text.
    pub kind: Option<&'static str>,
    pub encoding: Encoding,
    pub file_bytes: u64,
    pub read_bytes: u64,
    table: Table,
}

#[derive(Debug)]
enum Table {
    Text(TextFile),
    Columns(Columns),
}

#[derive(Clone, Debug)]
pub enum Part<'a> {
    Lines(&'a [u8]),
    Rows(&'a Columns, Range<usize>),
}

pub fn formats_of(head: &[u8]) -> impl Iterator<Item = &'static Format> {
    let starts =
        move |format: &&Format| format.signatures.iter().any(|start| head.starts_with(start));
    #[cfg(test)]
    let formats = super::FORMATS.iter().chain([&stuck::FORMAT]);
    #[cfg(not(test))]
    let formats = super::FORMATS.iter();
    formats.filter(starts)
}

/// Reader that never ends and cannot be cancelled, for tests.
#[cfg(test)]
pub(crate) mod stuck {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::Format;

    pub static N_STARTED: AtomicUsize = AtomicUsize::new(0);
    pub const SIGNATURE: &[u8] = b"\0stuck";
    pub const FORMAT: Format = Format {
        name: "a reader that never ends",
        endings: &[],
        signatures: &[SIGNATURE],
        read: |_| {
            N_STARTED.fetch_add(1, Ordering::SeqCst);
            loop {
                std::thread::park();
            }
        },
    };
}

/// Opens a file. Of a text, at most `limit_bytes` are read. If the file holds several tables, `parts` names the tables to
/// read; with an empty list, the program chooses.
pub fn open(
    path: &Path,
    block_bytes: usize,
    limit_bytes: Option<u64>,
    parts: &[String],
    progress: &Progress,
) -> Result<Opened, FileError> {
    // This is checked before opening, because opening a named pipe would block until its other end is opened.
    let metadata = std::fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(FileError::Folder { files: files_in(path), pattern: path.join("*.csv") });
    }
    if !metadata.is_file() {
        return Err(FileError::NotAFile);
    }
    let mut head = Vec::new();
    File::open(path)?.take(SIGNATURE_BYTES).read_to_end(&mut head)?;
    for format in formats_of(&head) {
        let source = Source { path, head: &head, n_bytes: metadata.len(), parts, progress };
        // Some crates that read these formats panic on damaged files.
        let read = panicked::caught_quietly(|| (format.read)(&source));
        // The reader reports a read that failed because of the cancellation as damage of the file.
        progress.check()?;
        match read.map_err(FileError::ReaderFailed)?? {
            Some(columns) if columns.n_rows() == 0 => {
                return Err(FileError::NoNumbers { left_out: columns.left_out });
            }
            Some(columns) => return Ok(Opened::of_columns(columns, format, metadata.len())),
            None => {}
        }
    }
    let text = TextFile::open(path, block_bytes, limit_bytes)?;
    let read_bytes = metadata.len().min(limit_bytes.unwrap_or(u64::MAX));
    Ok(Opened::of_text(text, metadata.len(), read_bytes))
}

fn files_in(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.path().is_file());
    let mut names: Vec<String> = files
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| !name.starts_with('.'))
        .collect();
    names.sort();
    names
}

impl Opened {
    fn of_columns(columns: Columns, format: &Format, n_bytes: u64) -> Self {
        Self {
            kind: Some(format.name),
            encoding: Encoding::Arrays,
            file_bytes: n_bytes,
            read_bytes: n_bytes,
            table: Table::Columns(columns),
        }
    }

    fn of_text(text: TextFile, file_bytes: u64, read_bytes: u64) -> Self {
        let encoding = text.encoding();
        Self { kind: None, encoding, file_bytes, read_bytes, table: Table::Text(text) }
    }

    /// Opens text in memory like a file.
    pub fn of_bytes(bytes: Vec<u8>) -> Result<Self, FileError> {
        let n_bytes = bytes.len() as u64;
        Ok(Self::of_text(TextFile::of_bytes(bytes)?, n_bytes, n_bytes))
    }

    /// Opens the first lines of a stream like a file, if the lines are JSON objects.
    pub fn of_json_lines(lines: &[String]) -> Option<(Self, LineKeys)> {
        let (columns, keys) = LineKeys::of_first(lines)?;
        Some((Self::of_columns(columns, &json_lines::FORMAT, 0), keys))
    }

    pub fn layout(&self) -> Option<TextLayout> {
        match &self.table {
            Table::Text(text) => text.layout(),
            Table::Columns(columns) => Some(TextLayout {
                header: columns.is_named,
                parts: (columns.parts.iter().filter(|part| part.is_used))
                    .map(|part| part.name.clone())
                    .collect(),
                ..TextLayout::default()
            }),
        }
    }

    /// Returns position and header of the table under this layout; `None` if the layout does not fit the table. For columns
    /// of numbers, only the header flag of the layout matters.
    pub fn head(&self, layout: &TextLayout) -> Option<Head> {
        let table = match &self.table {
            Table::Text(text) => return text.head(layout),
            Table::Columns(columns) => columns,
        };
        let columns = table.columns.iter();
        let names = columns.clone().map(|column| column.name.clone());
        (table.is_named || !layout.header).then(|| Head {
            line: table.n_lines.max(1),
            n_lines: table.n_lines,
            names: if layout.header { names.collect() } else { Vec::new() },
            units: columns.map(|column| column.unit.clone()).collect(),
            n_columns: table.columns.len(),
            reference_time: table.reference_time,
            ..Head::default()
        })
    }

    /// Returns true if automatic detection finds exactly this layout of the table.
    pub fn is_cut_by(&self, layout: &TextLayout) -> bool {
        match &self.table {
            Table::Text(text) => text.layout().as_ref() == Some(layout),
            Table::Columns(columns) => columns.is_named == layout.header,
        }
    }

    pub fn sample(&self, layout: &TextLayout, head: &Head) -> Sample<'_> {
        let columns = match &self.table {
            Table::Text(text) => return text.sample(layout, head),
            Table::Columns(columns) => columns,
        };
        let n_rows = columns.n_rows();
        let mut sample = Sample::default();
        let mut add = |rows: Range<usize>| {
            sample.add_place(rows.map(|row| columns.row(row).collect()));
        };
        add(0..n_rows.min(HEAD_ROWS));
        let n_more = n_rows.saturating_sub(HEAD_ROWS);
        if n_more <= PLACES * ROWS_AT_A_PLACE {
            add(n_rows - n_more..n_rows);
            return sample;
        }
        for place in 0..PLACES {
            let start = HEAD_ROWS + place * (n_more - ROWS_AT_A_PLACE) / (PLACES - 1);
            add(start..start + ROWS_AT_A_PLACE);
        }
        sample
    }

    /// Passes the rows below the header to `parse`, several parts of the file at a time. Passes the results to `take` in file
    /// order, with the share of the file that they cover.
    pub fn read<R: Send>(
        self,
        head: &Head,
        progress: &Progress,
        parse: impl Fn(Part<'_>) -> R + Sync,
        mut take: impl FnMut(Vec<R>, f64),
    ) -> Result<(), FileError> {
        let columns = match self.table {
            Table::Text(text) => {
                return text.read(head, progress, |lines| parse(Part::Lines(lines)), take);
            }
            Table::Columns(columns) => columns,
        };
        let n_rows = columns.n_rows();
        for start in (0..n_rows).step_by(PART_ROWS) {
            progress.check()?;
            let rows = start..n_rows.min(start + PART_ROWS);
            let share = rows.len() as f64 / n_rows as f64;
            take(vec![parse(Part::Rows(&columns, rows))], share);
        }
        progress.advance(self.file_bytes);
        Ok(())
    }

    /// Returns the number of rows of the table. For a text, it is estimated from the length of the first rows.
    pub fn about_rows(&self, head: &Head) -> u64 {
        match &self.table {
            Table::Text(text) => text.about_rows(head),
            Table::Columns(columns) => columns.n_rows() as u64,
        }
    }

    /// Returns how the table of a text was brought into the shape of one row for each sample, if it had another one.
    pub fn reshaped(&self) -> Option<&'static str> {
        match &self.table {
            Table::Text(text) => text.reshaped,
            Table::Columns(_) => None,
        }
    }

    pub fn columns(&self) -> Option<&Columns> {
        match &self.table {
            Table::Text(_) => None,
            Table::Columns(columns) => Some(columns),
        }
    }

    pub fn parts(&self) -> &[FilePart] {
        self.columns().map_or(&[], |columns| &columns.parts)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::thread;
    use std::time::Duration;

    use super::*;

    /// Returns the files of all formats that the tests have, with their contents.
    fn fixtures() -> Vec<(String, Vec<u8>)> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let named = files.map(|path| {
            let content = std::fs::read(&path).unwrap();
            (path.file_name().unwrap().to_string_lossy().into_owned(), content)
        });
        named.collect()
    }

    /// Reads a file of this content with all readers of its format. `n_bytes` is the size that the readers assume.
    #[track_caller]
    fn read_all(name: String, content: &[u8], n_bytes: u64, progress: &Progress) -> Vec<String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), content).unwrap();
        let (head, progress) = (content[..content.len().min(512)].to_vec(), progress.clone());
        let (done, is_done) = channel();
        thread::spawn(move || {
            let source =
                Source { path: file.path(), head: &head, n_bytes, parts: &[], progress: &progress };
            let read = formats_of(&head).map(|format| {
                let read = panicked::caught_quietly(|| (format.read)(&source));
                read.map_or_else(|_| "panic".to_owned(), |read| format!("{:?}", read.err()))
            });
            done.send(read.collect()).unwrap();
        });
        is_done
            .recv_timeout(Duration::from_secs(60))
            .unwrap_or_else(|_| panic!("{name} has no end"))
    }

    #[test]
    fn a_source_that_gives_nothing_more_ends_every_reader() {
        for (name, content) in fixtures() {
            let n_bytes = content.len();
            for end in (0..8).map(|part| 8 + part * n_bytes.saturating_sub(8) / 8) {
                let content = &content[..end.min(n_bytes)];
                read_all(name.clone(), content, n_bytes as u64, &Progress::default());
            }
        }
    }

    /// The header of the first page declares a list of 2^31 numbers, which the crate skips number by number.
    #[cfg(feature = "parquet")]
    #[test]
    fn a_list_beyond_the_end_of_a_parquet_file_is_an_error() {
        let files = fixtures();
        let (name, sound) = files.iter().find(|(name, _)| name == "none.parquet").unwrap();
        let mut content = sound.clone();
        content[4..11].copy_from_slice(&[0xf9, 0xf7, 0xff, 0xff, 0xff, 0xff, 0x07]);
        let n_bytes = content.len() as u64;
        let errors = read_all(name.clone(), &content, n_bytes, &Progress::default());
        assert_ne!(errors, ["None"]);
    }

    #[test]
    fn a_reader_that_is_cancelled_in_the_middle_says_so() {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in fixtures() {
            let path = folder.path().join(&name);
            std::fs::write(&path, &content).unwrap();
            for wait in [0, 20, 100, 500] {
                let progress = Progress::default();
                let read = thread::scope(|scope| {
                    scope.spawn(|| {
                        thread::sleep(Duration::from_micros(wait));
                        progress.cancel();
                    });
                    open(&path, 1 << 10, None, &[], &progress)
                });
                let sound = open(&path, 1 << 10, None, &[], &Progress::default());
                match read {
                    Ok(_) | Err(FileError::Cancelled) => {}
                    Err(other) => {
                        assert_eq!(other.to_string(), sound.unwrap_err().to_string(), "{name}")
                    }
                }
            }
        }
    }
}
