//! NumPy's `.npz`: one `.npy` file for each array, in a zip archive without compression.
//!
//! **Source** the NPY format, version 1.0 (and 3.0 for longer headers is never needed); APPNOTE of the zip format, 4.3.

use std::io;

use super::arrays::{Array, Content, arrays};
use super::facts::Fact;
use crate::calibration::Calibration;

/// Writes all [`arrays`]; vectors have one dimension.
pub(super) fn write(
    calibration: &Calibration,
    facts: &[Fact],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let files: Vec<(String, Vec<u8>)> =
        arrays(calibration, facts, calibration.units.iter().cloned())
            .into_iter()
            .map(|array| (format!("{}.npy", array.name), npy(&array)))
            .collect();
    out.write_all(&zip(&files)?)
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

/// An archive of stored files, dated 1980-01-01 so that equal calibrations give equal files.
fn zip(files: &[(String, Vec<u8>)]) -> io::Result<Vec<u8>> {
    const DATE: u16 = 1 << 5 | 1;
    const VERSION: u16 = 20;
    let mut archive = Vec::new();
    let mut directory = Vec::new();
    for (name, data) in files {
        let size = four_bytes(data.len())?;
        let mut common = Vec::new();
        // Version, flags, method (stored), time, date.
        for field in [VERSION, 0, 0, 0, DATE] {
            common.extend(field.to_le_bytes());
        }
        for field in [crc32(data), size, size] {
            common.extend(field.to_le_bytes());
        }
        common.extend((name.len() as u16).to_le_bytes()); // names are ours, and short
        common.extend(0_u16.to_le_bytes());
        let start = four_bytes(archive.len())?;
        archive.extend(b"PK\x03\x04");
        archive.extend(&common);
        archive.extend(name.as_bytes());
        archive.extend(data);
        directory.extend(b"PK\x01\x02");
        directory.extend(VERSION.to_le_bytes());
        directory.extend(&common);
        // Comment, disk, internal attributes; external attributes.
        directory.extend([0; 2 + 2 + 2 + 4]);
        directory.extend(start.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let start = four_bytes(archive.len())?;
    let count = (files.len() as u16).to_le_bytes();
    archive.extend(&directory);
    archive.extend(b"PK\x05\x06\0\0\0\0");
    archive.extend([count, count].concat());
    archive.extend(four_bytes(directory.len())?.to_le_bytes());
    archive.extend(start.to_le_bytes());
    archive.extend([0; 2]);
    Ok(archive)
}

fn four_bytes(length: usize) -> io::Result<u32> {
    u32::try_from(length).map_err(|_| {
        io::Error::other("more than 4 GB are too many for .npz; use .json, or fewer landmarks")
    })
}

/// CRC-32 of zip and PNG: polynomial 0xEDB88320, reflected.
fn crc32(data: &[u8]) -> u32 {
    !data.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            crc >> 1 ^ (0xEDB8_8320 & 0_u32.wrapping_sub(crc & 1))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of CRC-32/ISO-HDLC in the catalogue of parametrised CRC algorithms.
    #[test]
    fn the_checksum_is_the_one_of_the_catalogue() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

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
