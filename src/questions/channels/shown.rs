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

    /// Returns the figures of the channel: mean, noise, drift, and the width of its loop.
    pub fn table(&self) -> Table {
        let Some(figures) = &self.figures else {
            return Table::default();
        };
        let [unit, of_time] = &self.units;
        let rate = format!("{unit}/{of_time}");
        let few = "too few samples";
        let number = |value: f64| Some(Cell::digits(Some(value), 4));
        let known = |value: Option<f64>| Cell::known(value.and_then(number), few);
        let estimate = |estimate: Option<Estimate>| {
            let cell = estimate.map(|Estimate { value, uncertainty }| {
                let within = uncertainty.map(|half| format!(" ± {}", significant(half, 2)));
                Cell::number(value, significant(value, 4) + &within.unwrap_or_default())
            });
            Cell::known(cell, few)
        };
        let change = figures.change;
        let at_equal_load = change.is_some_and(|change| change.at_equal_load);
        let [change_name, change_about] = if at_equal_load {
            [
                "Zero return",
                "Mean at the last samples that have the load of the first samples, minus the mean of the first samples, with its 95 % interval",
            ]
        } else {
            [
                "Start to end",
                "Mean of the last twentieth of the samples minus that of the first twentieth, with its 95 % interval. The load at start and end is not known to be equal",
            ]
        };
        let mut rows = vec![
            ("Mean", known(Some(figures.mean)), unit, "Mean of the samples"),
            (
                "Noise (RMS)",
                known(figures.rms),
                unit,
                "Root mean square about the straight line through the samples",
            ),
            (
                "White noise",
                known(figures.white_noise),
                unit,
                "Standard deviation of the noise from sample to sample",
            ),
            (
                "Peak to peak",
                known(Some(figures.peak_to_peak)),
                unit,
                "Largest minus smallest value",
            ),
            (
                "Drift",
                estimate(figures.slope),
                &rate,
                "Slope of the straight line through the samples, with its 95 % interval",
            ),
            (change_name, estimate(change.map(|change| change.by)), unit, change_about),
        ];
        if let Some(widest) = &self.widest_loop {
            let widths = [
                ("Loop width", widest.largest_width(), "Largest width of the widest loop"),
                ("Mean width", widest.mean_width(), "Mean width of the widest loop"),
            ];
            rows.extend(widths.map(|(name, width, about)| (name, known(Some(width)), unit, about)));
        }
        let n_samples = figures.n_samples;
        Table::of(rows)
            .column(Column::words("figure"), |(name, _, _, about)| Cell::words(*name).about(*about))
            .column(Column::numbers("value"), |(_, cell, ..)| cell.clone())
            .words("unit", |(_, _, unit, _)| unit.as_str())
            .table("", format!("{n_samples} samples"))
    }
}
