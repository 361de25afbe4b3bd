//! Text file that is inspected and read in blocks, several of which are parsed at the same time. Results come in file order
//! for any number of threads. Only a few blocks are in memory at a time.

use std::cell::OnceCell;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::blocks::Blocks;
use super::cells::{Cells, is_skipped, lines};
use super::encoding::{Encoding, Text};
use super::layout::{self, HEAD_BYTES, Head, detect, locate};
use super::reshaped::{LIMIT_BYTES, is_channel, reshaped};
use super::written::TextLayout;
use crate::{
    formats::{
        columns::{PLACES, ROWS_AT_A_PLACE, Sample},
        error::FileError,
        format::Format,
    },
    progress::{Cancelled, Progress},
};

/// Format of every file whose first bytes match no other format.
pub const FORMAT: Format = Format {
    name: "delimited text",
    endings: &["csv", "txt", "tsv", "dat"],
    signatures: &[],
    read: |_| Ok(None),
};

/// Minimum and maximum number of bytes that are read at each of the places from which sample rows are taken.
const PLACE_BYTES: std::ops::RangeInclusive<usize> = 4 << 10..=128 << 10;
/// Number of blocks per thread, enough for an even share of the work among threads.
const BLOCKS_PER_THREAD: usize = 8;
/// Maximum number of blocks that are parsed at the same time, which limits memory on machines with many cores.
const BLOCKS_AT_A_TIME_LIMIT: usize = 64;

#[derive(Debug)]
pub struct TextFile {
    path: PathBuf,
    blocks: Blocks,
    head: Vec<u8>,
    /// Layout of the table, detected on first use.
    layout: OnceCell<Option<TextLayout>>,
    /// Whole lines from many places of the file after its start, read on first use.
    places: OnceCell<Vec<Vec<u8>>>,
    /// How the table was brought into the shape of one row for each sample, if it had another one.
    pub reshaped: Option<&'static str>,
}

impl TextFile {
    pub fn open(
        path: &Path,
        block_bytes: usize,
        limit_bytes: Option<u64>,
    ) -> Result<Self, FileError> {
        let mut blocks = Blocks::open(path, block_bytes, limit_bytes)?;
        let head = blocks.head(HEAD_BYTES)?;
        let (layout, places) = (OnceCell::new(), OnceCell::new());
        let text = Self { path: path.to_owned(), blocks, head, layout, places, reshaped: None };
        Ok(text.with_rows_of_samples()?.unwrap_or(text))
    }

    /// Returns the table with one row for each sample, if a small file has another shape.
    fn with_rows_of_samples(&self) -> Result<Option<Self>, FileError> {
        if self.blocks.text.file_bytes > LIMIT_BYTES || !self.may_have_another_shape() {
            return Ok(None);
        }
        let whole = Blocks::open(&self.path, LIMIT_BYTES as usize, None)?.head(usize::MAX)?;
        let Some((text, how)) = reshaped(&whole, |text| self.rows(text)) else { return Ok(None) };
        let later: Vec<&[u8]> = lines(&text).skip(ROWS_AT_A_PLACE * PLACES).collect();
        let places = later.chunks(later.len().div_ceil(PLACES).max(1));
        let places = places.map(|rows| rows[..rows.len().min(ROWS_AT_A_PLACE)].join(&b'\n'));
        let places = OnceCell::from(places.collect::<Vec<_>>());
        Ok(Some(Self { places, reshaped: Some(how), ..Self::of_bytes(text)? }))
    }

    fn may_have_another_shape(&self) -> bool {
        // Of a turned table, the start of the file may hold the first row only.
        let is_channel = |row: &Vec<&[u8]>| is_channel(row, 1);
        let rows = self.rows(&self.head);
        rows.first().is_some_and(is_channel) || reshaped(&self.head, |_| rows).is_some()
    }

