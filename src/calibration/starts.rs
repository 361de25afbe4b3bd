//! Measures how much the computed loads change if the robot is switched on some samples later.

use crate::{
    calibration::{calibration::Calibration, estimator::Estimator},
    recording::Recording,
};

/// Returns the root mean square difference per axis between the loads of runs that start at different samples of a
/// recording, once both runs have a full history. A history that stores fewer samples than the recordings have stores
/// other samples in each run. Returns `None` if the history stores all samples, or the recordings are too short.
pub(crate) fn scatter_of_starts<'a>(
    calibration: &Calibration,
    recordings: impl Iterator<Item = &'a Recording>,
) -> Option<Vec<f64>> {
    /// Starts of the later runs, as shares of the time between two stored samples.
    const STARTS: [f64; 3] = [0.25, 0.5, 0.75];
    /// Maximum number of samples that are compared.
    const MOST_SAMPLES: usize = 100_000;
    let is_coarse =
        calibration.rate_hz.is_some_and(|rate_hz| calibration.history_step_secs * rate_hz > 1.0);
    if !is_coarse || !calibration.features.has_history() {
        return None;
    }
    let design = calibration.design();
    let (mut squares, mut n) = (vec![0.0; calibration.axes.len()], 0);
    let runs = recordings.flat_map(|recording| STARTS.map(|start| (recording, start)));
    for (recording, start) in runs {
        let recording = recording.decimated(calibration.decimation);
        let recording = calibration.prepared(&recording).ok()?;
        let times = recording.times();
        let start_secs = times.first()? + start * calibration.history_step_secs;
        let full_secs = start_secs + calibration.features.window_secs();
        let mut whole_run = Estimator::new(calibration, &design).ok()?;
        let mut later_run = Estimator::new(calibration, &design).ok()?;
        for (k, time) in times.iter().enumerate() {
            let whole = whole_run.update_at(&recording, k);
            if *time < start_secs {
                continue;
            }
            let later = later_run.update_at(&recording, k);
            if let (Ok((_, whole)), Ok((_, later))) = (whole, later)
                && *time > full_secs
            {
                let pairs = whole.iter().zip(later).zip(&mut squares);
                pairs.for_each(|((whole, later), sum)| *sum += (whole - later).powi(2));
                n += 1;
            }
        }
        if n > MOST_SAMPLES {
            break;
        }
    }
    (n > 0).then(|| squares.iter().map(|sum| (sum / n as f64).sqrt()).collect())
}
