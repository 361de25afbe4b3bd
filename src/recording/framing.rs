//! Brings reference loads into the sensor frame, separately for each recording.
//!
//! Guarantees: only the reference load and the centre of mass of the weight change. A frame that mixes a measured axis with one
//! that was not measured is an error.

use super::{
    frame::{SensorFrame, change_frame},
    kinetics::Weight,
    recording::{Recording, RecordingError},
    shared::Ranged,
};

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
    use crate::recording::{Axis, Source};

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
