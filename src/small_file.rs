//! Reads small files, such as calibrations, column maps and sessions. A pipe or device is rejected, because reading it might
//! never end. Files above a size limit are rejected too.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

pub(crate) fn open_regular(path: &Path) -> io::Result<File> {
    // The kind of file is checked before opening, because opening a named pipe waits for a program at its other end.
    let kind = fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return Err(io::Error::other(
            "this is the path of a folder, not of a file; name a file in the folder",
        ));
    }
    if !kind.is_file() {
        return Err(io::Error::other(
            "this is a pipe or a device, not a file; save its contents to a file, and name that file",
        ));
    }
    File::open(path)
}

/// Returns the content of a file of at most `limit_bytes` bytes. `what` names the kind of file in error messages.
pub(crate) fn read_small(path: &Path, what: &str, limit_bytes: u64) -> io::Result<Vec<u8>> {
    let mut content = Vec::new();
    let mut start = open_regular(path)?.take(limit_bytes + 1);
    start.read_to_end(&mut content)?;
    if content.len() as u64 > limit_bytes {
        let message = format!("the file has more than {limit_bytes} bytes, too many for {what}");
        return Err(io::Error::other(message));
    }
    Ok(content)
}

#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct TomlError {
    path: String,
    reason: String,
}

const TOML_BYTES_LIMIT: u64 = 1 << 20;

pub(crate) fn read_toml<T>(
    path: &Path,
    what: &str,
    parse: fn(&str) -> Result<T, String>,
) -> Result<T, TomlError> {
    let text = read_small(path, what, TOML_BYTES_LIMIT).map_err(|error| error.to_string());
    let text = text.and_then(|text| String::from_utf8(text).map_err(|_| "not in UTF-8".to_owned()));
    let parsed = text.and_then(|text| parse(&text));
    parsed.map_err(|reason| TomlError { path: path.display().to_string(), reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_the_limit_and_nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read_small(&path, "a map", 5).unwrap(), b"12345");
        let message =
            |path: &Path, limit| read_small(path, "a map", limit).unwrap_err().to_string();
        assert!(message(&path, 4).contains("too many for a map"));
        assert!(message(folder.path(), 5).contains("folder"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn pipes_and_devices_are_not_read() {
        let error = read_small(Path::new("/dev/zero"), "a map", 5).unwrap_err();
        assert!(error.to_string().contains("device"), "{error}");
        // Files in /proc report a length of zero.
        assert!(read_small(Path::new("/proc/self/status"), "a map", 5).is_err());
    }
}
