//! Makes the tables and figures that show the result of a check of the recordings.

use crate::{
    questions::check::independent_loads::Sufficiency,
    report::{
        figure::{Figure, Line, Scale},
        table::{Cell, Column, Table},
    },
    scoring::rig::{RigReport, Run},
};

/// Colours (sRGB) of the gauges in figures, by Okabe and Ito (2008), without black and yellow.
const COLORS: [[u8; 3]; 6] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233]];

/// Function that returns the zeros or the sensitivities of the gauges in a run.
type Estimates = fn(&Run) -> &[Option<(f64, f64)>];

/// Returns the tables of the check without the error budget.
pub fn rig_and_axes(of: &Sufficiency) -> Vec<Table> {
    rig_tables(&of.rig).into_iter().chain([axes(of)]).collect()
}

fn axes(of: &Sufficiency) -> Table {
    Table::of(&of.axes)
        .words("Axis", |own| own.axis.label())
        .digits("smallest load", 4, |own| Some(own.low))
        .digits("largest load", 4, |own| Some(own.high))
        .digits("full scale", 4, |own| (own.full_scale > 0.0).then_some(own.full_scale))
        .words("full scale from", |own| if own.rated { "rated load" } else { "recorded loads" })
        .digits("fit RMSE", 4, |own| own.train_rmse)
        .about("RMS error of the fit on the training samples")
        .digits("cross-validation RMSE", 4, |own| own.left_out_rmse)
        .about("RMS error on samples that cross-validation held out of the fit")
        .words("correlated with", |own| match own.moves_with {
            Some((other, r)) => format!("{} ({r:+.2})", other.symbol()),
            None => String::new(),
        })
        .about(
            "Other axis whose training loads correlate most with those of this axis, and the correlation",
        )
        .table("Training loads and errors", "")
}

/// Returns the tables of the zeros of the gauges, their sensitivities, and the held-out errors, with one row for each
/// recording.
fn rig_tables(rig: &RigReport) -> Vec<Table> {
    let estimate = |own: Option<(f64, f64)>, from: f64| {
        let cell = own.map(|(value, error)| {
            let (value, error) = (100.0 * (value - from), 100.0 * error);
            Cell::number(value, format!("{value:+.2} ± {error:.2}"))
        });
        Cell::known(cell, "the loads of this recording do not determine this value")
    };
    let gauges = || rig.gauges.iter().enumerate();
    let head = |(_, name): &(usize, &String)| Column::numbers(name.as_str()).unit("%");
    let table = |of: Estimates, from: f64| {
        let rows = Table::of(rig.names.iter().zip(&rig.runs));
        let rows = rows.words("Recording", |(name, _)| name.as_str());
        rows.columns(gauges(), head, move |(_, run), (gauge, _)| estimate(of(run)[*gauge], from))
    };
    let zeros = table(|run| &run.zeros, 0.0)
        .column(Column::numbers("held-out error").unit("%"), |(_, run)| {
            Cell::digits(Some(100.0 * run.error), 3)
        })
        .about("Error of a conventional calibration in this recording, as a share of full scale. The calibration is fitted to the other recordings")
        .table(
            "Zeros of the gauges compared with the other recordings",
            "Difference between the zero of each gauge in this recording and in the other recordings, as a share of the gauge's range, ± one standard error.",
        );
    let sensitivities = table(|run| &run.sensitivities, 1.0).table(
            "Sensitivities of the gauges compared with the other recordings",
            "Relative difference between the sensitivity of each gauge in this recording and in the other recordings, ± one standard error.",
        );
    if rig.runs.len() > 1 { vec![zeros, sensitivities] } else { Vec::new() }
}

/// Returns the figures of the zeros and the sensitivities of the gauges over the recordings, in order of time.
pub fn rig_figures(rig: &RigReport) -> Vec<Figure<'static>> {
    let kinds: [(&str, Estimates, f64); 2] =
        [("Zero", |run| &run.zeros, 0.0), ("Sensitivity", |run| &run.sensitivities, 1.0)];
    let figure = |(what, of, from): (&str, Estimates, f64)| {
        let points = |gauge: usize| {
            rig.runs.iter().enumerate().filter_map(move |(at, run)| {
                let (value, error) = of(run)[gauge]?;
                Some((at as f64 + 1.0, 100.0 * (value - from), 100.0 * error))
            })
        };
        let all: Vec<_> = (0..rig.gauges.len()).flat_map(points).collect();
        let ends = all.iter().flat_map(|(_, value, error)| [value - error, value + error]);
        let up = Scale::spanning(format!("{what} [%]"), ends.chain([0.0]), 0.05);
        let lines = rig.gauges.iter().enumerate().map(|(gauge, name)| {
            let through: Vec<[f64; 2]> = points(gauge).map(|(x, y, _)| [x, y]).collect();
            let bars = points(gauge).map(|(x, y, error)| vec![[x, y - error], [x, y + error]]);
            let pieces: Vec<Vec<[f64; 2]>> = [through].into_iter().chain(bars).collect();
            Line { width: 1.5, ..Line::new(name.as_str(), COLORS[gauge % COLORS.len()], pieces) }
        });
        Figure {
            title: format!("{what} of each gauge compared with the other recordings"),
            across: Scale::new("Recording", (0.5, rig.runs.len() as f64 + 0.5)),
            lines: lines.collect(),
            up,
            ..Figure::default()
        }
    };
    if rig.runs.len() > 1 { kinds.map(figure).into() } else { Vec::new() }
}
