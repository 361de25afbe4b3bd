//! A CSV table of numbers, read without the program's own reader.

use std::path::Path;

/// Rows of numbers, with the names of the columns.
pub struct Table {
    pub header: Vec<String>,
    /// Numbers of each row; NaN for words.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// Reads a file with one header line and cells of numbers. A word, such as a status, becomes NaN.
    #[track_caller]
    pub fn read(path: &Path) -> Self {
        let mut csv = csv::ReaderBuilder::new();
        let mut csv = csv.comment(Some(b'#')).from_path(path).unwrap();
        Self {
            header: csv.headers().unwrap().iter().map(str::to_owned).collect(),
            rows: csv
                .records()
                .map(|row| row.unwrap().iter().map(|x| x.parse().unwrap_or(f64::NAN)).collect())
                .collect(),
        }
    }

    /// Returns the column whose name begins with this text.
    #[track_caller]
    pub fn column(&self, start: &str) -> Vec<f64> {
        let named = |name: &String| name.starts_with(start);
        let at = self.header.iter().position(named).expect(start);
        self.rows.iter().map(|row| row[at]).collect()
    }
}
