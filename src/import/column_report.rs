//! Describes the content of each column of a file, for the window in which the user chooses the roles of the columns.

use serde::Serialize;

use super::names::form_of_column;
use super::rows::is_overload;
use crate::{
    formats::{Cell, Opened, Sample, text::Head},
    import::map::{ColumnRole, ColumnRule, Header, TableMap},
};

const SHOWN_VALUES: usize = 3;
/// Minimum share (%) of rows in which the values increase, for a column to be taken for a time.
const CLOCK_STEPS_PERCENT: usize = 60;
/// Maximum share (%) of rows in which the values decrease, for a column to be taken for a time. Between two recordings of a
/// file, the time may go back.
const RESTARTS_PERCENT: usize = 1;
/// Minimum number of rows from which a time column is recognised.
const FEWEST_CLOCK_ROWS: usize = 3;

/// Properties of a column, from rows at the start and rows spread over the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnReport {
    /// Number of the column, counted from 1.
    pub number: usize,
    /// Cell of the header as written in the file, by which a column map names the column. Empty if the file has no header.
    pub header: String,
    /// Name of the column in the header, without a unit in brackets. Empty if the file has no header.
    pub name: String,
    /// Unit of the column, from the column map, the header or the row of units. `None` if none of them gives a unit.
    pub unit: Option<String>,
    pub content: Content,
    pub first: Vec<String>,
    /// Numbers at evenly spaced rows, for a small plot of the column.
    #[serde(skip)]
    pub outline: Vec<f32>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    /// True if the numbers or dates increase in most rows and hardly ever decrease, like a time.
    pub runs_like_clock: bool,
    pub is: ColumnRole,
}

impl ColumnReport {
    /// Returns true if the column may be a count of rows, poses or repetitions: its numbers are whole and increase by 0 or 1
    /// from row to row.
    pub(super) fn counts_rows(&self) -> bool {
        let first: Vec<f64> = self.first.iter().filter_map(|cell| cell.parse().ok()).collect();
        let is_step = |pair: &[f64]| pair[1] - pair[0] == 1.0 || pair[1] == pair[0];
        first.len() > 1
            && first[0].abs() <= 1.0
            && first.iter().all(|number| number.fract() == 0.0)
            && first.windows(2).all(is_step)
    }

    pub(super) fn cells_fit_role(&self) -> bool {
        match self.is {
            ColumnRole::Ignore | ColumnRole::Group | ColumnRole::Status | ColumnRole::Mount => true,
            ColumnRole::Date => self.content == Content::Times,
            ColumnRole::Time => self.runs_like_clock,
            // If the gauges are sampled faster than the reference, the time of the reference repeats in most rows, so it need
            // not increase in most rows.
            ColumnRole::TimeReference => {
                matches!(self.content, Content::Numbers | Content::Times)
            }
            ColumnRole::TimeFraction
            | ColumnRole::Gauge
            | ColumnRole::Auxiliary
            | ColumnRole::Load(_)
            | ColumnRole::Pose(_) => self.content == Content::Numbers,
        }
    }
}

/// Kind of content that most cells of a column have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, strum::IntoStaticStr)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum Content {
    Numbers,
    Times,
    Text,
    Nothing,
}

