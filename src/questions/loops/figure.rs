//! Plots of loops and cross-plots, drawn alike in the window, in files and in the report, and the tables beside them.

use std::sync::Arc;

use crate::{
    questions::{
        dataset::applied::OutputLag,
        loops::{
            cross::{CrossPlot, DwellCurve},
            picture::{Drawn, LoopCurve, LoopFigures, LoopPlot},
            request::{Channel, Up},
        },
        metrology::Reason,
    },
    recording::Axis,
    report::{
        Trace,
        figure::{Arrow, Cloud, DASHED, Figure, Line, Scale, color},
        table::{Cell, Column, Table},
    },
    scoring::{holds::Drift, loops::Frame, numbers::significant},
};

/// Divisor of a branch's number of points: a tenth of the branch on each side of an arrow gives the arrow's direction,
/// because neighbouring points are too noisy.
const ARROW_SHARE: usize = 10;

#[derive(Clone, Copy, Debug)]
pub struct Inks {
    pub conventional: [u8; 3],
    pub compensated: [u8; 3],
    /// Colour of lines that show a gauge or a cross-plot.
    pub gauge: [u8; 3],
    /// Colour of text. Where falling branches are drawn as a density, this colour is mixed with the colour of the load.
    pub text: [u8; 3],
    pub guide: [u8; 3],
}

impl Inks {
    /// Colours for figures on a light background.
    pub const PRINT: Self = Self {
        conventional: color::CONVENTIONAL,
        compensated: color::COMPENSATED,
        gauge: color::LOOK_BACK,
        text: [0; 3],
        guide: color::GUIDE,
    };

    fn of(&self, output: Option<Trace>) -> [u8; 3] {
        match output {
            Some(Trace::Conventional) => self.conventional,
            Some(_) => self.compensated,
            None => self.gauge,
        }
    }
}

#[derive(Debug)]
pub struct LoopView<'a> {
    pub plot: &'a LoopPlot,
    /// Name and unit of the gauge on the vertical axis; empty if the axis shows a load.
    pub gauge: (&'a str, &'a str),
    /// True if the figures describe the mean loop, false if they describe the largest cycle.
    has_mean: bool,
    pub shown: Vec<&'a LoopCurve>,
}

impl<'a> LoopView<'a> {
    /// Returns a view that shows all curves of the plot. Its figures (such as the width) describe the mean loop, or the largest
    /// cycle if there is no mean loop.
    pub fn of_all(plot: &'a LoopPlot, gauge: (&'a str, &'a str)) -> Self {
        let has_mean = plot.curves.iter().any(|curve| curve.mean.is_ok());
        Self { plot, gauge, has_mean, shown: plot.curves.iter().collect() }
    }

    pub fn figures(&self, curve: &'a LoopCurve) -> Result<&'a LoopFigures, &'a Reason> {
        if self.has_mean { curve.mean.as_ref() } else { curve.largest.as_ref() }
    }

    pub fn found(&self) -> Vec<(Option<Trace>, &'a LoopFigures)> {
        let found = self.shown.iter();
        found.filter_map(|curve| Some((curve.output, self.figures(curve).ok()?))).collect()
    }

    pub fn unit(&self) -> &'a str {
        match self.plot.question.up {
            Up::Gauge(_) => self.gauge.1,
            Up::Load | Up::Error => self.plot.question.axis.unit(),
        }
    }

    fn labels(&self) -> [String; 2] {
        let axis = self.plot.question.axis;
        let up = match self.plot.question.up {
            Up::Load => axis.label(),
            Up::Error => axis.label_of("error"),
            Up::Gauge(_) => format!("{} [{}]", self.gauge.0, self.gauge.1),
        };
        [axis.label_of(Trace::Calculated.label()), up]
    }

    pub fn title(&self) -> String {
        let [across, up] = self.labels();
        format!("{up} against {across}")
    }

    fn long_title(&self) -> String {
        let axis = self.plot.question.axis.symbol();
        let what = match self.plot.question.up {
            Up::Load => axis.to_owned(),
            Up::Error => format!("{axis} error"),
            Up::Gauge(_) => format!("{} against {axis}", self.gauge.0),
        };
        let without_lag = if self.plot.question.lag_removed { ", lag removed" } else { "" };
        let what = format!("{what}{without_lag}");
        let found = self.found();
        let Some((_, figures)) = found.first() else {
            return what;
        };
        let basis = figures.basis;
        let share = significant(100.0 * basis.range_share, 2);
        let of = if self.has_mean {
            format!("mean of {} of {} cycles", basis.n_cycles, self.plot.cycles.len())
        } else {
            "largest cycle".to_owned()
        };
        format!("{what}: {of}, {share} % of the load range")
    }

    /// Returns the plot: all branches as thin lines, and the loop whose width is stated as a thick line with arrows. The
    /// falling branch of the thick line is dashed.
    pub fn figure(&self, inks: &Inks, frame: Option<Frame>) -> Figure<'a> {
        let frame = frame.unwrap_or(self.plot.whole);
        let opacity = thin_opacity(self.shown.iter().map(|curve| &curve.drawn));
        let one_to_one = (self.plot.question.up == Up::Load)
            .then(|| Line::one_to_one(frame.loads, frame.outputs, inks.guide))
            .flatten();
        let branches = self.shown.iter().flat_map(|curve| {
            branch_lines(&curve.drawn, inks.of(curve.output), 1.0, [opacity, 0.5 * opacity])
        });
        let found = self.found();
        let loops = found.iter().flat_map(|(output, figures)| {
            let width = significant(figures.mean_width(), 3);
            let name = output.map_or("Gauge", Trace::label);
            let name = format!("{name}, mean width {width} {}", self.unit());
            let ways = [(name, None), (String::new(), Some(DASHED))];
            let ways = figures.branches.iter().zip(ways);
            ways.map(|(branch, (name, dash))| Line {
                width: 2.4,
                dash,
                ..Line::new(name, inks.of(*output), [&branch[..]])
            })
        });
        let arrows = found.iter().flat_map(|(output, figures)| {
            let ways = figures.branches.iter().zip([true, false]);
            ways.filter_map(|(branch, rising)| arrow(branch, rising, inks.of(*output)))
        });
        let [across, up] = self.labels();
        Figure {
            title: self.long_title(),
            across: Scale::new(across, frame.loads),
            up: Scale::new(up, frame.outputs),
            clouds: (self.shown.iter())
                .flat_map(|curve| clouds(&curve.drawn, inks.of(curve.output), inks.text))
                .collect(),
            arrows: arrows.collect(),
            lines: one_to_one.into_iter().chain(branches).chain(loops).collect(),
            ..Figure::default()
        }
    }
}

