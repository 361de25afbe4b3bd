//! Reads recordings from files with one row per sample: text as loggers and spreadsheets write it, or arrays of numbers.
//!
//! Guarantees: all values of a recording are finite and in SI units. A row is either used completely, or skipped with a
//! warning that gives its line. In files with arrays, rows count as lines. Wrong data never causes a panic. Text files are
//! read in small blocks.
//!
//! | module | contents |
//! |---|---|
//! | [`map`] | column maps: the roles of the columns of a table |
//! | `proposal`, `question` | the roles of columns from their names, units and values, and what they leave open |
//! | `pose_names` | names of the parts of a pose |
//! | `plan` | a column map applied to one file |
//! | `rows` | numbers from the cells of rows |
//! | [`pose`], `weigh`, `estimate` | loads from poses; a weight from loads |
//! | `two_clocks`, `join`, [`clock_offset`] | one table from gauges and reference |
//! | [`live`] | rows that arrive live |
//! | `timeline` | the unit of time, and the starts of recordings |
//! | `assemble` | recordings from rows |
//! | `column_report` | description of each column: name, unit, values, role |
//! | `abandonable` | reading on threads that can be abandoned |
//! | [`inspect`] | description of a file before it is loaded |
//! | `set_role` | another role for one channel of a file |
//! | `error`, `warning`, `named_column` | messages to the user |

mod abandonable;
mod assemble;
pub(crate) mod clock_offset;
mod column_report;
mod device_rows;
mod error;
mod estimate;
mod folder;
pub mod inspect;
mod join;
pub(crate) mod live;
mod load;
pub mod map;
mod named_column;
mod plan;
pub(crate) mod pose;
mod pose_names;
mod proposal;
mod question;
mod read;
mod rows;
mod set_role;
mod timeline;
mod two_clocks;
mod warning;
mod weigh;

pub use error::ReadError;
pub(crate) use error::TableError;
pub(crate) use estimate::estimate_weight;
pub(crate) use folder::{is_pattern, matching, recordings_in};
pub use load::{Loaded, unit_note};
pub use read::read;
pub(crate) use set_role::{ChannelRole, ColumnChange};
#[cfg(test)]
pub(crate) use warning::Cause;

