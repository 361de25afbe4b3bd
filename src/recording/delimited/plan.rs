//! What reading does with each column: a map, brought to one file and checked against it.
//!
//! Guarantees: exactly one source of time; where gauges are wanted 1 to 64 of them, where a reference is wanted one axis
//! or more; each axis at most once; every unit known.

use std::path::Path;

use super::ReadError;
use super::ati::CountedUnit;
use super::cells::Delimiter;
use super::column_name::ColumnName;
use super::layout::{Start, unbracketed};
use super::times::{DateOrder, TIME_SPELLINGS, TimeForm, TimeSpelling};
use crate::recording::Axis;
use crate::recording::columns::{ColumnKey, ColumnRole, ColumnRule, Decimal, TableMap};
use crate::recording::units;

/// More channels than any force/torque sensor has, few enough for normal equations to stay small.
const GAUGE_LIMIT: usize = 64;

/// What a column is used for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Use {
    Ignored,
    /// A number, part of the time.
    Time,
    /// A date or a time of day, part of the time.
    TimeText(TimeForm),
    /// Times `factor` it is as the map wants it.
    Gauge {
        factor: f64,
    },
    /// The reference load number `slot` in [`Axis`] order; times `factor` it is SI.
    Load {
        slot: usize,
        factor: f64,
    },
    Status,
}

impl Use {
    /// What a message calls such a column.
    pub(super) fn noun(self) -> &'static str {
        match self {
            Self::Ignored | Self::Status => "column",
            Self::Time | Self::TimeText(_) => "time",
            Self::Gauge { .. } => "gauge",
            Self::Load { .. } => "reference",
        }
    }
}

/// Which part of a table is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Everything: gauges and reference have one clock.
    Both,
    /// The gauges alone.
    Gauges,
    /// The reference, whose time is a second one in the file of the gauges.
    SecondClock,
    /// The reference, in a file of its own.
    ReferenceFile,
}

impl Side {
    fn has_gauges(self) -> bool {
        matches!(self, Self::Both | Self::Gauges)
    }

    fn has_loads(self) -> bool {
        self != Self::Gauges
    }

    fn time_role(self) -> ColumnRole {
        if self == Self::SecondClock {
            ColumnRole::TimeReference
        } else {
            ColumnRole::Time
        }
    }
}

/// Where times come from and what they count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TimeScale {
    /// So many make one second.
    PerSecond(f64),
    /// By their values.
    ByValues,
}

/// What is done with each column of a file.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// The header's line, or that of the first row.
    pub(super) line: u64,
    pub(super) delimiter: Delimiter,
    /// What stands before decimals.
    pub(super) point: u8,
    /// One per column, in file order.
    pub(super) uses: Vec<Use>,
    /// One per column, as a message calls it.
    pub(super) names: Vec<String>,
    /// Per column, which values mean that there is none; empty if no column has any.
    pub(super) dropouts: Vec<Vec<f64>>,
    pub(super) time_scale: TimeScale,
    /// Without one, rows are counted.
    pub(super) time_column: Option<usize>,
    /// In file order.
    pub(super) gauge_names: Vec<String>,
    /// Labels; empty where there is none.
    pub(super) gauge_units: Vec<String>,
    /// In [`Axis`] order.
    pub(super) axes: Vec<Axis>,
    /// Whether a row may hold nothing for this side.
    pub(super) may_be_blank: bool,
}

impl Plan {
    /// Brings a map to the file whose table starts so.
    pub(super) fn new(
        path: &Path,
        table: &TableMap,
        start: &Start,
        side: Side,
    ) -> Result<Self, ReadError> {
        let making = Making {
            path,
            table,
            start,
            side,
            columns: resolved(path, table, start)?,
        };
        let (time_column, time_scale, mut uses) = making.times()?;
        let (gauge_names, gauge_units) = making.gauges(&mut uses)?;
        let axes = making.loads(&mut uses)?;
        let names = making.names(&gauge_names, &uses);
        Ok(Self {
            line: start.line,
            delimiter: table.text.delimiter.into(),
            point: match table.text.decimal {
                Decimal::Point => b'.',
                Decimal::Comma => b',',
            },
            dropouts: making.dropouts(&uses),
            uses,
            names,
            time_scale,
            time_column,
            gauge_names,
            gauge_units,
            axes,
            may_be_blank: matches!(side, Side::Gauges | Side::SecondClock),
        })
    }
}

