//! Simulates single recordings and tables of load cases whose zero drifts, jumps, or changes with each mounting. Hysteresis is
//! a Dahl friction, creep is that of Kelvin elements.

use loopscope::recording::{Axis, Recording, Source};

use crate::simulator::Dice;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Programme {
    Stairs,
    Ramps,
    Sines,
    Pushes,
    Poses,
    Random,
}

pub const PROGRAMMES: [Programme; 6] = [
    Programme::Stairs,
    Programme::Ramps,
    Programme::Sines,
    Programme::Pushes,
    Programme::Poses,
    Programme::Random,
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zero {
    Sound,
    Drift,
    Jump,
}

/// Order of the loads of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Dead weights on one axis after the other.
    Weights,
    Random,
    UpAndDown,
    Shuffled,
    Rising,
}

pub const ORDERS: [Order; 5] =
    [Order::Weights, Order::Random, Order::UpAndDown, Order::Shuffled, Order::Rising];

/// Rated load of each axis.
pub const FULL_SCALE: f64 = 50.0;

/// What was simulated, as shares of full scale.
#[derive(Clone, Debug)]
pub struct Truth {
    pub size: f64,
    /// Time (s) of a jump, or duration of a drift.
    pub secs: f64,
    /// First rows of the mountings of a table.
    pub starts: Vec<usize>,
}

fn pick<T: Copy>(dice: &mut Dice, of: &[T]) -> T {
    of[dice.below(of.len())]
}

fn loads(dice: &mut Dice, kind: Programme, n: usize, n_axes: usize) -> Vec<Vec<f64>> {
    let low = pick(dice, &[-1.0, 0.0]);
    let mut loads = vec![vec![0.0; n_axes]; n];
    let set = |loads: &mut Vec<Vec<f64>>, held: &[Vec<f64>]| {
        let at = |k: usize| (k * held.len() / n).min(held.len() - 1);
        for (k, row) in loads.iter_mut().enumerate() {
            // A move takes several samples.
            let near = k.saturating_sub(4)..(k + 5).min(n);
            for (axis, own) in row.iter_mut().enumerate() {
                *own = near.clone().map(|k| held[at(k)][axis]).sum::<f64>() / near.len() as f64;
            }
        }
    };
    match kind {
        Programme::Stairs => {
            let steps = 3 + dice.below(5) as i32;
            let mut held = vec![vec![0.0; n_axes]];
            for _ in 0..2 + dice.below(4) {
                for axis in 0..n_axes {
                    let ends = if low < 0.0 { vec![1, -1] } else { vec![1] };
                    for way in ends {
                        for step in (1..=steps).chain((0..steps).rev()) {
                            let mut row = vec![0.0; n_axes];
                            row[axis] = f64::from(way * step) / f64::from(steps);
                            held.push(row);
                        }
                    }
                }
            }
            set(&mut loads, &held);
        }
        Programme::Poses => {
            let rest = vec![0.0; n_axes];
            let mut held = Vec::new();
            for _ in 0..8 + dice.below(25) {
                held.push((0..n_axes).map(|_| dice.between(-1.0, 1.0)).collect());
                held.push(rest.clone());
            }
            set(&mut loads, &held);
        }
        Programme::Pushes => {
            let n_pushes = 8 + dice.below(20);
            let pushes: Vec<(usize, f64)> = (0..n_pushes)
                .map(|_| {
                    (dice.below(n_axes), dice.between(0.3, 1.0) * pick(dice, &[1.0, 1.0, low]))
                })
                .collect();
            for (k, row) in loads.iter_mut().enumerate() {
                let at = k as f64 / n as f64 * n_pushes as f64;
                let (axis, size) = pushes[at as usize];
                let part = (2.0 * at.fract()).min(1.0);
                row[axis] = size * (std::f64::consts::PI * part).sin();
            }
        }
        Programme::Ramps | Programme::Sines | Programme::Random => {
            for axis in 0..n_axes {
                let cycles = 3.0 + dice.below(12) as f64;
                let phase = if n_axes > 1 { dice.unit() } else { 0.0 };
                let other = dice.between(1.3, 4.0);
                for (k, row) in loads.iter_mut().enumerate() {
                    let turns = cycles * k as f64 / n as f64 + phase;
                    let wave = |turns: f64| (std::f64::consts::TAU * turns).sin();
                    row[axis] = match kind {
                        Programme::Ramps => {
                            let up = 1.0 - (2.0 * turns.fract() - 1.0).abs();
                            low + (1.0 - low) * up
                        }
                        Programme::Sines => 0.5 * (1.0 + low + (1.0 - low) * wave(turns)),
                        _ => 0.5 * (wave(turns) + wave(other * turns)),
                    };
                }
            }
        }
    }
    loads
}