impl Content {
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Maximum number of values in the small plot of a column.
const OUTLINE_VALUES: usize = 90;

pub(super) fn reports(table: &TableMap, head: &Head, sample: &Sample<'_>) -> Vec<ColumnReport> {
    let rows = &sample.rows;
    let n_columns = rows.iter().map(Vec::len).max().unwrap_or(0).max(head.n_columns);
    let header = Header::of(head);
    let mut rules: Vec<Option<&ColumnRule>> = vec![None; n_columns];
    for rule in &table.columns {
        if let Some(slot) = header.index(&rule.column).ok().and_then(|index| rules.get_mut(index)) {
            slot.get_or_insert(rule);
        }
    }
    (0..n_columns)
        .map(|index| {
            let cells = || rows.iter().filter_map(move |row| row.get(index).copied());
            let filled = || cells().filter(|cell| !cell.is_empty());
            let value = |cell: Cell<'_>| {
                let value = match cell {
                    Cell::Number(value) => Some(value),
                    Cell::Since(since, value) => Some(since as f64 + value),
                    Cell::Text(text) => table.text.number(text).map(|(value, _)| value),
                };
                value.filter(|value| value.is_finite() && !is_overload(*value))
            };
            let numbers: Vec<f64> = filled().filter_map(value).collect();
            let form = form_of_column(rows, index);
            let content = if filled().next().is_none() {
                Content::Nothing
            } else if numbers.len() * 2 > filled().count() {
                Content::Numbers
            } else if form.is_some() {
                Content::Times
            } else {
                Content::Text
            };
            let time = |cell: Cell<'_>| match (content, form) {
                (Content::Times, Some(form)) => form.secs(cell.written()?),
                _ => value(cell),
            };
            let times = sample.places().map(|place| -> Vec<f64> {
                let cells = place.iter().filter_map(|row| row.get(index).copied());
                cells.filter_map(time).collect()
            });
            let rule = rules[index];
            ColumnReport {
                number: index + 1,
                header: head.names.get(index).cloned().unwrap_or_default(),
                name: head.name(index).map_or_else(String::new, |name| name.name),
                unit: rule.and_then(|rule| rule.unit.clone()).or_else(|| head.unit(index)),
                content,
                first: cells().take(SHOWN_VALUES).map(Cell::text).collect(),
                outline: (numbers.iter())
                    .step_by(numbers.len().div_ceil(OUTLINE_VALUES).max(1))
                    .map(|value| *value as f32)
                    .collect(),
                min: numbers.iter().copied().reduce(f64::min),
                max: numbers.iter().copied().reduce(f64::max),
                runs_like_clock: runs_like_clock(times),
                is: rule.map_or(ColumnRole::Ignore, |rule| rule.is),
            }
        })
        .collect()
}

/// Returns true if numbers increase from row to row in most rows and hardly ever decrease, as a time does. The rows come from
/// several places of a file.
fn runs_like_clock(places: impl Iterator<Item = Vec<f64>>) -> bool {
    let (mut n_up, mut n_back, mut n_steps) = (0, 0, 0);
    for times in places {
        for step in times.windows(2).map(|pair| pair[1] - pair[0]) {
            n_up += usize::from(step > 0.0);
            n_back += usize::from(step < 0.0);
            n_steps += 1;
        }
    }
    n_steps + 1 >= FEWEST_CLOCK_ROWS
        && n_back * 100 <= n_steps * RESTARTS_PERCENT
        && n_up * 100 >= n_steps * CLOCK_STEPS_PERCENT
}

/// Returns true if a column that the map ignores increases like a time, and does not only count rows.
pub(super) fn has_clock(opened: &Opened, table: &TableMap, head: &Head) -> bool {
    let reports = reports(table, head, &opened.sample(&table.text, head));
    let is_clock = |report: &ColumnReport| {
        report.is == ColumnRole::Ignore && report.runs_like_clock && !report.counts_rows()
    };
    reports.iter().any(is_clock)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_increase_and_hardly_ever_decrease() {
        let is_clock = |times: &[f64]| runs_like_clock([times.to_vec()].into_iter());
        assert!(is_clock(&[0.0, 0.1, 0.1, 0.2, 0.3]));
        assert!(!is_clock(&[0.0, 0.1, 0.05, 0.2, 0.3]));
        assert!(!is_clock(&[0.0, 0.0, 0.0, 0.2, 0.3]));
        assert!(!is_clock(&[0.0, 1.0]));
        let run = |n: u32| (0..n).map(f64::from);
        assert!(is_clock(&run(200).chain(run(200)).collect::<Vec<_>>()));
        let ramp = || (0..20).map(|k| run(8).map(move |step| f64::from(k) + step).collect());
        assert!(runs_like_clock(ramp()));
        let down = |place: Vec<f64>| place.into_iter().rev().collect::<Vec<f64>>();
        assert!(!runs_like_clock(ramp().chain(ramp().map(down))));
    }
}
