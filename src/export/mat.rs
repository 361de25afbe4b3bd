//! MATLAB's `.mat`, version 5: matrices of doubles and of characters, not compressed.
//!
//! **Source** MAT-File Format (The MathWorks), level 5: a header of 128 bytes, then one element for each variable, each
//! padded to 8 bytes; matrices stand column by column.

use std::io;

use super::arrays::{Array, Content, arrays};
use super::facts::Fact;
use crate::calibration::Calibration;

const MI_INT8: u32 = 1;
const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const MI_DOUBLE: u32 = 9;
const MI_MATRIX: u32 = 14;
const MI_UTF16: u32 = 17;
const MX_CHAR: u32 = 4;
const MX_DOUBLE: u32 = 6;

/// Writes all [`arrays`]; lists of texts are matrices of characters, one row each, padded with blanks.
pub(super) fn write(
    calibration: &Calibration,
    facts: &[Fact],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let title = concat!(
        "MATLAB 5.0 MAT-file, written by LoopScope ",
        env!("CARGO_PKG_VERSION")
    );
    let mut header = title.as_bytes().to_vec();
    header.resize(124, b' ');
    header.extend([0x00, 0x01]); // version, little-endian like all that follows
    header.extend(b"IM");
    out.write_all(&header)?;
    // Octave reads no character beyond ASCII.
    let units = calibration.units.iter().map(|unit| unit.replace('·', "."));
    for array in arrays(calibration, facts, units) {
        out.write_all(&variable(&array)?)?;
    }
    Ok(())
}

fn variable(array: &Array) -> io::Result<Vec<u8>> {
    let (class, rows, columns, kind, data) = match &array.content {
        Content::Numbers { columns, values } => {
            let rows = values.len().checked_div(*columns).unwrap_or(0);
            let data = column_by_column(rows, *columns, |row, column| {
                values[row * columns + column].to_le_bytes()
            });
            (MX_DOUBLE, rows, *columns, MI_DOUBLE, data)
        }
        Content::Texts(texts) => {
            let texts: Vec<Vec<u16>> = texts
                .iter()
                .map(|text| text.encode_utf16().collect())
                .collect();
            let columns = texts.iter().map(Vec::len).max().unwrap_or(0);
            let blank = u16::from(b' ');
            let data = column_by_column(texts.len(), columns, |row, column| {
                texts[row].get(column).unwrap_or(&blank).to_le_bytes()
            });
            (MX_CHAR, texts.len(), columns, MI_UTF16, data)
        }
    };
    let mut parts = Vec::new();
    element(
        &mut parts,
        MI_UINT32,
        &[class.to_le_bytes(), [0; 4]].concat(),
    )?;
    let dimensions = [
        four_bytes(rows)?.to_le_bytes(),
        four_bytes(columns)?.to_le_bytes(),
    ];
    element(&mut parts, MI_INT32, &dimensions.concat())?;
    element(&mut parts, MI_INT8, array.name.as_bytes())?;
    element(&mut parts, kind, &data)?;
    let mut variable = Vec::new();
    element(&mut variable, MI_MATRIX, &parts)?;
    Ok(variable)
}

fn column_by_column<const BYTES: usize>(
    rows: usize,
    columns: usize,
    entry: impl Fn(usize, usize) -> [u8; BYTES],
) -> Vec<u8> {
    let entry = &entry;
    (0..columns)
        .flat_map(|column| (0..rows).flat_map(move |row| entry(row, column)))
        .collect()
}

fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) -> io::Result<()> {
    out.extend(kind.to_le_bytes());
    out.extend(four_bytes(data.len())?.to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    Ok(())
}

fn four_bytes(length: usize) -> io::Result<u32> {
    u32::try_from(length).map_err(|_| {
        io::Error::other(
            "an array of more than 4 GB is too large for .mat; use .json, or fewer landmarks",
        )
    })
}
