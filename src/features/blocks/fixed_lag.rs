//! Feature block of fixed lags: the gauges a fixed time Δ ago, `s(t − Δ)` (references 23 and 24 in Koike et al. (2019)).
//!
//! Guarantees: gauges are interpolated between samples, so jitter and rounded times cause no jumps. Until the time Δ has
//! passed since the start, the columns are the present gauges. Samples older than the longest lag are dropped.

use std::collections::VecDeque;

use crate::features::{
    block::{Appends, Block, Inputs, Lists, STORED_SAMPLES, Search, Stream},
    kept::Kept,
    setting::{Range, Setting, Unit},
    source::{Code, Constant, Memory, Precision, Rows, Source},
};

/// Feature block of fixed lags. Its values are the lags (s).
#[derive(Clone, Copy, Debug)]
pub struct FixedLag;

const LAGS: Setting = Setting {
    key: "fixed_lags_secs",
    option: "fixed-lag",
    label: "Fixed lags",
    what: "a fixed lag",
    unit: Unit::SECONDS,
    default: &[0.5],
    range: Range::Past,
    step: 0.1,
    explanation: "Appends the gauges at this time before the present, interpolated linearly between samples. \
                  Until the lag has passed, the present gauges are used",
    source: "references 23 and 24 of the paper",
};

/// Lags that cross-validation tries (s): from typical lags of filters and amplifiers to those of the look-back in Koike et
/// al. (2019).
const CANDIDATES: [f64; 14] =
    [0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];

impl Block for FixedLag {
    fn name(&self) -> &'static str {
        "Fixed lag"
    }

    fn setting(&self) -> &'static Setting {
        &LAGS
    }

    fn formula(&self) -> &'static str {
        "s(t − Δ)"
    }

    fn appends(&self) -> Appends {
        Appends::Past(|lag_secs| format!("lag_{lag_secs}s"))
    }

    fn window_secs(&self, lags_secs: &[f64]) -> f64 {
        lags_secs.iter().copied().fold(0.0, f64::max)
    }

    fn memory(&self) -> Option<&'static str> {
        Some(STORED_SAMPLES)
    }

    fn stream(&self, lags_secs: &[f64], inputs: &Inputs<'_>) -> Box<dyn Stream> {
        Box::new(Lags::new(lags_secs, inputs.history_step_secs))
    }

    fn search(&self) -> Option<Search> {
        Some(Search { candidates: &CANDIDATES, lists: Lists::OneByOne(3) })
    }

    fn source(&self, lags_secs: &[f64], _: &Rows<'_>) -> Source {
        let code = |functions, update| Code { functions, ..Code::update(update) };
        Source {
            constants: vec![Constant {
                precision: Precision::Clock,
                ..Constant::reals("lag_secs", lags_secs.iter().copied())
            }],
            memory: vec![Memory {
                precision: Precision::Index,
                comment: "index of the first sample more recent than the lag, counted back from the present",
                ..Memory::single("behind", lags_secs.len())
            }],
            c: code(C_FUNCTIONS, C),
            rust: code(RUST_FUNCTIONS, RUST),
            python: code(PYTHON_FUNCTIONS, PYTHON),
            matlab: code(MATLAB_FUNCTIONS, MATLAB),
        }
    }
}

const C_FUNCTIONS: &str = "
/* Interpolated gauges at this age minus the present gauges; zero if no sample is that old. */
static inline void {{ prefix }}_lagged({{ prefix }}_state *s, int lag, {{ prefix }}_clock age, {{ prefix }}_real *out)
{
    int32_t behind = s->behind[lag] + 1 < s->kept ? s->behind[lag] + 1 : s->kept - 1;
    int g;
    while (behind > 0 && s->clock - s->times[{{ prefix }}_slot(s, behind)] >= age)
        behind--;
    s->behind[lag] = behind;
    if (behind + 1 >= s->kept) {
        for (g = 0; g < {{ n_gauges }}; g++)
            out[g] = 0;
    } else {
        int32_t older = {{ prefix }}_slot(s, behind + 1), younger = {{ prefix }}_slot(s, behind);
        {{ prefix }}_real before = ({{ prefix }}_real)(s->clock - s->times[older] - age);
        {{ prefix }}_real whole = ({{ prefix }}_real)(s->times[younger] - s->times[older]);
        {{ prefix }}_real share = whole > 0 ? before / whole : 0;
        for (g = 0; g < {{ n_gauges }}; g++) {
            {{ prefix }}_real start = s->gauges[older][g], end = s->gauges[younger][g];
            out[g] = start + share * (end - start) - s->gauges[s->newest][g];
        }
    }
}
";

