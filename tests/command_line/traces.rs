//! `--traces`, which writes the traces of the window as a table.

use crate::program::{fit, numbers, run, stderr, succeed};
use crate::table::Table;
use crate::workshop::{ALL_FILES, Workshop};

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