impl CrossPlot {
    pub(crate) fn figure(
        &self,
        labels: [String; 2],
        inks: &Inks,
        frame: Option<Frame>,
    ) -> Figure<'_> {
        let frame = frame.unwrap_or(self.whole);
        let one_to_one = match (self.question.across, self.question.up) {
            (Channel::Load(_, across), Channel::Load(_, up)) if across == up => {
                Line::one_to_one(frame.loads, frame.outputs, inks.guide)
            }
            _ => None,
        };
        let figure = figure_of_channels(&self.drawn, &labels, frame, inks);
        Figure { lines: one_to_one.into_iter().chain(figure.lines).collect(), ..figure }
    }
}

/// Returns the strokes of the rising and of the falling branches.
fn branch_lines(drawn: &Drawn, color: [u8; 3], width: f32, opacity: [f32; 2]) -> [Line<'_>; 2] {
    [true, false].map(|rising| {
        let strokes = drawn.strokes.iter().filter(|stroke| stroke.rising == rising);
        let pieces = strokes.map(|stroke| &stroke.points[..]);
        Line { opacity: opacity[usize::from(!rising)], width, ..Line::new("", color, pieces) }
    })
}

/// Returns the figure of one channel against another. Falling branches are paler.
pub fn figure_of_channels<'a>(
    drawn: &'a Drawn,
    [across, up]: &[String; 2],
    frame: Frame,
    inks: &Inks,
) -> Figure<'a> {
    let opacity = 1.25 * thin_opacity(std::iter::once(drawn));
    let [rising, falling] = branch_lines(drawn, inks.gauge, 1.1, [opacity, 0.6 * opacity]);
    let falling = Some(falling).filter(|line| !line.pieces.is_empty());
    Figure {
        title: format!("{up} against {across}"),
        across: Scale::new(across, frame.loads),
        up: Scale::new(up, frame.outputs),
        clouds: clouds(drawn, inks.gauge, inks.text),
        lines: [rising].into_iter().chain(falling).collect(),
        ..Figure::default()
    }
}

/// Returns density maps of the branches that have too many points for lines. Rising branches have the colour `rising`, falling
/// branches a colour between `rising` and `ink`.
fn clouds(drawn: &Drawn, rising: [u8; 3], ink: [u8; 3]) -> Vec<Cloud> {
    let clouds = drawn.clouds.iter();
    clouds
        .map(|cloud| Cloud {
            density: Arc::clone(&cloud.density),
            color: if cloud.rising { rising } else { color::falling(rising, ink) },
        })
        .collect()
}

/// Returns an arrow in the middle of a branch, which shows whether the load rises or falls. The points of the branch are
/// sorted by rising load.
fn arrow(branch: &[[f64; 2]], rising: bool, color: [u8; 3]) -> Option<Arrow> {
    let middle = branch.len() / 2;
    let around = (branch.len() / ARROW_SHARE).max(1);
    let (before, after) = (branch.get(middle.checked_sub(around)?)?, branch.get(middle + around)?);
    Some(Arrow {
        at: branch[middle],
        way: if rising { [*before, *after] } else { [*after, *before] },
        color,
    })
}

/// Returns the opacity of the thin lines of branches. More points give fainter lines, so that thick lines stand out.
fn thin_opacity<'a>(drawn: impl Iterator<Item = &'a Drawn>) -> f32 {
    let points = drawn.map(|drawing| drawing.strokes.iter().map(|one| one.points.len()).sum());
    let most: usize = points.max().unwrap_or(0);
    (0.6 * (1000.0 / most.max(1) as f32).sqrt()).clamp(0.2, 0.6)
}

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
