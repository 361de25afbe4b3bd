//! Files as loggers, terminals and meters write them.

use std::fmt::Write as _;

use super::tests::TestFile;
use super::*;
use crate::{
    finding::{Finding, Id},
    import::map::ColumnMap,
    progress::Progress,
    recording::Recording,
};

#[track_caller]
fn single(text: &str) -> (Recording, Vec<Finding>) {
    let loaded = TestFile::new(text).read().unwrap();
    let [recording] = &loaded.recordings[..] else {
        panic!("one recording: {:?}", loaded.warnings)
    };
    (recording.clone(), loaded.warnings)
}

/// As a 64-bit float, a present-day stamp in seconds has only seven decimals.
#[test]
fn stamps_of_a_date_keep_their_digits() {
    let stamp = |k: i64, step_ns: i64| 1_763_000_000_123_456_789 + k * step_ns;
    let secs =
        |k| format!("{}.{:09}", stamp(k, 19_531) / 1_000_000_000, stamp(k, 19_531) % 1_000_000_000);
    let nanos = |k| stamp(k, 19_531).to_string();
    let pair =
        |k| format!("{},{}", stamp(k, 19_531) / 1_000_000_000, stamp(k, 19_531) % 1_000_000_000);
    let iso = |k| {
        format!(
            "2025-11-13T02:13:{:02}.{:09}",
            20 + k / 51_200,
            (123_456_789 + k * 19_531) % 1_000_000_000
        )
    };
    let times: [(&str, &dyn Fn(i64) -> String); 5] = [
        ("time [s]", &secs),
        ("time", &nanos),
        ("time_ns", &nanos),
        ("sec,nanosec", &pair),
        ("time", &iso),
    ];
    for (name, time) in times {
        let mut text = format!("{name},S1,Fz\n");
        for k in 0..400 {
            writeln!(text, "{},{k},{}", time(k), k % 7).unwrap();
        }
        let (recording, findings) = single(&text);
        let rate = recording.rate_hz().unwrap();
        assert!((rate - 1e9 / 19_531.0).abs() < 1e-3, "{name}: {rate} {findings:?}");
        let clock = recording.clock_time(0);
        assert!((clock - 1_763_000_000.123_456_8).abs() < 1e-6, "{name}: {clock}");
    }
    let mut text = String::from("time,S1,Fz\n");
    for k in 0..400 {
        writeln!(text, "{}.{:03},{k},1", 1_763_000_000 + k / 200, k % 200 * 5).unwrap();
    }
    let rate = single(&text).0.rate_hz().unwrap();
    assert!((rate - 200.0).abs() < 1e-9, "{rate}");
}

/// A 64-bit integer has digits that a float does not have.
#[test]
fn stamps_of_a_file_of_arrays_keep_their_digits() {
    let head = "{'descr': [('t_ns', '<i8'), ('S1', '<f8'), ('Fz', '<f8')], 'fortran_order': False, 'shape': (400,), }";
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((head.len() as u16).to_le_bytes());
    file.extend(head.bytes());
    for k in 0..400_i64 {
        file.extend((1_763_000_000_123_456_789 + k * 19_531).to_le_bytes());
        file.extend((k as f64).to_le_bytes());
        file.extend(((k % 7) as f64).to_le_bytes());
    }
    let recording = TestFile::new(file).read().unwrap().recordings.remove(0);
    let rate = recording.rate_hz().unwrap();
    assert!((rate - 1e9 / 19_531.0).abs() < 1e-3, "{rate}");
    assert!((recording.clock_time(0) - 1_763_000_000.123_456_8).abs() < 1e-6);
}

