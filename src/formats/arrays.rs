//! Turns named arrays of NumPy and MATLAB files into columns, which are named as in the header of a text file.
//!
//! | array | columns |
//! |---|---|
//! | vector | one, with the name of the array; `S1` for gauges |
//! | `S`, `G`, `gauges`, `ch`, `raw` …, n × k | `S1` to `Sk` |
//! | `F`, `forces`, n × 3 | `Fx` `Fy` `Fz` |
//! | `M`, `T`, `moments`, `torques`, n × 3 | `Mx` `My` `Mz` |
//! | `F`, `loads`, `wrench`, `FT`, `reference` …, n × 6 | `Fx` to `Mz` (n × 3: the forces) |
//! | `X`, any other, n × k | `X1` to `Xk` |
//!
//! For a path such as `run.S` or `run/S`, the last part selects the row of this table. The columns keep the first part, as in
//! `run.S1`. n is the number of samples: the length of the time array, or, without one, the number of rows that most values
//! share. An array of k × n values is transposed.

use std::collections::HashMap;

use super::{
    columns::{Column, Columns},
    format::COLUMN_LIMIT,
};
use crate::{
    formats::column_name::{is_gauge_name, is_one_of, is_time_name},
    recording::Axis,
    shown::joined,
};

/// Names of arrays that hold gauges, in lower case, besides the names that columns of gauges have.
const GAUGES: &str = "gauges channels strains sensors signals volts";
const FORCES: &str = "f force forces forces_n f_n";
const MOMENTS: &str = "m t moment moments torque torques moments_nm torques_nm";
const LOADS: &str = "load loads wrench wrenches ft reference ref ati ground_truth";
/// Array names for the times of a reference that has its own clock, in lower case.
const REFERENCE_TIMES: &str =
    "t_ref time_ref t_reference time_reference reference_time ref_time t_loads time_loads";

/// Variable that is written to a NumPy or MATLAB file.
#[derive(Debug)]
pub enum Entry {
    Numbers(Array),
    Texts { name: String, texts: Vec<String> },
}

impl Entry {
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Numbers(array) => &array.name,
            Self::Texts { name, .. } => name,
        }
    }
}

/// Array of numbers as stored in a file.
#[derive(Debug, Default)]
pub struct Array {
    pub name: String,
    /// Unit of the array's values; empty if the file gives no unit.
    pub unit: &'static str,
    /// Names of the array's columns; empty if the file gives no names.
    pub labels: Vec<String>,
    pub shape: Vec<usize>,
    /// True if the values are stored column by column, as MATLAB does; false if row by row.
    pub is_by_column: bool,
    /// Number that was subtracted from each stored value, and must be added again. Large whole numbers keep all digits this way.
    pub since: i64,
    pub values: Vec<f64>,
}

/// Returns the arrays as columns of one table. Adds to `left_out` the arrays whose shape does not fit the table.
pub fn columns(arrays: Vec<Array>, mut left_out: Vec<String>) -> Columns {
    let n_rows = n_rows(&arrays);
    let reference_rows = reference_time(&arrays, n_rows).map(|array| array.values.len());
    let mut table = Columns { is_named: true, ..Columns::default() };
    for array in arrays {
        let is_reference_time = array.is_reference_time();
        let n_rows = match reference_rows {
            Some(rows) if is_reference_time || (is_load(&array.name) && array.has_rows(rows)) => {
                rows
            }
            _ => n_rows,
        };
        let array = if array.has_rows(n_rows) { array } else { array.transposed() };
        let n_columns = array.values.len().checked_div(n_rows).unwrap_or(0);
        if !array.has_rows(n_rows) || table.columns.len() + n_columns > COLUMN_LIMIT {
            left_out.push(format!("{} ({})", array.name, shape_in_words(&array.shape)));
            continue;
        }
        if is_reference_time {
            table.reference_time = Some(table.columns.len());
        }
        let names = if array.labels.len() == n_columns {
            array.labels.clone()
        } else {
            column_names(&array.name, n_columns, array.is_vector(), &table)
        };
        for (index, name) in names.into_iter().enumerate() {
            table.columns.push(Column {
                name,
                unit: array.unit.to_owned(),
                since: array.since,
                values: array.column(n_rows, n_columns, index),
                texts: None,
            });
        }
    }
    table.left_out = left_out;
    table
}

impl Array {
    pub fn is_time(&self) -> bool {
        is_time_name(&self.name) && self.is_vector() && self.values.len() > 1
    }

    fn is_reference_time(&self) -> bool {
        self.is_vector() && is_one_of(&last_part(&self.name).to_lowercase(), REFERENCE_TIMES)
    }

    fn is_vector(&self) -> bool {
        self.shape.iter().filter(|&&length| length != 1).count() <= 1
    }

    fn has_rows(&self, n_rows: usize) -> bool {
        match self.shape[..] {
            _ if n_rows == 0 || self.values.is_empty() => false,
            [length] => length == n_rows,
            [first, _] => first == n_rows,
            _ => false,
        }
    }

    fn transposed(mut self) -> Self {
        if self.shape.len() == 2 {
            self.shape.reverse();
            self.is_by_column = !self.is_by_column;
        }
        self
    }

    pub fn column(&self, n_rows: usize, n_columns: usize, column: usize) -> Vec<f64> {
        if self.is_by_column {
            self.values[column * n_rows..(column + 1) * n_rows].to_vec()
        } else {
            self.values.iter().skip(column).step_by(n_columns).copied().take(n_rows).collect()
        }
    }
}

