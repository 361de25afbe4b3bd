//! Finds axes whose reference is clipped: the recorded load stays at a limit while the gauges rise further.

use crate::{
    finding::{Finding, Id, Verdict},
    recording::Recording,
    scoring::{
        numbers::{percent, significant},
        rig::{
            Rig,
            fits::{self, Shape},
            units,
        },
    },
    shown::counted,
};

use Verdict::Doubtful;

/// Minimum rise of the load that the gauges predict while the reference stays at its maximum, for a report that it is
/// clipped. The mean rise is multiplied by the root of the number of such stays and divided by the error of the fit. Without
/// clipping, this number has the mean −0.8 and the standard deviation 1.2, so it exceeds 3 once in a thousand cases.
const RISES: f64 = 3.0;
/// Minimum mean excess of the predicted over the recorded load where the recorded load is at its maximum, for a report that
/// it is clipped. It is divided by the RMS error of the other samples. An error that is a cubic of the load is √7 = 2.65
/// times its RMS at the end of the range. Hysteresis causes up to 0.9.
const BEYOND: f64 = 2.65;

impl Rig {
    /// Returns findings of axes whose reference load is clipped: it stays at its maximum while the gauges rise and fall again.
    pub fn clipped_reference(&self, recordings: &[&Recording]) -> Vec<Finding> {
        let shape = &self.shape;
        let back = fits::backward(&self.total(|_| true), shape);
        let mut found = Vec::new();
        for (at, axis) in shape.axes.iter().enumerate() {
            // Recorded and predicted loads as shares of full scale. Load cases have no order, so they show no rise.
            let traces = recordings.iter().filter(|own| !own.is_static());
            let traces: Vec<Vec<(f64, f64)>> =
                traces.map(|own| self.shown(own, at, back.row(at)).collect()).collect();
            let all = || traces.iter().flatten();
            let n = all().count().max(1) as f64;
            let mean = all().map(|(load, shown)| shown - load).sum::<f64>() / n;
            let squares = all().map(|(load, shown)| (shown - load - mean).powi(2)).sum::<f64>();
            let error = (squares / n).sqrt();
            let mut loads: Vec<f64> = all().map(|own| own.0).collect();
            loads.sort_unstable_by(f64::total_cmp);
            let steps = loads.windows(2).map(|own| own[1] - own[0]).filter(|step| *step > 0.0);
            let resolution = steps.fold(f64::INFINITY, f64::min);
            for outward in [-1.0, 1.0] {
                let end = all().map(|own| outward * own.0).fold(f64::NEG_INFINITY, f64::max);
                let stays = traces.iter().flat_map(|own| own.chunk_by(|a, b| a.0 == b.0));
                let at_end = stays.filter(|stay| stay.len() > 2 && outward * stay[0].0 == end);
                let rises: Vec<f64> = at_end.map(|stay| rise(stay, outward)).collect();
                let rise = rises.iter().sum::<f64>() / rises.len().max(1) as f64;
                if rise * (rises.len() as f64).sqrt() <= RISES * error || rise <= resolution {
                    continue;
                }
                let (excess, error) = self.excess(recordings, at, outward * end);
                if outward * excess > BEYOND * error {
                    let load = significant(outward * end * shape.full_scale[at], 4);
                    let seen = format!(
                        "the reference of {} seems clipped: it stays at {load} {} while the gauges rise further",
                        axis.symbol(),
                        axis.unit()
                    );
                    let figures = format!(
                        "this happens {}, and the gauges rise further by {} of full scale on average",
                        counted(rises.len(), "time"),
                        percent(excess.abs())
                    );
                    let found_here = Finding::new(Id::ReferenceClipped, Doubtful, seen);
                    found.push(found_here.with(figures).costing(excess.abs()));
                }
            }
        }
        found
    }

    /// Returns the mean excess of the predicted over the recorded load where the recorded load is `end`, and the RMS error
    /// of the other samples. The prediction from the gauges, their squares and cubes is fitted to the other samples.
    fn excess(&self, recordings: &[&Recording], axis: usize, end: f64) -> (f64, f64) {
        let shape = Shape { n_gauges: 3 * self.shape.n_gauges, ..self.shape.clone() };
        let column = shape.axes_in(recordings[0])[axis];
        let sums_of = |wanted: bool| {
            let is_used = |own: usize, k: usize| {
                let own = recordings[own];
                let load = own.loads()[k * own.axes().len() + column];
                (load / shape.full_scale[axis] == end) == wanted
            };
            let powers = |gauges: &[f64], row: &mut Vec<f64>| {
                let all =
                    (1..=3).flat_map(|power| self.standard(gauges).map(move |own| own.powi(power)));
                row.extend(all);
            };
            fits::sum(units(recordings, &self.runs, &shape, powers, is_used).iter(), &shape)
        };
        fits::excess(&sums_of(false), &sums_of(true), axis, &shape)
    }

    /// Returns for each sample the load of an axis and its prediction from the gauges, as shares of full scale.
    fn shown(
        &self,
        of: &Recording,
        axis: usize,
        back: faer::RowRef<'_, f64>,
    ) -> impl Iterator<Item = (f64, f64)> {
        let at = self.shape.axes_in(of)[axis];
        let rows = of.gauges().chunks_exact(self.shape.n_gauges);
        let loads = of.loads()[at..].iter().step_by(of.axes().len());
        loads.zip(rows).map(move |(load, row)| {
            let shown = self.standard(row).enumerate().map(|(at, own)| back[at] * own);
            (load / self.shape.full_scale[axis], shown.sum())
        })
    }
}

/// Returns the mean predicted load of the middle half of a stay, minus the larger of the first and the last one. For noise
/// alone, this is negative.
fn rise(stay: &[(f64, f64)], outward: f64) -> f64 {
    let n = stay.len();
    let skipped = (n / 4).max(1);
    let inner = &stay[skipped..n - skipped];
    let mean = inner.iter().map(|own| outward * own.1).sum::<f64>() / inner.len() as f64;
    mean - (outward * stay[0].1).max(outward * stay[n - 1].1)
}
