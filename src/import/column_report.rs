//! Description of each column of a table: its name, its unit, its values, and the role that follows from them. All faces of the
//! program show and use this description.

use serde::Serialize;

use super::{rows::is_overload, timeline};
use crate::{
    formats::{
        Cell, Sample,
        column_name::ColumnName,
        text::{Head, TextLayout, times::TimeForm},
    },
    import::map::{ColumnRole, ColumnRule, Header, TableMap},
    recording::{median, units::TimeUnit},
};

const SHOWN_VALUES: usize = 3;
/// Minimum share (%) of rows in which the values increase, for a column to be taken for a time.
const CLOCK_STEPS_PERCENT: usize = 60;
/// Maximum share (%) of rows in which the values decrease, for a column to be taken for a time. Between two recordings of a
/// file, the time may go back.
const RESTARTS_PERCENT: usize = 1;
/// Minimum number of rows from which a time column is recognised.
const FEWEST_CLOCK_ROWS: usize = 3;
/// Minimum share (%) of steps that are near the median step, for the steps of a column to count as even.
const EVEN_STEPS_PERCENT: usize = 75;
/// Minimum share (%) of rows in which a time column has a value.
const FILLED_PERCENT: usize = 50;
/// Maximum distance of the first value from zero, in median steps, for a column to rise from zero.
const STEPS_FROM_ZERO: f64 = 3.0;
/// Minimum number of rows from which a column of numbers that rise by 1 or 0.5 is taken for a counter.
const COUNTED_ROWS: usize = 60;

/// Reason for the proposed role of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// A column map gives the role.
    Given,
    /// The name, or name and unit, say what the column is.
    Name,
    /// The unit says what the column is.
    Unit,
    /// The values run like a clock.
    Clock,
    /// The values count rows, cycles or frames.
    Counter,
    /// The values change, and nothing says that the column is something else than a gauge.
    Moves,
    /// Nothing in a calibration uses the column; it is only shown.
    Shown,
    /// The column holds no numbers, or always the same one.
    #[default]
    Nothing,
}

impl Reason {
    /// Returns the reason in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Given => "the column map",
            Self::Name => "its name",
            Self::Unit => "its unit",
            Self::Clock => "values like a clock",
            Self::Counter => "values that count",
            Self::Moves => "values that change",
            Self::Shown => "no use in a fit",
            Self::Nothing => "no numbers that change",
        }
    }
}

/// Column of a table: its name, its unit, properties of its values, and the role that follows from them. The values are from
/// rows at the start and rows spread over the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the names are the documentation")]
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
    /// Number that most likely stands for a missing value, because it lies far from all other values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<f64>,
    /// True if the numbers or dates increase in most rows and hardly ever decrease, like a time.
    pub runs_like_clock: bool,
    pub is: ColumnRole,
    /// Reason for the role.
    pub why: Reason,
    /// What the name says.
    #[serde(skip)]
    pub(crate) named: ColumnName,
    /// Notation of the values, if they are dates or times of day.
    #[serde(skip)]
    pub(crate) form: Option<TimeForm>,
    /// True if most steps between the values are equal.
    #[serde(skip)]
    pub(crate) is_even: bool,
    /// True if all values are whole numbers.
    #[serde(skip)]
    pub(crate) is_whole: bool,
    /// True if the values never decrease, or never increase.
    #[serde(skip)]
    pub(crate) is_monotone: bool,
    /// True if the values never fall, and rise by 1 (or by 0.5, in half cycles) from row to row if they rise.
    #[serde(skip)]
    counts_up: bool,
    /// True if the values rise in every row, and begin within a few steps of zero.
    #[serde(skip)]
    pub(crate) rises_from_zero: bool,
    /// Number of different values in the sample.
    #[serde(skip)]
    pub(crate) n_different: usize,
    /// True if most rows have a value.
    #[serde(skip)]
    pub(crate) is_filled: bool,
}

impl ColumnReport {
    /// Returns true if the values are numbers, not all of which are the same.
    pub(crate) fn moves(&self) -> bool {
        self.content == Content::Numbers && self.min < self.max
    }

    /// Returns true if the column is a load whose axis the name does not tell.
    pub(crate) fn is_unnamed_load(&self) -> bool {
        self.named.is_unnamed_load(self.unit.as_deref())
    }

    pub(crate) fn has_time_unit(&self) -> bool {
        self.unit.as_deref().and_then(TimeUnit::from_name).is_some()
    }

    pub(crate) fn is_other_quantity(&self) -> bool {
        self.named.is_other_quantity(self.unit.as_deref())
    }

    /// Returns the unit of an auxiliary channel, empty if none is given; `None` for any other column.
    pub(crate) fn auxiliary_unit(&self) -> Option<String> {
        self.named.auxiliary_unit(self.unit.as_deref())
    }

