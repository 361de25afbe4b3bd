//! Controls of the gauge limits and of the overload tolerance.

use egui::Ui;

use crate::{
    engine::{Edit, Engine, Project},
    min_max::MinMax,
    recording::{Entry, GaugeRange, ValidRange},
    shown::printable,
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
            "Minimum and maximum that the logger can write, such as -32768 and 32767. A gauge at a limit is clipped. \
             Without limits, a gauge counts as clipped if the gauge stays at its extreme value while the load changes",
        ) {
            let extremes = || gauge_extremes(project.recordings.entries(), None);
            entered = knows.then(|| GaugeRange::All(extremes()));
        }
        gauge_range(ui, project, &mut entered);
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

fn gauge_range(ui: &mut Ui, project: &Project, entered: &mut Option<GaugeRange>) {
    let Some(range) = entered else { return };
    let names = &project.recordings.layout().gauge_names;
    let ends = |ui: &mut Ui, (low, high): &mut (f64, f64), of: &str| {
        for (value, what) in [(low, "Smallest possible value"), (high, "Largest possible value")] {
            let speed = (0.001 * value.abs()).max(1e-6);
            let field = egui::DragValue::new(value).speed(speed);
            ui.add(field).on_hover_text(format!("{what} of {of}"));
        }
    };
    if let GaugeRange::All(range) = range {
        ends(ui, range, "a gauge");
    }
    let mut by_gauge = matches!(range, GaugeRange::Each(_));
    if ui.tick(
        &mut by_gauge,
        "for each gauge",
        "Sets separate limits for each gauge, for gauges on different amplifiers",
    ) {
        let range_of = |gauge: usize| range.of(gauge);
        *range = if by_gauge {
            GaugeRange::Each((0..names.len()).map(range_of).collect())
        } else {
            let known = (0..names.len()).filter_map(range_of).flat_map(|(low, high)| [low, high]);
            let all = || gauge_extremes(project.recordings.entries(), None);
            GaugeRange::All(known.collect::<MinMax>().ends().unwrap_or_else(all))
        };
    }
    let GaugeRange::Each(ranges) = range else {
        return;
    };
    ranges.resize(names.len(), None);
    let known = ranges.iter().flatten().count();
    let button = egui::Button::new(format!("{known} of {} gauges", names.len()));
    let response = ui.menu_of_fields(button, |ui| {
        egui::ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
            egui::Grid::new("limits of gauges").show(ui, |ui| {
                for (gauge, (name, limits)) in names.iter().zip(ranges).enumerate() {
                    let mut knows = limits.is_some();
                    if ui.tick(
                        &mut knows,
                        printable(name),
                        "Ticked if the limits of this gauge are known",
                    ) {
                        let entries = project.recordings.entries();
                        *limits = knows.then(|| gauge_extremes(entries, Some(gauge)));
                    }
                    if let Some(limits) = limits {
                        ends(ui, limits, name);
                    }
                    ui.end_row();
                }
            });
        });
    });
    response.on_hover_text("Shows the limits of each gauge. For a gauge without a tick, the data show where the gauge clips");
}

/// Returns the minimum and maximum value of all gauges or of one gauge, including zero.
fn gauge_extremes(entries: &[Entry], gauge: Option<usize>) -> (f64, f64) {
    let ranges = entries.iter().flat_map(|entry| {
        let ranges = entry.recording.gauge_ranges();
        match gauge {
            Some(gauge) => &ranges[gauge..=gauge],
            None => ranges,
        }
    });
    let range = ranges.copied().collect::<MinMax>().with(0.0);
    (range.min, range.max)
}
