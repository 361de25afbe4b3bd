//! `apply`, which computes the loads of recordings by a calibration file.

use std::fs::{self, OpenOptions};
use std::io::{BufRead as _, BufReader, Write as _};

use crate::program::{fit, numbers, program as command, run, stderr, succeed};
use crate::table::Table;
use crate::workshop::{ALL_FILES, HEADER, Workshop, rows};

fn rmse(predicted: &[f64], truth: &[f64]) -> f64 {
    let errors = predicted.iter().zip(truth).map(|(a, b)| (a - b).powi(2));
    (errors.sum::<f64>() / truth.len() as f64).sqrt()
}

/// Runs `fit` on the files of the workshop with the arguments `change`, and writes `c.json`. Returns the printed JSON.
fn calibrate(workshop: &Workshop, change: &[&str]) -> serde_json::Value {
    let arguments = [&ALL_FILES[..], &["--export", "c.json"], change].concat();
    fit(workshop.path(), &arguments)
}

fn apply(workshop: &Workshop, file: &str) -> Table {
    succeed(workshop.path(), &["apply", "c.json", file, "--out", "."]);
    Table::read(&workshop.file(&file.replace(".csv", "_loads.csv")))
}

#[test]
fn applied_loads_have_the_errors_that_the_fit_reported() {
    for change in [&[][..], &["--no-offset"], &["--distance", "full-scale", "--f-th", "0.2"]] {
        let workshop = Workshop::with_recordings();
        let paused = [HEADER, &rows(3.0, 90, 7.0), &rows(4.0, 60, 300.0)].concat();
        workshop.write("test.csv", paused);
        let report = calibrate(&workshop, change);
        let loads = apply(&workshop, "test.csv");
        let truth = loads.column("Fz reference");
        for (column, calibration) in
            [("Fz uncompensated", "conventional"), ("Fz compensated", "compensated")]
        {
            let reported = numbers(&report[calibration]["test_rmse"])[0];
            let found = rmse(&loads.column(column), &truth);
            assert!((found / reported - 1.0).abs() < 1e-9, "{change:?} {column}");
        }
        assert_ne!(loads.column("Fz uncompensated"), loads.column("Fz compensated"));
    }
}

#[test]
fn each_input_row_gives_one_output_row() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let paused = [HEADER, &rows(3.0, 70, 0.0), &rows(4.0, 50, 99.0)].concat();
    workshop.write("paused.csv", paused);
    let given = Table::read(&workshop.file("paused.csv"));
    let loads = apply(&workshop, "paused.csv");
    assert_eq!(loads.column("t [s]"), given.column("t [s]"));
    assert_eq!(loads.column("Fz reference"), given.column("Fz"));
}

#[test]
fn a_recording_without_reference_gets_loads_too() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    workshop.write("bare.csv", "t [s],S1,S2\n0,40,0\n0.1,41,0.1\n");
    let loads = apply(&workshop, "bare.csv");
    assert_eq!(loads.header, ["t [s]", "Fz uncompensated [N]", "Fz compensated [N]"]);
    assert_eq!(loads.rows.len(), 2);
}

#[test]
fn several_files_are_written_to_a_new_folder() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let arguments = ["apply", "c.json", "a.csv", "b.csv", "--out", "new/loads"];
    let output = succeed(workshop.path(), &arguments);
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 2);
    for name in ["new/loads/a_loads.csv", "new/loads/b_loads.csv"] {
        assert_eq!(Table::read(&workshop.file(name)).rows.len(), 150);
    }
}

