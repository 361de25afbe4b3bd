//! Sensor frame: turn and shift from the frame in which the reference load was measured (the gauge frame) to the frame in
//! which the calibration gives loads, such as a robot's flange.
//!
//! Guarantees: a frame changes only reference loads, before anything is fitted. So every error, figure and exported matrix is
//! in the sensor frame.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{
    axis::Axis,
    kinetics::{Rotation, cross, rotation_from_roll_pitch_yaw},
};
use crate::shown::joined;

/// Turn and shift of the gauge frame in the sensor frame, as in a `<origin xyz rpy>` of URDF. The turn is R = Rz Ry Rx: first
/// about the fixed axis x of the sensor frame, then about y, then about z. The shift p leads from the origin of the sensor frame
/// to that of the gauge frame. A load (F, M) in the gauge frame is `F' = R F`, `M' = R M + p × F'` in the sensor frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorFrame {
    /// Angles of the turn about x, y and z (degrees), in this order.
    pub turn_degrees: [f64; 3],
    /// Origin of the gauge frame, in the axes of the sensor frame (m).
    pub shift_metres: [f64; 3],
}

/// Matrix that takes a load with six axes from one frame to another.
type LoadMatrix = [[f64; 6]; 6];

/// Magnitude below which an entry of the turn is a rounding error of a right angle.
const ROUNDING: f64 = 1e-15;

fn turned(turn: &Rotation, vector: [f64; 3]) -> [f64; 3] {
    turn.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
}

fn transposed(turn: &Rotation) -> Rotation {
    std::array::from_fn(|i| turn.map(|row| row[i]))
}

/// Returns the matrix of a load with a turn R and a shift p: `[[R, 0], [[p]× R, R]]`.
fn load_matrix(turn: &Rotation, shift: [f64; 3]) -> LoadMatrix {
    let levers = transposed(&transposed(turn).map(|column| cross(shift, column)));
    std::array::from_fn(|i| {
        std::array::from_fn(|j| match (i / 3, j / 3) {
            (0, 0) | (1, 1) => turn[i % 3][j % 3],
            (1, 0) => levers[i % 3][j],
            _ => 0.0,
        })
    })
}

impl SensorFrame {
    /// Returns the frame; `None` if it neither turns nor shifts loads. The error is a reason why its numbers are not usable.
    pub fn checked(self) -> Result<Option<Self>, &'static str> {
        if !self.turn_degrees.iter().chain(&self.shift_metres).all(|value| value.is_finite()) {
            return Err("turn_degrees and shift_metres need three finite numbers each");
        }
        Ok(Some(self).filter(|frame| *frame != Self::default()))
    }

    fn turn(&self) -> Rotation {
        let [x, y, z] = self.turn_degrees.map(f64::to_radians);
        let turn = rotation_from_roll_pitch_yaw(x, y, z);
        turn.map(|row| row.map(|entry| if entry.abs() < ROUNDING { 0.0 } else { entry }))
    }

    /// Returns the 6 × 6 matrix that takes a load from the gauge frame to the sensor frame.
    pub fn matrix(&self) -> LoadMatrix {
        load_matrix(&self.turn(), self.shift_metres)
    }

    fn inverse_matrix(&self) -> LoadMatrix {
        let back = transposed(&self.turn());
        load_matrix(&back, turned(&back, self.shift_metres).map(|value| -value))
    }

    /// Returns a point (m) of the gauge frame in the sensor frame.
    pub fn point(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = turned(&self.turn(), point);
        std::array::from_fn(|i| turned[i] + self.shift_metres[i])
    }

    /// Returns the matrix that takes loads with these axes from one frame to another; `None` stands for the gauge frame. The
    /// error is an axis, and an axis that the frame mixes with it but that is not there.
    pub fn between(
        from: Option<Self>,
        to: Option<Self>,
        axes: &[Axis],
    ) -> Result<Vec<Vec<f64>>, (Axis, Axis)> {
        let to_sensor = to.unwrap_or_default().matrix();
        let from_sensor = from.unwrap_or_default().inverse_matrix();
        let all = |i: usize, j: usize| -> f64 {
            (0..Axis::ALL.len()).map(|k| to_sensor[i][k] * from_sensor[k][j]).sum()
        };
        let row = |axis: &Axis| {
            let at = *axis as usize;
            let mixed = Axis::ALL.iter().filter(|other| !axes.contains(other));
            let missing = mixed.copied().find(|other| all(at, *other as usize).abs() > ROUNDING);
            match missing {
                Some(missing) => Err((*axis, missing)),
                None => Ok(axes.iter().map(|other| all(at, *other as usize)).collect()),
            }
        };
        axes.iter().map(row).collect()
    }
}

/// Multiplies each row of loads (`n × n_axes` row-major) by a matrix of [`SensorFrame::between`].
pub(crate) fn change_frame(loads: &[f64], matrix: &[Vec<f64>]) -> Vec<f64> {
    let rows = loads.chunks_exact(matrix.len().max(1));
    let changed = rows.flat_map(|load| {
        matrix.iter().map(move |row| row.iter().zip(load).map(|(a, b)| a * b).sum::<f64>())
    });
    changed.collect()
}

impl fmt::Display for SensorFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [turn, shift] = [self.turn_degrees, self.shift_metres].map(|of| joined(", ", of));
        write!(
            f,
            "gauge frame turned by {turn} degrees about the fixed axes x, y, z of the sensor frame, its origin at {shift} m"
        )
    }
}
