//! Built-in simulated sensor: recordings like those of Koike et al. (2019), so that the program can be tried without files.
//!
//! A robot arm turns a resin sensor that carries a weight of 1.128 kg. There are five mounting points, six paths and three
//! speeds. The sensor has six gauges, hysteresis, creep and noise. The same seed gives the same numbers. A recording depends
//! only on seed, path, mounting point and speed. Reference loads are exact.

mod arm;
mod bench;
mod lag;
#[cfg(test)]
mod mean_hysteresis_tests;
mod sensor;

use rayon::prelude::*;

#[cfg(test)]
pub(crate) use self::lag::{LAG_SECS, PLAY_NEWTONS};
pub use self::lag::{Late, late, late_set};

use self::arm::{MOUNTS_M, Path};
use crate::{
    random::Random,
    recording::{
        axis::Axis,
        recording::{Recording, Source},
        set::{Entry, RecordingSet, Role},
    },
};

/// Seed of the random numbers for the simulated recordings that are shown when the program starts.
pub const DEFAULT_SEED: u64 = 2019;

/// Sampling rate of Koike et al. (2019, section 4.2.2), in Hz.
const RATE_HZ: f64 = 20.0;

/// Number of paths of the robot arm. Recordings of the last path have the role test, all others the role train.
const N_PATHS: u64 = 6;

/// First key of the random numbers for the calibration bench. It differs from the path numbers, which are the first keys of
/// the random numbers for the robot arm.
const BENCH: u64 = 1000;

/// Name of each speed of the robot arm, and number of samples of a path at this speed: a path takes 95 s, 135 s or 175 s.
const SPEEDS: [(&str, usize); 3] = [("fast", 1900), ("medium", 2700), ("slow", 3500)];

/// Returns all 90 recordings of the robot arm with their roles: five paths train (202,500 samples), the sixth tests (40,500
/// samples).
///
/// The names are `train_path1_mount1_fast` to `test_path6_mount5_slow`. Times start at 0 s in steps of 0.05 s, gauges `S1` to
/// `S6` are in mV/V. Roll and pitch are sinusoids with a random amplitude in each cycle. Their frequency is 0.05 Hz in fast
/// runs; medium and slow runs follow the same path in 135 s and 175 s, at 0.035 Hz and 0.027 Hz. The sensor is relaxed before
/// each recording, and the weight attached in the 5 s before the start.
///
/// **Source** Koike et al. 2019, sections 4.1 and 4.2.2. The paper does not relate speed to frequency and does not give the
/// signs of the mounting offsets. Both are choices of this program, as is the sensor.
pub fn recordings(seed: u64) -> RecordingSet {
    let (n_mounts, n_speeds) = (MOUNTS_M.len(), SPEEDS.len());
    let entry = |run: usize| {
        let path = 1 + (run / n_speeds / n_mounts) as u64;
        entry(seed, path, run / n_speeds % n_mounts, run % n_speeds)
    };
    let runs = (0..N_PATHS as usize * n_mounts * n_speeds).into_par_iter();
    with(RecordingSet::default(), runs.map(entry).collect())
}

/// Returns the recordings of a simulated calibration bench, `bench_Fx` to `bench_Mz`, with the role off. Each recording loads
/// one axis: rest, four cycles to the rated load in both directions, rest, steps with dwells up to 80 % of the rated load and
/// back, rest. The recordings show zero return, creep, repeatability and crosstalk.
pub fn bench(seed: u64) -> Vec<Entry> {
    let axes = Axis::ALL.into_iter().enumerate();
    axes.map(|(at, axis)| {
        let loads = bench::loads(axis, RATE_HZ);
        let mut random = Random::new(seed, &[BENCH, at as u64]);
        let name = format!("bench_{axis}");
        Entry::new(recording(name, loads, &mut random), Role::Off)
    })
    .collect()
}

/// Returns the [recordings] of the robot arm, followed by those of the [`bench()`].
pub fn demonstration(seed: u64) -> RecordingSet {
    with(recordings(seed), bench(seed))
}

fn with(mut set: RecordingSet, entries: Vec<Entry>) -> RecordingSet {
    for entry in entries {
        set.push(entry).expect("all simulated recordings have the same gauges and axes");
    }
    set
}

