//! The one rule by which the columns of a table get their roles: from name, unit and values together. Every reader and every face
//! of the program takes the roles from here.
//!
//! Guarantees: a table of numbers always gets roles by which it can be read. What a column map leaves out is proposed. What the
//! columns do not show and what changes a result is a [`Question`] with its shortest answer.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use super::{
    column_report::{ColumnReport, Content, Reason, date_orders, described, reports},
    error::{ReadError, at},
    map::{
        Attitude, ColumnKey, ColumnMap, ColumnRole, ColumnRule, Header, KeyError, PosePart,
        ReferenceFile, Rest, Shape, TableMap,
    },
    named_column::NamedColumn,
    plan::{AUXILIARY_LIMIT, CHANNEL_LIMIT, GAUGE_LIMIT},
    pose_names::pose_part,
    question::{About, Question},
    timeline,
    warning::Cause,
};
use crate::{
    formats::{
        Cell, Opened, Sample,
        column_name::{Kind, is_identifier},
        text::{Decimal, Head, Preamble, TextLayout, times::TimeForm},
    },
    recording::Axis,
};

/// Number of values from which a column of whole numbers may be a load in counts.
const MANY_VALUES: usize = 12;
/// Magnitude from which a load of whole numbers without a unit may be in counts.
const LEAST_COUNTS: f64 = 1e3;
/// Largest plausible force (N) and moment (N·m) without a unit.
const LARGEST_FORCE: f64 = 1e5;
const LARGEST_MOMENT: f64 = 1e4;
/// Minimum number of rows from which a first column that rises in uneven steps is a time. Load cases that are written by hand
/// are fewer.
const UNEVEN_CLOCK_ROWS: usize = 30;
/// Number of rows up to which a table without names, all of whose columns rise or fall, is taken for a table of load cases.
const FEW_ROWS: usize = 60;

/// Roles of the columns of one file: those that a column map gives, and the proposed ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mapped {
    /// Map of the roles of all columns.
    pub map: ColumnMap,
    /// Columns of the file with their roles and the reasons for these.
    pub columns: Vec<ColumnReport>,
    /// Questions about the columns that the roles leave open.
    pub questions: Vec<Question>,
    /// Loads that have no unit and are read in N or N·m.
    pub without_unit: Vec<String>,
    pub(super) notes: Vec<Cause>,
    /// False if the roles follow from values, so that a map which the user chose for a similar file is better.
    pub(super) is_certain: bool,
}

/// Returns the roles of the columns of a file. What `map` leaves out is proposed. `layout` is used instead of the detected one.
pub fn mapped(
    path: &Path,
    opened: &Opened,
    map: Option<&ColumnMap>,
    layout: Option<&TextLayout>,
) -> Result<Mapped, ReadError> {
    let no_header = || ReadError::NoHeader { path: path.to_owned() };
    let given = map.filter(|map| map.table.has_shape()).map(|map| &map.table.text);
    let text = match layout.or(given) {
        Some(text) => text.clone(),
        None => opened.layout().ok_or_else(no_header)?,
    };
    let Some(head) = opened.head(&text) else {
        // The reader of the table says what is missing.
        let map = map.ok_or_else(no_header)?.clone();
        return Ok(Mapped { map, ..Mapped::default() });
    };
    let sample = opened.sample(&text, &head);
    if let Some(map) = map.filter(|map| map.table.rest == Rest::Ignored) {
        let columns = reports(&map.table, &head, &sample);
        return Ok(Mapped { map: map.clone(), columns, is_certain: true, ..Mapped::default() });
    }
    // Of several tables side by side, the one with the first column that the map names is read.
    let header = Header::of(&head);
    let chosen = map.and_then(|map| map.table.columns.first());
    let chosen = chosen.and_then(|rule| header.index(&rule.column).ok());
    let mut proposal = Proposal::new(&text, &head, &sample, chosen.unwrap_or_default());
    let is_certain = map.is_some() || proposal.is_by_names;
    let map = match map {
        Some(map) => proposal.completed(map).map_err(|why| at(path, head.line)(why.into()))?,
        None => {
            if text.decimal == Decimal::Comma {
                proposal.notes.push(Cause::ExpectedComma);
            }
            let detected = layout.is_none().then(|| text.clone().with_either_mark());
            proposal.map(path, detected.unwrap_or_else(|| text.clone()))
        }
    };
    let bare = proposal.loads_without_unit().map(|column| column.name.clone());
    let without_unit = bare.collect();
    let Proposal { columns, questions, notes, .. } = proposal;
    Ok(Mapped { map, columns, questions, without_unit, notes, is_certain })
}

