//! Tables as plain data, and their conversion to text.
//!
//! Guarantees: every row has a cell for each column. A cell of a number contains the exact number and a rounded text.

use std::io;

use crate::{
    formats::csv::CsvWriter,
    recording::Axis,
    report::trace::Trace,
    scoring::{metrics::percent_change, numbers::significant},
    shown::{first, printable},
};

/// Maximum number of columns that are named before a reason which their cells have instead of a number.
const NAMED: usize = 6;

/// Rows and columns of numbers, texts, and reasons for missing numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Title of the table; may be empty.
    pub title: String,
    /// Columns from left to right.
    pub columns: Vec<Column>,
    /// Rows with one cell per column.
    pub rows: Vec<Vec<Cell>>,
    /// Note below the table; may be empty.
    pub note: String,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Align {
    #[default]
    Left,
    Right,
    /// Left-aligned hexadecimal digits, which may be broken into lines anywhere.
    Anywhere,
}

/// The head of a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Name and explanation of the table from which the column comes, if [`Table::beside`] joined tables.
    pub group: Option<(String, String)>,
    /// Short name of the column.
    pub name: String,
    /// Unit of the numbers in the column; empty if each row has its own unit.
    pub unit: &'static str,
    /// Alignment of the cells in the column.
    pub align: Align,
    /// Explanation of the column; may be empty.
    pub about: String,
    /// Load (reference, uncompensated, compensated, factory) that the numbers describe; `None` for other columns.
    pub trace: Option<Trace>,
}

impl Column {
    /// Returns the head of a column of words.
    pub fn words(name: impl Into<String>) -> Self {
        let name = name.into();
        Self { name, ..Self::default() }
    }

    /// Returns the head of a column of numbers.
    pub fn numbers(name: impl Into<String>) -> Self {
        Self { align: Align::Right, ..Self::words(name) }
    }

    /// Returns the head of a column of numbers that describe one load, such as the compensated load.
    pub fn of(trace: Trace, unit: &'static str) -> Self {
        let head = Self { trace: Some(trace), ..Self::numbers(trace.label()) };
        head.unit(unit).about(trace.explanation())
    }

    /// Returns the head of the column with this unit.
    pub fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Returns the head of the column with this explanation.
    pub fn about(self, about: impl Into<String>) -> Self {
        Self { about: about.into(), ..self }
    }

    /// Returns the head of a column with loads on this axis.
    pub fn load(axis: Axis) -> Self {
        Self::numbers(axis.symbol()).unit(axis.unit())
    }

    /// Returns the head of a column with the [change](Cell::change) between the two columns to its left.
    pub fn change() -> Self {
        Self::numbers("change").about("Change in percent from Uncompensated to Compensated")
    }

    /// Returns the head of the column as text: group, name and unit.
    pub fn title(&self) -> String {
        let group =
            (self.group.as_ref()).map_or_else(String::new, |(group, _)| format!("{group} "));
        match self.unit {
            "" => format!("{group}{}", self.name),
            unit => format!("{group}{} [{unit}]", self.name),
        }
    }
}

/// Kind and value of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A text.
    Words,
    /// A number in full precision.
    Number(f64),
    /// A missing number. The explanation of the cell is the reason.
    Missing,
    /// Empty cell, over which the cell to its left extends.
    Continued,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Displayed text: a rounded number or, for a missing number, one or two words in its place.
    pub text: String,
    pub value: Value,
    /// Explanation of a number or text, or the reason for a missing number; may be empty.
    pub about: String,
}

impl Cell {
    fn new(value: Value, text: impl Into<String>, about: impl Into<String>) -> Self {
        let (text, about) = (text.into(), about.into());
        Self { text, value, about }
    }

    pub fn words(text: impl Into<String>) -> Self {
        Self::new(Value::Words, text, "")
    }

    pub fn number(value: f64, text: impl Into<String>) -> Self {
        Self::new(Value::Number(value), text, "")
    }

    /// Returns a cell with this number, shown with `digits` significant digits; a dash for `None`.
    pub fn digits(value: Option<f64>, digits: usize) -> Self {
        value.map_or_else(Self::none, |value| Self::number(value, significant(value, digits)))
    }

