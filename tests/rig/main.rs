//! Runs the data check on simulated rigs. Most faults must be reported with the right cause, and recordings without faults must give no
//! false alarm.

mod bouc_wen;
mod laboratory;
mod simulator;
mod zeros;

use std::sync::Arc;

use loopscope::calibration::FitSettings;
use loopscope::finding::{Finding, Id};
use loopscope::progress::Progress;
use loopscope::questions::check::query::CheckData;
use loopscope::questions::{Request, sufficiency};
use loopscope::recording::{Entry, Recording, RecordingSet, Role, ValidRange};
use loopscope::scoring::rig::{Cause, Contradiction, Rig, RigReport};
use simulator::{Dice, FAULTS, Fault, Programme, Set};
use zeros::{Rows, Zero};

fn rig(set: &Set) -> Rig {
    let all = set.recordings();
    let all: Vec<&Recording> = all.iter().collect();
    Rig::of(&all, &set.full_scale).unwrap()
}

/// Returns the size at which a fault adds a quarter (or `RIG_ADDS_PERCENT`) to the held-out error; `None` if no size adds this much.
fn size(fault: Fault, sound: &Set) -> Option<f64> {
    let adds = number("RIG_ADDS_PERCENT", 25) as f64 / 100.0;
    let wanted = (1.0 + adds) * rig(sound).left_out_error();
    let error = |size: f64| rig(&fault.of(sound, size)).left_out_error();
    if !fault.has_size() {
        return (error(1.0) >= wanted).then_some(1.0);
    }
    let (mut low, mut high) = (0.0, 1e-3);
    while error(high) < wanted {
        (low, high) = (high, 2.0 * high);
        if high > 1.0 {
            return None;
        }
    }
    for _ in 0..8 {
        let middle = 0.5 * (low + high);
        if error(middle) < wanted { low = middle } else { high = middle }
    }
    Some(high)
}

/// Returns true if the reported causes contain this fault.
fn is_named(fault: Fault, set: &Set, causes: &[Finding]) -> bool {
    let has = |id: Id| causes.iter().any(|own| own.id == id);
    match fault {
        Fault::Clipped => has(Id::Faults),
        Fault::ClippedReference => has(Id::ReferenceClipped) || has(Id::Faults),
        Fault::Late => has(Id::Lag),
        _ => rig(set).contradiction().is_some_and(|found| is_right(fault, &found, set)),
    }
}

fn is_right(fault: Fault, found: &Contradiction, set: &Set) -> bool {
    let (cause, one_axis, one_gauge) = (&found.cause, set.axes.len() == 1, set.n_gauges == 1);
    let is_gain = |gauge: bool| match cause {
        Cause::AllGauges => !gauge || one_gauge,
        Cause::Gauge(_) => gauge || one_gauge || one_axis,
        Cause::Axes(_) => !gauge && one_axis,
        _ => false,
    };
    let value = found.value;
    let is_factor =
        |factor: f64| (value / factor - 1.0).abs() < 0.1 || (value * factor - 1.0).abs() < 0.1;
    match fault {
        Fault::Tare => *cause == Cause::Tare,
        // With three recordings, a drift cannot be distinguished from a step.
        Fault::Drift => *cause == Cause::Drift || (set.runs.len() < 4 && *cause == Cause::Tare),
        Fault::GaugeFrom | Fault::GaugeOnce => is_gain(true),
        Fault::AmplifierFrom => is_gain(false),
        Fault::PoundsOnce => is_gain(false) && is_factor(4.448),
        Fault::MillimetresOnce => matches!(cause, Cause::Axes(_)) && is_factor(1000.0),
        Fault::TurnedOnce => *cause == Cause::Rotation,
        Fault::SwappedGauges => matches!(cause, Cause::SwappedGauges(..)),
        Fault::SwappedAxes => matches!(cause, Cause::SwappedAxes(..)),
        Fault::MirroredAxis => {
            (matches!(cause, Cause::Axes(_)) || one_axis && is_gain(false)) && value < 0.0
        }
        Fault::MirroredGauge => is_gain(true) && value < 0.0,
        _ => false,
    }
}

