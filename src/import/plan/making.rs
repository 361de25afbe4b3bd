//! Applies a column map to a file: finds the columns that the map lists, and returns an error if the map does not fit the
//! file.

use super::{
    super::named_column::NamedColumn, AUXILIARY_LIMIT, CHANNEL_LIMIT, Channels, GAUGE_LIMIT, Plan,
    PlannedColumn, Side,
};
use crate::{
    formats::text::{
        Head,
        times::{DateOrder, TIME_SPELLINGS, TimeForm, TimeSpelling},
    },
    import::{
        error::TableError,
        map::{Attitude, ColumnKey, ColumnRole, ColumnRule, Header, TableMap, WeightMap},
    },
    recording::{
        Axis,
        units::{self, TimeUnit},
    },
};

/// Column of a file that is read, with its rule.
struct Listed<'a> {
    index: usize,
    rule: &'a ColumnRule,
    /// Name of the column in the header.
    name: Option<String>,
    /// Unit of the column: from its rule, else from the header or the row of units.
    unit: Option<String>,
}

impl<'a> Listed<'a> {
    /// Finds the columns of a column map in a file. They have the order of the file.
    fn all(table: &'a TableMap, head: &Head, side: Side) -> Result<Vec<Self>, TableError> {
        let is_by_number = |rule: &ColumnRule| matches!(rule.column, ColumnKey::Number(_));
        let (expected, actual) = (table.shape.columns, head.n_columns);
        let has_numbers = !table.text.header || table.columns.iter().any(is_by_number);
        if table.has_shape() && expected != actual && has_numbers {
            return Err(TableError::MapShape { expected, actual });
        }
        let mut rules = Header::of(head).rules(table)?;
        for (index, _) in rules.iter().filter(|(_, rule)| is_by_number(rule)) {
            let names = [&table.shape.names, &head.names].map(|names| names.get(*index));
            if let [Some(expected), Some(actual)] = names
                && expected != actual
            {
                let (expected, actual) = (expected.clone(), actual.clone());
                return Err(TableError::MapOtherName { column: index + 1, expected, actual });
            }
        }
        rules.retain(|(_, rule)| side.reads(rule.is));
        for (at, (index, rule)) in rules.iter().enumerate() {
            let name = rule.name.as_deref().filter(|_| rule.is.is_channel());
            let is_same = |(_, other): &&(usize, &ColumnRule)| {
                other.is == rule.is && name.is_none_or(|name| other.name.as_deref() == Some(name))
            };
            if (rule.is.is_of_one_column() || name.is_some())
                && let Some((first, _)) = rules[..at].iter().find(is_same)
            {
                let what =
                    format!("{} {}", rule.is, name.unwrap_or_default()).trim_end().to_owned();
                return Err(TableError::Twice { what, first: first + 1, second: index + 1 });
            }
        }
        let listed = |(index, rule): (usize, &'a ColumnRule)| Self {
            index,
            rule,
            name: head.name(index).map(|name| name.name),
            unit: rule.unit.clone().or_else(|| head.unit(index)),
        };
        Ok(rules.into_iter().map(listed).collect())
    }

    fn column(&self) -> NamedColumn {
        let name = self.name.clone().or(self.rule.name.clone());
        NamedColumn::new(self.index, name.unwrap_or_else(|| self.rule.is.to_string()))
    }

    /// Returns the name of the column's channel, which is numbered if nothing names it.
    fn channel(&self, stem: &str, before: &Channels) -> String {
        let in_header = || self.name.clone().filter(|name| !name.is_empty());
        let numbered = || format!("{stem}{}", before.names.len() + 1);
        self.rule.name.clone().or_else(in_header).unwrap_or_else(numbered)
    }

    fn unknown_unit(&self, known: &'static str) -> TableError {
        let unit = self.unit.clone().unwrap_or_default();
        TableError::UnknownUnit { column: self.column(), unit, known }
    }

    /// Returns how the times of the column are written; `None` if it has no unit.
    fn spelling(&self, known: &'static str) -> Result<Option<TimeSpelling>, TableError> {
        let spelling =
            |unit: &String| TimeSpelling::from_name(unit).ok_or_else(|| self.unknown_unit(known));
        self.unit.as_ref().map(spelling).transpose()
    }

