/// Chooses the samples that are kept in memory for look-backs and lags: the first sample, and each sample at least
/// `step_secs` after the last kept one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    step_secs: f64,
    last_secs: f64,
    /// True if the newest sample is kept.
    pub newest: bool,
}

impl Kept {
    pub fn new(step_secs: f64) -> Self {
        Self { step_secs, last_secs: f64::NEG_INFINITY, newest: true }
    }

    /// Returns true if the next sample, with this time (s), is kept.
    pub fn take(&mut self, time: f64) -> bool {
        self.newest = time - self.last_secs >= self.step_secs;
        if self.newest {
            self.last_secs = time;
        }
        self.newest
    }
}
