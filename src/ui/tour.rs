//! A first walk through the main job on the built-in sensor; it stands aside and can be skipped at any time.

const STEPS: [(&str, &str); 6] = [
    (
        "What this is",
        "These recordings come from a simulated force/torque sensor, so that there is something to try. Each pane shows one axis: \
         Calculated (Calc.) is the load that was really applied, Conventional (Conv.) what the usual calibration makes of the gauges, Compensated (Comp.) what it becomes with \
         gauges from the past. Their errors are below.",
    ),
    (
        "The past of a sample",
        "Move the pointer over a trace. The green interval is t_th, the green box F_th around the present load, the diamond the sample \
         that the look-back found: the last one whose load differed by F_th. Space plays through time.",
    ),
    (
        "Thresholds",
        "Move F_th and t_th in Settings: everything is fitted again while you move them. At 0 N, Comp. equals Conv. The tab Thresholds \
         shows the error for every pair, and suggests one without touching the test recordings.",
    ),
    (
        "Loops",
        "The tab Loops draws the error over the load: hysteresis as an area, before and after. Metrology gives the figures that a \
         calibration certificate asks for.",
    ),
    (
        "Your own recordings",
        "Drop files on the window, or File > Open. Give each a role: it trains, it tests, or it is off. A file whose columns have no \
         names is asked about first.",
    ),
    (
        "Out again",
        "Export the calibration at the foot: .json for this program, .h, .rs or .py to run on a robot, and more. F1 shows all keys, \
         Ctrl+P finds any action.",
    ),
];

/// Where the tour is.
#[derive(Debug, Default)]
pub struct Tour {
    step: Option<usize>,
}

impl Tour {
    /// Begins it.
    pub fn begin(&mut self) {
        self.step = Some(0);
    }

    /// Ends it.
    pub fn end(&mut self) {
        self.step = None;
    }

    /// Draws the step that it is at; whether it was ended.
    pub fn show(&mut self, context: &egui::Context) -> bool {
        let Some(step) = self.step else {
            return false;
        };
        let (title, text) = STEPS[step.min(STEPS.len() - 1)];
        let mut ended = false;
        egui::Window::new(format!("Tour, {} of {}: {title}", step + 1, STEPS.len()))
            .id(egui::Id::unique("tour"))
            .anchor(egui::Align2::RIGHT_TOP, [-24.0, 70.0])
            .collapsible(false)
            .resizable(false)
            .show(context, |ui| {
                ui.set_width(360.0);
                ui.add(egui::Label::new(text).wrap());
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    let back = ui.add_enabled(step > 0, egui::Button::new("Back"));
                    if back.on_hover_text("To the step before").clicked() {
                        self.step = Some(step - 1);
                    }
                    if step + 1 < STEPS.len() {
                        let next = ui.button("Next").on_hover_text("To the next step");
                        if next.clicked() {
                            self.step = Some(step + 1);
                        }
                        let skip = ui.button("Skip the tour");
                        ended |= skip
                            .on_hover_text("The Help menu has it, for later")
                            .clicked();
                    } else {
                        let done = ui.button("Done").on_hover_text("Ends the tour");
                        ended |= done.clicked();
                    }
                });
            });
        ended
    }
}
