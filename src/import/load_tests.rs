//! Files read by column maps: joined clocks, removed values, and refused maps.

use std::path::{Path, PathBuf};

use super::error::TableError;
use super::load::Reading;
use super::named_column::NamedColumn;
use super::*;
use crate::{
    finding::{Advice, Face, Finding},
    import::map::ColumnMap,
    progress::Progress,
    recording::{Axis, Recording},
};

struct Folder(tempfile::TempDir);

impl Folder {
    fn with(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn read(&self, name: &str, map: &ColumnMap) -> Result<Loaded, ReadError> {
        read(&self.path(name), Some(map), &[], &Progress::default())
    }
}

#[track_caller]
fn map(parts: &str) -> ColumnMap {
    let text = format!("{{ \"format\": \"loopscope column map\", \"version\": 1, {parts} }}");
    ColumnMap::from_json(text.as_bytes()).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn read_one(content: &str, parts: &str) -> Result<Loaded, ReadError> {
    Folder::with(&[("run.csv", content)]).read("run.csv", &map(parts))
}

#[track_caller]
fn single(loaded: Result<Loaded, ReadError>) -> (Recording, Vec<Finding>) {
    let mut loaded = loaded.unwrap();
    assert_eq!(loaded.recordings.len(), 1, "{:?}", loaded.warnings);
    (loaded.recordings.remove(0), loaded.warnings)
}

/// A thermometer is slower than the gauges, and its cells between two values are blank. No row is lost for this.
#[test]
fn an_auxiliary_value_is_held_and_costs_no_row() {
    let text = "t [s],S1,Fz,temperature [K],spare temp\n0,1,1,,\n0.1,2,2,300.15,\n0.2,3,3,x,\n0.3,4,4,301.15,\n";
    let folder = Folder::with(&[("run.csv", text)]);
    let loaded = read(&folder.path("run.csv"), None, &[], &Progress::default());
    let (recording, findings) = single(loaded);
    let auxiliary = recording.auxiliary();
    assert_eq!(auxiliary.names(), ["temperature"]);
    assert_eq!(auxiliary.units(), ["°C"]);
    let celsius: Vec<f64> = auxiliary.values().iter().map(|value| value.round()).collect();
    assert_eq!(celsius, [27.0, 27.0, 27.0, 28.0]);
    let names = vec!["spare temp".to_owned()];
    assert_eq!(findings, [Cause::IgnoredColumns { names }]);
}

/// Rows are 10 ms apart. The first thermometer has no value in row 20 and in 60 rows from row 100 on. A slow one has a value
/// in every 20th row and then stops for 100 rows.
#[test]
fn missing_auxiliary_values_are_reported_and_known_to_the_recording() {
    let mut text = String::from("t [s],S1,Fz,temperature,humidity\n");
    for k in 0..400 {
        let temperature = if k == 20 || (100..160).contains(&k) { "" } else { "21.5" };
        let humidity = if k % 20 == 0 && !(200..300).contains(&k) { "40" } else { "" };
        let t = 0.01 * f64::from(k);
        text += &format!("{t:.2},{k},{k},{temperature},{humidity}\n");
    }
    let folder = Folder::with(&[("run.csv", &text)]);
    let loaded = read(&folder.path("run.csv"), None, &[], &Progress::default());
    let (recording, findings) = single(loaded);
    // The slow thermometer continues after five of its steps.
    let (name, longest_secs) = ("temperature".to_owned(), Some(0.61));
    assert_eq!(findings, [Cause::HeldAuxiliary { name, n_rows: 61, longest_secs }]);
    let is_held = |recording: &Recording, t: f64| recording.auxiliary().is_held_at(t);
    let held = [0.2, 0.99, 1.0, 1.59, 1.6].map(|t| is_held(&recording, t));
    assert_eq!(held, [false, false, true, true, false]);
    let (_, rest) = recording.split(0.3).unwrap();
    assert!(is_held(&rest, 1.3) && is_held(&rest.decimated(3), 1.3));
    let humidity = recording.with_auxiliary_of(&["humidity".to_owned()]).unwrap();
    assert!(!is_held(&humidity, 1.3));
}

#[test]
fn an_auxiliary_channel_of_a_map_has_its_name_and_unit() {
    let parts = r#""table": { "shape": { "columns": 4 }, "columns": [ { "column": 1, "is": "time", "unit": "s" },
        { "column": 2, "is": "gauge" }, { "column": 3, "is": "Fz" },
        { "column": 4, "is": "auxiliary", "name": "supply", "unit": "mV", "scale": 2 } ] }"#;
    let (recording, _) = single(read_one("0,1,1,2500\n1,2,2,2400\n", parts));
    assert_eq!(recording.auxiliary().in_words(), ["supply 4.80 to 5.00 V"]);
    let again = parts.replace("\"is\": \"gauge\"", "\"is\": \"auxiliary\", \"name\": \"supply\"");
    let again =
        again.replace("{ \"column\": 3, \"is\": \"Fz\" }", "{ \"column\": 3, \"is\": \"gauge\" }");
    let error = read_one("0,1,1,2500\n1,2,2,2400\n", &again).unwrap_err().to_string();
    assert!(error.contains("columns 2 and 4 are both read as auxiliary supply"), "{error}");
}