/// Returns a number from an environment variable, which can be set for longer runs by hand; else the usual number.
fn number(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

type Sound = fn(u64, usize) -> Set;

fn described(set: &Set) -> String {
    let programmes: Vec<_> = set.runs.iter().map(|run| run.programme).collect();
    format!(
        "{} {} axes {} gauges hysteresis {:.3} noise {:.4} {programmes:?}",
        set.seed,
        set.axes.len(),
        set.n_gauges,
        set.hysteresis,
        set.noise
    )
}

/// Checks the detection rates. To print the table of the guide:
/// `RIG_FROM=7000 RIG_SETS=14 cargo test --release --test rig named -- --nocapture`.
fn assert_most_are_named(kind: &str, sound: Sound) {
    let (from, sets) = (number("RIG_FROM", 6), number("RIG_SETS", 4));
    let text = |found: &[Finding]| {
        found.iter().map(|own| own.to_string()).collect::<Vec<_>>().join("\n      ")
    };
    let mut accused = Vec::new();
    for seed in from..from + 4 * sets {
        let set = sound(seed, 1);
        let found = causes(&set);
        if !found.is_empty() {
            accused.push(format!("   {}: {}", described(&set), text(&found)));
        }
    }
    println!("{kind}: {} of {} sound sets accused", accused.len(), 4 * sets);
    accused.iter().for_each(|own| println!("{own}"));
    let (mut named, mut all) = (0, 0);
    for fault in FAULTS {
        let (mut right, mut of) = (0, 0);
        for seed in from..from + sets {
            let set = sound(seed + 500, fault.fewest_runs());
            if !fault.fits(&set) {
                continue;
            }
            let Some(size) = size(fault, &set) else { continue };
            let faulty = fault.of(&set, size);
            let found = causes(&faulty);
            let is_right = is_named(fault, &faulty, &found);
            (right, of) = (right + u64::from(is_right), of + 1);
            if !is_right || found.len() > 1 {
                let what = if is_right { "also named" } else { "not named" };
                println!("   {what}: size {size:.4}, {}: {}", described(&set), text(&found));
            }
        }
        println!("{kind}, {fault:?}: {right} of {of}");
        (named, all) = (named + right, all + of);
    }
    println!("{kind}: {named} of {all} faults named");
    // The test uses few sets. The guide has the rates for more sets.
    assert!(16 * accused.len() as u64 <= 4 * sets, "{accused:#?}");
    assert!(10 * named >= 8 * all, "{named} of {all}");
}

#[test]
fn faults_of_rigs_with_play_are_named_and_sound_ones_are_not_accused() {
    assert_most_are_named("play", Set::sound);
}

#[test]
fn faults_of_rigs_with_bouc_wen_hysteresis_are_named_and_sound_ones_are_not_accused() {
    assert_most_are_named("Bouc-Wen", bouc_wen::sound);
}

/// To try more sets: `LAB_FROM=1000 LAB_SETS=400 cargo test --release --test rig procedures -- --nocapture`.
#[test]
fn sound_sets_of_common_procedures_are_not_accused() {
    let (from, sets) = (number("LAB_FROM", 0), number("LAB_SETS", 32));
    let accused = |seed: &u64| {
        let set = laboratory::sound(*seed);
        let found: Vec<String> = causes(&set).iter().map(ToString::to_string).collect();
        let text = format!("{}: {}", described(&set), found.join("\n      "));
        (!found.is_empty()).then_some(text)
    };
    let accused: Vec<String> = (from..from + sets).filter_map(|seed| accused(&seed)).collect();
    println!(
        "{} of {sets} sets of common procedures accused\n{}",
        accused.len(),
        accused.join("\n")
    );
    assert!(32 * accused.len() as u64 <= sets, "{accused:#?}");
}

/// To try more sets: `LAB_FROM=1000 LAB_SETS=400 cargo test --release --test rig curved -- --nocapture`.
#[test]
fn curved_gauges_are_not_called_changed() {
    let (from, sets) = (number("LAB_FROM", 0), number("LAB_SETS", 32));
    let accused = |seed: &u64| {
        let mut set = laboratory::sound(*seed);
        let bends: Vec<f64> = set.span.iter().map(|span| 0.04 / span).collect();
        for row in set.runs.iter_mut().flat_map(|run| &mut run.gauges) {
            row.iter_mut().zip(&bends).for_each(|(own, bend)| *own += bend * *own * *own);
        }
        let found: Vec<String> = causes(&set).iter().map(ToString::to_string).collect();
        let text = format!("{}: {}", described(&set), found.join("\n      "));
        (!found.is_empty()).then_some(text)
    };
    let accused: Vec<String> = (from..from + sets).filter_map(|seed| accused(&seed)).collect();
    println!("{} of {sets} curved sets accused\n{}", accused.len(), accused.join("\n"));
    assert!(16 * accused.len() as u64 <= sets, "{accused:#?}");
}

/// In one of at least five recordings, the gauges are written late.
#[test]
fn a_recording_that_disagrees_for_another_reason_is_named() {
    let is_wide = |set: &Set| set.runs.len() > 4 && set.runs[2].programme == Programme::Random;
    let late = |mut set: Set| {
        set.runs[2].gauges.rotate_right(20);
        set
    };
    let disagrees = |set: &Set| {
        let errors: Vec<f64> = rig(set).table().iter().map(|run| run.error).collect();
        let others = errors.iter().enumerate().filter(|(at, _)| *at != 2);
        errors[2] > 4.0 * others.fold(0.0, |most: f64, (_, own)| most.max(*own))
    };
    let sets = (0..400).map(|seed| Set::sound(seed, 5)).filter(is_wide).map(late);
    let sets: Vec<Set> = sets.filter(disagrees).take(8).collect();
    assert_eq!(sets.len(), 8);
    let named = sets.iter().filter(|set| !causes(set).is_empty()).count();
    assert!(named > 6, "{named}");
}

/// The loads are limited by their controller, so they return to exactly their maximum, but the reference measures them correctly.
#[test]
fn a_limited_load_of_curved_gauges_is_not_called_a_clipped_reference() {
    let is_limited = |set: &Set| {
        set.runs.iter().all(|run| run.programme == Programme::Random) && set.axes.len() > 1
    };
    let sets: Vec<Set> =
        (0..200).map(|seed| Set::sound(seed, 3)).filter(is_limited).take(8).collect();
    assert_eq!(sets.len(), 8);
    for mut set in sets {
        let spans = set.span.clone();
        for row in set.runs.iter_mut().flat_map(|run| &mut run.gauges) {
            row.iter_mut().zip(&spans).for_each(|(own, span)| *own += 0.03 * *own * *own / span);
        }
        let found = causes(&set);
        assert!(found.iter().all(|own| own.id != Id::ReferenceClipped), "{found:?}");
    }
}

/// Each set has one additional column: a copy of the reference.
#[test]
fn columns_that_are_no_gauges_are_named() {
    let seen = |set: &Set| {
        let mut gauges: Vec<String> = (0..set.n_gauges).map(|at| format!("S{at}")).collect();
        *gauges.last_mut().unwrap() = "last".to_owned();
        rig(set).no_gauges(&gauges, &[]).map_or_else(String::new, |own| own.seen)
    };
    for seed in (0..40).filter(|seed| Set::sound(*seed, 2).noise > 0.002) {
        let sound = Set::sound(seed, 2);
        let with = |value: &dyn Fn(&simulator::Run, usize) -> f64| {
            let mut set = sound.clone();
            for run in &mut set.runs {
                let column: Vec<f64> = (0..run.loads.len()).map(|k| value(run, k)).collect();
                run.gauges.iter_mut().zip(column).for_each(|(row, own)| row.push(own));
            }
            set.n_gauges += 1;
            set.span.push(1.0);
            seen(&set)
        };
        assert_eq!(seen(&sound), "", "{seed}");
        let text = with(&|run, k| 2.0 * run.loads[k][0]);
        assert!(text.contains("last equals a linear combination") && !text.contains(';'), "{text}");
    }
}

#[test]
fn a_clipped_reference_is_named() {
    let found = |set: &Set| {
        let all = set.recordings();
        let all: Vec<&Recording> = all.iter().collect();
        Rig::of(&all, &set.full_scale).unwrap().clipped_reference(&all)
    };
    for seed in 0..number("RIG_SETS", 4) * 10 {
        assert_eq!(found(&Set::sound(seed, 1)), [], "{seed}");
    }
    let moves = |set: &Set| set.runs.iter().all(|run| run.programme != Programme::Poses);
    let (mut named, mut all) = (0, 0);
    for sound in (0..40).map(|seed| Set::sound(seed, 2)).filter(moves) {
        let mut clips = sound.clone();
        for row in clips.runs.iter_mut().flat_map(|run| &mut run.loads) {
            row[0] = row[0].min(0.5 * sound.full_scale[0]);
        }
        let is_named = |own: &Finding| own.seen.contains(sound.axes[0].symbol());
        named += usize::from(found(&clips).iter().any(is_named));
        all += 1;
    }
    println!("{named} of {all} clipped references named");
    assert!(4 * named >= 3 * all, "{named} of {all}");
}

/// Returns the findings on changes of the zero.
fn zero_changes(recordings: &[Recording]) -> Vec<Finding> {
    let all: Vec<&Recording> = recordings.iter().collect();
    let full_scale = vec![zeros::FULL_SCALE; all[0].axes().len()];
    let report = RigReport::of(&all, &full_scale, &Progress::default()).unwrap().unwrap();
    let wanted = [Id::DriftWithin, Id::ZeroJumped, Id::Mountings];
    report.findings.into_iter().filter(|own| wanted.contains(&own.id)).collect()
}

fn fact(of: &Finding, name: &str) -> f64 {
    of.facts[0][name].as_f64().unwrap_or(f64::NAN)
}

#[derive(Default)]
struct Rates {
    right: usize,
    /// Changes of more than 3 % of full scale among those that are named.
    large: usize,
    wrong: usize,
    all: usize,
}

impl std::fmt::Display for Rates {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { right, large, wrong, all } = self;
        write!(f, "{right} named (larger than 3 %: {large}), {wrong} wrong, of {all}")
    }
}

