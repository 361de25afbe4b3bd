//! Exported Python files. The tests run them only if Python and NumPy are installed.

use std::fs;
use std::process::Command;

use crate::support::{
    RECORDING, assert_loads, assert_runs_live, calibrations, disturbed, export, lines, samples,
    succeed, tared,
};
use crate::tools::is_there;

const DRIVER: &str = "
import sys
import numpy
import exported

samples = [[float(text) for text in line.split()] for line in open(sys.argv[1])]
state = exported.State()
if len(sys.argv) > 2:
    state.tare(samples.pop(0)[1:])
    for sample in samples:
        print(*(repr(float(x)) for part in state.update(sample[0], sample[1:]) for x in part), state.status)
    sys.exit()
loads, conventional = exported.apply([s[0] for s in samples], [s[1:] for s in samples])
for sample, *whole in zip(samples, loads, conventional):
    live = state.update(sample[0], sample[1:])
    assert numpy.array_equal(live, whole, equal_nan=True)
    print(*(repr(float(x)) for part in live for x in part), state.status)
";

#[test]
fn every_calibration_gives_the_same_loads_in_python() {
    if !is_there("python3", &["-c", "import numpy"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("samples.txt"), lines(&samples(&RECORDING))).unwrap();
    fs::write(at("disturbed.txt"), lines(&disturbed())).unwrap();
    let (recording, samples) = tared();
    fs::write(at("tared.txt"), lines(&samples)).unwrap();
    fs::write(at("main.py"), DRIVER).unwrap();
    for (name, calibration) in calibrations() {
        export(&calibration, &at("exported.py"));
        // Python must write no compiled files, because it would confuse two exports that are written within one second.
        let run = |file: &str| {
            let mut python = Command::new("python3");
            succeed(python.arg("-B").arg(at("main.py")).arg(at(file)))
        };
        let printed = run("samples.txt");
        assert_loads(&printed, &calibration, &RECORDING, 1e-9, &name);
        assert_runs_live(&run("disturbed.txt"), &calibration, 1e-9, &name);
        let mut python = Command::new("python3");
        let python = python.arg("-B").arg(at("main.py")).arg(at("tared.txt"));
        let printed = succeed(python.arg("tare"));
        assert_loads(&printed, &calibration, &recording, 1e-9, &name);
    }
}
