//! Reads recordings that NumPy, SciPy, h5py, openpyxl, pyarrow and the MCAP library wrote, and one file like LabVIEW's
//! (`tests/formats/generate.py`). The numbers equal the formulas of the generator, and damaged files cause no panic.
//!
//! Sample k of 40 is at k / 64 s. Gauge j is j + k / 4, and axis a is 10 a − k / 2.

#[path = "support/tools.rs"]
mod tools;

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use loopscope::formats::FileError;
use loopscope::import::inspect::{Known, inspect};
use loopscope::import::map::{ColumnKey, ColumnMap, ColumnRole, ColumnRule};
use loopscope::import::{Loaded, ReadError, read};
use loopscope::progress::Progress;
use loopscope::recording::{Axis, Recording};

const N: usize = 40;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats").join(name)
}

fn loaded(path: &Path) -> Loaded {
    read(path, None, &[], &Progress::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn error(path: &Path) -> String {
    read(path, None, &[], &Progress::default()).unwrap_err().to_string()
}

/// Reads a file. Returns its only recording, and its warnings as one text.
fn sound(path: &Path) -> (Recording, String) {
    let mut loaded = loaded(path);
    let messages: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(loaded.recordings.len(), 1, "{messages:?}");
    (loaded.recordings.remove(0), messages.join("\n"))
}

fn gauge(k: usize, j: usize) -> f64 {
    (j + 1) as f64 + k as f64 / 4.0
}

fn load(k: usize, a: usize) -> f64 {
    10.0 * (a + 1) as f64 - k as f64 / 2.0
}

/// Checks every number of a complete recording that starts at `start_secs`.
#[track_caller]
fn check(recording: &Recording, start_secs: f64, n_gauges: usize, axes: &[Axis]) {
    assert_eq!(recording.n_samples(), N);
    assert_eq!(recording.axes(), axes);
    let names: Vec<String> = (1..=n_gauges).map(|j| format!("S{j}")).collect();
    assert_eq!(recording.gauge_names(), names);
    for k in 0..N {
        let time = start_secs + k as f64 / 64.0;
        assert!((recording.times()[k] - time).abs() < 1e-6, "time {k}");
        for j in 0..n_gauges {
            assert_eq!(recording.gauges_at(k)[j], gauge(k, j), "gauge {j} of {k}");
        }
        for a in 0..axes.len() {
            assert_eq!(recording.loads()[k * axes.len() + a], load(k, a), "axis {a} of {k}");
        }
    }
}

fn check_numpy(folder: &Path) {
    let (plain, messages) = sound(&folder.join("plain.npz"));
    check(&plain, 0.0, 6, &Axis::ALL);
    for part in ["operator (texts)", "settings (Python objects)", "rate (one number)"] {
        assert!(messages.contains(part), "{messages}");
    }
    let (packed, messages) = sound(&folder.join("packed.npz"));
    check(&packed, 0.0, 6, &Axis::ALL);
    assert_eq!(messages, "");
    // The records are aligned. The padding between fields must not be read as a field.
    for name in ["records.npy", "records.npz"] {
        let (records, messages) = sound(&folder.join(name));
        assert_eq!(records.gauges(), plain.gauges(), "{name}");
        assert_eq!(records.gauge_names(), plain.gauge_names());
        assert_eq!(records.times(), plain.times(), "{name}");
        assert_eq!(records.axes(), [Axis::Fx, Axis::Mz]);
        assert_eq!(records.loads()[2..4], [load(1, 0), 2.0 * load(1, 5)]);
        assert!(messages.contains("label (texts), "), "{messages}");
        assert!(messages.contains("legs (lists of records)"), "{messages}");
    }
}

fn check_json_lines(folder: &Path) {
    let (recording, messages) = sound(&folder.join("run.jsonl"));
    check(&recording, 0.0, 6, &Axis::ALL);
    assert!(messages.contains("note (no numbers)"), "{messages}");
}

fn check_matlab(folder: &Path) {
    for name in ["plain.mat", "packed.mat"] {
        let (recording, messages) = sound(&folder.join(name));
        check(&recording, 0.0, 6, &Axis::ALL);
        for part in ["note (text)", "rig (a struct)", "z (complex numbers)"] {
            assert!(messages.contains(part), "{messages}");
        }
        assert_eq!(recording.others().names(), ["counts"]);
    }
    let (older, messages) = sound(&folder.join("older.mat"));
    check(&older, 0.0, 6, &Axis::ALL);
    for part in ["note (text)", "z (complex numbers)"] {
        assert!(messages.contains(part), "{messages}");
    }
}

#[cfg(feature = "parquet")]
fn check_parquet(folder: &Path) {
    let (recording, messages) = sound(&folder.join("snappy.parquet"));
    check(&recording, 0.0, 6, &Axis::ALL);
    assert!(messages.contains("label (no numbers), pose.list.element (lists)"), "{messages}");
    for name in ["gzip.parquet", "lz4.parquet", "none.parquet", "zstd.parquet"] {
        let (recording, messages) = sound(&folder.join(name));
        assert_eq!(recording.n_samples(), N - 2);
        assert_eq!(recording.gauges()[..4], [1.0, 1.25, 1.5, 2.25]);
        assert!(
            messages.contains(", line 4: column 2 (S1) contains NaN, not a finite"),
            "{messages}"
        );
        assert!(messages.contains("(2 times, last on line 5)"), "{messages}");
    }
    let messages = error(&folder.join("brotli.parquet"));
    assert!(
        messages.contains("is compressed by brotli") && messages.contains("snappy"),
        "{messages}"
    );
}

#[cfg(feature = "mcap")]
fn check_mcap(folder: &Path) {
    for name in ["plain.mcap", "zstd.mcap", "lz4.mcap"] {
        let (recording, messages) = sound(&folder.join(name));
        let text = "not part of its table: /joints (sensor_msgs/msg/JointState), /note (std_msgs/msg/String)";
        assert!(messages.contains(text), "{messages}");
        if name == "plain.mcap" {
            // The reference ends one sample earlier. The reference is linear in time, so interpolation is exact.
            assert!(messages.contains("no reference load near"), "{messages}");
            assert_eq!(recording.n_samples(), N - 1);
            assert_eq!(recording.loads()[6..12], [9.5, 19.5, 29.5, 39.5, 49.5, 59.5]);
        } else {
            check(&recording, 1000.0, 6, &Axis::ALL);
        }
    }
}

/// Reads a file by the proposed map, after the parts in this map are replaced by `parts`.
fn read_parts(path: &Path, parts: &[&str]) -> Result<Loaded, String> {
    let found = inspect(path, Known::Nothing, &Progress::default()).unwrap();
    let mut text = found.map.table.text.clone();
    text.parts = parts.iter().map(|part| (*part).to_owned()).collect();
    let found = inspect(path, Known::Layout(text.clone()), &Progress::default());
    let map = found.map_err(|error| error.to_string())?.map;
    // The map must read back after it was written.
    let mut json = Vec::new();
    map.write_json(&mut json).unwrap();
    let map = ColumnMap::from_json(&json).unwrap();
    read(path, Some(&map), &[], &Progress::default()).map_err(|error| error.to_string())
}

fn check_structs(folder: &Path) {
    let (recording, messages) = sound(&folder.join("struct.mat"));
    assert_eq!(recording.gauge_names()[0], "run.S1");
    assert_eq!((recording.gauges_at(3)[5], recording.loads()[6]), (gauge(3, 5), load(1, 0)));
    assert_eq!(recording.axes(), Axis::ALL);
    assert!(messages.contains("run.out.unit (text), run.note (text), gain"), "{messages}");
    let path = folder.join("structs.mat");
    let (recording, messages) = sound(&path);
    check(&recording, 0.0, 6, &Axis::ALL);
    assert!(messages.contains("run(1). Not read: run(2)"), "{messages}");
    let both = read_parts(&path, &["run(1)", "run(2)"]).unwrap();
    let lengths: Vec<usize> = both.recordings.iter().map(Recording::n_samples).collect();
    assert_eq!(lengths, [N, 10]);
    let missing = read_parts(&path, &["run(3)"]).unwrap_err();
    assert!(missing.contains("run(3) in this file, whose tables are run(1), run(2)"), "{missing}");
}

#[cfg(feature = "hdf5")]
fn check_hdf5(folder: &Path) {
    let (recording, messages) = sound(&folder.join("plain.h5"));
    check(&recording, 0.0, 6, &Axis::ALL);
    assert!(messages.contains("note (text)"), "{messages}");
    let (recording, _) = sound(&folder.join("newer.mat"));
    check(&recording, 0.0, 6, &Axis::ALL);
    let (frame, _) = sound(&folder.join("frame.h5"));
    check(&frame, 0.0, 6, &[]);
    let (recording, _) = sound(&folder.join("chunked.h5"));
    assert_eq!(recording.gauges(), frame.gauges());
    assert_eq!(recording.loads()[3..6], [0, 1, 2].map(|a| 2.0 * load(1, a)));
    let (recording, messages) = sound(&folder.join("records.h5"));
    assert_eq!(recording.gauges(), frame.gauges());
    assert_eq!(recording.axes(), [Axis::Fx, Axis::Mz]);
    assert_eq!(recording.loads()[2..4], [load(1, 0), load(1, 5)]);
    assert_eq!(messages, "");
    let (recording, messages) = sound(&folder.join("gaps.h5"));
    check(&recording, 0.0, 6, &Axis::ALL[..3]);
    for gap in [
        "F (60 of 180 values were never written)",
        "S (90 of 360 values were never written)",
        "t (10 of 60 values were never written)",
        "never (never written)",
        "never_in_chunks (never written)",
    ] {
        assert!(messages.contains(gap), "no {gap} in {messages}");
    }
    let path = folder.join("runs.h5");
    let (recording, messages) = sound(&path);
    check(&recording, 0.0, 6, &[]);
    assert!(messages.contains("second. Not read: first"), "{messages}");
    let first = read_parts(&path, &["first"]).unwrap();
    assert_eq!(first.recordings[0].n_samples(), 10);
}

#[cfg(feature = "xlsx")]
fn check_workbooks(folder: &Path) {
    let path = folder.join("sheets.xlsx");
    let (recording, messages) = sound(&path);
    check(&recording, 0.0, 6, &Axis::ALL);
    assert_eq!(recording.gauge_units()[0], "mV/V");
    assert!(messages.contains("Data. Not read: Short"), "{messages}");
    assert!(messages.contains("label (text), Notes (no table of numbers)"), "{messages}");
    let short = read_parts(&path, &["Short"]).unwrap();
    assert_eq!(short.recordings[0].n_samples(), 5);
    let differ = read_parts(&path, &["Data", "Short"]).unwrap_err();
    assert!(differ.contains("have different names"), "{differ}");
    check_dates(&folder.join("dates.xlsx"));
}

#[cfg(feature = "xlsx")]
fn check_dates(path: &Path) {
    let (recording, messages) = sound(path);
    assert_eq!(messages, "");
    // 1,709,683,200 s after 1970, UTC, it is midnight between 5 and 6 March 2024.
    assert_eq!(
        [0, 1, 2, 3, 4].map(|k| recording.clock_time(k)),
        [-0.5, -0.375, -0.25, -0.125, 0.0].map(|t| 1_709_683_200.0 + t)
    );
    assert_eq!((recording.gauges()[1], recording.loads()[1]), (gauge(1, 0), load(1, 0)));
}

#[cfg(feature = "xlsx")]
#[test]
fn workbooks_of_older_and_other_programs_are_read_like_xlsx() {
    for name in ["dates.xls", "dates.ods"] {
        check_dates(&fixture(name));
    }
    // A compound file that is no workbook, and a cut workbook, are errors.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let whole = fs::read(fixture("dates.xls")).unwrap();
    for bytes in [&b"\xd0\xcf\x11\xe0\xa1\xb1"[..], &whole[..whole.len() / 2]] {
        fs::write(&path, bytes).unwrap();
        assert!(error(&path).contains("workbook"), "{}", error(&path));
    }
}

fn check_labview(folder: &Path) {
    let (recording, messages) = sound(&folder.join("segments.lvm"));
    check(&recording, 0.0, 6, &Axis::ALL[..1]);
    assert_eq!((recording.gauge_units()[5].as_str(), messages.as_str()), ("mV/V", ""));
}

/// Checks that the topics whose names fit reference and gauges are read, unless other topics are chosen.
#[cfg(feature = "mcap")]
fn check_several_topics(folder: &Path) {
    let path = folder.join("several.mcap");
    let (recording, messages) = sound(&path);
    let text = "/strain, /ati/wrench. Not read: /ft, /joints, /estimate, /temperatures";
    assert!(messages.contains(text), "{messages}");
    assert_eq!((recording.gauges()[0], recording.loads()[0]), (gauge(0, 0), -load(0, 0)));
    let other = read_parts(&path, &["/ft", "/temperatures"]).unwrap();
    let other = &other.recordings[0];
    assert_eq!((other.gauges()[0], other.loads()[0]), (-gauge(0, 0), load(0, 0)));
    assert_eq!(other.axes(), Axis::ALL);
    let three = read_parts(&path, &["/ft", "/temperatures", "/strain"]).unwrap_err();
    assert!(three.contains("at most two are read together"), "{three}");
    let gone = read_parts(&path, &["/gone"]).unwrap_err();
    assert!(gone.contains("no table /gone in this file, whose tables are /strain"), "{gone}");
}

#[test]
fn fields_of_structs_are_columns_and_several_structs_are_chosen() {
    check_structs(&fixture(""));
}

#[cfg(feature = "hdf5")]
#[test]
fn groups_records_and_frames_of_hdf5_are_read() {
    check_hdf5(&fixture(""));
}

#[cfg(feature = "xlsx")]
#[test]
fn sheets_are_read_with_a_header_in_any_row() {
    check_workbooks(&fixture(""));
}

#[test]
fn labview_segments_continue_on_their_clock() {
    check_labview(&fixture(""));
}

#[cfg(feature = "mcap")]
#[test]
fn one_pair_of_several_topics_is_read_and_the_others_are_named() {
    check_several_topics(&fixture(""));
}

/// Returns the bytes of one matrix as `save -v4` writes it: five integers, the name, and the numbers column by column.
fn mat4(is_big_endian: bool, kind: u32, shape: [u32; 2], name: &str, data: &[Vec<u8>]) -> Vec<u8> {
    let first = kind + if is_big_endian { 1000 } else { 0 };
    let integers = [first, shape[0], shape[1], 0, name.len() as u32 + 1];
    let in_order = |mut bytes: Vec<u8>| {
        if is_big_endian {
            bytes.reverse();
        }
        bytes
    };
    let integers = integers.map(|own| in_order(own.to_le_bytes().to_vec()));
    let data = data.iter().cloned().map(in_order);
    let bytes = integers.concat().into_iter().chain(name.bytes()).chain([0]);
    bytes.chain(data.flatten()).collect()
}

#[test]
fn matlab_version_4_is_read_in_all_kinds_and_byte_orders() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mat");
    type Stored = fn(f64) -> Vec<u8>;
    let kinds: [(u32, Stored); 6] = [
        (0, |value| value.to_le_bytes().to_vec()),
        (10, |value| (value as f32).to_le_bytes().to_vec()),
        (20, |value| (value as i32).to_le_bytes().to_vec()),
        (30, |value| (value as i16).to_le_bytes().to_vec()),
        (40, |value| (value as u16).to_le_bytes().to_vec()),
        (50, |value| vec![value as u8]),
    ];
    let double = kinds[0].1;
    let rows = || (0..N).map(|k| k as f64);
    for (kind, bytes) in kinds {
        for is_big_endian in [false, true] {
            let write = |kind, shape, name: &str, data: Vec<Vec<u8>>| {
                mat4(is_big_endian, kind, shape, name, &data)
            };
            let n = N as u32;
            let note = "5 March 2024".bytes().map(|code| double(f64::from(code)));
            let time = rows().map(|k| double(k / 64.0)).collect();
            // Gauges are whole numbers. The file is tested once with each number type.
            let gauges = (0..2).flat_map(|j| rows().map(move |k| bytes(k * 3.0 + f64::from(j))));
            let mut content = [
                write(1, [1, 12], "recorded_on", note.collect()),
                write(0, [n, 1], "t", time),
                write(2, [1, 3], "where", [1.0; 3].map(double).to_vec()),
                write(kind, [n, 2], "S", gauges.collect()),
            ]
            .concat();
            fs::write(&path, &content).unwrap();
            let (recording, messages) = sound(&path);
            assert_eq!(recording.gauges()[2..4], [3.0, 4.0], "{kind} {is_big_endian}");
            assert_eq!(recording.gauges()[2 * N - 1], 118.0);
            assert_eq!(recording.times()[N - 1], 39.0 / 64.0);
            let left_out = "recorded_on (text), where (a sparse matrix)";
            assert!(messages.contains(left_out), "{messages}");
            content.pop();
            fs::write(&path, &content).unwrap();
            assert!(error(&path).contains("the file ends inside S; it was cut short"));
            content.truncate(25);
            fs::write(&path, &content).unwrap();
            assert!(error(&path).contains("not text but binary data"));
        }
    }
    let lie = mat4(false, 0, [u32::MAX; 2], "S", &[]);
    fs::write(&path, lie).unwrap();
    assert!(error(&path).contains("the file ends inside S"));
}

/// Each error names a way to convert the file with the tools of its format.
#[test]
fn unsupported_formats_are_refused_with_an_alternative() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    for (start, way_out) in [
        (&b"#ROSBAG V2.0\n"[..], "rostopic echo -b"),
        (b"TDSm\x0e\0\0\0", "nptdms"),
        (b"SQLite format 3\0", "mcap convert"),
        (b"ARROW1\0\0", "to_parquet"),
        (b"\x80\x04\x95\x10\0", "numpy.savez"),
        (b"MDF     4.10", "asammdf"),
    ] {
        fs::write(&path, [start, &[0; 600]].concat()).unwrap();
        let messages = error(&path);
        assert!(messages.contains("not text but") && messages.contains(way_out), "{messages}");
    }
    let mut archive = zip::ZipWriter::new(fs::File::create(&path).unwrap());
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    archive.start_file("xl/workbook.bin", options).unwrap();
    archive.finish().unwrap();
    assert!(error(&path).contains("(.xlsb); open it in a spreadsheet program"));
}

