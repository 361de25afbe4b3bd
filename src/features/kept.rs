//! Which samples of a history are kept.

/// The rule, sample by sample: the first is kept, and each that comes at least a step after the last kept one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    step_secs: f64,
    last_secs: f64,
    /// Whether the newest is.
    pub newest: bool,
}

impl Kept {
    /// Before the first sample.
    pub fn new(step_secs: f64) -> Self {
        Self { step_secs, last_secs: f64::NEG_INFINITY, newest: true }
    }

    /// Takes the next sample, and says whether it is kept.
    pub fn take(&mut self, time: f64) -> bool {
        self.newest = time - self.last_secs >= self.step_secs;
        if self.newest {
            self.last_secs = time;
        }
        self.newest
    }
}
