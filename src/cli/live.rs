//! `loopscope apply CAL -` and `--follow`: each sample is answered as it comes.

use std::io::{self, BufRead as _};
use std::path::Path;

use super::{JobError, tell};
use crate::calibration::{Calibration, Estimator};
use crate::export::{LiveSample, LoadRows, name_gauges};
use crate::import::live::{GrowingFile, Grown, LiveRow, LiveTable};
use crate::import::map::ColumnMap;
use crate::recording::Axis;
use crate::recording::gap::pause_by_step;

/// So many lines that are no rows are told of one by one.
const TOLD_ONE_BY_ONE: u64 = 5;

/// Answers standard input until it ends.
///
/// # Errors
/// [`JobError`] if no table begins there, it has not the gauges, or nobody reads the answers.
pub fn standard_input(tap: Tap) -> Result<(), JobError> {
    let mut lines = io::stdin().lock();
    let mut bytes = Vec::new();
    tap.answer(&mut || {
        bytes.clear();
        let n = lines.read_until(b'\n', &mut bytes)?;
        let text = String::from_utf8_lossy(&bytes);
        let line = text.trim_end_matches(['\r', '\n']).to_owned();
        Ok((n > 0).then_some(Grown::Line(line)))
    })
}

/// Answers a file from its beginning, and then what is written to it, until somebody ends the program.
///
/// # Errors
/// As [`standard_input`], or if the file cannot be read.
pub fn follow(tap: Tap, path: &Path) -> Result<(), JobError> {
    let unreadable = |source: io::Error| JobError::Follow {
        path: path.to_owned(),
        source,
    };
    let mut file = GrowingFile::open(path).map_err(unreadable)?;
    tap.answer(&mut || {
        let grown = file.look()?;
        if grown == Grown::Replaced {
            tell(&format_args!(
                "note: {}: another file has taken its place, or it was cut; it is followed from its beginning",
                path.display()
            ));
        }
        Ok(Some(grown))
    })
}

/// What answers samples.
#[derive(Debug)]
pub struct Tap {
    /// Its calibration.
    pub calibration: Calibration,
    /// Whether that names its gauges; else they are taken in order.
    pub names_gauges: bool,
    /// What the columns are, where somebody says so.
    pub map: Option<ColumnMap>,
}

impl Tap {
    fn answer(
        mut self,
        next: &mut dyn FnMut() -> io::Result<Option<Grown>>,
    ) -> Result<(), JobError> {
        let mut out = None;
        let mut n_broken = 0;
        while let Some((mut table, rows)) = self.begin(next)? {
            if !self.names_gauges {
                name_gauges(&mut self.calibration, table.gauge_names());
            }
            let places = table.places(&self.calibration.gauges);
            let places = places.ok_or_else(|| JobError::LiveGauges {
                expected: self.calibration.gauges.clone(),
                actual: table.gauge_names().to_vec(),
            })?;
            let design = self.calibration.design();
            let mut estimator = Estimator::new(&self.calibration, &design)
                .map_err(|error| JobError::Output(io::Error::other(error)))?;
            let out = match &mut out {
                Some(out) => out,
                None => {
                    let axes: Vec<Axis> = table.axes().to_vec();
                    out.insert(LoadRows::new(
                        &self.calibration,
                        axes,
                        true,
                        io::stdout().lock(),
                    )?)
                }
            };
            let needed = self.calibration.features.auxiliary_names();
            let auxiliary_places = table.auxiliary_places(&needed);
            let auxiliary_places =
                auxiliary_places.map_err(|channel| JobError::LiveAuxiliary { channel })?;
            let gap_secs = self.calibration.gap_secs;
            let mut auxiliary = vec![0.0; auxiliary_places.len()];
            let mut gauges = vec![0.0; places.len()];
            let mut write = |row: Option<LiveRow>, axes: &[Axis]| {
                for (gauge, place) in gauges.iter_mut().zip(&places) {
                    *gauge = row.as_ref().map_or(f64::NAN, |row| row.gauges[*place]);
                }
                for (value, place) in auxiliary.iter_mut().zip(&auxiliary_places) {
                    *value = row.as_ref().map_or(f64::NAN, |row| row.auxiliary[*place]);
                }
                let is_old = |(age, step): (f64, f64)| age > gap_secs.max(pause_by_step(step));
                let is_held = row.as_ref().is_some_and(|row| {
                    let mut own = auxiliary_places.iter().map(|at| row.auxiliary_ages[*at]);
                    own.any(is_old)
                });
                let sample = row.as_ref().map(|row| LiveSample {
                    time: row.time,
                    gauges: &gauges,
                    auxiliary: &auxiliary,
                    reference: (axes, &row.loads),
                    is_held,
                });
                out.write(&mut estimator, sample)?;
                out.flush()
            };
            let axes = table.axes().to_vec();
            for row in rows {
                write(Some(row), &axes)?;
            }
            loop {
                match next()? {
                    None => {
                        if n_broken > TOLD_ONE_BY_ONE {
                            tell(&format_args!("warning: {n_broken} lines were no rows"));
                        }
                        return Ok(());
                    }
                    Some(Grown::Nothing) => {}
                    Some(Grown::Replaced) => break,
                    Some(Grown::Line(line)) => {
                        let row = table.row(&line);
                        if row.is_none() {
                            n_broken += 1;
                            if n_broken <= TOLD_ONE_BY_ONE {
                                tell(&format_args!("warning: a line is no row: {line}"));
                            }
                        }
                        write(row, &axes)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Reads up to the first row; `None` where nothing comes.
    fn begin(
        &self,
        next: &mut dyn FnMut() -> io::Result<Option<Grown>>,
    ) -> Result<Option<(LiveTable, Vec<LiveRow>)>, JobError> {
        let mut head = Vec::new();
        loop {
            match next()? {
                None if head.is_empty() => return Ok(None),
                None => return Ok(Some(LiveTable::of_all(&head, self.map.as_ref())?)),
                Some(Grown::Nothing) => {}
                Some(Grown::Replaced) => head.clear(),
                Some(Grown::Line(line)) => {
                    head.push(line);
                    if let Some(begun) = LiveTable::begin(&head, self.map.as_ref())? {
                        return Ok(Some(begun));
                    }
                }
            }
        }
    }
}
