//! What the header line makes of each column. The rules look at names alone, never at who wrote the file.

use std::path::Path;

use super::ReadError;
use super::cells::{Cells, Delimiter, decimal_comma_number, number};
use super::column_name::{ColumnName, Kind};
use super::warning::Finding;
use crate::recording::Axis;
use crate::recording::units::{self, TimeUnit};

/// More channels than any force/torque sensor has, few enough for normal equations to stay small.
const GAUGE_LIMIT: usize = 64;

/// What a column is used for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Use {
    Ignored,
    Time,
    Gauge,
    /// The reference load number `slot` in [`Axis`] order; times `factor` it is SI.
    Load {
        slot: usize,
        factor: f64,
    },
}

impl Use {
    /// What a message calls such a column.
    pub(super) fn noun(self) -> &'static str {
        match self {
            Self::Ignored => "column",
            Self::Time => "time",
            Self::Gauge => "gauge",
            Self::Load { .. } => "reference",
        }
    }
}

/// A header that was understood: exactly one time column, 1 to 64 gauges, each axis at most once.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) line: u64,
    pub(super) delimiter: Delimiter,
    /// One per column, in file order.
    pub(super) uses: Vec<Use>,
    /// One per column, as written but for quotes and bracketed units.
    pub(super) names: Vec<String>,
    pub(super) time_unit: Option<TimeUnit>,
    /// In file order.
    pub(super) gauge_names: Vec<String>,
    /// In [`Axis`] order.
    pub(super) axes: Vec<Axis>,
}

impl Header {
    /// Understands the header line, number `line` of the file.
    pub(super) fn parse(
        path: &Path,
        line: u64,
        text: &[u8],
    ) -> Result<(Self, Vec<Finding>), ReadError> {
        let path = || path.to_owned();
        let delimiter = Delimiter::of_header(text);
        let cells = split(text, delimiter);
        if holds_only_numbers(text) {
            return Err(ReadError::HeaderIsNumbers { path: path(), line });
        }
        let columns: Vec<ColumnName> = cells.iter().map(|cell| ColumnName::parse(cell)).collect();
        let mut header = Self {
            line,
            delimiter,
            uses: vec![Use::Ignored; columns.len()],
            names: columns.iter().map(|column| column.name.clone()).collect(),
            time_unit: None,
            gauge_names: Vec::new(),
            axes: Vec::new(),
        };
        let unknown_unit = |index: usize, unit: &str, known| ReadError::UnknownUnit {
            path: path(),
            line,
            column: index + 1,
            name: columns[index].name.clone(),
            unit: unit.to_owned(),
            known,
        };

        let is_time = |index: &usize| columns[*index].kind == Some(Kind::Time);
        let times: Vec<usize> = (0..columns.len()).filter(is_time).collect();
        let Some(&time) = times.first() else {
            return Err(ReadError::NoTime {
                path: path(),
                line,
                names: cells,
            });
        };
        header.uses[time] = Use::Time;
        if let Some(unit) = &columns[time].unit {
            let known = TimeUnit::from_name(unit);
            header.time_unit =
                Some(known.ok_or_else(|| unknown_unit(time, unit, units::TIME_UNITS))?);
        }

        for (index, column) in columns.iter().enumerate() {
            if column.kind != Some(Kind::Gauge) {
                continue;
            }
            let is_same =
                |other: &ColumnName| other.kind == Some(Kind::Gauge) && other.name == column.name;
            if let Some(first) = columns[..index].iter().position(is_same) {
                return Err(ReadError::DuplicateGauge {
                    path: path(),
                    line,
                    name: column.name.clone(),
                    first: first + 1,
                    second: index + 1,
                });
            }
            header.uses[index] = Use::Gauge;
            header.gauge_names.push(column.name.clone());
            if header.gauge_names.len() > GAUGE_LIMIT {
                let is_gauge = |column: &&ColumnName| column.kind == Some(Kind::Gauge);
                return Err(ReadError::TooManyGauges {
                    path: path(),
                    line,
                    count: columns.iter().filter(is_gauge).count(),
                    limit: GAUGE_LIMIT,
                    names: cells,
                });
            }
        }
        if header.gauge_names.is_empty() {
            return Err(ReadError::NoGauges {
                path: path(),
                line,
                names: cells,
            });
        }

        for axis in Axis::ALL {
            let is_axis = |index: &usize| columns[*index].kind == Some(Kind::Load(axis));
            let mut candidates = (0..columns.len()).filter(is_axis);
            let Some(index) = candidates.next() else {
                continue;
            };
            if let Some(second) = candidates.next() {
                return Err(ReadError::DuplicateAxis {
                    path: path(),
                    line,
                    axis,
                    first: index + 1,
                    second: second + 1,
                });
            }
            let factor = match &columns[index].unit {
                None => 1.0,
                Some(unit) => {
                    axis_factor(axis, unit).map_err(|known| unknown_unit(index, unit, known))?
                }
            };
            let slot = header.axes.len();
            header.uses[index] = Use::Load { slot, factor };
            header.axes.push(axis);
        }

        let notes = notes(&cells, &header, &times);
        Ok((header, notes))
    }
}

/// Whether a line is a row already, whatever its delimiter would be.
fn holds_only_numbers(text: &[u8]) -> bool {
    let is_number = |cell: &[u8]| cell.is_empty() || number(cell).is_some();
    let is_comma_number = |cell: &[u8]| is_number(cell) || decimal_comma_number(cell).is_some();
    Cells::new(text, Delimiter::of_header(text)).all(is_number)
        || [Delimiter::Byte(b';'), Delimiter::Whitespace]
            .into_iter()
            .any(|delimiter| Cells::new(text, delimiter).all(is_comma_number))
}

