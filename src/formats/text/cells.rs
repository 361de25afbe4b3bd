//! Divides text into lines and cells, and reads numbers in cells.

use super::written::{Decimal, Delimiter, TextLayout, Thousands};
use crate::formats::columns::{Cell, Row};

/// Returns the delimiter of a header line: the most frequent of tab, semicolon and comma outside quotes, else whitespace.
pub fn delimiter_of_header(line: &[u8]) -> Delimiter {
    use Delimiter::{Comma, Semicolon, Spaces, Tab};
    let count = |delimiter: Delimiter| {
        let mut is_quoted = false;
        let outside_quotes = |&&byte: &&u8| {
            is_quoted ^= byte == b'"';
            byte == delimiter.byte() && !is_quoted
        };
        line.iter().filter(outside_quotes).count()
    };
    // `max_by_key` returns the last of equal elements, so a tab is preferred to a semicolon, and both to a comma.
    [Comma, Semicolon, Tab]
        .into_iter()
        .filter(|mark| count(*mark) > 0)
        .max_by_key(|mark| count(*mark))
        .unwrap_or(Spaces)
}

impl Delimiter {
    /// Returns true if a comma in a cell can be a decimal comma, which requires that commas do not separate the cells.
    pub fn allows_decimal_comma(self) -> bool {
        self != Self::Comma
    }

    /// Returns the byte that separates cells. A blank stands for any run of blanks and tabs.
    pub const fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
            Self::Spaces => b' ',
        }
    }
}

impl Decimal {
    const fn mark(self) -> char {
        match self {
            Self::Point => '.',
            Self::Comma => ',',
        }
    }
}

impl TextLayout {
    /// Returns a detected layout by which later numbers with either decimal mark are read, if the delimiter allows both.
    pub fn with_either_mark(self) -> Self {
        let is_open = self.delimiter.allows_decimal_comma() && self.thousands.is_none();
        Self { decimal: if is_open { Decimal::Point } else { self.decimal }, ..self }
    }

    /// Returns the cells of a line; `None` if the line is blank or a comment.
    pub fn row<'a>(&self, line: &'a [u8]) -> Option<TextRow<'a>> {
        (!is_skipped(line)).then(|| TextRow {
            cells: Cells::new(line.strip_suffix(b"\r").unwrap_or(line), self.delimiter),
            point: match (self.decimal, self.delimiter) {
                (Decimal::Point, _) => b'.',
                // If commas separate the cells, a number with a decimal comma is quoted and is never read as a plain number.
                // The decimal mark is then the byte 0xff, which occurs in no text.
                (Decimal::Comma, Delimiter::Comma) => 0xff,
                (Decimal::Comma, _) => b',',
            },
        })
    }

    /// Returns the number in a cell, and true if its comma was read as a decimal mark although the layout has the decimal
    /// point.
    pub fn number(&self, cell: &[u8]) -> Option<(f64, bool)> {
        let point = self.decimal.mark();
        // If commas separate the cells, a comma within a quoted cell separates thousands.
        let is_quoted = self.thousands.is_none()
            && self.decimal == Decimal::Point
            && !self.delimiter.allows_decimal_comma();
        let given = self.thousands.and_then(|mark| grouped_by(cell, mark, point));
        if let Some(value) = given {
            return Some((value, false));
        }
        self.ungrouped_number(cell).or_else(|| {
            let quoted = || grouped_by(cell, is_quoted.then_some(Thousands::Comma)?, point);
            let unmistakable = || Some(unmistakable_number(cell)?.0);
            Some((quoted().or_else(unmistakable)?, false))
        })
    }

    /// Returns the number in a cell, as [`Self::number`] does, minus `since`. The whole part is subtracted before conversion
    /// to a float, so no digit is lost.
    pub fn number_since(&self, since: i64, cell: &[u8]) -> Option<(f64, bool)> {
        let point = self.decimal.mark();
        let text = std::str::from_utf8(cell).ok()?;
        let (whole, decimals) = text.split_once(point).unwrap_or((text, ""));
        let share = match decimals {
            "" => Some(0.0),
            _ => plain_number(decimals.as_bytes(), b'.')
                .filter(|(_, end)| *end == decimals.len() && !decimals.starts_with('-'))
                .map(|(digits, _)| digits / 10_f64.powi(decimals.len() as i32)),
        };
        match (whole.parse::<i64>(), share) {
            (Ok(whole @ 0..), Some(share)) => Some(((whole - since) as f64 + share, false)),
            _ => self.number(cell).map(|(number, comma)| (number - since as f64, comma)),
        }
    }

    fn ungrouped_number(&self, cell: &[u8]) -> Option<(f64, bool)> {
        let with_comma = || decimal_comma_number(cell);
        match self.decimal {
            Decimal::Comma => {
                let is_whole = !cell.contains(&b'.');
                let value = with_comma().or_else(|| is_whole.then(|| number(cell)).flatten())?;
                Some((value, false))
            }
            Decimal::Point => match number(cell) {
                Some(value) => Some((value, false)),
                None if self.delimiter.allows_decimal_comma() => Some((with_comma()?, true)),
                None => None,
            },
        }
    }
}

