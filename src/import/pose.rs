//! Computes the load of a known weight from the pose of the sensor ("Calc." in the paper of Koike et al., 2019). Also
//! estimates a weight from poses and measured loads. Numbers that do not describe a rotation are never used as an
//! orientation.

use faer::{Mat, Side};

use crate::{
    dot::dot,
    import::map::{Angles, Attitude},
    recording::{
        kinetics::{
            Rotation, cross, pull_in_sensor, rotation_from_quaternion,
            rotation_from_roll_pitch_yaw, rotation_from_vector,
        },
        white_noise,
    },
};

/// Maximum deviation of a matrix from a rotation matrix. It applies to each dot product of two rows, which is 1 or 0 for a
/// rotation.
const ROTATION_TOLERANCE: f64 = 0.02;
/// Minimum variance of the direction of gravity in the sensor's frame for which a weight can be estimated.
const MIN_TURNING: f64 = 1e-3;
/// Minimum product of the variances of the direction of gravity along two axes, for which a centre of mass can be estimated.
const MIN_TURNING_TWICE: f64 = 1e-6;

/// Returns the rotation (sensor to world) that these numbers describe. They are in the order of [`Attitude::parts`], angles
/// in rad. `None` if the numbers do not describe a rotation.
pub fn rotation(attitude: Attitude, angles: Angles, numbers: &[f64]) -> Option<Rotation> {
    let rotation = match (attitude, numbers) {
        (Attitude::Quaternion, &[w, x, y, z]) => rotation_from_quaternion([w, x, y, z])?,
        (Attitude::RotationVector, &[x, y, z]) => rotation_from_vector([x, y, z]),
        (Attitude::RollPitchYaw, &[roll, pitch, yaw]) => match angles {
            Angles::FixedXyz => rotation_from_roll_pitch_yaw(roll, pitch, yaw),
            // Rotations about turned axes give the transpose of the rotations about fixed axes by the opposite angles.
            Angles::IntrinsicXyz => {
                let back = rotation_from_roll_pitch_yaw(-roll, -pitch, -yaw);
                std::array::from_fn(|i| std::array::from_fn(|j| back[j][i]))
            }
        },
        (Attitude::Matrix, &[a, b, c, d, e, f, g, h, i]) => [[a, b, c], [d, e, f], [g, h, i]],
        _ => return None,
    };
    is_rotation(&rotation).then_some(rotation)
}

