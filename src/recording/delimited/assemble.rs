//! Recordings from rows: the times settled, what is odd noted, cut where a recording ends.

use std::path::Path;

use super::header::{Header, Use};
use super::rows::Rows;
use super::warning::{Finding, LoadWarning};
use super::{Loaded, ReadError, timeline};
use crate::recording::units::TimeUnit;
use crate::recording::{Recording, Source};

/// More cuts mean that the times are no times; so many recordings would only fill the memory.
const RECORDING_LIMIT: usize = 50_000;

/// Why no row is usable.
pub(super) fn why_nothing_is_usable(path: &Path, header: &Header, rows: Rows) -> ReadError {
    let path_buf = path.to_owned();
    let n_full_rows = rows.n_skipped - rows.findings.short_rows();
    let is_culprit = |&&n_bad: &&u64| n_bad > 0 && n_bad == n_full_rows;
    let mut culprits = rows
        .bad_cells
        .iter()
        .enumerate()
        .filter(|(_, n_bad)| is_culprit(n_bad))
        .map(|(index, _)| index);
    if let (Some(index), None) = (culprits.next(), culprits.next()) {
        return ReadError::NoNumberInColumn {
            path: path_buf,
            line: header.line,
            what: header.uses[index].noun(),
            column: index + 1,
            name: header.names[index].clone(),
        };
    }
    let skips_row = |warning: &LoadWarning| {
        matches!(
            warning.finding,
            Finding::EmptyCell { .. }
                | Finding::NotANumber { .. }
                | Finding::NotFinite { .. }
                | Finding::TooFewCells { .. }
        )
    };
    let warnings = rows.findings.into_warnings(path);
    match warnings.into_iter().find(skips_row) {
        Some(first) => ReadError::NoUsableRow {
            first: Box::new(first),
        },
        None => ReadError::NoRows {
            path: path_buf,
            line: header.line,
        },
    }
}

/// Settles the times, notes what is odd, and cuts the rows into recordings.
pub(super) fn recordings(path: &Path, header: Header, mut rows: Rows) -> Result<Loaded, ReadError> {
    let column_of = |usage: Use| header.uses.iter().position(|other| *other == usage);
    let time = column_of(Use::Time).expect("a header has a time column");
    let unit = header.time_unit.unwrap_or_else(|| {
        let unit = timeline::unit_by_values(&rows.times);
        if unit != TimeUnit::Seconds {
            let finding = Finding::AssumedTimeUnit {
                column: time + 1,
                name: header.names[time].clone(),
                unit,
            };
            rows.findings.note(header.line, finding);
        }
        unit
    });
    if unit != TimeUnit::Seconds {
        for time in &mut rows.times {
            *time /= unit.per_second();
        }
    }
    note_constant_gauges(&header, &mut rows);
    let cuts = timeline::cuts(&rows.times);
    if cuts.starts.len() >= RECORDING_LIMIT {
        return Err(ReadError::TooManyRecordings {
            path: path.to_owned(),
            line: rows.line_of(cuts.starts[0]),
            count: cuts.starts.len(),
            column: time + 1,
            name: header.names[time].clone(),
        });
    }
    cuts.note(&mut rows);
    let findings = std::mem::take(&mut rows.findings);
    Ok(Loaded {
        recordings: cut(path, header, rows, &cuts.starts),
        warnings: findings.into_warnings(path),
    })
}

fn note_constant_gauges(header: &Header, rows: &mut Rows) {
    if rows.times.len() < 2 {
        return;
    }
    let n_gauges = header.gauge_names.len();
    let columns = (0..header.uses.len()).filter(|&index| header.uses[index] == Use::Gauge);
    for (gauge, column) in columns.enumerate() {
        let value = rows.gauges[gauge];
        let mut values = rows.gauges[gauge..].iter().step_by(n_gauges);
        if values.all(|other| *other == value) {
            let finding = Finding::ConstantGauge {
                column: column + 1,
                name: header.gauge_names[gauge].clone(),
                value,
            };
            rows.findings.note(header.line, finding);
        }
    }
}

