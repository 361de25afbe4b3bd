//! The one rule by which the columns of a table get their roles: from name, unit and values together. Every reader and every face
//! of the program takes its proposal from here.
//!
//! Guarantees: a table of numbers always gets a proposal by which it can be read. What the columns do not show and what changes
//! a result is a [`Question`] with its shortest answer.

use std::path::Path;

use super::{
    column_report::{ColumnReport, Content, Reason, date_orders, described},
    map::{
        Attitude, ColumnKey, ColumnMap, ColumnRole, ColumnRule, Header, PosePart, ReferenceFile,
        Shape, TableMap,
    },
    named_column::NamedColumn,
    plan::{AUXILIARY_LIMIT, CHANNEL_LIMIT, GAUGE_LIMIT},
    pose_names::pose_part,
    question::Question,
    warning::Cause,
};
use crate::{
    formats::{
        Cell, Opened, Sample,
        column_name::Kind,
        text::{Head, Preamble, TextLayout, times::TimeForm},
    },
    recording::{Axis, units::TimeUnit},
};

/// Number of values from which a column of whole numbers may be a load in counts.
const MANY_VALUES: usize = 12;
/// Magnitude from which a load of whole numbers without a unit may be in counts.
const LEAST_COUNTS: f64 = 1e3;
/// Largest plausible force (N) and moment (N·m) without a unit.
const LARGEST_FORCE: f64 = 1e5;
const LARGEST_MOMENT: f64 = 1e4;
/// Number of rows up to which a table without names, all of whose columns rise or fall, is taken for a table of load cases.
const FEW_ROWS: usize = 60;

/// Roles of the columns of one table, with what was assumed and what is still open.
#[derive(Debug)]
pub struct Proposal {
    pub columns: Vec<ColumnReport>,
    /// Index and rule of each column that has a role.
    pub rules: Vec<(usize, ColumnRule)>,
    pub notes: Vec<Cause>,
    pub questions: Vec<Question>,
    /// Loads that have no unit and are read in N or N·m.
    pub without_unit: Vec<String>,
    /// True if the names alone give the time, the gauges and the loads.
    pub is_by_names: bool,
    /// True if each row holds either gauges or loads.
    is_turn_by_turn: bool,
}

impl Proposal {
    pub fn table(&self, text: &TextLayout, head: &Head) -> TableMap {
        TableMap {
            shape: Shape { columns: head.n_columns, names: head.names.clone() },
            text: text.clone(),
            columns: self.rules.iter().map(|(_, rule)| rule.clone()).collect(),
            ..TableMap::default()
        }
    }

    /// Returns the column map of the file. If gauges and loads are in separate rows, the map names the same file as the file
    /// with the reference.
    pub fn map(&self, text: &TextLayout, head: &Head, path: &Path) -> ColumnMap {
        let mut table = self.table(text, head);
        if !self.is_turn_by_turn {
            return ColumnMap::of_table(table);
        }
        let mut of_loads = table.clone();
        of_loads.columns.retain(|rule| !rule.is.is_channel());
        table.columns.retain(|rule| !rule.is.is_load());
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        ColumnMap {
            table,
            reference: Some(ReferenceFile { file: format!("{{stem}}.{ending}"), table: of_loads }),
            ..ColumnMap::default()
        }
    }

    /// Returns a column map in which the columns that `map` leaves out keep their proposal. `text` is the layout by which the
    /// columns were found.
    pub fn completed(
        &self,
        map: &ColumnMap,
        text: &TextLayout,
        head: &Head,
    ) -> Result<ColumnMap, super::map::KeyError> {
        let header = Header::of(head);
        let mut given: Vec<(usize, ColumnRule)> = Vec::new();
        for rule in &map.table.columns {
            let index = self.index(&header, &rule.column)?;
            let mut rule = ColumnRule { column: header.key(index), ..rule.clone() };
            if rule.dropouts.is_empty() {
                rule.dropouts =
                    self.columns.get(index).and_then(|own| own.missing).into_iter().collect();
            }
            given.push((index, rule));
        }
        let is_taken = |index: usize, role: ColumnRole| {
            let is_same = |rule: &ColumnRule| role.is_of_one_column() && rule.is == role;
            given.iter().any(|(taken, rule)| *taken == index || is_same(rule))
        };
        // A load on another axis that the user chose replaces a load that was proposed only because it was the single one.
        let has_load = given.iter().any(|(_, rule)| rule.is.is_load());
        let is_guess = |index: usize| {
            has_load
                && matches!(self.columns[index].named.kind, None | Some(Kind::Gauge))
                && self.rules.iter().any(|(at, rule)| *at == index && rule.is.is_load())
        };
        let kept = self.rules.iter().filter(|(index, rule)| !is_taken(*index, rule.is));
        let mut rules: Vec<(usize, ColumnRule)> =
            kept.filter(|(index, _)| !is_guess(*index)).cloned().collect();
        rules.extend(given);
        rules.sort_by_key(|(index, _)| *index);
        let table = TableMap {
            columns: rules.into_iter().map(|(_, rule)| rule).collect(),
            sample_rate_hz: map.table.sample_rate_hz,
            stamps: map.table.stamps,
            ..self.table(text, head)
        };
        Ok(ColumnMap { table, ..map.clone() })
    }