#[test]
fn arrays_of_numpy_are_read_with_the_names_of_columns() {
    check_numpy(&fixture(""));
}

#[test]
fn lines_of_json_are_samples() {
    check_json_lines(&fixture(""));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.txt");
    let line = |k: usize| match k {
        // Some lines have NaN as Python writes it, a missing key, damaged text, or no text.
        3 => r#"{"time": "2024-03-05T10:00:03Z", "S": [NaN, 1], "is_on": true}"#.to_owned(),
        4 => r#"{"time": "2024-03-05T10:00:04Z", "is_on": true}"#.to_owned(),
        5 => r#"{"time": "2024-03-05T10:00:05Z", "S": [2.5,"#.to_owned(),
        k => format!(
            r#"{{"time": "2024-03-05T10:00:{k:02}Z", "S": [{k}.5, {}], "is_on": {}, "T [degC]": {}}}"#,
            2 * k,
            k % 2 == 0,
            if k < 8 { "null" } else { "25" },
        ),
    };
    let content: Vec<String> = (0..30).map(line).collect();
    let content = format!("\u{feff}{}\n{{\"time\": \"20", content.join("\r\n"));
    fs::write(&path, &content).unwrap();
    let (recording, messages) = sound(&path);
    assert_eq!(recording.n_samples(), 27);
    assert_eq!(recording.gauges_at(3), [6.5, 12.0]);
    assert_eq!(recording.clock_time(0), 1_709_632_800.0);
    assert_eq!(recording.auxiliary().names(), ["T"]);
    for part in [
        ", line 4: column 2 (S1) contains NaN",
        "(3 times, last on line 6)",
        "lines that are no JSON objects (1)",
        "ends in the middle of the data",
    ] {
        assert!(messages.contains(part), "{part} in {messages}");
    }
    fs::write(&path, content + &" ".repeat(1 << 20)).unwrap();
    assert!(error(&path).contains("a line is longer than 1048576 bytes"));
    let keys: String = (0..40_000).map(|k| format!("{{\"S{k}\":1}}\n")).collect();
    fs::write(&path, keys).unwrap();
    assert!(error(&path).contains("the table would unpack to more than"));
    let deep = format!("{{\"S\":{}\n", "[".repeat(100_000)).repeat(3);
    fs::write(&path, deep).unwrap();
    error(&path);
}