#[cfg(test)]
mod bad_input_tests;
#[cfg(test)]
mod kinds_tests;
#[cfg(test)]
mod load_tests;
#[cfg(test)]
mod logger_tests;

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::path::{Path, PathBuf};

    use super::error::TableError;
    use super::load::Reading;
    use super::*;
    use crate::finding::Finding;
    use crate::formats::FileError;
    use crate::formats::text::{detect, locate};
    use crate::progress::Progress;
    use crate::recording::{Axis, Recording, Source};

    /// File with this content in a temporary folder, which is deleted when the value is dropped.
    pub(super) struct TestFile {
        _folder: tempfile::TempDir,
        pub(super) path: PathBuf,
    }

    impl TestFile {
        pub(super) fn new(content: impl AsRef<[u8]>) -> Self {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("run.csv");
            std::fs::write(&path, content).unwrap();
            Self { _folder: folder, path }
        }

        pub(super) fn read(&self) -> Result<Loaded, ReadError> {
            read(&self.path, None, &[], &Progress::default())
        }

        fn read_in_blocks(
            &self,
            block_bytes: usize,
            progress: &Progress,
        ) -> Result<Loaded, ReadError> {
            let reading = Reading { block_bytes, ..Reading::whole(progress) };
            reading.load(&self.path, None)
        }
    }

    /// Returns the plan and the warnings that the names in a header give.
    pub(super) fn plan_and_notes(header: &str) -> Result<(plan::Plan, Vec<Cause>), ReadError> {
        let (path, head) = (Path::new("a.csv"), header.as_bytes());
        let text = detect(head).unwrap();
        let start = locate(head, &text).unwrap();
        let sample = crate::formats::Sample::default();
        let proposal = proposal::Proposal::new(&text, &start, &sample, 0);
        let table = proposal.table(text.clone());
        let plan = plan::Plan::new(&table, &start, plan::Side::Both, None);
        Ok((plan.map_err(error::at(path, start.line))?, proposal.notes))
    }

    pub(super) fn plan_of_names(header: &str) -> plan::Plan {
        plan_and_notes(header).unwrap().0
    }

    /// Reads a text without faults: one recording and no warnings.
    #[track_caller]
    fn sound(content: impl AsRef<[u8]>) -> Recording {
        let mut loaded = TestFile::new(content).read().unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!(loaded.recordings.len(), 1);
        loaded.recordings.remove(0)
    }

    fn messages(content: impl AsRef<[u8]>) -> Vec<String> {
        let loaded = TestFile::new(content).read().unwrap();
        let message = |warning: &Finding| {
            let message = warning.to_string();
            let (_, place_and_text) = message.split_once("run.csv, line ").unwrap();
            place_and_text.to_owned()
        };
        loaded.warnings.iter().map(message).collect()
    }

    fn error(content: impl AsRef<[u8]>) -> ReadError {
        TestFile::new(content).read().unwrap_err()
    }

    #[test]
    fn a_table_is_converted_to_a_recording_in_si() {
        let recording = sound("t_ms,S1,S2,Tz_Nmm,Fx\n0,1,-2,3000,4\n50,1.5,-2.5,0,5e0\n");
        assert_eq!(recording.name(), "run");
        assert!(matches!(recording.source(), Source::File(path) if path.ends_with("run.csv")));
        assert_eq!(recording.times(), [0.0, 0.05]);
        assert_eq!(recording.gauge_names(), ["S1", "S2"]);
        assert_eq!(recording.gauges(), [1.0, -2.0, 1.5, -2.5]);
        assert_eq!(recording.axes(), [Axis::Fx, Axis::Mz]);
        assert_eq!(recording.loads(), [4.0, 3.0, 5.0, 0.0]);
    }

    #[test]
    fn every_spelling_of_a_table_gives_the_same_numbers() {
        let expected = sound("t,S1,Fx\n0,1.5,-2\n0.1,2.5,4\n");
        for text in [
            "\u{feff}t,S1,Fx\r\n0,1.5,-2\r\n0.1,2.5,4\r\n",
            "# logger\n\nt,S1,Fx\n\r\n0,1.5,-2\r\n  # pause\n0.1,2.5,4",
            "t;S1;Fx\n0;1.5;-2\n0.1;2.5;4\n",
            "t\tS1\tFx\n0\t1.5\t-2\n0.1\t2.5\t4\n",
            "  t   S1 Fx [N]\n 0  1.5 -2 \n0.1\t2.5 4\n",
            "\"t\",\"S1\",\"Fx\"\n\"0\",\"1.5\",\"-2\"\n0.1, \"2.5\" ,4\n",
            "t , S1 [mV/V], Fx (N)\n0, 1.5, -2\n.1, 2.5, 4.\n",
        ] {
            let recording = sound(text);
            assert_eq!(recording.times(), expected.times(), "{text}");
            assert_eq!(recording.gauges(), expected.gauges(), "{text}");
            assert_eq!(recording.loads(), expected.loads(), "{text}");
            assert_eq!(recording.gauge_names(), ["S1"], "{text}");
        }
    }

    #[test]
    fn decimal_commas_are_read() {
        for text in ["t;S1\n0,5;1,5\n1,0;-2,5\n", "t\tS1\n0,5\t1,5\n1,0\t-2,5\n"] {
            let loaded = TestFile::new(text).read().unwrap();
            assert_eq!(loaded.recordings[0].times(), [0.5, 1.0]);
            assert_eq!(loaded.recordings[0].gauges(), [1.5, -2.5]);
            assert!(messages(text).is_empty());
        }
        let quoted = "t,S1,S2\n\"0,5\",\"1,125\",3\n\"1,0\",\"-2,5\",\"4,25\"\n";
        let loaded = TestFile::new(quoted).read().unwrap();
        assert_eq!(loaded.recordings[0].times(), [0.5, 1.0]);
        assert_eq!(loaded.recordings[0].gauges(), [1.125, 3.0, -2.5, 4.25]);
    }

    #[test]
    fn a_recording_needs_no_reference() {
        assert!(!sound("t,S1\n0,1\n0.1,2\n").has_reference());
    }

    #[test]
    fn unusable_rows_are_skipped_and_collected_by_kind() {
        let text = "t,S1,Fx\n0,1,1\n0.1,abc,1\n0.2,1,x\x1b\n0.3,,1\n0.4,1,NaN\n0.5,-inf,1\n0.6,1\n0.7,2,1\n";
        let loaded = TestFile::new(text).read().unwrap();
        assert_eq!(loaded.recordings[0].times(), [0.0, 0.7]);
        assert_eq!(
            messages(text),
            [
                "3: column 2 (S1) contains \"abc\", not a number. Row skipped (2 times, last on line 4)",
                "5: column 2 (S1) is empty. Row skipped",
                "6: column 3 (Fx) contains NaN, not a finite number. Row skipped (2 times, last on line 7)",
                "8: the row has 2 cells, but the table has 3 columns. Row skipped",
            ]
        );
    }

    #[test]
    fn ignored_columns_may_hold_anything_but_are_reported() {
        let text = b"t,note,S1,S1_std\n0,caf\xe9,1,\n0.1,\"a,b\",2,x\n";
        let loaded = TestFile::new(text).read().unwrap();
        assert_eq!(loaded.recordings[0].gauges(), [1.0, 2.0]);
        assert_eq!(messages(text), ["1: ignored columns: note, S1_std"]);
    }

    #[test]
    fn extra_cells_are_left_out_and_reported_once() {
        let reported = messages("t,S1\n0,1,9\n0.1,2,\n0.2,3,8\n");
        assert_eq!(reported.len(), 1);
        assert!(
            reported[0]
                .starts_with("2: the row has 3 cells, but the table has 2 columns. Extra cells")
        );
        assert!(reported[0].ends_with("(2 times, last on line 4)"));
    }

    #[test]
    fn a_file_without_a_table_gives_an_error_with_the_reason() {
        assert!(matches!(error(""), ReadError::File { source: FileError::Empty, .. }));
        assert!(matches!(error("\u{feff}"), ReadError::NoHeader { .. }));
        assert!(matches!(error("# a\n\n"), ReadError::NoHeader { .. }));
        assert!(matches!(
            error("t,S1\n"),
            ReadError::Table { line: 1, source: TableError::NoRows, .. }
        ));
        assert!(matches!(
            error("\x1f\u{8b}\0"),
            ReadError::File { source: FileError::NotText { .. }, .. }
        ));
        let folder = tempfile::tempdir().unwrap();
        let of = |path: &Path| read(path, None, &[], &Progress::default()).unwrap_err();
        assert!(matches!(
            of(folder.path()),
            ReadError::File { source: FileError::Folder { .. }, .. }
        ));
        assert!(matches!(
            of(&folder.path().join("gone")),
            ReadError::File { source: FileError::Io(_), .. }
        ));
    }

    #[test]
    fn a_file_without_usable_rows_gives_the_reason() {
        let culprit = error("t,S1,S2\n0,1,nan\n1,x,nan\n2,3\n").to_string();
        assert!(culprit.contains("run.csv, line 1: column 3 (S2) has no number in any row"));
        let first = error("t,S1,S2\n0,x,1\n1,2,y\n").to_string();
        assert!(first.contains("run.csv, line 2: column 2 (S1) contains \"x\""));
        assert!(first.contains("No other row of the table is usable"));
    }

    #[test]
    fn tiny_blocks_and_one_block_read_the_same() {
        let mut text = String::from("# start\nt [ms],S1,x,S2,Fz\n");
        for k in 0..300 {
            let (time, load) = ((k % 100) * 10, k % 7);
            let row = match k % 23 {
                3 => "\r\n".to_owned(),
                5 => format!("{time},,a,1,{load}\n"),
                7 => format!("{time},\"1\",\"b\",1\r\n"),
                11 => format!("{time},1,c,1,{load},extra\n"),
                13 => format!("{},1,c,1,{load}\n", time - 10),
                _ => format!("{time},{k}.25,d,1,{load}\r\n"),
            };
            text.write_str(&row).unwrap();
        }
        let file = TestFile::new(text.trim_end());
        let whole = file.read().unwrap();
        assert!(whole.recordings.len() == 3 && whole.warnings.len() > 4);
        for block_bytes in [1, 7, 64, 1000] {
            let progress = Progress::default();
            progress.add_total(std::fs::metadata(&file.path).unwrap().len());
            let blocks = file.read_in_blocks(block_bytes, &progress).unwrap();
            assert_eq!(blocks, whole, "{block_bytes} bytes");
            assert_eq!(progress.fraction(), Some(1.0));
        }
    }

    #[test]
    fn cancelling_stops_the_reading() {
        let file = TestFile::new("t,S1\n0,1\n");
        let progress = Progress::default();
        progress.cancel();
        assert!(matches!(read(&file.path, None, &[], &progress), Err(ReadError::Cancelled)));
    }

    #[test]
    fn mutated_files_never_panic() {
        const SPECIAL: &[u8] = b"\n\r,;\t\"#[]() -.e9nNS\0\xff";
        let sound =
            b"t,S1,\"S2\",Fx [N]\n0,1,2,3\n0.1,1.5,\"2.5\",3\n\n#c\n0.2,1e3,-4,5\r\n0.3,1,1,1";
        let file = TestFile::new(sound);
        let mut random = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = |limit: usize| {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random >> 11) as usize % limit
        };
        let mut n_read = 0;
        for _ in 0..2_000 {
            let mut content = sound.to_vec();
            for _ in 0..=next(6) {
                let at = next(content.len());
                let byte = SPECIAL[next(SPECIAL.len())];
                match next(4) {
                    0 => content[at] = byte,
                    1 => content[at] = next(256) as u8,
                    2 => content.insert(at, byte),
                    _ => content.truncate(at.max(1)),
                }
            }
            std::fs::write(&file.path, &content).unwrap();
            let read = file.read_in_blocks(1 + next(80), &Progress::default());
            match read {
                Ok(loaded) => {
                    n_read += 1;
                    let _ = format!("{:?}", loaded.warnings.iter().map(Finding::to_string));
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
        assert!(n_read > 200, "{n_read} files were read");
    }
}
