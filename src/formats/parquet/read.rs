//! Reads the numeric columns of a Parquet file, and lists the other columns as left out.

use std::io::{BufReader, Read as _};

use ::parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use ::parquet::data_type::{DataType, Int96};
use ::parquet::errors::ParquetError;
use ::parquet::file::reader::{ChunkReader, FileReader, Length, SerializedFileReader};
use ::parquet::schema::types::ColumnDescriptor;
use bytes::Bytes;

use super::super::{
    columns::{Column, Columns, from_origin},
    error::FileError,
    format::{COLUMN_LIMIT, Source, SourceFile},
};
use crate::progress::Progress;

const FILE: &str = "the file";
const BATCH_ROWS: usize = 1 << 14;

pub fn columns(source: &Source<'_>) -> Result<Option<Columns>, FileError> {
    let reader = SerializedFileReader::new(source.open()?).map_err(damaged)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut table = Columns { is_named: true, ..Columns::default() };
    let mut indices = Vec::new();
    for index in 0..schema.num_columns() {
        let column = schema.column(index);
        let name = column.path().string();
        let has_numbers =
            !matches!(column.physical_type(), Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY);
        if column.max_rep_level() > 0 || !has_numbers || indices.len() >= COLUMN_LIMIT {
            let kind = if column.max_rep_level() > 0 { "lists" } else { "no numbers" };
            table.left_out.push(format!("{name} ({kind})"));
            continue;
        }
        indices.push(index);
        table.columns.push(Column {
            name,
            unit: time_unit(&column).to_owned(),
            ..Column::default()
        });
    }
    let mut origins = vec![None; indices.len()];
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(damaged)?;
        for (&index, (column, origin)) in
            indices.iter().zip(table.columns.iter_mut().zip(&mut origins))
        {
            let scale = decimal_scale(&schema.column(index));
            let start = column.values.len();
            let reader = group.get_column_reader(index).map_err(damaged)?;
            append(reader, &mut column.values, origin, source.progress)?;
            column.since = origin.unwrap_or(0);
            if scale != 1.0 && column.since == 0 {
                column.values[start..].iter_mut().for_each(|value| *value /= scale);
            }
        }
    }
    Ok(Some(table))
}

impl Length for SourceFile {
    fn len(&self) -> u64 {
        self.n_bytes().unwrap_or(0)
    }
}

impl ChunkReader for SourceFile {
    type T = BufReader<Self>;

    fn get_read(&self, start: u64) -> Result<BufReader<Self>, ParquetError> {
        Ok(BufReader::new(self.at(start)?))
    }

    fn get_bytes(&self, start: u64, n_bytes: usize) -> Result<Bytes, ParquetError> {
        let mut bytes = Vec::new();
        self.at(start)?.take(n_bytes as u64).read_to_end(&mut bytes)?;
        if bytes.len() < n_bytes {
            return Err(ParquetError::EOF("a page".to_owned()));
        }
        Ok(bytes.into())
    }
}

fn damaged(error: ParquetError) -> FileError {
    let why = error.to_string();
    // The crate names a compression that it was built without only in the text of its error.
    if why.contains("Disabled feature at compile time") {
        return FileError::Compression {
            what: FILE.to_owned(),
            codec: why.rsplit(' ').next().unwrap_or_default().to_owned(),
            instead: "zstd, snappy, gzip, lz4 or no compression",
        };
    }
    match error {
        ParquetError::EOF(_) => FileError::cut_short(FILE),
        _ => FileError::damaged(FILE, why),
    }
}

fn time_unit(column: &ColumnDescriptor) -> &'static str {
    let logical = column.logical_type_ref();
    match (logical, column.converted_type(), column.physical_type()) {
        (Some(LogicalType::Timestamp(time) | LogicalType::Time(time)), ..) => match time.unit {
            TimeUnit::MILLIS => "ms",
            TimeUnit::MICROS => "us",
            TimeUnit::NANOS => "ns",
        },
        (_, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS, _) => "ms",
        (_, ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS, _) => "us",
        (.., Type::INT96) => "ns",
        _ => "",
    }
}

/// Returns the divisor that turns the stored whole numbers of a decimal column into its values; 1 for any other column.
fn decimal_scale(column: &ColumnDescriptor) -> f64 {
    match column.converted_type() {
        ConvertedType::DECIMAL => 10_f64.powi(column.type_scale()),
        _ => 1.0,
    }
}

fn append(
    reader: ColumnReader,
    values: &mut Vec<f64>,
    origin: &mut Option<i64>,
    progress: &Progress,
) -> Result<(), FileError> {
    match reader {
        ColumnReader::BoolColumnReader(reader) => all(reader, values, f64::from, progress),
        ColumnReader::Int32ColumnReader(reader) => all(reader, values, f64::from, progress),
        ColumnReader::Int64ColumnReader(reader) => {
            all(reader, values, |v| from_origin(v, origin), progress)
        }
        ColumnReader::Int96ColumnReader(reader) => {
            all(reader, values, |v: Int96| from_origin(v.to_nanos(), origin), progress)
        }
        ColumnReader::FloatColumnReader(reader) => all(reader, values, f64::from, progress),
        ColumnReader::DoubleColumnReader(reader) => all(reader, values, |v| v, progress),
        _ => Ok(()),
    }
}

/// Appends all values of a column, with NaN for missing values.
fn all<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    values: &mut Vec<f64>,
    mut value: impl FnMut(T::T) -> f64,
    progress: &Progress,
) -> Result<(), FileError> {
    let (mut levels, mut batch) = (Vec::new(), Vec::new());
    loop {
        progress.check()?;
        levels.clear();
        batch.clear();
        let read = reader.read_records(BATCH_ROWS, Some(&mut levels), None, &mut batch);
        let (n_rows, n_values, _) = read.map_err(damaged)?;
        if n_rows == 0 {
            return Ok(());
        }
        let mut present = batch.drain(..).map(&mut value);
        if n_values == n_rows {
            values.extend(present);
        } else {
            let highest = levels.iter().copied().max().unwrap_or(0);
            let of_level = |&level: &i16| {
                let is_there = level == highest && n_values > 0;
                is_there.then(|| present.next()).flatten().unwrap_or(f64::NAN)
            };
            values.extend(levels.iter().map(of_level));
        }
    }
}
