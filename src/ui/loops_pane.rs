//! Pane of hysteresis loops with a table of loop figures (such as the width), cross-plots of any two channels, and the drift
//! in dwells. The contents of the pane are computed in the background.

mod cards;
mod dwell_view;
mod linked;
mod loop_view;

use egui::Ui;

use crate::{
    engine::{Edit, Engine},
    questions::{
        loops::{
            Channel, CrossPlot, CrossQuestion, DwellQuestion, Inks, Look, LoopQuestion, Question,
            Span, TableOf, Up, query::LookAt,
        },
        metrology::MetrologySettings,
    },
    recording::Axis,
    report::figure::{Figure, STANDS_ALONE},
    ui::{
        channels_pane,
        choice::labelled_choice,
        command::{Out, Pane},
        controls::Controls as _,
        numbers::significant,
        palette::Trace,
        pane::{Cx, PaneView},
        plots::{self, Drawn, Zoom},
        reversal_threshold::{dwell_secs, reversal_threshold},
        trace_panes::trace_tick,
    },
};

const FIGURES_WIDTH: f32 = 320.0;
/// Height of the trace and of the cards below the loop (points).
const BELOW_HEIGHT: f32 = linked::STRIP_HEIGHT + cards::HEIGHT + 28.0;
/// Height of the pane below which the trace is left out (points).
const LOW: f32 = 420.0;

/// Function that returns a figure in the colours of the screen or of an SVG file.
type InInks<'f, 'a> = &'f dyn Fn(&Inks) -> Figure<'a>;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Mode {
    #[default]
    Loops,
    Cross,
    Dwells,
}

impl Mode {
    const ALL: [(Self, &'static str, &'static str); 3] = [
        (
            Self::Loops,
            "Loop",
            "Plots the error, the load or a gauge against the reference load of one axis",
        ),
        (Self::Cross, "Cross-plot", "Plots any load, gauge or time against any other"),
        (
            Self::Dwells,
            "Drift",
            "Shows the drift of the error while the load is constant: creep and zero return",
        ),
    ];
}

#[derive(Debug)]
pub struct LoopsPane {
    mode: Mode,
    axis: Axis,
    up: Up,
    span: Span,
    shown: [bool; 2],
    lag_removed: bool,
    across: Channel,
    cross_up: Channel,
    /// Index of the dwell on screen; `None` shows the longest dwell.
    rest: Option<usize>,
    zooms: [Zoom; Mode::ALL.len()],
    /// Width and height of the drawing in pixels. Each is that of the plot on screen or of a saved figure, whichever is
    /// larger.
    pixels: [f64; 2],
    /// True if the table of values is beside the plot.
    has_figures: bool,
    /// Single channels, which are shown if the recordings lack something for a calibration.
    channels: channels_pane::View,
}

impl Default for LoopsPane {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            axis: Axis::Fz,
            up: Up::default(),
            span: Span::default(),
            shown: [true; 2],
            lag_removed: false,
            across: Channel::Load(Trace::Calculated, Axis::Fz),
            cross_up: Channel::Gauge(0),
            rest: None,
            zooms: [None; Mode::ALL.len()],
            pixels: STANDS_ALONE.into(),
            has_figures: true,
            channels: channels_pane::View::asking_as(Pane::LOOPS.key, true),
        }
    }
}

impl PaneView for LoopsPane {
    fn ui(&mut self, ui: &mut Ui, cx: &mut Cx<'_>) {
        if cx.engine.project().missing().is_some() {
            return self.channels.ui(ui, cx);
        }
        if let Some(axis) = cx.scope.axes().first()
            && *axis != self.axis
        {
            self.axis = *axis;
            self.show_all();
        }
        self.draw(ui, cx);
        if self.is_of_rows(cx.engine) {
            return self.channels.ui(ui, cx);
        }
        // The result is requested after the drawing, because the drawing may have changed the settings of the pane.
        if let Some(look) = cx.engine.look(cx.time.visible_time(), self.question()) {
            cx.ask_as(Pane::LOOPS.key, LookAt(look));
        }
    }
}

