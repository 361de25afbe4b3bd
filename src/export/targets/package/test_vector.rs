//! Test samples that cover all situations of a calibration, with the loads that this program's own estimator computes.
//!
//! Guarantees: gauges move as under loads within full scale, and stay within their range in the training recordings. Gauges
//! are single-precision numbers, and times are multiples of 0.1 ms. So code in single precision or with a clock in ticks gets
//! exactly this input.

use std::f64::consts::TAU;

use crate::calibration::{Calibration, CalibrationError, Estimator};

/// Time (s), gauges and auxiliary channels of a test sample.
pub(super) type Sample = (f64, Vec<f64>, Vec<f64>);

#[derive(Clone, Debug)]
pub(super) struct Answered {
    pub sample: Sample,
    pub load: Vec<f64>,
    pub conventional: Vec<f64>,
    /// Status flags of the sample, with the numbers that exported code uses.
    pub status: u8,
    /// True if a slightly different threshold or clock gives another load or status, so that self-tests skip the load of this
    /// sample.
    pub at_edge: bool,
}

/// Sample rate of the test samples if the sample rate of the recordings is unknown (Hz).
const USUAL_RATE_HZ: f64 = 20.0;
/// Largest load in the test samples, as a share of full scale.
const SHARE_OF_FULL_SCALE: f64 = 0.8;
/// Largest difference of a gauge from its mean in the test samples, in standard deviations of that gauge in the training
/// recordings.
const DEVIATIONS: f64 = 2.0;
/// Number of samples of each fast motion. One fast motion comes before the slow motion, and one after it.
const FAST: usize = 100;
const SLOW: usize = 500;
/// Number of samples of the slow load cycle that cover the time which look-back, lags and creep need after a start. It
/// determines the sample interval of the slow load cycle.
const SLOW_PER_WINDOW: f64 = 300.0;

pub(super) fn test_vector(calibration: &Calibration) -> Result<Vec<Answered>, CalibrationError> {
    let samples = samples(calibration);
    let mut rows = answered(calibration, &samples, 1.0)?;
    let scale = full_scale(calibration);
    let weights = calibration.distance_weights();
    let largest = weights.iter().zip(&scale).map(|(w, s)| (w * s).powi(2)).sum::<f64>().sqrt();
    let with_thresholds = |side: f64| {
        let mut other = calibration.clone();
        for look_back in &mut other.features.look_backs {
            look_back.f_th += side * (1e-3 * look_back.f_th + 1e-5 * largest).min(look_back.f_th);
        }
        other
    };
    let (lower, higher) = (with_thresholds(-1.0), with_thresholds(1.0));
    for (calibration, clock) in
        [(&lower, 1.0), (&higher, 1.0), (calibration, 1.0 - 1e-6), (calibration, 1.0 + 1e-6)]
    {
        for (row, other) in rows.iter_mut().zip(answered(calibration, &samples, clock)?) {
            let mut apart = row.load.iter().zip(&other.load).zip(&scale);
            let is_far = apart.any(|((a, b), scale)| (a - b).abs() > 1e-5 * scale);
            row.at_edge |= is_far || row.status != other.status;
        }
    }
    Ok(rows)
}

/// Returns the full scale of each axis, or 1 if it is unknown. Errors are divided by it.
pub(super) fn full_scale(calibration: &Calibration) -> Vec<f64> {
    let scale = calibration.full_scale.iter();
    scale.map(|scale| if *scale > 0.0 { *scale } else { 1.0 }).collect()
}

fn answered(
    calibration: &Calibration,
    samples: &[Sample],
    clock: f64,
) -> Result<Vec<Answered>, CalibrationError> {
    let design = calibration.design();
    let mut estimator = Estimator::new(calibration, &design)?;
    let rows = samples.iter().map(|sample| {
        let (load, status) = match estimator.update_with(clock * sample.0, &sample.1, &sample.2) {
            Ok((status, load)) => (load.to_vec(), status),
            Err(error) => (vec![f64::NAN; calibration.axes.len()], error.status()),
        };
        Answered {
            sample: sample.clone(),
            load,
            conventional: estimator.conventional().to_vec(),
            status: status.bits(),
            at_edge: false,
        }
    });
    Ok(rows.collect())
}

