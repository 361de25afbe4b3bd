//! Position of a table in a text file, and division of its text into cells. Both are detected or given by a column map.
//! Detection never fails, and depends only on the first lines, not on the size of the blocks.

mod detect;
mod start;

use detect::is_lone_word;
pub(super) use detect::is_value;
pub(crate) use detect::{detect, is_header, is_units_row, words};

pub(super) use self::start::HEAD_BYTES;
pub(super) use self::start::names;
use self::start::{Line, first_lines, unbracketed};
use super::{
    ati,
    cells::{Cells, is_skipped, lines},
    written::{Preamble, TextLayout},
};
use crate::formats::{
    column_name::{ColumnName, is_known_unit},
    columns::Sample,
};
use crate::recording::units::force_in_newtons;

/// Position and header of a table in its file, if the file has a given layout.
#[derive(Debug, Default)]
pub struct Head {
    /// Number of the line with the header, or with the first row if there is no header.
    pub line: u64,
    /// Names of the columns in the header; empty without a header.
    pub names: Vec<String>,
    /// Column names from a comment above the rows, if there is no header and the comment names every column.
    pub names_in_comment: Vec<String>,
    /// Units of the columns in the line after the header; empty without such a line.
    pub units: Vec<String>,
    /// Number of columns: cells of the header, or, without a header, cells of most of the first rows.
    pub n_columns: usize,
    /// Number of lines before the first line that may be a row.
    pub n_lines: u64,
    /// Position in the file where the first line that may be a row starts (bytes).
    pub n_bytes: usize,
    pub ati: Option<ati::Preamble>,
    /// Unit of a load, and sample rate (Hz), from lines such as `# unit: kg` above the table.
    pub load_unit: Option<String>,
    pub rate_hz: Option<f64>,
    /// Position in the file where the table ends (bytes), if other text follows it.
    pub end_bytes: Option<usize>,
    /// Index of the time column for a reference with its own clock, if the file declares one.
    pub reference_time: Option<usize>,
}

impl Head {
    pub fn name(&self, index: usize) -> Option<ColumnName> {
        self.names.get(index).map(|name| ColumnName::parse(name))
    }