/// Columns of one table with their roles, with what was assumed and what is still open. A column without a role has the role
/// `ignore`.
pub struct Proposal<'a> {
    text: &'a TextLayout,
    head: &'a Head,
    rows: &'a [Vec<Cell<'a>>],
    pub columns: Vec<ColumnReport>,
    pub notes: Vec<Cause>,
    questions: Vec<Question>,
    /// True if the names alone give the time, the gauges and the loads.
    is_by_names: bool,
    /// Columns of which the roles are proposed: all, or those of one of several tables side by side.
    read: Range<usize>,
}

impl<'a> Proposal<'a> {
    /// Proposes the roles of the columns of a table from some of its rows. Of several tables side by side, the one with the
    /// column `chosen` is read.
    pub fn new(
        text: &'a TextLayout,
        head: &'a Head,
        sample: &'a Sample<'a>,
        chosen: usize,
    ) -> Self {
        let columns = described(text, head, sample);
        let (notes, questions) = (Vec::new(), Vec::new());
        // Cells beyond the last column of the table cannot be read.
        let (rows, read) = (&sample.rows, 0..head.n_columns);
        let is_by_names = false;
        let mut all = Self { text, head, rows, columns, notes, questions, is_by_names, read };
        all.propose(chosen);
        all
    }

    fn propose(&mut self, chosen: usize) {
        for column in &mut self.columns {
            let unit = column.unit.as_deref();
            column.named.kind = column.named.kind.and_then(|kind| kind.with_unit(unit));
            if column.unit.is_none() && column.named.kind.is_none() {
                column.unit = column.named.unit_behind_name();
            }
            let is_load = matches!(column.named.kind, Some(Kind::Load(axis)) if axis.is_force())
                || column.is_unnamed_load();
            if column.unit.is_none() && is_load {
                column.unit.clone_from(&self.head.load_unit);
            }
        }
        self.choose_table(chosen);
        self.choose_reference();
        if self.text.preamble == Some(Preamble::AtiNetFt) {
            self.ati_columns();
        } else {
            self.times();
        }
        self.poses();
        for index in 0..self.columns.len() {
            if let Some(Kind::Load(axis)) = self.columns[index].named.kind
                && self.is_free(index)
                && !self.has(|role| role == ColumnRole::Load(axis))
            {
                self.give(index, ColumnRole::Load(axis), Reason::Name);
            }
        }
        let is_group = |own: &ColumnReport| {
            let name = own.named.name.to_lowercase();
            name == "group" || name == "trial" && 4 * own.n_different < self.rows.len()
        };
        if let Some(&index) = self.free(is_group).first() {
            self.give(index, ColumnRole::Group, Reason::Name);
        }
        self.sensors();
        let has_named_gauges = self.columns.iter().any(|own| own.named.kind == Some(Kind::Gauge));
        self.is_by_names = has_named_gauges && self.has(|role| role == ColumnRole::Time);
        self.unnamed_loads();
        self.gauges(has_named_gauges);
        // Numbers that no calibration uses are only shown.
        for index in self.free(ColumnReport::moves).into_iter().take(CHANNEL_LIMIT) {
            let is_counter = self.columns[index].is_counter();
            let why = if is_counter { Reason::Counter } else { Reason::Shown };
            self.give(index, ColumnRole::Channel, why);
        }
        self.note();
        self.ask();
        if self.is_turn_by_turn() {
            self.notes.push(Cause::TurnByTurn);
        }
    }

    fn give(&mut self, index: usize, is: ColumnRole, why: Reason) {
        (self.columns[index].is, self.columns[index].why) = (is, why);
    }

    fn give_with_unit(&mut self, index: usize, is: ColumnRole, unit: Option<&str>, why: Reason) {
        self.give(index, is, why);
        if let Some(unit) = unit {
            self.columns[index].unit = Some(unit.to_owned());
        }
    }

    fn is_free(&self, index: usize) -> bool {
        self.columns[index].is == ColumnRole::Ignore && self.read.contains(&index)
    }

    /// Returns the columns with a role for which `is_it` returns true.
    fn with_role(&self, is_it: impl Fn(ColumnRole) -> bool) -> impl Iterator<Item = &ColumnReport> {
        self.columns.iter().filter(move |own| is_it(own.is))
    }

    fn has(&self, is_it: impl Fn(ColumnRole) -> bool) -> bool {
        self.with_role(is_it).next().is_some()
    }

