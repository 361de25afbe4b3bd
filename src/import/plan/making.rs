//! Applies a column map to a file: finds the columns that the map lists, and returns an error if the map does not fit the
//! file.

use super::{
    super::named_column::NamedColumn,
    Plan,
    parts::{
        AUXILIARY_LIMIT, CHANNEL_LIMIT, Channels, GAUGE_LIMIT, PosePlan, Side, TimeScale, Use,
    },
};
use crate::{
    formats::text::{
        Head,
        times::{DateOrder, TIME_SPELLINGS, TimeForm, TimeSpelling},
    },
    import::{
        error::TableError,
        map::{Attitude, ColumnKey, ColumnRole, ColumnRule, Header, PosePart, TableMap, WeightMap},
    },
    recording::{
        Axis,
        units::{self, TimeUnit},
    },
};

/// Columns of a file that are read, with their rules, in the order of the file.
struct Listed<'a> {
    table: &'a TableMap,
    head: &'a Head,
    side: Side,
    columns: Vec<(usize, &'a ColumnRule)>,
}

impl<'a> Listed<'a> {
    /// Finds the columns of a column map in a file.
    fn new(table: &'a TableMap, head: &'a Head, side: Side) -> Result<Self, TableError> {
        let is_by_number = |rule: &ColumnRule| matches!(rule.column, ColumnKey::Number(_));
        let (expected, actual) = (table.shape.columns, head.n_columns);
        let has_numbers = !table.text.header || table.columns.iter().any(is_by_number);
        if table.has_shape() && expected != actual && has_numbers {
            return Err(TableError::MapShape { expected, actual });
        }
        let mut columns = Header::of(head).rules(table)?;
        for (index, _) in columns.iter().filter(|(_, rule)| is_by_number(rule)) {
            let names = [&table.shape.names, &head.names].map(|names| names.get(*index));
            if let [Some(expected), Some(actual)] = names
                && expected != actual
            {
                let (expected, actual) = (expected.clone(), actual.clone());
                return Err(TableError::MapOtherName { column: index + 1, expected, actual });
            }
        }
        columns.retain(|(_, rule)| side.reads(rule.is));
        for (at, (index, rule)) in columns.iter().enumerate() {
            let name = rule.name.as_deref().filter(|_| rule.is.is_channel());
            let is_same = |(_, other): &&(usize, &ColumnRule)| {
                other.is == rule.is && name.is_none_or(|name| other.name.as_deref() == Some(name))
            };
            if (rule.is.is_of_one_column() || name.is_some())
                && let Some((first, _)) = columns[..at].iter().find(is_same)
            {
                let what =
                    format!("{} {}", rule.is, name.unwrap_or_default()).trim_end().to_owned();
                return Err(TableError::Twice { what, first: first + 1, second: index + 1 });
            }
        }
        Ok(Self { table, head, side, columns })
    }

    fn with_role(&self, role: ColumnRole) -> Option<(usize, &'a ColumnRule)> {
        self.columns.iter().copied().find(|(_, rule)| rule.is == role)
    }

    fn names(&self) -> Vec<String> {
        if self.head.names.is_empty() {
            return vec![format!("{} columns without names", self.head.n_columns)];
        }
        self.head.names.clone()
    }

    fn named(&self, index: usize, rule: &ColumnRule) -> NamedColumn {
        let name = self.head.name(index).map(|name| name.name).or(rule.name.clone());
        NamedColumn::new(index, name.unwrap_or_else(|| rule.is.to_string()))
    }

    /// Returns the unit of a column: from its rule, else from the header or the row of units. `None` if none of them gives a
    /// unit.
    fn unit(&self, index: usize, rule: &ColumnRule) -> Option<String> {
        rule.unit.clone().or_else(|| self.head.unit(index))
    }

    fn unknown_unit(
        &self,
        index: usize,
        rule: &ColumnRule,
        known: &'static str,
    ) -> impl Fn() -> TableError {
        let (column, unit) = (self.named(index, rule), self.unit(index, rule).unwrap_or_default());
        move || TableError::UnknownUnit { column: column.clone(), unit: unit.clone(), known }
    }

    /// Returns the factor from the numbers in a column to SI units. It includes the scale and the counts per unit of the
    /// rule. Without known units, the numbers keep their unit.
    fn factor(&self, index: usize, rule: &ColumnRule) -> Result<f64, TableError> {
        type InSi = fn(&str) -> Option<f64>;
        let (in_si, known): (InSi, _) = match rule.is {
            ColumnRole::Load(axis) if axis.is_force() => {
                (units::force_in_newtons, units::FORCE_UNITS)
            }
            ColumnRole::Load(_) => (units::moment_in_newton_metres, units::MOMENT_UNITS),
            ColumnRole::Pose(part) if part.is_angle() => {
                (units::angle_in_radians, units::ANGLE_UNITS)
            }
            ColumnRole::Pose(part) if PosePart::POSITION.contains(&part) => {
                (units::length_in_metres, units::LENGTH_UNITS)
            }
            _ => (|_| Some(1.0), ""),
        };
        // A log of ATI's Net F/T gives the unit of the loads and the counts per unit in lines above its table.
        let counted = self.head.ati.as_ref().and_then(|ati| match rule.is {
            ColumnRole::Load(axis) => Some(if axis.is_force() { &ati.force } else { &ati.moment }),
            _ => None,
        });
        let unit = self.unit(index, rule).or_else(|| Some(counted?.unit.clone()));
        let factor = match unit {
            Some(unit) => in_si(&unit).ok_or_else(self.unknown_unit(index, rule, known))?,
            None => 1.0,
        };
        let counts = counted.map_or(1.0, |counted| counted.counts);
        Ok(factor * rule.scale / rule.counts_per_unit / counts)
    }