    /// Takes the unit of the load and the sample rate from lines above the table, such as `Unit=kN` and `# rate: 80 Hz`.
    fn take_notes(&mut self, all: &[Line<'_>]) {
        const UNITS: [&str; 4] = ["unit", "units", "einheit", "force unit"];
        const RATES: [&str; 5] =
            ["rate", "sample rate", "sampling rate", "sampling frequency", "abtastrate"];
        let above = all.iter().take_while(|line| line.end <= self.n_bytes || is_skipped(line.text));
        for line in above {
            let text = String::from_utf8_lossy(line.text);
            let Some((word, value)) = text.trim_start_matches(['#', ' ']).split_once([':', '='])
            else {
                continue;
            };
            let (word, value) = (word.trim().to_lowercase(), value.trim());
            if UNITS.contains(&&*word) && force_in_newtons(value).is_some() {
                self.load_unit = Some(value.to_owned());
            }
            let rate = value.trim_end_matches("Hz").trim_end().parse();
            if let (true, Ok(rate)) = (RATES.contains(&&*word), rate) {
                self.rate_hz = Some(rate).filter(|rate: &f64| *rate > 0.0);
            }
        }
    }

    /// Returns the unit of a column: from the units row if it is a known unit, else from the header or the units row.
    pub fn unit(&self, index: usize) -> Option<String> {
        let in_units_row = || {
            let unit = unbracketed(self.units.get(index)?);
            (!unit.is_empty()).then(|| unit.to_owned())
        };
        let below = in_units_row();
        let is_known = below.as_deref().is_some_and(is_known_unit);
        let in_header = || self.name(index).and_then(|name| name.unit);
        if is_known { below } else { in_header().or(below) }
    }
}

/// Finds the header or the first row of a table in the first bytes of a file; `None` if the layout does not fit.
pub fn locate(head: &[u8], layout: &TextLayout) -> Option<Head> {
    let all = first_lines(head, layout.skip_rows);
    let ati = match layout.preamble {
        Some(Preamble::AtiNetFt) => Some(ati::Preamble::of(all.iter().map(|line| line.text))?),
        None => None,
    };
    let n_skipped = ati.as_ref().map_or(layout.skip_rows, |preamble| preamble.n_lines);
    let mut rows = all.iter().skip(n_skipped).filter(|line| !is_skipped(line.text)).peekable();
    let delimiter = layout.delimiter;
    let mut start = Head {
        n_lines: n_skipped as u64,
        n_bytes: n_skipped.checked_sub(1).map_or(Some(0), |last| Some(all.get(last)?.end))?,
        ati,
        ..Head::default()
    };
    start.take_notes(&all);
    if layout.header {
        let header = rows.next()?;
        start.line = header.number;
        start.names = names(header.text, delimiter);
        start.n_columns = start.names.len();
        let last = if layout.units_row {
            let below = rows.next()?;
            let cells = names(below.text, delimiter);
            match under_groups(&start.names, &cells) {
                Some(names) if !is_units_row(below.text, delimiter) => start.names = names,
                _ => start.units = cells,
            }
            start.n_columns = start.n_columns.max(start.names.len());
            below
        } else {
            header
        };
        (start.n_lines, start.n_bytes) = (last.number, last.end);
        // A word below the header, alone in its line, is no row: catman writes the sample rate there.
        while let Some(line) =
            rows.next_if(|line| start.n_columns > 1 && is_lone_word(line.text, delimiter))
        {
            (start.n_lines, start.n_bytes) = (line.number, line.end);
        }
        // The header may name the first columns only. One value too many is an extra cell.
        let filled = |line: &&Line| {
            let cells: Vec<&[u8]> = Cells::new(line.text, delimiter).collect();
            cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1)
        };
        let width = most_frequent(&rows.by_ref().map(|line| filled(&line)).collect::<Vec<_>>());
        if start.names.len() > 2 && width > start.names.len() + 1 {
            start.n_columns = width;
            start.names.resize(width, String::new());
        }
    } else {
        start.line = rows.peek()?.number;
        start.n_columns = most_frequent(
            &rows.map(|line| Cells::new(line.text, delimiter).count()).collect::<Vec<_>>(),
        );
        // The first row may have fewer cells than the table, so the names are counted against all columns.
        start.names_in_comment = detect::names_in_comment(&all, delimiter)
            .filter(|names| names.len() == start.n_columns)
            .unwrap_or_default();
    }
    start.end_bytes = detect::end_of_table(head, &all, start.n_lines, delimiter);
    Some(start)
}

/// Returns the names of columns from two rows of a header, the first of which names groups of columns: `Hip X1`. `None` if no
/// column has a name only in the second row.
fn under_groups(above: &[String], below: &[String]) -> Option<Vec<String>> {
    let mut group = "";
    let mut has_group = false;
    let mut name = |index: usize| {
        let [above, below] = [above, below].map(|row| row.get(index).map_or("", String::as_str));
        if !above.is_empty() {
            group = above;
        }
        has_group |= above.is_empty() && !below.is_empty() && !group.is_empty();
        match below {
            "" => above.to_owned(),
            _ => format!("{group} {below}").trim_start().to_owned(),
        }
    };
    let names: Vec<String> = (0..above.len().max(below.len())).map(&mut name).collect();
    has_group.then_some(names)
}

pub fn sample<'a>(
    head: &'a [u8],
    layout: &TextLayout,
    start: &Head,
    places: &'a [Vec<u8>],
) -> Sample<'a> {
    let mut sample = Sample::default();
    let first = first_lines(&head[start.n_bytes..start.end_bytes.unwrap_or(head.len())], 0);
    let row = |text| Some(layout.row(text)?.collect::<Vec<_>>());
    sample.add_place(first.iter().filter_map(|line| row(line.text)));
    for place in places {
        sample.add_place(lines(place).filter_map(|line| row(line.trim_ascii_end())));
    }
    sample
}

