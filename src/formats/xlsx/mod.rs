//! Reader of the sheets of workbooks (`.xlsx`, `.xls`, `.ods`), built with the feature `xlsx`.

#[cfg(feature = "xlsx")]
mod read;

use std::io::{BufReader, Seek as _};

use zip::ZipArchive;

use super::{
    columns::Columns,
    error::FileError,
    format::{Format, Source},
};

/// First bytes of a compound file, which may hold a workbook of Excel 97 to 2003.
const COMPOUND: &[u8] = b"\xd0\xcf\x11\xe0";

pub const FORMAT: Format = Format {
    name: "workbook of Excel or OpenDocument",
    endings: &["xlsx", "xlsm", "xls", "ods"],
    signatures: &[b"PK\x03\x04", COMPOUND],
    read: columns,
};

/// Kind of a workbook, by which it is read.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Workbook of XML sheets (`.xlsx`).
    Xml,
    /// Workbook of Excel 97 to 2003 (`.xls`).
    Old,
    /// OpenDocument spreadsheet (`.ods`).
    OpenDocument,
}

fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let mut file = BufReader::new(source.open()?);
    let kind = if source.head.starts_with(COMPOUND) {
        Kind::Old
    } else {
        #[cfg_attr(
            not(feature = "xlsx"),
            expect(unused_mut, reason = "only the reader changes the archive")
        )]
        let Ok(mut archive) = ZipArchive::new(file) else {
            return Ok(None);
        };
        let has = |member: &str| archive.file_names().flatten().any(|name| name == member);
        let kind = if has("xl/workbook.bin") {
            return Err(FileError::NotText {
                what: "an Excel workbook of binary sheets (.xlsb)",
                instead: "open it in a spreadsheet program, and save it as .xlsx or CSV",
            });
        } else if has("xl/workbook.xml") {
            Kind::Xml
        } else if has("content.xml") {
            Kind::OpenDocument
        } else {
            return Ok(None);
        };
        #[cfg(feature = "xlsx")]
        read::check_sizes(&mut archive)?;
        file = archive.into_inner();
        file.rewind()?;
        kind
    };
    #[cfg(feature = "xlsx")]
    return read::columns(source, file, kind).map(Some);
    #[cfg(not(feature = "xlsx"))]
    {
        drop((file, kind));
        Err(FileError::NotBuilt { what: "a workbook", feature: "xlsx" })
    }
}
