//! Python files, run where Python and NumPy are there.

use std::fs::{self, File};
use std::process::{Command, Stdio};

use crate::support::{RECORDING, assert_loads, calibrations, export, is_there, samples, succeed};

const DRIVER: &str = "
import sys
import exported

samples = [[float(text) for text in line.split()] for line in sys.stdin]
loads, conventional = exported.apply([s[0] for s in samples], [s[1:] for s in samples])
for row in zip(loads, conventional):
    print(*(repr(float(x)) for part in row for x in part))
";

#[test]
fn every_calibration_runs_in_python_as_it_does_here() {
    if !is_there("python3", &["-c", "import numpy"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("samples.txt"), samples(&RECORDING)).unwrap();
    fs::write(at("main.py"), DRIVER).unwrap();
    for (name, calibration) in calibrations() {
        export(&calibration, &at("exported.py"));
        let input = Stdio::from(File::open(at("samples.txt")).unwrap());
        // Without compiled files: two exports within a second would be taken for one.
        let printed = succeed(
            Command::new("python3")
                .arg("-B")
                .arg(at("main.py"))
                .stdin(input),
        );
        assert_loads(&printed, &calibration, &RECORDING, 1e-9, &name);
    }
}
