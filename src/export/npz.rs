//! NumPy's `.npz`: one `.npy` file for each array, in a zip archive without compression.
//!
//! **Source** the NPY format, version 1.0 (and 3.0 for longer headers is never needed).

use std::io::{self, Cursor, Write as _};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::arrays::{Array, Content, arrays};
use super::facts::Fact;
use crate::calibration::Calibration;

/// Writes all [`arrays`]; vectors have one dimension.
pub(super) fn write(
    calibration: &Calibration,
    facts: &[Fact],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    // One date for all, so that equal calibrations give equal files.
    let stored = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for array in arrays(calibration, facts, calibration.units.iter().cloned()) {
        archive.start_file(format!("{}.npy", array.name), stored)?;
        archive.write_all(&npy(&array))?;
    }
    out.write_all(archive.finish()?.get_ref())
}

/// The file of one array: magic, header padded to a multiple of 64 bytes, little-endian numbers.
fn npy(array: &Array) -> Vec<u8> {
    let mut data = Vec::new();
    let (kind, shape) = match &array.content {
        Content::Numbers { columns, values } => {
            data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            let shape = match values.len() == *columns {
                true => format!("({columns},)"),
                false => format!("({}, {columns})", values.len() / columns.max(&1)),
            };
            ("<f8".to_owned(), shape)
        }
        Content::Texts(texts) => {
            let longest = texts.iter().map(|text| text.chars().count()).max();
            let width = longest.unwrap_or(0).max(1);
            for text in texts {
                let codes = text.chars().map(u32::from).chain(std::iter::repeat(0));
                data.extend(codes.take(width).flat_map(u32::to_le_bytes));
            }
            (format!("<U{width}"), format!("({},)", texts.len()))
        }
    };
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let unpadded = 10 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    let length = u16::try_from(header.len()).expect("a header is some hundred bytes");
    [
        b"\x93NUMPY\x01\x00",
        &length.to_le_bytes()[..],
        header.as_bytes(),
        &data,
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_begin_at_a_multiple_of_64_after_a_header_that_ends_its_line() {
        let content = Content::Numbers {
            columns: 2,
            values: vec![1.0, 2.0, 3.0, 4.0],
        };
        let file = npy(&Array {
            name: "a".to_owned(),
            content,
        });
        assert_eq!(file.len() % 64, 32);
        assert_eq!(file[file.len() - 33], b'\n');
        assert!(String::from_utf8_lossy(&file).contains("'shape': (2, 2)"));
    }
}