    /// Returns true if the name or the values are those of a count of rows, cycles or frames.
    pub(crate) fn is_counter(&self) -> bool {
        let is_count = self.is_monotone && self.named.name.eq_ignore_ascii_case("count");
        self.counts_up || is_count || self.named.is_counter(self.is_whole)
    }

    /// Returns true if the column may be a count of rows, poses or repetitions: its numbers are whole and increase by 0 or 1
    /// from row to row.
    pub(crate) fn counts_rows(&self) -> bool {
        let first: Vec<f64> = self.first.iter().filter_map(|cell| cell.parse().ok()).collect();
        let is_step = |pair: &[f64]| pair[1] - pair[0] == 1.0 || pair[1] == pair[0];
        self.is_whole && first.len() > 1 && first[0].abs() <= 1.0 && first.windows(2).all(is_step)
    }

    pub(crate) fn cells_fit_role(&self) -> bool {
        match self.is {
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
            _ => true,
        }
    }
}

/// Kind of content that most cells of a column have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, strum::IntoStaticStr)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[expect(missing_docs, reason = "the names are the documentation")]
pub enum Content {
    Numbers,
    Times,
    Text,
    Nothing,
}

impl Content {
    pub(crate) fn name(self) -> &'static str {
        self.into()
    }
}

/// Maximum number of values in the small plot of a column.
const OUTLINE_VALUES: usize = 300;

/// Returns the columns of a table with the roles that a column map gives them.
pub fn reports(table: &TableMap, head: &Head, sample: &Sample<'_>) -> Vec<ColumnReport> {
    let mut columns = described(&table.text, head, sample);
    let header = Header::of(head);
    let rules = table.columns.iter().rev();
    for (index, rule) in rules.filter_map(|rule| Some((header.index(&rule.column).ok()?, rule))) {
        if let Some(column) = columns.get_mut(index) {
            column.take(rule, Reason::Given);
        }
    }
    columns
}

impl ColumnReport {
    pub(crate) fn take(&mut self, rule: &ColumnRule, why: Reason) {
        (self.is, self.why) = (rule.is, why);
        self.unit = rule.unit.clone().or(self.unit.take());
    }
}

/// Returns the columns of a table without roles.
pub fn described(text: &TextLayout, head: &Head, sample: &Sample<'_>) -> Vec<ColumnReport> {
    let rows = &sample.rows;
    let n_columns = rows.iter().map(Vec::len).max().unwrap_or(0).max(head.n_columns);
    let names = if text.header { &head.names } else { &head.names_in_comment };
    let column = |index: usize| {
        let cells = || rows.iter().filter_map(move |row| row.get(index).copied());
        let filled = || cells().filter(|cell| !cell.is_blank());
        let value = |cell: Cell<'_>| value_of(cell, text);
        let mut numbers: Vec<f64> = filled().filter_map(value).collect();
        let n_numbers = numbers.len();
        let missing = missing_mark(&numbers);
        numbers.retain(|number| Some(*number) != missing);
        let form = form_of_column(rows, index);
        let content = if filled().next().is_none() {
            Content::Nothing
        } else if n_numbers * 2 > filled().count() {
            Content::Numbers
        } else if form.is_some() {
            Content::Times
        } else {
            Content::Text
        };
        let time = |cell: Cell<'_>| match (content, form) {
            (Content::Times, Some(form)) => form.secs(cell.written()?),
            _ => value(cell).filter(|number| Some(*number) != missing),
        };
        let places = sample.places().map(|place| -> Vec<f64> {
            let cells = place.iter().filter_map(|row| row.get(index).copied());
            let mut times = cells.filter_map(time).collect::<Vec<f64>>();
            if form == Some(TimeForm::TimeOfDay) {
                timeline::count_days(&mut times);
            }
            times
        });
        let steps = Steps::of(places);
        let mut different: Vec<u64> = numbers.iter().map(|value| value.to_bits()).collect();
        different.sort_unstable();
        different.dedup();
        let is_whole = numbers.iter().all(|value| value.fract() == 0.0);
        let named = ColumnName::parse(names.get(index).map_or("", String::as_str));
        ColumnReport {
            number: index + 1,
            header: head.names.get(index).cloned().unwrap_or_default(),
            name: head.name(index).map_or_else(String::new, |name| name.name),
            unit: head.unit(index).or_else(|| named.unit.clone()),
            content,
            first: cells().take(SHOWN_VALUES).map(Cell::text).collect(),
            outline: (numbers.iter())
                .step_by(numbers.len().div_ceil(OUTLINE_VALUES).max(1))
                .map(|value| *value as f32)
                .collect(),
            min: numbers.iter().copied().reduce(f64::min),
            max: numbers.iter().copied().reduce(f64::max),
            missing,
            // Dates and times of day often repeat, because they have whole seconds.
            runs_like_clock: match content {
                Content::Times => steps.n_back * 100 <= steps.n && !steps.up.is_empty(),
                _ => steps.run_like_clock(),
            },
            is: ColumnRole::Ignore,
            why: Reason::Nothing,
            named,
            form,
            is_even: steps.are_even(),
            is_whole,
            is_monotone: steps.n_back == 0 || steps.up.is_empty(),
            // Numbers of rows in a text may be written `1.`, `2.`.
            counts_up: (numbers.len() > COUNTED_ROWS
                || filled().all(|cell| cell.written().is_some_and(|text| text.ends_with(b"."))))
                && numbers.is_sorted()
                && numbers.iter().all(|value| (2.0 * value).fract() == 0.0)
                && steps.up.iter().all(|step| [0.5, 1.0].contains(step) && *step == steps.up[0]),
            rises_from_zero: steps.up.len() == steps.n
                && numbers.first().map(|first| first.abs() / STEPS_FROM_ZERO)
                    <= median(steps.up.iter().copied()),
            n_different: different.len(),
            is_filled: filled().count() * 100 >= rows.len() * FILLED_PERCENT,
        }
    };
    (0..n_columns).map(column).collect()
}

