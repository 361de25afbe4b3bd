//! The time of one update of an exported C header at 1 kHz with a look-back of 15 s: `cargo bench --bench export`.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use loopscope::analysis::{Request, train};
use loopscope::calibration::{Calibration, FitSettings};
use loopscope::export::write_calibration;
use loopscope::features::{Blocks, FeatureSettings, Polynomial, Thresholds};
use loopscope::progress::Progress;
use loopscope::recording::simulated;

fn main() {
    let recordings = Arc::new(simulated::recordings(simulated::DEFAULT_SEED));
    let look_back = |f_th| FeatureSettings {
        look_backs: vec![Thresholds {
            f_th,
            t_th_secs: 15.0,
        }],
        ..FeatureSettings::present()
    };
    let every_block = FeatureSettings {
        blocks: Blocks::every().with(&Polynomial, &[2.0]),
        ..look_back(3.0)
    };
    for (name, features) in [
        ("3 N", look_back(3.0)),
        ("10 N", look_back(10.0)),
        ("never (1000 N)", look_back(1000.0)),
        ("every block", every_block),
    ] {
        let settings = FitSettings {
            features,
            decimation: 50,
            ..FitSettings::default()
        };
        let request = Request::fit(Arc::clone(&recordings), settings);
        let calibration = train(&request, &Progress::default(), &mut |_| {})
            .expect("the built-in recordings can be fitted");
        for real in ["double", "float"] {
            println!("{name}, {real}: {}", timed(&calibration, real));
        }
    }
}

fn timed(calibration: &Calibration, real: &str) -> String {
    let directory = tempfile::tempdir().expect("there is room for temporary files");
    let header = directory.path().join("timed.h");
    write_calibration(calibration, &header).expect("the header can be written");
    let mut means = String::from("#include \"timed.h\"\n");
    let scale = &calibration.gauge_scale;
    for (what, values) in [("mean", &scale.shift), ("deviation", &scale.deviation)] {
        writeln!(
            means,
            "static double timed_gauge_{what}(int g) {{ static const double values[] = {{{}}}; return values[g]; }}",
            values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(", ")
        )
        .expect("writing to a text cannot fail");
    }
    let wrapper = directory.path().join("wrapper.h");
    std::fs::write(&wrapper, means).expect("the wrapper can be written");
    let program = directory.path().join("timed");
    let driver = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/export.c");
    let compiled = Command::new("cc")
        .args(["-std=c99", "-O2", "-o"])
        .arg(&program)
        .arg(format!("-DHEADER=\"{}\"", wrapper.display()))
        .arg(format!("-DLOOPSCOPE_REAL={real}"))
        .arg(driver)
        .arg("-lm")
        .status();
    assert!(
        compiled.is_ok_and(|status| status.success()),
        "the header compiles"
    );
    let output = Command::new(program).output().expect("the driver runs");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}
