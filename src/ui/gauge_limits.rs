//! Controls of the gauge limits and of the overload tolerance.

use egui::Ui;

use crate::{
    engine::{Edit, Engine},
    min_max::MinMax,
    recording::{Entry, GaugeRange, ValidRange},
    ui::{command::Out, controls::Controls as _},
};

pub fn gauge_limits(ui: &mut Ui, engine: &Engine, out: &mut Out) {
    let project = engine.project();
    ui.horizontal_wrapped(|ui| {
        let mut entered = project.gauge_range.clone();
        let mut knows = entered.is_some();
        if ui.tick(
            &mut knows,
            "Gauge limits",
            "Minimum and maximum that the logger can write, such as -32768 and 32767. Without limits, a gauge counts as clipped if it stays at its extreme value while the load changes",
        ) {
            let extremes = || gauge_extremes(project.recordings.entries());
            entered = knows.then(|| GaugeRange::All(extremes()));
        }
        match &mut entered {
            Some(GaugeRange::All((low, high))) => {
                for (value, what) in [(low, "Smallest"), (high, "Largest")] {
                    let speed = (0.001 * value.abs()).max(1e-6);
                    let field = egui::DragValue::new(value).speed(speed);
                    ui.add(field).on_hover_text(format!("{what} possible value of a gauge"));
                }
            }
            Some(GaugeRange::Each(_)) => drop(ui.weak("separate for each gauge")),
            None => {}
        }
        if entered != project.gauge_range {
            out.send(Edit::GaugeRange(entered.filter(GaugeRange::rises)));
        }
        if project.settings.full_scale.iter().any(Option::is_some) {
            let tolerance = project.overload_tolerance.unwrap_or(ValidRange::RATED_TOLERANCE);
            let mut percent = 100.0 * tolerance;
            ui.label("Overload above rated by");
            let field = egui::DragValue::new(&mut percent).range(0.0..=100.0).speed(0.1).suffix(" %");
            let field = ui.add(field);
            if field.on_hover_text("A load counts as overload if it exceeds the rated load by more than this share").changed() {
                out.send(Edit::OverloadTolerance(percent / 100.0));
            }
        }
    });
}

/// Returns the minimum and maximum value of all gauges, including zero.
fn gauge_extremes(entries: &[Entry]) -> (f64, f64) {
    let ranges = entries.iter().flat_map(|entry| entry.recording.gauge_ranges());
    let range = ranges.copied().collect::<MinMax>().with(0.0);
    (range.min, range.max)
}