/// The zeros of the gauges change between two days. Only a tare removes the change from the loads.
#[test]
fn a_tared_calibration_warns_about_recordings_without_tare() {
    let workshop = Workshop::with_recordings();
    workshop.write("today.csv", shifted(workshop.read("a.csv")));
    let tare = ["--tare", "0:0.5"];
    let made = [
        &["fit", "--train", "a.csv", "b.csv", "--export", "cal.json", "--export", "cal.yaml"],
        &tare[..],
    ]
    .concat();
    succeed(workshop.path(), &made);
    assert!(workshop.read("cal.json").contains("\"interval\""));
    assert!(workshop.read("cal.yaml").contains("0 s to 0.5 s of each recording"));
    let apply = |out: &str, file: &str, more: &[&str]| {
        let arguments = [&["apply", "cal.json", file, "--out", out], more].concat();
        succeed(workshop.path(), &arguments)
    };
    apply("before", "a.csv", &tare);
    apply("after", "today.csv", &tare);
    let loads = |path: &str| -> Vec<f64> {
        let text = workshop.read(path);
        let rows = text.lines().skip_while(|line| !line.starts_with(char::is_numeric));
        rows.flat_map(|row| {
            row.split(',').filter_map(|cell| cell.parse().ok()).collect::<Vec<f64>>()
        })
        .collect()
    };
    let (before, after) = (loads("before/a_loads.csv"), loads("after/today_loads.csv"));
    assert!(!before.is_empty() && before.len() == after.len());
    for (before, after) in before.iter().zip(&after) {
        assert!((before - after).abs() < 1e-5, "{before} became {after}");
    }
    let warning = stderr(&apply("raw", "today.csv", &[]));
    assert!(
        warning.contains("not tared, but the calibration was fitted to gauges minus"),
        "{warning}"
    );
}

/// Returns the text of a recording with its first gauge shifted by 5.
fn shifted(text: String) -> String {
    let mut lines = text.lines();
    let header = lines.next().unwrap().to_owned();
    let shift = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        cells[1] = (cells[1].parse::<f64>().unwrap() + 5.0).to_string();
        cells.join(",")
    };
    let lines = [header].into_iter().chain(lines.map(shift));
    lines.collect::<Vec<_>>().join("\n")
}

/// The gauges are shifted after the calibration. A tare removes the shift, in files and in live rows.
#[test]
fn a_tare_removes_a_shift_for_tared_and_untared_calibrations() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    workshop.write("today.csv", shifted(workshop.read("a.csv")));
    let loads = |text: &str| -> Vec<(f64, f64)> {
        let rows = text.lines().skip(1).map(|row| row.split(','));
        let number = |cell: Option<&str>| cell.and_then(|cell| cell.parse().ok());
        rows.map(|mut row| (number(row.next()).unwrap(), number(row.nth(1)).unwrap_or(f64::NAN)))
            .collect()
    };
    let apply = |out: &str, file: &str| {
        let arguments = ["apply", "c.json", file, "--out", out, "--tare", "0:0.2"];
        succeed(workshop.path(), &arguments);
        loads(&workshop.read(&format!("{out}/{}_loads.csv", file.trim_end_matches(".csv"))))
    };
    let (before, after) = (apply("before", "a.csv"), apply("after", "today.csv"));
    assert!(before.len() > 20 && before.len() == after.len());
    let first: Vec<f64> = (after.iter().take_while(|(time, _)| time - after[0].0 <= 0.2))
        .map(|(_, load)| *load)
        .collect();
    let mean = first.iter().sum::<f64>() / first.len() as f64;
    assert!(mean.abs() < 1e-6, "{mean} N without load");
    let answered =
        fed(&workshop, &["apply", "c.json", "-", "--tare", "0:0.2"], &workshop.read("today.csv"));
    let taring = answered.lines().filter(|line| line.ends_with(",taring"));
    assert_eq!(taring.count(), first.len());
    for ((before, after), live) in before.iter().zip(&after).zip(loads(&answered)) {
        assert!((before.1 - after.1).abs() < 1e-5, "{before:?} {after:?}");
        let is_same = (live.1 - after.1).abs() < 1e-9 || live.1.is_nan();
        assert!(live.0 == after.0 && is_same, "{live:?} {after:?}");
    }
    assert!(!loads(&answered).last().unwrap().1.is_nan());
}

/// The sample that is beyond the tested range is also the first after a gap.
#[test]
fn a_rejected_row_keeps_its_time_and_statuses_are_joined() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let late = "30.5,9e4,9e4,0\n";
    let text = [HEADER, &rows(3.0, 5, 0.0), "4,oops,1,2\n", late].concat();
    let answered = fed(&workshop, &["apply", "c.json", "-"], &text);
    let last: Vec<&str> = answered.lines().skip(6).collect();
    assert_eq!(last[0], "4,,,,rejected: value");
    assert!(last[1].ends_with(",beyond+after a gap"), "{}", last[1]);
}

