//! Python files, run where Python and NumPy are there.

use std::fs;
use std::process::Command;

use crate::support::{
    RECORDING, assert_loads, assert_runs_live, calibrations, disturbed, export, is_there, lines,
    samples, succeed,
};

const DRIVER: &str = "
import sys
import numpy
import exported

samples = [[float(text) for text in line.split()] for line in open(sys.argv[1])]
loads, conventional = exported.apply([s[0] for s in samples], [s[1:] for s in samples])
state = exported.State()
for sample, *whole in zip(samples, loads, conventional):
    live = state.update(sample[0], sample[1:])
    assert numpy.array_equal(live, whole, equal_nan=True)
    print(*(repr(float(x)) for part in live for x in part), state.status)
";

#[test]
fn every_calibration_runs_in_python_as_it_does_here() {
    if !is_there("python3", &["-c", "import numpy"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("samples.txt"), lines(&samples(&RECORDING))).unwrap();
    fs::write(at("disturbed.txt"), lines(&disturbed())).unwrap();
    fs::write(at("main.py"), DRIVER).unwrap();
    for (name, calibration) in calibrations() {
        export(&calibration, &at("exported.py"));
        // Without compiled files: two exports within a second would be taken for one.
        let run = |file: &str| {
            let mut python = Command::new("python3");
            succeed(python.arg("-B").arg(at("main.py")).arg(at(file)))
        };
        let printed = run("samples.txt");
        assert_loads(&printed, &calibration, &RECORDING, 1e-9, &name);
        assert_runs_live(&run("disturbed.txt"), &calibration, 1e-9, &name);
    }
}