const HEADERLESS: &str = r#""table": { "shape": { "columns": 4 }, "text": { "delimiter": "semicolon", "decimal": "comma" },
    "columns": [
        { "column": 1, "is": "time", "unit": "ms" },
        { "column": 4, "is": "gauge", "unit": "mV/V", "scale": -2 },
        { "column": 2, "is": "Fz", "unit": "kN", "scale": -1, "counts_per_unit": 4 } ] }"#;

#[test]
fn a_headerless_file_is_read_by_numbers_units_and_signs() {
    let (recording, findings) = single(read_one("0;1,5;x;3\n10;-2;y;4,25\n", HEADERLESS));
    assert_eq!(recording.times(), [0.0, 0.01]);
    assert_eq!(recording.gauge_names(), ["S1"]);
    assert_eq!(recording.gauge_units(), ["mV/V"]);
    assert_eq!(recording.gauges(), [-6.0, -8.5]);
    assert_eq!((recording.axes(), recording.loads()), (&[Axis::Fz][..], &[-375.0, 500.0][..]));
    assert!(findings.is_empty(), "{findings:?}");
}

/// With a decimal comma, 1.500 may be fifteen hundred, so it is refused.
#[test]
fn a_point_among_decimal_commas_is_not_a_number() {
    let (recording, findings) = single(read_one("0;1;x;3\n5;1;x;1.500\n10;1;x;4\n", HEADERLESS));
    assert_eq!(recording.n_samples(), 2);
    let text = findings[0].to_string();
    assert!(text.contains("column 4") && text.contains("\"1.500\", not a number"), "{text}");
}

#[test]
fn times_can_be_counted_at_a_rate() {
    let parts = r#""table": { "shape": { "columns": 1 }, "sample_rate_hz": 4, "columns": [{ "column": 1, "is": "gauge" }] }"#;
    let (recording, findings) = single(read_one("1\n2\n\n# note\nx\n4\n", parts));
    // The unreadable row still takes its time; the blank line and the comment do not.
    assert_eq!(recording.times(), [0.0, 0.25, 0.75]);
    assert_eq!(findings.len(), 1);
    let in_blocks = |block_bytes| {
        let folder = Folder::with(&[("run.csv", "1\n2\n\n# note\nx\n4\n")]);
        let progress = Progress::default();
        let reading = Reading { block_bytes, ..Reading::whole(&progress) };
        reading.load(&folder.path("run.csv"), Some(&map(parts))).unwrap()
    };
    assert_eq!(in_blocks(1).recordings[0].times(), recording.times());
}

#[test]
fn a_column_can_count_samples() {
    let parts = |rate: &str| {
        format!(
            r#""table": {{ "shape": {{ "columns": 2 }}, {rate} "columns": [
            {{ "column": 1, "is": "time", "unit": "samples" }}, {{ "column": 2, "is": "gauge" }}] }}"#
        )
    };
    let (recording, _) = single(read_one("7,1\n8,2\n10,3\n", &parts("\"sample_rate_hz\": 2,")));
    assert_eq!(recording.times(), [3.5, 4.0, 5.0]);
    let error = read_one("7,1\n", &parts("")).unwrap_err();
    assert!(matches!(
        error,
        ReadError::Table {
            source: TableError::NoSampleRate { column: NamedColumn { number: 1, .. } },
            ..
        }
    ));
}

