//! Preamble and status words that the demonstration program of ATI's Net F/T writes.
//!
//! **Source** Manuals of Net F/T and Ethernet Axia: values are counts. The highest bit of the 32-bit status word is set
//! whenever another bit reports an error.

use crate::formats::columns::Cell;

const ANY_ERROR: u32 = 1 << 31;

#[derive(Debug, PartialEq)]
pub struct Preamble {
    pub n_lines: usize,
    pub rate_hz: Option<f64>,
    pub force: CountedUnit,
    pub moment: CountedUnit,
}

#[derive(Debug, PartialEq)]
pub struct CountedUnit {
    pub unit: String,
    pub counts: f64,
}

impl Preamble {
    pub fn of<'a>(lines: impl Iterator<Item = &'a [u8]>) -> Option<Self> {
        const LINES_AT_MOST: usize = 12;
        let mut values: Vec<(String, String)> = Vec::new();
        for (n_lines, line) in lines.take(LINES_AT_MOST).enumerate() {
            let line = String::from_utf8_lossy(line);
            if line.trim_start().trim_start_matches('"').starts_with("Status") {
                let value = |start: &str| {
                    let is_it = |(key, _): &&(String, String)| key.starts_with(start);
                    values.iter().find(is_it).map(|(_, value)| value.clone())
                };
                let number = |start| value(start)?.parse::<f64>().ok().filter(|x| *x > 0.0);
                let unit = |unit, counts| {
                    Some(CountedUnit { unit: value(unit)?, counts: number(counts)? })
                };
                return Some(Self {
                    n_lines,
                    rate_hz: number("rdt sample rate"),
                    force: unit("force unit", "counts per unit force")?,
                    moment: unit("torque unit", "counts per unit torque")?,
                });
            }
            // The preamble has lines such as `Force Units: N`, with the value in the same cell or in the next.
            if let Some((key, value)) = line.split_once(':') {
                let bare = |text: &str| text.trim_matches([' ', '"', ',', '\t', '\r']).to_owned();
                values.push((bare(key).to_lowercase(), bare(value)));
            }
        }
        None
    }
}

/// Returns true if the status word in a cell reports an error; `None` if the cell is neither a number nor hexadecimal digits.
pub fn reports_error(cell: Cell<'_>) -> Option<bool> {
    let text = match cell {
        Cell::Number(number) => {
            let is_word = (0.0..=f64::from(u32::MAX)).contains(&number) && number.fract() == 0.0;
            return is_word.then_some(number as u32 & ANY_ERROR != 0);
        }
        Cell::Text(text) => std::str::from_utf8(text).ok()?,
        Cell::Since(..) => return None,
    };
    let digits = text.strip_prefix("0x").or(text.strip_prefix("0X")).unwrap_or(text);
    let is_hexadecimal = !digits.starts_with('+');
    let word = is_hexadecimal.then(|| u32::from_str_radix(digits, 16).ok())??;
    Some(word & ANY_ERROR != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_counts_and_rate_are_read_from_the_preamble() {
        let with_note = "Start Time: Nov 5, 2026, 3:00:00 PM\nRDT Sample Rate: 1000\n\"PLEASE NOTE: the rate\"\n\
            Force Units: N\nCounts per Unit Force: 1000000.0\nTorque Units: Nmm\n\
            Counts per Unit Torque: 1000.0\nStatus (hex), RDT Sequence";
        let in_cells = "Start Time:,x\nRDT Sample Rate:,1000\nForce Units:,N\nCounts per Unit Force:,1000000\n\
            Torque Units:,Nmm\nCounts per Unit Torque:,1000\n\"Status (hex)\",\"RDT Sequence\"";
        for (text, n_lines) in [(with_note, 7), (in_cells, 6)] {
            let preamble = Preamble::of(text.lines().map(str::as_bytes)).unwrap();
            assert_eq!((preamble.n_lines, preamble.rate_hz), (n_lines, Some(1000.0)));
            assert_eq!((preamble.force.unit.as_str(), preamble.force.counts), ("N", 1e6));
            assert_eq!((preamble.moment.unit.as_str(), preamble.moment.counts), ("Nmm", 1e3));
        }
        assert_eq!(Preamble::of(["t,S1", "0,1"].map(str::as_bytes).into_iter()), None);
    }

    #[test]
    fn the_highest_bit_of_the_status_is_an_error() {
        for (status, is_error) in [
            ("0", Some(false)),
            ("80000001", Some(true)),
            ("0xC0000000", Some(true)),
            ("00010000", Some(false)), // a latched condition is not an error
            ("1x", None),
            ("", None),
            ("+1", None),
            ("180000000", None),
        ] {
            let cell = Cell::Text(status.as_bytes());
            assert_eq!(reports_error(cell), is_error, "{status}");
        }
        for (status, is_error) in [(0.0, Some(false)), (2147483649.0, Some(true)), (0.5, None)] {
            assert_eq!(reports_error(Cell::Number(status)), is_error, "{status}");
        }
    }
}
