//! Plays through the recording on screen.

use crate::{questions::TraceSet, ui::controls::Controls as _};

/// Longest time (s) in which the visible time is played. A longer visible time is played faster than it was recorded.
const LONGEST_SECS: f64 = 30.0;

#[derive(Debug, Default)]
pub struct Playing {
    /// Time on the time axis (s); `None` before playing started.
    time: Option<f64>,
    pub running: bool,
    /// True if a key moved the playing position after the last move of the pointer. Then the other panes show the sample at
    /// the playing position.
    pub stepped: bool,
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
    }

    /// Advances the playing position by `passed` seconds of clock time; `visible` is the length of the visible time (s). Returns
    /// the index and the time (s) of the sample at the position.
    pub fn go_on(
        &mut self,
        (passed, visible): (f64, f64),
        from: f64,
        traces: &TraceSet,
    ) -> Option<(usize, f64)> {
        let last = *traces.times.last()?;
        if self.running {
            let time = match self.time {
                Some(time) if time < last => time + passed * (visible / LONGEST_SECS).max(1.0),
                _ => from,
            };
            self.running = time < last;
            self.time = Some(time.min(last));
        }
        let time = self.time?;
        Some((traces.sample_at(time)?, time))
    }
}