/// A file, standard input and a growing file give the same loads, sample by sample.
#[test]
fn samples_are_answered_as_they_come() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let broken = "x,y\n";
    let text =
        [HEADER, &rows(3.0, 70, 0.0), broken, &rows(4.0, 50, 99.0), &rows(5.0, 20, 3.0)].concat();
    workshop.write("run.csv", &text);
    let out = ["apply", "c.json", "run.csv", "--out", ".", "--status"];
    succeed(workshop.path(), &out);
    let whole = workshop.read("run_loads.csv");
    let status = |line: &str| line.rsplit(',').next().unwrap().to_owned();
    let statuses: Vec<String> = whole.lines().skip(1).map(status).collect();
    assert_eq!(statuses.len(), 140);
    assert_eq!((&*statuses[0], &*statuses[70]), ("filling", "after a gap"));
    assert_eq!(statuses[120..123], ["rejected: time", "rejected: time", "restarted"]);
    let answered = fed(&workshop, &["apply", "c.json", "-"], &text);
    let (rejected, answers): (Vec<&str>, Vec<&str>) =
        answered.lines().partition(|line| line.starts_with(",,"));
    assert_eq!(rejected, [",,,,rejected: value"]);
    assert_eq!(answers, whole.lines().collect::<Vec<_>>());
    let json: String = (text.lines().skip(1).filter(|line| *line != "x,y"))
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            format!(
                "{{\"t\": {}, \"S1\": {}, \"S2\": {}, \"Fz\": {}}}\n",
                cells[0], cells[1], cells[2], cells[3]
            )
        })
        .collect();
    assert_eq!(fed(&workshop, &["apply", "c.json", "-"], &json), whole);
    for wrong in [
        &["apply", "c.json", "-", "run.csv"][..],
        &["apply", "c.json", "-", "--out", "."],
        &["apply", "c.json", "-", "--tare", "auto"],
        &["apply", "c.json", "run.csv"],
    ] {
        assert_eq!(run(workshop.path(), wrong).status.code(), Some(2), "{wrong:?}");
    }
}

/// Each row is answered before the next row is written.
#[test]
fn a_file_that_grows_is_followed() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let lines: Vec<String> = rows(3.0, 30, 0.0).lines().map(|line| format!("{line}\n")).collect();
    workshop.write("log.csv", [HEADER, &lines[0]].concat());
    let mut program = command(workshop.path(), &["apply", "c.json", "log.csv", "--follow"])
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut answers = BufReader::new(program.stdout.take().unwrap()).lines();
    let mut next = || answers.next().unwrap().unwrap();
    assert!(next().starts_with("t [s],"));
    let mut log = OpenOptions::new().append(true).open(workshop.file("log.csv")).unwrap();
    for (k, line) in lines.iter().enumerate() {
        if k > 0 {
            log.write_all(line.as_bytes()).unwrap();
        }
        let time = line.split(',').next().unwrap();
        let answered = next();
        assert_eq!(answered.split(',').next().unwrap().parse::<f64>(), time.parse(), "{k}");
    }
    // The file is replaced.
    workshop.write("new.csv", [HEADER, &lines[0]].concat());
    fs::rename(workshop.file("new.csv"), workshop.file("log.csv")).unwrap();
    assert!(next().ends_with("filling"));
    program.kill().unwrap();
    program.wait().unwrap();
}