pub fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let end = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        let line = &rest[..end];
        rest = rest.get(end + 1..).unwrap_or_default();
        Some(line)
    })
}

pub fn is_skipped(line: &[u8]) -> bool {
    matches!(line.trim_ascii_start().first(), None | Some(b'#'))
}

/// Cells of one line of text, without surrounding blanks and quotes. Doubled quotes inside quotes stay doubled.
#[derive(Clone, Debug)]
pub struct Cells<'a> {
    rest: Option<&'a [u8]>,
    delimiter: u8,
}

impl<'a> Cells<'a> {
    pub fn new(line: &'a [u8], delimiter: Delimiter) -> Self {
        // Some loggers write the NUL at the end of their texts.
        let line = match line {
            [number @ .., 0] if number.last().is_some_and(u8::is_ascii_alphanumeric) => number,
            _ => line,
        };
        let is_by_whitespace = delimiter == Delimiter::Spaces;
        Self {
            rest: Some(if is_by_whitespace { line.trim_ascii() } else { line }),
            delimiter: delimiter.byte(),
        }
    }

    fn ends_cell(&self, byte: u8) -> bool {
        byte == self.delimiter || (byte == b'\t' && self.delimiter == b' ')
    }

    fn after(&self, rest: &'a [u8], end: usize) -> &'a [u8] {
        match self.delimiter {
            b' ' => rest[end + 1..].trim_ascii_start(),
            _ => &rest[end + 1..],
        }
    }
}

impl<'a> Iterator for Cells<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        let quoted = closing_quote(rest).unwrap_or(0);
        let end = rest[quoted..].iter().position(|&byte| self.ends_cell(byte));
        let end = end.map(|end| quoted + end);
        self.rest = end.map(|end| self.after(rest, end));
        let cell = rest[..end.unwrap_or(rest.len())].trim_ascii();
        let unquoted = cell.strip_prefix(b"\"").and_then(|inner| inner.strip_suffix(b"\""));
        Some(unquoted.map_or(cell, <[u8]>::trim_ascii))
    }
}

#[derive(Clone, Debug)]
pub struct TextRow<'a> {
    cells: Cells<'a>,
    point: u8,
}

impl<'a> Iterator for TextRow<'a> {
    type Item = Cell<'a>;

    #[inline]
    fn next(&mut self) -> Option<Cell<'a>> {
        self.cells.next().map(Cell::Text)
    }
}

impl<'a> Row<'a> for TextRow<'a> {
    #[inline(always)] // one call per cell of the file
    fn next_number(&mut self) -> Option<f64> {
        let rest = self.cells.rest?;
        let (value, end) = plain_number(rest, self.point)?;
        self.cells.rest = match rest.get(end) {
            None => None,
            Some(&byte) if self.cells.ends_cell(byte) => Some(self.cells.after(rest, end)),
            Some(_) => return None,
        };
        Some(value)
    }
}

