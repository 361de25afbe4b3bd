//! Histogram of the look-back ages: the time since the load differed by the force threshold F_th. Ages above the time
//! threshold t_th have another colour.

use egui_plot::{Bar, BarChart, VLine};

use crate::{
    engine::Engine,
    questions::thresholds::PastAges,
    ui::{command::Out, numbers::significant, palette, plots},
};

pub fn ages(
    ui: &mut egui::Ui,
    engine: &Engine,
    past_ages: &PastAges,
    size: [f32; 2],
    out: &mut Out,
) {
    let t_th_secs = engine.project().thresholds().t_th_secs;
    let visuals = ui.visuals().clone();
    let share = |count: u64| 100.0 * count as f64 / past_ages.n_samples.max(1) as f64;
    let bars = past_ages.ages.iter().map(|bin| {
        let wide = bin.to_secs - bin.from_secs;
        let color = if bin.to_secs <= t_th_secs * (1.0 + 1e-9) {
            palette::look_back(&visuals)
        } else {
            visuals.weak_text_color()
        };
        Bar::new(bin.from_secs + 0.5 * wide, share(bin.count)).width(0.92 * wide).fill(color)
    });
    let name = "Look-back age";
    let plot = plots::still("ages", size);
    let response = plots::scales(plot, Some("look-back age [s]"), "samples [%]")
        .show_grid([false, true])
        .include_y(0.0)
        .show(ui, |plot| {
            plot.bar_chart(BarChart::new(name, bars.collect()));
            plot.vline(VLine::new("t_th", t_th_secs).color(palette::present(&visuals)).width(1.2));
        })
        .response;
    plots::finish(&response, name, None, out);
    response.on_hover_text(format!(
        "Time since the load differed by the force threshold F_th. Green: within the time threshold t_th, so the look-back uses this earlier sample. Grey: longer ago than t_th, so the sample is not used. For {} % of the samples it is longer ago than the last bar shows",
        significant(share(past_ages.n_beyond), 2)
    ));
}