impl LoopsPane {
    /// Returns true if the pane shows single channels in place of loops, because the rows have no times.
    fn is_of_rows(&self, engine: &Engine) -> bool {
        self.mode == Mode::Loops && engine.project().recordings.is_static()
    }

    fn draw(&mut self, ui: &mut Ui, Cx { engine, time, presents, out, .. }: &mut Cx<'_>) {
        if engine.analysis().is_none() {
            let text = engine.problem().unwrap_or("No calibration is fitted yet.");
            ui.centered_and_justified(|ui| ui.label(text));
            return;
        }
        self.follow(engine);
        let before = &engine.project().measuring;
        let mut measuring = before.clone();
        self.has_figures = !*presents;
        if !*presents {
            ui.horizontal_wrapped(|ui| self.choices(ui, engine, &mut measuring));
        }
        if measuring != *before {
            out.send(Edit::Measuring(measuring));
        }
        ui.separator();
        if self.is_of_rows(engine) {
            return;
        }
        if let Some(problem) = engine.lane_of::<LookAt>(Pane::LOOPS.key).problem() {
            ui.warn(problem);
        }
        let on_screen = ui.pixels_per_point() * self.plot_size(ui);
        self.pixels =
            [STANDS_ALONE.0.max(on_screen.x.into()), STANDS_ALONE.1.max(on_screen.y.into())];
        match (self.mode, engine.lane_of::<LookAt>(Pane::LOOPS.key).answer()) {
            (Mode::Loops, Some(Look::Loops(found))) => {
                loop_view::show(ui, self, engine, found, time, out);
            }
            (Mode::Cross, Some(Look::Cross(found))) => {
                cross_plot(ui, self, engine, found, out);
            }
            (Mode::Dwells, Some(Look::Dwells(found))) => {
                dwell_view::show(ui, self, engine, found, out);
            }
            _ => {}
        }
    }

    fn question(&self) -> Question {
        let Self { axis, up, span, lag_removed, across, cross_up, rest, pixels, .. } = *self;
        let frame = self.zoom();
        match self.mode {
            Mode::Loops => {
                Question::Loops(LoopQuestion { axis, up, span, lag_removed, frame, pixels })
            }
            Mode::Cross => {
                Question::Cross(CrossQuestion { across, up: cross_up, span, frame, pixels })
            }
            Mode::Dwells => Question::Dwells(DwellQuestion { axis, rest, frame, pixels }),
        }
    }

    /// Replaces a chosen axis, gauge or recording that no longer exists by one that exists.
    fn follow(&mut self, engine: &Engine) {
        let axes = engine.project().axes();
        let n_gauges = engine.project().recordings.layout().gauge_names.len();
        if let Some(first) = axes.first()
            && !axes.contains(&self.axis)
        {
            self.axis = *first;
            self.zooms = [None; Mode::ALL.len()];
        }
        if matches!(self.up, Up::Gauge(gauge) if gauge >= n_gauges) {
            self.up = Up::default();
        }
        if matches!(self.span, Span::One(at) if at >= engine.entries().len()) {
            self.span = Span::default();
        }
        let first = axes.first().copied();
        for channel in [&mut self.across, &mut self.cross_up] {
            match channel {
                Channel::Gauge(gauge) if *gauge >= n_gauges => *channel = Channel::Time,
                Channel::Load(_, axis) if !axes.contains(axis) => *axis = first.unwrap_or(*axis),
                _ => {}
            }
        }
    }

    fn zoom(&self) -> Zoom {
        self.zooms[self.mode as usize]
    }

    fn show_all(&mut self) {
        self.zooms[self.mode as usize] = None;
    }

