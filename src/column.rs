//! A column of a table.

/// Returns the values in one column of a row-major table with `width` columns.
pub(crate) fn column(
    rows: &[f64],
    width: usize,
    at: usize,
) -> impl ExactSizeIterator<Item = f64> + Clone {
    rows.chunks_exact(width.max(1)).map(move |row| row[at])
}