fn difference(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn is_rotation(rotation: &Rotation) -> bool {
    let [x, y, z] = rotation;
    let is = |value: f64, expected: f64| (value - expected).abs() <= ROTATION_TOLERANCE;
    let handedness = dot(x, &cross(*y, *z));
    [x, y, z].into_iter().all(|row| is(dot(row, row), 1.0))
        && is(dot(x, y), 0.0)
        && is(dot(x, z), 0.0)
        && is(dot(y, z), 0.0)
        && is(handedness, 1.0)
}

#[derive(Debug, PartialEq, serde::Serialize)]
pub struct WeightEstimate {
    pub mass_kg: f64,
    /// Centre of mass in the sensor's frame (m). `None` if a moment was not measured, or if the sensor was turned about only
    /// one axis.
    pub centre_m: Option<[f64; 3]>,
    /// Offset (N): force that the reference shows when the sensor carries nothing.
    pub force_offset: [f64; 3],
    /// Offset (N·m): moment that the reference shows when the sensor carries nothing. `None` without a centre of mass.
    pub moment_offset: Option<[f64; 3]>,
    /// Root mean square (N) of the residuals of the forces, over the three axes and all samples.
    pub force_rms: f64,
    pub moment_rms: Option<f64>,
    /// Noise of the forces (N), estimated from their changes from sample to sample.
    pub force_noise: f64,
    /// True if the forces have the opposite sign: the force of the sensor on the weight instead of the load on the sensor.
    pub is_opposite: bool,
    /// True if the forces and moments are given along the axes of the world, so that the pose turns them back.
    pub is_in_world: bool,
    /// Angle (degrees) by which the sensor is turned against the frame of the pose; 0 if it is not.
    pub turned_degrees: f64,
    pub n_samples: usize,
    /// Share of the forces' variance that the weight explains.
    #[serde(skip)]
    pub explained: f64,
}

/// Factor by which a turned sensor must reduce the residuals, so that the turn is taken for real.
const TURN_GAIN: f64 = 2.0;
/// Share of the mass that forces along the axes of the world give, below which the mass in the sensor's frame counts as none.
const WEIGHTLESS_SHARE: f64 = 0.05;
/// Share of the forces' variance below which there is no weight.
const LEAST_EXPLAINED: f64 = 0.1;
/// Factor above the noise from which the residuals are reported.
const NOISE_FACTOR: f64 = 3.0;

impl WeightEstimate {
    /// Returns false if the forces hardly change with the pose, as without a weight.
    pub fn is_certain(&self) -> bool {
        self.explained >= LEAST_EXPLAINED
    }

    /// Returns the estimate in words: one sentence for each estimated quantity.
    pub fn sentences(&self) -> Vec<String> {
        let list = |values: [f64; 3]| values.map(|value| format!("{value:.6}")).join(", ");
        let mut all = vec![
            format!("mass: {:.6} kg, from {} samples", self.mass_kg, self.n_samples),
            match self.centre_m {
                Some(centre) => format!("centre of mass: {} m", list(centre)),
                None => "centre of mass: unknown; to estimate it, measure Mx, My and Mz, and turn the sensor about two axes"
                    .to_owned(),
            },
            format!(
                "offset of the reference force: {} N, RMS of the residuals {:.6} N",
                list(self.force_offset),
                self.force_rms
            ),
        ];
        if let (Some(offset), Some(rms)) = (self.moment_offset, self.moment_rms) {
            let offset = list(offset);
            all.push(format!(
                "offset of the reference moment: {offset} N·m, RMS of the residuals {rms:.6} N·m"
            ));
        }
        if self.is_opposite {
            all.push(
                "the forces have the opposite sign: give the load columns \"scale\": -1".to_owned(),
            );
        }
        if self.is_in_world {
            all.push("the forces are given along the axes of the world; the poses turned them into the sensor's frame".to_owned());
        }
        if self.turned_degrees > 0.0 {
            all.push(format!(
                "the sensor is turned by {:.2}° against the frame of the pose; mass and centre take this into account",
                self.turned_degrees
            ));
        }
        if self.force_rms > NOISE_FACTOR * self.force_noise {
            all.push(format!(
                "the poses explain only part of the forces: {:.3} N remain, with {:.3} N of noise",
                self.force_rms, self.force_noise
            ));
        }
        all
    }
}

/// Estimates the weight by least squares, from one force and one moment for each orientation R of the sensor. The model of
/// the forces is `m Q Rᵀg` plus an offset, that of the moments `m c × Q Rᵀg` plus an offset, with mass m, gravity g and centre
/// of mass c. The turn Q of the sensor against the frame of the pose is the identity, unless another turn explains the forces
/// much better. The sign of the forces is estimated, too, and whether they are given along the axes of the world. Returns `None`
/// if gravity never turned in the sensor's frame, because weight and offset then cannot be separated.
pub fn estimate_weight(
    rotations: &[Rotation],
    forces: &[[f64; 3]],
    moments: Option<&[[f64; 3]]>,
    gravity: [f64; 3],
) -> Option<WeightEstimate> {
    let pulls: Vec<[f64; 3]> = rotations.iter().map(|r| pull_in_sensor(r, gravity)).collect();
    let back = |loads: &[[f64; 3]]| -> Vec<[f64; 3]> {
        rotations.iter().zip(loads).map(|(r, load)| pull_in_sensor(r, *load)).collect()
    };
    let own = estimate(&pulls, forces, moments, gravity)?;
    let turned_moments = moments.map(back);
    let in_world = estimate(&pulls, &back(forces), turned_moments.as_deref(), gravity)?;
    // Constant forces in many poses are an offset without a weight, or a weight along the axes of the world.
    let is_as_good = in_world.force_rms <= TURN_GAIN * own.force_rms.max(own.force_noise);
    let is_weightless = own.mass_kg < WEIGHTLESS_SHARE * in_world.mass_kg;
    let is_in_world = TURN_GAIN * in_world.force_rms.max(in_world.force_noise) < own.force_rms
        || is_as_good && is_weightless;
    let best = if is_in_world { WeightEstimate { is_in_world, ..in_world } } else { own };
    Some(best)
}

/// Does the work of [`estimate_weight`] for forces and moments in the sensor's frame, with gravity in the frame of the pose.
fn estimate(
    pulls: &[[f64; 3]],
    forces: &[[f64; 3]],
    moments: Option<&[[f64; 3]]>,
    gravity: [f64; 3],
) -> Option<WeightEstimate> {
    let n = pulls.len() as f64;
    let mean = |values: &[[f64; 3]]| -> [f64; 3] {
        std::array::from_fn(|i| values.iter().map(|v| v[i]).sum::<f64>() / n)
    };
    let (pull_mean, force_mean) = (mean(pulls), mean(forces));
    let mut spread = [[0.0; 3]; 3];
    let mut common = [[0.0; 3]; 3];
    for (pull, force) in pulls.iter().zip(forces) {
        let (pull, force) = (difference(pull, &pull_mean), difference(force, &force_mean));
        for i in 0..3 {
            for j in 0..3 {
                spread[i][j] += pull[i] * pull[j];
                common[i][j] += force[i] * pull[j];
            }
        }
    }
    let trace = spread[0][0] + spread[1][1] + spread[2][2];
    let scale = n * dot(&gravity, &gravity);
    if trace <= MIN_TURNING * scale {
        return None;
    }
    // `twice` is twice the sum of the products of the variances along two axes. It is zero if the direction of gravity varied
    // along only one line.
    let squares: f64 = spread.iter().flatten().map(|x| x * x).sum();
    let twice = trace * trace - squares;
    let is_turned_twice = twice > MIN_TURNING_TWICE * scale * scale;
    let rms = |pulls: &[[f64; 3]],
               measured: &[[f64; 3]],
               offset: [f64; 3],
               load: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let squares = pulls.iter().zip(measured).map(|(pull, measured)| {
            let left = difference(&difference(measured, &load(*pull)), &offset);
            dot(&left, &left)
        });
        (squares.sum::<f64>() / (3.0 * n)).sqrt()
    };
    // Mass, offset and residual for a turn of the sensor.
    let fitted = |turn: &Rotation| {
        let along: f64 = (0..3).map(|i| dot(&turn[i], &common[i])).sum();
        let mass_kg = along / trace;
        let turned = |pull: [f64; 3]| turn.map(|row| dot(&row, &pull));
        let offset = difference(&force_mean, &turned(pull_mean).map(|pull| mass_kg * pull));
        let left = rms(pulls, forces, offset, &|pull| turned(pull).map(|pull| mass_kg * pull));
        (mass_kg, offset, left)
    };
    const UPRIGHT: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let noise = force_noise(forces);
    let mut turn = UPRIGHT;
    let mut best = fitted(&turn);
    if is_turned_twice {
        for sign in [1.0, -1.0] {
            let signed = common.map(|row| row.map(|x| sign * x));
            if let Some(other) = best_turn(&signed) {
                let found = fitted(&other);
                if TURN_GAIN * found.2.max(noise) < best.2 {
                    (turn, best) = (other, found);
                }
            }
        }
    }
    let (mass_kg, force_offset, force_rms) = best;
    let all = rms(pulls, forces, force_mean, &|_| [0.0; 3]);
    let cosine = (turn[0][0] + turn[1][1] + turn[2][2] - 1.0) / 2.0;
    let is_upright = turn == UPRIGHT;
    let mut estimate = WeightEstimate {
        mass_kg: mass_kg.abs(),
        centre_m: None,
        force_offset,
        moment_offset: None,
        force_rms,
        moment_rms: None,
        force_noise: noise,
        is_opposite: mass_kg < 0.0,
        is_in_world: false,
        turned_degrees: if is_upright { 0.0 } else { cosine.clamp(-1.0, 1.0).acos().to_degrees() },
        n_samples: pulls.len(),
        explained: if all > 0.0 { 1.0 - (force_rms / all).powi(2) } else { 0.0 },
    };
    if let Some(moments) = moments.filter(|_| is_turned_twice) {
        // After subtraction of the means, the moments are `M = d × p`, where `p` is gravity in the sensor's frame and `d = m
        // c`. The normal equations for `d` are `Σ (|p|² I − p pᵀ) d = Σ p × M`.
        let in_sensor = |pull: &[f64; 3]| turn.map(|row| dot(&row, pull));
        let pulls: Vec<[f64; 3]> = pulls.iter().map(in_sensor).collect();
        let (pull_mean, moment_mean) = (mean(&pulls), mean(moments));
        let (mut right, mut spread) = ([0.0; 3], [[0.0; 3]; 3]);
        for (pull, moment) in pulls.iter().zip(moments) {
            let pull = difference(pull, &pull_mean);
            let turned = cross(pull, difference(moment, &moment_mean));
            for i in 0..3 {
                right[i] += turned[i];
                (0..3).for_each(|j| spread[i][j] += pull[i] * pull[j]);
            }
        }
        let matrix: Rotation = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { trace } else { 0.0 } - spread[i][j])
        });
        let first_moment = solve(&matrix, right);
        let offset = difference(&moment_mean, &cross(first_moment, pull_mean));
        let moment = |pull| cross(first_moment, pull);
        estimate.moment_rms = Some(rms(&pulls, moments, offset, &moment));
        estimate.centre_m = Some(first_moment.map(|x| x / mass_kg));
        estimate.moment_offset = Some(offset);
    }
    Some(estimate)
}