    /// Returns the index of the column with this name, with or without its unit, or with this number.
    fn index(&self, header: &Header<'_>, key: &ColumnKey) -> Result<usize, super::map::KeyError> {
        let found = header.index(key);
        let ColumnKey::Name(name) = key else { return found };
        let mut alike = self.columns.iter().filter(|column| column.named.name == *name);
        match (&found, alike.next(), alike.next()) {
            (Err(_), Some(column), None) => Ok(column.number - 1),
            _ => found,
        }
    }
}

/// Proposes the roles of the columns of a table.
pub fn propose(opened: &Opened, text: &TextLayout, head: &Head) -> Proposal {
    let sample = opened.sample(text, head);
    of_sample(text, head, &sample)
}

/// Proposes the roles of the columns of a table from some of its rows.
pub fn of_sample(text: &TextLayout, head: &Head, sample: &Sample<'_>) -> Proposal {
    let columns = described(text, head, sample);
    let n = columns.len();
    let mut making = Making {
        text,
        head,
        rows: &sample.rows,
        keys: Header::of(head),
        roles: vec![None; n],
        columns,
        notes: Vec::new(),
        questions: Vec::new(),
    };
    making.propose()
}

struct Making<'a> {
    text: &'a TextLayout,
    head: &'a Head,
    rows: &'a [Vec<Cell<'a>>],
    keys: Header<'a>,
    columns: Vec<ColumnReport>,
    roles: Vec<Option<(ColumnRule, Reason)>>,
    notes: Vec<Cause>,
    questions: Vec<Question>,
}

