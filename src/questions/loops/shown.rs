//! The figures of a loop, and of a dwell's drift, as tables.

use crate::questions::loops::source::OutputLag;
use crate::questions::metrology::Basis;
use crate::recording::Axis;
use crate::report::table::{Cell, Column, Table};
use crate::report::trace::Trace;
use crate::scoring::holds::Drift;
use crate::scoring::numbers::significant;

/// Ratio of rates from which cycles distinguish lag from hysteresis.
pub(crate) const RATES_APART: f64 = 2.0;

/// Returns a sentence on the lag of the gauges and its effect.
pub(crate) fn lag_in_words(found: &OutputLag) -> String {
    let lag = match &found.lag {
        Ok(lag) => lag,
        Err(reason) => return format!("Time lag unknown: {reason}."),
    };
    let [late, error] = [lag.seconds, 2.0 * lag.standard_error_secs].map(|own| significant(own, 3));
    let samples = significant(lag.samples, 3);
    if !lag.is_significant() {
        return format!("No significant time lag: {late} ± {error} s ({samples} samples).");
    }
    let kind = match lag.kind_is_known {
        true => lag.kind.name(),
        false => "delay, or time constant of a low-pass",
    };
    let explains = found.widths.map(|widths| {
        let [width, area] = [widths.explained_share(), widths.explained_area_share()]
            .map(|share| significant(100.0 * share, 2));
        let uncertainty = significant(100.0 * widths.uncertainty / widths.largest[1], 2);
        let not = if found.is_removable() { "" } else { "; the lag is too uncertain to be removed" };
        format!(
            ": it explains {width} % of the mean width and {area} % of the area. The largest width without it is known to ± {uncertainty} %{not}"
        )
    });
    let explains = explains.unwrap_or_default();
    format!("Time lag {late} ± {error} s ({samples} samples, {kind}){explains}.")
}

#[derive(Clone, Copy, Debug)]
pub struct LoopScale<'a> {
    pub axis: Axis,
    pub full_scale: f64,
    /// Unit of the gauge on the vertical axis; `None` for a load.
    pub gauge_unit: Option<&'a str>,
    /// Value of 100 % on the vertical axis; 0 if there is none.
    pub output_scale: f64,
}

#[derive(Clone, Copy, Debug)]
pub struct LoopMeasures {
    /// Load of the loop; `None` for a gauge.
    pub trace: Option<Trace>,
    /// Largest width, mean width, area and dissipated work, in their units, each with its basis.
    pub figures: [(f64, Basis); 4],
}

/// Returns the change of a figure with half and twice the reversal threshold.
pub(crate) fn moves(value: f64, basis: &Basis) -> String {
    let others = [basis.reversal_threshold_halved, basis.reversal_threshold_doubled];
    let moved = others.map(|other| match other {
        Some(other) if value != 0.0 => {
            let percent = 100.0 * (other / value - 1.0);
            match percent {
                _ if percent.abs() < 0.05 => "0".to_owned(),
                _ if percent.abs() < 1000.0 => format!("{percent:+.1}"),
                _ => format!("{percent:+.0}"),
            }
        }
        Some(0.0) => "0".to_owned(),
        _ => "–".to_owned(),
    });
    format!("{}, {} %", moved[0], moved[1])
}

/// Explanation of [`moves`].
pub(crate) const MOVES: &str = "Change of the figure with half and with twice the reversal threshold; a dash if the figure would be missing";

enum Line {
    Units,
    Percent(f64),
    Moves,
}

/// Returns largest width, mean width, area and dissipated work of each loop, in units and in percent. Further rows hold the
/// change from the first loop to the second, and the dependence on the reversal threshold.
pub fn loop_figures(loops: &[LoopMeasures], of: LoopScale<'_>) -> Table {
    let unit = of.gauge_unit.unwrap_or(of.axis.unit());
    let area_unit = match (of.gauge_unit, of.axis.is_force()) {
        (Some(unit), _) => format!("{unit}·{}", of.axis.unit()),
        (None, true) => "N²".to_owned(),
        (None, false) => "N²·m²".to_owned(),
    };
    let (share, area_share, of_what) = match of.gauge_unit {
        Some(_) => ("%", "%", "In percent of half the range of the gauge"),
        None => ("% FS", "% FS²", "In percent of full scale"),
    };
    let area_scale = of.output_scale * of.full_scale;
    let described = [
        ("Largest width", "Largest |falling − rising| at equal load", unit, share, of.output_scale),
        (
            "Mean width",
            "Mean |falling − rising| over the range of loads",
            unit,
            share,
            of.output_scale,
        ),
        (
            "Area",
            "Integral of |falling − rising| over the load; in percent of the full scales of both",
            &area_unit,
            area_share,
            area_scale,
        ),
        (
            "Dissipated work",
            "Integral of falling − rising over the load: positive if the output lags behind, negative if it leads; parts of opposite signs cancel",
            &area_unit,
            area_share,
            area_scale,
        ),
    ];
    let rows = described.iter().enumerate().flat_map(|(at, (name, about, unit, share, scale))| {
        [
            (at, *name, *unit, *about, Line::Units),
            (at, "", *share, of_what, Line::Percent(*scale)),
            (at, "½, 2 × band", "%", MOVES, Line::Moves),
        ]
    });
    Table::of(rows)
        .column(Column::words(""), |(_, name, _, about, line)| match line {
            Line::Percent(_) => Cell::words(*name),
            Line::Units | Line::Moves => Cell::words(*name).about(*about),
        })
        .column(Column::words(""), |(_, _, unit, about, _)| Cell::words(*unit).about(*about))
        .columns(
            loops,
            |one| one.trace.map_or_else(|| Column::numbers("Gauge"), |own| Column::of(own, "")),
            |(at, .., line), one| {
                let (value, basis) = &one.figures[*at];
                match line {
                    Line::Units => Cell::digits(Some(*value), 4),
                    Line::Percent(scale) => {
                        Cell::digits((*scale > 0.0).then(|| 100.0 * value / scale), 3)
                    }
                    Line::Moves => {
                        Cell::words(moves(*value, basis).trim_end_matches(" %")).about(MOVES)
                    }
                }
            },
        )
        .columns(
            <&[_; 2]>::try_from(loops),
            |_| Column::change(),
            |(at, .., line), both| match (line, both.map(|one| one.figures[*at].0)) {
                (Line::Units, [before, after]) if before * after < 0.0 => {
                    Cell::missing("–", "the sign changes")
                }
                (Line::Units, [before, after]) => Cell::change(before.abs(), after.abs()),
                (Line::Percent(_) | Line::Moves, _) => Cell::words(""),
            },
        )
        .table("", "")
}