#[test]
fn dates_are_read_from_one_column_and_from_two() {
    let two = r#""table": { "shape": { "columns": 3, "names": ["Date", "Time", "S1"] }, "text": { "header": true }, "columns": [
        { "column": "Date", "is": "date", "unit": "d/m/y" }, { "column": "Time", "is": "time", "unit": "h:m:s" },
        { "column": "S1", "is": "gauge" }] }"#;
    let (recording, _) =
        single(read_one("Date,Time,S1\n9.9.2001,1:46:39.5,1\n9.9.2001,1:46:40,2\n", two));
    assert_eq!(recording.clock_time(0), 999_999_999.5);
    assert_eq!(recording.clock_time(1), 1e9);
    // Without a map, names and values give the same result.
    let folder = Folder::with(&[
        ("two.csv", "Date,Time,S1\n2001-09-09,1:46:39.5,1\n2001-09-09,1:46:40,2\n"),
        ("one.csv", "time,S1\n2001-09-09T01:46:39.5Z,1\n2001-09-09T01:46:40Z,2\n2001-09-09,x\n"),
    ]);
    for name in ["two.csv", "one.csv"] {
        let loaded = read(&folder.path(name), None, &[], &Progress::default()).unwrap();
        assert_eq!(loaded.recordings[0].times(), recording.times(), "{name}");
    }
}

#[test]
fn a_units_row_is_read_by_names() {
    let folder = Folder::with(&[(
        "run.csv",
        "Export of 1 May\n\ntime;S1;Fx\n[ms];[mV/V];[kN]\n0;1;2\n10;3;4\n",
    )]);
    let loaded = read(&folder.path("run.csv"), None, &[], &Progress::default()).unwrap();
    let recording = &loaded.recordings[0];
    assert_eq!((recording.times(), recording.loads()), (&[0.0, 0.01][..], &[2000.0, 4000.0][..]));
    assert_eq!(recording.gauge_units(), ["mV/V"]);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
}

const TWO_CLOCKS: &str = r#""table": { "shape": { "columns": 4 }, "columns": [
    { "column": 1, "is": "time", "unit": "s" }, { "column": 2, "is": "gauge" },
    { "column": 3, "is": "time_reference", "unit": "ms" }, { "column": 4, "is": "Fx" }] }"#;

#[test]
fn a_reference_on_its_own_clock_is_evaluated_at_the_times_of_the_gauges() {
    // The reference ends earlier, so its columns are shorter and the last gauge samples have no reference.
    let text = "0,1,125,10\n0.25,2,375,30\n0.5,3,625,50\n0.75,4,,\n1,5,,\n";
    let join =
        |join: &str| single(read_one(text, &format!("{TWO_CLOCKS}, \"join\": {{ {join} }}")));
    let seen = |recording: &Recording| (recording.times().to_vec(), recording.loads().to_vec());
    let (recording, findings) = join("");
    assert_eq!(recording.gauges(), [2.0, 3.0]);
    assert_eq!(seen(&recording), (vec![0.25, 0.5], vec![20.0, 40.0]));
    assert_eq!(findings, [Cause::NoReferenceThen { time_secs: 0.0 }]);
    let (held, _) = join(r#""method": "hold", "limit_secs": 0.15"#);
    assert_eq!(seen(&held), (vec![0.25, 0.5, 0.75], vec![10.0, 30.0, 50.0]));
    let (shifted, _) = join(r#""clock_offset_secs": -0.125"#);
    assert_eq!(seen(&shifted), (vec![0.0, 0.25, 0.5], vec![10.0, 30.0, 50.0]));
}

const TWO_FILES: &str = r#""table": { "shape": { "columns": 2 }, "columns": [
        { "column": 1, "is": "time", "unit": "s" }, { "column": 2, "is": "gauge" }] },
    "reference": { "file": "{stem}_ref.csv", "table": { "shape": { "columns": 2 }, "columns": [
        { "column": 1, "is": "time", "unit": "s" }, { "column": 2, "is": "Fx", "dropouts": [-1] }] } }"#;

#[test]
fn a_reference_file_is_joined_without_its_dropouts() {
    let folder =
        Folder::with(&[("a.csv", "0,1\n1,2\n2,3\n"), ("a_ref.csv", "0,0\n0.5,-1\n1,10\n2,20\n")]);
    let progress = Progress::default();
    let loaded = read(&folder.path("a.csv"), Some(&map(TWO_FILES)), &[], &progress).unwrap();
    assert_eq!(loaded.recordings[0].loads(), [0.0, 10.0, 20.0]);
    let [dropout] = &loaded.warnings[..] else { panic!("{:?}", loaded.warnings) };
    let place = dropout.place.as_ref().unwrap();
    assert!(place.path.ends_with("a_ref.csv") && place.first_line == 2);
    assert!(dropout.seen.contains("column 2 (Fx) contains -1, which marks"), "{dropout}");
    // The second file is counted too: progress reaches the total plus the size of the first file.
    progress.add_total(std::fs::metadata(folder.path("a.csv")).unwrap().len());
    assert_eq!(progress.fraction(), Some(1.0));
}

