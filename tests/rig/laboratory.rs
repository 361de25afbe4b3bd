//! Recordings without a fault, as common procedures in a laboratory give them: one axis after the other, dead weights, rests, and a
//! reference that is rounded, noisy or read less often than the gauges.

use std::f64::consts::TAU;

use loopscope::recording::Axis;

use super::simulator::{Dice, Programme, Run, Set};

/// Radii of the play operators that make the hysteresis, as shares of the largest load.
const RADII: [f64; 3] = [0.05, 0.15, 0.3];

#[derive(Clone, Copy)]
enum Procedure {
    /// Steady ramps on one axis in each recording.
    Ramps,
    /// Dead weights on one axis in each recording, added and taken off one by one.
    Weights,
    /// Sines on all axes.
    Sines,
    /// Sines on all axes, with rests between them.
    Rests,
}

const PROCEDURES: [Procedure; 4] =
    [Procedure::Ramps, Procedure::Weights, Procedure::Sines, Procedure::Rests];

/// Returns the loads of a recording, one row per sample, from −1 to 1 on each axis.
fn loads(
    dice: &mut Dice,
    kind: Procedure,
    (n, n_axes): (usize, usize),
    run: usize,
) -> Vec<Vec<f64>> {
    let (cycles, sign) = (dice.between(3.0, 8.0), if dice.unit() < 0.5 { 1.0 } else { -1.0 });
    let waves: Vec<[f64; 2]> =
        (0..n_axes).map(|_| [dice.between(2.0, 9.0), dice.between(0.0, TAU)]).collect();
    let value = |k: usize, axis: usize| {
        let at = k as f64 / n as f64;
        let up_and_down = 1.0 - (2.0 * (cycles * at).fract() - 1.0).abs();
        let sine = |own: &[f64; 2]| (TAU * own[0] * at + own[1]).sin();
        match kind {
            Procedure::Ramps if axis == run % n_axes => 2.0 * up_and_down - 1.0,
            Procedure::Weights if axis == run % n_axes => sign * (5.0 * up_and_down).round() / 5.0,
            Procedure::Ramps | Procedure::Weights => 0.0,
            Procedure::Sines => sine(&waves[axis]),
            Procedure::Rests => sine(&waves[axis]) * (2.0 * (TAU * 3.0 * at).sin()).clamp(0.0, 1.0),
        }
    };
    (0..n).map(|k| (0..n_axes).map(|axis| value(k, axis)).collect()).collect()
}

/// Returns a set without faults.
pub fn sound(seed: u64) -> Set {
    let mut dice = Dice::new(seed);
    let pick = |dice: &mut Dice, of: &[f64]| of[dice.below(of.len())];
    let n_axes = [1, 2, 3, 3, 6, 6][dice.below(6)];
    let n_gauges = n_axes + dice.below(4);
    let n_runs = 2 + dice.below(7);
    let kind = PROCEDURES[dice.below(4)];
    let hysteresis = pick(&mut dice, &[0.0, 0.01, 0.03, 0.1]);
    let noise = pick(&mut dice, &[0.0003, 0.001, 0.004, 0.01]);
    let (rate_hz, n) = (pick(&mut dice, &[20.0, 50.0, 100.0]), 600 + dice.below(1400));
    // The reference: its step, its noise, and the number of samples for which each of its values is repeated.
    let (step, reference_noise) =
        (pick(&mut dice, &[1e-6, 0.001, 0.005, 0.01]), pick(&mut dice, &[0.0, 0.0005, 0.002]));
    let repeated = [1, 1, 5][dice.below(3)];
    let axes = Axis::ALL[..n_axes].to_vec();
    let full_scale: Vec<f64> =
        axes.iter().map(|axis| if axis.is_force() { 100.0 } else { 5.0 }).collect();
    let slope = |dice: &mut Dice, gauge: usize, axis: usize| {
        dice.normal() + if gauge == axis { 2.5 } else { 0.0 }
    };
    let slopes: Vec<Vec<f64>> = (0..n_gauges)
        .map(|gauge| (0..n_axes).map(|axis| slope(&mut dice, gauge, axis)).collect())
        .collect();
    let span: Vec<f64> =
        slopes.iter().map(|own| 2.0 * own.iter().map(|slope| slope.abs()).sum::<f64>()).collect();
    let mut runs = Vec::new();
    for run in 0..n_runs {
        let loads = loads(&mut dice, kind, (n, n_axes), run);
        let mut plays = vec![[0.0_f64; 3]; n_axes];
        let (mut gauges, mut reference) = (Vec::new(), Vec::<Vec<f64>>::new());
        for (k, load) in loads.iter().enumerate() {
            let mut felt = load.clone();
            for ((own, load), plays) in felt.iter_mut().zip(load).zip(&mut plays) {
                for (play, radius) in plays.iter_mut().zip(RADII) {
                    *play = play.clamp(load - radius, load + radius);
                    *own += hysteresis * 2.0 / 3.0 * *play;
                }
            }
            let gauge = |own: &Vec<f64>| -> f64 {
                0.5 + own.iter().zip(&felt).map(|(slope, load)| slope * load).sum::<f64>()
            };
            gauges
                .push(slopes.iter().map(|own| gauge(own) + 2.0 * noise * dice.normal()).collect());
            let read = |(load, full_scale): (&f64, &f64)| {
                ((load + reference_noise * dice.normal()) / step).round() * step * full_scale
            };
            let row = match k % repeated {
                0 => load.iter().zip(&full_scale).map(read).collect(),
                _ => reference[k - 1].clone(),
            };
            reference.push(row);
        }
        runs.push(Run {
            programme: Programme::Ramps,
            times: (0..n).map(|k| k as f64 / rate_hz).collect(),
            gauges,
            loads: reference,
        });
    }
    Set { seed, axes, full_scale, n_gauges, hysteresis, noise, span, runs }
}