/// JSON files that this program writes are not recordings, whether on one line or on many lines.
#[test]
fn json_documents_are_not_lines_of_samples() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let proposed = inspect(&fixture("plain.npz"), Known::Nothing, &Progress::default()).unwrap();
    let mut map = Vec::new();
    proposed.map.write_json(&mut map).unwrap();
    let document = r#"{"format": "x", "samples": [{"t": 0, "S1": 1}, {"t": 1, "S1": 2}]}"#;
    let over_lines = document.replace(' ', "\n");
    for content in [&map[..], document.as_bytes(), over_lines.as_bytes()] {
        fs::write(&path, content).unwrap();
        error(&path);
        if let Ok(found) = inspect(&path, Known::Nothing, &Progress::default()) {
            assert_eq!(found.table.kind, None);
        }
    }
}

#[test]
fn matrices_of_matlab_are_read_with_or_without_compression() {
    check_matlab(&fixture(""));
}

#[cfg(feature = "parquet")]
#[test]
fn columns_of_parquet_are_read_with_their_own_units() {
    check_parquet(&fixture(""));
}

#[cfg(feature = "mcap")]
#[test]
fn topics_of_mcap_are_joined_by_the_times_in_their_messages() {
    check_mcap(&fixture(""));
}

#[cfg(not(feature = "parquet"))]
#[test]
fn without_its_feature_a_parquet_file_is_named() {
    assert!(error(&fixture("snappy.parquet")).contains("built without the feature `parquet`"));
}