    fn choices(&mut self, ui: &mut Ui, engine: &Engine, measuring: &mut MetrologySettings) {
        ui.select_from(&mut self.mode, Mode::ALL);
        let before = (self.axis, self.up, self.span, self.across, self.cross_up, self.rest);
        match self.mode {
            _ if self.is_of_rows(engine) => {}
            Mode::Loops => {
                self.up_choice(ui, engine);
                self.span_choice(ui, engine);
                let found = match engine.lane_of::<LookAt>(Pane::LOOPS.key).answer() {
                    Some(Look::Loops(found)) => Some(found),
                    _ => None,
                };
                let used = found.map(|found| found.reversal_threshold);
                let axes = engine.project().axes();
                if let Some(at) = axes.iter().position(|axis| *axis == self.axis) {
                    reversal_threshold(ui, "Reversal threshold", (axes, at), measuring, used);
                }
                let can = self.lag_removed || found.is_some_and(|found| found.lag.is_removable());
                ui.add_enabled(can, egui::Checkbox::new(&mut self.lag_removed, "Lag removed"))
                    .on_hover_text("Delays the reference load by the delay or low-pass of the gauges. The width that remains is hysteresis, without the effect of an amplifier's filter");
            }
            Mode::Cross => {
                channel_choice(ui, engine, "across", &mut self.across);
                channel_choice(ui, engine, "up", &mut self.cross_up);
                self.span_choice(ui, engine);
            }
            Mode::Dwells => {
                if engine.project().recordings.is_static() {
                    ui.weak("Without times there are no dwells");
                } else {
                    dwell_secs(ui, "Dwells of at least", measuring)
                }
            }
        }
        let after = (self.axis, self.up, self.span, self.across, self.cross_up, self.rest);
        if after != before {
            self.show_all();
        }
        if self.mode != Mode::Cross
            && !(self.mode == Mode::Loops && matches!(self.up, Up::Gauge(_)))
        {
            ui.separator();
            for (shown, output) in self.shown.iter_mut().zip(Trace::OUTPUTS) {
                trace_tick(ui, shown, output);
            }
        }
    }

    fn is_shown(&self, output: Trace) -> bool {
        self.shown[usize::from(output == Trace::Compensated)]
    }

    fn up_choice(&mut self, ui: &mut Ui, engine: &Engine) {
        let gauges = &engine.project().recordings.layout().gauge_names;
        let all = [Up::Error, Up::Load].into_iter();
        let all = all.chain((0..gauges.len()).map(Up::Gauge));
        let described = |up| match up {
            Up::Load => ("Load", ""),
            Up::Error => ("Error", ""),
            Up::Gauge(gauge) => (gauges.get(gauge).map_or("", |name| name), ""),
        };
        labelled_choice(ui, ("up", 70.0), &mut self.up, all, described).on_hover_text(
            "Quantity on the vertical axis: the error, the computed load, or a raw gauge (as in Fig. 1 of Koike et al. 2019)",
        );
    }

    fn span_choice(&mut self, ui: &mut Ui, engine: &Engine) {
        let entries = engine.entries();
        let described = |span| {
            let name = match span {
                Span::Visible => "Shown recording",
                Span::Of(TableOf::Test) => "Test recordings",
                Span::Of(TableOf::Train) => "Training recordings",
                Span::Of(TableOf::NotFitted) => "Test and off recordings",
                Span::All | Span::Of(TableOf::All) => "All recordings",
                Span::One(at) => entries.get(at).map_or("–", |entry| entry.recording.name()),
            };
            (name, "")
        };
        let of = [TableOf::Test, TableOf::Train].map(Span::Of);
        let all = [Span::Visible, Span::All].into_iter().chain(of);
        let all = all.chain((0..entries.len()).map(Span::One));
        labelled_choice(ui, ("of", 104.0), &mut self.span, all, described).on_hover_text(
            "Recordings to plot. Shown recording: only what the traces show, also in time",
        );
    }

    fn plot_size(&self, ui: &Ui) -> egui::Vec2 {
        let beside = egui::vec2(FIGURES_WIDTH + 12.0, 2.0);
        let others = match self.mode {
            _ if !self.has_figures => egui::vec2(0.0, 2.0),
            Mode::Loops if ui.available_height() < LOW => egui::vec2(0.0, cards::HEIGHT + 12.0),
            Mode::Loops => egui::vec2(0.0, BELOW_HEIGHT),
            _ => beside,
        };
        (ui.available_size() - others).max(egui::vec2(200.0, 120.0))
    }

