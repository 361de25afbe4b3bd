//! Exports of the conventional matrix alone, as a C array.

use std::fs;
use std::process::Command;

use loopscope::calibration::Regressor;

use crate::support::{calibration, every_block, export, succeed};
use crate::tools::is_there;

#[test]
fn a_driver_file_contains_the_matrix_row_by_row() {
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    let text = export(&calibration, &directory.path().join("left arm.inc"));
    assert!(text.contains("static const double left_arm_matrix[6][6] = {"));
    assert!(
        text.contains("leaves out: the compensation of hysteresis")
            && text.contains("offset left out")
    );
    if !is_there("cc", &["--version"]) {
        return;
    }
    let main = "#include <stdio.h>\n#include \"left arm.inc\"\n\
                int main(void) { for (int k = 0; k < 36; k++) printf(\"%.17g\\n\", left_arm_matrix[k / 6][k % 6]); return 0; }\n";
    fs::write(directory.path().join("main.c"), main).unwrap();
    let mut cc = Command::new("cc");
    succeed(
        cc.current_dir(directory.path())
            .args(["-std=c99", "-Wall", "-Werror", "-o", "main", "main.c"]),
    );
    let printed = succeed(&mut Command::new(directory.path().join("main")));
    let actual: Vec<f64> = printed.lines().map(|line| line.parse().unwrap()).collect();
    let expected = calibration.conventional.matrix.iter();
    let expected: Vec<f64> = expected.flat_map(|row| row[..6].to_vec()).collect();
    assert_eq!(actual, expected);
}
