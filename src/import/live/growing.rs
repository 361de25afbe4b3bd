//! File that another program is still writing, as lines.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::formats::text::ArrivingLines;

/// Time after which a file without new lines is checked again.
const LOOK_AGAIN: Duration = Duration::from_millis(2);

/// Number of bytes of a growing file that are read at a time. The last [`TAIL_BYTES`] of them are remembered: if they change
/// in the file, the file was rewritten.
const READ_BYTES: usize = 1 << 16;
const TAIL_BYTES: usize = 256;

/// File that another program is still writing. If the file is replaced or rewritten, reading starts again at its beginning.
#[derive(Debug)]
pub struct GrowingFile {
    path: PathBuf,
    file: File,
    n_read: u64,
    tail: Vec<u8>,
    lines: ArrivingLines,
}

#[derive(Debug, PartialEq)]
pub enum Grown {
    Line(String),
    Nothing,
    /// The file was replaced or rewritten. Its first lines follow.
    Replaced,
}

impl GrowingFile {
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            file: File::open(path)?,
            n_read: 0,
            tail: Vec::new(),
            lines: ArrivingLines::default(),
        })
    }

    /// Returns the next complete line. If there is none yet, waits briefly and returns [`Grown::Nothing`] or
    /// [`Grown::Replaced`].
    pub fn look(&mut self) -> io::Result<Grown> {
        if let Some(line) = self.lines.next_line() {
            return Ok(Grown::Line(line));
        }
        let mut new = Vec::new();
        let is_there = self.still_holds_its_tail()?;
        if is_there {
            let mut next = (&mut self.file).take(READ_BYTES as u64);
            next.read_to_end(&mut new)?;
        }
        if !is_there || new.is_empty() && self.is_replaced() {
            *self = Self::open(&self.path)?;
            return Ok(Grown::Replaced);
        }
        if new.is_empty() {
            std::thread::sleep(LOOK_AGAIN);
            return Ok(Grown::Nothing);
        }
        self.n_read += new.len() as u64;
        self.lines.push(&new);
        self.tail.append(&mut new);
        self.tail.drain(..self.tail.len().saturating_sub(TAIL_BYTES));
        Ok(self.lines.next_line().map_or(Grown::Nothing, Grown::Line))
    }

    /// Returns true if the last bytes that were read are unchanged, so that reading can continue after them. In a rewritten
    /// file these bytes differ, even if the file is longer.
    fn still_holds_its_tail(&mut self) -> io::Result<bool> {
        let mut again = vec![0; self.tail.len()];
        let start = self.n_read - self.tail.len() as u64;
        self.file.seek(SeekFrom::Start(start))?;
        match self.file.read_exact(&mut again) {
            Ok(()) => Ok(again == self.tail),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Returns true if another file is now at this path. If there is no file, returns false, because the file may come back.
    fn is_replaced(&self) -> bool {
        match (self.file.metadata(), std::fs::metadata(&self.path)) {
            (Ok(here), Ok(there)) => is_other(&here, &there),
            _ => false,
        }
    }
}

#[cfg(unix)]
fn is_other(here: &std::fs::Metadata, there: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (here.dev(), here.ino()) != (there.dev(), there.ino())
}

#[cfg(not(unix))]
fn is_other(here: &std::fs::Metadata, there: &std::fs::Metadata) -> bool {
    here.created().ok() != there.created().ok()
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    #[test]
    fn a_growing_file_and_its_replacement_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let mut out = File::create(&path).unwrap();
        write!(out, "a\nb").unwrap();
        let mut file = GrowingFile::open(&path).unwrap();
        let mut next = || match file.look().unwrap() {
            Grown::Nothing => None,
            grown => Some(grown),
        };
        let line = |text: &str| Some(Grown::Line(text.to_owned()));
        assert_eq!(next(), line("a"));
        assert_eq!(next(), None);
        assert_eq!(next(), None);
        writeln!(out, "c").unwrap();
        assert_eq!(next(), line("bc"));
        std::fs::rename(&path, folder.path().join("log.1.csv")).unwrap();
        assert_eq!(next(), None);
        std::fs::write(&path, "d\n").unwrap();
        assert_eq!(next(), Some(Grown::Replaced));
        assert_eq!(next(), line("d"));
        std::fs::write(&path, "").unwrap();
        assert_eq!(next(), Some(Grown::Replaced));
        std::fs::write(&path, "head\n1\n").unwrap();
        assert_eq!([next(), next()], [line("head"), line("1")]);
        // The file is rewritten, and is longer than before at once.
        std::fs::write(&path, "other head\n7\n8\n").unwrap();
        assert_eq!(next(), Some(Grown::Replaced));
        assert_eq!([next(), next(), next()], ["other head", "7", "8"].map(line));
    }
}
