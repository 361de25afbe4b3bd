//! Sensor frame: turn and shift from the frame in which the reference load was measured (the gauge frame) to the frame in
//! which the calibration gives loads, such as a robot's flange.
//!
//! Guarantees: a frame changes only reference loads, before anything is fitted. So every error, figure and exported matrix is
//! in the sensor frame.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{
    axis::Axis,
    kinetics::Weight,
    recording::{Recording, RecordingError},
    shared::Ranged,
};
use crate::shown::joined;

/// Turn and shift of the gauge frame in the sensor frame, as in a `<origin xyz rpy>` of URDF: the turn is R = Rz Ry Rx, by
/// the angles about the fixed axes x, y and z of the sensor frame, and the shift p is the origin of the gauge frame. A load
/// (F, M) in the gauge frame is `F' = R F`, `M' = R M + p × F'` in the sensor frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorFrame {
    /// Angles of the turn about x, y and z (degrees), in this order.
    pub turn_degrees: [f64; 3],
    /// Origin of the gauge frame, in the axes of the sensor frame (m).
    pub shift_metres: [f64; 3],
}

type Matrix<const N: usize> = [[f64; N]; N];

/// Magnitude below which an entry of the turn is a rounding error of a right angle.
const ROUNDING: f64 = 1e-15;

fn product<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..N).map(|k| a[i][k] * b[k][j]).sum()))
}

fn turned(turn: &Matrix<3>, vector: [f64; 3]) -> [f64; 3] {
    turn.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
}

/// Returns the matrix of a load with a turn R and a shift p: `[[R, 0], [[p]× R, R]]`.
fn load_matrix(turn: &Matrix<3>, [x, y, z]: [f64; 3]) -> Matrix<6> {
    let levers = product(&[[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]], turn);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| match (i / 3, j / 3) {
            (0, 0) | (1, 1) => turn[i % 3][j % 3],
            (1, 0) => levers[i % 3][j],
            _ => 0.0,
        })
    })
}

impl SensorFrame {
    /// Returns true if the frame neither turns nor shifts loads.
    pub fn is_identity(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the reason why the numbers of the frame are not usable.
    pub fn wrong(&self) -> Option<&'static str> {
        let all = self.turn_degrees.iter().chain(&self.shift_metres);
        let is_finite = all.fold(true, |known, value| known && value.is_finite());
        (!is_finite).then_some("turn_degrees and shift_metres need three finite numbers each")
    }