#[test]
fn two_clocks_of_the_same_day_are_joined() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("a.csv", "time,S1\n1763000000.25,1\n1763000000.50,2\n1763000000.75,3\n");
    write("a_ref.csv", "time,Fz\n1762999999.5,0\n1763000001.5,2\n");
    let map = ColumnMap::from_json(
        br#"{"format": "loopscope column map", "version": 1,
        "table": {"shape": {"columns": 2, "names": ["time", "S1"]}, "text": {"header": true},
            "columns": [{"column": "time", "is": "time", "unit": "s"}, {"column": "S1", "is": "gauge"}]},
        "reference": {"file": "{stem}_ref.csv", "table": {"shape": {"columns": 2, "names": ["time", "Fz"]}, "text": {"header": true},
            "columns": [{"column": "time", "is": "time", "unit": "s"}, {"column": "Fz", "is": "Fz"}]}},
        "join": {"limit_secs": 9}}"#,
    );
    let path = folder.path().join("a.csv");
    let loaded = read(&path, Some(&map.unwrap()), &[], &Progress::default()).unwrap();
    assert_eq!(loaded.recordings[0].loads(), [0.75, 1.0, 1.25]);
}

#[test]
fn lines_of_a_terminal_start_with_their_time() {
    for names in ["", "12:03:04.000 -> S1,S2,Fz\n"] {
        let mut text = names.to_owned();
        for k in 0..40 {
            writeln!(text, "12:03:0{}.{:03} -> {k},{},{}", 4 + k / 20, k % 20 * 50, 80 - k, k % 5)
                .unwrap();
        }
        let file = TestFile::new(&text);
        if names.is_empty() {
            assert!(file.read().unwrap().asked().is_some());
            continue;
        }
        let (recording, _) = single(&text);
        assert_eq!(
            (recording.n_samples(), recording.gauge_names().join(" ")),
            (40, "S1 S2".into())
        );
        assert!((recording.rate_hz().unwrap() - 20.0).abs() < 1e-6);
        assert_eq!(recording.loads()[..6], [0.0, 1.0, 2.0, 3.0, 4.0, 0.0]);
    }
}

#[test]
fn milliseconds_may_follow_a_colon() {
    let (recording, _) =
        single("time,S1,Fz\n10:11:12:000,1,2\n10:11:12:250,2,3\n10:11:12:500,4,4\n");
    assert_eq!(recording.rate_hz(), Some(4.0));
}

#[test]
fn a_word_with_its_value_is_not_a_header() {
    for (names, delimiter) in [("Zeit Kan1 Kan2 Druck", " "), ("q;alpha;beta;gamma", ";")] {
        let mut text =
            format!("{names}\n{}\nSample rate: 200 Hz\n", ["s", "mV", "mV", "N"].join(delimiter));
        for k in 0..20 {
            let row = [k, 3 * k, 50 - k, k % 3].map(|x| x.to_string());
            writeln!(text, "{}", row.join(delimiter)).unwrap();
        }
        let layout = crate::formats::text::detect(text.as_bytes()).unwrap();
        assert_eq!((layout.header, layout.skip_rows, layout.units_row), (true, 0, true), "{names}");
    }
}

#[test]
fn the_overload_codes_of_meters_are_not_values() {
    let (recording, findings) =
        single("t_s,S1,Fz\n0,1,2\n1,9.9E+37,2\n2,2,-9.91e37\n3,3,4\n4,4,5\n");
    assert_eq!(recording.gauges(), [1.0, 3.0, 4.0]);
    assert!(findings[0].to_string().contains("its range is exceeded"), "{findings:?}");
}

#[test]
fn a_comment_in_quotes_may_hold_a_line_end() {
    let text = "t,S1,Fz,note\n0,1,2,a\n1,2,3,\"two\nlines, \"\"quoted\"\"\r\nor three\"\n2,3,4,b\n3,4,x,\n";
    let loaded = TestFile::new(text).read().unwrap();
    assert_eq!(loaded.recordings[0].gauges(), [1.0, 2.0, 3.0]);
    let skipped = loaded.warnings.iter().find(|own| own.id == Id::RowsSkipped).unwrap();
    let place = skipped.place.as_ref().unwrap();
    assert_eq!((place.first_line, place.count), (7, 1));
}