#[cfg(not(feature = "mcap"))]
#[test]
fn without_its_feature_an_mcap_recording_is_named() {
    assert!(error(&fixture("plain.mcap")).contains("built without the feature `mcap`"));
}

#[test]
fn newly_generated_files_read_like_the_stored_ones() {
    if !tools::is_there("python3", &["-c", "import numpy"]) {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let script = fixture("generate.py");
    let made = Command::new("python3").arg(script).arg(folder.path()).output();
    let is_there = |package: &str, name: &str| {
        let is_there = folder.path().join(name).exists();
        if !is_there {
            tools::skipped(package, &format!("python3 wrote no {name}: {made:?}"));
        }
        is_there
    };
    check_numpy(folder.path());
    if is_there("scipy", "packed.mat") {
        check_matlab(folder.path());
        check_structs(folder.path());
    }
    check_labview(folder.path());
    check_json_lines(folder.path());
    #[cfg(feature = "hdf5")]
    if is_there("h5py", "newer.mat") {
        check_hdf5(folder.path());
    }
    #[cfg(feature = "xlsx")]
    if is_there("openpyxl", "dates.xlsx") {
        check_workbooks(folder.path());
    }
    #[cfg(feature = "parquet")]
    if is_there("pyarrow", "brotli.parquet") {
        check_parquet(folder.path());
    }
    #[cfg(feature = "mcap")]
    if is_there("mcap", "several.mcap") {
        check_mcap(folder.path());
        check_several_topics(folder.path());
    }
}

/// The reference has every second sample. The reference is linear in time, so interpolation is exact.
#[test]
fn arrays_on_two_clocks_are_joined() {
    let (recording, messages) = sound(&fixture("two_clocks.npz"));
    assert_eq!(recording.axes(), &Axis::ALL[..3]);
    assert_eq!(recording.n_samples(), N - 1);
    for k in 0..N - 1 {
        assert_eq!(recording.loads()[3 * k..3 * k + 3], [load(k, 0), load(k, 1), load(k, 2)]);
    }
    assert!(messages.contains("no reference load near the time 0.609375 s"), "{messages}");
}

#[test]
fn an_array_without_names_opens_and_is_read_by_a_map() {
    let path = fixture("lone.npy");
    // All columns rise or fall with the rows, so none of them is taken for the time before the roles are given.
    let (recording, _) = sound(&path);
    assert_eq!((recording.n_gauges(), recording.has_reference()), (13, false));
    let proposed = inspect(&path, Known::Nothing, &Progress::default()).unwrap();
    assert_eq!(proposed.table.columns[0].is, ColumnRole::Gauge);
    assert_eq!((proposed.table.about_rows, proposed.table.kind), (40, Some("NumPy array")));
    let mut map = ColumnMap::default();
    map.table.shape.columns = 13;
    let rule = |number, is| ColumnRule::new(ColumnKey::Number(number), is);
    map.table.columns = vec![rule(1, ColumnRole::Time)];
    map.table.columns.extend((2..8).map(|n| rule(n, ColumnRole::Gauge)));
    map.table.columns.extend((0..6).map(|a| rule(8 + a, ColumnRole::Load(Axis::ALL[a]))));
    let loaded = read(&path, Some(&map), &[], &Progress::default()).unwrap();
    check(&loaded.recordings[0], 0.0, 6, &Axis::ALL);
}

#[test]
fn a_map_chooses_among_arrays_as_among_columns_of_text() {
    let path = fixture("plain.npz");
    let mut map = inspect(&path, Known::Nothing, &Progress::default()).unwrap().map;
    map.table.columns.retain(|rule| rule.is != ColumnRole::Load(Axis::Fy));
    let fx = ColumnRole::Load(Axis::Fx);
    let rule = map.table.columns.iter_mut().find(|rule| rule.is == fx).unwrap();
    (rule.unit, rule.scale) = (Some("kN".to_owned()), -1.0);
    let loaded = read(&path, Some(&map), &[], &Progress::default()).unwrap();
    assert_eq!(loaded.recordings[0].axes().len(), 5);
    assert_eq!(loaded.recordings[0].loads()[0], -10_000.0);
}

/// An array that is listed twice must neither cause a panic as gauges, nor give an axis of zeros.
#[test]
fn an_array_that_a_map_lists_by_name_and_by_number_is_refused() {
    for name in ["plain.npz", "plain.mat"] {
        let path = fixture(name);
        let proposed = inspect(&path, Known::Nothing, &Progress::default()).unwrap();
        for report in &proposed.table.columns {
            let mut map = proposed.map.clone();
            let again = ColumnKey::Number(report.number);
            let columns = &mut map.table.columns;
            columns.push(ColumnRule::new(again, ColumnRole::Ignore));
            let read = read(&path, Some(&map), &[], &Progress::default());
            let is_free = report.is == ColumnRole::Ignore;
            assert_eq!(read.is_ok(), is_free, "{}", report.header);
            if let Err(error) = read {
                let messages = format!("column {} is listed twice, as", report.number);
                assert!(error.to_string().contains(&messages), "{error}");
            }
        }
    }
}

#[test]
fn the_content_decides_and_not_the_file_name() {
    let folder = tempfile::tempdir().unwrap();
    for (name, other) in [("packed.npz", "run.csv"), ("plain.mat", "run.txt")] {
        let path = folder.path().join(other);
        fs::copy(fixture(name), &path).unwrap();
        check(&sound(&path).0, 0.0, 6, &Axis::ALL);
    }
    let path = folder.path().join("run.npz");
    fs::write(&path, "t,S1\n0,1\n1,2\n").unwrap();
    assert_eq!(sound(&path).0.n_samples(), 2);
    fs::write(&path, b"\x1f\x8b\x08 squeezed").unwrap();
    assert!(error(&path).contains("not text but a gzip archive; unpack it"));
}

#[test]
fn files_without_a_table_list_their_contents() {
    let folder = tempfile::tempdir().unwrap();
    let messages = |content: &[u8]| {
        let path = folder.path().join("run");
        fs::write(&path, content).unwrap();
        error(&path)
    };
    assert!(
        error(&fixture("objects.npy"))
            .contains("holds Python objects instead of numbers; save it as")
    );
    let empty_archive = [&b"PK\x05\x06"[..], &[0; 18]].concat();
    assert!(messages(&empty_archive).contains("no table of numbers"));
    let mut matlab73 = b"MATLAB 7.3 MAT-file".to_vec();
    matlab73.resize(512, b' ');
    assert!(messages(&matlab73).contains("save it with `save FILE -v7`"));
    let matlab5 = [&b"MATLAB 5.0 MAT-file"[..], &[b' '; 105], b"\x00\x01IM"].concat();
    assert!(messages(&matlab5).contains("no table of numbers"));
    assert!(messages(b"PK\x03\x04 S.npy is cut off").contains("the archive is damaged"));
}

fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), data].concat()
}