/// Returns the position of the closing quote of a cell; `None` if the cell has no quotes or they are not closed.
fn closing_quote(rest: &[u8]) -> Option<usize> {
    let start = match rest.first() {
        Some(b'"') => 0,
        Some(b' ') => rest.iter().position(|&byte| byte != b' ')?,
        _ => return None,
    };
    if rest[start] != b'"' {
        return None;
    }
    let mut at = start + 1;
    loop {
        at += rest[at..].iter().position(|&byte| byte == b'"')?;
        if rest.get(at + 1) != Some(&b'"') {
            return Some(at);
        }
        at += 2;
    }
}

/// Reads the plain number at the start of `text`: a sign, digits and a decimal mark `point`, at most 18 digits. Returns the
/// number and the position of its end. The result is that of [`number`], in less time: the digits as a whole number (up to
/// 2^53) and the power of ten are both exact, so their quotient is the nearest floating-point number.
fn plain_number(text: &[u8], point: u8) -> Option<(f64, usize)> {
    const POWERS: [f64; 19] = [
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
        1e17, 1e18,
    ];
    let is_negative = text.first() == Some(&b'-');
    let mut digits = 0_u64;
    let mut at = usize::from(is_negative);
    let start = at;
    let mut take_digits = |mut at: usize| {
        while let Some(digit) = text.get(at).map(|byte| byte.wrapping_sub(b'0'))
            && digit < 10
        {
            digits = digits.wrapping_mul(10).wrapping_add(u64::from(digit));
            at += 1;
        }
        at
    };
    at = take_digits(at);
    let mut n_digits = at - start;
    let mut n_decimals = 0;
    if text.get(at) == Some(&point) {
        let end = take_digits(at + 1);
        n_decimals = end - (at + 1);
        n_digits += n_decimals;
        at = end;
    }
    if !(1..=18).contains(&n_digits) || digits > 1 << f64::MANTISSA_DIGITS {
        return None;
    }
    let value = digits as f64 / POWERS[n_decimals];
    Some((if is_negative { -value } else { value }, at))
}

/// Returns the number in a cell whose decimal mark is a point, also NaN and infinity.
pub fn number(cell: &[u8]) -> Option<f64> {
    let plain = plain_number(cell, b'.').filter(|(_, end)| *end == cell.len());
    plain.map(|(value, _)| value).or_else(|| std::str::from_utf8(cell).ok()?.parse().ok())
}

/// Returns the number in a cell whose digits are grouped in threes by `thousands`, with the decimal mark `point`.
fn grouped_by(cell: &[u8], thousands: Thousands, point: char) -> Option<f64> {
    let text = std::str::from_utf8(cell).ok()?;
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    let (whole, decimals) = match digits.rsplit_once(point) {
        Some((whole, decimals)) if !thousands.is(point) => (whole, Some(decimals)),
        _ => (digits, None),
    };
    let are_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let groups: Vec<&str> = whole.split(|letter| thousands.is(letter)).collect();
    let (first, later) = groups.split_first()?;
    let is_grouped = (1..=3).contains(&first.len())
        && !first.starts_with('0')
        && !later.is_empty()
        && later.iter().all(|group| group.len() == 3);
    let decimals = decimals.unwrap_or("0");
    let is_number =
        is_grouped && groups.iter().all(|group| are_digits(group)) && are_digits(decimals);
    let sign = if text.starts_with('-') { "-" } else { "" };
    is_number.then(|| format!("{sign}{}.{decimals}", groups.concat()).parse().ok())?
}

/// Returns the number in a cell and its separator of thousands, if the cell can be read in only one way: `1'234`, `1,234.5`,
/// `1.234,5`, `1,234,567`.
pub fn unmistakable_number(cell: &[u8]) -> Option<(f64, Thousands)> {
    let of = |thousands: Thousands, point| Some((grouped_by(cell, thousands, point)?, thousands));
    let count = |byte: u8| cell.iter().filter(|other| **other == byte).count();
    match (count(b','), count(b'.')) {
        (0, 0 | 1) => of(Thousands::Apostrophe, '.').or_else(|| of(Thousands::Space, '.')),
        (1, 0) => of(Thousands::Apostrophe, ',').or_else(|| of(Thousands::Space, ',')),
        (_, 1) | (2.., 0) => of(Thousands::Comma, '.').or_else(|| of(Thousands::Point, ',')),
        (0 | 1, _) => of(Thousands::Point, ','),
        _ => None,
    }
}

