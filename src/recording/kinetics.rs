//! Load of a weight that hangs from a sensor, computed from the sensor's attitude (orientation). The attitude is given as a
//! quaternion, a rotation vector, or roll, pitch and yaw. If the weight does not accelerate, the force never exceeds `m·g`
//! except by rounding.

use serde::{Deserialize, Serialize};

/// Standard gravity in m/s².
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// Attitude R of a sensor: the rows of the rotation matrix from sensor to world coordinates. The world's z axis points up.
pub type Rotation = [[f64; 3]; 3];

/// Weight that a sensor carries, such as a tool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Weight {
    /// Mass (kg).
    pub mass_kg: f64,
    /// Centre of mass r of the weight in the sensor's frame (m).
    pub centre_m: [f64; 3],
}

/// Returns the load `[Fx, Fy, Fz, Mx, My, Mz]` (N, N·m) of a weight at rest, at the origin and in the axes of the sensor: `F
/// = m Rᵀ g`, `M = r × F`.
///
/// **Source** Koike et al. 2019: the load L of Eq. 1, computed from the robot's attitude as in section 4.1.2.
pub fn gravity_load(sensor_to_world: &Rotation, weight: &Weight) -> [f64; 6] {
    // Gravity points along −z of the world. In the sensor's axes, the world's z axis is the last row of R.
    let pull = -weight.mass_kg * STANDARD_GRAVITY;
    with_moments(sensor_to_world[2].map(|along_up| pull * along_up), weight)
}

/// Returns the load of an accelerated weight, in the form of [`gravity_load`]: `F = m Rᵀ (g − a)`, `M = r × F`. `pull` is
/// gravity minus the acceleration of the weight's centre (m/s², in the world's axes).
pub fn load_of_pull(sensor_to_world: &Rotation, weight: &Weight, pull: [f64; 3]) -> [f64; 6] {
    let force = pull_in_sensor(sensor_to_world, pull).map(|pull| weight.mass_kg * pull);
    with_moments(force, weight)
}

/// Converts the vector `pull` from the world's axes to the sensor's axes: `Rᵀ pull`.
pub fn pull_in_sensor(sensor_to_world: &Rotation, pull: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = sensor_to_world;
    std::array::from_fn(|i| x[i] * pull[0] + y[i] * pull[1] + z[i] * pull[2])
}

fn with_moments(force @ [fx, fy, fz]: [f64; 3], weight: &Weight) -> [f64; 6] {
    let [mx, my, mz] = cross(weight.centre_m, force);
    [fx, fy, fz, mx, my, mz]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the attitude that a quaternion `[w, x, y, z]` of any length describes, or `None` if its length is zero.
pub fn rotation_from_quaternion(quaternion: [f64; 4]) -> Option<Rotation> {
    let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length <= 1e-9 || !length.is_finite() {
        return None;
    }
    let [w, x, y, z] = quaternion.map(|part| part / length);
    Some([
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ])
}

/// Returns the attitude after a rotation about a vector. The vector's length is the angle (rad).
pub fn rotation_from_vector(vector: [f64; 3]) -> Rotation {
    let angle = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    // If the angle tends to zero, sin(angle / 2) / angle tends to one half.
    let share = if angle > 0.0 { (angle / 2.0).sin() / angle } else { 0.5 };
    let [x, y, z] = vector.map(|part| share * part);
    rotation_from_quaternion([(angle / 2.0).cos(), x, y, z]).unwrap_or([[f64::NAN; 3]; 3])
}

/// Returns the attitude after rotations (rad) by `roll` about the world's x axis, then `pitch` about y, then `yaw` about z.
pub fn rotation_from_roll_pitch_yaw(roll: f64, pitch: f64, yaw: f64) -> Rotation {
    let (sin_roll, cos_roll) = roll.sin_cos();
    let (sin_pitch, cos_pitch) = pitch.sin_cos();
    let x = [cos_pitch, sin_pitch * sin_roll, sin_pitch * cos_roll];
    let y = [0.0, cos_roll, -sin_roll];
    let (sin, cos) = yaw.sin_cos();
    [
        std::array::from_fn(|i| cos * x[i] - sin * y[i]),
        std::array::from_fn(|i| sin * x[i] + cos * y[i]),
        [-sin_pitch, cos_pitch * sin_roll, cos_pitch * cos_roll],
    ]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn assert_close(actual: [f64; 6], expected: [f64; 6]) {
        for (a, e) in actual.iter().zip(expected) {
            assert!((a - e).abs() < 1e-12, "{actual:?} is not {expected:?}");
        }
    }

    /// With `m g = W` and `r = (x, y, z)`: level, F = (0, 0, −W) and M = r × F = (−yW, xW, 0). Rolled by 90°, the y axis
    /// points up: F = (0, −W, 0) and M = (zW, 0, −xW). Pitched by 90°, the x axis points down: F = (W, 0, 0) and M = (0, zW,
    /// −yW).
    #[test]
    fn quarter_turns_give_known_loads() {
        let [x, y, z] = [0.02, 0.015, 0.03];
        let weight = Weight { mass_kg: 2.0, centre_m: [x, y, z] };
        let w = 2.0 * STANDARD_GRAVITY;
        let load =
            |roll, pitch| gravity_load(&rotation_from_roll_pitch_yaw(roll, pitch, 0.0), &weight);
        assert_close(load(0.0, 0.0), [0.0, 0.0, -w, -y * w, x * w, 0.0]);
        assert_close(load(FRAC_PI_2, 0.0), [0.0, -w, 0.0, z * w, 0.0, -x * w]);
        assert_close(load(0.0, FRAC_PI_2), [w, 0.0, 0.0, 0.0, z * w, -y * w]);
    }

    #[test]
    fn attitudes_are_rotations() {
        for (roll, pitch) in [(0.0, 0.0), (0.4, -1.3), (-3.0, 1.5), (2.0, 0.7)] {
            let r = rotation_from_roll_pitch_yaw(roll, pitch, 0.0);
            for i in 0..3 {
                for j in 0..3 {
                    let dot: f64 = (0..3).map(|k| r[i][k] * r[j][k]).sum();
                    let unit = if i == j { 1.0 } else { 0.0 };
                    assert!((dot - unit).abs() < 1e-12);
                }
            }
        }
    }
}