/// Returns the number among the values of a column, in the order of the rows, that stands for a missing value: -1, ±1000000 or
/// digits 9. It repeats, and it is far outside the range of all other values. A true extreme has neighbours near it, but
/// the neighbours of a missing value are like any others.
fn missing_mark(numbers: &[f64]) -> Option<f64> {
    const FEWEST: usize = 3;
    const FEWEST_OTHERS: usize = 12;
    /// Maximum number of marks for each other value.
    const MOST_MARKS: usize = 2;
    /// Minimum distance of the mark from the range of the other values, in ranges.
    const RANGES: f64 = 2.0;
    /// Minimum value of the others if the mark is -1.
    const ABOVE_MINUS_ONE: f64 = 20.0;
    const MARKS: [f64; 13] = [
        -1.0,
        -999.0,
        999.0,
        -9999.0,
        9999.0,
        -99_999.0,
        99_999.0,
        -999_999.0,
        999_999.0,
        -9_999_999.0,
        9_999_999.0,
        -1e6,
        1e6,
    ];
    let quartile = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 4).copied()
    };
    MARKS.into_iter().find(|&mark| {
        let n_marks = numbers.iter().filter(|own| **own == mark).count();
        if n_marks < FEWEST || n_marks > MOST_MARKS * (numbers.len() - n_marks) {
            // A channel without a sensor has no other values.
            return n_marks >= FEWEST && n_marks == numbers.len() && mark != -1.0;
        }
        let mut others: Vec<f64> = numbers.iter().copied().filter(|own| *own != mark).collect();
        others.sort_by(f64::total_cmp);
        let (min, max) = (others[0], others[others.len() - 1]);
        let typical = quartile(&mut others.iter().map(|own| (own - mark).abs()).collect());
        let gap = (min - mark).max(mark - max);
        let is_far = gap >= RANGES * (max - min) || mark == -1.0 && min >= ABOVE_MINUS_ONE;
        others.dedup();
        if !is_far || others.len() < FEWEST_OTHERS {
            return false;
        }
        let pairs = numbers.windows(2).filter(|pair| (pair[0] == mark) != (pair[1] == mark));
        let mut beside: Vec<f64> = pairs.map(|pair| (pair[0] - pair[1]).abs()).collect();
        quartile(&mut beside) >= typical.map(|typical| 0.5 * typical)
    })
}

/// Returns the number in a cell.
pub fn value_of(cell: Cell<'_>, text: &TextLayout) -> Option<f64> {
    let value = match cell {
        Cell::Number(value) => Some(value),
        Cell::Since(since, value) => Some(since as f64 + value),
        Cell::Text(cell) => text.number(cell).map(|(value, _)| value),
    };
    value.filter(|value| value.is_finite() && !is_overload(*value))
}

fn written<'a>(rows: &[Vec<Cell<'a>>], index: usize) -> Option<Vec<&'a [u8]>> {
    let cells = rows.iter().filter_map(|row| row.get(index).copied());
    let filled = cells.filter(|cell| !cell.is_empty());
    filled.map(Cell::written).collect()
}

