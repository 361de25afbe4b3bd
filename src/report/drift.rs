//! What changed between sessions, as tables and figures.

use jiff::Timestamp;

use super::figure::{Figure, Line, Scale, color};
use super::table::{Cell, Column, Table};
use crate::evaluation::sessions::{Drift, GaugeState, Session};
use crate::evaluation::sufficiency::percent;
use crate::recording::DateSource;

/// Colours of the gauges, over and over.
const COLORS: [[u8; 3]; 5] = [
    color::BLUE,
    color::VERMILION,
    color::GREEN,
    color::PURPLE,
    color::SKY,
];
/// Of more gauges those that moved most are drawn.
const DRAWN: usize = 8;

fn with_about(name: &str, about: &str) -> Column {
    Column {
        about: about.to_owned(),
        ..Column::numbers(name)
    }
}

/// All tables that say something, in the order in which they are read.
pub fn drift_tables(of: &Drift) -> Vec<Table> {
    let tables = [refits(of), changes(of), sessions(of)];
    tables
        .into_iter()
        .filter(|table| !table.rows.is_empty())
        .collect()
}

fn refits(of: &Drift) -> Table {
    let mut columns = vec![Column::words("What is fitted again")];
    columns.extend(of.axes.iter().map(|axis| Column::load(*axis)));
    let rows = of.refits.iter().map(|own| {
        let mut row = vec![Cell::words(own.refit.label()).about(own.refit.explanation())];
        let missing = own
            .problem
            .clone()
            .unwrap_or_else(|| "too few new samples or recordings to leave any out".to_owned());
        row.extend((0..of.axes.len()).map(|axis| match &own.left_out_rmse {
            Some(errors) => Cell::digits(Some(errors[axis]), 4),
            None => Cell::missing("–", missing.clone()),
        }));
        row
    });
    let how = of
        .left_out
        .as_ref()
        .map_or_else(String::new, |how| format!(" Left out {how}."));
    Table {
        title: "Errors on the new recordings, left out".to_owned(),
        columns,
        rows: rows.collect(),
        note: format!("The old calibration: {}.{how}", of.old),
    }
}

fn changes(of: &Drift) -> Table {
    let rows = of.changes.iter().map(|own| {
        let sure = |is_sure: bool| match is_sure {
            true => "more than it scatters within a session",
            false => "no more than it scatters within a session",
        };
        let share = |share: f64, is_sure: bool| {
            let sign = if share < 0.0 { "−" } else { "+" };
            let mark = if is_sure { "" } else { " ?" };
            Cell::number(share, format!("{sign}{}{mark}", percent(share.abs())))
                .about(sure(is_sure))
        };
        vec![
            Cell::words(&own.gauge),
            Cell::digits(Some(own.zero[0]), 5),
            Cell::digits(Some(own.zero[1]), 5),
            share(own.zero_share, own.zero_is_sure),
            Cell::words(own.axis.symbol()),
            share(own.sensitivity_share, own.sensitivity_is_sure),
        ]
    });
    let columns = vec![
        Column::words("Gauge"),
        with_about(
            "zero then",
            "What the gauge shows without a load, in the first session",
        ),
        with_about("zero now", "The same in the last session"),
        with_about(
            "change of zero",
            "Of what full load on its axis makes of the gauge",
        ),
        Column {
            about: "The axis that the gauge answers to most".to_owned(),
            ..Column::words("axis")
        },
        with_about(
            "change of sensitivity",
            "Of what a unit of load on that axis adds to the gauge",
        ),
    ];
    Table {
        title: "Gauges, from the first session to the last".to_owned(),
        columns,
        rows: rows.collect(),
        note: "A question mark: the figure moved by no more than three of its standard errors, by the scatter of parts of the \
               sessions, or by less than 0.2 %."
            .to_owned(),
    }
}