    /// Draws the plot on the left. On the right, `figures` draws the table of values.
    fn lay_out<'a>(
        &mut self,
        ui: &mut Ui,
        (name, figure): (Option<String>, InInks<'_, 'a>),
        out: &mut Out,
        figures: impl FnOnce(&mut Ui, &mut Self, &mut Out),
    ) -> Drawn {
        let size @ egui::Vec2 { x: width, y: height } = self.plot_size(ui);
        ui.horizontal_top(|ui| {
            let top_down = egui::Layout::top_down(egui::Align::Min);
            let drawn = ui.allocate_ui_with_layout(size, top_down, |ui| {
                ui.set_width(width);
                let (_, id, _) = Mode::ALL[self.mode as usize];
                let zoom = &mut self.zooms[self.mode as usize];
                plots::plot(ui, (id, name), height, figure, zoom, out)
            });
            if !self.has_figures {
                return drawn.inner;
            }
            ui.vertical(|ui| {
                ui.set_width(FIGURES_WIDTH);
                egui::ScrollArea::vertical().id_salt("figures").auto_shrink([false, false]).show(
                    ui,
                    |ui| {
                        figures(ui, self, out);
                    },
                );
            });
            drawn.inner
        })
        .inner
    }
}

fn channel_name(channel: Channel, engine: &Engine) -> String {
    let gauges = &engine.project().recordings.layout().gauge_names;
    match channel {
        Channel::Time => "Time".to_owned(),
        Channel::Gauge(gauge) => gauges.get(gauge).cloned().unwrap_or_default(),
        Channel::Load(load, axis) => format!("{} {}", axis.symbol(), load.label()),
    }
}

fn channel_unit(channel: Channel, engine: &Engine) -> &str {
    match channel {
        Channel::Time => "s",
        Channel::Gauge(gauge) => engine.project().recordings.gauge_unit(gauge),
        Channel::Load(_, axis) => axis.unit(),
    }
}

fn channel_choice(ui: &mut Ui, engine: &Engine, label: &str, channel: &mut Channel) {
    let n_gauges = engine.project().recordings.layout().gauge_names.len();
    let kinds = [Trace::Calculated, Trace::Conventional, Trace::Compensated];
    let loads = (engine.project().axes().iter())
        .flat_map(|axis| kinds.map(|load| Channel::Load(load, *axis)));
    let all = (0..n_gauges).map(Channel::Gauge).chain(loads);
    let all = std::iter::once(Channel::Time).chain(all);
    labelled_choice(ui, (label, 96.0), channel, all, |one| (channel_name(one, engine), ""))
        .on_hover_text("Quantity to plot: time, a gauge, or the reference, uncompensated or compensated load of an axis");
}

/// Draws the cross-plot of two channels.
fn cross_plot(
    ui: &mut Ui,
    pane: &mut LoopsPane,
    engine: &Engine,
    picture: &CrossPlot,
    out: &mut Out,
) {
    let label = |channel: Channel| {
        let name = channel_name(channel, engine);
        format!("{name} [{}]", channel_unit(channel, engine))
    };
    let question = &picture.question;
    let labels = [question.across, question.up].map(label);
    let zoom = pane.zoom();
    let figure = |inks: &Inks| picture.figure(labels.clone(), inks, zoom);
    pane.lay_out(ui, (None, &figure), out, |ui, _, _| {
        let [across, up] = &labels;
        ui.strong(format!("{up} against {across}"));
        ui.weak(format!("{} samples", picture.n_samples));
        if [picture.question.across, picture.question.up].contains(&Channel::Time) {
            ui.weak(
                "Each recording has its own clock, so the times of different recordings overlap.",
            );
        } else if let Some([slope, correlation]) = picture.trend {
            let units = [question.up, question.across].map(|of| channel_unit(of, engine));
            let [slope, correlation] = [slope, correlation].map(|value| significant(value, 4));
            ui.label(format!("Slope {slope} {}/{}", units[0], units[1]));
            ui.label(format!("Correlation {correlation}"));
        }
    });
}