/// The columns that rules speak of, in file order.
fn resolved<'a>(
    path: &Path,
    table: &'a TableMap,
    start: &Start,
) -> Result<Vec<(usize, &'a ColumnRule)>, ReadError> {
    let is_by_number = |rule: &ColumnRule| matches!(rule.column, ColumnKey::Number(_));
    let (expected, actual) = (table.shape.columns, start.n_columns);
    if expected != actual && (!table.text.header || table.columns.iter().any(is_by_number)) {
        return Err(ReadError::MapShape {
            path: path.to_owned(),
            line: start.line,
            expected,
            actual,
        });
    }
    let mut columns = Vec::with_capacity(table.columns.len());
    for rule in &table.columns {
        columns.push((index_of(path, table, start, rule)?, rule));
    }
    columns.sort_by_key(|(index, _)| *index);
    Ok(columns)
}

fn index_of(
    path: &Path,
    table: &TableMap,
    start: &Start,
    rule: &ColumnRule,
) -> Result<usize, ReadError> {
    match &rule.column {
        ColumnKey::Number(number) => {
            let index = number - 1;
            match (table.shape.names.get(index), start.names.get(index)) {
                (Some(expected), Some(actual)) if expected != actual => {
                    Err(ReadError::MapOtherName {
                        path: path.to_owned(),
                        line: start.line,
                        column: *number,
                        expected: expected.clone(),
                        actual: actual.clone(),
                    })
                }
                _ => Ok(index),
            }
        }
        ColumnKey::Name(name) => {
            let mut same = (0..start.names.len()).filter(|&index| start.names[index] == *name);
            match (same.next(), same.next()) {
                (Some(index), None) => Ok(index),
                (Some(first), Some(second)) => Err(ReadError::MapSameNames {
                    path: path.to_owned(),
                    line: start.line,
                    name: name.clone(),
                    first: first + 1,
                    second: second + 1,
                }),
                (None, _) => Err(ReadError::MapNoColumn {
                    path: path.to_owned(),
                    line: start.line,
                    expected: name.clone(),
                    names: start.names.clone(),
                }),
            }
        }
    }
}

/// What a plan is made from.
struct Making<'a> {
    path: &'a Path,
    table: &'a TableMap,
    start: &'a Start,
    side: Side,
    /// Each with its index in the file, in file order.
    columns: Vec<(usize, &'a ColumnRule)>,
}