fn sessions(of: &Drift) -> Table {
    let mut columns = ["Session", "began"].map(Column::words).to_vec();
    columns.push(Column::numbers("samples"));
    for axis in &of.axes {
        let symbol = axis.symbol();
        columns.push(Column {
            unit: axis.unit(),
            ..with_about(&format!("{symbol} mean error"), "Of the old calibration")
        });
        columns.push(Column {
            unit: axis.unit(),
            ..with_about(&format!("{symbol} RMSE"), "Of the old calibration")
        });
    }
    let rows = of.sessions.iter().map(|own| {
        let began = own
            .started
            .and_then(|secs| Timestamp::from_second(secs as i64).ok());
        // A clock that somebody corrected tells no time of day.
        let is_by_clock = own.dated_by == [DateSource::Clock];
        let began = match (began.filter(|_| is_by_clock), own.day) {
            (Some(began), _) => began.strftime("%Y-%m-%d %H:%M UTC").to_string(),
            (None, Some(day)) => day.to_string(),
            (None, None) => "–".to_owned(),
        };
        let from: Vec<&str> = own.dated_by.iter().map(|from| from.words()).collect();
        let from = match from.is_empty() {
            true => "nothing says when".to_owned(),
            false => from.join("; "),
        };
        let mut row = vec![Cell::words(&own.name), Cell::words(began).about(from)];
        row.push(Cell::number(
            own.n_samples as f64,
            own.n_samples.to_string(),
        ));
        for (mean, rmse) in own.mean_error.iter().zip(&own.rmse) {
            // What rounding leaves of a fit's mean error is none.
            let mean = if mean.abs() < 1e-9 * rmse { 0.0 } else { *mean };
            row.extend([mean, *rmse].map(|value| Cell::digits(Some(value), 4)));
        }
        row
    });
    Table {
        title: format!("Sessions, by {}", of.by),
        columns,
        rows: rows.collect(),
        ..Table::default()
    }
}

/// The zeros of the gauges over the sessions, then their sensitivities, as changes from the first in percent; none where there is
/// nothing to compare.
pub fn drift_figures(of: &Drift) -> Vec<Figure<'static>> {
    let told: Vec<(&Session, &Vec<GaugeState>)> = of
        .sessions
        .iter()
        .filter_map(|own| Some((own, own.gauges.as_ref()?)))
        .collect();
    if of.changes.is_empty() || told.len() < 2 {
        return Vec::new();
    }
    // Days where they are known, else the place in the row.
    let begin = |own: &Session| match own.started {
        Some(started) if own.dated_by == [DateSource::Clock] => Some(started),
        _ => Some(86_400.0 * own.day?.since_1970()),
    };
    let starts: Option<Vec<f64>> = told.iter().map(|(own, _)| begin(own)).collect();
    let (across, label): (Vec<f64>, &str) = match starts {
        Some(starts) => (
            starts
                .iter()
                .map(|start| (start - starts[0]) / 86_400.0)
                .collect(),
            "days since the first session",
        ),
        None => ((1..=told.len()).map(|at| at as f64).collect(), "session"),
    };
    let first = told[0].1;
    let figure = |title: &str,
                  up: &str,
                  share: &dyn Fn(usize, &GaugeState) -> f64,
                  size: &dyn Fn(usize) -> f64| {
        let mut chosen: Vec<usize> = (0..of.changes.len()).collect();
        chosen.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
        chosen.truncate(DRAWN);
        let lines: Vec<Line<'static>> = chosen
            .iter()
            .enumerate()
            .filter_map(|(place, at)| {
                let gauge = of
                    .gauges
                    .iter()
                    .position(|name| *name == of.changes[*at].gauge)?;
                let points = told.iter().zip(&across);
                let points: Vec<[f64; 2]> = points
                    .map(|((_, states), x)| [*x, 100.0 * share(*at, &states[gauge])])
                    .collect();
                Some(Line::new(
                    of.changes[*at].gauge.clone(),
                    COLORS[place % COLORS.len()],
                    [points],
                ))
            })
            .collect();
        let values: Vec<f64> = lines
            .iter()
            .flat_map(|line| line.pieces[0].iter().map(|[_, y]| *y))
            .collect();
        Figure {
            title: title.to_owned(),
            across: Scale::spanning(label, across.iter().copied(), 0.05),
            up: Scale::spanning(up, values, 0.1),
            lines,
            ..Figure::default()
        }
    };
    let place = |at: usize| {
        let own = &of.changes[at];
        let gauge = of
            .gauges
            .iter()
            .position(|name| *name == own.gauge)
            .unwrap_or(0);
        let axis = of
            .axes
            .iter()
            .position(|axis| *axis == own.axis)
            .unwrap_or(0);
        (&first[gauge], axis)
    };
    let zero = |at: usize, now: &GaugeState| {
        let (then, axis) = place(at);
        (now.zero - then.zero) / (then.slopes[axis] * of.full_scale[axis]).abs()
    };
    let slope = |at: usize, now: &GaugeState| {
        let (then, axis) = place(at);
        now.slopes[axis] / then.slopes[axis] - 1.0
    };
    vec![
        figure(
            "Zeros of the gauges",
            "change [% of full load]",
            &zero,
            &|at| of.changes[at].zero_share.abs(),
        ),
        figure("Sensitivities of the gauges", "change [%]", &slope, &|at| {
            of.changes[at].sensitivity_share.abs()
        }),
    ]
}
