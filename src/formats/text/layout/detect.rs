use super::{
    super::{
        ati,
        cells::{
            Cells, decimal_comma_number, delimiter_of_header, is_skipped, number,
            unmistakable_number,
        },
        times::TimeForm,
    },
    most_frequent,
    start::{HEAD_BYTES, Line, first_lines, names, unbracketed},
};
use crate::formats::{
    column_name::{ColumnName, Kind, is_any_unit, is_known_unit},
    text::written::{Decimal, Delimiter, Preamble, TextLayout, Thousands},
};

/// Number of first lines of a file among which the header is searched.
const HEADER_LIMIT: usize = 60;

/// Detects the layout of a table from its first lines; `None` if all of them are blank or comments.
pub fn detect(head: &[u8]) -> Option<TextLayout> {
    let all = first_lines(head, 0);
    let lines: Vec<Line> = all.iter().copied().filter(|line| !is_skipped(line.text)).collect();
    lines.first()?;
    if let Some(preamble) = ati::Preamble::of(all.iter().map(|line| line.text)) {
        return Some(TextLayout {
            skip_rows: preamble.n_lines,
            header: true,
            preamble: Some(Preamble::AtiNetFt),
            ..TextLayout::default()
        });
    }
    let delimiter = delimiter_of_rows(&lines);
    let is_first_row = |at: usize| is_first_row(&lines[at..], delimiter);
    // A line with known column names is the header. Without such a line, the header is the line above the first row.
    let by_names = || {
        let is_header = |line: &Line| words(line.text).is_some_and(|cells| is_header(&cells));
        lines.iter().take(HEADER_LIMIT).position(is_header)
    };
    let holds = usual_values(&lines, delimiter);
    // Lines of a preamble may be as wide as the table, but do not have numbers in all its columns.
    let is_of_table = |at: usize| {
        let mut cells = Cells::new(lines[at].text, delimiter);
        holds.iter().all(|holds_value| {
            let is_there = |cell: &[u8]| cell.is_empty() || is_value(cell, delimiter);
            let cell = cells.next();
            !holds_value || cell.is_none_or(is_there)
        })
    };
    let first_row =
        (0..lines.len().min(HEADER_LIMIT)).find(|&at| is_first_row(at) && is_of_table(at));
    let first_row = first_row.map(|row| of_longest_table(&lines, row, delimiter));
    let header = match first_row {
        Some(0) => None,
        Some(row) => {
            by_names().filter(|at| *at < row).or_else(|| header_above(&lines, row, delimiter))
        }
        None => Some(by_names().unwrap_or(0)),
    };
    let below_header = header.map_or(0, |at| at + 1);
    let delimiter = match header.map(|at| (at, delimiter_of_header(lines[at].text))) {
        Some((at, named)) if fits_rows(&lines[at..], named) => named,
        _ => delimiter,
    };
    let is_units_row =
        |line: &Line| header.is_some_and(|at| is_below_names(lines[at].text, line.text, delimiter));
    let start = header.or(first_row).unwrap_or(0);
    Some(TextLayout {
        delimiter,
        thousands: thousands_of(&lines[below_header..], delimiter),
        decimal: decimal_of(&lines[below_header..], delimiter),
        skip_rows: if start == 0 { 0 } else { lines[start].number as usize - 1 },
        header: header.is_some(),
        units_row: lines.get(below_header).is_some_and(is_units_row),
        ..TextLayout::default()
    })
}

/// Returns true if a cell holds a number or a time.
pub fn is_value(cell: &[u8], delimiter: Delimiter) -> bool {
    number(cell).is_some()
        || (delimiter.allows_decimal_comma() && decimal_comma_number(cell).is_some())
        || unmistakable_number(cell).is_some()
        || TimeForm::of_all([cell].into_iter()).is_some()
}

