//! Converts tables of other shapes into tables with one row for each sample: lines with a label in front of each number, turned
//! tables (one row for each channel), and long tables (the channels of a sample stand in successive rows).

use std::ops::Range;

use super::{
    cells::{Cells, delimiter_of_header, lines, number},
    labels,
    layout::is_value,
    serial_monitor,
    written::Delimiter,
};
use crate::formats::column_name::{ColumnName, Kind, is_any_unit, is_identifier, is_one_of};

/// Maximum length of a file whose table is reshaped (bytes). The table is held in memory.
pub const LIMIT_BYTES: u64 = 32 << 20;

type Row<'a> = Vec<&'a [u8]>;

/// Returns a table with one row for each sample, as a text whose cells are separated by tabs, and how it was made; `None` if
/// the text is such a table already. `rows` divides the text into cells; its first row is the header.
pub fn reshaped<'a>(
    text: &'a [u8],
    rows: impl FnOnce(&'a [u8]) -> Vec<Row<'a>>,
) -> Option<(Vec<u8>, &'static str)> {
    if let Some(table) = labels::table(text) {
        return Some((table, "each number has a label, which names its column"));
    }
    if let Some(table) = serial_monitor::table(text) {
        return Some((table, "the time in front of each line is a column"));
    }
    if lines(text).next().is_some_and(is_quoted) && lines(text).all(is_quoted) {
        let bare: Vec<u8> = text.iter().copied().filter(|byte| *byte != b'"').collect();
        return Some((bare, "each line stands in quotes"));
    }
    let rows = rows(text);
    let is_turned = rows.len() > 1 && rows.iter().all(|row| is_channel(row, rows.len()));
    if is_turned {
        let width = rows.iter().map(Vec::len).max().unwrap_or(0);
        let column = |at: usize| rows.iter().map(move |row| row.get(at).copied().unwrap_or(b""));
        let turned = (0..width).map(|at| column(at).collect::<Row<'_>>().join(&b'\t'));
        let how = "each row of the file is a channel, so that its columns are read as rows";
        return Some((turned.collect::<Vec<_>>().join(&b'\n'), how));
    }
    let how = "the channels of a sample stand in successive rows, which are read as one row";
    Some((Long::of(&rows)?.text(), how))
}

/// Returns true if quotes surround several cells of a line. In a single one, a comma may be the decimal mark.
fn is_quoted(line: &[u8]) -> bool {
    let inside = line.trim_ascii().strip_prefix(b"\"").and_then(|line| line.strip_suffix(b"\""));
    inside.is_some_and(|cells| {
        !cells.contains(&b'"') && Cells::new(cells, delimiter_of_header(cells)).nth(2).is_some()
    })
}

/// Returns true if a row holds a name, perhaps a unit, and many more numbers than the table has rows.
pub fn is_channel(row: &[&[u8]], n_rows: usize) -> bool {
    const FEWEST_SAMPLES: usize = 8;
    /// Minimum number of samples for each channel.
    const SAMPLES_PER_CHANNEL: usize = 3;
    let is_value = |cell: &&&[u8]| is_value(cell, Delimiter::Tab);
    let has_unit = row.get(1).is_some_and(|unit| is_any_unit(&String::from_utf8_lossy(unit)));
    let Some((name, samples)) = row.split_first() else { return false };
    let samples = &samples[usize::from(has_unit)..];
    samples.len() >= FEWEST_SAMPLES.max(SAMPLES_PER_CHANNEL * n_rows)
        && !is_value(&name)
        && name.iter().any(u8::is_ascii_alphabetic)
        && samples.iter().all(|cell| cell.is_empty() || is_value(&cell))
}

/// Table in which a column tells the channel or the device of each row.
struct Long<'a> {
    names: Vec<ColumnName>,
    rows: &'a [Row<'a>],
    identifier: usize,
    identifiers: Vec<&'a [u8]>,
    /// Rows of each sample.
    samples: Vec<Range<usize>>,
}

