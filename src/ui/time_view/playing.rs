//! Going through time, as if the recording were measured now.

use crate::questions::TraceSet;
use crate::ui::choice::choice;

/// How many seconds go by in one, to choose from.
const SPEEDS: [f64; 6] = [0.2, 1.0, 2.0, 5.0, 20.0, 100.0];

/// Where it is, and whether it moves.
#[derive(Debug)]
pub struct Playing {
    /// On the time axis (s); `None` before it was begun.
    time: Option<f64>,
    running: bool,
    /// Whether it was put there by a key since the pointer last moved.
    stepped: bool,
    speed: f64,
}

impl Default for Playing {
    fn default() -> Self {
        Self { time: None, running: false, stepped: false, speed: 1.0 }
    }
}

impl Playing {
    /// Goes on, or stops.
    pub fn toggle(&mut self) {
        self.running = !self.running;
    }

    /// Forgets where it was.
    pub fn clear(&mut self) {
        (self.time, self.running, self.stepped) = (None, false, false);
    }

    /// Stops at this time.
    pub fn stand_at(&mut self, time: f64) {
        (self.time, self.running, self.stepped) = (Some(time), false, true);
    }

    /// The pointer moved: the sample under it is the one to show.
    pub fn let_pointer_lead(&mut self) {
        self.stepped = false;
    }

    /// Whether the sample to show is this one rather than the one under the pointer.
    pub fn leads(&self) -> bool {
        self.stepped
    }

    /// Draws the button and the choice of speeds.
    pub fn controls(&mut self, ui: &mut egui::Ui) {
        let label = if self.running { "Stop" } else { "Play" };
        let button = ui.button(label).on_hover_text(
            "Goes through time from cursor A, or from what is on screen; the look-back is drawn at each sample (Space)",
        );
        if button.clicked() {
            self.toggle();
        }
        let about = "Seconds of the recording in one second";
        let button = egui::ComboBox::from_id_salt("speed")
            .selected_text(format!("{}×", self.speed))
            .width(48.0);
        let items = SPEEDS.into_iter();
        let items = items.map(|speed| (speed, format!("{speed}×").into(), about));
        choice(ui, button, &mut self.speed, items).on_hover_text(about);
    }

    /// Goes on by `passed` seconds on the clock; returns the sample it is at and its time.
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

    /// Whether it moves.
    pub fn is_running(&self) -> bool {
        self.running
    }
}
