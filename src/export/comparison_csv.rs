//! The comparison of regressors as a table.

use std::io;

use crate::calibration::Scores;
use crate::recording::write_csv::CsvWriter;

/// What one row of the table says; [`analysis`](crate::analysis) has it, and this room stands below.
pub trait ComparisonRow {
    /// Regressor, history, and amount of data in words.
    fn labels(&self) -> [String; 3];
    /// The axes' names with their units.
    fn axes(&self) -> Vec<String>;
    /// RMSE per axis.
    fn scores(&self) -> &Scores;
    /// How long it took (s).
    fn seconds(&self) -> f64;
}

/// Writes one row per entry: labels, then RMSE per axis on train, on test and by leave-one-recording-out; an empty cell
/// where nothing could be scored.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write_comparison_csv(
    rows: &[impl ComparisonRow],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let mut csv = CsvWriter::new(out);
    for record in comparison_records(rows) {
        csv.row(record)?;
    }
    csv.flush()
}

/// The cells of the table, its head first.
#[must_use]
pub fn comparison_records(rows: &[impl ComparisonRow]) -> Vec<Vec<String>> {
    let axes = rows.first().map_or(Vec::new(), ComparisonRow::axes);
    let mut head = ["regressor", "history", "data", "seconds"]
        .map(str::to_owned)
        .to_vec();
    for set in ["train", "test", "leave-one-out"] {
        head.extend(axes.iter().map(|axis| format!("{axis} {set}")));
    }
    let mut records = vec![head];
    for row in rows {
        let mut record = row.labels().to_vec();
        record.push(format!("{:.3}", row.seconds()));
        let Scores {
            train_rmse,
            test_rmse,
            cv_rmse,
        } = row.scores();
        for rmse in [train_rmse, test_rmse, cv_rmse] {
            match rmse {
                Some(rmse) => record.extend(rmse.iter().map(f64::to_string)),
                None => record.extend(axes.iter().map(|_| String::new())),
            }
        }
        records.push(record);
    }
    records
}