const C: &str = "
        int at;
        for (at = 0; at < {{ sets }}; at++) {
            {{ prefix }}_lagged(s, at, c->lag_secs[at], next);
            next += {{ n_gauges }};
        }
";

const RUST_FUNCTIONS: &str = "
    /// Interpolated gauges at this age minus the present gauges; zero if no sample is that old.
    fn lagged(&mut self, lag: usize, age: f64) -> [Real; GAUGES] {
        let mut behind = (self.behind[lag] + 1).min(self.kept - 1);
        while behind > 0 && self.time - self.times[self.slot(behind)] >= age {
            behind -= 1;
        }
        self.behind[lag] = behind;
        let mut out = [0.0; GAUGES];
        if behind + 1 < self.kept {
            let (older, younger) = (self.slot(behind + 1), self.slot(behind));
            let (start, end) = (self.times[older], self.times[younger]);
            let share = if end > start { ((self.time - start) - age) / (end - start) } else { 0.0 } as Real;
            for (g, out) in out.iter_mut().enumerate() {
                let (before, after) = (self.gauges[older][g], self.gauges[younger][g]);
                *out = before + share * (after - before) - self.gauges[self.newest][g];
            }
        }
        out
    }
";

const RUST: &str = "
        for (lag, lag_secs) in LAG_SECS.iter().enumerate() {
            let lagged = self.lagged(lag, *lag_secs);
            row[next..next + GAUGES].copy_from_slice(&lagged);
            next += GAUGES;
        }
";