impl Making<'_> {
    fn with_role(&self, role: ColumnRole) -> impl Iterator<Item = (usize, &ColumnRule)> {
        let columns = self.columns.iter().copied();
        columns.filter(move |(_, rule)| rule.is == role)
    }

    /// The only column with this role, if there is one.
    fn single(&self, role: ColumnRole) -> Result<Option<(usize, &ColumnRule)>, ReadError> {
        let mut columns = self.with_role(role);
        let first = columns.next();
        match (first, columns.next()) {
            (Some((first, _)), Some((second, _))) => Err(ReadError::RoleTwice {
                path: self.path.to_owned(),
                line: self.start.line,
                role,
                first: first + 1,
                second: second + 1,
            }),
            _ => Ok(first),
        }
    }

    /// What columns are called where one was looked for.
    fn all_names(&self) -> Vec<String> {
        if self.start.names.is_empty() {
            return vec![format!("{} columns without names", self.start.n_columns)];
        }
        self.start.names.clone()
    }

    /// The header's name of a column, without its unit.
    fn bare_name(&self, index: usize) -> Option<String> {
        let name = self.start.names.get(index)?;
        Some(ColumnName::parse(name).name)
    }

    /// A column's unit: that of the rule, else that of the header or the units row.
    fn unit(&self, index: usize, rule: &ColumnRule) -> Option<String> {
        let in_header = || ColumnName::parse(self.start.names.get(index)?).unit;
        let in_units_row = || {
            let unit = unbracketed(self.start.units.get(index)?);
            (!unit.is_empty()).then(|| unit.to_owned())
        };
        rule.unit.clone().or_else(in_header).or_else(in_units_row)
    }

    fn unknown_unit(
        &self,
        index: usize,
        rule: &ColumnRule,
        unit: &str,
        known: &'static str,
    ) -> ReadError {
        let name = self.bare_name(index).or(rule.name.clone());
        ReadError::UnknownUnit {
            path: self.path.to_owned(),
            line: self.start.line,
            column: index + 1,
            name: name.unwrap_or_else(|| rule.is.to_string()),
            unit: unit.to_owned(),
            known,
        }
    }

    fn times(&self) -> Result<(Option<usize>, TimeScale, Vec<Use>), ReadError> {
        let n_columns = match self.start.names.len() {
            0 => self.start.n_columns,
            n_names => n_names,
        };
        let mut uses = vec![Use::Ignored; n_columns];
        if self.side != Side::Gauges
            && let Some((index, _)) = self.single(ColumnRole::Status)?
        {
            uses[index] = Use::Status;
        }
        let ati_rate = self.start.ati.as_ref().and_then(|ati| ati.rate_hz);
        let rate = self.table.sample_rate_hz.or(ati_rate);
        let Some((index, rule)) = self.single(self.side.time_role())? else {
            return match rate {
                Some(rate) => Ok((None, TimeScale::PerSecond(rate), uses)),
                None if self.start.ati.is_some() && self.side == Side::Both => {
                    Err(self.reference_alone())
                }
                None => Err(ReadError::NoTime {
                    path: self.path.to_owned(),
                    line: self.start.line,
                    names: self.all_names(),
                }),
            };
        };
        uses[index] = Use::Time;
        let unit = self.unit(index, rule);
        let unknown = |unit: &str| self.unknown_unit(index, rule, unit, TIME_SPELLINGS);
        let scale = match unit
            .as_deref()
            .map(|unit| (unit, TimeSpelling::from_name(unit)))
        {
            None => TimeScale::ByValues,
            Some((unit, None)) => return Err(unknown(unit)),
            Some((_, Some(TimeSpelling::Number(unit)))) => TimeScale::PerSecond(unit.per_second()),
            Some((_, Some(TimeSpelling::Samples))) => match rate {
                Some(rate) => TimeScale::PerSecond(rate),
                None => {
                    return Err(ReadError::NoSampleRate {
                        path: self.path.to_owned(),
                        line: self.start.line,
                        column: index + 1,
                        name: self.bare_name(index).unwrap_or_else(|| "time".to_owned()),
                    });
                }
            },
            Some((_, Some(TimeSpelling::Text(form)))) => {
                uses[index] = Use::TimeText(form);
                TimeScale::PerSecond(1.0)
            }
        };
        self.date(&mut uses)?;
        Ok((Some(index), scale, uses))
    }

    /// The column with the day, which adds to a time of day.
    fn date(&self, uses: &mut [Use]) -> Result<(), ReadError> {
        if self.side.time_role() != ColumnRole::Time {
            return Ok(());
        }
        if let Some((index, rule)) = self.single(ColumnRole::Date)? {
            let form = match self.unit(index, rule) {
                None => TimeForm::Date(DateOrder::YearMonthDay),
                Some(unit) => match TimeSpelling::from_name(&unit) {
                    Some(TimeSpelling::Text(form @ TimeForm::Date(_))) => form,
                    _ => {
                        return Err(self.unknown_unit(index, rule, &unit, "iso8601, d/m/y, m/d/y"));
                    }
                },
            };
            uses[index] = Use::TimeText(form);
        }
        Ok(())
    }

    fn gauges(&self, uses: &mut [Use]) -> Result<(Vec<String>, Vec<String>), ReadError> {
        let (mut names, mut labels) = (Vec::new(), Vec::new());
        if !self.side.has_gauges() {
            return Ok((names, labels));
        }
        let mut indices: Vec<usize> = Vec::new();
        for (index, rule) in self.with_role(ColumnRole::Gauge) {
            let in_header = || self.bare_name(index).filter(|name| !name.is_empty());
            let name = rule.name.clone().or_else(in_header);
            let name = name.unwrap_or_else(|| format!("S{}", names.len() + 1));
            if let Some(first) = names.iter().position(|other| *other == name) {
                return Err(ReadError::DuplicateGauge {
                    path: self.path.to_owned(),
                    line: self.start.line,
                    name,
                    first: indices[first] + 1,
                    second: index + 1,
                });
            }
            uses[index] = Use::Gauge {
                factor: rule.scale / rule.counts_per_unit,
            };
            indices.push(index);
            names.push(name);
            labels.push(self.unit(index, rule).unwrap_or_default());
        }
        match names.len() {
            0 if self.start.ati.is_some() => Err(self.reference_alone()),
            0 => Err(ReadError::NoGauges {
                path: self.path.to_owned(),
                line: self.start.line,
                names: self.all_names(),
            }),
            count if count > GAUGE_LIMIT => Err(ReadError::TooManyGauges {
                path: self.path.to_owned(),
                line: self.start.line,
                count,
                limit: GAUGE_LIMIT,
                names: self.all_names(),
            }),
            _ => Ok((names, labels)),
        }
    }

    fn reference_alone(&self) -> ReadError {
        ReadError::ReferenceAlone {
            path: self.path.to_owned(),
            line: self.start.line,
        }
    }

    fn loads(&self, uses: &mut [Use]) -> Result<Vec<Axis>, ReadError> {
        let mut axes = Vec::new();
        if !self.side.has_loads() {
            return Ok(axes);
        }
        for axis in Axis::ALL {
            let mut candidates = self.with_role(ColumnRole::Load(axis));
            let Some((index, rule)) = candidates.next() else {
                continue;
            };
            if let Some((second, _)) = candidates.next() {
                return Err(ReadError::DuplicateAxis {
                    path: self.path.to_owned(),
                    line: self.start.line,
                    axis,
                    first: index + 1,
                    second: second + 1,
                });
            }
            uses[index] = Use::Load {
                slot: axes.len(),
                factor: self.load_factor(axis, index, rule)?,
            };
            axes.push(axis);
        }
        if axes.is_empty() && self.side != Side::Both {
            return Err(ReadError::NoLoads {
                path: self.path.to_owned(),
                line: self.start.line,
                names: self.all_names(),
            });
        }
        Ok(axes)
    }

    /// What one of a column's numbers is in SI.
    fn load_factor(&self, axis: Axis, index: usize, rule: &ColumnRule) -> Result<f64, ReadError> {
        let counted = self.counted_unit(axis);
        let in_preamble = || counted.map(|counted| counted.unit.clone());
        let in_si = match self.unit(index, rule).or_else(in_preamble) {
            None => 1.0,
            Some(unit) => axis_factor(axis, &unit)
                .map_err(|known| self.unknown_unit(index, rule, &unit, known))?,
        };
        let counts = counted.map_or(1.0, |counted| counted.counts);
        Ok(in_si * rule.scale / (counts * rule.counts_per_unit))
    }

    /// What the preamble says about an axis.
    fn counted_unit(&self, axis: Axis) -> Option<&CountedUnit> {
        let ati = self.start.ati.as_ref()?;
        Some(if axis.is_force() {
            &ati.force
        } else {
            &ati.moment
        })
    }

    fn names(&self, gauge_names: &[String], uses: &[Use]) -> Vec<String> {
        let mut gauges = gauge_names.iter();
        let mut name = |(index, usage): (usize, &Use)| {
            let of_gauge = match usage {
                Use::Gauge { .. } => gauges.next().cloned(),
                _ => None,
            };
            let rule = || self.columns.iter().find(|(other, _)| *other == index);
            self.bare_name(index)
                .or(of_gauge)
                .or_else(|| rule().map(|(_, rule)| rule.is.to_string()))
                .unwrap_or_default()
        };
        uses.iter().enumerate().map(&mut name).collect()
    }

    fn dropouts(&self, uses: &[Use]) -> Vec<Vec<f64>> {
        let is_used = |index: usize| uses.get(index).is_some_and(|usage| *usage != Use::Ignored);
        let mut dropouts = Vec::new();
        for (index, rule) in &self.columns {
            if !rule.dropouts.is_empty() && is_used(*index) {
                dropouts.resize(uses.len(), Vec::new());
                dropouts[*index] = rule.dropouts.clone();
            }
        }
        dropouts
    }
}

