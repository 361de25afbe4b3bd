//! Figures and table of one channel, as the pane shows them.

use std::borrow::Cow;

use crate::{
    questions::{
        channels::{figures::Estimate, query::ChannelPlot},
        loops::{Inks, figure_of_channels},
    },
    report::{
        Cell, Column, Table,
        figure::{Figure, Line, Scale},
    },
    scoring::{loops::Frame, numbers::significant},
};

/// Margin above and below a spectrum, as a share of its range.
const MARGIN: f64 = 0.05;

impl ChannelPlot {
    /// Returns the plot of the channel over the other channel. Falling branches of a loop are fainter than rising ones.
    pub fn figure(&self, inks: &Inks, frame: Option<Frame>) -> Figure<'_> {
        figure_of_channels(&self.drawn, &self.labels, frame.unwrap_or(self.whole), inks)
    }

    /// Returns true if there are enough samples for a spectrum.
    pub fn has_spectrum(&self) -> bool {
        self.spectrum.is_some()
    }

    /// Returns the plot of the spectrum with logarithmic scales; `None` without a spectrum.
    pub fn spectrum_figure(&self, inks: &Inks) -> Option<Figure<'static>> {
        let points: Vec<[f64; 2]> = (self.spectrum.as_ref()?.points.iter())
            .filter(|[frequency, density]| *frequency > 0.0 && *density > 0.0)
            .map(|point| point.map(f64::log10))
            .collect();
        let [unit, of_time] = &self.units;
        let hertz = if of_time == "s" { "Hz" } else { "1/row" };
        let unit = if unit.is_empty() { "1" } else { unit };
        let ends = |at: usize| points.iter().map(move |point| point[at]).collect::<Vec<_>>();
        Some(Figure {
            title: format!("Spectrum of {}", self.labels[1]),
            across: Scale::spanning(format!("log10 of frequency [{hertz}]"), ends(0), 0.0),
            up: Scale::spanning(format!("log10 of density [{unit}/√{hertz}]"), ends(1), MARGIN),
            lines: vec![Line {
                width: 1.1,
                ..Line::new("", inks.gauge, [Cow::<[[f64; 2]]>::Owned(points)])
            }],
            ..Figure::default()
        })
    }

    /// Returns the figures of the channel: mean, noise, drift, and its slope and loop over the other channel. Rows of a table of
    /// loads are no clock, so they have no noise and no drift.
    pub fn table(&self) -> Table {
        let Some(figures) = &self.figures else {
            return Table::default();
        };
        let [unit, of_time] = &self.units;
        let per = |other: &str| format!("{unit}/{other}");
        let sure = |value: f64| Some(Estimate { value, uncertainty: None });
        let in_time = !self.is_table_of_loads;
        let rows = [
            ("Mean", sure(figures.mean), unit.clone(), "Mean of the samples"),
            (
                "Peak to peak",
                sure(figures.peak_to_peak),
                unit.clone(),
                "Largest minus smallest value",
            ),
            (
                "Standard deviation",
                figures.deviation.filter(|_| in_time).and_then(sure),
                unit.clone(),
                "Root mean square about the straight line through the samples over time. It contains the motion of the load",
            ),
            (
                "White noise",
                figures.white_noise.filter(|_| in_time).and_then(sure),
                unit.clone(),
                "Standard deviation of the noise from sample to sample",
            ),
            (
                "Drift",
                figures.slope.filter(|_| in_time),
                per(of_time),
                "Slope of the straight line through the samples over time, with its 95 % interval; none if the interval contains zero",
            ),
            (
                "Zero return",
                figures.zero_return.filter(|_| in_time),
                unit.clone(),
                "Mean at the last samples that have the load of the first samples, minus the mean of the first samples, with its 95 % interval; none if the interval contains zero",
            ),
            (
                "Slope",
                self.trend.and_then(|[slope, _]| sure(slope)),
                per(&self.unit_across),
                "Slope of the least-squares line over the horizontal channel",
            ),
            (
                "Correlation",
                self.trend.and_then(|[_, correlation]| sure(correlation)),
                String::new(),
                "Correlation coefficient with the horizontal channel",
            ),
            (
                "Loop width",
                self.widest_loop.as_ref().and_then(|widest| sure(widest.largest_width())),
                unit.clone(),
                "Largest width of the loop over the widest range; of loops over equal ranges, the widest",
            ),
            (
                "Mean width",
                self.widest_loop.as_ref().and_then(|widest| sure(widest.mean_width())),
                unit.clone(),
                "Mean width of the same loop",
            ),
        ];
        let n_samples = figures.n_samples;
        let rows = rows.into_iter().filter_map(|(name, found, unit, about)| {
            Some((name, found.filter(|found| found.value.is_finite())?, unit, about))
        });
        Table::of(rows)
            .column(Column::words("figure"), |(name, _, _, about)| Cell::words(*name).about(*about))
            .column(Column::numbers("value"), |(_, found, ..)| found.cell())
            .words("unit", |(_, _, unit, _)| unit.clone())
            .table("", format!("{n_samples} samples"))
    }
}

impl Estimate {
    /// Returns the value with its interval; "none" if the interval contains zero.
    fn cell(&self) -> Cell {
        let Self { value, uncertainty } = *self;
        match uncertainty.map(|half| (half, significant(half, 2))) {
            Some((half, words)) if value.abs() <= half => Cell::words(format!("none ± {words}")),
            Some((_, words)) => Cell::number(value, format!("{} ± {words}", significant(value, 4))),
            None => Cell::digits(Some(value), 4),
        }
    }
}