/// The same samples give the same loads in all formats of devices. Rows without a time use the given rate.
#[test]
fn rows_are_answered_as_devices_print_them() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let gauges: Vec<[f64; 2]> =
        (0..30).map(|k| [f64::from(k), 0.5 * f64::from(k * k % 7)]).collect();
    let print = |row: &dyn Fn(f64, [f64; 2]) -> String| -> String {
        gauges.iter().enumerate().map(|(k, own)| row(0.02 * k as f64, *own)).collect()
    };
    let loads = |text: &str, more: &[&str]| -> Vec<String> {
        let arguments = [&["apply", "c.json", "-"], more].concat();
        let answers = fed(&workshop, &arguments, text);
        let answers = answers.lines().skip(1).map(|row| row.split_once(',').unwrap().1.to_owned());
        answers.collect()
    };
    let table = ["t [s],S1,S2\n", &print(&|t, [a, b]| format!("{t},{a},{b}\n"))].concat();
    let expected = loads(&table, &[]);
    assert_eq!(expected.len(), gauges.len());
    let rate = ["--rate", "50"];
    let stamp = |t: f64| format!("12:00:{t:06.3} -> ");
    for (name, text, more) in [
        ("commas", print(&|_, [a, b]| format!("{a},{b}\n")), &rate[..]),
        ("blanks", print(&|_, [a, b]| format!("{a} {b}\r\n")), &rate),
        ("decimal commas", print(&|_, [a, b]| format!("{a};{b}\n").replace('.', ",")), &rate),
        ("tabs", print(&|_, [a, b]| format!("{a}\t{b}\n")), &rate),
        ("a time first", print(&|t, [a, b]| format!("{:.0} {a} {b}\n", 1e3 * t)), &[]),
        ("an arrow", print(&|t, [a, b]| format!("{}{a},{b}\n", stamp(t))), &[]),
        ("pairs", print(&|_, [a, b]| format!("S2:{b} S1: {a}\n")), &rate),
        ("pairs after an arrow", print(&|t, [a, b]| format!("{}S1:{a},S2:{b}\n", stamp(t))), &[]),
        ("json", print(&|_, [a, b]| format!("{{\"S2\": {b}, \"S1\": {a}}}\n")), &rate),
    ] {
        let answered = loads(&text, more);
        assert_eq!(answered, expected, "{name}");
    }
    let more = print(&|_, [a, b]| format!("{a},{b},{}\n", a * b));
    let numbers = ["--rows", "numbers", "--rate", "50"];
    assert_eq!(loads(&more, &numbers), expected, "further numbers are ignored");
    workshop.write("input", "1\n2\n3\n".repeat(9));
    let input = fs::File::open(workshop.file("input")).unwrap();
    let arguments = ["apply", "c.json", "-", "--rows", "numbers"];
    let output = command(workshop.path(), &arguments).stdin(input).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("S1, S2"), "{message}");
    let lines = "1,2\n2,3\n".repeat(6) + "foo\n2,3\n";
    let arguments = ["apply", "c.json", "-", "--json", "--rate", "50"];
    let broken = fed(&workshop, &arguments, &lines);
    assert!(broken.contains("\"why\":\"the line has 1 of the 2 values that"), "{broken}");
    let few: String = "1,2\n2,3\n".to_owned();
    assert_eq!(loads(&few, &rate).len(), 2, "fewer than ten lines");
    let clock = fed(&workshop, &["apply", "c.json", "-", "--rows", "numbers"], "1,2\n2,3\n3,4\n");
    let times: Vec<f64> = (clock.lines().skip(1))
        .map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect();
    assert!(times.len() == 3 && times.is_sorted_by(|a, b| a < b), "{times:?}");
}

/// A bad value is answered with its reason. The lines `tare` and `reset` are commands. Messages name the stream.
#[test]
fn rows_on_standard_input_are_an_instrument() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let text = [
        "t [s],S1,S2\n0,1,2\n0.02,1,oops\n0.04,1,2\ntare\n0.06,1,2\nreset\n0.08,2,3\n",
        "tare 0.02\n0.1,4,5\n0.12,4,5\n0.14,4,5\n",
    ]
    .concat();
    let answers = fed(&workshop, &["apply", "c.json", "-", "--json"], &text);
    let rows: Vec<serde_json::Value> =
        answers.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(rows.len(), 8);
    assert_eq!(rows[1]["t"], 0.02);
    assert_eq!(rows[1]["why"], "S2 is \"oops\"");
    let load = |row: &serde_json::Value| row["Fz_uncompensated"].as_f64().unwrap();
    assert!(load(&rows[3]).abs() < 1e-9 && load(&rows[7]).abs() < 1e-9, "{answers}");
    assert!(load(&rows[2]).abs() > 1e-3 && load(&rows[4]).abs() > 1e-3, "{answers}");
    assert_eq!(rows[5]["status"], "taring");
    assert!(rows[5]["Fz_compensated"].is_null());

    workshop.write("input", "left\nright\n".repeat(20));
    let input = fs::File::open(workshop.file("input")).unwrap();
    let output = command(workshop.path(), &["apply", "c.json", "-"]).stdin(input).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && error.contains("standard input"), "{error}");
    assert!(!error.contains("/tmp"), "{error}");
}

