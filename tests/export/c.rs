//! C headers, compiled with the strictest C99 warnings.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use loopscope::calibration::{Calibration, Regressor, Status};
use loopscope::export::Footprint;

use crate::support::{
    RECORDING, Samples, assert_loads, assert_runs_as, assert_runs_live, calibration, calibrations,
    disturbed, every_block, export, keeping, lines, samples, succeed, tared, with_pauses,
};
use crate::tools::is_there;

pub const STRICT: [&str; 8] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-pedantic",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wshadow",
    "-Werror",
];

/// Warning options of clang: all warnings, except those on style, padding, older languages and array accesses.
const EVERYTHING: [&str; 10] = [
    "-Weverything",
    "-Wno-unknown-warning-option",
    "-Wno-padded",
    "-Wno-unsafe-buffer-usage",
    "-Wno-declaration-after-statement",
    "-Wno-c++98-compat",
    "-Wno-c++98-compat-pedantic",
    "-Wno-old-style-cast",
    "-Wno-zero-as-null-pointer-constant",
    "-Wno-unused-macros",
];

/// Exports `calibration` into `directory`, compiles its driver with numbers of type `real`, and returns the program's path.
#[track_caller]
fn compiled(calibration: &Calibration, directory: &Path, name: &str, real: &str) -> PathBuf {
    let program = directory.join(format!("{name}_{real}"));
    let mut compile = compiler("cc", "driver.c", calibration, directory, name, real);
    succeed(compile.args(STRICT).args(["-O1", "-o"]).arg(&program).arg("-lm"));
    program
}

/// Returns the compiler's command for a driver of the header. Exports the header if it does not exist yet.
fn compiler(
    compiler: &str,
    driver: &str,
    calibration: &Calibration,
    directory: &Path,
    name: &str,
    real: &str,
) -> Command {
    let header = directory.join(format!("{name}.h"));
    if !header.exists() {
        export(calibration, &header);
    }
    let upper = name.to_ascii_uppercase();
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export");
    let mut compile = Command::new(compiler);
    compile
        .arg(format!("-DHEADER=\"{}\"", header.display()))
        .arg(format!("-DNAME={name}"))
        .arg(format!("-DESTIMATOR={name}_estimator"))
        .arg(format!("-DCALIBRATION={upper}_CALIBRATION"))
        .arg(format!("-DGAUGES={upper}_GAUGES"))
        .arg(format!("-DAXES={upper}_AXES"))
        .arg(format!("-DLOOPSCOPE_REAL={real}"))
        .arg(tests.join(driver));
    compile
}