#[test]
fn clocks_that_cannot_be_joined_give_an_error_with_the_reason() {
    let messages = |reference: &str| {
        let folder = Folder::with(&[("a.csv", "0,1\n1,2\n"), ("a_ref.csv", reference)]);
        folder.read("a.csv", &map(TWO_FILES)).unwrap_err().text(Face::CommandLine)
    };
    let apart = messages("100,1\n101,2\n");
    assert!(apart.contains("times of the gauges are 0 s to 1 s"), "{apart}");
    assert!(apart.contains("clock_offset_secs"), "{apart}");
    let back = messages("0,1\n1,2\n0.5,3\n");
    assert!(
        back.contains(
            "a_ref.csv, line 3: the time of the reference load goes back from 1 s to 0.5 s"
        ),
        "{back}"
    );
    assert!(messages("0,-1\n1,-1\n").contains("a_ref.csv, line 1: column 2 (Fx) contains -1"));
    let folder = Folder::with(&[("a.csv", "0,1\n1,2\n")]);
    let gone = folder.read("a.csv", &map(TWO_FILES)).unwrap_err();
    assert!(gone.to_string().contains("a_ref.csv: the file cannot be read"), "{gone}");
}

const NET_FT: &str = "Start Time: Nov 5, 2026, 3:00:00 PM\nRDT Sample Rate: 100\nForce Units: N\n\
    Counts per Unit Force: 1000\nTorque Units: N-mm\nCounts per Unit Torque: 10\n\
    Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time\n\
    0, 500, 9, 1000, 0, -2000, 10000, 0, 0, \"Nov 5, 2026, 3:00:01 PM\"\n\
    80000002, 501, 9, 9999, 9, 9, 9, 9, 9, \"Nov 5, 2026, 3:00:01 PM\"\n\
    10000, 502, 9, 3000, 0, -2000, 30000, 0, 0, \"Nov 5, 2026, 3:00:01 PM\"\n";

#[test]
fn a_net_ft_log_is_a_reference_in_counts_without_the_rows_that_report_errors() {
    let folder = Folder::with(&[("run.csv", "t_s,S1\n5,1\n5.01,2\n5.02,3\n"), ("ati.csv", NET_FT)]);
    let progress = Progress::default();
    let inspection = inspect::inspect(&folder.path("ati.csv"), inspect::Known::Nothing, &progress);
    let proposed = inspection.unwrap().map.table;
    let gauges = inspect::inspect(&folder.path("run.csv"), inspect::Known::Nothing, &progress);
    let map = ColumnMap {
        reference: Some(crate::import::map::ReferenceFile {
            file: "ati.csv".to_owned(),
            table: proposed,
        }),
        ..gauges.unwrap().map
    };
    let (recording, findings) = single(folder.read("run.csv", &map));
    assert_eq!(recording.axes(), Axis::ALL);
    assert_eq!(recording.times(), [5.0, 5.01, 5.02]);
    let on_axis =
        |axis| recording.loads().iter().skip(axis).step_by(6).copied().collect::<Vec<_>>();
    assert_eq!(on_axis(0)[1..], [2.0, 3.0]);
    assert_eq!(on_axis(2), [-2.0, -2.0, -2.0]);
    assert_eq!(on_axis(3), [1.0, 2.0, 3.0]);
    let [error] = &findings[..] else { panic!("{findings:?}") };
    assert!(
        error.seen.contains("80000002, a status by which the device reports an error"),
        "{error}"
    );
    let (alone, _) = single(read(&folder.path("ati.csv"), None, &[], &progress));
    assert_eq!((alone.n_gauges(), alone.axes()), (0, &Axis::ALL[..]));
}

