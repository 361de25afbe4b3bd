//! Reads and writes NumPy's `.npz`: arrays in a zip archive, written without compression. An array of records is a table of
//! its own.

use std::io::{self, BufReader, Cursor, Read as _, Write as _};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::arrays::Entry;
use super::columns::Columns;
use super::error::FileError;
use super::format::{Budget, Format, Source};
use super::npy;
use super::parts::{self, Group};

pub(super) const FORMAT: Format = Format {
    name: "NumPy archive",
    endings: &["npz"],
    signatures: &[b"PK\x03\x04", EMPTY],
    read: columns,
};

/// First bytes of a zip archive that contains no files.
const EMPTY: &[u8] = b"PK\x05\x06";

/// Maximum number of files in an archive that are read, so that a damaged archive cannot take endless time.
const MEMBER_LIMIT: usize = 10_000;

/// Reads the arrays of an archive as a table; `None` for an archive without arrays, such as a workbook. A damaged archive is
/// an error only if its first file is an array.
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
    let has_array = archive.file_names().flatten().any(|name| name.ends_with(".npy"));
    if !has_array && !archive.is_empty() {
        return Ok(None);
    }
    let (mut groups, mut left_out) = (vec![Group::default()], Vec::new());
    for index in 0..archive.len().min(MEMBER_LIMIT) {
        let mut member = archive.by_index(index).map_err(of_zip(ARCHIVE))?;
        let name = member.name().map_err(of_zip(ARCHIVE))?.into_owned();
        let Some(name) = name.strip_suffix(".npy") else {
            left_out.push(format!("{name} (not an array)"));
            continue;
        };
        let n_bytes = member.size();
        Budget::of_file(member.compressed_size()).take(name, n_bytes, 1)?;
        let mut array = (&mut member).take(n_bytes);
        match npy::read(name, &mut array, n_bytes, source.progress) {
            Ok(content) if content.is_records => {
                let what = content.left_out.iter();
                left_out.extend(what.map(|what| format!("{name}/{what}")));
                groups.push(Group { name: name.to_owned(), arrays: content.arrays });
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

pub fn write(entries: &[Entry], out: &mut dyn io::Write) -> io::Result<()> {
    let files = entries.iter().map(|entry| (format!("{}.npy", entry.name()), npy::written(entry)));
    out.write_all(&zipped(CompressionMethod::Stored, files)?)
}

/// Returns a zip archive of files, each with its path and content. Equal files give equal archives, byte by byte.
pub fn zipped(
    method: CompressionMethod,
    files: impl IntoIterator<Item = (String, impl AsRef<[u8]>)>,
) -> io::Result<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(method)
        .last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, content) in files {
        archive.start_file(path, options)?;
        archive.write_all(content.as_ref())?;
    }
    Ok(archive.finish()?.into_inner())
}
