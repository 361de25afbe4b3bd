//! Proposes roles of columns from their values, if the names do not give them. The user reviews the proposal.

use super::super::names::{Guess, form_of_column};
use super::super::plan::{AUXILIARY_LIMIT, GAUGE_LIMIT};
use super::columns::{ColumnReport, Content};
use super::question::Question;
use crate::formats::Cell;
use crate::formats::column_name::{ColumnName, is_clock_name, is_load_unit};
use crate::formats::text::Head;
use crate::formats::text::times::TimeForm;
use crate::import::map::{ColumnRole, ColumnRule, Header};

/// Adds a time and gauges to a map without them, and returns the questions that the user has to decide.
pub(super) fn fill_in(
    guess: &mut Guess,
    head: &Head,
    rows: &[Vec<Cell<'_>>],
    reports: &[ColumnReport],
) -> Vec<Question> {
    let mut questions = Vec::new();
    let keys = Header::of(head);
    let unnamed_loads: Vec<usize> = guess.unnamed_loads.iter().map(|index| index + 1).collect();
    if !unnamed_loads.is_empty() {
        questions.push(Question::LoadAxis(unnamed_loads.clone()));
    }
    let needs_time = !guess.has_role(ColumnRole::Time);
    let needs_gauges = !guess.has_role(ColumnRole::Gauge);
    let has_loads = guess.rules.iter().any(|(_, rule)| rule.is.is_load());
    let may_be_load_cases = has_loads && !needs_gauges && needs_time;
    let is_clock = |guess: &Guess, report: &ColumnReport| {
        let is_counter = may_be_load_cases && report.counts_rows();
        report.runs_like_clock && guess.is_free(report.number - 1) && !is_counter
    };
    if needs_time {
        match reports.iter().find(|report| is_clock(guess, report)) {
            Some(clock) => guess.rules.extend(times(&keys, rows, clock.number - 1)),
            None => questions.push(Question::Time),
        }
    }
    let clocks = reports.iter().filter(|report| is_clock(guess, report));
    let clocks: Vec<usize> = clocks.map(|report| report.number).collect();
    if !clocks.is_empty() {
        questions.push(Question::ReferenceClock(clocks));
    }
    if needs_gauges {
        let may_be = |report: &&ColumnReport| {
            let at = report.number - 1;
            let is_load = unnamed_loads.contains(&report.number);
            let is_time = head.names.get(at).is_some_and(|name| is_clock_name(name));
            may_be_gauge(report) && guess.is_free(at) && !is_load && !is_time
        };
        let proposed = reports.iter().filter(may_be).map(|report| report.number);
        let (gauges, rules) = gauges(head, &keys, proposed.take(GAUGE_LIMIT).collect());
        guess.rules.extend(rules);
        if !gauges.is_empty() {
            questions.push(Question::Gauges { proposed: gauges, has_loads });
        }
    }
    guess.rules.sort_by_key(|(index, _)| *index);
    questions
}

/// Returns which of the proposed columns are gauges, with the rules of all: those with the name of an auxiliary channel are auxiliary.
fn gauges(
    head: &Head,
    keys: &Header<'_>,
    mut proposed: Vec<usize>,
) -> (Vec<usize>, Vec<(usize, ColumnRule)>) {
    let auxiliary = |number: &usize| {
        let unit = head.unit(number - 1);
        let name = head.names.get(number - 1)?;
        ColumnName::parse(name).auxiliary_unit(unit.as_deref())
    };
    let mut named: Vec<usize> = (proposed.iter().copied())
        .filter(|number| auxiliary(number).is_some())
        .take(AUXILIARY_LIMIT)
        .collect();
    // If all proposed columns are temperatures or voltages, they may be the gauges themselves.
    if named.len() == proposed.len() {
        named.clear();
    }
    proposed.retain(|number| !named.contains(number));
    let channels = named.iter().map(|number| {
        let rule = ColumnRule {
            unit: auxiliary(number).filter(|unit| !unit.is_empty()),
            ..ColumnRule::new(keys.key(number - 1), ColumnRole::Auxiliary)
        };
        (number - 1, rule)
    });
    let gauges = proposed
        .iter()
        .map(|number| (number - 1, ColumnRule::new(keys.key(number - 1), ColumnRole::Gauge)));
    let rules = channels.chain(gauges).collect();
    (proposed, rules)
}

fn may_be_gauge(report: &ColumnReport) -> bool {
    let changes = report.min < report.max;
    let is_load = report.unit.as_deref().is_some_and(is_load_unit);
    report.content == Content::Numbers && changes && !report.runs_like_clock && !is_load
}

/// Returns the rules that make a column the time, with the date column beside a time of day.
fn times(keys: &Header<'_>, rows: &[Vec<Cell<'_>>], index: usize) -> Vec<(usize, ColumnRule)> {
    let form = form_of_column(rows, index);
    let rule = |index, is, form: Option<TimeForm>| {
        let rule = ColumnRule {
            unit: form.map(|form| form.name().to_owned()),
            ..ColumnRule::new(keys.key(index), is)
        };
        (index, rule)
    };
    let mut rules = vec![rule(index, ColumnRole::Time, form)];
    let before = index.checked_sub(1);
    if form == Some(TimeForm::TimeOfDay)
        && let Some((date, form)) =
            before.and_then(|date| Some((date, form_of_column(rows, date)?)))
        && form != TimeForm::TimeOfDay
    {
        rules.push(rule(date, ColumnRole::Date, Some(form)));
    }
    rules
}