/// Prints the table of the guide: `cargo test --release --test rig trial -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes; prints the table of the guide"]
fn trial_of_zeros_that_change() {
    let (from, sets) = (number("ZERO_FROM", 5000), number("ZERO_SETS", 40));
    for (at, programme) in zeros::PROGRAMMES.into_iter().enumerate() {
        for zero in [Zero::Sound, Zero::Drift, Zero::Jump] {
            let (mut rates, mut near) = (Rates::default(), 0);
            for set in 0..sets {
                let seed = (from + set) * zeros::PROGRAMMES.len() as u64 + at as u64;
                let (recording, own, truth) = zeros::recording(seed, zero);
                assert_eq!(own, programme);
                let expected = match zero {
                    Zero::Drift => Some(Id::DriftWithin),
                    Zero::Jump => Some(Id::ZeroJumped),
                    Zero::Sound => None,
                };
                let found = zero_changes(&[recording]);
                rates.all += 1;
                if let Some(found) = found.first() {
                    if Some(found.id) == expected {
                        rates.right += 1;
                        rates.large += usize::from(truth.size > 0.03);
                        let place = (fact(found, "at_secs") - truth.secs).abs();
                        near += usize::from(place < 60.0_f64.max(0.05 * truth.secs));
                    } else {
                        rates.wrong += 1;
                        println!("   {seed} {zero:?}: {found}");
                    }
                }
            }
            println!("{programme:?}, {zero:?}: {rates}; time right {near}");
        }
    }
    for (at, order) in zeros::ORDERS.into_iter().enumerate() {
        for rows in [Rows::Sound, Rows::MountedAnew] {
            let (mut rates, mut exact) = (Rates::default(), 0);
            for set in 0..sets {
                let seed = (from + set) * zeros::ORDERS.len() as u64 + at as u64;
                let (cases, own, truth) = zeros::table(seed, rows);
                assert_eq!(own, order);
                let found = zero_changes(&cases);
                rates.all += 1;
                let is_mounted_anew = rows == Rows::MountedAnew;
                let is_right = is_mounted_anew && !found.is_empty();
                rates.right += usize::from(is_right);
                rates.large += usize::from(is_right && truth.size > 0.03);
                rates.wrong += usize::from(!is_mounted_anew && !found.is_empty());
                exact += usize::from(found.first().is_some_and(|own| starts(own) == truth.starts));
            }
            println!("table {order:?}, {rows:?}: {rates}; rows right {exact}");
        }
    }
}