impl Making<'_> {
    fn propose(&mut self) -> Proposal {
        if self.text.preamble.is_none() && self.text.skip_rows > 0 {
            self.notes.push(Cause::SkippedPreamble { n_lines: self.text.skip_rows });
        }
        for column in &mut self.columns {
            let unit = column.unit.as_deref();
            column.named.kind = column.named.kind.and_then(|kind| kind.with_unit(unit));
            if column.unit.is_none() && column.named.kind.is_none() {
                column.unit = column.named.unit_behind_name();
            }
        }
        let others = self.choose_reference();
        self.times();
        if self.text.preamble == Some(Preamble::AtiNetFt) {
            self.ati_columns();
        }
        self.poses();
        self.named_loads(&others);
        self.group();
        let has_named_gauges = self.columns.iter().any(|own| own.named.kind == Some(Kind::Gauge));
        let is_by_names = has_named_gauges && self.has(|role| role == ColumnRole::Time);
        self.unnamed_loads(&others);
        self.gauges(has_named_gauges, &others);
        self.channels();
        self.note_ignored();
        self.note_date_order();
        self.note_missing();
        self.ask();
        let is_turn_by_turn = self.is_turn_by_turn();
        if is_turn_by_turn {
            self.notes.push(Cause::TurnByTurn);
        }
        let without_unit = self.loads_without_unit().map(|column| column.name.clone()).collect();
        let mut rules = Vec::new();
        for (index, role) in self.roles.iter().enumerate() {
            if let Some((rule, why)) = role {
                self.columns[index].take(rule, *why);
                rules.push((index, rule.clone()));
            }
        }
        Proposal {
            columns: std::mem::take(&mut self.columns),
            rules,
            notes: std::mem::take(&mut self.notes),
            questions: std::mem::take(&mut self.questions),
            without_unit,
            is_by_names,
            is_turn_by_turn,
        }
    }

    fn give(&mut self, index: usize, is: ColumnRole, why: Reason) {
        let column = &self.columns[index];
        let is_named = !self.text.header && is.is_channel() && !column.named.name.is_empty();
        let rule = ColumnRule {
            unit: column.unit.clone().filter(|unit| !unit.is_empty()),
            name: is_named.then(|| column.named.name.clone()),
            dropouts: column.missing.into_iter().collect(),
            ..ColumnRule::new(self.keys.key(index), is)
        };
        self.roles[index] = Some((rule, why));
    }

    fn give_with_unit(&mut self, index: usize, is: ColumnRole, unit: Option<&str>, why: Reason) {
        self.give(index, is, why);
        if let (Some((rule, _)), Some(unit)) = (&mut self.roles[index], unit) {
            rule.unit = Some(unit.to_owned());
        }
    }

    fn is_free(&self, index: usize) -> bool {
        self.roles[index].is_none()
    }

    fn role(&self, index: usize) -> Option<ColumnRole> {
        self.roles[index].as_ref().map(|(rule, _)| rule.is)
    }

    /// Returns the indices of the columns with a role for which `is_it` returns true.
    fn with_role(&self, is_it: impl Fn(ColumnRole) -> bool) -> impl Iterator<Item = usize> {
        (0..self.roles.len()).filter(move |index| self.role(*index).is_some_and(&is_it))
    }

    fn has(&self, is_it: impl Fn(ColumnRole) -> bool) -> bool {
        self.with_role(is_it).next().is_some()
    }

    fn free(&self) -> impl Iterator<Item = &ColumnReport> {
        self.columns.iter().filter(|column| self.is_free(column.number - 1))
    }

    /// Returns the indices of the columns without a role for which `is_it` returns true.
    fn indices(&self, is_it: impl Fn(&ColumnReport) -> bool) -> Vec<usize> {
        self.free().filter(|column| is_it(column)).map(|column| column.number - 1).collect()
    }

    fn names(&self, indices: &[usize]) -> Vec<String> {
        indices.iter().map(|index| self.written_name(*index)).collect()
    }

    fn written_name(&self, index: usize) -> String {
        let names = if self.text.header { &self.head.names } else { &self.head.names_in_comment };
        names.get(index).cloned().unwrap_or_else(|| format!("column {}", index + 1))
    }

    /// If several topics or structs of a log contain the same axis, keeps only the loads of one of them as the reference.
    /// Preferred are names such as `ref`, then the larger number of axes, then the first one in the file. Returns the other
    /// columns.
    fn choose_reference(&mut self) -> Vec<usize> {
        const REFERENCES: [&str; 7] =
            ["ati", "ref", "reference", "referenz", "truth", "gt", "ground_truth"];
        let axis_of = |column: &ColumnReport| match column.named.kind {
            Some(Kind::Load(axis)) => Some(axis),
            _ => None,
        };
        // A repeated name without a path belongs to another device, such as the second of two plates.
        let mut sources: Vec<(String, Vec<Axis>)> = Vec::new();
        let mut source_of: Vec<Option<usize>> = vec![None; self.columns.len()];
        for (index, column) in self.columns.iter().enumerate() {
            let Some(axis) = axis_of(column) else { continue };
            let source = &column.named.source;
            let free = |(own, axes): &(String, Vec<Axis>)| own == source && !axes.contains(&axis);
            let at = sources.iter().position(free).unwrap_or_else(|| {
                sources.push((source.clone(), Vec::new()));
                sources.len() - 1
            });
            sources[at].1.push(axis);
            source_of[index] = Some(at);
        }
        let is_shared =
            |axis: &Axis| sources.iter().filter(|(_, axes)| axes.contains(axis)).count() > 1;
        if !Axis::ALL.iter().any(is_shared) {
            return Vec::new();
        }
        let calls_itself_so =
            |source: &str| source.split(['/', '_']).any(|word| REFERENCES.contains(&word));
        let rank = |at: &usize| (calls_itself_so(&sources[*at].0), sources[*at].1.len());
        // The order is reversed, because `max_by_key` returns the last of equal elements, and the first is wanted.
        let used = (0..sources.len()).rev().max_by_key(rank);
        let (mine, others): (Vec<usize>, Vec<usize>) = (0..self.columns.len())
            .filter(|index| source_of[*index].is_some())
            .partition(|index| source_of[*index] == used);
        let names =
            |of: &[usize]| of.iter().map(|index| self.columns[*index].named.name.clone()).collect();
        let cause = Cause::SeveralReferences { used: names(&mine), others: names(&others) };
        self.notes.push(cause);
        for &index in &others {
            self.columns[index].named.kind = None;
        }
        others
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
            let unit = own.unit.as_deref().and_then(TimeUnit::from_name);
            let is_called = unit.is_some() || own.named.has_clock_word();
            own.named.kind.is_none()
                && own.runs_like_clock
                && own.is_filled
                && (is_called || own.content == Content::Times)
        };
        let mut why = Reason::Name;
        let mut times = self.indices(is_named);
        let fraction = self.stamp_fraction(&mut times);
        if times.is_empty() {
            times = self.indices(is_clock);
        }
        if times.is_empty() && !self.has_names() {
            why = Reason::Clock;
            times = self.nameless_clock().into_iter().collect();
        }
        let Some(&time) = times.first() else { return };
        let form = self.columns[time].form;
        self.give(time, ColumnRole::Time, why);
        if let (Some(form), Some((rule, _))) = (form, &mut self.roles[time])
            && rule.unit.is_none()
        {
            rule.unit = Some(form.name().to_owned());
        }
        if let Some(index) = fraction {
            self.give(index, ColumnRole::TimeFraction, Reason::Name);
        }
        if form == Some(TimeForm::TimeOfDay) {
            let dates = self.indices(|own| matches!(own.form, Some(TimeForm::Date(_))));
            if let Some(&date) = dates.first() {
                let form = self.columns[date].form.map(TimeForm::name);
                self.give_with_unit(date, ColumnRole::Date, form, Reason::Name);
            }
        }
        let is_ati = self.text.preamble == Some(Preamble::AtiNetFt);
        if let (Some(others), false) = (times.get(1..), is_ati)
            && !others.is_empty()
        {
            let (used, others) = (self.written_name(time), self.names(others));
            self.notes.push(Cause::SeveralTimes { used, others });
        }
    }

    fn has_names(&self) -> bool {
        self.text.header || !self.head.names_in_comment.is_empty()
    }

    /// Finds a time stamp that is divided into two columns, seconds and nanoseconds. Moves the column with the seconds to the
    /// front of `times`, and returns the column with the nanoseconds.
    fn stamp_fraction(&self, times: &mut Vec<usize>) -> Option<usize> {
        let first = *times.first()?;
        let name = |index: usize| &self.columns[index].named;
        let is_pair = |secs: usize, rest: usize| name(secs).is_completed_by(name(rest));
        let (secs, rest) = times.iter().copied().find_map(|other| match () {
            () if is_pair(first, other) => Some((first, other)),
            () if is_pair(other, first) => Some((other, first)),
            () => None,
        })?;
        times.retain(|&time| time != secs && time != rest);
        times.insert(0, secs);
        Some(rest)
    }

    /// Returns the time among columns without names: dates, or even steps, or seconds since 1970. A table in which all columns
    /// rise or fall together has no time: it holds load cases.
    fn nameless_clock(&self) -> Option<usize> {
        let is_epoch = |own: &ColumnReport| {
            let first = own.min.unwrap_or_default();
            [1.0, 1e3, 1e6, 1e9].iter().any(|unit| (1e9..4e9).contains(&(first / unit)))
        };
        let numbers = || self.columns.iter().filter(|own| own.content == Content::Numbers);
        let are_cases =
            self.rows.len() <= FEW_ROWS && numbers().all(|own| own.is_monotone && own.moves());
        let may_be = |own: &&ColumnReport| {
            let is_stamp = own.content == Content::Times || is_epoch(own);
            let is_clock = own.is_even && own.min >= Some(0.0) && !own.counts_rows() && !are_cases;
            own.runs_like_clock && own.is_filled && (is_stamp || is_clock)
        };
        self.free().find(may_be).map(|own| own.number - 1)
    }

    /// Sets the roles of the columns in a log of ATI's Net F/T. The time is derived from the count of samples, because the
    /// column "time" only tells when a row was written.
    fn ati_columns(&mut self) {
        let times: Vec<usize> = self.with_role(|role| role == ColumnRole::Time).collect();
        times.into_iter().for_each(|index| self.roles[index] = None);
        let column = |name: &str| self.head.names.iter().position(|other| other.starts_with(name));
        let [sequence, status] = ["RDT Sequence", "Status"].map(column);
        if let Some(index) = sequence {
            self.give_with_unit(index, ColumnRole::Time, Some("samples"), Reason::Name);
        }
        if let Some(index) = status {
            self.give(index, ColumnRole::Status, Reason::Name);
        }
    }

    /// Gives the columns of the sensor's pose their roles, if their names give a whole orientation.
    fn poses(&mut self) {
        let parts: Vec<Option<(PosePart, Option<&'static str>)>> =
            self.columns.iter().map(|own| pose_part(&own.named)).collect();
        let place =
            |part: PosePart| parts.iter().position(|own| own.is_some_and(|(own, _)| own == part));
        let is_whole = |attitude: &Attitude| {
            let is_there = |at: usize| self.columns[at].content == Content::Numbers;
            attitude.parts().iter().all(|part| place(*part).is_some_and(is_there))
        };
        let Some(attitude) = Attitude::ALL.into_iter().find(is_whole) else { return };
        let position = PosePart::POSITION;
        let has_position = position.iter().all(|part| place(*part).is_some());
        let position = position.iter().filter(|_| has_position);
        for &part in attitude.parts().iter().chain(position) {
            let Some(index) = place(part) else { continue };
            if self.is_free(index) {
                let own = self.columns[index].unit.clone();
                let unit = own.as_deref().or(parts[index].and_then(|(_, unit)| unit));
                self.give_with_unit(index, ColumnRole::Pose(part), unit, Reason::Name);
                self.columns[index].named.kind = None;
            }
        }
    }

    fn named_loads(&mut self, others: &[usize]) {
        for index in 0..self.columns.len() {
            if let (Some(Kind::Load(axis)), true) =
                (self.columns[index].named.kind, self.is_free(index) && !others.contains(&index))
                && !self.has(|role| role == ColumnRole::Load(axis))
            {
                self.give(index, ColumnRole::Load(axis), Reason::Name);
            }
        }
    }

    fn group(&mut self) {
        let is_group = |own: &ColumnReport| own.named.name.eq_ignore_ascii_case("group");
        if let Some(&index) = self.indices(is_group).first() {
            self.give(index, ColumnRole::Group, Reason::Name);
        }
    }

    /// A single force without an axis is read as Fz, a single moment as Mz. Several are a question.
    fn unnamed_loads(&mut self, others: &[usize]) {
        if self.has(ColumnRole::is_load) {
            return;
        }
        let is_one = |own: &ColumnReport| {
            own.content == Content::Numbers
                && !others.contains(&(own.number - 1))
                && own.named.is_unnamed_load(own.unit.as_deref())
        };
        let mut all = self.indices(is_one);
        if all.iter().any(|index| self.columns[*index].moves()) {
            all.retain(|index| self.columns[*index].moves());
        }
        let is_moment = |index: &usize| {
            let own = &self.columns[*index];
            own.named.is_unnamed_moment(own.unit.as_deref())
        };
        let (moments, forces): (Vec<usize>, Vec<usize>) = all.iter().copied().partition(is_moment);
        for (of, axis) in [(forces, Axis::Fz), (moments, Axis::Mz)] {
            match of[..] {
                [] => {}
                [index] => {
                    let has_unit = self.columns[index].unit.is_some();
                    let why = if has_unit { Reason::Unit } else { Reason::Name };
                    self.give(index, ColumnRole::Load(axis), why);
                }
                _ => {
                    let columns = of.iter().map(|index| index + 1).collect();
                    self.questions.push(Question::LoadAxis(columns));
                }
            }
        }
    }

    fn gauges(&mut self, has_named_gauges: bool, others: &[usize]) {
        let asked: Vec<usize> = self
            .questions
            .iter()
            .filter_map(|question| match question {
                Question::LoadAxis(columns) => Some(columns.iter().map(|number| number - 1)),
                _ => None,
            })
            .flatten()
            .collect();
        let may_be = |own: &ColumnReport| {
            let index = own.number - 1;
            !others.contains(&index)
                && !asked.contains(&index)
                && !own.named.is_unnamed_load(own.unit.as_deref())
        };
        let mut gauges = if has_named_gauges {
            self.indices(|own| own.named.kind == Some(Kind::Gauge))
        } else {
            self.indices(|own| {
                may_be(own)
                    && own.moves()
                    && own.named.kind.is_none()
                    && !own.is_counter()
                    && !own.named.is_other_quantity(own.unit.as_deref())
                    && !(own.named.has_clock_word() && own.runs_like_clock)
                    && !own.named.is_of_stamp()
                    && !self.is_nameless_clock(own)
            })
        };
        if gauges.is_empty() {
            // A signal that never changes is still a signal.
            gauges = self.indices(|own| {
                own.content == Content::Numbers
                    && own.min.is_some()
                    && own.named.kind.is_none()
                    && own.named.is_signal(own.unit.as_deref())
            });
        }
        let why = if has_named_gauges { Reason::Name } else { Reason::Moves };
        // Columns with names of auxiliary channels, and the units that unit or name give.
        let mut auxiliary: Vec<(usize, String)> = self
            .free()
            .filter(|own| may_be(own) && (!has_named_gauges || own.named.kind.is_none()))
            .filter_map(|own| {
                Some((own.number - 1, own.named.auxiliary_unit(own.unit.as_deref())?))
            })
            .collect();
        // If all columns that could be gauges have names of auxiliary channels, such as temperatures, they are more likely the
        // gauges.
        if gauges.iter().all(|gauge| auxiliary.iter().any(|(index, _)| index == gauge)) {
            auxiliary.retain(|(index, _)| !gauges.contains(index));
        }
        let mut seen: Vec<String> = Vec::new();
        for (index, unit) in auxiliary {
            let name = self.columns[index].named.name.clone();
            let is_nameless = name.is_empty();
            if seen.len() == AUXILIARY_LIMIT
                || gauges.is_empty()
                || !is_nameless && seen.contains(&name)
            {
                continue;
            }
            gauges.retain(|own| *own != index);
            self.give(index, ColumnRole::Auxiliary, Reason::Name);
            if let Some((rule, _)) = &mut self.roles[index] {
                rule.unit = Some(unit).filter(|unit| !unit.is_empty());
            }
            seen.push(name);
        }
        let limit = if has_named_gauges { usize::MAX } else { GAUGE_LIMIT };
        for index in gauges.into_iter().take(limit) {
            self.give(index, ColumnRole::Gauge, why);
        }
    }

    /// Returns true for a column without a name that runs like a clock although another column is the time.
    fn is_nameless_clock(&self, own: &ColumnReport) -> bool {
        !self.has_names()
            && own.runs_like_clock
            && own.is_even
            && self.has(|role| role == ColumnRole::Time)
    }

    /// Numbers that no calibration uses are only shown.
    fn channels(&mut self) {
        let others = self.indices(ColumnReport::moves);
        for index in others.into_iter().take(CHANNEL_LIMIT) {
            let own = &self.columns[index];
            let why = if own.is_counter() { Reason::Counter } else { Reason::Shown };
            self.give(index, ColumnRole::Channel, why);
        }
    }

    fn note_ignored(&mut self) {
        let n_names =
            if self.text.header { self.head.names.len() } else { self.head.names_in_comment.len() };
        let ignored = (0..n_names.min(self.columns.len())).filter(|index| {
            let named = &self.columns[*index].named;
            self.is_free(*index)
                && !self.written_name(*index).is_empty()
                && named.kind != Some(Kind::Time)
        });
        let ignored: Vec<usize> = ignored.collect();
        if !ignored.is_empty() {
            self.notes.push(Cause::IgnoredColumns { names: self.names(&ignored) });
        }
    }

    /// Notes if it is unclear whether day or month comes first in the dates.
    fn note_date_order(&mut self) {
        let days = self.with_role(|role| matches!(role, ColumnRole::Time | ColumnRole::Date));
        let found = days.into_iter().find_map(|index| {
            let (form, other) = date_orders(self.rows, index)?;
            Some(Cause::AssumedDateOrder {
                column: NamedColumn::new(index, self.written_name(index)),
                order: form.name(),
                other: other.name(),
            })
        });
        self.notes.extend(found);
    }

    /// Notes the numbers that are read as missing values.
    fn note_missing(&mut self) {
        let marks = self.columns.iter().filter(|own| !self.is_free(own.number - 1));
        let marks = marks.filter_map(|own| {
            Some(format!("{} ({})", self.written_name(own.number - 1), own.missing?))
        });
        let columns: Vec<String> = marks.collect();
        if !columns.is_empty() {
            self.notes.push(Cause::MissingMarks { columns });
        }
    }

    /// Returns the loads that have neither a unit nor a device that gives it.
    fn loads_without_unit(&self) -> impl Iterator<Item = &ColumnReport> {
        let is_ati = self.head.ati.is_some();
        self.columns.iter().filter(move |own| {
            let rule = self.roles[own.number - 1].as_ref().map(|(rule, _)| rule);
            !is_ati && rule.is_some_and(|rule| rule.is.is_load() && rule.unit.is_none())
        })
    }

    /// Asks what changes a result and cannot be seen.
    fn ask(&mut self) {
        let is_doubtful = |own: &&ColumnReport| {
            let largest = own.min.unwrap_or(0.0).abs().max(own.max.unwrap_or(0.0).abs());
            let role = self.role(own.number - 1);
            let is_moment = matches!(role, Some(ColumnRole::Load(axis)) if !axis.is_force());
            let limit = if is_moment { LARGEST_MOMENT } else { LARGEST_FORCE };
            let may_be_counts =
                own.is_whole && own.n_different > MANY_VALUES && largest >= LEAST_COUNTS;
            largest > limit || may_be_counts || own.named.is_mass()
        };
        let doubtful: Vec<usize> =
            self.loads_without_unit().filter(is_doubtful).map(|own| own.number).collect();
        if !doubtful.is_empty() {
            self.questions.push(Question::LoadUnit(doubtful));
        }
        let is_asked = self.questions.iter().any(|own| matches!(own, Question::LoadAxis(_)));
        if !self.has(ColumnRole::is_load) && !is_asked {
            let moves = |index: &usize| matches!(self.roles[*index], Some((_, Reason::Moves)));
            let gauges = self.with_role(|role| role == ColumnRole::Gauge);
            let by_values: Vec<usize> = gauges.filter(moves).map(|index| index + 1).collect();
            if by_values.len() > 1 {
                self.questions.push(Question::Load(by_values));
            }
        }
        let clocks: Vec<usize> = self
            .columns
            .iter()
            .filter(|own| !self.has_names() && own.runs_like_clock && own.is_even)
            .filter(|own| self.role(own.number - 1) == Some(ColumnRole::Channel))
            .map(|own| own.number)
            .collect();
        if !clocks.is_empty() {
            self.questions.push(Question::ReferenceClock(clocks));
        }
    }

    /// Returns true if each row has either gauges or loads, but not both, and both kinds of rows occur.
    fn is_turn_by_turn(&self) -> bool {
        const FEWEST_ROWS: usize = 3;
        let gauges: Vec<usize> = self.with_role(|role| role == ColumnRole::Gauge).collect();
        let loads: Vec<usize> = self.with_role(ColumnRole::is_load).collect();
        let has = |row: &Vec<Cell<'_>>, columns: &[usize]| {
            let mut cells = columns.iter().filter_map(|index| row.get(*index));
            cells.any(|cell| !cell.is_blank())
        };
        let mut counts = [0; 2];
        for row in self.rows {
            match (has(row, &gauges), has(row, &loads)) {
                (true, true) => return false,
                (true, false) => counts[0] += 1,
                (false, true) => counts[1] += 1,
                (false, false) => {}
            }
        }
        let has_time = self.has(|role| role == ColumnRole::Time);
        has_time && counts.iter().all(|count| *count >= FEWEST_ROWS)
    }
}

#[cfg(test)]
mod tests {
    use super::super::plan::Use;
    use super::super::tests::plan_and_notes;
    use super::*;
    use crate::import::error::{ReadError, TableError};

    #[test]
    fn the_first_time_is_used_and_the_others_are_reported() {
        let (plan, notes) = plan_and_notes("label,stamp,S1,time,,").unwrap();
        let gauge = Use::Gauge { factor: 1.0 };
        assert_eq!(plan.uses, [Use::Ignored, Use::Time, gauge, Use::Ignored]);
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
