//! Plays through a recording as if it were being measured.

use crate::questions::TraceSet;
use crate::ui::choice::choice;

/// Selectable speeds: seconds of the recording per second.
const SPEEDS: [f64; 6] = [0.2, 1.0, 2.0, 5.0, 20.0, 100.0];

#[derive(Debug)]
pub struct Playing {
    /// Time on the time axis (s); `None` before playing started.
    time: Option<f64>,
    running: bool,
    /// True if a key moved the position after the pointer last moved.
    stepped: bool,
    speed: f64,
}

impl Default for Playing {
    fn default() -> Self {
        Self { time: None, running: false, stepped: false, speed: 1.0 }
    }
}

impl Playing {
    pub fn toggle(&mut self) {
        self.running = !self.running;
    }

    pub fn clear(&mut self) {
        (self.time, self.running, self.stepped) = (None, false, false);
    }

    pub fn stand_at(&mut self, time: f64) {
        (self.time, self.running, self.stepped) = (Some(time), false, true);
    }

    /// Makes the sample under the pointer the present one, because the pointer moved.
    pub fn let_pointer_lead(&mut self) {
        self.stepped = false;
    }

    /// Returns true if the present sample is the playing position, not the sample under the pointer.
    pub fn leads(&self) -> bool {
        self.stepped
    }

    pub fn controls(&mut self, ui: &mut egui::Ui) {
        let label = if self.running { "Stop" } else { "Play" };
        let button = ui.button(label).on_hover_text(
            "Plays from cursor A, or from the start of the visible time; draws the look-back at each sample (Space)",
        );
        if button.clicked() {
            self.toggle();
        }
        let about = "Speed: seconds of the recording per second";
        let button = egui::ComboBox::from_id_salt("speed")
            .selected_text(format!("{}×", self.speed))
            .width(48.0);
        let items = SPEEDS.into_iter();
        let items = items.map(|speed| (speed, format!("{speed}×").into(), about));
        choice(ui, button, &mut self.speed, items).on_hover_text(about);
    }

    /// Advances the position by `passed` seconds of clock time. Returns the sample there and its time.
    pub fn go_on(&mut self, passed: f64, from: f64, traces: &TraceSet) -> Option<(usize, f64)> {
        let last = *traces.times.last()?;
        if self.running {
            let time = match self.time {
                Some(time) if time < last => time + passed * self.speed,
                _ => from,
            };
            self.running = time < last;
            self.time = Some(time.min(last));
        }
        let time = self.time?;
        Some((traces.sample_at(time)?, time))
    }

    pub fn is_running(&self) -> bool {
        self.running
    }
}