/// Returns the first row of each mounting, counted from 0.
fn starts(of: &Finding) -> Vec<usize> {
    of.facts.iter().map(|own| own["rows"][0].as_u64().unwrap() as usize - 1).collect()
}

#[test]
fn a_zero_that_drifts_or_jumps_in_one_recording_is_measured_and_a_sound_one_is_not_accused() {
    for seed in 0..30 {
        let found = zero_changes(&[zeros::recording(seed, Zero::Sound).0]);
        assert_eq!(found, [], "{seed}");
    }
    let (mut named, mut wrong) = (0, 0);
    for (zero, id) in [(Zero::Drift, Id::DriftWithin), (Zero::Jump, Id::ZeroJumped)] {
        for seed in 0..24 {
            let (recording, programme, truth) = zeros::recording(seed, zero);
            let found = zero_changes(&[recording]);
            let Some(found) = found.first() else { continue };
            let secs = fact(found, if zero == Zero::Jump { "at_secs" } else { "during_secs" });
            let is_right = found.id == id && (secs - truth.secs).abs() < 0.1 * truth.secs;
            println!("{seed} {programme:?} {truth:?}: {found}");
            (named, wrong) = (named + i32::from(is_right), wrong + i32::from(!is_right));
        }
    }
    assert!(named >= 20 && wrong <= 2, "{named} named, {wrong} wrong");
}