/// Returns, for each column of the table, true if most of its cells in the later lines hold a value.
fn usual_values(lines: &[Line], delimiter: Delimiter) -> Vec<bool> {
    let later = &lines[lines.len() / 2..];
    let rows = later.iter().filter(|line| is_rowlike(line.text, delimiter));
    let mut counts: Vec<usize> = Vec::new();
    let mut n_rows = 0;
    for row in rows {
        n_rows += 1;
        for (index, cell) in Cells::new(row.text, delimiter).enumerate() {
            if index == counts.len() {
                counts.push(0);
            }
            counts[index] += usize::from(!cell.is_empty() && is_value(cell, delimiter));
        }
    }
    counts.into_iter().map(|count| 2 * count > n_rows).collect()
}

/// Returns true if any delimiter divides the line into cells that are all values (numbers or times).
fn holds_only_values(text: &[u8]) -> bool {
    Delimiter::ALL.into_iter().any(|delimiter| {
        Cells::new(text, delimiter).all(|cell| cell.is_empty() || is_value(cell, delimiter))
    })
}

/// Returns the delimiter that divides the lines into the most cells with values and the fewest other cells.
fn delimiter_of_rows(lines: &[Line]) -> Delimiter {
    let score = |delimiter: Delimiter| -> usize {
        let of_line = |line: &Line| {
            let (n_values, n_others) = counts(line.text, delimiter);
            n_values.saturating_sub(2 * n_others)
        };
        lines.iter().map(of_line).sum()
    };
    use Delimiter::{Comma, Semicolon, Spaces, Tab};
    // `max_by_key` returns the last of equal elements, so the comma is preferred.
    let candidates = [Spaces, Tab, Semicolon, Comma];
    candidates.into_iter().max_by_key(|&d| score(d)).unwrap_or(Comma)
}

/// Returns how many cells of a line hold a value (number or time), and how many do not.
fn counts(text: &[u8], delimiter: Delimiter) -> (usize, usize) {
    let (values, others): (Vec<_>, Vec<_>) = Cells::new(text, delimiter)
        .filter(|cell| !cell.is_empty())
        .partition(|cell| is_value(cell, delimiter));
    (values.len(), others.len())
}

fn is_rowlike(text: &[u8], delimiter: Delimiter) -> bool {
    let (n_values, n_others) = counts(text, delimiter);
    n_values > n_others
}

/// Returns true if the first of these lines is a row of samples: as many cells as the next two lines, mostly values, and a
/// value wherever the next line has one.
fn is_first_row(lines: &[Line], delimiter: Delimiter) -> bool {
    let cells = |line: &Line| -> Vec<bool> {
        let is_value = |cell: &[u8]| cell.is_empty() || is_value(cell, delimiter);
        Cells::new(line.text, delimiter).map(is_value).collect()
    };
    let Some(first) = lines.first() else {
        return false;
    };
    let of_first = cells(first);
    let mut following = lines[1..].iter().take(2);
    let is_like = |line: &Line| {
        let of_line = cells(line);
        is_rowlike(line.text, delimiter)
            && of_line.len() == of_first.len()
            && of_line.iter().zip(&of_first).all(|(later, first)| *first || !later)
    };
    is_rowlike(first.text, delimiter) && following.all(is_like)
}

/// Returns the first row of the longest of several tables that follow each other, such as results and data, each below names
/// of its own and these below a blank line or a title. The first table begins at `row`. The same names again belong to the
/// same table.
fn of_longest_table(lines: &[Line], row: usize, delimiter: Delimiter) -> usize {
    let n_rows =
        |at: usize| lines[at..].iter().take_while(|line| is_rowlike(line.text, delimiter)).count();
    let above = |at: usize| at.checked_sub(1).map_or(&b""[..], |above| lines[above].text);
    let is_apart = |at: usize| {
        let follows = |two: &[Line]| two[1].number == two[0].number + 1;
        let near = &lines[at.saturating_sub(3)..=at];
        !near.windows(2).all(follows) || near.iter().any(|own| is_lone_word(own.text, delimiter))
    };
    let are_names = |text| {
        let cells = || Cells::new(text, delimiter).filter(|cell| !cell.is_empty());
        cells().all(|cell| !is_value(cell, delimiter)) && cells().nth(1).is_some()
    };
    let is_start = |at: &usize| {
        are_names(above(*at))
            && above(*at) != above(row)
            && is_apart(*at)
            && is_first_row(&lines[*at..], delimiter)
    };
    (row + 1..lines.len())
        .filter(is_start)
        .fold(row, |longest, at| if n_rows(at) > n_rows(longest) { at } else { longest })
}