/// Returns the test samples: fast and slow motions, gauges that are not numbers, late and early times, a pause, and a reset
/// clock.
fn samples(calibration: &Calibration) -> Vec<Sample> {
    let rate_hz = calibration.rate_hz.unwrap_or(USUAL_RATE_HZ);
    let fast_secs = (1.0 / rate_hz).max(1e-3);
    let gap_secs = calibration.gap_secs;
    let slow_secs = calibration.features.settling_secs() / SLOW_PER_WINDOW;
    let slow_secs = slow_secs.min(0.4 * gap_secs).max(fast_secs);
    let gauges_at = motion(calibration);
    let mut samples: Vec<Sample> = Vec::new();
    let (mut time, mut fast) = (12.5, 0.0);
    for k in 0..FAST + SLOW + FAST {
        let is_fast = !(FAST..FAST + SLOW).contains(&k);
        // Sample intervals vary by this factor, as with real clocks; its mean is one.
        let uneven = 1.0 + 0.3 * (2.4 * k as f64).sin();
        time += uneven * if is_fast { fast_secs } else { slow_secs };
        if k == FAST + SLOW {
            time += 1.5 * gap_secs + 1.0;
        }
        fast += if is_fast { 1.0 / 23.0 } else { 0.0 };
        let slow = k as f64 / SLOW as f64;
        let auxiliary = calibration.features.auxiliary.iter();
        // The auxiliary channel goes a little beyond its range in the training recordings, to test the warning.
        let auxiliary = auxiliary.map(|channel| {
            let middle = 0.5 * (channel.min + channel.max);
            let moved = 0.65 * (channel.max - channel.min) * (TAU * 1.7 * slow).sin();
            f64::from((middle + moved) as f32)
        });
        samples.push((time, gauges_at(slow, fast), auxiliary.collect()));
    }
    let set_anew = samples[samples.len() - 60..].to_vec();
    let start = set_anew[0].0 - 3.0;
    samples.extend(
        set_anew.into_iter().map(|(time, gauges, auxiliary)| (time - start, gauges, auxiliary)),
    );
    samples[40].1[0] = f64::NAN;
    let last = samples[41].1.len() - 1;
    samples[41].1[last] = f64::INFINITY;
    if let Some(last) = samples[43].2.last_mut() {
        *last = f64::NAN;
    }
    samples[60].0 = samples[50].0;
    samples[70].0 = samples[69].0;
    samples[80].0 += 1e9;
    samples[FAST + 40].0 = samples[FAST + 41].0;
    for (time, ..) in &mut samples {
        *time = (*time * 1e4).round() / 1e4;
    }
    samples
}

/// Returns a function from the phases of a slow and a fast motion to gauges. The gauges move as under loads, in which each
/// axis moves at its own rate.
fn motion(calibration: &Calibration) -> impl Fn(f64, f64) -> Vec<f64> {
    let full_scale = full_scale(calibration);
    let gauges = 0..calibration.gauges.len();
    // Change of each gauge at full scale of each axis, in standard deviations of the gauge.
    let slopes: Vec<Vec<f64>> = match calibration.gauges_per_load() {
        // If the calibration gives no map from loads to gauges, each gauge moves by its own amount.
        None => gauges.map(|gauge| vec![DEVIATIONS * 0.5f64.powi(gauge as i32 % 3)]).collect(),
        Some(slopes) => gauges
            .map(|gauge| {
                full_scale
                    .iter()
                    .enumerate()
                    .map(|(axis, scale)| slopes[(gauge, axis)] * scale)
                    .collect()
            })
            .collect(),
    };
    let reach = slopes.iter().map(|row| row.iter().map(|slope| slope.abs()).sum());
    let reach: f64 = reach.fold(f64::MIN_POSITIVE, f64::max);
    let factor = SHARE_OF_FULL_SCALE.min(DEVIATIONS / reach);
    let scale = &calibration.gauge_scale;
    move |slow, fast| {
        slopes
            .iter()
            .zip(&scale.shift)
            .zip(&scale.deviation)
            .map(|((slopes, shift), deviation)| {
                let moved = slopes.iter().enumerate().map(|(axis, slope)| {
                    let pace = 1.0 + 0.37 * axis as f64;
                    let load = 0.7 * (TAU * pace * slow).sin() + 0.3 * (TAU * pace * fast).sin();
                    slope * load
                });
                let moved = factor * moved.sum::<f64>();
                f64::from((shift + deviation * moved) as f32)
            })
            .collect()
    }
}
