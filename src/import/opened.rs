//! A file that was opened, with its first rows as cells: text, or columns of numbers that need no cutting.
//!
//! Guarantees: whoever looks at a file or makes a plan for it need not know which of the two it is.

use std::borrow::Cow;
use std::path::Path;

use super::plan::Plan;
use super::rows::Rows;
use super::{Finding, ReadError, stream};
use crate::formats::text::Encoding;
use crate::formats::text::TextLayout;
use crate::formats::text::blocks::Blocks;
use crate::formats::text::cells::is_skipped;
use crate::formats::text::layout::{self, Detected, Start};
use crate::formats::{self, ArraysError};
use crate::import::map::TableMap;
use crate::progress::Progress;

/// So much of a text is there when its table is looked for.
const HEAD_BYTES: usize = 1 << 16;
/// So many rows of an array are looked at.
const HEAD_ROWS: usize = 200;

/// A file that was opened, and its start.
#[derive(Debug)]
pub(super) enum Opened {
    Text {
        blocks: Blocks,
        head: Vec<u8>,
    },
    Arrays {
        table: formats::Table,
        /// The first rows.
        cells: Vec<Vec<String>>,
        file_bytes: u64,
    },
}

impl Opened {
    /// Opens a file; of a text with a limit, only so many bytes are read.
    pub(super) fn open(
        path: &Path,
        block_bytes: usize,
        limit_bytes: Option<u64>,
        progress: &Progress,
    ) -> Result<Self, ReadError> {
        let table = formats::read(path, progress).map_err(|source| match source {
            ArraysError::Cancelled => ReadError::Cancelled,
            ArraysError::Io(source) => ReadError::Io {
                path: path.to_owned(),
                source,
            },
            source => ReadError::Arrays {
                path: path.to_owned(),
                source,
            },
        })?;
        if let Some(table) = table {
            let n_rows = table.n_rows().min(HEAD_ROWS);
            return Ok(Self::Arrays {
                cells: (0..n_rows).map(|row| cells(&table, row)).collect(),
                file_bytes: std::fs::metadata(path).map_or(0, |metadata| metadata.len()),
                table,
            });
        }
        let mut blocks = Blocks::open(path, block_bytes, limit_bytes)?;
        let head = blocks.head(HEAD_BYTES)?;
        Ok(Self::Text { blocks, head })
    }

    /// How the table is written, found by looking; `None` if there is none.
    pub(super) fn detected(&self) -> Option<Detected> {
        match self {
            Self::Text { head, .. } => layout::detect(head),
            Self::Arrays { table, .. } => Some(Detected {
                text: TextLayout {
                    header: table.is_named,
                    ..TextLayout::default()
                },
                names_in_comment: Vec::new(),
            }),
        }
    }

    /// Where the table is by a layout; `None` if it is not there.
    pub(super) fn located(&self, text: &TextLayout) -> Option<Start> {
        let table = match self {
            Self::Text { head, .. } => return layout::locate(head, text),
            Self::Arrays { table, .. } => table,
        };
        let names = table.columns.iter().map(|column| column.name.clone());
        let units = table.columns.iter().map(|column| column.unit.clone());
        let has_names = text.header && table.is_named;
        (has_names || !text.header).then(|| Start {
            line: 1,
            names: if has_names {
                names.collect()
            } else {
                Vec::new()
            },
            units: units.collect(),
            n_columns: table.columns.len(),
            reference_time: table.reference_time,
            ..Start::default()
        })
    }

    /// As [`Opened::located`] by the layout of a map, or why not.
    pub(super) fn start(&self, path: &Path, table: &TableMap) -> Result<Start, ReadError> {
        self.located(&table.text)
            .ok_or_else(|| ReadError::TooShortForMap {
                path: path.to_owned(),
                what: match (self, table.text.header) {
                    (Self::Arrays { .. }, _) => "named columns",
                    (_, true) => "lines to skip and a header",
                    (_, false) => "lines to skip and rows",
                },
            })
    }