/// Returns the cells of a line; `None` if all of them are values.
pub fn words(text: &[u8]) -> Option<Vec<String>> {
    (!holds_only_values(text)).then(|| names(text, delimiter_of_header(text)))
}

/// Returns true if these cells name a time column, and a gauge or a load.
pub fn is_header(cells: &[String]) -> bool {
    let kinds: Vec<Kind> = cells.iter().filter_map(|cell| ColumnName::parse(cell).kind).collect();
    kinds.contains(&Kind::Time) && kinds.iter().any(|kind| *kind != Kind::Time)
}

/// Returns true if the delimiter divides the rows below the header into values. `lines` starts with the header. The words of a
/// header above a single column are one name.
fn fits_rows(lines: &[Line], delimiter: Delimiter) -> bool {
    let row = lines.iter().skip(1).find(|line| holds_only_values(line.text));
    let n_cells = |line: &Line| names(line.text, delimiter).len();
    row.is_none_or(|row| {
        is_rowlike(row.text, delimiter)
            && (delimiter != Delimiter::Spaces || n_cells(row) > 1 || n_cells(&lines[0]) == 1)
    })
}

/// Returns the index of the header of a row of numbers. It is the nearest line above the row that has the same number of cells,
/// except for lines with units, lines with numbers, and lines such as `Sample rate: 200 Hz`. Cells of the row may be blank.
fn header_above(lines: &[Line], row: usize, delimiter: Delimiter) -> Option<usize> {
    let n_cells = |at: usize| names(lines[at].text, delimiter).len();
    let n_filled = n_cells(row);
    let n_row = Cells::new(lines[row].text, delimiter).count();
    let is_as_wide = |at: &usize| {
        let n = n_cells(*at);
        let fits = (n_filled.saturating_sub(1)..=n_row + 1).contains(&n);
        // A header may name the first columns only.
        let names_first = || {
            let mut cells = names(lines[*at].text, delimiter).into_iter();
            n > 2
                && n < n_row
                && cells.any(|cell| ColumnName::parse(&cell).kind == Some(Kind::Time))
        };
        (fits || names_first()) && (n > 1 || n_row == 1 && row == 1)
    };
    // A lone word in the first cell is a title. In the second of two cells, it names the second column, and the first has no name.
    let is_alone = |at: &usize| {
        let text = lines[*at].text;
        let is_of_second = n_row == 2 && starts_blank(text, delimiter);
        n_row > 1 && is_lone_word(text, delimiter) && !is_of_second
    };
    let may_be = |at: &usize| !is_note(lines[*at].text, delimiter) && !is_alone(at);
    let has_words = |at: &usize| !is_rowlike(lines[*at].text, delimiter);
    let any_words = (0..row).filter(may_be).any(|at| has_words(&at));
    let mut above = (0..row).rev().filter(may_be).filter(|at| !any_words || has_words(at));
    let nearest = above.next()?;
    match above.next() {
        // A name over several columns has blank cells behind it, so that its line may end early.
        Some(names) if is_below_names(lines[names].text, lines[nearest].text, delimiter) => {
            [names, nearest].iter().any(is_as_wide).then_some(names)
        }
        _ => Some(nearest).filter(is_as_wide),
    }
}

/// Returns true if only one cell of a line is filled, and not with a value.
pub fn is_lone_word(text: &[u8], delimiter: Delimiter) -> bool {
    delimiter != Delimiter::Spaces && counts(text, delimiter) == (0, 1)
}