    fn turn(&self) -> Matrix<3> {
        let [[sx, cx], [sy, cy], [sz, cz]] = self.turn_degrees.map(|degrees| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            [sine, cosine].map(|value| if value.abs() < ROUNDING { 0.0 } else { value })
        });
        let about_x = [[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]];
        let about_y = [[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]];
        let about_z = [[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]];
        product(&about_z, &product(&about_y, &about_x))
    }

    /// Returns the 6 × 6 matrix that takes a load from the gauge frame to the sensor frame.
    pub fn matrix(&self) -> [[f64; 6]; 6] {
        load_matrix(&self.turn(), self.shift_metres)
    }

    fn inverse_matrix(&self) -> Matrix<6> {
        let turn = self.turn();
        let back = std::array::from_fn(|i| std::array::from_fn(|j| turn[j][i]));
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
        let all = product(&to_sensor, &from.unwrap_or_default().inverse_matrix());
        let row = |axis: &Axis| {
            let at = *axis as usize;
            let mixed = Axis::ALL.iter().filter(|other| !axes.contains(other));
            let missing = mixed.copied().find(|other| all[at][*other as usize].abs() > ROUNDING);
            match missing {
                Some(missing) => Err((*axis, missing)),
                None => Ok(axes.iter().map(|other| all[at][*other as usize]).collect()),
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

impl Recording {
    /// Returns the frame of the reference load; `None` for the frame in which it was measured.
    pub fn frame(&self) -> Option<SensorFrame> {
        self.frame
    }

    /// Returns the recording with the weight from which its reference load was computed, in the gauge frame.
    pub(crate) fn with_tool(mut self, tool: Option<Weight>) -> Self {
        self.tool = tool;
        self
    }

    /// Returns the weight from which the reference load was computed, in the frame of the load.
    pub fn tool(&self) -> Option<Weight> {
        let frame = self.frame.unwrap_or_default();
        self.tool.map(|tool| Weight { centre_m: frame.point(tool.centre_m), ..tool })
    }

    /// Returns the recording with its reference load in another frame. A recording without a reference has any frame.
    ///
    /// # Errors
    /// [`RecordingError::Frame`] if the frame mixes an axis with one that was not measured.
    pub fn in_frame(mut self, frame: Option<SensorFrame>) -> Result<Self, RecordingError> {
        if self.frame == frame || !self.has_reference() {
            return Ok(self);
        }
        let matrix = SensorFrame::between(self.frame, frame, self.axes());
        let matrix = matrix.map_err(|(axis, missing)| {
            let name = self.name().to_owned();
            RecordingError::Frame { name, axis, missing }
        })?;
        self.loads = Ranged::new(change_frame(self.loads(), &matrix), matrix.len());
        self.frame = frame;
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Source;

    fn recording(axes: &[Axis], load: &[f64]) -> Recording {
        let (axes, load) = (axes.to_vec(), load.to_vec());
        Recording::new("a", Source::Simulated, vec![0.0], vec![], vec![], axes, load).unwrap()
    }

    /// Turn by 90° about z: the gauge frame's x axis is the sensor's y axis. At x = 0.1 m, a force of 2 N along the sensor's y has
    /// the moment 0.2 N·m about z.
    #[test]
    fn a_load_is_turned_and_gets_the_moment_of_its_force() {
        let frame = SensorFrame { turn_degrees: [0.0, 0.0, 90.0], shift_metres: [0.1, 0.0, 0.0] };
        let measured = recording(&Axis::ALL, &[2.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
        let framed = measured.clone().in_frame(Some(frame)).unwrap();
        let expected = [0.0, 2.0, 0.0, 0.0, 0.5, 0.2];
        assert!(framed.loads().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
        assert_eq!(framed.frame(), Some(frame));
        let back = framed.in_frame(None).unwrap();
        assert!(back.loads().iter().zip(measured.loads()).all(|(a, b)| (a - b).abs() < 1e-15));
        let carries = measured.with_tool(Some(Weight { mass_kg: 1.5, centre_m: [0.0, 1.0, 2.0] }));
        let tool = carries.in_frame(Some(frame)).unwrap().tool();
        assert_eq!(tool, Some(Weight { mass_kg: 1.5, centre_m: [-0.9, 0.0, 2.0] }));
    }

    /// The order of the angles is that of URDF: first about x, then about the fixed y, then about the fixed z.
    #[test]
    fn the_turns_are_about_fixed_axes() {
        let frame = SensorFrame { turn_degrees: [90.0, 0.0, 90.0], ..SensorFrame::default() };
        let load = recording(&Axis::ALL, &[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        let framed = load.in_frame(Some(frame)).unwrap();
        assert_eq!(framed.loads()[..3], [0.0, 0.0, 1.0], "y to z about x, and z stays about z");
    }

    #[test]
    fn a_frame_needs_the_axes_that_it_mixes() {
        let refused = |turn_degrees, shift_metres, axes: &[Axis]| {
            let frame = SensorFrame { turn_degrees, shift_metres };
            recording(axes, &vec![1.0; axes.len()]).in_frame(Some(frame)).is_err()
        };
        let forces = [Axis::Fx, Axis::Fy, Axis::Fz];
        assert!(!refused([10.0, 20.0, 30.0], [0.1; 3], &forces));
        assert!(refused([10.0, 0.0, 0.0], [0.0; 3], &[Axis::Fz]));
        assert!(!refused([180.0, 0.0, 45.0], [0.0, 0.0, 0.1], &[Axis::Fz]));
        assert!(!refused([0.0; 3], [0.0, 0.0, 0.1], &[Axis::Fy, Axis::Mx, Axis::Mz]));
        assert!(refused([0.0; 3], [0.0, 0.1, 0.0], &[Axis::Fz, Axis::My, Axis::Mz]));
    }
}