impl<'a> Long<'a> {
    fn of(rows: &'a [Row<'a>]) -> Option<Self> {
        const MOST_CHANNELS: usize = 32;
        const FEWEST_SAMPLES: usize = 3;
        let (header, rows) = rows.split_first()?;
        if header.iter().any(|cell| number(cell).is_some()) {
            return None;
        }
        let name = |cell: &&[u8]| ColumnName::parse(&String::from_utf8_lossy(cell));
        let names: Vec<ColumnName> = header.iter().map(name).collect();
        let clock = names.iter().position(is_clock);
        (0..names.len()).find_map(|at| {
            let cells = || rows.iter().filter_map(move |row| row.get(at).copied());
            let are_words = cells().all(|cell| number(cell).is_none());
            let ColumnName { name, unit, kind, .. } = &names[at];
            let is_named = match are_words {
                true => is_identifier(name),
                false => is_one_of(&name.to_lowercase(), NUMBERED),
            };
            let may_be = is_named || clock.is_some() && are_words && name != "group";
            if names.len() < 2 || clock == Some(at) || kind.is_some() || unit.is_some() || !may_be {
                return None;
            }
            let mut identifiers = Vec::new();
            let is_too_many = |cell| {
                identifiers.extend((!identifiers.contains(&cell)).then_some(cell));
                identifiers.len() > MOST_CHANNELS
            };
            if cells().any(is_too_many) || !(2..=MOST_CHANNELS).contains(&identifiers.len()) {
                return None;
            }
            let mut samples: Vec<Range<usize>> = Vec::new();
            for (index, row) in rows.iter().enumerate() {
                let is_same = |other: &Row<'_>| other.get(at) == row.get(at);
                match samples.last_mut() {
                    Some(sample) if !rows[sample.clone()].iter().any(is_same) => {
                        sample.end = index + 1;
                    }
                    _ => samples.push(index..index + 1),
                }
            }
            let n_whole = samples.iter().filter(|own| own.len() == identifiers.len()).count();
            // Numbers may be a signal that takes few values.
            let percent = if are_words && is_named { 50 } else { 90 };
            // The rows of a sample have one time, if the name does not tell what the column is.
            let has_one_time = |sample: &&Range<usize>| {
                let mut times = rows[(*sample).clone()].iter().map(|row| row.get(clock?));
                let first = times.next();
                sample.len() > 1 && times.all(|time| Some(time) == first)
            };
            let n_together = samples.iter().filter(has_one_time).count();
            let is_long = n_whole >= FEWEST_SAMPLES
                && 100 * n_whole >= percent * samples.len()
                && (is_named || 2 * n_together >= n_whole);
            let names = names.clone();
            is_long.then_some(Self { names, rows, identifier: at, identifiers, samples })
        })
    }

    fn text(&self) -> Vec<u8> {
        let (shared, others): (Vec<usize>, Vec<usize>) = (0..self.names.len())
            .filter(|at| *at != self.identifier)
            .partition(|at| is_clock(&self.names[*at]) || self.names[*at].is_counter(true));
        let is_unit = |at: &usize| is_one_of(&self.names[*at].name.to_lowercase(), "unit einheit");
        let (units, values): (Vec<usize>, Vec<usize>) = others.into_iter().partition(is_unit);
        let with_unit = |name: String, unit: Option<&str>| match unit {
            Some(unit) => format!("{name} [{unit}]"),
            None => name,
        };
        let in_shared = |at: &usize| {
            let name = &self.names[*at];
            with_unit(name.name.clone(), name.unit.as_deref())
        };
        let mut header: Vec<String> = shared.iter().map(in_shared).collect();
        for identifier in &self.identifiers {
            let is_it = |row: &&Row<'_>| row.get(self.identifier) == Some(identifier);
            let first = self.rows.iter().find(is_it);
            let unit = first.and_then(|row| row.get(*units.first()?));
            let unit = unit.map(|unit| String::from_utf8_lossy(unit));
            let mut channel = String::from_utf8_lossy(identifier).into_owned();
            if number(identifier).is_some() {
                channel = format!("{} {channel}", self.names[self.identifier].name);
            }
            for at in &values {
                let ColumnName { name, unit: own, .. } = &self.names[*at];
                let is_plain = values.len() == 1 && is_one_of(&name.to_lowercase(), PLAIN);
                let name = if is_plain { channel.clone() } else { format!("{name} {channel}") };
                header.push(with_unit(name, own.as_deref().or(unit.as_deref())));
            }
        }
        let mut text = header.join("\t").into_bytes();
        for sample in &self.samples {
            let rows = &self.rows[sample.clone()];
            let cell = |row: Option<&Row<'a>>, at: &usize| -> &'a [u8] {
                row.and_then(|row| row.get(*at)).copied().unwrap_or_default()
            };
            let of_row = |identifier: &&[u8]| {
                rows.iter().find(|row| row.get(self.identifier) == Some(identifier))
            };
            let cells = shared.iter().map(|at| cell(rows.first(), at)).chain(
                self.identifiers
                    .iter()
                    .flat_map(|own| values.iter().map(move |at| cell(of_row(own), at))),
            );
            text.push(b'\n');
            text.extend(cells.collect::<Row<'_>>().join(&b'\t'));
        }
        text
    }
}