/// Rows with one number more than the calibration has gauges are read only if it is a time. The answer to the question is a
/// list of names.
#[test]
fn rows_with_a_number_too_many_are_asked_about() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let rows = |row: &dyn Fn(u32) -> String| -> String { (0..50).map(row).collect() };
    let gauges = |k: u32| format!("{},{}", 40.0 + f64::from(k), f64::from(k * k % 7));
    let table = rows(&|k| format!("{},{}\n", 0.1 * f64::from(k), gauges(k)));
    let expected = fed(&workshop, &["apply", "c.json", "-"], &["t [s],S1,S2\n", &table].concat());
    let loads = |text: &str| -> Vec<String> {
        text.lines().skip(1).map(|row| row.split_once(',').unwrap().1.to_owned()).collect()
    };
    for first in [0, 7] {
        let status = rows(&|k| format!("{first},{}\n", gauges(k)));
        let refused = rejected(&workshop, &["apply", "c.json", "-"], &status);
        assert_eq!((refused.0, &*refused.1), (1, ""));
        assert!(refused.2.contains("--rows \"x,S1,S2\""), "{}", refused.2);
        let named = ["apply", "c.json", "-", "--rows", "x,S1,S2", "--rate", "10"];
        assert_eq!(loads(&fed(&workshop, &named, &status)), loads(&expected));
    }
    for text in [
        table.clone(),
        rows(&|k| format!("{},{}\n", 100 * k, gauges(k))),
        rows(&|k| format!("{},{},{}\n", k / 10, k % 10 * 100_000_000, gauges(k))),
        rows(&|k| format!("[{} , {}]\r", 100 * k, gauges(k))),
    ] {
        assert_eq!(loads(&fed(&workshop, &["apply", "c.json", "-"], &text)), loads(&expected));
    }
}