/// Returns the noise of forces (N): the root mean square, over the three axes, of the noise of each.
fn force_noise(forces: &[[f64; 3]]) -> f64 {
    let squares = (0..3).map(|axis| {
        let values: Vec<f64> = forces.iter().map(|force| force[axis]).collect();
        white_noise(&values).powi(2)
    });
    (squares.sum::<f64>() / 3.0).sqrt()
}

/// Returns the rotation Q for which the sum of `fᵀ Q p` is largest, from the sum of `f pᵀ`. `None` if all forces are zero.
///
/// **Source** Horn (1987), closed-form solution of absolute orientation using unit quaternions. The quaternion is the eigenvector
/// of the largest eigenvalue of a symmetric matrix.
fn best_turn(common: &Rotation) -> Option<Rotation> {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = *common;
    let rows = [
        [xx + yy + zz, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy],
    ];
    let size: f64 = rows.as_flattened().iter().map(|x| x.abs()).sum();
    if !size.is_finite() || size == 0.0 {
        return None;
    }
    let parts = Mat::from_fn(4, 4, |i, j| rows[i][j]).self_adjoint_eigen(Side::Lower).ok()?;
    // The eigenvalues are in rising order.
    let vector = std::array::from_fn(|i| parts.U()[(i, 3)]);
    rotation_from_quaternion(vector)
}