/// Names of a column of numbers that tells the channel of each row.
const NUMBERED: &str = "channel sensor device node id kanal";
/// Names of a column of values that tell nothing about the values.
const PLAIN: &str = "value values wert reading data measurement valeur val";

fn is_clock(name: &ColumnName) -> bool {
    name.kind == Some(Kind::Time) || name.has_clock_word() || name.name.eq_ignore_ascii_case("date")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(rows: &str) -> String {
        let text = rows.replace(' ', "\n");
        let rows = |text: &'static [u8]| -> Vec<Row<'static>> {
            lines(text).map(|row| row.split(|byte| *byte == b',').collect()).collect()
        };
        let text = reshaped(text.leak().as_bytes(), rows).map_or(Vec::new(), |found| found.0);
        String::from_utf8(text).unwrap().replace('\t', ",").replace('\n', " ")
    }

    #[test]
    fn quotes_around_lines_are_left_out() {
        assert_eq!(text("\"-5,2,2\" \"-4,2,1\""), "-5,2,2 -4,2,1");
        assert_eq!(text("\"1,5\" \"2,5\""), "");
    }

    #[test]
    fn rows_of_channels_are_turned() {
        let turned = text("t,s,1,2,3,4,5,6,7,8 S1,mV,3,4,5,6,7,8,9,1");
        assert_eq!(turned, "t,S1 s,mV 1,3 2,4 3,5 4,6 5,7 6,8 7,9 8,1");
        assert_eq!(text("a,1,2 b,3,4 c,5,6"), "");
    }

    /// The devices are read in turn; one row of the second sample is missing.
    #[test]
    fn channels_in_successive_rows_become_columns() {
        let rows = "time,side,Value[kg] 1,L,5 1,R,6 2,L,7 3,L,8 3.1,R,9 4,L,1 4,R,2";
        assert_eq!(text(rows), "time,L [kg],R [kg] 1,5,6 2,7, 3,8,9 4,1,2");
        let rows = "t,channel,force_N,unit 1,1,5,N 1,2,6,N 2,1,7,N 2,2,8,N 3,1,9,N 3,2,1,N";
        assert_eq!(text(rows), "t,force_N channel 1 [N],force_N channel 2 [N] 1,5,6 2,7,8 3,9,1");
        assert_eq!(text("load,way,x 1,up,2 1,down,3 2,up,4 2,down,5 3,up,6 3,down,7"), "");
        assert_eq!(text("t,device,x 1,a,2 2,a,3 3,a,4 4,b,5 5,b,6 6,b,7"), "");
        assert_eq!(text("t,S1,cell[N] 1,1,0 2,2,1 3,3,0 4,4,1 5,5,0 6,6,1"), "");
        assert_eq!(text("t,way,x 1,up,2 2,down,3 3,up,4 4,down,5 5,up,6 6,down,7"), "");
        let rows = "t,way,x 1,up,2 1,down,3 2,up,4 2,down,5 3,up,6 3,down,7";
        assert_eq!(text(rows), "t,x up,x down 1,2,3 2,4,5 3,6,7");
    }
}