/// What one `unit` on `axis` is in SI, or the units that would be understood.
fn axis_factor(axis: Axis, unit: &str) -> Result<f64, &'static str> {
    if axis.is_force() {
        units::force_in_newtons(unit).ok_or(units::FORCE_UNITS)
    } else {
        units::moment_in_newton_metres(unit).ok_or(units::MOMENT_UNITS)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{plan_and_notes, plan_of_names};
    use super::*;

    #[test]
    fn loads_come_in_axis_order_and_gauges_in_file_order() {
        let (plan, notes) = plan_and_notes("Tz_Nmm,S2,t,Fx [kN],S1 [mV/V]").unwrap();
        assert_eq!(plan.axes, [Axis::Fx, Axis::Mz]);
        assert_eq!(plan.gauge_names, ["S2", "S1"]);
        assert_eq!(plan.gauge_units, ["", "mV/V"]);
        let load = |slot, factor| Use::Load { slot, factor };
        assert_eq!(plan.uses[0], load(1, 1e-3));
        assert_eq!(plan.uses[3], load(0, 1e3));
        assert_eq!(plan.time_scale, TimeScale::ByValues);
        assert!(notes.is_empty());
    }

    #[test]
    fn a_bracketed_unit_stays_with_its_name_between_blanks() {
        let plan = plan_of_names("time [ms]  S1 (mV / V)  Mx (N mm)");
        assert_eq!(plan.time_scale, TimeScale::PerSecond(1e3));
        assert_eq!(plan.names, ["time", "S1", "Mx"]);
        assert_eq!(plan.axes, [Axis::Mx]);
    }

    #[test]
    fn what_cannot_be_used_is_an_error_that_says_where() {
        let message = |text: &str| plan_and_notes(text).unwrap_err().to_string();
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
        assert_eq!(
            plan_of_names(&format!("t{}", gauges(64))).gauge_names.len(),
            64
        );
        let error = plan_and_notes(&format!("t{}", gauges(70))).unwrap_err();
        assert!(matches!(error, ReadError::TooManyGauges { count: 70, .. }));
        assert!(error.to_string().ends_with("ch6 and 63 more"));
    }
}
