//! Faulty files give a message with the place and a way out, never a panic and never an invented number.

use std::fs;
use std::path::Path;

use super::inspect::{Known, inspect};
use super::tests::TestFile;
use super::*;
use crate::{
    formats::text::TextLayout, import::map::ColumnMap, progress::Progress, recording::Recording,
};

/// Returns the error of reading a file, or its warnings.
fn messages(content: impl AsRef<[u8]>) -> String {
    match TestFile::new(content).read() {
        Ok(loaded) => {
            let messages: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
            messages.join("\n")
        }
        Err(error) => error.to_string(),
    }
}

fn n_samples(content: impl AsRef<[u8]>) -> usize {
    let loaded = TestFile::new(content).read().unwrap();
    loaded.recordings.iter().map(Recording::n_samples).sum()
}

fn of_path(path: &Path) -> String {
    read(path, None, &[], &Progress::default()).unwrap_err().to_string()
}

#[test]
fn mixed_line_ends_are_all_line_ends() {
    let text = "t,S1\r0,1\r\n0.1,2\n0.2,3\r\r\n0.3,4";
    assert_eq!((n_samples(text), messages(text)), (4, String::new()));
}

#[test]
fn utf_16_is_read_like_utf_8() {
    let text = "\u{feff}t;S1;Fx [N]\r\n0;1,5;2\r\n0,1;2,5;3\r\n";
    let expected = TestFile::new(text).read().unwrap();
    for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
        let content: Vec<u8> = text.encode_utf16().flat_map(bytes).collect();
        let loaded = TestFile::new(content).read().unwrap();
        assert_eq!(loaded.recordings[0].loads(), expected.recordings[0].loads());
        assert_eq!(loaded.warnings.len(), expected.warnings.len());
    }
}

#[test]
fn progress_over_utf_16_reaches_its_end() {
    let text = "t;S1\n0;1\n1;2\n";
    let file = TestFile::new(text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>());
    let progress = Progress::default();
    progress.add_total(fs::metadata(&file.path).unwrap().len());
    read(&file.path, None, &[], &progress).unwrap();
    assert_eq!(progress.fraction(), Some(1.0));
}

#[test]
fn units_in_latin_1_are_understood() {
    let loaded = TestFile::new(b"t [\xb5s],S1,Mx [N\xb7mm]\n0,1,5\n100,2,5\n").read().unwrap();
    assert_eq!(loaded.recordings[0].times(), [0.0, 1e-4]);
    assert_eq!(loaded.recordings[0].loads(), [0.005, 0.005]);
}

#[test]
fn a_few_zero_bytes_cost_only_their_rows() {
    let mut text = "t,S1\n0,1\n0.1,\0\0\n".to_owned();
    for k in 2..100 {
        text.push_str(&format!("{},1.5\n", f64::from(k) / 10.0));
    }
    assert_eq!(n_samples(&text), 99);
    assert!(
        messages(&text).contains("run.csv, line 3: column 2 (S1) contains \"\\0\\0\""),
        "{}",
        messages(&text)
    );
}

#[test]
fn rows_of_wrong_length_are_reported_with_both_lengths() {
    let text = "t,S1,Fx\n0,1,2\n1,1\n2,1,2,3\n3,1,2\n";
    assert_eq!(n_samples(text), 3);
    assert!(messages(text).contains(
        "run.csv, line 3: the row has 2 cells, but the table has 3 columns. Row skipped"
    ));
    assert!(
        messages(text)
            .contains("run.csv, line 4: the row has 4 cells, but the table has 3 columns. Extra")
    );
}

#[test]
fn quoted_numbers_are_numbers() {
    let text = "\"t\";\"S1\"\n\"0\";\"1,5\"\n\"1\";\"2\"\n";
    let loaded = TestFile::new(text).read().unwrap();
    assert_eq!(loaded.recordings[0].gauges(), [1.5, 2.0]);
}