/// Files declare sizes larger than any memory. The reader must return an error without an allocation of this size.
#[test]
fn declared_sizes_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    for shape in ["(9999999999999,)", "(18446744073709551615, 2)", "(1000000, 1000000)"] {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        fs::write(&path, npy(&header, &[0; 64])).unwrap();
        assert!(error(&path).contains("the file ends inside the array"), "{shape}");
    }
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 0), }\n";
    fs::write(&path, npy(header, &[])).unwrap();
    assert!(error(&path).contains("no table of numbers"));
    for order in ["False", "True"] {
        let header = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': (0, 3), }}\n");
        fs::write(&path, npy(&header, &[])).unwrap();
        assert!(error(&path).contains("no table of numbers"));
    }
    for (descr, shape, expected) in [
        ("[('t', '<f8'), ('S1', '<f8', (999999999,))]", "(2,)", "the file ends inside the array"),
        ("[('t', '<f8'), ('S1', '<f8', (999999999,))]", "(0,)", "no table of numbers"),
        (
            "[('t', '<f8', (9999999999, 9999999999))]",
            "(0,)",
            "the data type in its header cannot be read",
        ),
        ("[('t', '<U1'), ('S1', '<f8', (0,))]", "(99999999999,)", "holds records without numbers"),
        ("[('t', '<f8'), ('S1', '|O')]", "(2,)", "holds Python objects"),
        ("[('t', '<f8'), ('S1', '<f8')", "(2,)", "the data type in its header cannot be read"),
        (&"[('t', ".repeat(9000), "(2,)", "the data type in its header cannot be read"),
    ] {
        let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
        fs::write(&path, npy(&header, &[0; 64])).unwrap();
        assert!(error(&path).contains(expected), "{descr}: {}", error(&path));
    }
    let header = "{'descr': '<c16', 'fortran_order': False, 'shape': (2,), }\n";
    fs::write(&path, npy(header, &[0; 32])).unwrap();
    assert!(error(&path).contains("holds complex numbers"));
    let mut matrix = fs::read(fixture("plain.mat")).unwrap();
    matrix[132..136].copy_from_slice(&u32::MAX.to_le_bytes());
    fs::write(&path, matrix).unwrap();
    assert!(error(&path).contains("the file ends inside"));
}