    /// Returns the indices of the columns without a role for which `is_it` returns true.
    fn free(&self, is_it: impl Fn(&ColumnReport) -> bool) -> Vec<usize> {
        let free = self.with_role(|role| role == ColumnRole::Ignore);
        let free = free.filter(|own| self.read.contains(&(own.number - 1)) && is_it(own));
        free.map(|own| own.number - 1).collect()
    }

    /// Returns the names of the columns as they are written, in the header or in a comment above the rows.
    fn names(&self) -> &[String] {
        if self.text.header { &self.head.names } else { &self.head.names_in_comment }
    }

    fn written_name(&self, index: usize) -> String {
        self.names().get(index).cloned().unwrap_or_else(|| format!("column {}", index + 1))
    }

    /// Restricts the columns to one of several tables that stand side by side, each with its clock and with the same names.
    fn choose_table(&mut self, chosen: usize) {
        let is_time =
            |own: &&ColumnReport| own.named.kind == Some(Kind::Time) || own.has_time_unit();
        let mut times = self.columns.iter().filter(is_time).map(|own| own.number - 1);
        let (Some(first), Some(second)) = (times.next(), times.next()) else { return };
        let width = second - first;
        let mut names: Vec<&str> = self.columns.iter().map(|own| &*own.named.name).collect();
        names.truncate(names.iter().rposition(|name| !name.is_empty()).map_or(0, |last| last + 1));
        let mut tables = names[first..].chunks(width);
        if width < 2 || tables.any(|table| table != &names[first..second]) {
            return;
        }
        let start = chosen - chosen.saturating_sub(first) % width;
        self.read = start.max(first)..start.max(first) + width;
        let n_tables = (names.len() - first) / width;
        // The tables need not be equally long.
        self.columns
            .iter_mut()
            .for_each(|column| (column.why, column.is_filled) = (Reason::Shown, true));
        self.notes.push(Cause::SideBySide {
            n_tables,
            first: self.read.start + 1,
            last: self.read.end,
        });
    }

    /// If several topics or structs of a log contain the same axis, keeps only the loads of one of them as the reference, and
    /// only shows the others. Preferred are names such as `ref`, then the larger number of axes, then the first one in the
    /// file.
    fn choose_reference(&mut self) {
        const REFERENCES: [&str; 7] =
            ["ati", "ref", "reference", "referenz", "truth", "gt", "ground_truth"];
        // A repeated name without a path belongs to another device, such as the second of two plates.
        let mut sources: Vec<(&str, Vec<(Axis, usize)>)> = Vec::new();
        for (index, column) in self.columns.iter().enumerate() {
            let Some(Kind::Load(axis)) = column.named.kind else { continue };
            if !self.read.contains(&index) {
                continue;
            }
            let source = column.named.source.as_str();
            let is_open = |(other, loads): &&mut (&str, Vec<(Axis, usize)>)| {
                *other == source && loads.iter().all(|(other, _)| *other != axis)
            };
            match sources.iter_mut().find(is_open) {
                Some((_, loads)) => loads.push((axis, index)),
                None => sources.push((source, vec![(axis, index)])),
            }
        }
        let all = || sources.iter().flat_map(|(_, loads)| loads);
        if Axis::ALL.iter().all(|axis| all().filter(|(other, _)| other == axis).count() <= 1) {
            return;
        }
        let is_called_so =
            |source: &str| source.split(['/', '_']).any(|word| REFERENCES.contains(&word));
        // The order is reversed, because `max_by_key` returns the last of equal elements, and the first is wanted.
        let used = sources.iter().rev();
        let used = used.max_by_key(|(source, loads)| (is_called_so(source), loads.len()));
        let used = used.map_or(&[][..], |(_, loads)| loads);
        let (used, mut others): (Vec<usize>, Vec<usize>) = all()
            .map(|(_, index)| *index)
            .partition(|index| used.iter().any(|(_, other)| other == index));
        others.sort_unstable();
        let names =
            |of: &[usize]| of.iter().map(|index| self.columns[*index].named.name.clone()).collect();
        let cause = Cause::SeveralReferences { used: names(&used), others: names(&others) };
        self.notes.push(cause);
        for index in others {
            self.columns[index].named.kind = None;
            if self.columns[index].moves() {
                self.give(index, ColumnRole::Channel, Reason::Shown);
            }
        }
    }