#[test]
fn values_that_are_not_finite_are_never_kept() {
    for (cell, shown) in
        [("inf", "inf"), ("-Infinity", "-Infinity"), ("nan", "nan"), ("1e999", "1e999")]
    {
        let text = format!("t,S1\n0,1\n1,{cell}\n2,2\n");
        assert_eq!(n_samples(&text), 2);
        let place = format!("run.csv, line 3: column 2 (S1) contains {shown}, not a finite number");
        assert!(messages(&text).contains(&place), "{}", messages(&text));
    }
    // The number is finite, but its value in newtons is not.
    assert!(
        messages("t,S1,Fx [kN]\n0,1,1e307\n1,1,1\n")
            .contains("run.csv, line 2: column 3 (Fx) contains 1e307")
    );
}

#[test]
fn empty_files_and_headers_alone_are_distinguished() {
    assert!(messages("").contains("run.csv: the file is empty"));
    assert!(messages("\n\n#x\n").contains("run.csv: no header"));
    assert!(
        messages("t,S1\n\n")
            .contains("run.csv, line 1: the table has a header, but no rows after it")
    );
}

#[test]
fn archives_and_binary_files_are_named() {
    for (content, kind) in [
        (&b"\x1f\x8b\x08\0\0\0\0\0"[..], "a gzip archive"),
        (b"PK\x03\x04\x14\0", "a zip archive or a spreadsheet"),
        (b"\x28\xb5\x2f\xfd\x24", "a Zstandard archive"),
        (b"\x00\x01\x02\x03\x04\x05", "binary data"),
    ] {
        let messages = messages(content);
        assert!(
            messages.contains(&format!("run.csv: the file is not text but {kind}; unpack it")),
            "{messages}"
        );
    }
    // HDF5 is supported, but this file is damaged.
    #[cfg(feature = "hdf5")]
    assert!(messages(b"\x89HDF\r\n\x1a\n").contains("an HDF5 file that is damaged"));
}

#[test]
fn a_wrong_delimiter_shows_in_the_number_of_columns() {
    let file = TestFile::new("t;S1;Fx\n0;1;2\n1;2;3\n");
    let layout = TextLayout { header: true, ..TextLayout::default() };
    let inspection =
        inspect(&file.path, Known::Layout(layout.clone()), &Progress::default()).unwrap();
    let messages = inspection.check.error.unwrap();
    assert!(
        messages.contains(
            "run.csv, line 1: no table of numbers: there is no column of numbers among t;S1;Fx"
        ),
        "{messages}"
    );
    let known = inspect(&file.path, Known::Nothing, &Progress::default()).unwrap();
    assert_eq!(known.check.error, None);
    let wrong = ColumnMap::from_json(
        br#"{ "format": "loopscope column map", "version": 1, "table": { "shape": { "columns": 3 },
            "columns": [{ "column": 1, "is": "time" }, { "column": 2, "is": "gauge" }] } }"#,
    );
    let error = read(&file.path, Some(&wrong.unwrap()), &[], &Progress::default()).unwrap_err();
    assert!(error.to_string().contains(
        "run.csv, line 1: the column map is for files with 3 columns, but this file has 1"
    ));
}

#[test]
fn folders_and_missing_files_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    assert!(of_path(folder.path()).contains("this is a folder; name the recordings in it"));
    let file = TestFile::new("t,S1\n0,1\n");
    fs::remove_file(&file.path).unwrap();
    assert!(of_path(&file.path).contains("run.csv: the file cannot be read"));
}

#[cfg(target_os = "linux")]
#[test]
fn unreadable_files_are_reported() {
    assert!(of_path(Path::new("/dev/zero")).contains("/dev/zero: this is a pipe or a device"));
    // The file can be opened, but its first byte cannot be read.
    assert!(
        of_path(Path::new("/proc/self/mem")).contains("/proc/self/mem: the file cannot be read")
    );
}

mod mutations {
    use super::*;