#[cfg(feature = "mcap")]
#[test]
fn a_text_of_mcap_that_is_longer_than_its_record_is_damage() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let content = fs::read(fixture("plain.mcap")).unwrap();
    let starts = content.windows(3).enumerate();
    let encodings = starts.filter(|(_, bytes)| bytes == b"cdr").map(|(at, _)| at);
    for at in encodings.take(2) {
        let mut damaged = content.clone();
        damaged[at - 4..at].copy_from_slice(&0xffff_fff0_u32.to_le_bytes());
        fs::write(&path, damaged).unwrap();
        let messages = error(&path);
        assert!(messages.contains("a text is longer than its record"), "{messages}");
    }
}

fn fixtures() -> Vec<PathBuf> {
    let mut endings = vec!["npz", "npy", "mat", "lvm", "jsonl"];
    if cfg!(feature = "hdf5") {
        endings.push("h5");
    }
    if cfg!(feature = "xlsx") {
        endings.push("xlsx");
    }
    if cfg!(feature = "parquet") {
        endings.push("parquet");
    }
    if cfg!(feature = "mcap") {
        endings.push("mcap");
    }
    let is_read = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|ending| endings.contains(&ending))
    };
    let entries = fs::read_dir(fixture("")).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(is_read);
    paths.sort();
    paths
}

/// Checks that an error is not a panic of this project's own readers. Only the crates for some formats may panic.
#[track_caller]
fn check_no_defect(fixture: &Path, error: &ReadError) {
    let by_crate = ["parquet", "h5", "xlsx"];
    let ending = fixture.extension().and_then(|ending| ending.to_str());
    let is_by_crate = ending.is_some_and(|ending| by_crate.contains(&ending));
    let messages = error.to_string();
    assert!(is_by_crate || !messages.contains("its reader failed"), "{fixture:?}: {messages}");
}

