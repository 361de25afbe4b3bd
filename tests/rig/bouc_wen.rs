//! Recordings without faults from a second simulator. No limit of the check was chosen on these recordings. Each axis has Bouc-Wen
//! hysteresis and creep. Gauges are curved, noise is coloured, the converter has 14 bits, and the load programmes are different.

use std::f64::consts::TAU;

use loopscope::recording::Axis;

use crate::simulator::{Dice, PROGRAMMES, Programme, Run, Set};

/// Returns the loads of one recording, one row per sample. The largest load of each axis is about 1.
fn programme(dice: &mut Dice, kind: Programme, n_axes: usize, rate: f64) -> Vec<Vec<f64>> {
    let reach = dice.between(0.7, 1.0);
    let n = (dice.between(40.0, 120.0) * rate) as usize;
    let row = |of: &mut dyn FnMut(usize) -> f64| (0..n_axes).map(|axis| reach * of(axis)).collect();
    match kind {
        // Three masses hang from the sensor in random orientations.
        Programme::Poses => {
            let mut pose = || {
                let way: Vec<f64> = (0..n_axes).map(|_| dice.normal()).collect();
                let length = way.iter().map(|own| own * own).sum::<f64>().sqrt();
                let mass = [0.3, 0.6, 1.0][dice.below(3)];
                row(&mut |axis| mass * way[axis] / length)
            };
            (0..60).map(|_| pose()).collect()
        }
        // One axis after the other moves up and down, while the other axes are held.
        Programme::Steps => {
            let (every, mut held) = ((6.0 * rate) as usize, vec![0.0; n_axes]);
            let mut at = |k: usize| {
                let moves = k / every % n_axes;
                let part = (k % every) as f64 / every as f64;
                if k.is_multiple_of(every) {
                    held[moves] = dice.between(-0.7, 0.7);
                }
                row(&mut |axis| {
                    held[axis] + if axis == moves { 0.9 * (TAU * part).sin() } else { 0.0 }
                })
            };
            (0..n).map(&mut at).collect()
        }
        // All axes go through cycles of growing size.
        Programme::Ramps => {
            let hz: Vec<f64> = (0..n_axes).map(|_| dice.between(0.08, 0.3)).collect();
            let at = |k: usize| {
                let (time, grown) = (k as f64 / rate, (k + 1) as f64 / n as f64);
                row(&mut |axis| grown.sqrt() * (TAU * hz[axis] * time + axis as f64).sin())
            };
            (0..n).map(at).collect()
        }
        // A hand pushes and pulls the sensor.
        Programme::Random => {
            let mut states = vec![[0.0_f64; 2]; n_axes];
            let mut at = |_| {
                row(&mut |axis| {
                    let [slow, own] = &mut states[axis];
                    *slow += -*slow / rate + 0.9 * dice.normal() / rate.sqrt();
                    *own += 2.0 * (*slow - *own) / rate;
                    own.tanh()
                })
            };
            (0..n).map(&mut at).collect()
        }
    }
}

/// Returns a set of recordings without faults, with the same ranges of sizes as the first simulator.
pub fn sound(seed: u64, fewest_runs: usize) -> Set {
    let mut dice = Dice::new(seed + 77_000);
    let n_runs = (1 + dice.below(8)).max(fewest_runs);
    let n_axes = 1 + dice.below(6);
    let n_gauges = n_axes + dice.below(5);
    let hysteresis = 0.1 * dice.unit().powi(2);
    let noise = 0.0005 * 20.0_f64.powf(dice.unit());
    let rate = [10.0, 25.0, 50.0][dice.below(3)];
    let axes = Axis::ALL[if n_axes > 3 { 0 } else { dice.below(7 - n_axes) }..][..n_axes].to_vec();
    let full_scale: Vec<f64> =
        axes.iter().map(|axis| if axis.is_force() { 500.0 } else { 20.0 }).collect();
    // Every gauge responds to every axis.
    let slopes: Vec<Vec<f64>> =
        (0..n_gauges).map(|_| (0..n_axes).map(|_| dice.normal()).collect()).collect();
    let span: Vec<f64> =
        slopes.iter().map(|own| own.iter().map(|slope| slope.abs()).sum()).collect();
    let zeros: Vec<f64> = span.iter().map(|span| span * dice.normal()).collect();
    let curves: Vec<f64> = span.iter().map(|_| 0.003 * dice.normal()).collect();
    let one_kind = (dice.unit() < 0.7).then(|| PROGRAMMES[dice.below(4)]);
    let yields = dice.between(0.1, 0.5);
    let mut runs = Vec::new();
    for _ in 0..n_runs {
        let kind = one_kind.unwrap_or_else(|| PROGRAMMES[dice.below(4)]);
        let loads = programme(&mut dice, kind, n_axes, rate);
        // State of each axis: last load, hysteresis and creep.
        let mut states = vec![[0.0_f64; 3]; n_axes];
        let mut noises = vec![0.0; n_gauges];
        let mut gauges = Vec::new();
        for load in &loads {
            let strains = load.iter().zip(&mut states).map(|(load, [last, bent, crept])| {
                for _ in 0..8 {
                    let step = (load - *last) / 8.0 / yields;
                    *bent += step * (1.0 - bent.abs() * if step * *bent > 0.0 { 1.0 } else { 0.0 });
                }
                *last = *load;
                *crept += (load - *crept) / (15.0 * rate);
                load - hysteresis * (*bent - 0.3 * *crept)
            });
            let strains: Vec<f64> = strains.collect();
            let row = (0..n_gauges).map(|gauge| {
                let own = slopes[gauge].iter().zip(&strains);
                let own = own.map(|(slope, strain)| slope * strain).sum::<f64>() / span[gauge];
                noises[gauge] = 0.5 * noises[gauge] + 0.87 * noise * dice.normal();
                let value = own + curves[gauge] * own.powi(3) + noises[gauge];
                zeros[gauge] + span[gauge] * (value * 8192.0).round() / 8192.0
            });
            gauges.push(row.collect());
        }
        let scaled = |load: &Vec<f64>| load.iter().zip(&full_scale).map(|(a, b)| a * b).collect();
        runs.push(Run {
            programme: kind,
            times: (0..loads.len()).map(|k| k as f64 / rate).collect(),
            gauges,
            loads: loads.iter().map(scaled).collect(),
        });
    }
    Set { seed, axes, full_scale, n_gauges, hysteresis, noise, span, runs }
}