    pub fn whole(number: usize) -> Self {
        Self::number(number as f64, number.to_string())
    }

    /// Returns a cell with the change from `from` to `to` in percent; a dash if `from` is zero.
    pub fn change(from: f64, to: f64) -> Self {
        let change = percent_change(from, to);
        change.map_or_else(Self::none, |change| Self::number(change, format!("{change:+.1} %")))
    }

    /// Returns a cell for a missing number with its reason. A narrow cell shows `word` instead of the reason.
    pub fn missing(word: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::new(Value::Missing, word, reason)
    }

    /// Returns the cell. For `None`, returns a dash with this reason for the missing number.
    pub fn known(cell: Option<Self>, reason: impl Into<String>) -> Self {
        cell.unwrap_or_else(|| Self::missing("–", reason))
    }

    pub fn none() -> Self {
        Self::missing("–", "")
    }

    pub fn continued() -> Self {
        Self::new(Value::Continued, "", "")
    }

    pub fn about(self, about: impl Into<String>) -> Self {
        let about = about.into();
        Self { about, ..self }
    }

    /// Returns the reason for a missing number, if the cell has one.
    pub fn reason(&self) -> Option<&str> {
        (self.value == Value::Missing && !self.about.is_empty()).then_some(&self.about)
    }
}

pub struct Rows<R> {
    of: Vec<R>,
    table: Table,
    /// For each row, the cell that is repeated in every column that is added from now on. `None` if the row computes its
    /// cells.
    instead: Vec<Option<Cell>>,
}

impl<R> Rows<R> {
    /// Adds a column. `head` is its head, and `cell` returns the cell of a row.
    pub fn column(mut self, head: Column, cell: impl Fn(&R) -> Cell) -> Self {
        self.table.columns.push(head);
        let rows = self.table.rows.iter_mut().zip(&self.of).zip(&mut self.instead);
        for ((cells, row), instead) in rows {
            cells.push(match instead {
                Some(other) => std::mem::replace(other, Cell::continued()),
                None => cell(row),
            });
        }
        self
    }

    pub fn columns<C>(
        self,
        of: impl IntoIterator<Item = C>,
        head: impl Fn(&C) -> Column,
        cell: impl Fn(&R, &C) -> Cell,
    ) -> Self {
        of.into_iter()
            .fold(self, |rows, column| rows.column(head(&column), |row| cell(row, &column)))
    }

    pub fn words<T: Into<String>>(self, name: impl Into<String>, text: impl Fn(&R) -> T) -> Self {
        self.column(Column::words(name), |row| Cell::words(text(row)))
    }

    /// Adds a column of numbers with `digits` significant digits. A missing number is a dash.
    pub fn digits(
        self,
        name: impl Into<String>,
        digits: usize,
        value: impl Fn(&R) -> Option<f64>,
    ) -> Self {
        self.column(Column::numbers(name), |row| Cell::digits(value(row), digits))
    }

    pub fn about(mut self, about: impl Into<String>) -> Self {
        if let Some(last) = self.table.columns.last_mut() {
            last.about = about.into();
        }
        self
    }

    /// Replaces all columns added later by a single cell, in the rows for which `cell` returns a cell.
    pub fn instead(mut self, cell: impl Fn(&R) -> Option<Cell>) -> Self {
        self.instead = self.of.iter().map(cell).collect();
        self
    }

    /// Returns the finished table; title and note may be empty.
    pub fn table(self, title: impl Into<String>, note: impl Into<String>) -> Table {
        Table { title: title.into(), note: note.into(), ..self.table }
    }
}

impl Table {
    /// Begins a table with one row per item.
    pub fn of<R>(rows: impl IntoIterator<Item = R>) -> Rows<R> {
        let of: Vec<R> = rows.into_iter().collect();
        let table = Self { rows: vec![Vec::new(); of.len()], ..Self::default() };
        Rows { instead: vec![None; of.len()], of, table }
    }