#[test]
fn a_map_for_another_file_is_refused_with_expected_and_actual_columns() {
    let named = r#""table": { "shape": { "columns": 3, "names": ["t", "A", "B"] }, "text": { "header": true }, "columns": [
        { "column": "t", "is": "time" }, { "column": "A", "is": "gauge" }, { "column": 3, "is": "Fx" }] }"#;
    for (content, parts, messages) in [
        (
            "1;2;3\n",
            HEADERLESS,
            "run.csv, line 1: the column map is for files with 4 columns, but this file has 3",
        ),
        ("1,2,3,4\n", HEADERLESS, "is for files with 4 columns, but this file has 1"),
        ("t,A,B,C\n0,1,2,3\n", named, "is for files with 3 columns, but this file has 4"),
        (
            "t,X,B\n0,1,2\n",
            named,
            "the column map needs a column named A, but the columns of this file are t, X, B",
        ),
        ("t,A,C\n0,1,2\n", named, "the name of column 3 is C in this file, but B in the map"),
        ("t,A,A\n0,1,2\n", named, "columns 2 and 3 are both named A"),
        ("# nothing\n", named, "at the start of the file, but this file has none"),
        ("t,A,B\n", named, "the table has a header, but no rows"),
        ("0;a;b;c\n", HEADERLESS, "run.csv, line 1: column 2 (Fz) contains \"a\", not a number"),
    ] {
        let error = read_one(content, parts).unwrap_err().to_string();
        assert!(error.contains(messages), "{content}: {error}");
    }
    let more_columns =
        read_one("x,t,A\n0,1,2\n", &named.replace(", { \"column\": 3, \"is\": \"Fx\" }", ""));
    assert_eq!(more_columns.unwrap().recordings[0].gauges(), [2.0]);
}

/// One rule uses the column's name, another its number, so there are two rules for one column.
#[test]
fn a_column_listed_by_name_and_by_number_is_an_error_that_names_both() {
    let parts = |columns: &str| {
        format!(
            r#""table": {{ "shape": {{ "columns": 4 }}, "text": {{ "header": true }}, "columns": [
            {{ "column": "t [s]", "is": "time" }}, {{ "column": "S1", "is": "gauge" }}, {columns}] }}"#
        )
    };
    for (columns, number, keys) in [
        (
            r#"{ "column": "Fx [N]", "is": "Fx" }, { "column": 4, "is": "Fy" }"#,
            4,
            "as \"Fx [N]\" and as 4",
        ),
        (
            r#"{ "column": 4, "is": "ignore" }, { "column": "Fx [N]", "is": "Fx" }"#,
            4,
            "as 4 and as \"Fx [N]\"",
        ),
        (r#"{ "column": 2, "is": "gauge", "name": "again" }"#, 2, "as \"S1\" and as 2"),
        (
            r#"{ "column": 1, "is": "time_reference" }, { "column": 4, "is": "Fx" }"#,
            1,
            "as \"t [s]\" and as 1",
        ),
        (r#"{ "column": "S1", "is": "Fx" }"#, 2, "as \"S1\" and as \"S1\""),
    ] {
        let text = "t [s],S1,S2,Fx [N]\n0,1,2,3\n0.1,2,3,4\n";
        let error = read_one(text, &parts(columns)).unwrap_err();
        assert!(matches!(error, ReadError::Table { source: TableError::MapKey(_), .. }), "{error}");
        let messages = error.to_string();
        let place = format!("run.csv, line 1: column {number} is listed twice, {keys}");
        assert!(messages.contains(&place), "{messages}");
    }
    let both_known = parts(r#"{ "column": "Fx [N]", "is": "Fx" }, { "column": 4, "is": "Fy" }"#)
        .replace(
            "\"columns\": 4",
            "\"columns\": 4, \"names\": [\"t [s]\", \"S1\", \"S2\", \"Fx [N]\"]",
        );
    let text = format!("{{ \"format\": \"loopscope column map\", \"version\": 1, {both_known} }}");
    let at_once = ColumnMap::from_json(text.as_bytes()).unwrap_err().to_string();
    assert!(at_once.contains("column 4 is listed twice, as \"Fx [N]\" and as 4"), "{at_once}");
}

#[test]
fn a_map_made_in_code_is_checked_too() {
    let mut wrong = map(HEADERLESS);
    wrong.table.columns[0].scale = f64::NAN;
    let folder = Folder::with(&[("run.csv", "0;1;x;3\n")]);
    let error = folder.read("run.csv", &wrong).unwrap_err();
    assert!(matches!(error, ReadError::Map(_)), "{error}");
}

#[test]
fn the_number_of_skipped_lines_is_that_of_the_map() {
    let preamble = "a line of a long preamble\n".repeat(700);
    let parts = HEADERLESS.replace("\"decimal\"", "\"skip_rows\": 700, \"decimal\"");
    let (recording, _) = single(read_one(&format!("{preamble}0;1;x;3\n10;2;x;4\n"), &parts));
    assert_eq!(recording.gauges(), [-6.0, -8.0]);
}

/// The largest floating-point numbers, when interpolated and scaled, are removed and never become infinite.
#[test]
fn numbers_at_the_end_of_the_range_stay_finite_or_are_removed() {
    let slow = r#""table": { "shape": { "columns": 2 }, "sample_rate_hz": 0.1, "columns": [
        { "column": 1, "is": "time", "unit": "samples" }, { "column": 2, "is": "gauge" }] }"#;
    let (recording, findings) = single(read_one("1,1\n2,2\n1.5e308,3\n", slow));
    assert_eq!(recording.times(), [10.0, 20.0]);
    let text = &findings[0].seen;
    assert!(text.contains("column 1") && text.contains("not a finite number"), "{text}");
    assert!(read_one("1.5e308,1\n", slow).is_err());
    let blended = read_one("1,1,0,-1.7e308\n1.5,1,2000,1.7e308\n", TWO_CLOCKS).unwrap_err();
    assert!(matches!(blended, ReadError::ClocksApart { .. }));
}