#[test]
fn a_file_that_is_cut_short_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    for fixture in fixtures() {
        let content = fs::read(&fixture).unwrap();
        for part in 1..24 {
            fs::write(&path, &content[..content.len() * part / 24]).unwrap();
            match read(&path, None, &[], &Progress::default()) {
                // A killed recorder leaves a file without its end. Complete matrices of this file are read.
                Ok(loaded) => {
                    let messages: Vec<String> =
                        loaded.warnings.iter().map(ToString::to_string).collect();
                    // Of a damaged text, the remaining rows are read; of HDF5, the complete datasets.
                    let may_be_whole = ["mat", "lvm", "h5"];
                    let ending = fixture.extension().and_then(|ending| ending.to_str());
                    let is_whole = ending.is_some_and(|ending| may_be_whole.contains(&ending));
                    let is_told = messages
                        .iter()
                        .any(|messages| messages.contains("ends in the middle of the data"));
                    assert!(is_told || is_whole, "{fixture:?} {part}: {messages:?}");
                }
                Err(ReadError::File { source: FileError::Io(source), .. }) => {
                    panic!("{fixture:?}: {source}")
                }
                Err(error) => check_no_defect(&fixture, &error),
            }
        }
    }
}

#[test]
fn mutated_files_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = |limit: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random >> 11) as usize % limit
    };
    let mut n_read = 0;
    for fixture in fixtures() {
        let sound = fs::read(&fixture).unwrap();
        for _ in 0..100 {
            let mut content = sound.clone();
            for _ in 0..=next(4) {
                // Most sizes and types are stored at the start and at the end of a file.
                let at = match next(3) {
                    0 => next(content.len().min(400)),
                    1 => content.len() - 1 - next(content.len().min(400)),
                    _ => next(content.len()),
                };
                match next(4) {
                    0 => content[at] = [0, 1, 0x7f, 0x80, 0xff][next(5)],
                    1 => content[at] ^= 1 << next(8),
                    2 => content[at] = next(256) as u8,
                    _ => content[at..].iter_mut().take(4).for_each(|byte| *byte = 0xff),
                }
            }
            fs::write(&path, &content).unwrap();
            match read(&path, None, &[], &Progress::default()) {
                Ok(loaded) => n_read += usize::from(!loaded.recordings.is_empty()),
                Err(error) => check_no_defect(&fixture, &error),
            }
        }
    }
    assert!(n_read > 50, "{n_read} files were read");
}