    /// Returns the text of a cell for screen readers: column, row, value and unit, or the reason for a missing number.
    pub fn spoken(&self, row: usize, column: usize) -> String {
        let cell = &self.rows[row][column];
        // The name of a row consists of the texts in its first columns. An empty cell repeats the cell above.
        let is_named = |at: &usize| matches!(self.rows[row][*at].value, Value::Words);
        let name = |at: usize| {
            let mut texts = self.rows[..=row].iter().rev().map(|row| row[at].text.as_str());
            texts.find(|text| !text.is_empty()).unwrap_or("")
        };
        let names: Vec<&str> = (0..column).take_while(is_named).map(name).collect();
        let mut names = names.join(" ");
        let mut unit = self.columns[column].unit.to_owned();
        if unit.is_empty()
            && let Some((name, found)) = names.strip_suffix(']').and_then(|it| it.rsplit_once(" ["))
        {
            (unit, names) = (found.to_owned(), name.to_owned());
        }
        let is_number = matches!(cell.value, Value::Number(_)) && !cell.text.ends_with('%');
        let group = self.columns[column].group.as_ref();
        let hover = match cell.reason() {
            Some(reason) if cell.text == "–" => reason.to_owned(),
            Some(reason) => format!("{}: {reason}", cell.text),
            None => cell.text.clone(),
        };
        let parts = [
            group.map_or("", |(group, _)| group),
            &self.columns[column].name,
            &names,
            &hover,
            if is_number { &unit } else { "" },
        ];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        parts.join(" ")
    }

    /// Joins tables side by side that have the same first column. The other columns are grouped under the names of the
    /// tables.
    pub fn beside(title: &str, tables: impl IntoIterator<Item = (String, Self)>) -> Self {
        let mut all = Self { title: title.to_owned(), ..Self::default() };
        for (name, table) in tables {
            let known = usize::from(!all.columns.is_empty());
            let about = [table.title, table.note].join("\n");
            let group = Some((name, about.trim().to_owned()));
            for (at, mut column) in table.columns.into_iter().enumerate().skip(known) {
                column.group = group.clone().filter(|_| at > 0);
                all.columns.push(column);
            }
            all.rows.resize(table.rows.len(), Vec::new());
            for (row, cells) in all.rows.iter_mut().zip(table.rows) {
                row.extend(cells.into_iter().skip(known));
            }
        }
        all
    }

    /// Returns the table with this number of decimals for all loads and errors, so that it can be compared with other tables.
    pub fn with_decimals(mut self, decimals: usize) -> Self {
        for (at, column) in self.columns.iter().enumerate() {
            let cells = self.rows.iter_mut().map(|row| &mut row[at]);
            for cell in cells.filter(|_| column.trace.is_some()) {
                if let Value::Number(number) = cell.value {
                    cell.text = format!("{number:.decimals$}");
                }
            }
        }
        self
    }

    /// Returns the indices of the rows sorted by one column: numbers by size, words alphabetically, missing values last. The
    /// sort is stable.
    pub fn order(&self, column: usize, descending: bool) -> Vec<usize> {
        let cell = |row: &usize| &self.rows[*row][column];
        let is_missing = |row: &usize| match cell(row).value {
            Value::Number(number) => number.is_nan(),
            Value::Words => cell(row).text.is_empty(),
            Value::Missing | Value::Continued => true,
        };
        let by_value = |a: &usize, b: &usize| match (cell(a).value, cell(b).value) {
            (Value::Number(a), Value::Number(b)) => a.total_cmp(&b),
            _ => cell(a).text.cmp(&cell(b).text),
        };
        let mut order: Vec<usize> = (0..self.rows.len()).collect();
        order.sort_by(|a, b| {
            let by_value = by_value(a, b);
            let by_value = if descending { by_value.reverse() } else { by_value };
            is_missing(a).cmp(&is_missing(b)).then(by_value)
        });
        order
    }

    /// Removes all other columns. `is_kept` gets the index and the head of a column.
    pub(crate) fn keep_columns(&mut self, is_kept: impl Fn(usize, &Column) -> bool) {
        let columns = self.columns.iter().enumerate();
        let kept: Vec<bool> = columns.map(|(at, column)| is_kept(at, column)).collect();
        for row in &mut self.rows {
            let mut at = kept.iter();
            row.retain(|_| *at.next().unwrap_or(&true));
        }
        let mut at = kept.iter();
        self.columns.retain(|_| *at.next().unwrap_or(&true));
    }