pub fn n_rows(arrays: &[Array]) -> usize {
    if let Some(time) = arrays.iter().find(|array| array.is_time()) {
        return time.values.len();
    }
    let length = |array: &Array| match array.shape[..] {
        _ if array.is_vector() => Some(array.values.len()),
        [first, _] => Some(first),
        _ => None,
    };
    let mut numbers_in: HashMap<usize, usize> = HashMap::new();
    for array in arrays {
        if let Some(rows) = length(array) {
            *numbers_in.entry(rows).or_default() += array.values.len();
        }
    }
    numbers_in.into_iter().max_by_key(|&(rows, n)| (n, rows)).map_or(0, |(rows, _)| rows)
}

fn reference_time(arrays: &[Array], n_rows: usize) -> Option<&Array> {
    let has_gauge_time = arrays.iter().any(|array| {
        is_time_name(&array.name) && array.is_vector() && array.values.len() == n_rows
    });
    arrays.iter().find(|array| has_gauge_time && array.is_reference_time())
}

fn last_part(name: &str) -> &str {
    name.rsplit(['.', '/']).next().unwrap_or(name)
}

fn is_load(name: &str) -> bool {
    let name = last_part(name).to_lowercase();
    [FORCES, MOMENTS, LOADS].iter().any(|list| is_one_of(&name, list))
}

fn column_names(name: &str, n_columns: usize, is_vector: bool, table: &Columns) -> Vec<String> {
    let last = last_part(name);
    let before = &name[..name.len() - last.len()];
    let small = last.to_lowercase();
    let is_in = |list: &str| is_one_of(&small, list);
    if is_vector && n_columns == 1 && !is_in(GAUGES) {
        return vec![name.to_owned()];
    }
    let axes = match n_columns {
        3 if is_in(MOMENTS) => &Axis::ALL[3..],
        3 if is_load(name) => &Axis::ALL[..3],
        6 if is_in(FORCES) || is_in(LOADS) => &Axis::ALL[..],
        _ => &[],
    };
    if !axes.is_empty() {
        return axes.iter().map(|axis| format!("{before}{}", axis.symbol())).collect();
    }
    let first = format!("{before}S1");
    let is_free = || table.columns.iter().all(|column| column.name != first);
    let is_gauges = is_in(GAUGES) || is_gauge_name(&format!("{last}1"));
    let stem = if is_gauges && is_free() { "S" } else { last };
    (1..=n_columns).map(|k| format!("{before}{stem}{k}")).collect()
}

fn shape_in_words(shape: &[usize]) -> String {
    if shape.is_empty() { "one number".to_owned() } else { joined(" × ", shape) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(name: &str, shape: &[usize]) -> Array {
        let n = shape.iter().product::<usize>();
        Array {
            name: name.to_owned(),
            shape: shape.to_vec(),
            values: (0..n).map(|k| k as f64).collect(),
            ..Array::default()
        }
    }

    fn names(arrays: Vec<Array>) -> (Vec<String>, Vec<String>) {
        let table = columns(arrays, Vec::new());
        let names = table.columns.into_iter().map(|column| column.name);
        (names.collect(), table.left_out)
    }

    #[test]
    fn arrays_get_the_names_of_columns() {
        let (named, left_out) = names(vec![
            array("time", &[9]),
            array("gauges", &[9, 2]),
            array("raw", &[9, 2]),
            array("wrench", &[9, 6]),
            array("T", &[9, 3]),
            array("pose", &[9, 4]),
            array("Temp", &[1, 9]),
            array("rate", &[]),
            array("cube", &[9, 2, 2]),
        ]);
        let expected =
            "time S1 S2 raw1 raw2 Fx Fy Fz Mx My Mz Mx My Mz pose1 pose2 pose3 pose4 Temp";
        assert_eq!(named.join(" "), expected);
        assert_eq!(left_out, ["rate (one number)", "cube (9 × 2 × 2)"]);
    }

    #[test]
    fn a_transposed_array_is_turned_upright() {
        let table = columns(vec![array("t", &[3]), array("S", &[2, 3])], Vec::new());
        assert_eq!(table.columns[1].values, [0.0, 1.0, 2.0]);
        assert_eq!(table.columns[2].values, [3.0, 4.0, 5.0]);
        let upright = columns(vec![array("t", &[3]), array("S", &[3, 2])], Vec::new());
        assert_eq!(upright.columns[1].values, [0.0, 2.0, 4.0]);
    }

    #[test]
    fn an_empty_array_has_empty_columns() {
        for is_by_column in [false, true] {
            let empty = Array { is_by_column, ..array("S", &[0, 3]) };
            assert!((0..3).all(|column| empty.column(0, 3, column).is_empty()));
        }
    }

    #[test]
    fn a_reference_may_have_its_own_clock() {
        let arrays =
            vec![array("t", &[8]), array("S", &[8, 2]), array("t_ref", &[5]), array("F", &[5, 3])];
        let table = columns(arrays, Vec::new());
        assert_eq!(table.reference_time, Some(3));
        let lengths: Vec<usize> = table.columns.iter().map(|c| c.values.len()).collect();
        assert_eq!(lengths, [8, 8, 8, 5, 5, 5, 5]);
    }

    #[test]
    fn without_a_time_the_largest_array_sets_the_number_of_samples() {
        let arrays =
            vec![array("x", &[4]), array("y", &[4]), array("S", &[7, 3]), array("e", &[0, 9])];
        let (named, left_out) = names(arrays);
        assert_eq!(named, ["S1", "S2", "S3"]);
        assert_eq!(left_out.len(), 3);
    }
}