    /// A map as it goes for this file: arrays are not cut, so nothing that is said about text matters but the header.
    pub(super) fn fitting<'a>(&self, table: &'a TableMap) -> Cow<'a, TableMap> {
        match self {
            Self::Text { .. } => Cow::Borrowed(table),
            Self::Arrays { .. } => Cow::Owned(TableMap {
                text: TextLayout {
                    header: table.text.header,
                    ..TextLayout::default()
                },
                ..table.clone()
            }),
        }
    }

    /// The cells of the first rows.
    pub(super) fn first_rows(&self, text: &TextLayout, start: &Start) -> Vec<Vec<&[u8]>> {
        match self {
            Self::Text { head, .. } => layout::first_rows(head, text, start),
            Self::Arrays { cells, .. } => cells
                .iter()
                .map(|row| row.iter().map(String::as_bytes).collect())
                .collect(),
        }
    }

    /// What the file itself gives reason to say.
    pub(super) fn notes(&self) -> Vec<Finding> {
        let mut notes = Vec::new();
        if let Self::Arrays { table, .. } = self {
            if !table.left_out.is_empty() {
                notes.push(Finding::LeftOut {
                    names: table.left_out.clone(),
                });
            }
            if table.ends_early {
                notes.push(Finding::EndsEarly);
            }
        }
        notes
    }

    /// All rows, by a plan.
    pub(super) fn rows(
        self,
        plan: &Plan,
        start: &Start,
        progress: &Progress,
    ) -> Result<Rows, ReadError> {
        match self {
            Self::Text { mut blocks, head } => {
                stream::read_rows(plan, start, head, &mut blocks, progress)
            }
            Self::Arrays {
                table, file_bytes, ..
            } => {
                let rows = Rows::of_arrays(&table, plan, progress)?;
                progress.advance(file_bytes);
                Ok(rows)
            }
        }
    }

    /// How many rows the file has if all are like those of its head.
    pub(super) fn about_rows(&self, start: &Start) -> u64 {
        let head = match self {
            Self::Text { head, .. } => head,
            Self::Arrays { table, .. } => return table.n_rows() as u64,
        };
        let rows = &head[start.n_bytes.min(head.len())..];
        let lines = rows.split(|byte| *byte == b'\n');
        let n_rows = lines.filter(|line| !is_skipped(line)).count() as f64;
        let text_bytes = self.file_bytes() / self.encoding().bytes_per_character();
        let share =
            text_bytes.saturating_sub(start.n_bytes as u64) as f64 / rows.len().max(1) as f64;
        // A file that is here as a whole differs by its byte order mark at most.
        let share = if share < 1.001 { 1.0 } else { share };
        (n_rows * share).round() as u64
    }

    /// What a file of arrays is called; `None` for text.
    pub(super) fn kind(&self) -> Option<&'static str> {
        match self {
            Self::Text { .. } => None,
            Self::Arrays { table, .. } => Some(table.kind),
        }
    }

    pub(super) fn encoding(&self) -> Encoding {
        match self {
            Self::Text { blocks, .. } => blocks.encoding(),
            Self::Arrays { .. } => Encoding::Arrays,
        }
    }

    /// How long the file is.
    pub(super) fn file_bytes(&self) -> u64 {
        match self {
            Self::Text { blocks, .. } => blocks.whole_file_bytes(),
            Self::Arrays { file_bytes, .. } => *file_bytes,
        }
    }

    /// How many of them are read.
    pub(super) fn read_bytes(&self) -> u64 {
        match self {
            Self::Text { blocks, .. } => blocks.file_bytes(),
            Self::Arrays { file_bytes, .. } => *file_bytes,
        }
    }
}

/// A row as text would have it; nothing below the end of a shorter column.
pub(super) fn cells(table: &formats::Table, row: usize) -> Vec<String> {
    let cell = |column: &formats::Column| column.values.get(row).map(f64::to_string);
    let columns = table.columns.iter();
    columns
        .map(|column| cell(column).unwrap_or_default())
        .collect()
}