    /// Returns the table with its rows in the order of these indices.
    pub fn in_order(mut self, order: &[usize]) -> Self {
        let rows = order.iter().map(|at| std::mem::take(&mut self.rows[*at]));
        self.rows = rows.collect();
        self
    }

    /// Returns the table as aligned text for a terminal, with control characters escaped. A reason that is too long for its
    /// cell stands below the row.
    pub fn text(&self) -> String {
        let width = |text: &str| text.chars().count();
        let titles: Vec<String> = self.columns.iter().map(Column::title).collect();
        let widths = titles.iter().enumerate().map(|(at, title)| {
            let cells = self.rows.iter().map(|row| width(&row[at].text));
            cells.fold(width(title), usize::max)
        });
        let widths: Vec<usize> = widths.collect();
        let line = |texts: Vec<&str>| {
            let cells = self.columns.iter().zip(&widths).zip(texts);
            let cells = cells.map(|((column, width), text)| match column.align {
                Align::Right => format!("  {text:>width$}"),
                Align::Left | Align::Anywhere => format!("  {text:<width$}"),
            });
            cells.collect::<String>().trim_end().to_owned()
        };
        let mut lines =
            vec![self.title.clone(), line(titles.iter().map(|title| &**title).collect())];
        for row in &self.rows {
            let ends = |at: usize| row[at + 1..].iter().all(|cell| cell.value == Value::Continued);
            let texts = row.iter().enumerate();
            let texts =
                texts.map(|(at, cell)| cell.reason().filter(|_| ends(at)).unwrap_or(&cell.text));
            lines.push(line(texts.collect()));
            let cells = row.iter().zip(&self.columns).enumerate().filter(|(at, _)| !ends(*at));
            let reasons = cells.filter_map(|(_, (cell, column))| Some((cell.reason()?, column)));
            for same in reasons.collect::<Vec<_>>().chunk_by(|a, b| a.0 == b.0) {
                let names = first(NAMED, same.iter().map(|pair| &pair.1.name));
                lines.push(format!("    {names}: {}", same[0].0));
            }
        }
        lines.push(self.note.clone());
        lines.retain(|line| !line.is_empty());
        let lines = lines.iter().map(|line| printable(line));
        lines.map(|line| format!("{line}\n")).collect()
    }

    /// Returns the heads of the columns, then the rows, with exact numbers and full reasons for missing numbers.
    fn records(&self) -> Vec<Vec<String>> {
        let mut records = vec![self.columns.iter().map(Column::title).collect()];
        for row in &self.rows {
            let mut record: Vec<String> = Vec::new();
            for cell in row {
                record.push(match cell.value {
                    Value::Words => cell.text.clone(),
                    Value::Number(value) => value.to_string(),
                    Value::Missing => cell.about.clone(),
                    Value::Continued => record.last().cloned().unwrap_or_default(),
                });
            }
            records.push(record);
        }
        records
    }

    /// Returns the table as tab-separated text for the clipboard; tabs and line ends in a cell become blanks.
    pub fn tab_separated(&self) -> String {
        let lines: Vec<String> = self
            .records()
            .iter()
            .map(|record| {
                let cells = record.iter();
                let cells = cells.map(|cell| cell.replace(['\t', '\n', '\r'], " "));
                cells.collect::<Vec<_>>().join("\t")
            })
            .collect();
        lines.join("\n")
    }