/// Returns the position where the table of a short file ends: at a blank line below its rows if no line after it is a row with
/// as many cells. `None` if the table ends with the file.
pub fn end_of_table(
    head: &[u8],
    all: &[Line],
    n_lines: u64,
    delimiter: Delimiter,
) -> Option<usize> {
    if head.len() >= HEAD_BYTES || all.last()?.end < head.len() {
        return None;
    }
    let table = all.get(n_lines as usize..)?;
    let n_cells = |line: &Line| Cells::new(line.text, delimiter).count();
    let is_row = |line: &&Line| is_rowlike(line.text, delimiter);
    let usual = most_frequent(&table.iter().filter(is_row).map(n_cells).collect::<Vec<_>>());
    let last = table.iter().rposition(|line| is_row(&line) && n_cells(line) == usual)?;
    let (blank, after) = table[last + 1..].split_first()?;
    let is_blank = |line: &Line| line.text.trim_ascii().is_empty();
    (is_blank(blank) && !after.iter().all(is_blank)).then_some(table[last].end)
}

fn starts_blank(text: &[u8], delimiter: Delimiter) -> bool {
    Cells::new(text, delimiter).next().is_some_and(<[u8]>::is_empty)
}

/// Returns true if a line below the header is part of the header: it holds units, or names of columns whose cells in the first
/// line of the header are blank.
fn is_below_names(names_above: &[u8], text: &[u8], delimiter: Delimiter) -> bool {
    let (n_values, n_others) = counts(text, delimiter);
    let is_second_row = n_values == 0
        && n_others > 1
        && starts_blank(text, delimiter)
        && !starts_blank(names_above, delimiter);
    is_units_row(text, delimiter) || is_second_row
}

/// Returns true if a line is a note, a word with its value: `Sample rate: 200 Hz`. Names such as `Unnamed: 0` stand beside others.
fn is_note(text: &[u8], delimiter: Delimiter) -> bool {
    let mut others = Cells::new(text, delimiter).skip(1);
    if delimiter != Delimiter::Spaces
        && others.any(|cell| cell.first().is_some_and(u8::is_ascii_alphabetic))
    {
        return false;
    }
    let text = String::from_utf8_lossy(text);
    let Some((word, value)) = text.split_once([':', '=']) else {
        return false;
    };
    let is_word = !word.trim().is_empty() && !word.contains(|c: char| c.is_ascii_digit());
    is_word && value.trim_start().starts_with(|c: char| c.is_ascii_digit() || c == '-')
}

/// Returns true if a line below the header holds units: at least one known unit, or several other units, and no values.
pub fn is_units_row(text: &[u8], delimiter: Delimiter) -> bool {
    let cells = names(text, delimiter);
    let (n_values, _) = counts(text, delimiter);
    let is_other = |cell: &&String| is_any_unit(unbracketed(cell)) || *cell == "/";
    let n_others = cells.iter().filter(is_other).count();
    n_values == 0
        && (cells.iter().any(|cell| is_known_unit(unbracketed(cell)))
            || n_others > 1 && 2 * n_others >= cells.len())
}

/// Returns true if the comma in a cell may separate thousands, as in `1,250`.
fn may_be_thousands(cell: &[u8]) -> bool {
    let digits = cell.strip_prefix(b"-").unwrap_or(cell);
    let Some(at) = digits.iter().position(|byte| *byte == b',') else {
        return false;
    };
    (1..=3).contains(&at) && digits[0] != b'0' && digits.len() == at + 4
}

/// Returns the separator of thousands in these lines, if a number that can be read in only one way shows it.
fn thousands_of(lines: &[Line], delimiter: Delimiter) -> Option<Thousands> {
    lines
        .iter()
        .flat_map(|line| Cells::new(line.text, delimiter))
        .find_map(|cell| Some(unmistakable_number(cell)?.1))
}