    /// Returns the factor from the numbers in the column to SI units. It includes the scale and the counts per unit of the
    /// rule. Without known units, the numbers keep their unit.
    fn factor(&self, head: &Head) -> Result<f64, TableError> {
        type InSi = fn(&str) -> Option<f64>;
        let (in_si, known): (InSi, _) = match self.rule.is {
            ColumnRole::Load(axis) if axis.is_force() => {
                (units::force_in_newtons, units::FORCE_UNITS)
            }
            ColumnRole::Load(_) => (units::moment_in_newton_metres, units::MOMENT_UNITS),
            ColumnRole::Pose(part) if part.is_angle() => {
                (units::angle_in_radians, units::ANGLE_UNITS)
            }
            _ => (|_| Some(1.0), ""),
        };
        // A log of ATI's Net F/T gives the unit of the loads and the counts per unit in lines above its table.
        let counted = head.ati.as_ref().and_then(|ati| match self.rule.is {
            ColumnRole::Load(axis) => Some(if axis.is_force() { &ati.force } else { &ati.moment }),
            _ => None,
        });
        let unit = self.unit.as_deref().or_else(|| Some(&counted?.unit));
        let factor = match unit {
            Some(unit) => in_si(unit).ok_or_else(|| self.unknown_unit(known))?,
            None => 1.0,
        };
        let counts = counted.map_or(1.0, |counted| counted.counts);
        Ok(factor * self.rule.scale / self.rule.counts_per_unit / counts)
    }
}

fn with_role<'a, 'b>(listed: &'b [Listed<'a>], role: ColumnRole) -> Option<&'b Listed<'a>> {
    listed.iter().find(|column| column.rule.is == role)
}

impl Plan {
    /// Makes the plan for a file from a column map and the head of the file.
    pub fn new(
        table: &TableMap,
        head: &Head,
        side: Side,
        weight: Option<&WeightMap>,
    ) -> Result<Self, TableError> {
        let listed = Listed::all(table, head, side)?;
        let names = || {
            if head.names.is_empty() {
                return vec![format!("{} columns without names", head.n_columns)];
            }
            head.names.clone()
        };
        for (what, role, limit) in [
            ("gauges", ColumnRole::Gauge, GAUGE_LIMIT),
            ("auxiliary channels", ColumnRole::Auxiliary, AUXILIARY_LIMIT),
        ] {
            let count = listed.iter().filter(|column| column.rule.is == role).count();
            if count > limit {
                return Err(TableError::TooMany { what, count, limit, names: names() });
            }
        }
        // An orientation with missing columns cannot occur here, because the column map was checked before.
        let has_weight = weight.is_some() && side != Side::Gauges;
        let attitude = Attitude::of_table(table).ok().flatten().filter(|_| has_weight);
        let has_axis = |axis: &Axis| with_role(&listed, ColumnRole::Load(*axis)).is_some();
        let unused = |index| PlannedColumn {
            is: ColumnRole::Ignore,
            name: head.name(index).map_or_else(String::new, |name| name.name),
            factor: 1.0,
            shift: 0.0,
            slot: 0,
            form: None,
            dropouts: Vec::new(),
        };
        let mut plan = Self {
            line: head.line,
            text: table.text.clone(),
            columns: (0..head.n_columns).map(unused).collect(),
            per_second: Some(1.0),
            since: 0,
            time_column: None,
            gauges: Channels::default(),
            auxiliary: Channels::default(),
            others: Channels::default(),
            axes: Axis::ALL.into_iter().filter(has_axis).collect(),
            attitude,
            may_be_blank: side != Side::Both,
            is_static: false,
        };
        let ati_rate = head.ati.as_ref().and_then(|ati| ati.rate_hz);
        plan.take_times(&listed, side, table.sample_rate_hz.or(ati_rate))?;
        if plan.is_static && side != Side::Both {
            return Err(TableError::no_time(names()));
        }
        for column in &listed {
            plan.take(column, head)?;
        }
        if side == Side::Gauges && plan.gauges.names.is_empty() {
            return Err(TableError::no_gauges(names()));
        }
        if !side.has_gauges() && plan.axes.is_empty() && plan.attitude.is_none() {
            let (what, advice) = ("reference load", "Name the load columns Fx, Fy and so on");
            return Err(TableError::Lacks { what, advice, names: names() });
        }
        let is_read = |column: &PlannedColumn| {
            column.is_number() && !column.is_time() && column.is != ColumnRole::Ignore
        };
        if !plan.columns.iter().any(is_read) {
            return Err(TableError::NoNumbers { names: names() });
        }
        Ok(plan)
    }