/// The class is compiled with the same warnings as the C header. In double, its loads equal the program's exactly.
#[test]
fn the_class_runs_every_calibration_in_cpp() {
    if !is_there("g++", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    for (name, calibration) in calibrations() {
        for real in ["double", "float"] {
            let program = directory.path().join(format!("{name}_{real}"));
            let mut compile =
                compiler("g++", "driver.cpp", &calibration, directory.path(), &name, real);
            let strict = STRICT.iter().filter(|option| !option.starts_with("-std"));
            compile.args(strict).args(["-std=c++11", "-O1", "-o"]).arg(&program);
            succeed(&mut compile);
            if real == "double" {
                let printed = succeed(&mut fed(&program, directory.path(), &disturbed()));
                assert_runs_live(&printed, &calibration, 1e-9, &name);
            }
        }
    }
}

#[test]
fn clang_analyses_every_export_without_a_warning() {
    if !is_there("clang", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let source = directory.path().join("source");
    for (name, calibration) in calibrations() {
        let header = directory.path().join(format!("{name}.h"));
        export(&calibration, &header);
        fs::write(&source, format!("#include \"{name}.h\"\n")).unwrap();
        for real in ["double", "float"] {
            for (language, standard) in [("c", "c99"), ("c++", "c++11"), ("c++", "c++17")] {
                let mut clang = Command::new("clang");
                clang.args(EVERYTHING).args(["-Werror", "-fsyntax-only", "-x", language]);
                clang.arg(format!("-std={standard}")).arg(format!("-DLOOPSCOPE_REAL={real}"));
                succeed(clang.arg(&source));
            }
        }
    }
}

fn fed(program: &Path, directory: &Path, fed: &Samples) -> Command {
    let input = directory.join("samples.txt");
    fs::write(&input, lines(fed)).unwrap();
    let mut command = Command::new(program);
    command.stdin(Stdio::from(File::open(input).unwrap()));
    command
}

#[test]
fn every_calibration_gives_the_same_loads_in_c() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    for (name, calibration) in calibrations() {
        for (real, tolerance) in [("double", 1e-9), ("float", 1e-4)] {
            let program = compiled(&calibration, directory.path(), &name, real);
            let printed = succeed(&mut fed(&program, directory.path(), &samples(&RECORDING)));
            assert_loads(
                &printed,
                &calibration,
                &RECORDING,
                tolerance,
                &format!("{name} in {real}"),
            );
            // In float, a load that differs by almost exactly F_th may find another past sample.
            if real == "double" {
                let printed = succeed(&mut fed(&program, directory.path(), &disturbed()));
                assert_runs_live(&printed, &calibration, tolerance, &name);
            }
        }
    }
}

/// The samples include pauses, pauses beyond the range of the 32-bit counter, and rejected samples.
#[test]
fn the_three_clocks_treat_pauses_alike() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let forgets = calibration(every_block(), Regressor::Linear);
    let keeps = keeping(forgets.clone(), 400.0);
    let both = [("forgets", forgets), ("keeps", keeps)];
    let runs =
        both.iter().flat_map(|own| [("double", 1e-9), ("float", 1e-4)].map(|real| (own, real)));
    for ((name, calibration), (real, tolerance)) in runs {
        let program = compiled(calibration, directory.path(), name, real);
        for clock in ["seconds", "step", "ticks"] {
            // The driver ignores the argument "seconds" and uses seconds.
            let clock_of_driver = if clock == "seconds" { "-" } else { clock };
            let printed =
                succeed(fed(&program, directory.path(), &with_pauses()).arg(clock_of_driver));
            let what = format!("{name}, {clock} in {real}");
            let samples = with_pauses();
            let statuses = assert_runs_as(&samples, &printed, calibration, tolerance, &what);
            let gaps = statuses.iter().enumerate().filter(|(_, own)| own.has(Status::AFTER_GAP));
            let gaps: Vec<usize> = gaps.map(|(k, _)| k).collect();
            assert_eq!(gaps, [300, 400, 500, 600, 800, 900]);
        }
    }
}

/// The calibrations are of tared and of untared gauges.
#[test]
fn a_tare_in_c_is_that_of_apply() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let (recording, samples) = tared();
    let mut calibration = calibration(every_block(), Regressor::Linear);
    for (name, tare) in [("untared", None), ("tared", recording.tare())] {
        calibration.tare = tare;
        let program = compiled(&calibration, directory.path(), name, "double");
        let printed = succeed(fed(&program, directory.path(), &samples).arg("tare"));
        assert_loads(&printed, &calibration, &recording, 1e-9, name);
    }
}

/// After an invalid step, the elapsed time is unknown.
#[test]
fn an_impossible_time_step_restarts_the_history() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    let program = compiled(&calibration, directory.path(), "stepped", "double");
    let mut back: Samples = samples(&RECORDING).into_iter().take(60).collect();
    back[30].0 = back[20].0;
    for (time, _) in &mut back[31..] {
        *time -= 0.5;
    }
    back[50].0 = f64::NAN;
    let printed = succeed(fed(&program, directory.path(), &back).arg("step"));
    let statuses: Vec<u8> =
        (printed.lines()).map(|line| line.rsplit(' ').next().unwrap().parse().unwrap()).collect();
    let restarted = (Status::RESTARTED.bits(), Status::FILLING.bits());
    assert_eq!(statuses[30..32], [Status::REJECTED_TIME.bits(), restarted.0 + restarted.1]);
    // The next step is invalid too.
    let rejected = Status::REJECTED_VALUE.bits();
    assert_eq!(statuses[50..52], [rejected, rejected]);
    assert_eq!(statuses[52], restarted.0 + restarted.1);
}

/// The driver calls `zero_last_load` at sample 100. Later loads are then smaller by the load of sample 100.
#[test]
fn zero_last_load_subtracts_the_last_load() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    let program = compiled(&calibration, directory.path(), "tared", "double");
    let printed = succeed(fed(&program, directory.path(), &samples(&RECORDING)).arg("zero"));
    let applied = calibration.apply(&RECORDING).unwrap();
    let of = |sample: usize| &applied.compensated[sample * 6..][..6];
    for (k, line) in printed.lines().enumerate().skip(100) {
        for (axis, text) in line.split_whitespace().take(6).enumerate() {
            let actual: f64 = text.parse().unwrap();
            let expected = of(k)[axis] - of(99)[axis];
            assert!((actual - expected).abs() < 1e-8, "sample {k}: {actual} is not {expected}");
        }
    }
}

