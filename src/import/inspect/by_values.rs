//! Proposes roles of columns (time, gauge and so on) from the values in the columns, if the names of the columns do not give
//! the roles. The user reviews the proposal.

use super::super::names::{Guess, form_of_column};
use super::super::plan::{AUXILIARY_LIMIT, GAUGE_LIMIT};
use super::question::Question;
use crate::{
    formats::{
        Cell,
        column_name::{ColumnName, is_clock_name, is_load_unit},
        text::{Head, times::TimeForm},
    },
    import::{
        column_report::{ColumnReport, Content},
        map::{ColumnRole, ColumnRule, Header},
    },
};

/// Adds the roles of the time and of the gauges to a proposed column map, if the names of the columns gave none. Returns the
/// questions about the map that the user has to decide.
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
            let is_load = unnamed_loads.contains(&report.number)
                || report.unit.as_deref().is_some_and(is_load_unit);
            let is_time = report.runs_like_clock
                || head.names.get(at).is_some_and(|name| is_clock_name(name));
            let is_live = report.content == Content::Numbers && report.min < report.max;
            is_live && guess.is_free(at) && !is_load && !is_time
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

/// Divides columns that could be gauges into gauges and auxiliary channels, by their names. Returns the gauge columns, and
/// the rules of all these columns.
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
    // If all these columns have names of auxiliary channels, such as temperatures, they are more likely the gauges.
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

/// Returns the rule that gives this column the role of the time. If the column holds times of day and the column before holds
/// dates, also returns the rule that gives that column the role of the date.
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