fn form_of_column(rows: &[Vec<Cell<'_>>], index: usize) -> Option<TimeForm> {
    TimeForm::of_all(written(rows, index)?.into_iter())
}

/// Returns the form of the dates of a column and another order of day and month in which they could be read.
pub fn date_orders(rows: &[Vec<Cell<'_>>], index: usize) -> Option<(TimeForm, TimeForm)> {
    let form = form_of_column(rows, index)?;
    Some((form, form.other_order(written(rows, index)?.into_iter())?))
}

/// Steps of the values of a column from row to row, at several places of a file.
#[derive(Default)]
struct Steps {
    /// Steps by which the values increase.
    up: Vec<f64>,
    n_back: usize,
    n: usize,
}

impl Steps {
    fn of(places: impl Iterator<Item = Vec<f64>>) -> Self {
        let mut steps = Self::default();
        for times in places {
            for step in times.windows(2).map(|pair| pair[1] - pair[0]) {
                steps.n_back += usize::from(step < 0.0);
                steps.n += 1;
                steps.up.extend((step > 0.0).then_some(step));
            }
        }
        steps
    }

    /// Returns true if the values increase from row to row in most rows and hardly ever decrease, as a time does.
    fn run_like_clock(&self) -> bool {
        self.n + 1 >= FEWEST_CLOCK_ROWS
            && self.n_back * 100 <= self.n * RESTARTS_PERCENT
            && self.up.len() * 100 >= self.n * CLOCK_STEPS_PERCENT
    }

    fn are_even(&self) -> bool {
        let Some(median) = median(self.up.iter().copied()) else { return false };
        let n_near = self.up.iter().filter(|step| (**step - median).abs() <= 0.5 * median).count();
        n_near * 100 >= self.up.len() * EVEN_STEPS_PERCENT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_values_are_found_and_true_extremes_are_not() {
        let wave = |k: usize| 500.0 + 400.0 * (k as f64 * 0.3).sin();
        let with = |mark: f64, every: usize| -> Vec<f64> {
            (0..200).map(|k| if k % every == 5 { mark } else { wave(k).round() }).collect()
        };
        for mark in [-1.0, -9999.0, 9999.0, -999_999.0, -1e6] {
            assert_eq!(missing_mark(&with(mark, 9)), Some(mark), "{mark}");
        }
        assert_eq!(missing_mark(&with(-1.0, 150)), None, "it hardly repeats");
        assert_eq!(missing_mark(&with(-5.0, 9)), None);
        let mostly = |n: usize| -> Vec<f64> {
            (0..400).map(|k| if k % n == 0 { wave(k).round() } else { -1.0 }).collect()
        };
        assert_eq!([missing_mark(&mostly(3)), missing_mark(&mostly(4))], [Some(-1.0), None]);
        assert_eq!(missing_mark(&with(999.0, 9)), None, "inside twice the range");
        // A signal about zero, a ramp of whole numbers, a load that returns to -1, in steps and at once, and a setpoint.
        let about_zero: Vec<f64> =
            (0..200).map(|k| (2.0 * (k as f64 * 0.3).sin()).round()).collect();
        let ramp: Vec<f64> = (0..200).map(|k| f64::from(k % 50) - 1.0).collect();
        let steps: Vec<f64> = (0..200).map(|k| f64::from(k % 20) * 50.0 - 1.0).collect();
        let back = |k: i32| if k % 40 < 20 { k % 20 } else { 20 - k % 20 };
        let both: Vec<f64> = (0..200).map(|k| f64::from(back(k)) * 50.0 - 1.0).collect();
        let setpoint: Vec<f64> = (0..200).map(|k| [-1.0, 9999.0][k / 5 % 2]).collect();
        for values in [about_zero, ramp, steps, both, setpoint] {
            assert_eq!(missing_mark(&values), None, "{values:?}");
        }
    }

    #[test]
    fn clocks_increase_and_hardly_ever_decrease() {
        let runs_like_clock =
            |places: Vec<Vec<f64>>| Steps::of(places.into_iter()).run_like_clock();
        let is_clock = |times: &[f64]| runs_like_clock(vec![times.to_vec()]);
        assert!(is_clock(&[0.0, 0.1, 0.1, 0.2, 0.3]));
        assert!(!is_clock(&[0.0, 0.1, 0.05, 0.2, 0.3]));
        assert!(!is_clock(&[0.0, 0.0, 0.0, 0.2, 0.3]));
        assert!(!is_clock(&[0.0, 1.0]));
        let run = |n: u32| (0..n).map(f64::from);
        assert!(is_clock(&run(200).chain(run(200)).collect::<Vec<_>>()));
        let ramp = || -> Vec<Vec<f64>> {
            (0..20).map(|k| run(8).map(move |step| f64::from(k) + step).collect()).collect()
        };
        assert!(runs_like_clock(ramp()));
        let down = |place: Vec<f64>| place.into_iter().rev().collect::<Vec<f64>>();
        let both = ramp().into_iter().chain(ramp().into_iter().map(down));
        assert!(!runs_like_clock(both.collect()));
    }
}