    /// Returns the cells of the rows of a table in this text, and of its header.
    fn rows<'a>(&self, text: &'a [u8]) -> Vec<Vec<&'a [u8]>> {
        let found = self.layout().and_then(|layout| Some((self.head(&layout)?, layout)));
        let Some((start, layout)) = found else { return Vec::new() };
        let table = lines(text).skip(start.line as usize - 1).filter(|line| !is_skipped(line));
        table.map(|line| Cells::new(line.trim_ascii_end(), layout.delimiter).collect()).collect()
    }

    /// Takes bytes in memory as a file, all of which is its start.
    pub fn of_bytes(bytes: Vec<u8>) -> Result<Self, FileError> {
        let n_bytes = bytes.len();
        let mut blocks = Blocks::of(Text::of_bytes(bytes)?, n_bytes);
        let head = blocks.head(n_bytes)?;
        let (layout, places) = (OnceCell::new(), OnceCell::from(Vec::new()));
        Ok(Self { path: PathBuf::new(), blocks, head, layout, places, reshaped: None })
    }

    pub fn layout(&self) -> Option<TextLayout> {
        self.layout.get_or_init(|| detect(&self.head)).clone()
    }

    pub fn head(&self, layout: &TextLayout) -> Option<Head> {
        locate(&self.head, layout)
    }

    /// Returns the cells of the first rows, and of some rows from all over the file. The time for this does not grow with the
    /// file.
    pub fn sample(&self, layout: &TextLayout, head: &Head) -> Sample<'_> {
        let places = self.places.get_or_init(|| self.read_places());
        layout::sample(&self.head, layout, head, places)
    }

    fn read_places(&self) -> Vec<Vec<u8>> {
        let (n_inspected, line_bytes) = layout::inspected(&self.head);
        let bytes_per_character = self.encoding().bytes_per_character();
        // Reading begins with the line end in front of the first line, so that this line counts as whole.
        let start = (n_inspected as u64 * bytes_per_character).saturating_sub(bytes_per_character);
        let n_more = self.blocks.text.file_bytes.saturating_sub(start);
        let line_bytes = line_bytes * bytes_per_character as usize;
        let place_bytes =
            (line_bytes * (ROWS_AT_A_PLACE + 2)).clamp(*PLACE_BYTES.start(), *PLACE_BYTES.end());
        // A place of the file that cannot be read is skipped: reading the whole file will report the error.
        let lines = |at, n_bytes| self.blocks.lines_at(&self.path, at, n_bytes).ok();
        if n_more <= (PLACES * place_bytes) as u64 {
            return lines(start, n_more as usize).into_iter().collect();
        }
        let room = n_more - place_bytes as u64;
        let at = |place: usize| start + (room as f64 * place as f64 / (PLACES - 1) as f64) as u64;
        (0..PLACES).filter_map(|place| lines(at(place), place_bytes)).collect()
    }

    /// Returns the number of rows in the file, estimated from the length of the first rows.
    pub fn about_rows(&self, head: &Head) -> u64 {
        let end = head.end_bytes.unwrap_or(self.head.len());
        let rows = &self.head[head.n_bytes.min(end)..end];
        let n_rows = lines(rows).filter(|line| !is_skipped(line)).count() as f64;
        let text_bytes = self.blocks.text.file_bytes / self.encoding().bytes_per_character();
        let share =
            text_bytes.saturating_sub(head.n_bytes as u64) as f64 / rows.len().max(1) as f64;
        // If the rows that were read are the whole file, its length exceeds theirs by a byte order mark at most. Their number
        // is then the exact number of rows.
        let share = if share < 1.001 { 1.0 } else { share };
        (n_rows * share).round() as u64
    }

    pub fn encoding(&self) -> Encoding {
        self.blocks.text.encoding
    }

    /// Reads the rows of the file as [`Opened::read`](crate::formats::Opened::read) does, in blocks of lines.
    pub fn read<R: Send>(
        self,
        head: &Head,
        progress: &Progress,
        parse: impl Fn(&[u8]) -> R + Sync,
        mut take: impl FnMut(Vec<R>, f64),
    ) -> Result<(), FileError> {
        let Self { mut blocks, head: mut start, .. } = self;
        // A table that ends in the first bytes of the file is in them as a whole.
        start.truncate(head.end_bytes.unwrap_or(start.len()));
        let rest = start.split_off(head.n_bytes);
        drop(start);
        let bytes_per_character = blocks.text.encoding.bytes_per_character();
        let advance = |n_bytes: usize| progress.advance(n_bytes as u64 * bytes_per_character);
        advance(head.n_bytes);
        let text_bytes = (blocks.text.read_bytes / bytes_per_character).max(1) as f64;
        let blocks_at_a_time =
            (BLOCKS_PER_THREAD * rayon::current_num_threads()).min(BLOCKS_AT_A_TIME_LIMIT);
        let parse = |block: &Vec<u8>| {
            progress.check()?;
            let parsed = parse(block);
            advance(block.len());
            Ok(parsed)
        };
        let mut next_block = || {
            progress.check()?;
            blocks.next()
        };
        let mut batch = vec![rest];
        while !batch.is_empty() {
            let next = std::iter::from_fn(|| next_block().transpose()).take(blocks_at_a_time);
            let (next_batch, parsed) = rayon::join(
                || next.collect::<Result<Vec<Vec<u8>>, FileError>>(),
                || batch.par_iter().map(parse).collect::<Result<Vec<R>, Cancelled>>(),
            );
            let n_bytes: usize = batch.iter().map(Vec::len).sum();
            take(parsed?, n_bytes as f64 / text_bytes);
            batch = next_batch?;
        }
        Ok(())
    }
}