#[test]
fn mountings_of_a_table_are_found_with_their_rows() {
    let mut exact = 0;
    for seed in 0..30 {
        let found = zero_changes(&zeros::table(seed, Rows::Sound).0);
        assert_eq!(found, [], "{seed}");
        let (cases, order, truth) = zeros::table(seed, Rows::MountedAnew);
        let found = zero_changes(&cases);
        println!("{seed} {order:?} {truth:?}: {:?}", found.first().map(ToString::to_string));
        exact += i32::from(found.first().is_some_and(|own| starts(own) == truth.starts));
    }
    assert!(exact >= 12, "{exact}");
}

/// A table whose zeros drift has no mountings, and of a table with one wrong load, no other row is accused.
#[test]
fn drifts_and_mistyped_loads_of_tables_are_told_from_mountings() {
    let found = |seed: u64, rows: Rows| {
        let (cases, order, truth) = zeros::table(seed, rows);
        let all: Vec<&Recording> = cases.iter().collect();
        let full_scale = vec![zeros::FULL_SCALE; all[0].axes().len()];
        let report = RigReport::of(&all, &full_scale, &Progress::default()).unwrap().unwrap();
        let texts: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
        println!("{seed} {rows:?} {order:?} {truth:?}: {texts:?}");
        (report.findings, format!("row {} ", zeros::mistyped(cases.len()) + 1))
    };
    let (mut drifts, mut mistyped, mut wrong) = (0, 0, 0);
    for seed in 0..30 {
        let has = |own: &[Finding], id: Id| own.iter().any(|own| own.id == id);
        let (own, _) = found(seed, Rows::Drifting);
        drifts += usize::from(has(&own, Id::ZerosDrift));
        wrong += usize::from(has(&own, Id::Mountings) || has(&own, Id::OneDisagrees));
        let (own, row) = found(seed, Rows::Mistyped);
        let disagrees = own.iter().find(|own| own.id == Id::OneDisagrees);
        mistyped += usize::from(disagrees.is_some_and(|own| own.seen.starts_with(&row)));
        wrong += usize::from(disagrees.is_some_and(|own| !own.seen.starts_with(&row)));
        assert!(!has(&found(seed, Rows::Sound).0, Id::OneDisagrees), "{seed}");
    }
    println!("{drifts} drifts and {mistyped} mistyped loads of 30 named, {wrong} wrong");
    assert!(drifts >= 8 && mistyped >= 27 && wrong <= 3, "{drifts} {mistyped} {wrong}");
}