/// Returns the number in a cell whose only comma is the decimal mark.
pub fn decimal_comma_number(cell: &[u8]) -> Option<f64> {
    let (whole, part) = std::str::from_utf8(cell).ok()?.split_once(',')?;
    let is_point_elsewhere = whole.contains('.') || part.contains('.');
    (!is_point_elsewhere).then(|| format!("{whole}.{part}").parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(line: &str, delimiter: Delimiter) -> Vec<String> {
        Cells::new(line.as_bytes(), delimiter)
            .map(|cell| String::from_utf8_lossy(cell).into_owned())
            .collect()
    }

    #[test]
    fn cells_lose_their_blanks_and_quotes() {
        let comma = Delimiter::Comma;
        assert_eq!(cells("1, 2 ,,", comma), ["1", "2", "", ""]);
        assert_eq!(cells("\"1\", \"a,b\" ,3", comma), ["1", "a,b", "3"]);
        assert_eq!(cells("\"a\"\"b\",2", comma), ["a\"\"b", "2"]);
        assert_eq!(cells("\"open,2", comma), ["\"open", "2"]);
        assert_eq!(cells("\"1\"2,3", comma), ["\"1\"2", "3"]);
        assert_eq!(cells("1\t\t3", Delimiter::Tab), ["1", "", "3"]);
        let blanks = cells("  1 \t 2  \"a b\" ", Delimiter::Spaces);
        assert_eq!(blanks, ["1", "2", "a b"]);
    }

    #[test]
    fn the_header_gives_the_delimiter() {
        use super::Delimiter::{Comma, Semicolon, Spaces, Tab};
        for (line, delimiter) in [
            ("t,S1;x,Fx", Comma),
            ("t;S1", Semicolon),
            ("t\tS1", Tab),
            ("\"t,a,b\";S1", Semicolon),
            ("t  S1", Spaces),
        ] {
            assert_eq!(delimiter_of_header(line.as_bytes()), delimiter, "{line}");
        }
    }

    #[test]
    fn plain_numbers_are_the_nearest_floating_point_numbers() {
        let mut random = 1_u64;
        for n_decimals in 0..17 {
            for _ in 0..200 {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let value = (random >> 12) as i64 - (1 << 51);
                let text = format!("{:.n_decimals$}", value as f64 / 1e9);
                let expected: f64 = text.parse().unwrap();
                if let Some((value, end)) = plain_number(text.as_bytes(), b'.') {
                    assert_eq!(value.to_bits(), expected.to_bits(), "{text}");
                    assert_eq!(end, text.len());
                } else {
                    assert!(n_decimals > 8, "{text} is plain");
                }
            }
        }
        for text in ["", "-", ".", "-.", "x", "9007199254740993", "0.1234567890123456789"] {
            assert_eq!(plain_number(text.as_bytes(), b'.'), None, "{text}");
        }
        assert_eq!(plain_number(b"-0.5e3", b'.'), Some((-0.5, 4)));
        assert_eq!(plain_number(b"5.;", b'.'), Some((5.0, 2)));
    }

    #[test]
    fn a_plain_number_is_a_whole_cell() {
        let layout = TextLayout { delimiter: Delimiter::Spaces, ..TextLayout::default() };
        let mut row = layout.row(b"1.5  2e1 -3").unwrap();
        assert_eq!(row.next_number(), Some(1.5));
        assert_eq!(row.next_number(), None);
        assert_eq!(row.next(), Some(Cell::Text(b"2e1")));
        assert_eq!(row.next_number(), Some(-3.0));
        assert_eq!(row.next_number(), None);
        assert_eq!(row.next(), None);
    }

    #[test]
    fn a_decimal_comma_needs_to_be_the_only_mark() {
        assert_eq!(decimal_comma_number(b"-1,5e3"), Some(-1500.0));
        for not_one in ["1,234.5", "1,2,3", "1.5", "a,b", ","] {
            assert_eq!(decimal_comma_number(not_one.as_bytes()), None, "{not_one}");
        }
    }
}
