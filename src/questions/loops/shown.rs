//! Tables of the widths and areas of loops, and of the drift in a dwell.

use crate::{
    questions::{
        dataset::applied::OutputLag,
        loops::{dwell::DwellCurve, figure::LoopView, request::Up},
    },
    recording::Axis,
    report::{
        table::{Cell, Column, Table},
        trace::Trace,
    },
    scoring::{holds::Drift, numbers::significant},
};

/// Returns a sentence about the time lag of the uncompensated load, and its effect on the width of the loop.
pub fn lag_in_words(found: &OutputLag) -> String {
    let lag = match &found.lag {
        Ok(lag) => lag,
        Err(reason) => return format!("Time lag of the uncompensated load unknown: {reason}."),
    };
    let [late, error] =
        [lag.seconds, 2.0 * lag.standard_error_secs].map(|secs| significant(secs, 3));
    let samples = significant(lag.samples, 3);
    if !lag.is_significant() {
        return format!(
            "No significant time lag of the uncompensated load: {late} ± {error} s, which is {samples} samples."
        );
    }
    let kind =
        if lag.kind_is_known { lag.kind.name() } else { "delay, or time constant of a low-pass" };
    let explains = found.widths.map(|widths| {
        let [width, area] = [widths.explained_share(), widths.explained_area_share()]
            .map(|share| significant(100.0 * share, 2));
        let uncertainty = significant(100.0 * widths.uncertainty / widths.largest[1], 2);
        let not = if found.is_removable() { "" } else { "; the lag is too uncertain to be removed" };
        format!(
            ". The lag explains {width} % of the loop's mean width and {area} % of its area. Without the lag, the largest width is known to ± {uncertainty} %{not}"
        )
    });
    let explains = explains.unwrap_or_default();
    format!("Time lag {late} ± {error} s ({samples} samples, {kind}){explains}.")
}

enum Line {
    Units,
    Percent(f64),
}

/// Returns a table of the largest width, mean width, area and dissipated work of each loop, in units and in percent. For two
/// loops, a column holds the change from the first to the second.
pub fn loop_figures(view: &LoopView<'_>) -> Table {
    let (loops, plot, unit) = (view.found(), view.plot, view.unit());
    let (axis, scale) = (plot.question.axis, plot.output_scale);
    let is_gauge = matches!(plot.question.up, Up::Gauge(_));
    let area_unit = match axis.is_force() {
        _ if is_gauge => format!("{unit}·{}", axis.unit()),
        true => "N²".to_owned(),
        false => "N²·m²".to_owned(),
    };
    let (share, area_share, of_what) = if is_gauge {
        ("%", "%", "In percent of half the range of the gauge")
    } else {
        ("% FS", "% FS²", "In percent of full scale")
    };
    let width = (unit, share, scale);
    let area = (&*area_unit, area_share, scale * plot.full_scale);
    let described = [
        (
            "Largest width",
            "Largest distance |falling − rising| between the two branches of the loop at equal load",
            width,
        ),
        (
            "Mean width",
            "Mean distance |falling − rising| between the two branches of the loop, across its range of loads",
            width,
        ),
        (
            "Area",
            "Integral of |falling − rising| along the load; in percent of the product of the full scales of output and load",
            area,
        ),
        (
            "Dissipated work",
            "Integral of falling − rising along the load: positive if the output lags behind, negative if the output leads; parts of opposite signs cancel",
            area,
        ),
    ];
    let rows =
        described.into_iter().enumerate().flat_map(|(at, (name, about, (unit, share, scale)))| {
            [(at, name, unit, about, Line::Units), (at, "", share, of_what, Line::Percent(scale))]
        });
    Table::of(rows)
        .column(Column::words(""), |(_, name, _, about, line)| match line {
            Line::Percent(_) => Cell::words(*name),
            Line::Units => Cell::words(*name).about(*about),
        })
        .column(Column::words(""), |(_, _, unit, about, _)| Cell::words(*unit).about(*about))
        .columns(
            &loops,
            |(output, _)| {
                output.map_or_else(|| Column::numbers("Gauge"), |own| Column::of(own, ""))
            },
            |(at, .., line), (_, figures)| {
                let value = &figures.measures[*at];
                match line {
                    Line::Units => Cell::digits(Some(*value), 4),
                    Line::Percent(scale) => {
                        Cell::digits((*scale > 0.0).then(|| 100.0 * value / scale), 3)
                    }
                }
            },
        )
        .columns(
            <&[_; 2]>::try_from(&loops[..]),
            |_| Column::change(),
            |(at, .., line), both| match (
                line,
                both.each_ref().map(|(_, figures)| figures.measures[*at]),
            ) {
                (Line::Units, [before, after]) if before * after < 0.0 => {
                    Cell::missing("–", "no change in percent, because the figures of the two loops have opposite signs")
                }
                (Line::Units, [before, after]) => Cell::change(before.abs(), after.abs()),
                (Line::Percent(_), _) => Cell::words(""),
            },
        )
        .table("", "")
}

/// Returns a table of the exponential that is fitted to each output's error over one dwell. A cell is a dash if the dwell has
/// no duration.
pub fn drifts(axis: Axis, curve: &DwellCurve) -> Table {
    let drifts = Trace::OUTPUTS.into_iter().zip(curve.outputs.iter().map(|output| &output.drift));
    let reasons = drifts.clone().filter_map(|(trace, drift)| {
        let reason = drift.as_ref()?.tau_secs().err()?;
        Some(format!("{} {reason}", trace.label()))
    });
    let reasons = reasons.collect::<Vec<_>>().join("\n");
    let unit = axis.unit();
    type OfDrift = fn(&Drift) -> Cell;
    let rows: [(String, &str, OfDrift); 3] = [
        (
            format!("Drift [{unit}]"),
            "Change of the error (output − load) from the beginning of the dwell to its end, on the fitted exponential",
            |drift| Cell::digits(Some(drift.size), 3),
        ),
        (
            "τ [s]".to_owned(),
            "Time constant τ of the error a + b (1 − exp(−t / τ)), fitted over the dwell; a dash means that the data do not determine the time constant",
            |drift| match drift.tau_secs() {
                Ok(tau) => Cell::digits(Some(tau), 3),
                Err(reason) => Cell::missing("–", reason.to_string()),
            },
        ),
        (
            format!("Noise [{unit}]"),
            "Root mean square of the residuals of the fitted exponential",
            |drift| Cell::digits(Some(drift.noise), 3),
        ),
    ];
    Table::of(rows)
        .column(Column::words(""), |(name, about, _)| Cell::words(name).about(*about))
        .columns(
            drifts,
            |(trace, _)| Column::of(*trace, ""),
            |(.., cell), (_, drift)| drift.as_ref().map_or_else(Cell::none, cell),
        )
        .table("", reasons)
}