    /// Writes the table as comma-separated text. Numbers that are read back have exactly the same value.
    ///
    /// # Errors
    /// The I/O errors of `out`.
    pub fn write_csv(&self, out: &mut dyn io::Write) -> io::Result<()> {
        let mut csv = CsvWriter::new(out);
        for record in self.records() {
            csv.row(record)?;
        }
        csv.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the errors of two axes, the second of which was never loaded.
    fn table() -> Table {
        let both = [Trace::Conventional, Trace::Compensated].map(|trace| Column::of(trace, "N"));
        Table {
            title: "Errors".to_owned(),
            columns: [Column::words("Axis")].into_iter().chain(both).collect(),
            rows: vec![
                vec![
                    Cell::words("Fx"),
                    Cell::digits(Some(2.0 / 3.0), 3),
                    Cell::missing("1 cycle", "only one cycle"),
                ],
                vec![
                    Cell::words("Fy"),
                    Cell::missing("constant", "Fy is never loaded"),
                    Cell::continued(),
                ],
                vec![
                    Cell::words("Fz"),
                    Cell::missing("constant", "no load"),
                    Cell::digits(Some(12.5), 3),
                ],
            ],
            note: "Of one recording.".to_owned(),
        }
    }

    #[test]
    fn the_spoken_text_of_a_cell_has_its_place_and_the_reason_for_a_missing_number() {
        let mut table = table();
        assert_eq!(table.spoken(0, 1), "Uncompensated Fx 0.667 N");
        assert_eq!(table.spoken(0, 2), "Compensated Fx 1 cycle: only one cycle");
        let errors = [Cell::words("Fx [N]"), Cell::digits(Some(0.36), 3)];
        let below = [Cell::words(""), Cell::change(2.0, 1.0)];
        let columns = ["Axis", "RMSE"].map(Column::words);
        table = Table {
            columns: columns.to_vec(),
            rows: vec![errors.to_vec(), below.to_vec()],
            ..Table::default()
        };
        table.columns[1].group = Some(("Test".to_owned(), String::new()));
        assert_eq!(table.spoken(0, 1), "Test RMSE Fx 0.360 N");
        assert_eq!(table.spoken(1, 1), "Test RMSE Fx -50.0 %", "the row has the name above it");
    }

    #[test]
    fn text_is_aligned_and_tells_every_reason() {
        let expected = "Errors\n\
            \x20 Axis  Uncompensated [N]  Compensated [N]\n\
            \x20 Fx                0.667   only one cycle\n\
            \x20 Fy    Fy is never loaded\n\
            \x20 Fz             constant             12.5\n\
            \x20   Uncompensated: no load\n\
            Of one recording.\n";
        assert_eq!(table().text(), expected);
    }

    #[test]
    fn numbers_are_copied_in_full_and_reasons_are_in_each_cell() {
        let full = (2.0_f64 / 3.0).to_string();
        let expected = format!(
            "Axis\tUncompensated [N]\tCompensated [N]\nFx\t{full}\tonly one cycle\nFy\tFy is never loaded\tFy is never loaded\n\
             Fz\tno load\t12.5"
        );
        assert_eq!(table().tab_separated(), expected);
        let mut csv = Vec::new();
        table().write_csv(&mut csv).unwrap();
        let csv = String::from_utf8(csv).unwrap();
        assert_eq!(csv, format!("{}\n", expected.replace('\t', ",")));
    }

    #[test]
    fn tables_beside_each_other_share_their_first_column() {
        let tables = ["Train", "Test"].map(|name| (name.to_owned(), table()));
        let both = Table::beside("RMSE", tables);
        let titles: Vec<String> = both.columns.iter().map(Column::title).collect();
        let expected = [
            "Axis",
            "Train Uncompensated [N]",
            "Train Compensated [N]",
            "Test Uncompensated [N]",
            "Test Compensated [N]",
        ];
        assert_eq!(titles, expected);
        assert!(both.rows.iter().all(|row| row.len() == 5));
        let (_, about) = both.columns[4].group.as_ref().unwrap();
        assert_eq!(about, "Errors\nOf one recording.");
    }

    #[test]
    fn rows_are_sorted_by_a_column_with_missing_values_last() {
        assert_eq!(table().order(0, true), [2, 1, 0]);
        assert_eq!(table().order(1, false), [0, 1, 2], "one number");
        let mut table = table();
        table.rows[1][2] = Cell::digits(Some(-3.0), 3);
        assert_eq!(table.order(2, false), [1, 2, 0]);
        assert_eq!(table.order(2, true), [2, 1, 0]);
        let names: Vec<String> =
            (table.in_order(&[2, 0]).rows.iter()).map(|row| row[0].text.clone()).collect();
        assert_eq!(names, ["Fz", "Fx"]);
    }

    #[test]
    fn a_change_from_zero_is_a_dash() {
        assert_eq!(Cell::change(2.0, 1.0), Cell::number(-50.0, "-50.0 %"));
        assert_eq!(Cell::change(0.0, 1.0), Cell::none());
    }
}
