//! Reader of the sheets of workbooks (`.xlsx`), built with the feature `xlsx`.

#[cfg(feature = "xlsx")]
mod read;

use std::io::BufReader;

use zip::ZipArchive;

use super::columns::Columns;
use super::error::FileError;
use super::format::{Format, Source};

pub(super) const FORMAT: Format = Format {
    name: "Excel workbook",
    endings: &["xlsx", "xlsm"],
    signatures: &[b"PK\x03\x04"],
    read: columns,
};

fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    const INSTEAD: &str = "open it in a spreadsheet program, and save it as .xlsx or CSV";
    let Ok(archive) = ZipArchive::new(BufReader::new(source.open()?)) else {
        return Ok(None);
    };
    let has = |member: &str| archive.file_names().flatten().any(|name| name == member);
    if has("xl/workbook.bin") {
        return Err(FileError::NotText {
            what: "an Excel workbook of binary sheets (.xlsb)",
            instead: INSTEAD,
        });
    }
    if has("content.xml") {
        return Err(FileError::NotText { what: "an OpenDocument file", instead: INSTEAD });
    }
    if !has("xl/workbook.xml") {
        return Ok(None);
    }
    #[cfg(feature = "xlsx")]
    return read::columns(source, archive).map(Some);
    #[cfg(not(feature = "xlsx"))]
    Err(FileError::NotBuilt { what: "an Excel workbook", feature: "xlsx" })
}
