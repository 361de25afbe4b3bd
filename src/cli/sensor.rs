//! `loopscope sensor`: a description of a sensor to fill in.

use std::io::Write as _;

use clap::Args;

use super::error::JobError;
use super::examples::examples;
use super::run::{Run, Work};
use crate::recording::Item;

/// Print a description of a sensor to fill in: `sensor.toml`.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope sensor", "a description to fill in and keep as sensor.toml"),
]))]
pub struct SensorJob {}

impl Work for SensorJob {
    fn run(&self, run: &Run) -> Result<(), JobError> {
        run.print_text(|out| {
            for item in Item::all() {
                writeln!(out, "{} = \"\"  # {}: {}", item.key(), item.label(), item.hint())?;
            }
            writeln!(
                out,
                "\n# In N and N·m; an axis that is not named has what the recordings reach\n[rated_loads]\n# Fx = 100"
            )
        })
    }
}