/// Returns a random sensitivity of each gauge to each axis.
fn slopes(dice: &mut Dice, n_gauges: usize, n_axes: usize) -> Vec<Vec<f64>> {
    let slope = |dice: &mut Dice, gauge: usize, axis: usize| {
        0.7 * dice.normal() + if gauge == axis { 2.0 } else { 0.0 }
    };
    (0..n_gauges).map(|gauge| (0..n_axes).map(|axis| slope(dice, gauge, axis)).collect()).collect()
}

/// Returns a shift of the gauges that looks like a load of this size, plus a part that no load explains.
fn shift(dice: &mut Dice, slopes: &[Vec<f64>], size: f64) -> Vec<f64> {
    let n_axes = slopes[0].len();
    let load: Vec<f64> = (0..n_axes).map(|_| dice.normal()).collect();
    let length = load.iter().map(|own| own * own).sum::<f64>().sqrt();
    let along = |own: &Vec<f64>| -> f64 {
        own.iter().zip(&load).map(|(slope, load)| slope * load / length * size).sum()
    };
    slopes.iter().map(|own| along(own) + 0.5 * size * dice.normal()).collect()
}

/// Returns a recording with its programme and the truth.
pub fn recording(seed: u64, zero: Zero) -> (Recording, Programme, Truth) {
    let mut dice = Dice::new(seed);
    let programme = PROGRAMMES[seed as usize % PROGRAMMES.len()];
    let n_axes = pick(&mut dice, &[1, 1, 2, 3]);
    let n_gauges = n_axes + dice.below(3);
    let n = 1000 + dice.below(3000);
    let duration = dice.between(60.0, 3000.0);
    let hysteresis = pick(&mut dice, &[0.0, 0.01, 0.03, 0.05]);
    let creeps = pick(&mut dice, &[0.0, 0.0, 0.01, 0.03, 0.05]);
    let noise = pick(&mut dice, &[0.0005, 0.001, 0.003]);
    let curve = pick(&mut dice, &[0.0, 0.0, 0.02]);
    let size = pick(&mut dice, &[0.02, 0.04, 0.08]);
    let seconds = |k: usize| duration * k as f64 / n as f64;
    let loads = loads(&mut dice, programme, n, n_axes);
    let slopes = slopes(&mut dice, n_gauges, n_axes);
    let zeros: Vec<f64> = (0..n_gauges).map(|_| dice.normal()).collect();
    let shift = shift(&mut dice, &slopes, size);
    let jumps = (n as f64 * dice.between(0.2, 0.8)) as usize;
    let slow = duration * 10_f64.powf(dice.between(-1.7, 0.2));
    let mut friction = vec![0.0_f64; n_axes];
    let mut creep = vec![0.0_f64; n_axes];
    let mut gauges = Vec::new();
    for (k, row) in loads.iter().enumerate() {
        let mut felt = row.clone();
        for (axis, own) in felt.iter_mut().enumerate() {
            let load = *own;
            let moved = load - if k > 0 { loads[k - 1][axis] } else { load };
            friction[axis] += moved / 0.3 * (1.0 - moved.signum() * friction[axis]);
            friction[axis] = friction[axis].clamp(-1.0, 1.0);
            creep[axis] += (duration / n as f64 / slow).min(1.0) * (load - creep[axis]);
            *own += curve * load * load - hysteresis * friction[axis] + creeps * creep[axis];
        }
        let part = match zero {
            Zero::Sound => 0.0,
            Zero::Drift => k as f64 / n as f64,
            Zero::Jump => f64::from(u8::from(k >= jumps)),
        };
        for (gauge, own) in slopes.iter().enumerate() {
            let strain: f64 = own.iter().zip(&felt).map(|(slope, load)| slope * load).sum();
            let random = noise * 2.0 * dice.normal();
            gauges.push(zeros[gauge] + strain + part * shift[gauge] + random);
        }
    }
    let scaled = loads.concat().into_iter().map(|load| FULL_SCALE * load).collect();
    let recording = Recording::new(
        format!("{programme:?}"),
        Source::File(format!("{seed}.csv").into()),
        (0..n).map(seconds).collect(),
        (1..=n_gauges).map(|gauge| format!("S{gauge}")).collect(),
        gauges,
        Axis::ALL[..n_axes].to_vec(),
        scaled,
    );
    let secs = if zero == Zero::Jump { seconds(jumps) } else { duration };
    (recording.unwrap(), programme, Truth { size, secs, starts: Vec::new() })
}