/// Solves a linear system of three equations by Cramer's rule. The matrix must be symmetric and not singular.
fn solve(matrix: &Rotation, right: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = *matrix;
    let determinant = dot(&x, &cross(y, z));
    [
        dot(&right, &cross(y, z)) / determinant,
        dot(&x, &cross(right, z)) / determinant,
        dot(&x, &cross(y, right)) / determinant,
    ]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::recording::kinetics::{STANDARD_GRAVITY, Weight, load_of_pull};

    const GRAVITY: [f64; 3] = [0.0, 0.0, -STANDARD_GRAVITY];

    fn assert_close(actual: &[f64], expected: &[f64], tolerance: f64) {
        for (a, e) in actual.iter().zip(expected) {
            assert!((a - e).abs() <= tolerance, "{actual:?} is not {expected:?}");
        }
    }

    /// A quarter turn about z takes x to y and y to −x. A quarter turn about x takes y to z and z to −y. Their products were
    /// computed by hand.
    #[test]
    fn every_representation_of_an_orientation_means_the_same() {
        let fixed = Angles::FixedXyz;
        let quarter = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let half = (FRAC_PI_2 / 2.0).sin();
        for (attitude, numbers) in [
            (Attitude::Quaternion, &[half, 0.0, 0.0, half][..]),
            (Attitude::Quaternion, &[-2.0, 0.0, 0.0, -2.0]),
            (Attitude::RotationVector, &[0.0, 0.0, FRAC_PI_2]),
            (Attitude::RollPitchYaw, &[0.0, 0.0, FRAC_PI_2]),
            (Attitude::Matrix, quarter.as_flattened()),
        ] {
            let rotation = rotation(attitude, fixed, numbers).unwrap();
            assert_close(rotation.as_flattened(), quarter.as_flattened(), 1e-15);
        }
        let both = [FRAC_PI_2, 0.0, FRAC_PI_2];
        let of = |angles| rotation(Attitude::RollPitchYaw, angles, &both).unwrap();
        let z_after_x = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let x_after_z = [[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]];
        assert_close(of(fixed).as_flattened(), z_after_x.as_flattened(), 1e-15);
        let intrinsic = of(Angles::IntrinsicXyz);
        assert_close(intrinsic.as_flattened(), x_after_z.as_flattened(), 1e-15);
    }

    #[test]
    fn numbers_that_are_not_a_rotation_are_refused() {
        let of = |attitude, numbers: &[f64]| rotation(attitude, Angles::FixedXyz, numbers);
        assert_eq!(of(Attitude::Quaternion, &[0.0; 4]), None);
        let mirror = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0];
        assert_eq!(of(Attitude::Matrix, &mirror), None);
        assert_eq!(of(Attitude::Matrix, &[1.0; 9]), None);
        assert!(of(Attitude::RotationVector, &[0.0; 3]).is_some());
    }

    #[test]
    fn a_weight_is_found_behind_offsets() {
        let weight = Weight { mass_kg: 1.25, centre_m: [0.02, -0.01, 0.06] };
        let offset = [3.0, -2.0, 1.0, 0.1, 0.2, -0.3];
        let turned =
            |k: u32| rotation_from_roll_pitch_yaw(f64::from(k), 0.7 * f64::from(k * k % 5), 0.3);
        let measured = |rotations: &[Rotation]| -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
            let load = |r: &Rotation| load_of_pull(r, &weight, GRAVITY);
            let part =
                |load: [f64; 6], at: usize| std::array::from_fn(|i| load[at + i] + offset[at + i]);
            rotations.iter().map(|r| (part(load(r), 0), part(load(r), 3))).unzip()
        };
        let rotations: Vec<Rotation> = (0..12).map(turned).collect();
        let (forces, moments) = measured(&rotations);
        let found = estimate_weight(&rotations, &forces, Some(&moments), GRAVITY).unwrap();
        assert_close(&[found.mass_kg], &[1.25], 1e-12);
        assert_close(&found.centre_m.unwrap(), &weight.centre_m, 1e-12);
        assert_close(&found.force_offset, &offset[..3], 1e-11);
        assert_close(&found.moment_offset.unwrap(), &offset[3..], 1e-11);
        assert_close(&[found.force_rms, found.moment_rms.unwrap()], &[0.0; 2], 1e-11);
        // Turned back and forth along one line of gravity: the mass can be estimated, the centre cannot.
        let line: Vec<Rotation> = [0.0, std::f64::consts::PI]
            .map(|roll| rotation_from_roll_pitch_yaw(roll, 0.0, 0.0))
            .into();
        let (forces, moments) = measured(&line);
        let found = estimate_weight(&line, &forces, Some(&moments), GRAVITY).unwrap();
        assert_eq!(found.centre_m, None);
        let still = vec![turned(1); 5];
        let (forces, moments) = measured(&still);
        assert_eq!(estimate_weight(&still, &forces, Some(&moments), GRAVITY), None);
    }

    /// Deterministic noise between -1 and 1.
    fn noise(k: usize) -> f64 {
        ((k as f64 * 12.9898).sin() * 43_758.547).fract()
    }

    /// A weight of 1.93 kg in 40 poses, held for 12 samples each, with 0.05 N of noise. Its forces are as they are, with the
    /// opposite sign, from a sensor turned by 30° about z, and along the axes of the world.
    #[test]
    fn sign_turn_and_frame_of_the_forces_are_estimated() {
        let weight = Weight { mass_kg: 1.93, centre_m: [-0.0325, 0.0, 0.067] };
        let rotations: Vec<Rotation> = (0..480)
            .map(|k| {
                let pose = (k / 12) as f64;
                rotation_from_roll_pitch_yaw(0.7 * pose, 0.4 * pose + 0.3, 1.1 * pose)
            })
            .collect();
        let turn = rotation_from_roll_pitch_yaw(0.0, 0.0, 30_f64.to_radians());
        let turned = |by: &Rotation, v: [f64; 3]| by.map(|row| dot(&row, &v));
        for case in ["plain", "opposite", "turned", "world"] {
            let (mut forces, mut moments) = (Vec::new(), Vec::new());
            for (k, rotation) in rotations.iter().enumerate() {
                let own = load_of_pull(rotation, &weight, GRAVITY);
                let (force, moment) = ([own[0], own[1], own[2]], [own[3], own[4], own[5]]);
                let change = |v: [f64; 3]| match case {
                    "opposite" => v.map(|x| -x),
                    "turned" => turned(&turn, v),
                    "world" => turned(rotation, v),
                    _ => v,
                };
                let force = change(force);
                forces.push(std::array::from_fn(|i| force[i] + 0.05 * noise(3 * k + i)));
                moments.push(change(moment));
            }
            let found = estimate_weight(&rotations, &forces, Some(&moments), GRAVITY).unwrap();
            assert!((found.mass_kg - 1.93).abs() < 0.002, "{case}: {found:?}");
            assert_eq!(found.is_opposite, case == "opposite", "{case}");
            assert_eq!(found.is_in_world, case == "world", "{case}");
            let degrees = if case == "turned" { 30.0 } else { 0.0 };
            assert!((found.turned_degrees - degrees).abs() < 0.1, "{case}: {found:?}");
            assert!(found.force_rms < 3.0 * found.force_noise, "{case}: {found:?}");
            let centre = found.centre_m.unwrap();
            if case != "turned" {
                assert_close(&centre, &weight.centre_m, 1e-3);
            }
        }
        // A force that no pose explains is more than the noise.
        let other: Vec<[f64; 3]> =
            (0..480).map(|k| [noise(k / 12), 5.0 * noise(k / 12 + 7), 1.0]).collect();
        let found = estimate_weight(&rotations, &other, None, GRAVITY).unwrap();
        assert!(found.force_rms > NOISE_FACTOR * found.force_noise, "{found:?}");
    }
}
