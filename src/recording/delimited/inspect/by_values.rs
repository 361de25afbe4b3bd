//! What columns may be where their names do not say it: a proposal for a person to look through.

use super::super::column_name::is_load_unit;
use super::super::layout::Start;
use super::super::listed;
use super::super::names::{Named, form_of_column};
use super::super::times::TimeForm;
use super::columns::{ColumnReport, Content};
use crate::recording::columns::{ColumnRole, ColumnRule, Header};

/// More are no gauges of one sensor.
const GAUGE_LIMIT: usize = 64;

/// Adds a time, and gauges, to a map that has none, and says what a person has to decide.
pub(super) fn fill_in(
    named: &mut Named,
    start: &Start,
    rows: &[Vec<&[u8]>],
    reports: &[ColumnReport],
) -> Vec<String> {
    let mut hints = Vec::new();
    let Named { table, indices, .. } = named;
    if table.text.preamble.is_some() {
        hints.push(
            "this log of ATI's Net F/T holds the reference alone: put this table under \"reference\" in the map of the file with the gauges"
                .to_owned(),
        );
        return hints;
    }
    let keys = start.header();
    let mut is_free = vec![true; reports.len()];
    indices.iter().for_each(|index| is_free[*index] = false);
    let needs_time = !table.has_role(ColumnRole::Time);
    let needs_gauges = !table.has_role(ColumnRole::Gauge);
    let rules = indices.drain(..).zip(table.columns.drain(..));
    let mut rules: Vec<(usize, ColumnRule)> = rules.collect();
    let mut add = |(index, rule): (usize, ColumnRule), is_free: &mut [bool]| {
        is_free[index] = false;
        rules.push((index, rule));
    };
    let is_clock = |report: &&ColumnReport, is_free: &[bool]| {
        report.runs_like_clock && is_free[report.number - 1]
    };
    if needs_time {
        match reports.iter().find(|report| is_clock(report, &is_free)) {
            Some(clock) => {
                for rule in times(&keys, rows, clock.number - 1) {
                    add(rule, &mut is_free);
                }
            }
            None => hints.push(
                "no column runs like a clock: say which is the time, or give \"sample_rate_hz\""
                    .to_owned(),
            ),
        }
    }
    let clocks: Vec<String> = reports
        .iter()
        .filter(|report| is_clock(report, &is_free))
        .map(|report| report.number.to_string())
        .collect();
    if !clocks.is_empty() {
        hints.push(format!(
            "other columns that run like a clock: {}; if the reference has its own clock, one of them is \"time_reference\"",
            listed(&clocks)
        ));
    }
    if needs_gauges {
        let gauges: Vec<usize> = reports
            .iter()
            .filter(|report| may_be_gauge(report) && is_free[report.number - 1])
            .map(|report| report.number - 1)
            .take(GAUGE_LIMIT)
            .collect();
        if !gauges.is_empty() {
            hints.push(
                "which columns are gauges and which the reference is not written in the file: all numbers that change are proposed as gauges; make the reference's columns \"Fx\" to \"Mz\" with their unit, and \"ignore\" the others"
                    .to_owned(),
            );
        }
        for index in gauges {
            let rule = ColumnRule::new(keys.key(index), ColumnRole::Gauge);
            add((index, rule), &mut is_free);
        }
    }
    rules.sort_by_key(|(index, _)| *index);
    (*indices, table.columns) = rules.into_iter().unzip();
    hints
}

fn may_be_gauge(report: &ColumnReport) -> bool {
    let changes = report.min < report.max;
    let is_load = report.unit.as_deref().is_some_and(is_load_unit);
    report.content == Content::Numbers && changes && !report.runs_like_clock && !is_load
}

/// The rules that make column `index` the time, and a date beside a time of day part of it.
fn times(keys: &Header<'_>, rows: &[Vec<&[u8]>], index: usize) -> Vec<(usize, ColumnRule)> {
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
