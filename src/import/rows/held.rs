//! Fills in the values of auxiliary channels that do not have a value in every row.

use super::*;

impl Rows {
    /// Replaces each missing value of an auxiliary channel by the previous value of the channel, or by its first value if
    /// there is none before. Channels without any value are reported and removed.
    pub fn hold_auxiliary(&mut self, plan: &mut Plan, gap_secs: Option<f64>) {
        let n = plan.auxiliary.names.len();
        let known = |channel: usize| {
            let mut values = self.auxiliary.iter().skip(channel).step_by(n);
            values.any(|value| value.is_finite())
        };
        let is_kept: Vec<bool> = (0..n).map(known).collect();
        for (name, _) in plan.auxiliary.names.iter().zip(&is_kept).filter(|(_, is_kept)| !**is_kept)
        {
            let names = vec![name.clone()];
            self.findings.note(plan.line, Cause::IgnoredColumns { names });
        }
        keep(&mut self.auxiliary, &is_kept);
        keep(&mut plan.auxiliary.names, &is_kept);
        keep(&mut plan.auxiliary.units, &is_kept);
        let n = plan.auxiliary.names.len();
        for channel in 0..n {
            self.note_held(channel, plan, gap_secs);
            let mut values = self.auxiliary.iter().skip(channel).step_by(n).copied();
            let mut last = values.find(|value| value.is_finite()).unwrap_or_default();
            for value in self.auxiliary.iter_mut().skip(channel).step_by(n) {
                if value.is_finite() { last = *value } else { *value = last }
            }
        }
    }

    /// Reports the rows in which an auxiliary channel has no value. A channel that is sampled slowly has values only in some
    /// rows. So its rows are reported only if it has no value for longer than a pause.
    fn note_held(&mut self, channel: usize, plan: &Plan, gap_secs: Option<f64>) {
        let n_channels = plan.auxiliary.names.len();
        let is_known = |row: usize| self.auxiliary[row * n_channels + channel].is_finite();
        let (known, missing): (Vec<usize>, Vec<usize>) =
            (0..self.times.len()).partition(|row| is_known(*row));
        if missing.is_empty() {
            return;
        }
        let gap_of_rows = gap_secs.unwrap_or_else(|| gap_by_steps(&self.times));
        let at: Vec<f64> = known.iter().map(|row| self.times[*row]).collect();
        // If the channel is sampled more slowly than the gauges, only longer times without a value are reported.
        let gap = gap_of_rows.max(steps_of_a_pause(&at));
        let [step, own] = [&self.times, &at].map(|times| median_step(times).unwrap_or(0.0));
        let is_now_and_then = own > 1.5 * step;
        // Pauses between recordings do not count as time without a value.
        let within = |row: usize| Some(self.times[row] - self.times[row.checked_sub(1)?]);
        let secs_of = |rows: &Range<usize>| {
            let steps = (rows.start..(rows.end + 1).min(self.times.len())).filter_map(within);
            steps.filter(|step| (0.0..=gap_of_rows).contains(step)).sum::<f64>()
        };
        let runs = missing.chunk_by(|a, b| a + 1 == *b).map(|run| {
            let rows = run[0]..run[run.len() - 1] + 1;
            let secs = secs_of(&rows);
            (rows, secs)
        });
        let runs: Vec<(Range<usize>, f64)> = runs.collect();
        let reported: Vec<&(Range<usize>, f64)> = (runs.iter())
            .filter(|(_, secs)| plan.is_static || !is_now_and_then || *secs > gap)
            .collect();
        let (Some((first, _)), Some((last, _))) = (reported.first(), reported.last()) else {
            return;
        };
        let secs = reported.iter().map(|(_, secs)| *secs).fold(0.0, f64::max);
        let cause = Cause::HeldAuxiliary {
            name: plan.auxiliary.names[channel].clone(),
            n_rows: reported.iter().map(|(rows, _)| rows.len()).sum(),
            longest_secs: (!plan.is_static).then_some(secs),
        };
        let (first, last) = (first.start, last.end - 1);
        let long = runs.iter().filter(|(_, secs)| !plan.is_static && *secs > gap);
        let held = long.map(|(rows, _)| HeldRows { channel, rows: rows.clone() });
        self.held.extend(held);
        self.note_rows(first, last, 1, cause);
    }
}

/// Keeps only some columns of a table. The table holds the values of the rows, one row after another.
fn keep<T>(table: &mut Vec<T>, is_kept: &[bool]) {
    let mut columns = is_kept.iter().cycle();
    table.retain(|_| columns.next() == Some(&true));
}