/// Returns the findings on a set. The last `n_tests` recordings have the role Test.
fn findings(set: &Set, n_tests: usize) -> Vec<Finding> {
    let mut recordings = RecordingSet::default();
    let n_train = set.runs.len() - n_tests;
    for (at, own) in set.recordings().into_iter().enumerate() {
        let role = if at < n_train { Role::Train } else { Role::Test };
        recordings.push(Entry::new(own, role)).unwrap();
    }
    let full_scale = set.full_scale.iter().copied().map(Some).collect();
    let settings = FitSettings { full_scale, ..FitSettings::default() };
    let request = Request::fit(Arc::new(recordings), settings);
    let asked = CheckData::of(&request, ValidRange::default());
    sufficiency(&asked, &Progress::default()).unwrap().findings
}

/// Returns the faults that the check reports.
fn causes(set: &Set) -> Vec<Finding> {
    findings(set, 0).into_iter().filter(|own| own.id.is_cause()).collect()
}

/// Returns the ids of the findings on load programmes and loads of a set.
fn of_loads(set: &Set, n_tests: usize) -> Vec<Id> {
    let wanted = [Id::SameSamples, Id::OneProgramme, Id::OneAxisAtATime, Id::OneSided];
    let found = findings(set, n_tests).into_iter().map(|own| own.id);
    found.filter(|id| wanted.contains(id)).collect()
}

/// Returns a set with other loads. The gauges follow the loads linearly, with noise.
fn with_loads(set: &Set, load: impl Fn(usize, usize, usize, f64) -> f64) -> Set {
    let mut set = set.clone();
    let mut dice = Dice::new(set.seed);
    for (at, run) in set.runs.iter_mut().enumerate() {
        for (k, (loads, gauges)) in run.loads.iter_mut().zip(&mut run.gauges).enumerate() {
            loads.iter_mut().enumerate().for_each(|(axis, own)| *own = load(at, k, axis, *own));
            for (gauge, own) in gauges.iter_mut().enumerate() {
                let parts =
                    loads.iter().zip(&set.full_scale).enumerate().map(|(axis, (load, full))| {
                        load / full * if axis == gauge { 1.5 } else { 0.1 * (1 + gauge) as f64 }
                    });
                *own = parts.sum::<f64>() + 0.01 * dice.normal();
            }
        }
    }
    set
}

/// Each defect must be found in the set that has it, and in no other set.
#[test]
fn repeated_samples_and_programmes_and_loads_of_one_axis_or_one_way_are_told_apart() {
    let is_fit = |set: &Set| {
        set.axes.len() > 1 && set.runs.iter().all(|run| run.programme != Programme::Poses)
    };
    let sets = (0..60).map(|seed| Set::sound(seed, 3)).filter(is_fit).take(6);
    for sound in sets {
        let seed = sound.seed;
        assert_eq!(of_loads(&sound, 0), [], "{seed}");
        assert_eq!(of_loads(&sound, 1), [], "{seed}");
        let mut twice = sound.clone();
        twice.runs.push(sound.runs[0].clone());
        assert_eq!(of_loads(&twice, 0), [Id::SameSamples], "{seed}: twice in training");
        assert_eq!(of_loads(&twice, 1), [Id::SameSamples], "{seed}: in training and test");
        let mut repeated = sound.clone();
        repeated.runs = vec![sound.runs[0].clone(); 4];
        let repeated = with_loads(&repeated, |_, _, _, load| load);
        assert_eq!(of_loads(&repeated, 0), [Id::OneProgramme], "{seed}");
        let n_axes = sound.axes.len();
        let alone = with_loads(
            &sound,
            |run, k, axis, load| {
                if (run + k / 40) % n_axes == axis { load } else { 0.0 }
            },
        );
        assert_eq!(of_loads(&alone, 0), [Id::OneAxisAtATime], "{seed}");
        let one_sided = with_loads(&sound, |_, _, _, load| load.abs());
        assert_eq!(of_loads(&one_sided, 0), [Id::OneSided], "{seed}");
    }
}
