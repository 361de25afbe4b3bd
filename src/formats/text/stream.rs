//! From blocks to what is made of them: one block after the other is read, many are parsed at a time.
//!
//! Guarantees: results come in file order whatever the number of threads; only a few blocks are in memory at a time.

use rayon::prelude::*;

use super::blocks::Blocks;
use super::{FileError, Head, TextFile};
use crate::progress::{Cancelled, Progress};

/// Enough for threads to share them evenly.
const BLOCKS_PER_THREAD: usize = 8;
/// Blocks parsed at a time at most, so that many cores do not mean much memory.
const BLOCKS_AT_A_TIME_LIMIT: usize = 64;

impl TextFile {
    /// Hands all lines below a head to `parse`, block by block, and what comes of them to `take`, with the share of the
    /// file that they are; while some blocks are parsed, the next ones are read.
    pub(in super::super) fn read<R: Send>(
        self,
        head: &Head,
        progress: &Progress,
        parse: impl Fn(&[u8]) -> R + Sync,
        mut take: impl FnMut(Vec<R>, f64),
    ) -> Result<(), FileError> {
        let Self {
            mut blocks,
            head: mut start,
        } = self;
        let rest = start.split_off(head.n_bytes);
        drop(start);
        let bytes_per_character = blocks.encoding().bytes_per_character();
        let advance = |n_bytes: usize| progress.advance(n_bytes as u64 * bytes_per_character);
        advance(head.n_bytes);
        let text_bytes = (blocks.file_bytes() / bytes_per_character).max(1) as f64;
        let blocks_at_a_time =
            (BLOCKS_PER_THREAD * rayon::current_num_threads()).min(BLOCKS_AT_A_TIME_LIMIT);
        let parse = |block: &Vec<u8>| {
            progress.check()?;
            let parsed = parse(block);
            advance(block.len());
            Ok(parsed)
        };
        let mut batch = vec![rest];
        while !batch.is_empty() {
            let (next_batch, parsed) = rayon::join(
                || read_batch(&mut blocks, blocks_at_a_time, progress),
                || {
                    let parsed = batch.par_iter().map(parse);
                    parsed.collect::<Result<Vec<R>, Cancelled>>()
                },
            );
            let n_bytes: usize = batch.iter().map(Vec::len).sum();
            take(parsed?, n_bytes as f64 / text_bytes);
            batch = next_batch?;
        }
        Ok(())
    }
}

fn read_batch(
    blocks: &mut Blocks,
    n_blocks: usize,
    progress: &Progress,
) -> Result<Vec<Vec<u8>>, FileError> {
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