/// Samples with values that are not numbers, and single samples with implausible times, have no load and no effect on later samples.
#[test]
fn bad_samples_are_rejected_in_c() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    let program = compiled(&calibration, directory.path(), "robust", "double");
    let good: Samples = samples(&RECORDING).into_iter().take(60).collect();
    let run = |samples: &Samples| {
        let printed = succeed(&mut fed(&program, directory.path(), samples));
        printed.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let mut disturbed = good.clone();
    disturbed.insert(30, (good[29].0, vec![f64::NAN; 6]));
    disturbed.insert(31, good[10].clone());
    disturbed.insert(32, (1e9, good[30].1.clone()));
    let (mut actual, expected) = (run(&disturbed), run(&good));
    for line in actual.drain(30..33) {
        let mut numbers = line.split_whitespace().rev();
        assert!(matches!(numbers.next(), Some("16" | "32")));
        assert!(numbers.all(|load| load.contains("nan")), "{line}");
    }
    assert_eq!(actual, expected);
}

/// The memory stated in the comment of the header, at the stated sample rate, equals the size that the compiler reports.
#[test]
fn the_stated_memory_is_that_of_the_state() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let header = directory.path().join("sized.h");
    let text = export(&calibration(every_block(), Regressor::Linear), &header);
    let stated = text.split_once("about ").unwrap().1.split_once(' ').unwrap().0;
    let stated: f64 = stated.parse().unwrap();
    let source = directory.path().join("sized.c");
    fs::write(&source, "#include <stdio.h>\n#include \"sized.h\"\nint main(void) { printf(\"%lu\", (unsigned long)sizeof(sized_state)); return 0; }\n").unwrap();
    let program = directory.path().join("sized");
    succeed(Command::new("cc").args(STRICT).arg(&source).arg("-o").arg(&program).arg("-lm"));
    let actual: f64 = succeed(&mut Command::new(program)).parse().unwrap();
    assert!((stated / actual - 1.0).abs() < 0.001, "{stated} {actual}");
}

#[test]
fn names_from_files_stay_in_their_comments() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let mut calibration = calibration(every_block(), Regressor::Linear);
    calibration.trained_on =
        vec!["*/ #error /* ??/\n\\".to_owned(), "x \u{202e}\u{1b}[31m".to_owned()];
    compiled(&calibration, directory.path(), "named", "double");
    let odd = directory.path().join("2 left-arm.h");
    let text = export(&calibration, &odd);
    assert!(text.contains("cal_2_left_arm_update("));
    assert!(!text.contains('\u{202e}') && !text.contains('\u{1b}'));
}

/// Compiles for a Cortex-M4F, if this compiler is installed.
#[test]
fn a_controller_needs_the_stated_memory_and_no_double_arithmetic() {
    if !is_there("arm-none-eabi-gcc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    for (name, calibration) in calibrations() {
        export(&calibration, &at("bare.h"));
        let source = "#include \"bare.h\"\nstatic bare_state state;\n\
            bare_status step(uint32_t ticks, const float *gauges, float *load);\n\
            bare_status step(uint32_t ticks, const float *gauges, float *load)\n\
            { return bare_update_ticks(&BARE_CALIBRATION, &state, ticks, gauges, load, NULL); }\n";
        fs::write(at("bare.c"), source).unwrap();
        let mut compiler = Command::new("arm-none-eabi-gcc");
        compiler.args(STRICT).args([
            "-O2",
            "-mcpu=cortex-m4",
            "-mthumb",
            "-mfpu=fpv4-sp-d16",
            "-mfloat-abi=hard",
        ]);
        compiler.args(["-DLOOPSCOPE_REAL=float", "-c", "-o"]).arg(at("bare.o")).arg(at("bare.c"));
        succeed(&mut compiler);
        let size = succeed(Command::new("arm-none-eabi-size").arg(at("bare.o")));
        let sizes: Vec<f64> = size
            .lines()
            .nth(1)
            .unwrap()
            .split_whitespace()
            .take(3)
            .map(|x| x.parse().unwrap())
            .collect();
        let footprint = Footprint::of(&calibration);
        assert_eq!(sizes[2] as usize, footprint.memory, "{name}");
        let off = footprint.program as f64 / sizes[0];
        assert!(
            (0.85..1.2).contains(&off),
            "{name}: {} stated, {} used",
            footprint.program,
            sizes[0]
        );
        let symbols = succeed(Command::new("arm-none-eabi-nm").arg(at("bare.o")));
        assert!(!symbols.contains("__aeabi_d"), "{name}: {symbols}");
    }
}