#[test]
fn roles_that_exclude_each_other_are_named() {
    let with = |columns: &str| {
        let parts =
            format!(r#""table": {{ "shape": {{ "columns": 4 }}, "columns": [{columns}] }}"#);
        read_one("1,2,3,4\n", &parts).unwrap_err().to_string()
    };
    let time = r#"{ "column": 1, "is": "time" }"#;
    let twice = with(&format!(r#"{time}, {{ "column": 2, "is": "time" }}"#));
    assert!(twice.contains("columns 1 and 2 are both read as time"), "{twice}");
    assert!(with(time).contains("no column of numbers among 4 columns without names"));
    let same = r#"{ "column": 2, "is": "gauge", "name": "a" }, { "column": 3, "is": "gauge", "name": "a" }"#;
    assert!(with(&format!("{time}, {same}")).contains("columns 2 and 3 are both read as gauge a"));
    let unit = r#"{ "column": 2, "is": "gauge" }, { "column": 3, "is": "Fx", "unit": "stone" }"#;
    assert!(with(&format!("{time}, {unit}")).contains("column 3 (Fx) has the unknown unit stone"));
    let clock = r#"{ "column": 2, "is": "gauge" }, { "column": 3, "is": "time_reference" }"#;
    assert!(with(&format!("{time}, {clock}")).contains("no reference load among"));
}

#[test]
fn a_proposed_map_reads_its_file_like_its_names_do() {
    for content in [
        "t,S1,Fx [kN]\n0,1,2\n0.1,3,4\n",
        "Logger\nt_ms;S1;S1;Fx\n0;1,5;2;3\n10;1;2;3,5\n",
        "time [s]  S1 (mV / V)  note\n0 1 x\n1 2 y\n",
        "# t S1\n0 1\n1 2\n",
    ] {
        let folder = Folder::with(&[("run.csv", content)]);
        let path = folder.path("run.csv");
        let inspected = inspect::inspect(&path, inspect::Known::Nothing, &Progress::default());
        let inspection = inspected.unwrap();
        match read(&path, None, &[], &Progress::default()) {
            Ok(loaded) => {
                let mapped = folder.read("run.csv", &inspection.map).unwrap();
                assert_eq!(mapped.recordings, loaded.recordings, "{content}");
                assert_eq!(inspection.check.error, None, "{content}");
            }
            Err(error) => assert_eq!(inspection.check.error, Some(error.to_string())),
        }
    }
}

/// A header identifies the files of a map. Without one, the layout and the values do.
#[test]
fn a_map_is_used_for_files_that_match_it() {
    let rows = "0;1,5;2;3\n10;-2;1;4,25\n20;2,5;0;3\n30;1,5;1;5\n";
    let own = |content: &str| {
        let folder = Folder::with(&[("run.csv", content)]);
        let path = folder.path("run.csv");
        let inspected = inspect::inspect(&path, inspect::Known::Nothing, &Progress::default());
        inspected.unwrap().map
    };
    let maps = [own(rows), own(&format!("a;b [N];c;d\n{rows}"))];
    let found = |content: &str| {
        let folder = Folder::with(&[("run.csv", content)]);
        let found = inspect::map_for(&folder.path("run.csv"), &maps, &Progress::default());
        found.unwrap().map(|map| maps.iter().position(|other| other == map).unwrap())
    };
    let fewer = rows.replace("0;1,5", "5;1,5").replace("10;", "15;");
    assert_eq!(found(&fewer), Some(0));
    assert_eq!(found(&format!("a;b [N];c;d\n{fewer}")), Some(1));
    for other in [
        rows.replace(';', "\t"),
        rows.replace(',', "."),
        format!("Logger 7\n\n{rows}"),
        rows.replace("10;", "-10;"),
        rows.replace(";3\n", ";on\n").replace(";5\n", ";off\n"),
        rows.replace('\n', ";1\n"),
        format!("a;b [kN];c;d\n{rows}"),
        format!("b [N];a;c;d\n{rows}"),
        "a;b [N];c\n0;1;2\n10;1;2\n".to_owned(),
    ] {
        assert_eq!(found(&other), None, "{other}");
    }
}

#[test]
fn inspection_shows_questions_that_names_leave_open() {
    let content = "5;0;10,5;7\n6;0,5;10,5;8\n5;1;10,5;9\n7;1,5;10,5;7\n";
    let folder = Folder::with(&[("run.csv", content)]);
    let path: &Path = &folder.path("run.csv");
    let inspection = inspect::inspect(path, inspect::Known::Nothing, &Progress::default()).unwrap();
    let roles: Vec<&str> = inspection.table.columns.iter().map(|column| column.is.name()).collect();
    assert_eq!(roles, ["gauge", "time", "ignore", "gauge"]);
    assert_eq!((inspection.table.about_rows, inspection.table.line), (4, Some(1)));
    assert_eq!(inspection.table.columns[0].max, Some(7.0));
    assert_eq!(inspection.questions.len(), 1);
    let check = &inspection.check;
    assert_eq!((check.error.as_ref(), check.recordings[0].n_samples), (None, 4));
    assert_eq!((check.gauges.len(), check.recordings[0].rate_hz), (2, Some(2.0)));
}

/// Headers that ROS tools and German measuring programs write for a wrench and for an array.
#[test]
fn headers_of_other_programs_are_understood_without_a_map() {
    let gauges = |name: fn(usize) -> String| (0..2).map(name).collect::<Vec<_>>().join(",");
    let bagpy =
        "Time,header.seq,header.stamp.secs,header.stamp.nsecs,wrench.force.x,wrench.torque.z,S1,S2";
    for (header, row) in [
        (bagpy.to_owned(), "1700000000.5,7,1700000000,500000000,1,2,3,4"),
        (
            format!(
                "%time,field.header.stamp,field.wrench.force.x,field.wrench.torque.z,{}",
                gauges(|k| format!("/gauges/data[{k}]"))
            ),
            "1700000000500000000,1700000000500000000,1,2,3,4",
        ),
        (
            format!(
                "__time,/ft/wrench/force/x,/ft/wrench/torque/z,{}",
                gauges(|k| format!("/gauges/data.{k}"))
            ),
            "1700000000.5,1,2,3,4",
        ),
        (
            format!(
                "header.stamp.sec,header.stamp.nanosec,wrench.force.x,wrench.torque.z,{}",
                gauges(|k| format!("strain[{k}]"))
            ),
            "1700000000,500000000,1,2,3,4",
        ),
        ("Zeit [s];Kraft X [N];Drehmoment z [Nm];DMS 1;DMS 2".to_owned(), "1700000000,5;1;2;3;4"),
    ] {
        let folder = Folder::with(&[("run.csv", &format!("{header}\n{row}\n"))]);
        let loaded = read(&folder.path("run.csv"), None, &[], &Progress::default());
        let recording = &loaded.unwrap_or_else(|error| panic!("{error}")).recordings[0];
        assert_eq!(recording.clock_time(0), 1_700_000_000.5, "{header}");
        assert_eq!(recording.gauges(), [3.0, 4.0], "{header}");
        assert_eq!(recording.axes(), [Axis::Fx, Axis::Mz], "{header}");
        assert_eq!(recording.loads(), [1.0, 2.0], "{header}");
    }
}

#[test]
fn one_of_several_wrenches_is_the_reference_and_the_others_are_named() {
    let (recording, findings) = single(read_by_names(
        "t,/dut/wrench/force/x,/ati/wrench/force/x,/dut/wrench/force/y,S1\n0,1,2,3,4\n0.1,2,3,4,5\n",
    ));
    assert_eq!(recording.loads(), [2.0, 3.0]);
    let cause = Cause::SeveralReferences {
        used: vec!["/ati/wrench/force/x".into()],
        others: vec!["/dut/wrench/force/x".into(), "/dut/wrench/force/y".into()],
    };
    assert_eq!(findings, [cause]);
}

fn read_by_names(content: &str) -> Result<Loaded, ReadError> {
    let folder = Folder::with(&[("run.csv", content)]);
    read(&folder.path("run.csv"), None, &[], &Progress::default())
}

/// The second column changes late, and the third rises for long before it falls: ten rows alone would mislead.
#[test]
fn roles_are_guessed_from_rows_all_over_the_file() {
    use crate::import::map::ColumnRole;
    let roles = |n_rows: usize| -> Vec<ColumnRole> {
        let mut content = String::from("stamp of host,b,c,d\n");
        for k in 0..n_rows {
            let c = (k % n_rows).min(n_rows - k);
            let b = if k > n_rows / 2 { k % 5 } else { 0 };
            content += &format!("{},{b},{c},{}\n", k * 2, k % 3);
        }
        let folder = Folder::with(&[("run.csv", &content)]);
        let path = folder.path("run.csv");
        let known = inspect::Known::Nothing;
        let found = inspect::inspect(&path, known, &Progress::default()).unwrap();
        found.table.columns.iter().map(|column| column.is).collect()
    };
    let (time, gauge) = (ColumnRole::Time, ColumnRole::Gauge);
    for n_rows in [10, 600, 3_000, 200_000] {
        assert_eq!(roles(n_rows), [time, gauge, gauge, gauge], "{n_rows}");
    }
}

fn read_text(text: &str) -> Result<Loaded, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::write(&path, text).unwrap();
    read(&path, None, &[], &Progress::default())
}

/// Numbers of a thousand or more occur late in the file, in US, German and Swiss format, with and without decimals.
#[test]
fn separators_of_thousands_are_found_late_in_the_file() {
    for (head, small, large, delimiter) in [
        ("t,S1,Fz [N]", "9.5", "\"1,262.21\"", ","),
        ("t,S1,Fz [N]", "9.5", "\"1,262\"", ","),
        ("t;S1;Fz [N]", "9,5", "1.262,21", ";"),
        ("t;S1;Fz [N]", "9.5", "1'262.21", ";"),
        ("t;S1;Fz [N]", "9,5", "1\u{a0}262,21", ";"),
    ] {
        let row = |k: usize| {
            let load = if k < 400 { small } else { large };
            format!("{k}{delimiter}{}{delimiter}{load}\n", k % 7)
        };
        let text = format!("{head}\n{}", (0..600).map(row).collect::<String>());
        let loaded = read_text(&text).unwrap();
        let recording = &loaded.recordings[0];
        assert_eq!((loaded.recordings.len(), recording.n_samples()), (1, 600), "{large}");
        let expected = if large.contains("21") { 1262.21 } else { 1262.0 };
        assert_eq!((recording.loads()[0], recording.loads()[599]), (9.5, expected), "{large}");
    }
}

#[test]
fn more_than_a_tenth_of_skipped_rows_is_an_error_that_asks_for_a_map() {
    let text = |n_bad: usize| {
        let row = |k: usize| format!("{k},{},{}\n", k % 7, if k < n_bad { "1.2.3" } else { "4" });
        format!("t,S1,Fz [N]\n{}", (0..200).map(row).collect::<String>())
    };
    let error = read_text(&text(30)).unwrap_err();
    let messages = error.to_string();
    assert!(
        error.wants_a_map() && messages.contains("30 of 200 rows") && messages.contains("1.2.3"),
        "{messages}"
    );
    assert_eq!(read_text(&text(15)).unwrap().recordings[0].n_samples(), 185);
}

#[test]
fn a_single_load_without_an_axis_is_read_as_fz() {
    for name in [
        "Force [N]",
        "Kraft [N]",
        "Load cell Z [N]",
        "F_ref [N]",
        "fz_true",
        "load_kg",
        "Reference force",
    ] {
        let rows: String = (0..30).map(|k| format!("{k},{},{}\n", k % 7, k % 5)).collect();
        let loaded = read_text(&format!("t,S1,{name}\n{rows}")).unwrap();
        assert_eq!(loaded.recordings[0].axes(), [Axis::Fz], "{name}");
    }
    let rows: String = (0..30).map(|k| format!("{k},{},{}\n", k % 7, k % 5)).collect();
    for name in ["Fx in kN", "Force_X in kN"] {
        let loaded = read_text(&format!("t,S1,{name}\n{rows}")).unwrap();
        let recording = &loaded.recordings[0];
        assert_eq!((recording.axes(), recording.loads()[1]), (&[Axis::Fx][..], 1000.0), "{name}");
        assert!(loaded.warnings.is_empty());
    }
    // Gauges and temperatures are not affected.
    let loaded = read_text(&format!("t,S1,load cell [mV/V]\n{rows}")).unwrap();
    assert_eq!(loaded.recordings[0].n_gauges(), 2);
}
