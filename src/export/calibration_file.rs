//! Writes and reads calibration files. A JSON file holds the whole calibration, so that it gives the same loads when it is
//! read back. Files of other formats hold a part.

use std::io;
use std::path::{Path, PathBuf};

use super::target::{Refusal, Target, of_target};
use super::targets::{self, TARGETS, asks_for_folder, target_for};
use crate::{
    calibration::Calibration,
    export::atomic::{Together, WriteError},
    shown::joined,
    small_file::read_small,
};

const LARGEST_FILE_BYTES: u64 = 64 << 20;

#[derive(Debug, thiserror::Error)]
pub enum ReadCalibrationError {
    #[error("cannot read {}: {source}", .path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{}: {source}", .path.display())]
    Content { path: PathBuf, source: Refusal },
    #[error("{}: this format cannot be read back; use a calibration in {}, such as the .json of the same fit", .path.display(), readable())]
    WriteOnly { path: PathBuf },
}

fn readable() -> String {
    let readable = TARGETS.iter().filter(|target| target.reader.is_some());
    joined(" or ", readable.map(|target| target.name))
}

/// Writes a calibration atomically, in the format that the file name ending selects. With an unknown ending, the complete
/// JSON format is used. A path that ends with `/` means a library in a folder.
///
/// [`WriteError`] if the file cannot be written, or the format cannot hold the calibration (its source is then a [`Refusal`]).
pub fn write_calibration(calibration: &Calibration, path: &Path) -> Result<(), WriteError> {
    let mut files = Together::default();
    add_calibration(&mut files, calibration, path)?;
    files.finish()
}

/// Writes a calibration like [`write_calibration`], as one of the files in `files` that get their names together.
pub fn add_calibration(
    files: &mut Together,
    calibration: &Calibration,
    path: &Path,
) -> Result<(), WriteError> {
    let target = target_for(path).unwrap_or(TARGETS[0]);
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    if asks_for_folder(path) {
        return files.folder(path, || targets::files(calibration, &name));
    }
    files.write(path, |out| (target.write)(&of_target(target, calibration, &name)?, out))
}

/// Returns the size of the file of each format (bytes), in the order of [`TARGETS`]; `None` for a format that cannot hold the
/// calibration.
pub fn file_sizes(calibration: &Calibration, name: &str) -> Vec<Option<u64>> {
    let size = |target: &&Target| {
        let mut counted = Counted(0);
        (target.write)(&of_target(target, calibration, name).ok()?, &mut counted).ok()?;
        Some(counted.0)
    };
    TARGETS.iter().map(size).collect()
}

/// Counts the bytes that are written to it.
struct Counted(u64);

impl io::Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns a warning if the file at this path would leave out a part of the calibration; see
/// [`Target::caution`](super::target::Target::caution).
pub fn caution(calibration: &Calibration, path: &Path) -> Option<String> {
    let left_out = (target_for(path)?.caution)(calibration)?;
    Some(format!("{} leaves out {left_out}", path.display()))
}

/// Reads a calibration and checks it, in the format of the file's ending; an unknown ending means the complete format. Gauges
/// without [names](crate::export::names_gauges) are called SG0, SG1 and so on; see [`name_gauges`](crate::export::name_gauges).
///
/// # Errors
/// [`ReadCalibrationError`] if the file cannot be read, is no calibration, or is incomplete.
pub fn read_calibration(path: &Path) -> Result<Calibration, ReadCalibrationError> {
    Ok(read_with_notes(path)?.0)
}