/// Returns the position behind the first lines, which are inspected, and the mean length of these lines (bytes).
pub fn inspected(head: &[u8]) -> (usize, usize) {
    let lines = first_lines(head, 0);
    let end = lines.last().map_or(0, |line| line.end);
    (end, end / lines.len().max(1))
}

/// Returns the number that occurs most often (of several, the first), or 0 for an empty list.
fn most_frequent(numbers: &[usize]) -> usize {
    let count = |number: &&usize| numbers.iter().filter(|other| other == number).count();
    // `max_by_key` returns the last of equal elements, so the order is reversed to get the first.
    numbers.iter().rev().max_by_key(count).copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::text::Delimiter;
    use crate::formats::text::Delimiter::Semicolon;

    /// This program writes tables with such names, so that no spreadsheet takes a name for a formula.
    #[test]
    fn a_guarded_name_is_read_without_its_guard() {
        let found = names(b"t,'=S1 [V],\"'@S,2\",'S3", Delimiter::Comma);
        assert_eq!(found, ["t", "=S1 [V]", "@S,2", "'S3"]);
    }

    #[test]
    fn a_bracket_that_is_never_closed_takes_the_rest_of_the_line() {
        let cells = |text: &str| names(text.as_bytes(), Delimiter::Spaces);
        assert_eq!(cells("t (m s) S1 [V ] x"), ["t (m s)", "S1 [V ]", "x"]);
        let text = format!("t [s] S1 (V{}", " a".repeat(300_000));
        assert_eq!(cells(&text).len(), 2);
    }

    #[test]
    fn two_rows_of_a_header_give_one_name_each() {
        let head = b"Frame#\tTime\tHip\t\t\tKnee\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n1\t0.1\t1\t2\t3\t4\t5\t6\n2\t0.2\t1\t2\t3\t4\t5\t6\n3\t0.3\t1\t2\t3\t4\t5\t7\n";
        let layout = detect(head).unwrap();
        assert!(layout.header && layout.units_row);
        let start = locate(head, &layout).unwrap();
        let names =
            ["Frame#", "Time", "Hip X1", "Hip Y1", "Hip Z1", "Knee X2", "Knee Y2", "Knee Z2"];
        assert_eq!((start.names, start.n_columns), (names.map(str::to_owned).to_vec(), 8));
        let units = b"t;S1;Fx\n;mV;N\n1;2;3\n4;5;6\n";
        let start = locate(units, &detect(units).unwrap()).unwrap();
        assert_eq!((start.names[1].as_str(), start.units[1].as_str()), ("S1", "mV"));
    }

    #[test]
    fn a_table_is_found_by_its_layout() {
        let head = b"x\nA;B [N]\n[s];[N]\n# c\n1;2\n3;4\n";
        let layout = TextLayout {
            delimiter: Semicolon,
            skip_rows: 1,
            header: true,
            units_row: true,
            ..TextLayout::default()
        };
        let start = locate(head, &layout).unwrap();
        assert_eq!((start.line, start.n_lines), (2, 3));
        assert_eq!(start.names, ["A", "B [N]"]);
        assert_eq!(start.units, ["[s]", "[N]"]);
        assert!(head[start.n_bytes..].starts_with(b"# c"));
        let headerless = TextLayout { skip_rows: 4, header: false, ..layout.clone() };
        let start = locate(head, &headerless).unwrap();
        assert_eq!((start.line, start.n_lines, start.n_columns), (5, 4, 2));
        let beyond = TextLayout { skip_rows: 9, ..layout };
        assert!(locate(head, &beyond).is_none());
    }
}
