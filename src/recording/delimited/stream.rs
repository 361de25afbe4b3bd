//! From blocks to rows: one block after the other is read, many are parsed at a time.
//!
//! Guarantees: rows come in file order whatever the number of threads; only a few blocks are in memory at a time.

use std::path::Path;

use rayon::prelude::*;

use super::blocks::Blocks;
use super::header::Header;
use super::rows::Rows;
use super::{ReadError, cells};
use crate::progress::{Cancelled, Progress};

/// Enough for threads to share them evenly.
const BLOCKS_PER_THREAD: usize = 8;
/// Blocks parsed at a time at most, so that many cores do not mean much memory.
const BLOCKS_AT_A_TIME_LIMIT: usize = 64;

/// Reads the header and all rows; while some blocks are parsed, the next ones are read.
pub(super) fn read_rows(
    path: &Path,
    progress: &Progress,
    blocks: &mut Blocks,
) -> Result<(Header, Rows), ReadError> {
    let (header, mut rows, rest) = read_header(path, progress, blocks)?;
    let blocks_at_a_time =
        (BLOCKS_PER_THREAD * rayon::current_num_threads()).min(BLOCKS_AT_A_TIME_LIMIT);
    let parse = |block: &Vec<u8>| {
        progress.check()?;
        let rows = Rows::parse(block, &header);
        progress.advance(block.len() as u64);
        Ok(rows)
    };
    let mut batch = vec![rest];
    while !batch.is_empty() {
        let (next_batch, parsed) = rayon::join(
            || read_batch(blocks, blocks_at_a_time, progress),
            || {
                batch
                    .par_iter()
                    .map(parse)
                    .collect::<Result<_, Cancelled>>()
            },
        );
        append_all(&mut rows, parsed?, &header, blocks.file_bytes());
        batch = next_batch?;
    }
    Ok((header, rows))
}

/// Appends rows in order; the first time it makes room for the whole file, as growing later would copy everything.
fn append_all(rows: &mut Rows, parsed: Vec<Rows>, header: &Header, file_bytes: u64) {
    if rows.times.is_empty() && !parsed.is_empty() {
        // As many rows per byte as so far, and a little more.
        let n_rows: usize = parsed.iter().map(|rows| rows.times.len()).sum();
        let n_bytes: usize = parsed.iter().map(|rows| rows.n_bytes).sum();
        let share = n_rows as f64 / n_bytes.max(1) as f64;
        let estimate = 1.02 * share * file_bytes as f64;
        rows.reserve(estimate as usize, header);
    }
    parsed.into_iter().for_each(|next| rows.append(next));
}

fn read_batch(
    blocks: &mut Blocks,
    n_blocks: usize,
    progress: &Progress,
) -> Result<Vec<Vec<u8>>, ReadError> {
    let mut batch = Vec::with_capacity(n_blocks);
    while batch.len() < n_blocks {
        progress.check()?;
        match blocks.next()? {
            Some(block) => batch.push(block),
            None => break,
        }
    }
    Ok(batch)
}

/// Finds the header; gives it with the rows so far (none, but their line count and the header's notes) and the part of
/// its block that follows.
fn read_header(
    path: &Path,
    progress: &Progress,
    blocks: &mut Blocks,
) -> Result<(Header, Rows, Vec<u8>), ReadError> {
    let mut n_lines = 0;
    while let Some(mut block) = blocks.next()? {
        progress.check()?;
        let mut start = 0;
        while start < block.len() {
            let end = memchr::memchr(b'\n', &block[start..]).map_or(block.len(), |at| start + at);
            let next = block.len().min(end + 1);
            n_lines += 1;
            if cells::is_skipped(&block[start..end]) {
                start = next;
                continue;
            }
            let line = block[start..end].trim_ascii_end();
            let (header, notes) = Header::parse(path, n_lines, line)?;
            let mut rows = Rows::default();
            rows.n_lines = n_lines;
            for note in notes {
                rows.findings.note(n_lines, note);
            }
            progress.advance(next as u64);
            return Ok((header, rows, block.split_off(next)));
        }
        progress.advance(block.len() as u64);
    }
    Err(ReadError::NoHeader {
        path: path.to_owned(),
    })
}