    /// Returns the plan for the columns of the sensor's pose, and the parts of the pose in their order, if the load is computed
    /// from the pose.
    fn pose(&self, weight: Option<&WeightMap>) -> Option<(PosePlan, Vec<PosePart>)> {
        let weight = weight.filter(|_| self.side != Side::Gauges)?;
        // A pose with missing columns cannot occur here, because the column map was checked before.
        let attitude = Attitude::of_table(self.table).ok()??;
        let is_there = |part: &PosePart| self.with_role(ColumnRole::Pose(*part)).is_some();
        let position: Vec<PosePart> = PosePart::POSITION.into_iter().filter(is_there).collect();
        let n_turns = attitude.parts().len();
        let has_position = position.len() == PosePart::POSITION.len();
        let parts = [attitude.parts(), &position].concat();
        let mount = self.with_role(ColumnRole::Mount).map(|_| parts.len());
        let plan = PosePlan {
            attitude,
            position: has_position.then_some(n_turns),
            mount,
            mounts: weight.mounts.iter().map(|mount| mount.name.clone()).collect(),
            width: parts.len() + usize::from(mount.is_some()),
        };
        Some((plan, parts))
    }
}

impl Plan {
    /// Makes the plan for a file from a column map and the head of the file.
    pub fn new(
        table: &TableMap,
        head: &Head,
        side: Side,
        weight: Option<&WeightMap>,
    ) -> Result<Self, TableError> {
        let listed = Listed::new(table, head, side)?;
        let (pose, parts) = listed.pose(weight).unzip();
        let has_axis = |axis: &Axis| listed.with_role(ColumnRole::Load(*axis)).is_some();
        let mut plan = Self {
            line: head.line,
            text: table.text.clone(),
            uses: vec![Use::Ignored; head.n_columns],
            names: Vec::new(),
            dropouts: Vec::new(),
            time_scale: TimeScale::PerSecond(1.0),
            since: 0,
            time_column: None,
            gauges: Channels::default(),
            auxiliary: Channels::default(),
            others: Channels::default(),
            axes: Axis::ALL.into_iter().filter(has_axis).collect(),
            pose,
            may_be_blank: side != Side::Both,
            is_static: false,
        };
        for (what, role, limit) in [
            ("gauges", ColumnRole::Gauge, GAUGE_LIMIT),
            ("auxiliary channels", ColumnRole::Auxiliary, AUXILIARY_LIMIT),
        ] {
            let count = listed.columns.iter().filter(|(_, rule)| rule.is == role).count();
            if count > limit {
                return Err(TableError::TooMany { what, count, limit, names: listed.names() });
            }
        }
        plan.take_times(&listed)?;
        if let Some(pose) = plan.pose.as_mut().filter(|_| plan.is_static) {
            // Without times, the acceleration of the weight cannot be computed, so its position is not needed.
            pose.position = None;
        }
        for &(index, rule) in &listed.columns {
            plan.take(&listed, index, rule, parts.as_deref().unwrap_or_default())?;
        }
        let is_read = |usage: &Use| usage.is_number() && !usage.is_time() && *usage != Use::Ignored;
        if side == Side::Gauges && plan.gauges.names.is_empty() {
            return Err(TableError::no_gauges(listed.names()));
        }
        if !side.has_gauges() && plan.axes.is_empty() && plan.pose.is_none() {
            let (what, advice) = ("reference load", "Name the load columns Fx, Fy and so on");
            return Err(TableError::Lacks { what, advice, names: listed.names() });
        }
        if !plan.uses.iter().any(is_read) {
            return Err(TableError::NoNumbers { names: listed.names() });
        }
        plan.names = plan.column_names(&listed);
        Ok(plan)
    }

