//! Option `--traces` of `fit` and `apply`: writes loads and their errors over time as one table.

use std::path::PathBuf;

use clap::{Args, builder::TypedValueParser};

use super::{error::JobError, values::named_file};
use crate::{
    calibration::Calibration,
    export::{FileFormat, TRACE_FORMATS, Together, write_traces},
    progress::Progress,
    questions::intervals_within,
    recording::Recording,
};

#[derive(Debug, Args)]
pub struct TraceArgs {
    #[arg(long, help = traces_help(), value_name = "FILE", value_parser = traces_file())]
    pub traces: Option<PathBuf>,
}

fn traces_help() -> String {
    let endings = FileFormat::listed(TRACE_FORMATS);
    format!(
        "Write reference, uncompensated and compensated loads and the errors of every sample to one table: {endings}"
    )
}

fn traces_file() -> impl TypedValueParser<Value = PathBuf> {
    named_file().try_map(|path| match FileFormat::for_path(TRACE_FORMATS, &path) {
        Some(_) => Ok(path),
        None => Err(format!(
            "traces cannot be written in the format of this file name ending; use {}",
            FileFormat::listed(TRACE_FORMATS)
        )),
    })
}

impl TraceArgs {
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
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        let intervals = intervals_within(recordings, decimation, all);
        Ok(write_traces(files, path, calibration, &intervals, &Progress::default())?)
    }
}
