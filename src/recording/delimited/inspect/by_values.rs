//! What columns may be where their names do not say it: a proposal for a person to look through.

use super::super::column_name::is_load_unit;
use super::super::layout::Start;
use super::super::names::{form_of_column, key};
use super::super::times::TimeForm;
use super::columns::{ColumnReport, Content};
use crate::recording::columns::{ColumnRole, ColumnRule, TableMap};

/// More are no gauges of one sensor.
const GAUGE_LIMIT: usize = 64;

/// Adds a time, and gauges, to a map that has none, and says what a person has to decide.
pub(super) fn fill_in(
    table: &mut TableMap,
    start: &Start,
    rows: &[Vec<&[u8]>],
    reports: &[ColumnReport],
) -> Vec<String> {
    let mut hints = Vec::new();
    if table.text.preamble.is_some() {
        hints.push(
            "this log of ATI's Net F/T holds the reference alone: put this table under \"reference\" in the map of the file with the gauges"
                .to_owned(),
        );
        return hints;
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
            None => hints.push(
                "no column runs like a clock: say which is the time, or give \"sample_rate_hz\""
                    .to_owned(),
            ),
        }
    }
    let clocks: Vec<String> = reports
        .iter()
        .filter(|report| report.runs_like_clock && is_free(table, report))
        .map(|report| report.number.to_string())
        .collect();
    if !clocks.is_empty() {
        hints.push(format!(
            "other columns that run like a clock: {}; if the reference has its own clock, one of them is \"time_reference\"",
            clocks.join(", ")
        ));
    }
    if !table.has_role(ColumnRole::Gauge) {
        let mut gauges: Vec<ColumnRule> = reports
            .iter()
            .filter(|report| may_be_gauge(report) && is_free(table, report))
            .map(|report| ColumnRule::new(key(start, report.number - 1), ColumnRole::Gauge))
            .collect();
        gauges.truncate(GAUGE_LIMIT);
        if !gauges.is_empty() {
            hints.push(
                "which columns are gauges and which the reference is not written in the file: all numbers that change are proposed as gauges; make the reference's columns \"Fx\" to \"Mz\" with their unit, and \"ignore\" the others"
                    .to_owned(),
            );
        }
        table.columns.append(&mut gauges);
    }
    table.columns.sort_by_key(|rule| {
        let is_it = |report: &&ColumnReport| key(start, report.number - 1) == rule.column;
        reports.iter().find(is_it).map(|report| report.number)
    });
    hints
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