const PYTHON_FUNCTIONS: &str = "
    def _lagged(self, lag_secs, present):
        \"\"\"Interpolated gauges at this age; the present gauges if no sample is that old.\"\"\"
        younger = np.searchsorted(self.times[: self.kept], self.time - lag_secs, side=\"right\")
        while younger < self.kept and self.time - self.times[younger] >= lag_secs:  # rounding
            younger += 1
        while younger > 0 and self.time - self.times[younger - 1] < lag_secs:
            younger -= 1
        if younger == 0 or younger == self.kept:
            return present
        start, end = self.times[younger - 1], self.times[younger]
        before, after = self.gauges[younger - 1], self.gauges[younger]
        return before + ((self.time - start) - lag_secs) / (end - start) * (after - before)
";

const PYTHON: &str = "
        for lag_secs in LAG_SECS:
            row.append(self._lagged(lag_secs, present) - present)
";

const MATLAB_FUNCTIONS: &str = "
function gauges = {{ prefix }}_lagged(state, lag_secs, present)
% Interpolated gauges at this age; the present gauges if no sample is that old.
% Bisection: sample `near` is younger than the lag, sample `far` is not. Samples are counted from the newest.
near = -1;
far = state.kept;
while far - near > 1
    middle = floor((near + far) / 2);
    if state.time - state.times({{ prefix }}_slot(state, middle)) < lag_secs
        near = middle;
    else
        far = middle;
    end
end
gauges = present;
if near >= 0 && far < state.kept
    older = {{ prefix }}_slot(state, far);
    next = {{ prefix }}_slot(state, near);
    start = state.times(older);
    share = ((state.time - start) - lag_secs) / (state.times(next) - start);
    gauges = state.gauges(:, older) + share * (state.gauges(:, next) - state.gauges(:, older));
end
end
";

const MATLAB: &str = "
for at = 1:{{ sets }}
    row(next + (1:{{ n_gauges }})) = {{ prefix }}_lagged(state, c.lag_secs(at), present) - present;
    next = next + {{ n_gauges }};
end
";

/// Samples stored for the lags, up to the longest lag.
#[derive(Clone, Debug)]
struct Lags {
    lags_secs: Vec<f64>,
    times: VecDeque<f64>,
    gauges: VecDeque<f64>,
    /// For each lag, the index of the oldest stored sample whose age is below the lag.
    younger: Vec<usize>,
    kept: Kept,
}

impl Lags {
    fn new(lags_secs: &[f64], step_secs: f64) -> Self {
        Self {
            lags_secs: lags_secs.to_vec(),
            times: VecDeque::new(),
            gauges: VecDeque::new(),
            younger: vec![0; lags_secs.len()],
            kept: Kept::new(step_secs),
        }
    }
}

impl Stream for Lags {
    fn step(&mut self, time: f64, gauges: &[f64], _: &[f64], out: &mut [f64]) {
        let g = gauges.len();
        if !self.kept.newest {
            self.times.pop_back();
            self.gauges.truncate(self.gauges.len() - g);
        }
        self.kept.take(time);
        self.times.push_back(time);
        self.gauges.extend(gauges);
        for (at, (lag, out)) in self.lags_secs.iter().zip(out.chunks_exact_mut(g)).enumerate() {
            let younger = &mut self.younger[at];
            while time - self.times[*younger] >= *lag && *younger + 1 < self.times.len() {
                *younger += 1; // ends at the present sample, whose age is zero
            }
            let Some(older) = younger.checked_sub(1) else {
                out.copy_from_slice(gauges);
                continue;
            };
            let (start, end) = (self.times[older], self.times[*younger]);
            let share = if end > start { ((time - start) - lag) / (end - start) } else { 1.0 };
            for (gauge, out) in out.iter_mut().enumerate() {
                let before = self.gauges[older * g + gauge];
                let after = self.gauges[*younger * g + gauge];
                *out = before + share * (after - before);
            }
        }
        // One sample older than the longest lag is kept, because the next interpolation needs it.
        let unused = self.younger.iter().copied().min().unwrap_or(0);
        for _ in 1..unused {
            self.times.pop_front();
            self.gauges.drain(..g);
            self.younger.iter_mut().for_each(|younger| *younger -= 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a ramp of 1 per second, the value half a second ago is smaller by 0.5. Before that there is no past.
    #[test]
    fn a_ramp_is_interpolated_between_samples() {
        let mut lag = Lags::new(&[0.5, 3.0], 0.0);
        for k in 0..20 {
            let time = 0.3 * f64::from(k);
            let mut out = [0.0; 2];
            lag.step(time, &[time], &[], &mut out);
            for (value, lag) in out.iter().zip([0.5, 3.0]) {
                let expected = if time >= lag { time - lag } else { time };
                assert!((value - expected).abs() < 1e-12, "{time} s: {out:?}");
            }
        }
        assert!(lag.times.len() < 13, "kept {}", lag.times.len());
    }

    /// If samples come faster than the history step, the lag uses the kept samples and the newest sample.
    #[test]
    fn fast_samples_are_thinned() {
        let mut lag = Lags::new(&[0.5], 0.1);
        for k in 0..2000 {
            let time = 0.001 * f64::from(k);
            let mut out = [0.0];
            lag.step(time, &[time], &[], &mut out);
            let expected = if time >= 0.5 { time - 0.5 } else { time };
            assert!((out[0] - expected).abs() < 1e-9, "{time} s: {out:?}");
            assert!(lag.times.len() < 10);
        }
    }

    #[test]
    fn repeated_times_cause_no_division_by_zero() {
        let mut lag = Lags::new(&[0.1], 0.0);
        let mut out = [0.0];
        for (time, gauge) in [(0.0, 1.0), (0.0, 2.0), (0.0, 3.0), (0.2, 4.0), (0.2, 5.0)] {
            lag.step(time, &[gauge], &[], &mut out);
            assert!(out[0].is_finite());
        }
    }
}
