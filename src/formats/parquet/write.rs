//! Writes a table as Apache Parquet: a column with the name of each row, then columns of optional doubles, one for each
//! number of a row.

use std::io::{self, Write};
use std::sync::Arc;

use ::parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use ::parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::Type;

/// Number of rows that are written as one group: few enough for small memories, many enough for fast readers.
const GROUP_ROWS: usize = 1 << 16;

pub struct ParquetTable<'a> {
    writer: SerializedFileWriter<&'a mut (dyn Write + Send)>,
    names: Vec<ByteArray>,
    columns: Vec<Vec<Option<f64>>>,
}

impl<'a> ParquetTable<'a> {
    pub fn new(head: &[String], out: &'a mut (dyn Write + Send)) -> io::Result<Self> {
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let writer = schema(head).and_then(|schema| {
            SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))
        });
        Ok(Self {
            writer: writer.map_err(io::Error::other)?,
            names: Vec::new(),
            columns: vec![Vec::new(); head.len()],
        })
    }

    pub fn push(&mut self, name: &str, row: &[Option<f64>]) -> io::Result<()> {
        self.names.push(name.into());
        for (column, number) in self.columns.iter_mut().zip(row) {
            column.push(*number);
        }
        match self.names.len() {
            GROUP_ROWS => self.write_group(),
            _ => Ok(()),
        }
    }

    pub fn finish(mut self) -> io::Result<()> {
        if !self.names.is_empty() {
            self.write_group()?;
        }
        self.writer.close().map(drop).map_err(io::Error::other)
    }

    fn write_group(&mut self) -> io::Result<()> {
        self.group().map_err(io::Error::other)?;
        self.names.clear();
        self.columns.iter_mut().for_each(Vec::clear);
        Ok(())
    }

    fn group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        if let Some(mut column) = group.next_column()? {
            let names = column.typed::<ByteArrayType>();
            names.write_batch(&self.names, None, None)?;
            column.close()?;
        }
        for numbers in &self.columns {
            if let Some(mut column) = group.next_column()? {
                let present: Vec<i16> = numbers.iter().map(|n| i16::from(n.is_some())).collect();
                let values: Vec<f64> = numbers.iter().flatten().copied().collect();
                let numbers = column.typed::<DoubleType>();
                numbers.write_batch(&values, Some(&present), None)?;
                column.close()?;
            }
        }
        group.close()?;
        Ok(())
    }
}

fn schema(head: &[String]) -> Result<Type, ParquetError> {
    let names = Type::primitive_type_builder("recording", Physical::BYTE_ARRAY)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(Some(LogicalType::String))
        .build()?;
    let numbers = head.iter().map(|name| {
        Type::primitive_type_builder(name, Physical::DOUBLE)
            .with_repetition(Repetition::OPTIONAL)
            .build()
    });
    let fields = std::iter::once(Ok(names)).chain(numbers).map(|field| field.map(Arc::new));
    Type::group_type_builder("traces").with_fields(fields.collect::<Result<_, _>>()?).build()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::parquet::file::reader::{FileReader as _, SerializedFileReader};
    use ::parquet::record::Field;

    /// One more row than a group, so that the file has two groups.
    #[test]
    fn all_rows_read_back_and_missing_values_are_null() {
        let mut file = tempfile::tempfile().unwrap();
        let head = ["t [s]", "Fz calc [N]"].map(str::to_owned);
        let mut table = ParquetTable::new(&head, &mut file).unwrap();
        for k in 0..=GROUP_ROWS {
            let truth = (k % 2 == 0).then_some(k as f64 / 3.0);
            table.push("run 力", &[Some(k as f64), truth]).unwrap();
        }
        table.finish().unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        assert_eq!(reader.num_row_groups(), 2);
        let mut n = 0;
        for (k, row) in reader.get_row_iter(None).unwrap().enumerate() {
            let row = row.unwrap();
            let fields: Vec<_> = row.get_column_iter().collect();
            assert_eq!(*fields[0].1, Field::Str("run 力".to_owned()));
            assert_eq!((&**fields[1].0, fields[1].1), ("t [s]", &Field::Double(k as f64)));
            let truth = match k % 2 {
                0 => Field::Double(k as f64 / 3.0),
                _ => Field::Null,
            };
            assert_eq!(*fields[2].1, truth);
            n += 1;
        }
        assert_eq!(n, GROUP_ROWS + 1);
    }
}