/// Cuts from the end, so that what is left needs no copy, and a file with one recording none at all.
fn cut(path: &Path, header: Header, rows: Rows, starts: &[usize]) -> Vec<Recording> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = |part: usize| {
        if starts.is_empty() {
            stem.to_string()
        } else {
            format!("{stem} #{part}")
        }
    };
    let Rows {
        mut times,
        mut gauges,
        mut loads,
        ..
    } = rows;
    let make = |part, times, gauges, loads| {
        Recording::new(
            name(part),
            Source::File(path.to_owned()),
            times,
            header.gauge_names.clone(),
            gauges,
            header.axes.clone(),
            loads,
        )
        .expect("rows are finite and of one width, and each recording's times never go back")
    };
    let mut recordings = Vec::with_capacity(starts.len() + 1);
    for (index, &start) in starts.iter().enumerate().rev() {
        let tails = (
            times.split_off(start),
            gauges.split_off(start * header.gauge_names.len()),
            loads.split_off(start * header.axes.len()),
        );
        recordings.push(make(index + 2, tails.0, tails.1, tails.2));
        for left in [&mut times, &mut gauges, &mut loads] {
            // Now and then only: each time would make many cuts slow.
            if left.len() < left.capacity() / 4 * 3 {
                left.shrink_to_fit();
            }
        }
    }
    for left in [&mut times, &mut gauges, &mut loads] {
        left.shrink_to_fit();
    }
    recordings.push(make(1, times, gauges, loads));
    recordings.reverse();
    recordings
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::super::tests::TestFile;
    use super::*;

    fn load(text: &str) -> (Vec<Recording>, Vec<Finding>) {
        let loaded = TestFile::new(text).read().unwrap();
        let findings = loaded.warnings.into_iter().map(|warning| warning.finding);
        (loaded.recordings, findings.collect())
    }

    #[test]
    fn seconds_stay_exactly_as_written() {
        let (recordings, findings) = load("time,S1\n0.1,1\n0.30000000000000004,2\n");
        assert_eq!(recordings[0].times(), [0.1, 0.300_000_000_000_000_04]);
        assert_eq!(findings, []);
    }

    #[test]
    fn an_assumed_time_unit_is_told() {
        let (recordings, findings) = load("S1,time\n1,0\n2,3\n4,6\n");
        assert_eq!(recordings[0].times(), [0.0, 0.003, 0.006]);
        let told = Finding::AssumedTimeUnit {
            column: 2,
            name: "time".into(),
            unit: TimeUnit::Milliseconds,
        };
        assert_eq!(findings, [told]);
        let (recordings, findings) = load("S1,time_s\n1,0\n2,3\n4,6\n");
        assert_eq!(recordings[0].times(), [0.0, 3.0, 6.0]);
        assert_eq!(findings, []);
    }

    #[test]
    fn a_constant_gauge_is_told_and_stays() {
        let (recordings, findings) = load("S1,S2,t,S3\n7,1,0,2\n7,2,0.1,2\n");
        assert_eq!(recordings[0].n_gauges(), 3);
        let constant = |column, name: &str, value| Finding::ConstantGauge {
            column,
            name: name.into(),
            value,
        };
        let told = [constant(1, "S1", 7.0), constant(4, "S3", 2.0)];
        assert_eq!(findings, told);
        assert_eq!(load("t,S1\n0,1\n").1, []);
    }

    #[test]
    fn a_pause_or_a_step_back_starts_a_recording() {
        let text = "t,S1,Fx\n0,1,1\n0.1,2,2\n0.2,3,3\n9,4,4\n\n9.1,5,5\n0,6,6\n0,7,7\n";
        let loaded = TestFile::new(text).read().unwrap();
        let names: Vec<_> = loaded.recordings.iter().map(Recording::name).collect();
        assert_eq!(names, ["run #1", "run #2", "run #3"]);
        assert_eq!(loaded.recordings[1].times(), [9.0, 9.1]);
        assert_eq!(loaded.recordings[2].loads(), [6.0, 7.0]);
        let [cut, repeat] = &loaded.warnings[..] else {
            panic!("two warnings: {:?}", loaded.warnings)
        };
        assert_eq!((cut.first_line, cut.last_line, cut.count), (5, 8, 2));
        let told = Finding::NewRecording {
            from_secs: 0.2,
            to_secs: 9.0,
        };
        assert_eq!(cut.finding, told);
        assert_eq!((repeat.first_line, repeat.count), (9, 1));
        assert_eq!(repeat.finding, Finding::RepeatedTime { time_secs: 0.0 });
    }

    #[test]
    fn thousands_of_cuts_are_one_warning() {
        let mut text = String::from("t,S1\n");
        for row in 0..20_000 {
            writeln!(text, "{},{row}", row % 2).unwrap();
        }
        let (recordings, findings) = load(&text.replace("t,", "t_s,"));
        assert_eq!((recordings.len(), findings.len()), (10_000, 1));
        assert_eq!(recordings[4_321].gauges(), [8_642.0, 8_643.0]);
        assert_eq!(recordings[9_999].name(), "run #10000");
    }

    #[test]
    fn times_that_are_none_are_an_error() {
        let mut text = String::from("# count\nt,S1\n");
        for row in 0..60_000 {
            writeln!(text, "{},{row}", 60_000 - row).unwrap();
        }
        let error = TestFile::new(text).read().unwrap_err();
        assert!(matches!(
            error,
            ReadError::TooManyRecordings {
                line: 4,
                count: 59_999,
                ..
            }
        ));
    }
}
