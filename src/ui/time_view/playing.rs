//! Plays through the recording on screen at a selectable speed.

use crate::{
    questions::TraceSet,
    ui::{choice::choice, controls::Controls as _},
};

/// Selectable speeds: seconds of the recording per second.
const SPEEDS: [f64; 6] = [0.2, 1.0, 2.0, 5.0, 20.0, 100.0];

#[derive(Debug)]
pub struct Playing {
    /// Time on the time axis (s); `None` before playing started.
    time: Option<f64>,
    pub running: bool,
    /// True if a key moved the playing position after the last move of the pointer. Then the other panes show the sample at
    /// the playing position.
    pub stepped: bool,
    speed: f64,
}

impl Default for Playing {
    fn default() -> Self {
        Self { time: None, running: false, stepped: false, speed: 1.0 }
    }
}

impl Playing {
    pub fn clear(&mut self) {
        (self.time, self.running, self.stepped) = (None, false, false);
    }

    pub fn stand_at(&mut self, time: f64) {
        (self.time, self.running, self.stepped) = (Some(time), false, true);
    }

    pub fn controls(&mut self, ui: &mut egui::Ui) {
        let label = if self.running { "Stop" } else { "Play" };
        if ui.press(
            label,
            "Plays the recording from cursor A, or from the start of the visible time (Space)",
        ) {
            self.running = !self.running;
        }
        let about = "Playing speed: seconds of the recording per second";
        let button = egui::ComboBox::from_id_salt("speed").width(48.0);
        choice(ui, button, &mut self.speed, SPEEDS, |speed| (format!("{speed}×"), about))
            .on_hover_text(about);
    }

    /// Advances the playing position by `passed` seconds of clock time. Returns the index and the time (s) of the sample at the
    /// position.
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
}