fn with_stamps(text: &str, stamps: &str) -> Vec<Recording> {
    let file = TestFile::new(text);
    let rule = |name: &str, is: &str| format!(r#"{{"column": "{name}", "is": "{is}"}}"#);
    let columns = [("t", "time"), ("S1", "gauge"), ("Fz", "Fz")].map(|(name, is)| rule(name, is));
    let map = format!(
        r#"{{"format": "loopscope column map", "version": 1, "table": {{"shape": {{"columns": 3, "names": ["t", "S1", "Fz"]}},
        "text": {{"header": true}}, "stamps": "{stamps}", "columns": [{}]}}}}"#,
        columns.join(",")
    );
    let map = ColumnMap::from_json(map.as_bytes()).unwrap();
    read(&file.path, Some(&map), &[], &Progress::default()).unwrap().recordings
}

#[test]
fn rows_written_late_can_be_sorted() {
    let mut text = String::from("t,S1,Fz\n");
    for k in 0..60_i32 {
        // Two of ten rows are exchanged.
        let own = match k % 10 {
            4 => k + 1,
            5 => k - 1,
            _ => k,
        };
        writeln!(text, "{},{own},{}", f64::from(own) / 20.0, own % 7).unwrap();
    }
    let loaded = TestFile::new(&text).read().unwrap();
    assert_eq!(loaded.recordings.len(), 7);
    assert!(
        loaded.warnings.iter().any(|own| *own == Cause::LateRows { count: 6 }),
        "{:?}",
        loaded.warnings
    );
    let sorted = with_stamps(&text, "sorted");
    assert_eq!(sorted.len(), 1);
    let gauges: Vec<f64> = (0..60).map(f64::from).collect();
    assert_eq!(sorted[0].gauges(), gauges);
}

#[test]
fn rows_with_the_same_stamp_can_be_spread() {
    let mut text = String::from("t,S1,Fz\n");
    // The rate is 20 Hz, and the first row is in the middle of a second.
    for k in 10..110 {
        writeln!(text, "{},{k},{}", k / 20, k % 7).unwrap();
    }
    let loaded = TestFile::new(&text).read().unwrap();
    assert!(loaded.warnings.iter().any(|own| *own == Cause::CoarseStamps), "{:?}", loaded.warnings);
    let spread = with_stamps(&text, "spread");
    assert_eq!(spread.len(), 1);
    for (k, time) in (10..110).zip(spread[0].times()) {
        assert!((time - f64::from(k) / 20.0).abs() < 1e-9, "{k}: {time}");
    }
    // A pause still ends a recording.
    let later = text.lines().skip(1).map(|row| row.split_once(',').unwrap());
    let later: Vec<String> =
        later.map(|(t, rest)| format!("{},{rest}", t.parse::<i32>().unwrap() + 100)).collect();
    assert_eq!(with_stamps(&format!("{text}{}\n", later.join("\n")), "spread").len(), 2);
}

/// PlotJuggler and pandas write topics with different times in one table.
#[test]
fn topics_in_one_table_are_two_clocks() {
    let mut text = String::from("time,S1,S2,Fz\n");
    for k in 0..200 {
        let time = f64::from(k) * 0.01;
        match k % 2 {
            0 => writeln!(text, "{time},{},{},", k, 300 - k).unwrap(),
            _ => writeln!(text, "{time},,,{}", 2 * k).unwrap(),
        }
    }
    let (recording, findings) = single(&text);
    assert!(findings.iter().any(|own| *own == Cause::TurnByTurn), "{findings:?}");
    // The first row is before any reference.
    assert_eq!(recording.n_samples(), 99);
    for (k, load) in (1..100).zip(recording.loads()) {
        assert!((load - f64::from(4 * k)).abs() < 1e-9, "{k}: {load}");
    }
    assert!(findings.iter().all(|own| own.id != Id::RowsSkipped), "{findings:?}");
}
