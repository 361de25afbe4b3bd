//! Option `--traces` of `fit` and `apply`: writes loads and their errors over time as one table.

use std::path::PathBuf;

use clap::Args;

use super::error::{JobError, failed, usage};
use super::values::named_file;
use crate::{
    calibration::Calibration,
    export::{FileFormat, TRACE_FORMATS, Together, write_traces},
    progress::Progress,
    questions::intervals_within,
    recording::Recording,
};

#[derive(Debug, Args)]
pub struct TraceArgs {
    #[arg(long, help = traces_help(), value_name = "FILE", value_parser = named_file())]
    pub traces: Option<PathBuf>,
    /// Start of the written time range in seconds, on the clock of each recording.
    #[arg(long, value_name = "SECONDS", requires = "traces", allow_negative_numbers = true)]
    from: Option<f64>,
    /// End of the written time range in seconds, on the clock of each recording.
    #[arg(long, value_name = "SECONDS", requires = "traces", allow_negative_numbers = true)]
    to: Option<f64>,
}

fn traces_help() -> String {
    let endings = FileFormat::listed(TRACE_FORMATS);
    format!(
        "Write reference, uncompensated and compensated loads and the errors of every sample to one table: {endings}"
    )
}

impl TraceArgs {
    pub fn check(&self) -> Result<(), JobError> {
        let Some(path) = &self.traces else {
            return Ok(());
        };
        if FileFormat::for_path(TRACE_FORMATS, path).is_none() {
            return usage(format!(
                "{}: traces cannot be written in the format of this file name ending; use {}",
                path.display(),
                FileFormat::listed(TRACE_FORMATS)
            ));
        }
        let (from_secs, to_secs) = self.range();
        if from_secs <= to_secs {
            Ok(())
        } else {
            usage(format!(
                "traces from {from_secs} s to {to_secs} s are empty; the start must not be after the end"
            ))
        }
    }

    fn range(&self) -> (f64, f64) {
        (self.from.unwrap_or(f64::NEG_INFINITY), self.to.unwrap_or(f64::INFINITY))
    }

    /// Checks, before the fit, that at least one sample lies in the time range given by `--from` and `--to`.
    pub fn check_intervals<'a>(
        &self,
        recordings: impl Iterator<Item = &'a Recording>,
        decimation: usize,
    ) -> Result<(), JobError> {
        let (from_secs, to_secs) = self.range();
        if self.traces.is_some()
            && intervals_within(recordings, decimation, (from_secs, to_secs)).is_empty()
        {
            return failed(format!(
                "no sample lies between {from_secs} s and {to_secs} s on the clock of its recording; choose other times"
            ));
        }
        Ok(())
    }

    pub fn write<'a>(
        &self,
        files: &mut Together,
        calibration: &Calibration,
        recordings: impl Iterator<Item = &'a Recording>,
        decimation: usize,
    ) -> Result<(), JobError> {
        let Some(path) = &self.traces else {
            return Ok(());
        };
        let (from_secs, to_secs) = self.range();
        let intervals = intervals_within(recordings, decimation, (from_secs, to_secs));
        Ok(write_traces(files, path, calibration, &intervals, &Progress::default())?)
    }
}