/// Returns the fitted exponential of each load's error over one dwell. The cells are `None` if no time passes.
pub fn drifts(axis: Axis, drifts: &[(Trace, Option<&Drift>)]) -> Table {
    let reasons = drifts.iter().filter_map(|(trace, drift)| {
        let reason = drift.as_ref()?.tau_secs().err()?;
        Some(format!("{} {reason}", trace.label()))
    });
    let unit = axis.unit();
    type OfDrift = fn(&Drift) -> Cell;
    let rows: [(String, &str, OfDrift); 3] = [
        (
            format!("Drift [{unit}]"),
            "Change of output − load from the beginning of the dwell to its end, on the fitted exponential",
            |drift| Cell::digits(Some(drift.size), 3),
        ),
        (
            "τ [s]".to_owned(),
            "Time constant of a + b (1 − exp(−t / τ)); a dash if the data do not determine it",
            |drift| match drift.tau_secs() {
                Ok(tau) => Cell::digits(Some(tau), 3),
                Err(reason) => Cell::missing("–", reason.to_string()),
            },
        ),
        (format!("Noise [{unit}]"), "Root mean square of the residuals of the fit", |drift| {
            Cell::digits(Some(drift.noise), 3)
        }),
    ];
    Table::of(rows)
        .column(Column::words(""), |(name, about, _)| Cell::words(name).about(*about))
        .columns(
            drifts,
            |(trace, _)| Column::of(*trace, ""),
            |(.., cell), (_, drift)| drift.map_or_else(Cell::none, cell),
        )
        .table("", reasons.collect::<Vec<_>>().join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Full scale is 20 N: a width of 1 N is 5 %, and an area of 8 N² is 2 % of its square.
    #[test]
    fn figures_are_in_units_in_percent_and_as_a_change() {
        let of =
            LoopScale { axis: Axis::Fz, full_scale: 20.0, gauge_unit: None, output_scale: 20.0 };
        let basis = Basis { reversal_threshold_halved: Some(1.1), ..Basis::new(3, 0.5) };
        let measures = |trace, figures: [f64; 4]| LoopMeasures {
            trace,
            figures: figures.map(|figure| (figure, basis)),
        };
        let both = [
            measures(Some(Trace::Conventional), [1.0, 0.5, 8.0, 8.0]),
            measures(Some(Trace::Compensated), [0.5, 0.25, 2.0, -2.0]),
        ];
        let shown = |table: &Table| -> Vec<Vec<String>> {
            let rows = table.rows.iter();
            rows.map(|row| row.iter().map(|cell| cell.text.clone()).collect()).collect()
        };
        let rows = shown(&loop_figures(&both, of));
        assert_eq!(rows[0], ["Largest width", "N", "1.000", "0.5000", "-50.0 %"]);
        assert_eq!(rows[1], ["", "% FS", "5.00", "2.50", ""]);
        assert_eq!(rows[2], ["½, 2 × band", "%", "+10.0, –", "+120.0, –", ""]);
        assert_eq!(rows[6], ["Area", "N²", "8.000", "2.000", "-75.0 %"]);
        assert_eq!(rows[7], ["", "% FS²", "2.00", "0.500", ""]);
        assert_eq!(rows[9], ["Dissipated work", "N²", "8.000", "-2.000", "–"]);
        let gauge = LoopScale { gauge_unit: Some("ohm"), output_scale: 0.0, ..of };
        let rows = shown(&loop_figures(&[measures(None, [1.0; 4])], gauge));
        assert_eq!(rows[0], ["Largest width", "ohm", "1.000"]);
        assert_eq!(rows[1], ["", "%", "–"]);
        assert_eq!(rows[6][1], "ohm·N");
    }
}