fn entry(seed: u64, path: u64, mount: usize, speed: usize) -> Entry {
    let (pace, n_samples) = SPEEDS[speed];
    let (role, part) = if path == N_PATHS { (Role::Test, "test") } else { (Role::Train, "train") };
    let loads = Path::new(seed, path).loads(n_samples, MOUNTS_M[mount]);
    let mut random = Random::new(seed, &[path, mount as u64 + 1, speed as u64 + 1]);
    let name = format!("{part}_path{path}_mount{}_{pace}", mount + 1);
    Entry::new(recording(name, loads, &mut random), role)
}

fn recording(name: String, loads: Vec<[f64; 6]>, random: &mut Random) -> Recording {
    let gauges = sensor::gauges_from_loads(&loads, RATE_HZ, random);
    Recording::new(
        name,
        Source::Simulated,
        (0..loads.len()).map(|k| k as f64 / RATE_HZ).collect(),
        (1..=6).map(|gauge| format!("S{gauge}")).collect(),
        gauges,
        Axis::ALL.to_vec(),
        loads.into_iter().flatten().collect(),
    )
    .expect("simulated values form a valid recording")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::kinetics::STANDARD_GRAVITY;

    #[test]
    fn there_are_as_many_recordings_and_samples_as_in_the_paper() {
        let set = recordings(DEFAULT_SEED);
        assert!(set.is_simulated());
        for (role, count, samples) in [(Role::Train, 75, 202_500), (Role::Test, 15, 40_500)] {
            let sizes: Vec<usize> = (set.entries().iter())
                .filter(|entry| entry.role == role)
                .map(|entry| entry.recording.n_samples())
                .collect();
            assert_eq!((sizes.len(), sizes.iter().sum()), (count, samples));
        }
        let name = |index: usize| set.entries()[index].recording.name().to_owned();
        assert_eq!(name(0), "train_path1_mount1_fast");
        assert_eq!(name(89), "test_path6_mount5_slow");
        let slow = &set.entries()[89].recording;
        assert_eq!((slow.times()[0], slow.times()[3499]), (0.0, 3499.0 / 20.0));
    }

    #[test]
    fn the_bench_comes_after_the_papers_recordings_and_is_off() {
        let (all, paper) = (demonstration(DEFAULT_SEED), recordings(DEFAULT_SEED));
        assert_eq!(all.entries()[..90], paper.entries()[..]);
        let bench = &all.entries()[90..];
        assert_eq!(bench.len(), 6);
        for (at, entry) in bench.iter().enumerate() {
            assert_eq!(entry.role, Role::Off);
            assert_eq!(entry.recording.name(), format!("bench_{}", Axis::ALL[at].symbol()));
            for load in entry.recording.loads().chunks(6) {
                assert!((0..6).all(|axis| axis == at || load[axis] == 0.0));
                assert!(load[at].abs() <= sensor::RATED_LOAD[at] * (1.0 + 1e-12));
            }
            assert!(entry.recording.gauges().iter().all(|s| s.abs() < 2.5));
        }
    }

    #[test]
    fn the_seed_decides_the_numbers() {
        let first = recordings(7);
        assert_eq!(first, recordings(7));
        let other = recordings(8);
        for (a, b) in first.entries().iter().zip(other.entries()) {
            assert_ne!(a.recording.loads(), b.recording.loads());
            assert_ne!(a.recording.gauges(), b.recording.gauges());
        }
    }

    #[test]
    fn force_never_exceeds_the_weight_and_the_centre_gives_no_moment() {
        let weight = arm::MASS_KG * STANDARD_GRAVITY;
        for entry in recordings(DEFAULT_SEED).entries() {
            let centred = entry.recording.name().contains("mount1");
            for load in entry.recording.loads().chunks(6) {
                let force = load[..3].iter().map(|f| f * f).sum::<f64>().sqrt();
                assert!(force <= weight * (1.0 + 1e-12));
                let moment = load[3..].iter().map(|m| m * m).sum::<f64>().sqrt();
                assert!(moment <= 0.025 * weight * (1.0 + 1e-12));
                assert_eq!(moment == 0.0, centred);
            }
        }
    }

    /// Gauge readings stay near their offset. A reading outside shows that the simulation is unstable.
    #[test]
    fn gauges_stay_in_range() {
        for entry in recordings(DEFAULT_SEED).entries() {
            assert!(entry.recording.gauges().iter().all(|s| s.abs() < 2.5));
        }
    }
}