/// Returns the decimal mark of a table: the comma if its numbers contain commas and no points, else the point.
fn decimal_of(lines: &[Line], delimiter: Delimiter) -> Decimal {
    // If commas separate the cells, a comma in a quoted number may separate thousands and does not show a decimal comma.
    let is_decimal = |cell: &[u8]| {
        (delimiter.allows_decimal_comma() || !may_be_thousands(cell))
            && decimal_comma_number(cell).is_some()
    };
    let cells = || lines.iter().flat_map(|line| Cells::new(line.text, delimiter));
    let is_before_decimals = |cell: &[u8]| {
        let at = |byte| cell.iter().rposition(|other| *other == byte);
        unmistakable_number(cell).is_some() && at(b',') > at(b'.')
    };
    let groups_by_comma = thousands_of(lines, delimiter) == Some(Thousands::Comma);
    let has_comma =
        !groups_by_comma && cells().any(|cell| is_decimal(cell) || is_before_decimals(cell));
    let has_point = || cells().any(|cell| cell.contains(&b'.') && number(cell).is_some());
    if has_comma && !has_point() { Decimal::Comma } else { Decimal::Point }
}

/// Returns the names in the last comment above the first row, if the comment names each column, among them a time and a
/// gauge or load.
pub fn names_in_comment(all: &[Line], delimiter: Delimiter) -> Option<Vec<String>> {
    let row = all.iter().position(|line| !is_skipped(line.text))?;
    let n_cells = Cells::new(all[row].text, delimiter).count();
    let is_filled = |line: &&Line| !line.text.trim_ascii().is_empty();
    let text = all[..row].iter().rev().find(is_filled)?.text;
    let text = text.trim_ascii_start();
    let text = &text[text.iter().take_while(|byte| **byte == b'#').count()..];
    words(text.trim_ascii_start()).filter(|cells| cells.len() == n_cells && is_header(cells))
}

#[cfg(test)]
mod tests {
    use super::super::locate;
    use super::*;
    use crate::formats::text::Delimiter::{Comma, Semicolon, Spaces, Tab};

    fn text(text: &str) -> TextLayout {
        detect(text.as_bytes()).unwrap()
    }

    #[test]
    fn delimiter_and_decimal_mark_are_found() {
        for (content, delimiter, decimal) in [
            ("t,S1\n0,1\n1,2\n", Comma, Decimal::Point),
            ("t;S1\n0;1\n1;2.5\n", Semicolon, Decimal::Point),
            ("t;S1\n0;1\n1;2,5\n", Semicolon, Decimal::Comma),
            ("t\tS1\n0\t1,5\n", Tab, Decimal::Comma),
            ("t S1\n0 1,5\n", Spaces, Decimal::Comma),
            ("0,5;1,5\n1;2\n", Semicolon, Decimal::Comma),
            ("0,5\t1,5\n", Tab, Decimal::Comma),
            ("1, 2, 3\n4, 5, 6\n", Comma, Decimal::Point),
            ("t,S1\n\"0,5\",\"1,5\"\n", Comma, Decimal::Comma),
            ("t,S1\n1,\"1,250\"\n2,\"3,125\"\n", Comma, Decimal::Point),
            ("t,S1\n0.5,\"1,25\"\n", Comma, Decimal::Point),
            (
                "a;b\n2024-01-01 10:00:00,5;1,5\n2024-01-01 10:00:01,5;1,5\n",
                Semicolon,
                Decimal::Comma,
            ),
            ("Time, raw;Value, raw\n1;2\n3;4\n", Semicolon, Decimal::Point),
        ] {
            let found = text(content);
            assert_eq!((found.delimiter, found.decimal), (delimiter, decimal), "{content}");
        }
    }

