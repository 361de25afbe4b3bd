//! NumPy's `.npz`: arrays in a zip archive, written without compression. An array of records is a table of its own.

use std::io::{self, BufReader, Cursor, Read as _, Write as _};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::arrays::Entry;
use super::columns::Columns;
use super::error::FileError;
use super::format::{Format, Source, unpacked_limit};
use super::npy;
use super::parts::{self, Group};

pub(super) const FORMAT: Format = Format {
    name: "NumPy archive",
    endings: &["npz"],
    signatures: &[b"PK\x03\x04", EMPTY],
    read: columns,
};

/// First bytes of an archive without members.
const EMPTY: &[u8] = b"PK\x05\x06";

/// Maximum number of members that are read.
const MEMBER_LIMIT: usize = 10_000;

/// Reads the arrays of an archive as a table, or `None`. Damage is an error only if the archive starts with an array.
fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    const ARCHIVE: &str = "the archive";
    if source.head.starts_with(EMPTY) {
        return Ok(Some(Columns::default()));
    }
    let starts_with_array = memchr::memmem::find(source.head, b".npy").is_some();
    let mut archive = match ZipArchive::new(BufReader::new(source.open()?)) {
        Ok(archive) => archive,
        Err(error) if starts_with_array => return Err(of_zip(ARCHIVE)(error)),
        Err(_) => return Ok(None),
    };
    let is_array = |name: &str| name.ends_with(".npy");
    let has_array = archive.file_names().flatten().any(|name| is_array(&name));
    let is_npz = archive.is_empty() || has_array;
    if !is_npz {
        return Ok(None);
    }
    let (mut groups, mut left_out) = (vec![Group::default()], Vec::new());
    for index in 0..archive.len().min(MEMBER_LIMIT) {
        let mut member = archive.by_index(index).map_err(of_zip(ARCHIVE))?;
        let name = member.name().map_err(of_zip(ARCHIVE))?.into_owned();
        let Some(name) = name.strip_suffix(".npy").map(str::to_owned) else {
            left_out.push(format!("{name} (not an array)"));
            continue;
        };
        let limit_bytes = unpacked_limit(member.compressed_size());
        let n_bytes = member.size();
        if n_bytes > limit_bytes {
            return Err(FileError::unpacks_too_large(&name, limit_bytes));
        }
        let mut array = (&mut member).take(n_bytes);
        match npy::read(&name, &mut array, n_bytes, source.progress) {
            Ok(content) if content.is_records => {
                let what = content.left_out.iter();
                left_out.extend(what.map(|what| format!("{name}/{what}")));
                groups.push(Group { name, arrays: content.arrays });
            }
            Ok(content) => groups[0].arrays.extend(content.arrays),
            Err(FileError::NotNumbers { kind, .. }) => left_out.push(format!("{name} ({kind})")),
            Err(other) => return Err(other),
        }
    }
    if archive.len() > MEMBER_LIMIT {
        left_out.push(format!("{} more members", archive.len() - MEMBER_LIMIT));
    }
    parts::of_groups(groups, '/', left_out, source.parts).map(Some)
}

fn of_zip(what: &str) -> impl Fn(ZipError) -> FileError {
    move |error| match error {
        ZipError::Io(error) => super::error::reading(what)(error),
        other => FileError::damaged(what, other.to_string()),
    }
}

pub(crate) fn write(entries: &[Entry], out: &mut dyn io::Write) -> io::Result<()> {
    // A fixed date, so that equal entries give equal files.
    let stored = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for entry in entries {
        archive.start_file(format!("{}.npy", entry.name()), stored)?;
        archive.write_all(&npy::written(entry))?;
    }
    out.write_all(archive.finish()?.get_ref())
}
