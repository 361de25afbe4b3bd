//! Time of one update of an exported C header, and memory of its state (`cargo bench --bench export`). Signals are calm, vibrating,
//! noisy and stepwise, at 1 and 10 kHz. If the compiler is installed, also program size and memory on a Cortex-M4F.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use loopscope::calibration::{Calibration, FitSettings};
use loopscope::export::write_calibration;
use loopscope::features::{Blocks, Creep, FeatureSettings, FixedLag, Play, Polynomial};
use loopscope::progress::Progress;
use loopscope::questions::{Request, train};
use loopscope::recording::simulated;

fn main() {
    let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
    let present = FeatureSettings::present();
    let with = |blocks: Blocks| FeatureSettings { blocks, ..present.clone() };
    let none = Blocks::default();
    let polynomial = Blocks::every().with(&Polynomial, &[2.0]);
    for (name, features, history_rate_hz) in [
        ("default", FeatureSettings::default(), 0.0),
        ("default, history 100 Hz", FeatureSettings::default(), 100.0),
        ("default, history 1000 Hz", FeatureSettings::default(), 1000.0),
        ("lag", with(none.clone().with(&FixedLag, &[0.5])), 0.0),
        ("creep", with(none.clone().with(&Creep, &[1.0, 6.0, 40.0])), 0.0),
        ("play", with(none.clone().with(&Play, &[0.1, 0.2, 0.4, 0.7, 1.1, 1.6])), 0.0),
        (
            "play, squares",
            with(none.with(&Play, &[0.1, 0.2, 0.4, 0.7, 1.1, 1.6]).with(&Polynomial, &[2.0])),
            0.0,
        ),
        ("every block", FeatureSettings { blocks: polynomial, ..FeatureSettings::default() }, 0.0),
    ] {
        let history_rate_hz = Some(history_rate_hz);
        let settings = FitSettings { features, history_rate_hz, ..FitSettings::default() };
        let request = Request::fit(Arc::clone(&recordings), settings);
        let calibration = train(&request, &Progress::default(), &mut |_| {})
            .expect("the built-in recordings can be fitted");
        let directory = tempfile::tempdir().expect("there is room for temporary files");
        write_header(&calibration, directory.path());
        for real in ["double", "float"] {
            compile(directory.path(), real);
            for (rate, signals) in [("1000", "cvns"), ("10000", "cvns")] {
                for signal in signals.chars() {
                    let program = Command::new(directory.path().join("timed"))
                        .args([rate, &signal.to_string()])
                        .output()
                        .expect("the driver runs");
                    let printed = String::from_utf8_lossy(&program.stdout).trim().to_owned();
                    println!("{name}, {real}, {rate} Hz, {signal}: {printed}");
                }
            }
        }
        println!("{name}, Cortex-M4F: {}", on_arm(directory.path()));
    }
}

fn write_header(calibration: &Calibration, directory: &Path) {
    write_calibration(calibration, &directory.join("timed.h")).expect("the header can be written");
    // With these amplitudes of the gauges, the load moves by F_th from peak to peak.
    let scale = &calibration.gauge_scale;
    let force = calibration.axes.iter().zip(&calibration.conventional.matrix);
    let force = force.filter(|(axis, _)| axis.is_force()).map(|(_, row)| {
        let moved = row.iter().zip(&scale.deviation);
        moved.map(|(slope, deviation)| slope * deviation).sum::<f64>().powi(2)
    });
    let brush = 1.5 / force.sum::<f64>().sqrt();
    let brush: Vec<f64> = scale.deviation.iter().map(|deviation| brush * deviation).collect();
    let mut means = String::from("#include \"timed.h\"\n");
    for (what, values) in
        [("mean", &scale.shift), ("deviation", &scale.deviation), ("brush", &brush)]
    {
        let values: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        writeln!(
            means,
            "static double timed_gauge_{what}(int g) {{ static const double values[] = {{{}}}; return values[g]; }}",
            values.join(", ")
        )
        .expect("writing to a text cannot fail");
    }
    std::fs::write(directory.join("wrapper.h"), means).expect("the wrapper can be written");
}

fn compile(directory: &Path, real: &str) {
    let driver = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/export.c");
    let compiled = Command::new("cc")
        .args(["-std=c99", "-O2", "-o"])
        .arg(directory.join("timed"))
        .arg(format!("-DHEADER=\"{}\"", directory.join("wrapper.h").display()))
        .arg(format!("-DLOOPSCOPE_REAL={real}"))
        .arg(driver)
        .arg("-lm")
        .status();
    assert!(compiled.is_ok_and(|status| status.success()), "the header compiles");
}

/// Returns a text with the sizes of program and memory in float (bytes), and the number of functions of double arithmetic.
fn on_arm(directory: &Path) -> String {
    let source = "#include \"timed.h\"\nstatic timed_state state;\n\
        timed_status step(unsigned ticks, const float *gauges, float *load) {\n\
        return timed_update_ticks(&TIMED_CALIBRATION, &state, ticks, gauges, load, NULL); }\n";
    std::fs::write(directory.join("arm.c"), source).expect("a source can be written");
    let compiled = Command::new("arm-none-eabi-gcc")
        .args([
            "-std=c99",
            "-O2",
            "-mcpu=cortex-m4",
            "-mthumb",
            "-mfpu=fpv4-sp-d16",
            "-mfloat-abi=hard",
        ])
        .args(["-ffreestanding", "-DLOOPSCOPE_REAL=float", "-c", "arm.c", "-o", "arm.o"])
        .current_dir(directory)
        .status();
    if !compiled.is_ok_and(|status| status.success()) {
        return "skipped: no arm-none-eabi-gcc with its C library here".to_owned();
    }
    let run = |tool: &str| {
        let output = Command::new(tool).arg("arm.o").current_dir(directory).output();
        output.map_or_else(
            |_| String::new(),
            |output| String::from_utf8_lossy(&output.stdout).into_owned(),
        )
    };
    let size = run("arm-none-eabi-size");
    let numbers: Vec<&str> = size.lines().nth(1).unwrap_or_default().split_whitespace().collect();
    let doubles = run("arm-none-eabi-nm").lines().filter(|line| line.contains("__aeabi_d")).count();
    format!(
        "program {} bytes, memory {} bytes, {doubles} functions of double arithmetic",
        numbers.first().unwrap_or(&"?"),
        numbers.get(2).unwrap_or(&"?")
    )
}