    /// Sets the use of one column, and adds its channel.
    fn take(
        &mut self,
        listed: &Listed<'_>,
        index: usize,
        rule: &ColumnRule,
        parts: &[PosePart],
    ) -> Result<(), TableError> {
        let unit = || listed.unit(index, rule).unwrap_or_default();
        let name = |stem: &str, before: &Channels| {
            let in_header = || Some(listed.head.name(index)?.name).filter(|name| !name.is_empty());
            let numbered = || format!("{stem}{}", before.names.len() + 1);
            rule.name.clone().or_else(in_header).unwrap_or_else(numbered)
        };
        let usage = match rule.is {
            ColumnRole::Gauge => {
                self.gauges.add(name("S", &self.gauges), unit());
                Use::Gauge { factor: listed.factor(index, rule)? }
            }
            ColumnRole::Auxiliary => {
                let (unit, factor, shift) = units::auxiliary_unit(&unit());
                self.auxiliary.add(name("aux", &self.auxiliary), unit);
                Use::Auxiliary { factor: factor * listed.factor(index, rule)?, shift }
            }
            ColumnRole::Channel if self.others.names.len() < CHANNEL_LIMIT => {
                self.others.add(name("channel ", &self.others), unit());
                Use::Channel { factor: listed.factor(index, rule)? }
            }
            ColumnRole::Load(axis) => {
                let slot = self.axes.iter().take_while(|other| **other != axis).count();
                Use::Load { slot, factor: listed.factor(index, rule)? }
            }
            ColumnRole::Pose(part) => match parts.iter().position(|own| *own == part) {
                Some(slot) => Use::Pose { slot, factor: listed.factor(index, rule)? },
                None => return Ok(()),
            },
            ColumnRole::Mount if self.pose.is_some() => Use::Mount { slot: parts.len() },
            ColumnRole::Status => Use::Status,
            ColumnRole::Group => Use::Group,
            _ => self.uses[index],
        };
        self.uses[index] = usage;
        if !rule.dropouts.is_empty() && usage != Use::Ignored {
            self.dropouts.resize(self.uses.len(), Vec::new());
            self.dropouts[index].clone_from(&rule.dropouts);
        }
        Ok(())
    }

    /// Sets the uses of the columns that give the time, and the conversion of times to seconds. Gauges and reference with
    /// separate clocks need times.
    fn take_times(&mut self, listed: &Listed<'_>) -> Result<(), TableError> {
        let ati_rate = listed.head.ati.as_ref().and_then(|ati| ati.rate_hz);
        let rate = listed.table.sample_rate_hz.or(ati_rate);
        let Some((index, rule)) = listed.with_role(listed.side.time_role()) else {
            self.is_static = rate.is_none();
            self.time_scale = TimeScale::PerSecond(rate.unwrap_or(1.0));
            return if self.is_static && listed.side != Side::Both {
                Err(TableError::no_time(listed.names()))
            } else {
                Ok(())
            };
        };
        let spelling = |(index, rule), known| {
            let unit = listed.unit(index, rule);
            let spelling = unit.map(|unit| TimeSpelling::from_name(&unit));
            spelling.map(|own| own.ok_or_else(listed.unknown_unit(index, rule, known))).transpose()
        };
        (self.time_column, self.uses[index]) = (Some(index), Use::Time);
        self.time_scale = match spelling((index, rule), TIME_SPELLINGS)? {
            None => TimeScale::ByValues,
            Some(TimeSpelling::Number(unit)) => TimeScale::PerSecond(unit.per_second()),
            Some(TimeSpelling::Samples) => {
                let column = listed.named(index, rule);
                TimeScale::PerSecond(rate.ok_or(TableError::NoSampleRate { column })?)
            }
            Some(TimeSpelling::Text(form)) => {
                self.uses[index] = Use::TimeText(form);
                TimeScale::PerSecond(1.0)
            }
        };
        if let Some((index, rule)) = listed.with_role(ColumnRole::Date) {
            const DATES: &str = "iso8601, d/m/y, m/d/y";
            self.uses[index] = Use::TimeText(match spelling((index, rule), DATES)? {
                None => TimeForm::Date(DateOrder::YearMonthDay),
                Some(TimeSpelling::Text(form @ TimeForm::Date(_))) => form,
                Some(_) => return Err(listed.unknown_unit(index, rule, DATES)()),
            });
        }
        if let Some((index, rule)) = listed.with_role(ColumnRole::TimeFraction) {
            let unit = listed.unit(index, rule).unwrap_or_else(|| "ns".to_owned());
            let unknown = listed.unknown_unit(index, rule, "s, ms, us, ns");
            let fraction = TimeUnit::from_name(&unit).ok_or_else(unknown)?;
            let per_second = match self.time_scale {
                TimeScale::PerSecond(per_second) => per_second,
                TimeScale::ByValues => 1.0,
            };
            self.uses[index] = Use::TimeFraction { factor: per_second / fraction.per_second() };
            self.time_scale = TimeScale::PerSecond(per_second);
        }
        Ok(())
    }

    /// Returns the name of each column for messages: from the header, else that of its channel, else its role.
    fn column_names(&self, listed: &Listed<'_>) -> Vec<String> {
        let mut gauges = self.gauges.names.iter();
        let mut name = |(index, usage): (usize, &Use)| {
            let of_gauge = matches!(usage, Use::Gauge { .. }).then(|| gauges.next().cloned());
            let role = || {
                let (_, rule) = listed.columns.iter().find(|(at, _)| *at == index)?;
                Some(rule.is.to_string())
            };
            let in_header = listed.head.name(index).map(|name| name.name);
            in_header.or(of_gauge.flatten()).or_else(role).unwrap_or_default()
        };
        self.uses.iter().enumerate().map(&mut name).collect()
    }
}
