//! What columns may be where their names do not say it: a proposal for a person to look through.

use super::super::column_name::is_load_unit;
use super::super::layout::Start;
use super::super::names::{form_of_column, key};
use super::super::times::TimeForm;
use super::columns::{ColumnReport, Content};
use super::question::Question;
use crate::recording::columns::{ColumnRole, ColumnRule, TableMap};

/// More are no gauges of one sensor.
const GAUGE_LIMIT: usize = 64;

/// Adds a time, and gauges, to a map that has none, and says what a person has to decide.
pub(super) fn fill_in(
    table: &mut TableMap,
    start: &Start,
    rows: &[Vec<&[u8]>],
    reports: &[ColumnReport],
) -> Vec<Question> {
    let mut questions = Vec::new();
    if table.text.preamble.is_some() {
        questions.push(Question::ReferenceAlone);
        return questions;
    }
    let is_free = |table: &TableMap, report: &ColumnReport| {
        let key = key(start, report.number - 1);
        table.columns.iter().all(|rule| rule.column != key)
    };
    let needs_time = !table.has_role(ColumnRole::Time);
    if needs_time {
        let clock = reports
            .iter()
            .find(|report| report.runs_like_clock && is_free(table, report));
        match clock {
            Some(clock) => add_time(table, start, rows, clock.number - 1),
            None => questions.push(Question::Time),
        }
    }
    let clocks: Vec<usize> = reports
        .iter()
        .filter(|report| report.runs_like_clock && is_free(table, report))
        .map(|report| report.number)
        .collect();
    if !clocks.is_empty() {
        questions.push(Question::ReferenceClock(clocks));
    }
    if !table.has_role(ColumnRole::Gauge) {
        let proposed: Vec<usize> = reports
            .iter()
            .filter(|report| may_be_gauge(report) && is_free(table, report))
            .map(|report| report.number)
            .take(GAUGE_LIMIT)
            .collect();
        let is_load = |rule: &ColumnRule| matches!(rule.is, ColumnRole::Load(_));
        let has_loads = table.columns.iter().any(is_load);
        let rule = |number: &usize| ColumnRule::new(key(start, number - 1), ColumnRole::Gauge);
        table.columns.extend(proposed.iter().map(rule));
        if !proposed.is_empty() {
            questions.push(Question::Gauges {
                proposed,
                has_loads,
            });
        }
    }
    table.columns.sort_by_key(|rule| {
        let is_it = |report: &&ColumnReport| key(start, report.number - 1) == rule.column;
        reports.iter().find(is_it).map(|report| report.number)
    });
    questions
}

fn may_be_gauge(report: &ColumnReport) -> bool {
    let changes = report.min < report.max;
    let is_load = report.unit.as_deref().is_some_and(is_load_unit);
    report.content == Content::Numbers && changes && !report.runs_like_clock && !is_load
}

/// Makes column `index` the time, and a date beside a time of day part of it.
fn add_time(table: &mut TableMap, start: &Start, rows: &[Vec<&[u8]>], index: usize) {
    let form = form_of_column(rows, index);
    let mut add = |index, is, form: Option<TimeForm>| {
        table.columns.push(ColumnRule {
            unit: form.map(|form| form.name().to_owned()),
            ..ColumnRule::new(key(start, index), is)
        });
    };
    add(index, ColumnRole::Time, form);
    let before = index.checked_sub(1);
    if form == Some(TimeForm::TimeOfDay)
        && let Some((date, form)) =
            before.and_then(|date| Some((date, form_of_column(rows, date)?)))
        && form != TimeForm::TimeOfDay
    {
        add(date, ColumnRole::Date, Some(form));
    }
}
