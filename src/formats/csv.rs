//! Writes one recording as a table that every spreadsheet and this program can read. Numbers have a decimal point and the
//! shortest form that reads back as the same value.

use std::io::{self, Write};

use crate::recording::Recording;

/// Writer of comma-separated text in which spreadsheets find no formulas: a cell that begins with `=`, `+`, `-`, `@`, a tab
/// or a return gets a leading `'`. Spreadsheets hide this mark, and [`unguarded`] removes it from names.
pub(crate) struct CsvWriter<W: Write>(csv::Writer<W>);

impl<W: Write> CsvWriter<W> {
    pub fn new(out: W) -> Self {
        Self(csv::Writer::from_writer(out))
    }

    pub fn cell(&mut self, cell: impl AsRef<str>) -> io::Result<()> {
        let cell = cell.as_ref();
        if begins_a_formula(cell) && cell.parse::<f64>().is_err() {
            return Ok(self.0.write_field(format!("'{cell}"))?);
        }
        Ok(self.0.write_field(cell)?)
    }

    pub fn end_row(&mut self) -> io::Result<()> {
        Ok(self.0.write_record(None::<&[u8]>)?)
    }

    pub fn row(&mut self, cells: impl IntoIterator<Item = impl AsRef<str>>) -> io::Result<()> {
        for cell in cells {
            self.cell(cell)?;
        }
        self.end_row()
    }

    pub fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

fn begins_a_formula(cell: &str) -> bool {
    cell.starts_with(['=', '+', '-', '@', '\t', '\r'])
}

/// Returns a cell without the leading `'` with which [`CsvWriter`] prevents formulas.
pub(crate) fn unguarded(cell: &str) -> &str {
    match cell.strip_prefix('\'') {
        Some(text) if begins_a_formula(text) => text,
        _ => cell,
    }
}

/// Writes a recording as comma-separated text: a header, then per sample one row of time (s), gauges, load (N, N·m) and
/// auxiliary channels, as far as they are known. A load case has no time. The last column is the group, if the recording has one.
///
/// The header names the units: `t [s],S1,…,Fx [N],…,Mx [N·m]`. On an error, part of the table may have been written.
pub fn write_csv(recording: &Recording, out: &mut impl Write) -> io::Result<()> {
    let mut table = CsvWriter::new(out);
    let (axes, auxiliary) = (recording.axes(), recording.auxiliary());
    let is_timed = !recording.is_static();
    // The reader puts the name of the column before the value.
    let group = recording.group().map(|group| group.strip_prefix("group ").unwrap_or(group));
    let time = is_timed.then(|| "t [s]".to_owned());
    let auxiliary_label = |(name, unit): (&String, &String)| {
        if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") }
    };
    let header = (time.into_iter())
        .chain(recording.gauge_names().iter().cloned())
        .chain(axes.iter().map(|axis| axis.label()))
        .chain(auxiliary.names().iter().zip(auxiliary.units()).map(auxiliary_label))
        .chain(group.map(|_| "group".to_owned()));
    table.row(header)?;
    for (k, time) in recording.times().iter().enumerate() {
        let loads = &recording.loads()[k * axes.len()..(k + 1) * axes.len()];
        let numbers = (is_timed.then_some(time).into_iter())
            .chain(recording.gauges_at(k))
            .chain(loads)
            .chain(auxiliary.at(k));
        table.row(numbers.map(f64::to_string).chain(group.map(str::to_owned)))?;
    }
    table.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Axis, Source};

    fn recording(gauge_names: &[&str], gauges: Vec<f64>, axes: &[Axis]) -> Recording {
        let n = gauges.len() / gauge_names.len();
        Recording::new(
            "r",
            Source::Simulated,
            (0..n).map(|k| k as f64 / 20.0).collect(),
            gauge_names.iter().map(|&name| name.to_owned()).collect(),
            gauges,
            axes.to_vec(),
            (0..n * axes.len()).map(|i| (i as f64).sqrt()).collect(),
        )
        .unwrap()
    }

    fn written(recording: &Recording) -> String {
        let mut out = Vec::new();
        write_csv(recording, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn values_read_back_identical() {
        let gauges = vec![0.1 + 0.2, -0.0, 1e-300, -1.7e25, 5e-324, f64::MAX];
        let recording = recording(&["S1", "S2"], gauges, &[Axis::Fz, Axis::Mx]);
        let text = written(&recording);
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("t [s],S1,S2,Fz [N],Mx [N·m]"));
        for (k, line) in lines.by_ref().enumerate() {
            let bits: Vec<u64> =
                line.split(',').map(|field| field.parse::<f64>().unwrap().to_bits()).collect();
            let mut expected = vec![recording.times()[k].to_bits()];
            expected.extend(recording.gauges_at(k).iter().map(|s| s.to_bits()));
            expected.extend(recording.loads()[2 * k..2 * k + 2].iter().map(|l| l.to_bits()));
            assert_eq!(bits, expected);
        }
        assert_eq!(text.lines().count(), 1 + recording.n_samples());
    }

    #[test]
    fn no_name_is_a_formula_and_numbers_stay_numbers() {
        let names = ["=1+cmd|' /C calc'!A0", "@S", "-S", "+1", "'S", "S=1"];
        let text = written(&recording(&names, vec![-1.5, 1.0, -2e-9, 0.0, 0.0, 0.0], &[]));
        let (header, rows) = text.split_once('\n').unwrap();
        assert_eq!(header, "t [s],'=1+cmd|' /C calc'!A0,'@S,'-S,+1,'S,S=1");
        assert_eq!(rows, "0,-1.5,1,-0.000000002,0,0,0\n");
        let read: Vec<&str> = header.split(',').skip(1).map(unguarded).collect();
        assert_eq!(read, names);
    }

    #[test]
    fn names_are_quoted_where_they_need_it() {
        let text = written(&recording(&["a,b", "c\"d"], vec![1.0, 2.5], &[]));
        assert_eq!(text, "t [s],\"a,b\",\"c\"\"d\"\n0,1,2.5\n");
    }
}
