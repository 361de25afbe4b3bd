//! `loopscope sensor`: prints a template of `sensor.toml`, the file that describes a sensor.

use std::io::Write as _;

use clap::Args;

use super::{
    error::JobError,
    run::{Run, Work, examples},
};
use crate::recording::Item;

/// Print a template of sensor.toml, the file that describes a sensor.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope sensor", "prints a template to fill in and save as sensor.toml"),
]))]
pub struct SensorJob {}

impl Work for SensorJob {
    fn run(&self, run: &Run) -> Result<(), JobError> {
        run.print_text(|out| {
            for item in Item::all() {
                writeln!(out, "{} = \"\"  # {}: {}", item.key(), item.label(), item.placeholder())?;
            }
            writeln!(
                out,
                "\n# In N and N·m. An axis that is not listed takes the largest load of the recordings.\n[rated_loads]\n# Fx = 100\n\n# Frame of the loads: the gauge frame, in which the reference was measured, is turned about the fixed axes x, y, z and then\n# shifted, as in <origin xyz rpy> of URDF.\n[frame]\n# turn_degrees = [0, 0, 90]\n# shift_metres = [0, 0, 0.05]"
            )
        })
    }
}