    /// Finds the time, and the date and the fraction of a second that belong to it.
    fn times(&mut self) {
        if let Some(index) = self.head.reference_time {
            self.give(index, ColumnRole::TimeReference, Reason::Name);
        }
        // A name of a time over texts, or over a column that is mostly empty, is not the clock of the table.
        let is_named = |own: &ColumnReport| {
            own.named.kind == Some(Kind::Time) && own.content != Content::Text && own.is_filled
        };
        // A unit of time, or a name that only contains a word for time, needs values like a clock.
        let is_clock = |own: &ColumnReport| {
            let is_called = own.has_time_unit() || own.named.has_clock_word();
            own.named.kind.is_none()
                && own.runs_like_clock
                && own.is_filled
                && (is_called || own.content == Content::Times)
        };
        let mut why = Reason::Name;
        let mut times = self.free(is_named);
        // A clock moves. Of several, an even one is that of the samples, and a time of day with uneven steps that of the disk.
        let may_be_clock = |index: &usize| {
            let column = &self.columns[*index];
            // One part of a stamp need not move: its seconds in the rows of one second, or the rest in steps of a second.
            column.content != Content::Numbers || column.moves() || column.named.is_of_stamp()
        };
        if times.iter().any(may_be_clock) {
            times.retain(may_be_clock);
        }
        let is_even = |index: &usize| self.columns[*index].is_even;
        let of_day = |index: &usize| self.columns[*index].form == Some(TimeForm::TimeOfDay);
        if times.first().is_some_and(|first| of_day(first) && !is_even(first)) {
            times.sort_by_key(|index| !is_even(index));
        }
        let fraction = self.stamp_fraction(&mut times);
        if times.is_empty() {
            times = self.free(is_clock);
            let is_called = |index: &usize| {
                let own = &self.columns[*index];
                own.unit.is_some() || own.named.has_clock_word()
            };
            why = if times.first().is_some_and(is_called) { Reason::Name } else { Reason::Clock };
        }
        if times.is_empty() {
            why = Reason::Clock;
            times = self.nameless_clock();
        }
        let Some((&time, others)) = times.split_first() else { return };
        let form = self.columns[time].form;
        let unit = form.map(TimeForm::name).filter(|_| self.columns[time].unit.is_none());
        self.give_with_unit(time, ColumnRole::Time, unit, why);
        if let Some(index) = fraction {
            self.give(index, ColumnRole::TimeFraction, Reason::Name);
        }
        let dates = self.free(|own| matches!(own.form, Some(TimeForm::Date(_))));
        if form == Some(TimeForm::TimeOfDay)
            && let Some(&date) = dates.first()
        {
            let form = self.columns[date].form.map(TimeForm::name);
            self.give_with_unit(date, ColumnRole::Date, form, Reason::Name);
        }
        if !others.is_empty() {
            let others = others.iter().map(|index| self.written_name(*index)).collect();
            self.notes.push(Cause::SeveralTimes { used: self.written_name(time), others });
        }
    }

    /// Finds a time stamp that is divided into two columns, seconds and nanoseconds. Moves the column with the seconds to the
    /// front of `times`, and returns the column with the nanoseconds.
    fn stamp_fraction(&self, times: &mut Vec<usize>) -> Option<usize> {
        let first = *times.first()?;
        let name = |index: usize| &self.columns[index].named;
        let is_pair = |(secs, rest): &(usize, usize)| name(*secs).is_completed_by(name(*rest));
        let mut pairs = times.iter().flat_map(|&other| [(first, other), (other, first)]);
        let (secs, rest) = pairs.find(is_pair)?;
        times.retain(|&time| time != secs && time != rest);
        times.insert(0, secs);
        Some(rest)
    }

    /// Returns the time among columns without names: dates, or even steps, or seconds since 1970. A table in which all columns
    /// rise or fall together has no time: it holds load cases.
    fn nameless_clock(&self) -> Vec<usize> {
        let is_epoch = |own: &ColumnReport| {
            timeline::counts_from_1970(own.min.unwrap_or_default(), &(1e9..4e9))
        };
        let mut numbers = self.columns.iter().filter(|own| own.content == Content::Numbers);
        let are_cases =
            self.rows.len() <= FEW_ROWS && numbers.all(|own| own.is_monotone && own.moves());
        // A setpoint and what follows it rise together.
        let n_rising = self.columns.iter().filter(|own| own.rises_from_zero).count();
        let is_only_one = n_rising == 1 && self.rows.len() >= UNEVEN_CLOCK_ROWS;
        let has_names = !self.names().is_empty();
        let mut clocks = self.free(|own| {
            let is_uneven = own.number == 1 && own.rises_from_zero && is_only_one;
            let is_stamp = own.content == Content::Times || is_epoch(own);
            let is_clock = (own.is_even && own.min >= Some(0.0) || is_uneven)
                && !own.counts_rows()
                && !(has_names && own.is_whole)
                && !are_cases;
            let is_nameless = own.named.name.is_empty();
            is_nameless && own.runs_like_clock && own.is_filled && (is_stamp || is_clock)
        });
        clocks.truncate(1);
        clocks
    }

