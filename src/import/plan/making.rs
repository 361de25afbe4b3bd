//! Applies a column map to a file: finds the columns that the map lists, and returns an error if the map does not fit the
//! file.

use super::{
    super::named_column::NamedColumn,
    parts::{AUXILIARY_LIMIT, CHANNEL_LIMIT, GAUGE_LIMIT, PosePlan, Side, TimeScale, Use},
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

/// Known units of a quantity: a function that returns the factor from a unit to SI, and the names of the units for messages.
type Quantity = (fn(&str) -> Option<f64>, &'static str);

pub struct Making<'a> {
    pub table: &'a TableMap,
    pub head: &'a Head,
    pub side: Side,
    /// Index and rule of each column that is read, in the order of the columns in the file.
    columns: Vec<(usize, &'a ColumnRule)>,
}

impl<'a> Making<'a> {
    /// Finds the columns of a column map in a file.
    pub fn new(table: &'a TableMap, head: &'a Head, side: Side) -> Result<Self, TableError> {
        let is_by_number = |rule: &ColumnRule| matches!(rule.column, ColumnKey::Number(_));
        let (expected, actual) = (table.shape.columns, head.n_columns);
        let has_shape = table.has_shape();
        if has_shape
            && expected != actual
            && (!table.text.header || table.columns.iter().any(is_by_number))
        {
            return Err(TableError::MapShape { expected, actual });
        }
        let mut columns = Header::of(head).rules(table)?;
        for (index, _) in columns.iter().filter(|(_, rule)| is_by_number(rule)) {
            if let (Some(expected), Some(actual)) =
                (table.shape.names.get(*index), head.names.get(*index))
                && expected != actual
            {
                return Err(TableError::MapOtherName {
                    column: index + 1,
                    expected: expected.clone(),
                    actual: actual.clone(),
                });
            }
        }
        columns.retain(|(_, rule)| side.reads(rule.is));
        Ok(Self { table, head, side, columns })
    }

    fn with_role(&self, role: ColumnRole) -> impl Iterator<Item = (usize, &'a ColumnRule)> {
        let columns = self.columns.iter().copied();
        columns.filter(move |(_, rule)| rule.is == role)
    }

    /// Returns the column with this role; `None` if there is none. Returns an error if there are two.
    fn single(&self, role: ColumnRole) -> Result<Option<(usize, &'a ColumnRule)>, TableError> {
        let mut columns = self.with_role(role);
        let first = columns.next();
        match (first, columns.next()) {
            (Some((first, _)), Some((second, _))) => {
                let what = role.to_string();
                Err(TableError::Twice { what, first: first + 1, second: second + 1 })
            }
            _ => Ok(first),
        }
    }

    fn all_names(&self) -> Vec<String> {
        if self.head.names.is_empty() {
            return vec![format!("{} columns without names", self.head.n_columns)];
        }
        self.head.names.clone()
    }

    fn bare_name(&self, index: usize) -> Option<String> {
        self.head.name(index).map(|name| name.name)
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
        unit: &str,
        known: &'static str,
    ) -> TableError {
        let name = self.bare_name(index).or(rule.name.clone());
        TableError::UnknownUnit {
            column: NamedColumn::new(index, name.unwrap_or_else(|| rule.is.to_string())),
            unit: unit.to_owned(),
            known,
        }
    }

    pub fn no_numbers(&self) -> TableError {
        TableError::NoNumbers { names: self.all_names() }
    }

    /// Returns a use for each column. Only the status column and the group column have their use yet; all others are set to
    /// ignored.
    pub fn uses(&self) -> Result<Vec<Use>, TableError> {
        let mut uses = vec![Use::Ignored; self.head.n_columns];
        for (role, usage) in [(ColumnRole::Status, Use::Status), (ColumnRole::Group, Use::Group)] {
            if let Some((index, _)) = self.single(role)? {
                uses[index] = usage;
            }
        }
        Ok(uses)
    }

    /// Finds the time column and sets its use. Returns its index, and the conversion of its times to seconds; `None` if the
    /// rows have no times. Gauges and reference with separate clocks need times.
    pub fn times(
        &self,
        uses: &mut [Use],
    ) -> Result<Option<(Option<usize>, TimeScale)>, TableError> {
        let ati_rate = self.head.ati.as_ref().and_then(|ati| ati.rate_hz);
        let rate = self.table.sample_rate_hz.or(ati_rate);
        let Some((index, rule)) = self.single(self.side.time_role())? else {
            return match rate {
                Some(rate) => Ok(Some((None, TimeScale::PerSecond(rate)))),
                None if self.side == Side::Both => Ok(None),
                None => Err(TableError::NoTime { names: self.all_names() }),
            };
        };
        uses[index] = Use::Time;
        let unit = self.unit(index, rule);
        let unknown = |unit: &str| self.unknown_unit(index, rule, unit, TIME_SPELLINGS);
        let scale = match unit.as_deref().map(|unit| (unit, TimeSpelling::from_name(unit))) {
            None => TimeScale::ByValues,
            Some((unit, None)) => return Err(unknown(unit)),
            Some((_, Some(TimeSpelling::Number(unit)))) => TimeScale::PerSecond(unit.per_second()),
            Some((_, Some(TimeSpelling::Samples))) => match rate {
                Some(rate) => TimeScale::PerSecond(rate),
                None => {
                    let name = self.bare_name(index).unwrap_or_else(|| "time".to_owned());
                    let column = NamedColumn::new(index, name);
                    return Err(TableError::NoSampleRate { column });
                }
            },
            Some((_, Some(TimeSpelling::Text(form)))) => {
                uses[index] = Use::TimeText(form);
                TimeScale::PerSecond(1.0)
            }
        };
        self.date(uses)?;
        Ok(Some((Some(index), self.time_fraction(scale, uses)?)))
    }

    /// Sets the use of the column with fractions of seconds, if there is one. Returns the conversion of times to seconds.
    fn time_fraction(&self, scale: TimeScale, uses: &mut [Use]) -> Result<TimeScale, TableError> {
        let Some((index, rule)) = self.single(ColumnRole::TimeFraction)? else {
            return Ok(scale);
        };
        let unit = self.unit(index, rule).unwrap_or_else(|| "ns".to_owned());
        let fraction = TimeUnit::from_name(&unit)
            .ok_or_else(|| self.unknown_unit(index, rule, &unit, "s, ms, us, ns"))?;
        let per_second = match scale {
            TimeScale::PerSecond(per_second) => per_second,
            TimeScale::ByValues => 1.0,
        };
        uses[index] = Use::TimeFraction { factor: per_second / fraction.per_second() };
        Ok(TimeScale::PerSecond(per_second))
    }

    /// Sets that the values of the date column are added to the times of day.
    fn date(&self, uses: &mut [Use]) -> Result<(), TableError> {
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

    /// Returns the name of a channel: from its rule, else from the header, else `stem` with a running number. A name in the
    /// header that another channel has already gets a number.
    fn channel_name(
        &self,
        index: usize,
        rule: &ColumnRule,
        stem: &str,
        before: &[String],
    ) -> String {
        if let Some(name) = &rule.name {
            return name.clone();
        }
        let in_header = self.bare_name(index).filter(|name| !name.is_empty());
        let name = in_header.unwrap_or_else(|| format!("{stem}{}", before.len() + 1));
        let numbered = (2..).map(|number| format!("{name} ({number})"));
        let mut names = std::iter::once(name.clone()).chain(numbered);
        names.find(|name| !before.contains(name)).unwrap_or_default()
    }

    /// Returns names and units of the columns with this role, and the columns themselves.
    fn named(
        &self,
        role: ColumnRole,
        stem: &str,
        limit: usize,
    ) -> (Vec<String>, Vec<String>, Vec<(usize, &'a ColumnRule)>) {
        let columns: Vec<(usize, &'a ColumnRule)> = self.with_role(role).take(limit).collect();
        let mut names = Vec::new();
        for (index, rule) in &columns {
            names.push(self.channel_name(*index, rule, stem, &names));
        }
        let unit =
            |(index, rule): &(usize, &ColumnRule)| self.unit(*index, rule).unwrap_or_default();
        let units = columns.iter().map(unit).collect();
        (names, units, columns)
    }

    pub fn gauges(&self, uses: &mut [Use]) -> Result<(Vec<String>, Vec<String>), TableError> {
        let count = self.with_role(ColumnRole::Gauge).count();
        if count > GAUGE_LIMIT {
            return Err(TableError::TooManyGauges {
                count,
                limit: GAUGE_LIMIT,
                names: self.all_names(),
            });
        }
        let (names, labels, indices) = self.named(ColumnRole::Gauge, "S", GAUGE_LIMIT);
        for (at, (index, rule)) in indices.iter().enumerate() {
            if let Some(first) = names[..at].iter().position(|other| *other == names[at]) {
                let (what, first) = (format!("gauge {}", names[at]), indices[first].0 + 1);
                return Err(TableError::Twice { what, first, second: index + 1 });
            }
            uses[*index] = Use::Gauge { factor: rule.scale / rule.counts_per_unit };
        }
        if names.is_empty() && self.side == Side::Gauges {
            return Err(TableError::NoGauges { names: self.all_names() });
        }
        Ok((names, labels))
    }

    /// Returns the names and units of the channels that are only shown.
    pub fn channels(&self, uses: &mut [Use]) -> (Vec<String>, Vec<String>) {
        let (names, labels, indices) = self.named(ColumnRole::Channel, "channel ", CHANNEL_LIMIT);
        for (index, rule) in indices {
            uses[index] = Use::Channel { factor: rule.scale / rule.counts_per_unit };
        }
        (names, labels)
    }

    pub fn auxiliary(&self, uses: &mut [Use]) -> Result<(Vec<String>, Vec<String>), TableError> {
        let (names, mut labels, indices) =
            self.named(ColumnRole::Auxiliary, "aux", AUXILIARY_LIMIT + 1);
        for (at, (index, rule)) in indices.into_iter().enumerate() {
            if names[..at].contains(&names[at]) || at == AUXILIARY_LIMIT {
                return Err(TableError::Auxiliaries {
                    column: NamedColumn::new(index, &names[at]),
                    limit: AUXILIARY_LIMIT,
                });
            }
            let (label, factor, shift) = units::auxiliary_unit(&labels[at]);
            uses[index] =
                Use::Auxiliary { factor: factor * rule.scale / rule.counts_per_unit, shift };
            labels[at] = label;
        }
        Ok((names, labels))
    }

    /// Sets the uses of the columns of the sensor's pose, and returns their plan, if the load is computed from the pose.
    pub fn pose(
        &self,
        weight: Option<&WeightMap>,
        uses: &mut [Use],
    ) -> Result<Option<PosePlan>, TableError> {
        let (Some(weight), true) = (weight, self.side != Side::Gauges) else {
            return Ok(None);
        };
        // A pose with missing columns cannot occur here, because the column map was checked before.
        let Ok(Some(attitude)) = Attitude::of_table(self.table) else {
            return Ok(None);
        };
        let mut width = 0;
        let mut place = |part: PosePart, uses: &mut [Use]| -> Result<bool, TableError> {
            let Some((index, rule)) = self.single(ColumnRole::Pose(part))? else {
                return Ok(false);
            };
            uses[index] = Use::Pose { slot: width, factor: self.pose_factor(part, index, rule)? };
            width += 1;
            Ok(true)
        };
        for part in attitude.parts() {
            place(*part, uses)?;
        }
        let mut n_places = 0;
        for part in PosePart::POSITION {
            n_places += usize::from(place(part, uses)?);
        }
        let mount = self.single(ColumnRole::Mount)?.map(|(index, _)| {
            uses[index] = Use::Mount { slot: width };
            width += 1;
            width - 1
        });
        Ok(Some(PosePlan {
            attitude,
            position: (n_places == 3).then_some(attitude.parts().len()),
            mount,
            mounts: weight.mounts.iter().map(|mount| mount.name.clone()).collect(),
            width,
        }))
    }

    fn pose_factor(
        &self,
        part: PosePart,
        index: usize,
        rule: &ColumnRule,
    ) -> Result<f64, TableError> {
        let quantity: Option<Quantity> = if part.is_angle() {
            Some((units::angle_in_radians, units::ANGLE_UNITS))
        } else {
            let is_place = PosePart::POSITION.contains(&part);
            is_place.then_some((units::length_in_metres, units::LENGTH_UNITS))
        };
        self.factor(index, rule, self.unit(index, rule), quantity)
    }

    /// Returns the factor from the numbers in a column to SI units. It includes the scale and the counts per unit of the
    /// rule.
    fn factor(
        &self,
        index: usize,
        rule: &ColumnRule,
        unit: Option<String>,
        quantity: Option<Quantity>,
    ) -> Result<f64, TableError> {
        let in_si = match (unit, quantity) {
            (Some(unit), Some((in_si, known))) => {
                in_si(&unit).ok_or_else(|| self.unknown_unit(index, rule, &unit, known))?
            }
            _ => 1.0,
        };
        Ok(in_si * rule.scale / rule.counts_per_unit)
    }

    pub fn loads(&self, has_pose: bool, uses: &mut [Use]) -> Result<Vec<Axis>, TableError> {
        let mut axes = Vec::new();
        for axis in Axis::ALL {
            if let Some((index, rule)) = self.single(ColumnRole::Load(axis))? {
                let factor = self.load_factor(axis, index, rule)?;
                uses[index] = Use::Load { slot: axes.len(), factor };
                axes.push(axis);
            }
        }
        if axes.is_empty() && !self.side.has_gauges() && !has_pose {
            return Err(TableError::NoLoads { names: self.all_names() });
        }
        Ok(axes)
    }

    fn load_factor(&self, axis: Axis, index: usize, rule: &ColumnRule) -> Result<f64, TableError> {
        let (quantity, counted): (Quantity, _) = if axis.is_force() {
            let counted = self.head.ati.as_ref().map(|ati| &ati.force);
            ((units::force_in_newtons, units::FORCE_UNITS), counted)
        } else {
            let counted = self.head.ati.as_ref().map(|ati| &ati.moment);
            ((units::moment_in_newton_metres, units::MOMENT_UNITS), counted)
        };
        // A log of ATI's Net F/T gives the unit of the loads and the counts per unit in lines above its table.
        let in_preamble = || counted.map(|counted| counted.unit.clone());
        let unit = self.unit(index, rule).or_else(in_preamble);
        let counts = counted.map_or(1.0, |counted| counted.counts);
        Ok(self.factor(index, rule, unit, Some(quantity))? / counts)
    }

    pub fn names(&self, gauge_names: &[String], uses: &[Use]) -> Vec<String> {
        let mut gauges = gauge_names.iter();
        let mut name = |(index, usage): (usize, &Use)| {
            let of_gauge = match usage {
                Use::Gauge { .. } => gauges.next().cloned(),
                _ => None,
            };
            let role = || {
                let at = self.columns.binary_search_by_key(&index, |(index, _)| *index);
                at.ok().map(|at| self.columns[at].1.is.to_string())
            };
            self.bare_name(index).or(of_gauge).or_else(role).unwrap_or_default()
        };
        uses.iter().enumerate().map(&mut name).collect()
    }

    pub fn dropouts(&self, uses: &[Use]) -> Vec<Vec<f64>> {
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
