//! `--traces`, which writes the traces of the window as a table.

use crate::program::{fit, numbers, run, stderr, succeed};
use crate::table::Table;
use crate::workshop::{ALL_FILES, HEADER, Workshop, rows};

fn rms(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (squares / values.len() as f64).sqrt()
}

/// The RMSE of the test rows in the table equals the test RMSE of the fit.
#[test]
fn traces_have_the_errors_that_the_fit_reported() {
    let workshop = Workshop::with_recordings();
    let arguments = [&ALL_FILES[..], &["--decimate", "2", "--traces", "t.csv"]].concat();
    let report = fit(workshop.path(), &arguments);
    let text = workshop.read("t.csv");
    let numbers_alone = text.lines().map(|line| line.split_once(',').unwrap().1);
    workshop.write("n.csv", numbers_alone.collect::<Vec<_>>().join("\n"));
    let table = Table::read(&workshop.file("n.csv"));
    assert_eq!(table.column("t").len(), 4 * 75);
    let is_test: Vec<bool> = text.lines().skip(1).map(|line| line.starts_with("test,")).collect();
    for (column, kind) in
        [("Fz uncompensated error", "conventional"), ("Fz compensated error", "compensated")]
    {
        let errors = table.column(column);
        let of_test = errors.iter().zip(&is_test).filter(|(_, is_test)| **is_test);
        let of_test: Vec<f64> = of_test.map(|(error, _)| *error).collect();
        assert_eq!(of_test.len(), 75);
        let reported = numbers(&report[kind]["test_rmse"])[0];
        assert!((rms(&of_test) - reported).abs() < 1e-9 * reported, "{column}");
    }
    let (calc, comp, error) = (
        table.column("Fz reference"),
        table.column("Fz compensated"),
        table.column("Fz compensated error"),
    );
    assert!((0..300).all(|k| error[k] == comp[k] - calc[k]));
}

/// A file with a pause is read as two recordings. The state of the play is kept through the pause, as on a robot.
#[test]
fn traces_of_a_file_with_a_pause_are_the_loads_that_apply_writes() {
    let workshop = Workshop::with_recordings();
    let paused = [HEADER, &rows(3.0, 70, 0.0), &rows(4.0, 50, 12.0)].concat();
    workshop.write("paused.csv", paused);
    let play = &["fit", "--look-back", "none", "--play", "0.2,0.4", "--export", "c.json"];
    succeed(workshop.path(), &[&play[..], &ALL_FILES[..]].concat());
    let compensated = |keep_secs: &str| {
        let file: serde_json::Value = serde_json::from_str(&workshop.read("c.json")).unwrap();
        let mut file = file.as_object().unwrap().clone();
        file.insert("keep_secs".to_owned(), serde_json::from_str(keep_secs).unwrap());
        workshop.write("k.json", serde_json::to_string(&file).unwrap());
        let both = ["apply", "k.json", "paused.csv", "--out", "."];
        succeed(workshop.path(), &[&both[..], &["--traces", "t.csv", "--force"]].concat());
        let text = workshop.read("t.csv");
        let head = text.lines().next().unwrap().split(',');
        let at = head.clone().position(|head| head.contains("Fz compensated [")).unwrap();
        let cells = text.lines().skip(1).map(|line| line.split(',').nth(at).unwrap().parse());
        let traces: Vec<f64> = cells.map(Result::unwrap).collect();
        let loads = Table::read(&workshop.file("paused_loads.csv")).column("Fz compensated");
        assert_eq!((traces.len(), &traces), (120, &loads));
        traces
    };
    let (forgotten, kept) = (compensated("{}"), compensated(r#"{"play_radii": 100}"#));
    assert_eq!(forgotten[..70], kept[..70]);
    assert_ne!(forgotten[70], kept[70]);
}

#[test]
fn recordings_without_a_reference_leave_its_cells_empty() {
    let workshop = Workshop::with_recordings();
    let make = [&["fit", "--export", "c.json"], &ALL_FILES[..]].concat();
    succeed(workshop.path(), &make);
    workshop.write("bare.csv", "t [s],S1,S2\n0,40,1\n0.1,41,2\n");
    succeed(workshop.path(), &["apply", "c.json", "bare.csv", "a.csv", "--traces", "t.csv"]);
    let text = workshop.read("t.csv");
    let cells: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
    assert_eq!(cells[..3], ["bare", "0", ""]);
    assert_eq!(cells.iter().filter(|cell| cell.is_empty()).count(), 3);
    succeed(workshop.path(), &["apply", "c.json", "bare.csv", "--traces", "u.csv"]);
    assert_eq!(
        workshop.read("u.csv").lines().next().unwrap(),
        "recording,t [s],Fz uncompensated [N],Fz compensated [N]"
    );
}

#[test]
fn impossible_traces_are_refused_with_a_correction() {
    let workshop = Workshop::with_recordings();
    for (more, word) in [
        (&["--traces", "t.txt"][..], "use .csv"),
        (&["--traces", "a.csv", "--force"], "replace the input"),
        (&["--traces", "gone/t.csv"], "no folder"),
    ] {
        let output = run(workshop.path(), &[&["fit"], &ALL_FILES[..], more].concat());
        assert!(
            !output.status.success() && stderr(&output).contains(word),
            "{more:?}: {}",
            stderr(&output)
        );
        assert!(!workshop.file("t.csv").exists());
    }
    workshop.write("t.csv", "mine");
    let output = run(workshop.path(), &[&["fit"], &ALL_FILES[..], &["--traces", "t.csv"]].concat());
    assert!(stderr(&output).contains("--force") && workshop.read("t.csv") == "mine");
}