    /// Sets the roles of the columns in a log of ATI's Net F/T. The time is derived from the count of samples, because the
    /// column "time" only tells when a row was written.
    fn ati_columns(&mut self) {
        for (start, role, unit) in [
            ("RDT Sequence", ColumnRole::Time, Some("samples")),
            ("Status", ColumnRole::Status, None),
        ] {
            let index = self.head.names.iter().position(|name| name.starts_with(start));
            if let Some(index) = index {
                self.give_with_unit(index, role, unit, Reason::Name);
            }
        }
    }

    /// Gives the columns of the sensor's pose their roles, if their names give a whole orientation.
    fn poses(&mut self) {
        let parts: Vec<Option<(PosePart, Option<&'static str>)>> =
            self.columns.iter().map(|own| pose_part(&own.named)).collect();
        let place =
            |part: &PosePart| parts.iter().position(|own| own.is_some_and(|(own, _)| own == *part));
        let is_there = |part: &PosePart| {
            place(part).is_some_and(|at| self.columns[at].content == Content::Numbers)
        };
        let is_whole = |attitude: &Attitude| attitude.parts().iter().all(is_there);
        let Some(attitude) = Attitude::ALL.into_iter().find(is_whole) else { return };
        let position = PosePart::POSITION;
        let has_position = position.iter().all(|part| place(part).is_some());
        let position = position.iter().filter(|_| has_position);
        for part in attitude.parts().iter().chain(position) {
            let Some(index) = place(part).filter(|index| self.is_free(*index)) else { continue };
            let by_name = parts[index].and_then(|(_, unit)| unit);
            let unit = by_name.filter(|_| self.columns[index].unit.is_none());
            self.give_with_unit(index, ColumnRole::Pose(*part), unit, Reason::Name);
            self.columns[index].named.kind = None;
        }
    }

    /// A single force without an axis is read as Fz, a single moment as Mz. Several are a question.
    fn unnamed_loads(&mut self) {
        if self.has(ColumnRole::is_load) {
            return;
        }
        let mut all = self.free(|own| own.content == Content::Numbers && own.is_unnamed_load());
        if all.iter().any(|index| self.columns[*index].moves()) {
            all.retain(|index| self.columns[*index].moves());
        }
        // The unit in the lines above a table belongs to its only column.
        if let (Some(unit), [index]) = (&self.head.load_unit, &self.free(ColumnReport::moves)[..])
            && all.is_empty()
        {
            self.columns[*index].unit = Some(unit.clone());
            all.push(*index);
        }
        let is_moment = |index: &usize| {
            let own = &self.columns[*index];
            own.named.is_unnamed_moment(own.unit.as_deref())
        };
        let (moments, forces): (Vec<usize>, Vec<usize>) = all.into_iter().partition(is_moment);
        for (of, axis) in [(forces, Axis::Fz), (moments, Axis::Mz)] {
            match of[..] {
                [] => {}
                [index] => {
                    let has_unit = self.columns[index].unit.is_some();
                    let why = if has_unit { Reason::Unit } else { Reason::Name };
                    self.give(index, ColumnRole::Load(axis), why);
                }
                _ => self.open(About::Load, of.into_iter().map(|index| index + 1).collect()),
            }
        }
    }

    /// Finds the gauges, and the auxiliary channels beside them.
    fn gauges(&mut self, has_named_gauges: bool) {
        let has_time = self.has(|role| role == ColumnRole::Time);
        let mut gauges = self.free(|own| {
            if has_named_gauges {
                return own.named.kind == Some(Kind::Gauge);
            }
            // Without names, a column that runs like a clock is one of another device.
            let is_clock = own.named.has_clock_word()
                || own.has_time_unit()
                || own.runs_like_clock && self.names().is_empty() && own.is_even && has_time;
            own.moves()
                && own.named.kind.is_none()
                && !own.is_unnamed_load()
                && !own.is_counter()
                && !own.is_other_quantity()
                && !is_clock
                && !own.named.is_of_stamp()
        });
        if gauges.is_empty() {
            // A signal that never changes is still a signal.
            gauges = self.free(|own| {
                own.content == Content::Numbers
                    && own.min.is_some()
                    && own.named.kind.is_none()
                    && own.named.is_signal(own.unit.as_deref())
            });
        }
        let mut auxiliary = self.free(|own| {
            let may_be = !has_named_gauges || own.named.kind.is_none();
            may_be && !own.is_unnamed_load() && own.auxiliary_unit().is_some()
        });
        // If all columns that could be gauges have names of auxiliary channels, such as temperatures, they are more likely the
        // gauges.
        if gauges.iter().all(|gauge| auxiliary.contains(gauge)) {
            auxiliary.retain(|index| !gauges.contains(index));
        }
        let limit = if gauges.is_empty() { 0 } else { AUXILIARY_LIMIT };
        for index in auxiliary.into_iter().take(limit) {
            let unit = self.columns[index].auxiliary_unit().filter(|unit| !unit.is_empty());
            gauges.retain(|own| *own != index);
            self.give_with_unit(index, ColumnRole::Auxiliary, unit.as_deref(), Reason::Name);
        }
        let (limit, why) = if has_named_gauges {
            (usize::MAX, Reason::Name)
        } else {
            (GAUGE_LIMIT, Reason::Moves)
        };
        for index in gauges.into_iter().take(limit) {
            self.give(index, ColumnRole::Gauge, why);
        }
    }

    /// Notes which columns are ignored, whether it is unclear if day or month comes first in the dates, and which numbers are
    /// read as missing values.
    fn note(&mut self) {
        let n_names = self.names().len();
        let mut ignored = self.free(|own| own.named.kind != Some(Kind::Time));
        ignored.retain(|index| *index < n_names && !self.written_name(*index).is_empty());
        let names: Vec<String> = ignored.iter().map(|index| self.written_name(*index)).collect();
        self.notes.extend((!names.is_empty()).then_some(Cause::IgnoredColumns { names }));
        let days = self.with_role(|role| matches!(role, ColumnRole::Time | ColumnRole::Date));
        let order = { days }.find_map(|own| {
            let (form, other) = date_orders(self.rows, own.number - 1)?;
            let column = NamedColumn::new(own.number - 1, self.written_name(own.number - 1));
            let (order, other) = (form.name(), other.name());
            Some(Cause::AssumedDateOrder { column, order, other })
        });
        let marks = self.with_role(|role| role != ColumnRole::Ignore).filter_map(|own| {
            Some(format!("{} ({})", self.written_name(own.number - 1), own.missing?))
        });
        let columns: Vec<String> = marks.collect();
        self.notes.extend(order);
        self.notes.extend((!columns.is_empty()).then_some(Cause::MissingMarks { columns }));
    }

    /// Returns the loads that have neither a unit nor a device that gives it.
    fn loads_without_unit(&self) -> impl Iterator<Item = &ColumnReport> {
        let is_ati = self.head.ati.is_some();
        let loads = self.with_role(ColumnRole::is_load);
        loads.filter(move |own| !is_ati && own.unit.as_deref().is_none_or(str::is_empty))
    }

    fn open(&mut self, about: About, columns: Vec<usize>) {
        self.questions.push(Question { about, columns });
    }

    /// Asks what changes a result and cannot be seen.
    fn ask(&mut self) {
        let is_doubtful = |own: &&ColumnReport| {
            let largest = own.min.unwrap_or(0.0).abs().max(own.max.unwrap_or(0.0).abs());
            let is_moment = matches!(own.is, ColumnRole::Load(axis) if !axis.is_force());
            let limit = if is_moment { LARGEST_MOMENT } else { LARGEST_FORCE };
            let may_be_counts =
                own.is_whole && own.n_different > MANY_VALUES && largest >= LEAST_COUNTS;
            let has_remark = own.named.name.ends_with(')');
            largest > limit || may_be_counts || own.named.is_mass() || has_remark
        };
        let numbers = |of: &mut dyn Iterator<Item = &ColumnReport>| -> Vec<usize> {
            of.map(|own| own.number).collect()
        };
        let doubtful = numbers(&mut self.loads_without_unit().filter(is_doubtful));
        let gauges = self.with_role(|role| role == ColumnRole::Gauge);
        let by_values = numbers(&mut gauges.filter(|own| own.why == Reason::Moves));
        let clocks = self.with_role(|role| role == ColumnRole::Channel);
        let clocks = numbers(&mut clocks.filter(|own| own.runs_like_clock && own.is_even));
        let is_asked = self.questions.iter().any(|question| question.about == About::Load);
        if !doubtful.is_empty() {
            self.open(About::LoadUnit, doubtful);
        }
        if by_values.len() > 1 && !self.has(ColumnRole::is_load) && !is_asked {
            self.open(About::Load, by_values);
        }
        if !clocks.is_empty() && self.names().is_empty() {
            self.open(About::ReferenceClock, clocks);
        }
    }

    /// Asks whether the rows belong to several sensors, if a column with a suitable name has few different values.
    fn sensors(&mut self) {
        const MOST_SENSORS: usize = 8;
        let is_it = |own: &ColumnReport| {
            let cells = self.rows.iter().filter_map(|row| row.get(own.number - 1)?.written());
            let different: BTreeSet<&[u8]> = cells.filter(|cell| !cell.is_empty()).collect();
            is_identifier(&own.named.name)
                && own.named.kind.is_none()
                && own.content == Content::Text
                && (2..=MOST_SENSORS.min(self.rows.len() / 3)).contains(&different.len())
        };
        if let Some(&index) = self.free(is_it).first() {
            self.open(About::Sensors, vec![index + 1]);
        }
    }

    /// Returns true if each row has either gauges or loads, but not both, and both kinds of rows occur.
    fn is_turn_by_turn(&self) -> bool {
        const FEWEST_ROWS: usize = 3;
        let has = |row: &[Cell<'_>], is_it: fn(ColumnRole) -> bool| {
            let mut cells = self.with_role(is_it).filter_map(|own| row.get(own.number - 1));
            cells.any(|cell| !cell.is_blank())
        };
        let mut counts = [0; 2];
        for row in self.rows {
            match (has(row, |role| role == ColumnRole::Gauge), has(row, ColumnRole::is_load)) {
                (true, true) => return false,
                (true, false) => counts[0] += 1,
                (false, true) => counts[1] += 1,
                (false, false) => {}
            }
        }
        let has_time = self.has(|role| role == ColumnRole::Time);
        has_time && counts.iter().all(|count| *count >= FEWEST_ROWS)
    }

    /// Returns the description of the table in a column map.
    pub fn table(&self, text: TextLayout) -> TableMap {
        let header = Header::of(self.head);
        TableMap {
            shape: Shape { columns: self.head.n_columns, names: self.head.names.clone() },
            text,
            columns: self.columns.iter().filter_map(|own| self.rule(own, &header)).collect(),
            sample_rate_hz: self.rate_without_time(),
            ..TableMap::default()
        }
    }

    /// Returns the sample rate (Hz) that the lines above the table give, if no column is a time.
    fn rate_without_time(&self) -> Option<f64> {
        let has_time = self.has(|role| role == ColumnRole::Time);
        self.head.rate_hz.filter(|_| !has_time)
    }

    /// Returns the rule by which a column map gives a column its role; `None` if it has none.
    fn rule(&self, column: &ColumnReport, header: &Header<'_>) -> Option<ColumnRule> {
        let name = column.named.name.as_str();
        let is_named = !self.text.header && column.is.is_channel() && !name.is_empty();
        (column.is != ColumnRole::Ignore).then(|| ColumnRule {
            unit: column.unit.clone().filter(|unit| !unit.is_empty()),
            name: is_named.then(|| name.to_owned()),
            dropouts: column.missing.into_iter().collect(),
            ..ColumnRule::new(header.key(column.number - 1), column.is)
        })
    }

    /// Returns the column map of the file. If gauges and loads are in separate rows, the map names the same file as the file
    /// with the reference.
    fn map(&self, path: &Path, text: TextLayout) -> ColumnMap {
        let mut table = self.table(text);
        if !self.notes.contains(&Cause::TurnByTurn) {
            return ColumnMap::of_table(table);
        }
        let mut of_loads = table.clone();
        of_loads.columns.retain(|rule| !rule.is.is_channel());
        table.columns.retain(|rule| !rule.is.is_load());
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        let file = format!("{{stem}}.{ending}");
        let reference = Some(ReferenceFile { file, table: of_loads });
        ColumnMap { reference, ..ColumnMap::of_table(table) }
    }

    /// Gives the columns the roles of a column map, and returns a map in which the columns that the given one leaves out keep
    /// their proposal.
    fn completed(&mut self, map: &ColumnMap) -> Result<ColumnMap, KeyError> {
        let header = Header::of(self.head);
        let mut rules: Vec<(usize, ColumnRule)> = Vec::new();
        for rule in &map.table.columns {
            let index = self.index(&header, &rule.column)?;
            let mut rule = ColumnRule { column: header.key(index), ..rule.clone() };
            if rule.dropouts.is_empty() {
                let missing = self.columns.get(index).and_then(|own| own.missing);
                rule.dropouts.extend(missing);
            }
            rules.push((index, rule));
        }
        let given = rules.clone();
        let has_load = given.iter().any(|(_, rule)| rule.is.is_load());
        for index in 0..self.columns.len() {
            let column = &mut self.columns[index];
            if let Some((_, rule)) = given.iter().find(|(at, _)| *at == index) {
                if rule.is != column.is || rule.unit != column.unit {
                    column.take(rule, Reason::Given);
                }
                continue;
            }
            let is_taken =
                column.is.is_of_one_column() && given.iter().any(|(_, rule)| rule.is == column.is);
            // A load on another axis that the user chose replaces a load that was proposed only because it was the single one.
            let is_guess = has_load
                && column.is.is_load()
                && matches!(column.named.kind, None | Some(Kind::Gauge));
            if is_taken || is_guess {
                (column.is, column.why) = (ColumnRole::Ignore, Reason::Given);
            }
            rules.extend(self.rule(&self.columns[index], &header).map(|rule| (index, rule)));
        }
        rules.sort_by_key(|(index, _)| *index);
        let table = TableMap {
            columns: rules.into_iter().map(|(_, rule)| rule).collect(),
            sample_rate_hz: map.table.sample_rate_hz.or(self.rate_without_time()),
            stamps: map.table.stamps,
            ..self.table(self.text.clone())
        };
        let whole = ColumnMap { table, ..map.clone() };
        self.questions.retain(|own| own.is_open(&whole, &self.columns));
        Ok(whole)
    }

    /// Returns the index of the column with this name, with or without its unit, or with this number.
    fn index(&self, header: &Header<'_>, key: &ColumnKey) -> Result<usize, KeyError> {
        let found = header.index(key);
        let ColumnKey::Name(name) = key else { return found };
        let mut alike = self.columns.iter().filter(|column| column.named.name == *name);
        match (&found, alike.next(), alike.next()) {
            (Err(_), Some(column), None) => Ok(column.number - 1),
            _ => found,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::plan_and_notes;
    use super::*;
    use crate::import::error::{ReadError, TableError};

    #[test]
    fn the_first_time_is_used_and_the_others_are_reported() {
        let (plan, notes) = plan_and_notes("label,stamp,S1,time,,").unwrap();
        let roles: Vec<ColumnRole> = plan.columns.iter().map(|own| own.is).collect();
        use ColumnRole::{Gauge, Ignore, Time};
        assert_eq!(roles, [Ignore, Time, Gauge, Ignore]);
        let several = Cause::SeveralTimes { used: "stamp".into(), others: vec!["time".into()] };
        let ignored = Cause::IgnoredColumns { names: vec!["label".into()] };
        assert_eq!(notes, [several, ignored]);
    }

    /// With this number of columns, an algorithm of quadratic cost would not end.
    #[test]
    fn many_columns_are_understood_at_once() {
        let header = |name: &str| {
            let names = (0..20_000).map(|k| format!(",{name}{k}"));
            format!("t{}", names.collect::<String>())
        };
        let (plan, notes) = plan_and_notes(&format!("{},S1", header("x"))).unwrap();
        assert_eq!(plan.gauges.names, ["S1"]);
        let Cause::IgnoredColumns { names } = &notes[0] else { panic!("{notes:?}") };
        assert_eq!(names.len(), 20_000);
        let error = plan_and_notes(&header("ch")).unwrap_err();
        assert!(matches!(
            error,
            ReadError::Table { source: TableError::TooMany { count: 20_000, .. }, .. }
        ));
    }

    #[test]
    fn a_repeated_name_is_listed_by_its_number() {
        let head =
            Head { names: ["t", "x", "x", ""].map(str::to_owned).to_vec(), ..Head::default() };
        let keys = Header::of(&head);
        let keys: Vec<_> = (0..4).map(|index| keys.key(index)).collect();
        let number = ColumnKey::Number;
        assert_eq!(keys, [ColumnKey::Name("t".into()), number(2), number(3), number(4)]);
    }
}