/// The numbers of a row count whatever stands between them, with and without a given form. A line that might be read one
/// column off is asked about, and so are rows of several lines.
#[test]
fn numbers_are_found_between_any_text() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let print = |row: &dyn Fn(u32, f64, f64) -> String| -> String {
        let values = (0..50).map(|k| (k, 40.0 - 0.7 * f64::from(k * k % 9), f64::from(k * k % 7)));
        values.map(|(k, a, b)| row(k, a, b - 3.0)).collect()
    };
    let apply = |rows: &[&str], text: &str| {
        let arguments = [&["apply", "c.json", "-", "--rate", "10"], rows].concat();
        rejected(&workshop, &arguments, text)
    };
    let loads = |answer: &(i32, String, String)| -> Vec<String> {
        assert_eq!(answer.0, 0, "{}", answer.2);
        let rows = answer.1.lines().skip(1);
        rows.map(|row| row.split_once(',').unwrap().1.to_owned()).collect()
    };
    let expected = loads(&apply(&[], &print(&|_, a, b| format!("{a},{b}\n"))));
    assert_eq!(expected.len(), 50);
    let (numbers, names) = (&["--rows", "numbers"][..], &["--rows", "S1,S2"][..]);
    let log = print(&|k, _, _| format!("[  {k}.1] I (wifi): state: init, rssi: -{k}\n"));
    for (name, text) in [
        ("Robotiq", print(&|_, a, b| format!("( {a} , {b} )\n"))),
        ("brackets", print(&|_, a, b| format!("[{a} {b}]\n"))),
        ("lists", print(&|_, a, b| format!("[[{a}, {b}]]\n"))),
        ("angles", print(&|_, a, b| format!("<{a}|{b:e}>\n"))),
        ("names", print(&|_, a, b| format!("S1={a} S2={b}\n"))),
        ("units", print(&|_, a, b| format!("{a:7.3} mV/V, {b:7.3}mV/V\r\n"))),
        ("label", print(&|_, a, b| format!("Reading: {a} {b}\n"))),
        ("labels", print(&|_, a, b| format!("a0={a} a1={b}\n"))),
        ("carriage returns", print(&|_, a, b| format!("a0={a} a1={b}\r"))),
        (
            "an arrow",
            print(&|k, a, b| format!("12:00:{:04.1} -> x: {a}, y: {b}\n", 0.1 * f64::from(k))),
        ),
    ] {
        for rows in [&[][..], numbers, names] {
            assert_eq!(loads(&apply(rows, &text)), expected, "{name} {rows:?}");
        }
        let found = loads(&apply(&[], &[&*log, &text].concat()));
        assert_eq!(found[found.len() - 50..], expected, "{name} after a log");
        assert!(found[..found.len() - 50].iter().all(|row| row.ends_with(",rejected: value")));
    }
    // A clock is found among the numbers. A counter is none.
    let timed = print(&|k, a, b| format!("t={} a={a} b={b}\n", 100 * k));
    assert_eq!(loads(&apply(&[], &timed)), expected);
    assert_eq!(loads(&apply(&["--rows", "timed-numbers"], &timed)), expected);
    let counted = print(&|k, a, b| format!("n {} v {a} {b}\n", k + 7));
    assert_eq!(loads(&apply(&["--rows", "x,S1,S2"], &counted)), expected);
    let turned = print(&|_, a, b| format!("7 S2={b} S1={a}\n"));
    assert_eq!(loads(&apply(&["--rows", "x,S2,S1"], &turned)), expected);

    let pairs = |a: &str, b: &str| print(&|_, x, y| format!("{a}{x}\n{b}{y}\n"));
    for (name, text) in [
        ("a counter", counted),
        ("names in another order", turned),
        ("candump", print(&|_, _, _| "can0  123   [8]  11 22 33 44 55 66 77 88\n".to_owned())),
        ("short candump", print(&|_, _, _| "can0  123   [1]  11\n".to_owned())),
        ("a time of day", print(&|k, a, b| format!("12:00:{k:02} {a} {b}mV\n"))),
        ("a separate sign", print(&|_, a, b| format!("S = - {a}, - {b}\n"))),
        ("one pair in a line", pairs("S1: ", "S2: ")),
        ("one label in a line", pairs("a0: ", "a1: ")),
        ("Teleplot", pairs(">S1:", ">S2:")),
        ("a log", log),
        ("few rows", "a0=1 a1=2\n".repeat(9)),
    ] {
        for rows in [&[][..], numbers, names] {
            let (code, answered, message) = apply(rows, &text);
            assert_eq!((code, &*answered), (1, ""), "{name} {rows:?}");
            assert!(message.contains("--rows") && message.contains("S1, S2"), "{name} {message}");
        }
    }
    for fields in [pairs("data:\n- ", "- "), pairs("x: ", "y: "), pairs("S1: ", "S2: ")] {
        let echo = fields.lines().map(|line| format!("{line}\n---\n")).collect::<String>();
        for rows in [&[][..], numbers, names] {
            let (code, answered, message) = apply(rows, &echo);
            assert_eq!((code, &*answered), (1, ""), "{echo}");
            assert!(message.contains("--csv"), "{message}");
        }
    }
    let labels = print(&|_, a, b| format!("a0={a} a1={b}\n"));
    let others = "a1=1 a0=2\na0=1 a1=2 a2=3\na0=1 a1=nan\n1,2\n";
    let answered = loads(&apply(&[], &[&*labels, others].concat()));
    assert_eq!(answered[..50], expected);
    assert!(answered[50..].iter().all(|row| row.ends_with(",rejected: value")), "{answered:?}");
    assert_eq!(answered.len(), 54);
}