    /// Sets the use of one column that is no time, and adds its channel.
    fn take(&mut self, listed: &Listed<'_>, head: &Head) -> Result<(), TableError> {
        let column = &mut self.columns[listed.index];
        let is = listed.rule.is;
        let unit = listed.unit.clone().unwrap_or_default();
        let mut name = None;
        match is {
            ColumnRole::Gauge => {
                self.gauges.add(listed.channel("S", &self.gauges), unit);
                name = self.gauges.names.last().cloned();
            }
            ColumnRole::Auxiliary => {
                let (unit, factor, shift) = units::auxiliary_unit(&unit);
                self.auxiliary.add(listed.channel("aux", &self.auxiliary), unit);
                (column.factor, column.shift) = (factor, shift);
            }
            ColumnRole::Channel if self.others.names.len() < CHANNEL_LIMIT => {
                self.others.add(listed.channel("channel ", &self.others), unit);
            }
            ColumnRole::Load(axis) => {
                column.slot = self.axes.iter().take_while(|other| **other != axis).count();
            }
            ColumnRole::Pose(part) => {
                let parts = self.attitude.map_or(&[][..], Attitude::parts);
                let Some(slot) = parts.iter().position(|other| *other == part) else {
                    return Ok(());
                };
                column.slot = slot;
            }
            ColumnRole::Status | ColumnRole::Group => {}
            _ => {
                if column.is_time() {
                    column.dropouts.clone_from(&listed.rule.dropouts);
                }
                return Ok(());
            }
        }
        column.is = is;
        column.dropouts.clone_from(&listed.rule.dropouts);
        column.factor *= listed.factor(head)?;
        if listed.name.is_none() {
            column.name = name.unwrap_or_else(|| is.to_string());
        }
        Ok(())
    }

    /// Sets the uses of the columns that give the time, and the conversion of times to seconds.
    fn take_times(
        &mut self,
        listed: &[Listed<'_>],
        side: Side,
        rate: Option<f64>,
    ) -> Result<(), TableError> {
        let Some(time) = with_role(listed, side.time_role()) else {
            self.is_static = rate.is_none();
            self.per_second = Some(rate.unwrap_or(1.0));
            return Ok(());
        };
        let mut give = |source: &Listed<'_>, is, form, factor| {
            let column = &mut self.columns[source.index];
            (column.is, column.form, column.factor) = (is, form, factor);
            if source.name.is_none() {
                column.name = source.rule.is.to_string();
            }
        };
        let mut form = None;
        let mut per_second = match time.spelling(TIME_SPELLINGS)? {
            None => None,
            Some(TimeSpelling::Number(unit)) => Some(unit.per_second()),
            Some(TimeSpelling::Samples) => {
                let no_rate = || TableError::NoSampleRate { column: time.column() };
                Some(rate.ok_or_else(no_rate)?)
            }
            Some(TimeSpelling::Text(text)) => {
                form = Some(text);
                Some(1.0)
            }
        };
        give(time, ColumnRole::Time, form, 1.0);
        if let Some(date) = with_role(listed, ColumnRole::Date) {
            const DATES: &str = "iso8601, d/m/y, m/d/y";
            let form = match date.spelling(DATES)? {
                None => TimeForm::Date(DateOrder::YearMonthDay),
                Some(TimeSpelling::Text(form @ TimeForm::Date(_))) => form,
                Some(_) => return Err(date.unknown_unit(DATES)),
            };
            give(date, ColumnRole::Date, Some(form), 1.0);
        }
        if let Some(fraction) = with_role(listed, ColumnRole::TimeFraction) {
            let unit = TimeUnit::from_name(fraction.unit.as_deref().unwrap_or("ns"));
            let unit = unit.ok_or_else(|| fraction.unknown_unit("s, ms, us, ns"))?;
            let of_time = *per_second.get_or_insert(1.0);
            give(fraction, ColumnRole::TimeFraction, None, of_time / unit.per_second());
        }
        (self.time_column, self.per_second) = (Some(time.index), per_second);
        Ok(())
    }
}