/// What one `unit` on `axis` is in SI, or the units that would be understood.
fn axis_factor(axis: Axis, unit: &str) -> Result<f64, &'static str> {
    if axis.is_force() {
        units::force_in_newtons(unit).ok_or(units::FORCE_UNITS)
    } else {
        units::moment_in_newton_metres(unit).ok_or(units::MOMENT_UNITS)
    }
}

/// The header's cells. Where whitespace is the delimiter, a unit in brackets stays with its name; cells without a name
/// at the end are left out.
fn split(text: &[u8], delimiter: Delimiter) -> Vec<String> {
    let text = String::from_utf8_lossy(text);
    let mut cells: Vec<String> = Vec::new();
    for cell in Cells::new(text.as_bytes(), delimiter) {
        let cell = String::from_utf8_lossy(cell).replace("\"\"", "\"");
        match cells.last_mut() {
            Some(last)
                if delimiter == Delimiter::Whitespace
                    && (cell.starts_with(['[', '(']) || is_open(last)) =>
            {
                last.push(' ');
                last.push_str(&cell);
            }
            _ => cells.push(cell),
        }
    }
    while cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    cells
}

fn is_open(cell: &str) -> bool {
    cell.rfind(['[', '(']) > cell.rfind([']', ')'])
}

/// What the header leaves out.
fn notes(cells: &[String], header: &Header, times: &[usize]) -> Vec<Finding> {
    let mut notes = Vec::new();
    if let [used, others @ ..] = times
        && !others.is_empty()
    {
        notes.push(Finding::SeveralTimes {
            used: cells[*used].clone(),
            others: others.iter().map(|&index| cells[index].clone()).collect(),
        });
    }
    let ignored: Vec<String> = (0..cells.len())
        .filter(|index| header.uses[*index] == Use::Ignored && !times.contains(index))
        .map(|index| cells[index].clone())
        .filter(|name| !name.is_empty())
        .collect();
    if !ignored.is_empty() {
        notes.push(Finding::IgnoredColumns { names: ignored });
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<(Header, Vec<Finding>), ReadError> {
        Header::parse(Path::new("a.csv"), 1, text.as_bytes())
    }

    #[test]
    fn loads_come_in_axis_order_and_gauges_in_file_order() {
        let (header, notes) = parse("Tz_Nmm,S2,t,Fx [kN],S1").unwrap();
        assert_eq!(header.axes, [Axis::Fx, Axis::Mz]);
        assert_eq!(header.gauge_names, ["S2", "S1"]);
        let load = |slot, factor| Use::Load { slot, factor };
        assert_eq!(header.uses[0], load(1, 1e-3));
        assert_eq!(header.uses[3], load(0, 1e3));
        assert_eq!(header.time_unit, None);
        assert!(notes.is_empty());
    }

    #[test]
    fn a_bracketed_unit_stays_with_its_name_between_blanks() {
        let (header, _) = parse("time [ms]  S1 (mV / V)  Mx (N mm)").unwrap();
        assert_eq!(header.time_unit, Some(TimeUnit::Milliseconds));
        assert_eq!(header.names, ["time", "S1", "Mx"]);
        assert_eq!(header.axes, [Axis::Mx]);
    }

    #[test]
    fn the_first_time_wins_and_the_rest_is_noted() {
        let (header, notes) = parse("label,stamp,S1,time,,").unwrap();
        assert_eq!(
            header.uses,
            [Use::Ignored, Use::Time, Use::Gauge, Use::Ignored]
        );
        assert_eq!(
            notes,
            [
                Finding::SeveralTimes {
                    used: "stamp".into(),
                    others: vec!["time".into()]
                },
                Finding::IgnoredColumns {
                    names: vec!["label".into()]
                },
            ]
        );
    }

    #[test]
    fn what_cannot_be_used_is_an_error_that_says_where() {
        let message = |text: &str| parse(text).unwrap_err().to_string();
        assert!(
            message("0,1.5,\"2\"").starts_with("a.csv:1: no header: the first line holds only")
        );
        assert!(message("0,5;1,5").contains("only numbers"));
        assert!(message("S1,Fx").contains("no time column among S1, Fx"));
        assert!(message("t,Fx,a\tb").contains("no gauge column among t, Fx, a\\tb"));
        let unit = message("t,S1,Fx [stone]");
        assert!(unit.contains("column 3 (Fx) has the unknown unit stone; understood here: N, kN"));
        assert!(message("t,S1,Mx (N)").contains("unknown unit N; understood here: N·m"));
        assert!(message("t [min],S1").contains("unknown unit min; understood here: s, ms"));
        assert!(message("t,S1,Fx,ATI_Fx").contains("columns 3 and 4 are both Fx"));
        assert!(message("t,S1 [V],x,S1 [mV]").contains("columns 2 and 4 are both gauge S1"));
    }

    #[test]
    fn sixty_four_gauges_are_the_limit() {
        let gauges = |n: usize| (0..n).map(|k| format!(",ch{k}")).collect::<String>();
        let (header, _) = parse(&format!("t{}", gauges(64))).unwrap();
        assert_eq!(header.gauge_names.len(), 64);
        let error = parse(&format!("t{}", gauges(70))).unwrap_err();
        assert!(matches!(error, ReadError::TooManyGauges { count: 70, .. }));
        assert!(error.to_string().ends_with("ch6 and 63 more"));
    }
}