/// What is wrong with the rows of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rows {
    Sound,
    MountedAnew,
    /// The zeros drift from row to row.
    Drifting,
    /// The load of one row, see [`mistyped`], is not the one that was applied.
    Mistyped,
}

/// Returns the row of a table that is mistyped, counted from 0.
pub fn mistyped(n_rows: usize) -> usize {
    n_rows / 3
}

/// Returns the load cases of a table, with the order of its loads and the truth.
pub fn table(seed: u64, rows: Rows) -> (Vec<Recording>, Order, Truth) {
    let mut dice = Dice::new(seed);
    let order = ORDERS[seed as usize % ORDERS.len()];
    let n_axes = pick(&mut dice, &[1, 2, 3, 3, 6]);
    let n_gauges = n_axes + dice.below(4);
    let mut loads: Vec<Vec<f64>> = Vec::new();
    let mut starts = vec![0];
    match order {
        Order::Weights => {
            let steps = 4 + dice.below(4);
            for axis in 0..n_axes.max(2) {
                if axis > 0 {
                    starts.push(loads.len());
                }
                let way = pick(&mut dice, &[-1.0, 1.0]);
                for step in 0..=steps {
                    let mut row = vec![0.0; n_axes];
                    row[axis % n_axes] = way * step as f64 / steps as f64;
                    loads.push(row);
                }
            }
        }
        _ => {
            let n = 15 + 4 * n_axes + dice.below(40);
            let cycles = (1 + dice.below(3)) as f64;
            for k in 0..n {
                let turns = k as f64 / n as f64 * cycles;
                let main = match order {
                    Order::Rising => k as f64 / n as f64,
                    Order::Random => dice.between(-1.0, 1.0),
                    _ => 1.0 - (2.0 * turns.fract() - 1.0).abs(),
                };
                let other = |dice: &mut Dice| 0.5 * main + dice.between(-0.5, 0.5);
                let mut row = vec![main];
                row.extend((1..n_axes).map(|_| other(&mut dice)));
                loads.push(row);
            }
            if order == Order::Shuffled {
                (1..n).rev().for_each(|k| loads.swap(k, dice.below(k + 1)));
            }
            let n_mountings = 2 + dice.below(3);
            starts.extend((1..n_mountings).map(|at| n * at / n_mountings));
        }
    }
    let slopes = slopes(&mut dice, n_gauges, n_axes);
    let curve = pick(&mut dice, &[0.0, 0.01, 0.03]);
    let hysteresis = pick(&mut dice, &[0.0, 0.01, 0.02]);
    let noise = pick(&mut dice, &[0.0002, 0.001, 0.002]);
    let size = pick(&mut dice, &[0.02, 0.05, 0.1]);
    let shifts: Vec<Vec<f64>> = starts.iter().map(|_| shift(&mut dice, &slopes, size)).collect();
    let mut friction = vec![0.0_f64; n_axes];
    let mut before = vec![0.0; n_axes];
    let mut cases = Vec::new();
    for (k, row) in loads.iter().enumerate() {
        let mut felt = row.clone();
        for (axis, own) in felt.iter_mut().enumerate() {
            let moved = *own - before[axis];
            friction[axis] = (friction[axis] + moved / 0.3).clamp(-1.0, 1.0);
            *own += curve * *own * own.abs() - hysteresis * friction[axis];
        }
        before.clone_from(row);
        let mounting = starts.iter().rposition(|start| *start <= k).unwrap_or(0);
        let gauges = slopes.iter().enumerate().map(|(gauge, own)| {
            let strain: f64 = own.iter().zip(&felt).map(|(slope, load)| slope * load).sum();
            let zero = match rows {
                Rows::MountedAnew => shifts[mounting][gauge],
                Rows::Drifting => shifts[0][gauge] * k as f64 / loads.len() as f64,
                _ => 0.0,
            };
            1.0 + strain + zero + 2.0 * noise * dice.normal()
        });
        let mut recorded = row.clone();
        if rows == Rows::Mistyped && k == mistyped(loads.len()) {
            recorded[0] += 0.2;
        }
        let case = Recording::new(
            format!("case {}", k + 1),
            Source::File(format!("{seed}.csv").into()),
            vec![k as f64],
            (1..=n_gauges).map(|gauge| format!("S{gauge}")).collect(),
            gauges.collect(),
            Axis::ALL[..n_axes].to_vec(),
            recorded.iter().map(|load| FULL_SCALE * load).collect(),
        );
        cases.push(case.unwrap().without_times());
    }
    (cases, order, Truth { size, secs: 0.0, starts })
}