    #[test]
    fn separators_of_thousands_are_found() {
        use crate::formats::text::written::Thousands::{Apostrophe, Comma as Commas, Point, Space};
        for (content, delimiter, decimal, thousands) in [
            ("t,S1\n1,\"1,262.21\"\n2,9.5\n", Comma, Decimal::Point, Some(Commas)),
            ("t;S1\n1;1.234,5\n2;9,5\n", Semicolon, Decimal::Comma, Some(Point)),
            ("t;S1\n1;1'234.5\n2;9.5\n", Semicolon, Decimal::Point, Some(Apostrophe)),
            ("t;S1\n1;1\u{a0}234,5\n2;9,5\n", Semicolon, Decimal::Comma, Some(Space)),
            ("t;S1\n1;1,234,567\n2;9.5\n", Semicolon, Decimal::Point, Some(Commas)),
            ("t;S1\n1;1,234\n2;9,500\n", Semicolon, Decimal::Comma, None),
        ] {
            let found = text(content);
            let found = (found.delimiter, found.decimal, found.thousands);
            assert_eq!(found, (delimiter, decimal, thousands), "{content}");
        }
    }

    #[test]
    fn header_units_and_preamble_are_distinguished() {
        for (content, skip_rows, header, units_row) in [
            ("t,S1\n0,1\n", 0, true, false),
            ("# note\nt,S1\n0,1\n", 0, true, false),
            ("t,S1\ns,mV/V\n0,1\n", 0, true, true),
            ("Clock,Strain\n[s],[mV/V]\n0,1\n1,2\n", 0, true, true),
            ("Logger 5\nStart: today\n\nt,S1\n0,1\n", 3, true, false),
            ("Logger 5\nA,B,C\n1,2,3\n4,5,6\n", 1, true, false),
            ("Logger 5\n1,2,3\n4,5,6\n", 1, false, false),
            // A preamble as wide as the table, blank cells at the end, two rows of names, a row of zero readings.
            (
                "Export\nDevice:,A,A\nRate:,9,9\nGain:,1,1\nTest:,1,1\nClock,P,Q\n[s],[N],[N]\n0,1,2\n1,2,3\n2,3,4\n3,4,5\n4,5,6\n",
                5,
                true,
                true,
            ),
            ("A,B,C,D,E\n1,6.5,3.8,,\n2,6.6,3.9,,\n3,6.7,4.1,,\n", 0, true, false),
            (
                "Rate\n120\nFrame,Time,Hip,,,Knee\n,,X1,Y1,Z1,X2\n1,0,1,2,3,4\n2,1,1,2,3,4\n3,2,1,2,3,4\n",
                2,
                true,
                true,
            ),
            ("A,B,C\nzero,0.1,0.2\n1,2,3\n4,5,6\n7,8,9\n", 0, true, false),
            ("1,2,3\n4,5,6\n", 0, false, false),
            ("1,2,on\n4,5,off\n", 0, false, false),
            ("t,1,2\n0,3,4\n1,5,6\n", 0, true, false),
            ("Dear diary,\ntoday I measured.\n", 0, true, false),
        ] {
            let found = text(content);
            let actual = (found.skip_rows, found.header, found.units_row);
            assert_eq!(actual, (skip_rows, header, units_row), "{content}");
        }
        assert_eq!(detect(b"# a\n\n"), None);
    }

    #[test]
    fn a_comment_names_all_columns_or_none() {
        for content in
            ["# t S1 S2 Fx\nab  1 2 3\n0c\n0 1 2 3\n0", "# t S1 S2 Fx\nab  S1 S2 Fx\nac\n0 1 2"]
        {
            let layout = detect(content.as_bytes()).unwrap();
            assert!(!layout.header);
            let head = locate(content.as_bytes(), &layout).unwrap();
            assert_eq!(head.names_in_comment, [""; 0], "{content}");
        }
    }

    #[test]
    fn a_comment_may_name_the_columns() {
        let in_comment = |content: &[u8]| {
            let layout = detect(content).unwrap();
            assert!(!layout.header);
            locate(content, &layout).unwrap().names_in_comment
        };
        let named = in_comment(b"# run 3\n# t S1 Fx\n0 1 2\n1 2 3\n");
        assert_eq!(named, ["t", "S1", "Fx"]);
        assert!(in_comment(b"# a note\n0 1 2\n").is_empty());
    }
}