/// Writes a workbook of one sheet with these rows and shared strings.
#[cfg(feature = "xlsx")]
fn workbook(path: &Path, rows: &str, strings: &str) {
    let mut archive = zip::ZipWriter::new(fs::File::create(path).unwrap());
    let main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    let kinds = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let linked = "http://schemas.openxmlformats.org/package/2006/relationships";
    let links = |kind: &str, target: &str| {
        format!(
            r#"<Relationships xmlns="{linked}"><Relationship Id="rId1" Type="{kinds}/{kind}" Target="{target}"/></Relationships>"#
        )
    };
    for (name, content) in [
        ("_rels/.rels", links("officeDocument", "xl/workbook.xml")),
        (
            "xl/workbook.xml",
            format!(
                r#"<workbook xmlns="{main}" xmlns:r="{kinds}"><sheets><sheet name="Data" sheetId="1" r:id="rId1"/></sheets></workbook>"#
            ),
        ),
        ("xl/_rels/workbook.xml.rels", links("worksheet", "worksheets/sheet1.xml")),
        ("xl/sharedStrings.xml", format!(r#"<sst xmlns="{main}" {strings}</sst>"#)),
        (
            "xl/worksheets/sheet1.xml",
            format!(r#"<worksheet xmlns="{main}"><sheetData>{rows}</sheetData></worksheet>"#),
        ),
    ] {
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file(name, options).unwrap();
        archive.write_all(content.as_bytes()).unwrap();
    }
    archive.finish().unwrap();
}

/// A workbook and a CSV with the same cells give the same warnings about texts and empty cells in a column of numbers.
#[cfg(feature = "xlsx")]
#[test]
fn a_text_in_a_column_of_a_workbook_is_reported_like_that_of_a_csv() {
    let folder = tempfile::tempdir().unwrap();
    let heads = ["t", "S1", "Fz [N]"];
    let cells = |k: usize| {
        let gauge = match k {
            5 | 7 => "broken".to_owned(),
            9 => String::new(),
            _ => gauge(k, 0).to_string(),
        };
        [(k as f64 / 64.0).to_string(), gauge, load(k, 2).to_string()]
    };
    let cell = |text: &str| match text.parse::<f64>() {
        _ if text.is_empty() => "<c></c>".to_owned(),
        Ok(number) => format!("<c><v>{number}</v></c>"),
        Err(_) => format!(r#"<c t="str"><v>{text}</v></c>"#),
    };
    let row = |cells: &[String]| {
        format!("<row>{}</row>", cells.iter().map(|text| cell(text)).collect::<String>())
    };
    let all: Vec<[String; 3]> =
        [heads.map(str::to_owned)].into_iter().chain((0..N).map(cells)).collect();
    let (sheet, text) = (folder.path().join("run.xlsx"), folder.path().join("run.csv"));
    workbook(&sheet, &all.iter().map(|cells| row(cells)).collect::<String>(), ">");
    fs::write(&text, all.iter().map(|cells| cells.join(",") + "\n").collect::<String>()).unwrap();
    let found = [sheet, text].map(|path| {
        let Loaded { recordings, warnings, .. } = loaded(&path);
        let seen = warnings.iter().map(|own| {
            let place = own.place.as_ref().unwrap();
            (own.seen.clone(), place.first_line, place.count)
        });
        (recordings[0].n_samples(), seen.collect::<Vec<_>>())
    });
    assert_eq!(found[0], found[1]);
    assert_eq!(found[0].0, N - 3);
    assert_eq!(found[0].1.iter().map(|own| own.2).collect::<Vec<_>>(), [2, 1]);
}

/// The memory for a workbook must depend only on the number of its filled cells.
#[cfg(feature = "xlsx")]
#[test]
fn distant_cells_and_shared_texts_take_no_extra_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.xlsx");
    let heads = ["t", "S1", "Fz [N]"].map(|name| format!(r#"<c t="str"><v>{name}</v></c>"#));
    let row = |k: usize| {
        let (t, gauge, load) = (k as f64 / 64.0, gauge(k, 0), load(k, 2));
        format!("<row><c><v>{t}</v></c><c><v>{gauge}</v></c><c><v>{load}</v></c></row>")
    };
    let rows: String = (0..N).map(row).collect();
    let table = format!("<row>{}</row>{rows}", heads.concat());
    let corner = r#"<row r="1048576"><c r="XFD1048576" t="str"><v>x</v></c></row>"#;
    workbook(&path, &format!("{table}{corner}"), ">");
    let (recording, messages) = sound(&path);
    assert_eq!(recording.n_samples(), N, "{messages}");
    assert_eq!(recording.gauges()[N - 1], gauge(N - 1, 0));

    let many = format!("<row>{}</row>", r#"<c t="s"><v>0</v></c>"#.repeat(5000));
    let long = format!("><si><t>{}</t></si>", "x".repeat(1 << 20));
    workbook(&path, &format!("{table}{}", many.repeat(3)), &long);
    assert_eq!(sound(&path).0.n_samples(), N);

    let lie = format!(r#"uniqueCount="{}">"#, u32::MAX);
    workbook(&path, &table, &lie);
    assert!(error(&path).contains("4294967295 texts"), "{}", error(&path));

    // The numbers are on a diagonal, so a table of 40,000 rows and 4,096 columns has few filled cells.
    let letter = |at: usize| char::from(b'A' + (at % 26) as u8);
    let cell = |k: usize| {
        let column: String = [k % 5000 / 676, k % 676 / 26, k % 26].map(letter).iter().collect();
        format!(r#"<row><c r="{column}{}"><v>{k}</v></c></row>"#, k + 1)
    };
    workbook(&path, &(0..40_000).map(cell).collect::<String>(), ">");
    assert!(error(&path).contains("Data would unpack to more than"), "{}", error(&path));
}

/// Writes an `.npz` archive of these arrays.
fn npz(path: &Path, arrays: &[(&str, Vec<f64>)]) {
    let mut archive = zip::ZipWriter::new(fs::File::create(path).unwrap());
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, values) in arrays {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        let header =
            format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}\n", values.len());
        let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        archive.write_all(&npy(&header, &data)).unwrap();
    }
    archive.finish().unwrap();
}

#[test]
fn presses_in_arrays_are_recordings_and_bursts_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    for (pause, n_recordings) in [(0.3, 1), (10.0, 60)] {
        let time = |k: u32| f64::from(k / 10) * pause + f64::from(k % 10) / 1000.0;
        let times: Vec<f64> = (0..600).map(time).collect();
        let gauge = (0..600).map(|k| f64::from(k % 7)).collect();
        npz(&path, &[("t", times), ("S1", gauge)]);
        let loaded = loaded(&path);
        assert_eq!(loaded.recordings.len(), n_recordings);
        let messages = loaded.warnings[0].to_string();
        assert_eq!(messages.contains("rows come in bursts"), n_recordings == 1, "{messages}");
        let map = inspect(&path, Known::Nothing, &Progress::default()).unwrap().map;
        let map = ColumnMap { gap_secs: Some(0.1), ..map };
        let cut = read(&path, Some(&map), &[], &Progress::default()).unwrap();
        assert_eq!(cut.recordings.len(), 60);
    }
}

/// The crate that reads Parquet panics on some damaged files.
#[cfg(feature = "parquet")]
#[test]
fn a_panic_of_a_reader_is_an_error_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.parquet");
    let mut content = fs::read(fixture("gzip.parquet")).unwrap();
    content[806] = 207;
    fs::write(&path, content).unwrap();
    let messages = error(&path);
    assert!(messages.contains("run.parquet: the file is damaged"), "{messages}");
    let binary = env!("CARGO_BIN_EXE_loopscope");
    let output = Command::new(binary).arg("inspect").arg(&path).output().unwrap();
    let messages = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), messages.lines().count()), (Some(1), 1), "{messages}");
}

/// There are more arrays than a table may have columns. The time must grow only in proportion to their number.
#[test]
fn thousands_of_arrays_are_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    let arrays: Vec<(String, Vec<f64>)> =
        (1..=12_000).map(|k| (format!("S{k}"), vec![0.0, 1.0, 2.0])).collect();
    let mut named: Vec<(&str, Vec<f64>)> = vec![("t", vec![0.0, 0.1, 0.2])];
    named.extend(arrays.iter().map(|(name, values)| (name.as_str(), values.clone())));
    npz(&path, &named);
    assert!(error(&path).contains("4095 gauges, but at most 64 "));
    let found = inspect(&path, Known::Nothing, &Progress::default()).unwrap();
    assert_eq!(found.table.columns.len(), 4096);
}