/// A header names the columns in any order, also after a long log. Without a header but with a given form, the log is
/// rejected.
#[test]
fn a_header_or_rows_after_a_long_log_are_found() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let log: String =
        (0..80).map(|k| format!("[  {k}.1] I (wifi): state: init, rssi: -{k}\n")).collect();
    let rows = "0,1,2\n100,3,5\n200,4,4\n";
    let apply = |text: &str| fed(&workshop, &["apply", "c.json", "-"], text);
    let expected = apply(&["t [ms],S1,S2\n", rows].concat());
    let turned = "t [ms],S2,S1\n0,2,1\n100,5,3\n200,4,4\n";
    assert_eq!(apply(&[&log, turned].concat()), expected);
    // The header of a logger that starts again in the middle of the rows.
    let twice = apply(&["t [ms],S1,S2\n", rows, "boot: 7\n", turned].concat());
    let answers: Vec<&str> = twice.lines().collect();
    assert_eq!(answers.len(), 8);
    assert_eq!(answers[5..], expected.lines().collect::<Vec<_>>()[1..]);

    let numbers = ["apply", "c.json", "-", "--rows", "numbers", "--rate", "10"];
    let answered = fed(&workshop, &numbers, &[&log, "1,2\n3,5\n4,4\n"].concat());
    let (rejected, answers): (Vec<&str>, Vec<&str>) =
        answered.lines().skip(1).partition(|line| line.ends_with(",rejected: value"));
    assert_eq!((rejected.len(), answers.len()), (80, 3));

    // The time for the first lines does not grow with the square of their length.
    let long = format!("# {}\n", "log ".repeat(2500)).repeat(190);
    let start = std::time::Instant::now();
    assert_eq!(apply(&[&long, "t [ms],S1,S2\n", rows].concat()), expected);
    assert!(start.elapsed().as_secs_f64() < 6.0, "{:?}", start.elapsed());
}

/// A tare works before the header, below it and between the rows, and a reset ends it. The answers to the rows need no
/// temporary folder.
#[test]
fn a_tare_works_wherever_it_stands() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let arguments = ["apply", "c.json", "-", "--status", "--json"];
    let loads = |text: &str| -> Vec<Option<f64>> {
        workshop.write("input", text);
        let input = fs::File::open(workshop.file("input")).unwrap();
        let mut program = command(workshop.path(), &arguments);
        let output = program.env("TMPDIR", "/nowhere").stdin(input).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        let answers = String::from_utf8(output.stdout).unwrap();
        let row = |line: &str| serde_json::from_str::<serde_json::Value>(line).unwrap();
        answers.lines().map(|line| row(line)["Fz_uncompensated"].as_f64()).collect()
    };
    let header = "t,S1,S2\n";
    let rows = |from: u32| -> String {
        (from..from + 6).map(|k| format!("{}.{},41,3\n", k / 10, k % 10)).collect()
    };
    let untared = loads(&[header, &rows(0)].concat());
    assert!(untared.iter().all(|load| load.unwrap().abs() > 1e-3), "{untared:?}");
    let is_zero = |load: &Option<f64>| load.is_some_and(|load| load.abs() < 1e-9);
    for text in [
        ["tare\n", header, &rows(0)].concat(),
        [header, "tare\n", &rows(0)].concat(),
        ["tare 0.05\n", header, &rows(0)].concat(),
    ] {
        let loads = loads(&text);
        assert_eq!(loads[0], None, "{text}");
        assert!(loads.len() == 6 && loads[1..].iter().all(is_zero), "{text} {loads:?}");
    }
    assert_eq!(loads(&[header, "tare 1000\n", &rows(0)].concat()), untared);
    let ended = loads(&[header, "tare 50\n", &rows(0), "reset\n", &rows(6)].concat());
    assert_eq!(ended, [vec![None; 6], untared].concat());
}

/// Returns the exit code, the standard output and the messages of the program with this input.
fn rejected(workshop: &Workshop, arguments: &[&str], text: &str) -> (i32, String, String) {
    workshop.write("input", text);
    let input = fs::File::open(workshop.file("input")).unwrap();
    let output = command(workshop.path(), arguments).stdin(input).output().unwrap();
    let message = stderr(&output);
    (output.status.code().unwrap(), String::from_utf8(output.stdout).unwrap(), message)
}

/// The source is a folder: on Linux, reading a folder fails in the same way as reading an unplugged serial port.
#[cfg(target_os = "linux")]
#[test]
fn a_source_that_ends_early_has_its_own_exit_code() {
    let workshop = Workshop::with_recordings();
    calibrate(&workshop, &[]);
    let input = fs::File::open(workshop.path()).unwrap();
    let output = command(workshop.path(), &["apply", "c.json", "-"]).stdin(input).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{message}");
    assert!(message.contains("standard input: the source ended"), "{message}");
}

fn fed(workshop: &Workshop, arguments: &[&str], text: &str) -> String {
    workshop.write("input", text);
    let input = fs::File::open(workshop.file("input")).unwrap();
    let output = command(workshop.path(), arguments).stdin(input).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}
