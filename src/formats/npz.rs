//! NumPy's `.npz`: arrays in a zip archive.

use std::fs::File;
use std::io::{BufReader, Read};

use zip::ZipArchive;
use zip::result::ZipError;

use super::{ArraysError, Table, naming, npy, unpacked_limit};
use crate::progress::Progress;

/// More members are no recording.
const MEMBER_LIMIT: usize = 10_000;

/// The arrays of an archive as a table; `None` if it is an archive of something else. A damaged one is only told of if
/// it `starts_with_array`.
pub(crate) fn table(
    file: File,
    starts_with_array: bool,
    progress: &Progress,
) -> Result<Option<Table>, ArraysError> {
    const ARCHIVE: &str = "the archive";
    let mut archive = match ZipArchive::new(BufReader::new(file)) {
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
    let (mut arrays, mut left_out) = (Vec::new(), Vec::new());
    for index in 0..archive.len().min(MEMBER_LIMIT) {
        let mut member = archive.by_index(index).map_err(of_zip(ARCHIVE))?;
        let name = member.name().map_err(of_zip(ARCHIVE))?.into_owned();
        let Some(name) = name.strip_suffix(".npy").map(str::to_owned) else {
            left_out.push(format!("{name} (no array)"));
            continue;
        };
        let limit_bytes = unpacked_limit(member.compressed_size());
        let n_bytes = member.size();
        if n_bytes > limit_bytes {
            return Err(ArraysError::UnpacksTooLarge {
                what: name,
                limit_bytes,
            });
        }
        let mut array = (&mut member).take(n_bytes);
        match npy::read(&name, &mut array, n_bytes, progress) {
            Ok(array) => arrays.push(array),
            Err(ArraysError::NotNumbers { kind, .. }) => left_out.push(format!("{name} ({kind})")),
            Err(other) => return Err(other),
        }
    }
    if archive.len() > MEMBER_LIMIT {
        left_out.push(format!("{} more members", archive.len() - MEMBER_LIMIT));
    }
    Ok(Some(naming::table("NumPy archive", arrays, left_out)))
}

fn of_zip(what: &str) -> impl Fn(ZipError) -> ArraysError {
    move |error| match error {
        ZipError::Io(error) => super::error::reading(what)(error),
        other => ArraysError::Damaged {
            what: what.to_owned(),
            why: other.to_string(),
        },
    }
}