    const SPECIAL: &[u8] = b"\n\r,;\t\"#[](){}:/ -.e9nNSTZ\0\xff";
    const FILES: [&[u8]; 7] = [
        b"t,S1,\"S2\",Fx [N]\n0,1,2,3\n0.1,1.5,\"2.5\",3\n\n#c\n0.2,1e3,-4,5\r\n0.3,1,1,1",
        b"Logger\n\nDate;Time;S1;Fx\n;[s];[V];[kN]\n9.9.2001;1:46:39,5;1;2\n9.9.2001;1:46:40;1,5;3\n",
        b"Start Time: x\nRDT Sample Rate: 9\nForce Units: N\nCounts per Unit Force: 9\nTorque Units: Nm\n\
            Counts per Unit Torque: 9\nStatus (hex), RDT Sequence, Fx, Tx\n0, 5, 1, 2\n80000000, 6, 1, 2\n",
        b"0 1 100 5\n0.5 2 300 6\n1 3 900 7\n1.5 4 1000 8\n",
        b"\xff\xfet\0,\0S\x001\0\n\x000\0,\x001\0\n\0",
        b"LabVIEW Measurement\nSeparator\tTab\nX_Columns\tNo\n***End_of_Header***\n\nChannels\t2\nX0\t0\t0\nDelta_X\t1\t1\n\
            ***End_of_Header***\nX_Value\tS1\tFx\n\t1\t2\n\t3\t4\n",
        b"pose,S1,Fx\n1,2,3\n2,3,4\n1,2.5,3\n2,3.5,4\n",
    ];
    const MAP: &[u8] = br#"{"format": "loopscope column map", "version": 1, "table": {"shape": {"columns": 4},
        "text": {"delimiter": "spaces", "decimal": "comma", "skip_rows": 0, "header": false}, "sample_rate_hz": 5,
        "columns": [{"column": 1, "is": "time", "unit": "s"}, {"column": 2, "is": "gauge", "scale": -1},
        {"column": 3, "is": "time_reference"}, {"column": 4, "is": "Fz", "unit": "kN", "dropouts": [7]}]},
        "join": {"method": "nearest", "limit_secs": 9, "clock_offset_secs": 0.5}}"#;

    struct Random(u64);

    impl Random {
        fn next(&mut self, limit: usize) -> usize {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as usize % limit
        }

        fn mutated(&mut self, sound: &[u8], most_changes: usize) -> Vec<u8> {
            let mut content = sound.to_vec();
            for _ in 0..=self.next(most_changes) {
                let at = self.next(content.len());
                let byte = SPECIAL[self.next(SPECIAL.len())];
                match self.next(5) {
                    0 => content[at] = byte,
                    1 => content[at] = self.next(256) as u8,
                    2 => content.insert(at, byte),
                    3 => {
                        content.remove(at);
                        content.push(byte);
                    }
                    _ => content.truncate(at.max(1)),
                }
            }
            content
        }
    }

    #[test]
    fn mutated_files_never_panic_with_or_without_a_map() {
        let file = TestFile::new("");
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let sound_map = ColumnMap::from_json(MAP).unwrap();
        let (mut n_read, mut n_mapped) = (0, 0);
        for round in 0..1_500 {
            let content = random.mutated(FILES[round % FILES.len()], 5);
            fs::write(&file.path, &content).unwrap();
            let progress = Progress::default();
            let inspected = inspect(&file.path, Known::Nothing, &progress);
            if let Ok(inspection) = inspected {
                n_read += usize::from(inspection.check.error.is_none());
                let loaded = read(&file.path, None, &[], &progress);
                if let (Ok(loaded), None) = (loaded, &inspection.check.error) {
                    assert_eq!(loaded.recordings.len(), inspection.check.recordings.len());
                }
            }
            n_mapped += usize::from(read(&file.path, Some(&sound_map), &[], &progress).is_ok());
        }
        assert!(n_read > 150 && n_mapped > 50, "{n_read} {n_mapped}");
    }

    #[test]
    fn mutated_maps_never_panic_and_read_back_the_same() {
        let file = TestFile::new(FILES[3]);
        let mut random = Random(0x0123_4567_89ab_cdef);
        let mut n_used = 0;
        for _ in 0..3_000 {
            let Ok(map) = ColumnMap::from_json(&random.mutated(MAP, 2)) else {
                continue;
            };
            let mut written = Vec::new();
            map.write_json(&mut written).unwrap();
            assert_eq!(ColumnMap::from_json(&written).unwrap(), map);
            n_used += usize::from(read(&file.path, Some(&map), &[], &Progress::default()).is_ok());
        }
        assert!(n_used > 20, "{n_used}");
    }
}
