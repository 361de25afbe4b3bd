//! Carriers of the conventional matrix alone: arrays of C, and what iCub takes.

use std::fs;
use std::process::Command;

use loopscope::calibration::{Calibration, Regressor};
use loopscope::export::write_calibration;
use loopscope::features::FeatureSettings;

use crate::support::{calibration, every_block, export, is_there, succeed};

/// As of gauges in counts of a board of 16 bits.
pub fn in_counts(mut calibration: Calibration) -> Calibration {
    for coefficient in calibration.conventional.matrix.iter_mut().flatten() {
        *coefficient *= 1e-6;
    }
    calibration
}

#[test]
fn a_driver_gets_the_matrix_row_by_row() {
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    let text = export(&calibration, &directory.path().join("left arm.inc"));
    assert!(text.contains("static const double left_arm_matrix[6][6] = {"));
    assert!(text.contains("leaves out: all history") && text.contains("offset left out"));
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

/// Moments come first; a coefficient is off by half of the last bit at most.
#[test]
fn the_board_of_an_icub_gets_fractions_of_16_bits() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("c.dat");
    let whole = calibration(FeatureSettings::present(), Regressor::Linear);
    let told = write_calibration(&whole, &path).unwrap_err().to_string();
    assert!(told.contains("Mx") && told.contains("counts"), "{told}");
    assert!(!path.exists());

    let calibration = in_counts(whole);
    let text = export(&calibration, &path);
    assert_eq!(text.matches("\r\n").count(), 43);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[36], "1");
    for (at, axis) in [3, 4, 5, 0, 1, 2].into_iter().enumerate() {
        let full_scale: f64 = lines[37 + at].parse().unwrap();
        assert_eq!(full_scale, calibration.full_scale[axis].ceil());
        for gauge in 0..6 {
            let bits = u16::from_str_radix(lines[6 * at + gauge], 16).unwrap();
            let actual = f64::from(bits as i16) / 32768.0 * full_scale / 32767.0;
            let expected = calibration.conventional.matrix[axis][gauge];
            let half_bit = 0.5 / 32768.0 * full_scale / 32767.0;
            assert!(
                (actual - expected).abs() <= 1.001 * half_bit,
                "{axis} {gauge}"
            );
        }
    }
}

#[test]
fn the_configuration_of_an_icub_gets_36_numbers() {
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(every_block(), Regressor::Linear);
    let text = export(&calibration, &directory.path().join("l_arm_ft_sensor.xml"));
    let (_, list) = text
        .split_once("<param name=\"l_arm_ft_sensor\">(")
        .unwrap();
    let (list, end) = list.split_once(')').unwrap();
    assert_eq!(end, "</param>\n</group>\n");
    let actual: Vec<f64> = (list.split(','))
        .map(|number| number.trim().parse().unwrap())
        .collect();
    let expected = calibration.conventional.matrix.iter();
    let expected: Vec<f64> = expected.flat_map(|row| row[..6].to_vec()).collect();
    assert_eq!(actual, expected);
}