/// Reads a calibration like [`read_calibration`], and returns it with notes for the user.
pub fn read_with_notes(path: &Path) -> Result<(Calibration, Vec<String>), ReadCalibrationError> {
    let at = || path.to_owned();
    let io = |source| ReadCalibrationError::Io { path: at(), source };
    let content = read_small(path, "a calibration", LARGEST_FILE_BYTES).map_err(io)?;
    let target = target_for(path).unwrap_or(TARGETS[0]);
    let Some(read) = target.reader else {
        return Err(ReadCalibrationError::WriteOnly { path: at() });
    };
    let wrong = |source| ReadCalibrationError::Content { path: at(), source };
    let (calibration, mut notes) = read(&content).map_err(wrong)?;
    calibration.validate().map_err(|error| wrong(error.into()))?;
    for note in &mut notes {
        note.insert_str(0, &format!("{}: ", path.display()));
    }
    Ok((calibration, notes))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use super::*;
    use crate::calibration::{FORMAT, LinearMap, Quality, Regressor, UsedRecording, VERSION};
    use crate::export::code::Program;
    use crate::features::{Blocks, FeatureSettings, GaugeScale, Polynomial};
    use crate::recording::{Axis, Identity, Role};

    fn calibration() -> Calibration {
        calibration_of(["S,1", "S\"2"], FeatureSettings::default(), true)
    }

    fn calibration_of(gauges: [&str; 2], features: FeatureSettings, offset: bool) -> Calibration {
        let gauges = gauges.map(str::to_owned).to_vec();
        let map = |blocks: &FeatureSettings, factor: f64| {
            let columns = blocks.columns(gauges.len(), offset);
            let row =
                |axis: f64| (0..columns.len()).map(move |at| factor * axis / (at as f64 + 3.0));
            let matrix = vec![row(1.0).collect(), row(-1e-9).collect()];
            LinearMap::new(columns, matrix)
        };
        Calibration {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: "LoopScope".to_owned(),
            simulated: false,
            identity: Identity::default(),
            axes: vec![Axis::Fz, Axis::Mx],
            units: vec!["N".to_owned(), "N·m".to_owned()],
            full_scale: vec![12.0, 0.25],
            rated: vec![true, false],
            offset,
            decimation: 1,
            gap_secs: 1.0,
            keep_secs: BTreeMap::from([("stored_samples".to_owned(), 2.5)]),
            fade: BTreeMap::new(),
            history_step_secs: 0.0,
            limits: Vec::new(),
            gauge_limits: Vec::new(),
            gauge_scale: GaugeScale::identity(2),
            regressor: Regressor::Linear,
            conventional: map(&FeatureSettings::present(), 0.1),
            compensated: Some(map(&features, 1e8)),
            features,
            learned: None,
            quality: Quality::default(),
            trained_on: vec!["a \u{1b}[31m".to_owned()],
            rate_hz: Some(20.5),
            sources: vec![UsedRecording {
                name: "a \u{1b}[31m".to_owned(),
                role: Role::Test,
                file: Some("a.csv */ --> \n#".to_owned()),
                sha256: Some("ba78".to_owned()),
            }],
            tare: None,
            frame: None,
            tool: None,
            gauges,
        }
    }

    fn written(calibration: &Calibration, name: &str) -> (tempfile::TempDir, PathBuf) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join(name);
        write_calibration(calibration, &path).unwrap();
        (directory, path)
    }

    #[test]
    fn json_reads_back_to_the_last_bit() {
        let calibration = calibration();
        let (_directory, path) = written(&calibration, "c.json");
        assert_eq!(read_calibration(&path).unwrap(), calibration);
    }

    /// Only the first of two axes has a rated load.
    #[test]
    fn every_target_marks_full_scales_that_are_rated_loads() {
        for name in ["c.h", "c.rs", "c.py", "c.csv", "c.yaml"] {
            let (_directory, path) = written(&calibration(), name);
            let text = fs::read_to_string(path).unwrap();
            let full_scale = "Fz 12.000 N (rated), Mx 0.25000 N·m";
            let is_right = text.contains(full_scale) && !text.contains("N·m (rated)");
            assert!(is_right, "{name}: {text}");
        }
        let (_directory, path) = written(&calibration(), "c.yaml");
        let yaml = fs::read_to_string(path).unwrap();
        assert!(yaml.contains("\n    rated: [true, false]\n"), "{yaml}");
    }

    #[test]
    fn csv_names_rows_and_columns() {
        let calibration = calibration();
        let (_directory, path) = written(&calibration, "c.CSV");
        let comments = fs::read_to_string(&path).unwrap();
        assert!(comments.contains(
            "\n# leaves out: settings of the feature blocks (only described in words)\n"
        ));
        let scale = &calibration.gauge_scale;
        let standardised = format!("(S,1 - {}) * {}\n", scale.shift[0], scale.inverse_scale[0]);
        assert!(comments.contains(&standardised));
        assert!(comments.contains("(test): a.csv */ --> \\u{a}#, SHA-256 ba78\n"));
        let mut csv = csv::ReaderBuilder::new();
        let mut csv = csv.comment(Some(b'#')).from_path(path).unwrap();
        let header: Vec<_> = csv.headers().unwrap().iter().map(str::to_owned).collect();
        assert_eq!(header[4..], ["S,1", "S\"2", "S,1_past", "S\"2_past", "offset"]);
        let rows: Vec<_> = csv.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 4);
        assert_eq!(&rows[1][2], "Mx");
        assert_eq!(&rows[0][6], "");
        let value: f64 = rows[2][6].parse().unwrap();
        assert_eq!(value, calibration.compensated.unwrap().matrix[0][2]);
    }

    /// Columns are distinguished by their kind, not by their names.
    #[test]
    fn gauges_may_be_called_like_other_columns() {
        let features = FeatureSettings {
            blocks: Blocks::default().with(&Polynomial, &[2.0]),
            ..FeatureSettings::default()
        };
        for second in ["S1_past", "S1^2", "offset", "Crosstalk Fx"] {
            for offset in [true, false] {
                let calibration = calibration_of(["S1", second], features.clone(), offset);
                let (_directory, path) = written(&calibration, "c.json");
                assert_eq!(read_calibration(&path).unwrap(), calibration);

                let conventional = &calibration.conventional.matrix[0];
                let on_rows = Program::new(&calibration).conventional;
                assert_eq!(on_rows.matrix[0], conventional[..2]);
                assert_eq!(on_rows.base[0], if offset { conventional[2] } else { 0.0 });

                let (_directory, path) = written(&calibration, "c.csv");
                let mut csv = csv::ReaderBuilder::new();
                let mut csv = csv.comment(Some(b'#')).from_path(path).unwrap();
                let row = csv.records().next().unwrap().unwrap();
                let cells = row.iter().skip(4).enumerate();
                let filled = cells.filter(|(_, cell)| !cell.is_empty());
                let filled: Vec<(usize, f64)> =
                    filled.map(|(column, cell)| (column, cell.parse().unwrap())).collect();
                let columns = [0, 1].into_iter().chain(offset.then_some(7));
                let expected = columns.zip(conventional.iter().copied());
                assert_eq!(filled, expected.collect::<Vec<_>>(), "{second}");
            }
        }
    }

    #[test]
    fn an_edited_file_is_refused_with_the_reason() {
        let refused = |from: &str, to: &str| {
            let (_directory, path) = written(&calibration(), "c.json");
            let content = fs::read_to_string(&path).unwrap();
            assert!(content.contains(from), "{from}");
            fs::write(&path, content.replacen(from, to, 1)).unwrap();
            read_calibration(&path).unwrap_err().to_string()
        };
        assert!(refused("loopscope calibration", "other").contains("format"));
        assert!(refused("\"version\": 2", "\"version\": 9").contains("version 9"));
        assert!(refused("\"N·m\"", "\"N·mm\"").contains("unit of Mx"));
        assert!(refused("\"f_th\": 3.0", "\"f_th\": -3.0").contains("F_th is -3"));
        assert!(refused("\"f_th\": 3.0", "\"f_th\": NaN").contains("not a calibration file"));
        assert!(refused("\"offset\"\n    ]", "\"ofset\"\n    ]").contains("ofset"));
        assert!(refused("\"Mx\"", "\"Fz\"").contains("axes"));
        assert!(refused("12.0,", "").contains("full_scale"));
    }

    /// Gauges of 1e-200 have the inverse scale 1e200; a coefficient of 1e308 makes the load of any gauge infinite.
    #[test]
    fn numbers_that_are_too_large_are_refused() {
        let refused = |change: fn(&mut Calibration)| {
            let mut calibration = calibration();
            change(&mut calibration);
            calibration.validate().unwrap_err().to_string()
        };
        assert!(refused(|c| c.decimation = 0).contains("decimation"));
        assert!(refused(|c| c.full_scale = vec![0.0, 0.0]).contains("full_scale"));
        for value in [-1.0, f64::NAN, 1e308] {
            let mut calibration = calibration();
            calibration.full_scale[1] = value;
            assert!(calibration.validate().is_err(), "{value}");
        }
        for value in [1e308, -1e200, f64::INFINITY, f64::NAN] {
            let mut calibration = calibration();
            calibration.conventional.matrix[1][0] = value;
            let message = calibration.validate().unwrap_err().to_string();
            assert!(message.contains("conventional.matrix, row Mx"), "{message}");
        }
        assert!(refused(|c| c.gauge_scale.inverse_scale[0] = 1e200).contains("inverse_scale"));
        assert!(refused(|c| c.gauge_scale.shift[1] = -1e200).contains("-1e200"));
    }

    #[test]
    fn other_files_are_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("c.json");
        assert!(read_calibration(&path).is_err());
        fs::write(&path, "t,S1,Fx\n").unwrap();
        let error = read_calibration(&path).unwrap_err().to_string();
        assert!(error.contains("not a calibration"), "{error}");
        assert!(read_calibration(directory.path()).is_err());
    }
}
