//! From blocks to rows: one block after the other is read, many are parsed at a time.
//!
//! Guarantees: rows come in file order whatever the number of threads; only a few blocks are in memory at a time.

use rayon::prelude::*;

use super::ReadError;
use super::plan::Plan;
use super::rows::Rows;
use crate::formats::text::blocks::Blocks;
use crate::formats::text::layout::Start;
use crate::progress::{Cancelled, Progress};

/// Enough for threads to share them evenly.
const BLOCKS_PER_THREAD: usize = 8;
/// Blocks parsed at a time at most, so that many cores do not mean much memory.
const BLOCKS_AT_A_TIME_LIMIT: usize = 64;

/// Reads all rows below `start` of a file whose first bytes are `head`; while some blocks are parsed, the next ones are
/// read.
pub(super) fn read_rows(
    plan: &Plan,
    start: &Start,
    mut head: Vec<u8>,
    blocks: &mut Blocks,
    progress: &Progress,
) -> Result<Rows, ReadError> {
    let mut rows = Rows::starting_after(start.n_lines);
    let rest = head.split_off(start.n_bytes);
    drop(head);
    let bytes_per_character = blocks.encoding().bytes_per_character();
    let advance = |n_bytes: usize| progress.advance(n_bytes as u64 * bytes_per_character);
    advance(start.n_bytes);
    let text_bytes = blocks.file_bytes() / bytes_per_character;
    let blocks_at_a_time =
        (BLOCKS_PER_THREAD * rayon::current_num_threads()).min(BLOCKS_AT_A_TIME_LIMIT);
    let parse = |block: &Vec<u8>| {
        progress.check()?;
        let rows = Rows::parse(block, plan);
        advance(block.len());
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
        append_all(&mut rows, parsed?, plan, text_bytes);
        batch = next_batch?;
    }
    Ok(rows)
}

/// Appends rows in order; the first time it makes room for the whole file, as growing later would copy everything.
fn append_all(rows: &mut Rows, parsed: Vec<Rows>, plan: &Plan, text_bytes: u64) {
    if rows.times.is_empty() && !parsed.is_empty() {
        // As many rows per byte as so far, and a little more.
        let n_rows: usize = parsed.iter().map(|rows| rows.times.len()).sum();
        let n_bytes: usize = parsed.iter().map(|rows| rows.n_bytes).sum();
        let share = n_rows as f64 / n_bytes.max(1) as f64;
        let estimate = 1.02 * share * text_bytes as f64;
        rows.reserve(estimate as usize, plan);
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
