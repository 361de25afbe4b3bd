//! The tables of a report: what it is about, how good it is, what it was made of, and the matrices.

use super::markup::{Cell, Markup};
use super::{ReportData, ReportRecording, date};
use crate::calibration::{Calibration, Learned, LinearMap};
use crate::evaluation::metrics::percent_change;
use crate::evaluation::numbers::significant;
use crate::evaluation::threshold_study::ScoreSet;
use crate::features::Distance;
use crate::recording::{Axis, Role};

/// A longer matrix is told of only in part: nobody reads it, and the complete calibration has it.
const MOST_FEATURES: usize = 400;

pub(super) fn head(report: &ReportData, page: &mut Markup) {
    let calibration = &report.calibration;
    page.element("h1", "Calibration report");
    let kind = match report.fitted {
        true => "fitted to",
        false => "applied to",
    };
    let count = |role: Role| {
        let roles = report.recordings.iter();
        let roles = roles.map(|recording| recording.used.role);
        roles.filter(|own| *own == role).count()
    };
    let (train, test) = (count(Role::Train), count(Role::Test));
    page.raw("<p class=\"about\">");
    page.text(&format!(
        "LoopScope {}, {}. The calibration was made by {} and {kind} {} recordings, {train} of them to train on and {test} to \
         test on. Their files stand at the end.",
        env!("CARGO_PKG_VERSION"),
        date::utc(report.made),
        calibration.program,
        report.recordings.len(),
    ));
    page.raw("</p>");
}

/// Each paragraph of the notes as one.
pub(super) fn notes(report: &ReportData, page: &mut Markup) {
    let lines = report.notes.lines().map(str::trim);
    let lines: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
    if lines.is_empty() {
        return;
    }
    page.section("notes", "", "Notes", |page| {
        for line in lines {
            page.element("p", line);
        }
    });
}

pub(super) fn warnings(report: &ReportData, page: &mut Markup) {
    page.section("warnings", "", "Warnings", |page| {
        if report.warnings.is_empty() {
            page.element("p", "None.");
            return;
        }
        page.within("div", "class=\"warnings\"", |page| {
            page.within("ul", "", |page| {
                for warning in &report.warnings {
                    page.element("li", warning);
                }
            });
        });
    });
}

/// Sets of errors with their names, the most telling first.
const SETS: [(ScoreSet, &str); 3] = [
    (ScoreSet::Test, "Test"),
    (ScoreSet::LeftOut, "Leave-one-out"),
    (ScoreSet::Train, "Train"),
];

pub(super) fn scores(report: &ReportData, page: &mut Markup) {
    let calibration = &report.calibration;
    let quality = &calibration.quality;
    page.section("scores", "", "Errors", |page| {
        page.element(
            "p",
             "Root mean squared error per axis. Calc.: the true load; Conv.: from the present gauges alone; Comp.: with what the \
             past adds. Test: on recordings that the fit never saw. Leave-one-out: on each training recording by a fit to the \
             others. Train: on what was fitted, which flatters.",
        );
        let mut head = vec![Cell::text("Set"), Cell::text("Axis")];
        head.extend(["Conv.", "Comp.", "change", "Conv. % FS", "Comp. % FS"].map(|name| {
            Cell::Number(name.to_owned())
        }));
        if report.factory.is_some() {
            head.push(Cell::Number("Factory".to_owned()));
        }
        let n_numbers = head.len() - 1;
        let mut rows = Vec::new();
        for (set, name) in SETS {
            let (Some(before), Some(after)) = (set.rmse(&quality.conventional), set.rmse(&quality.compensated))
            else {
                rows.push(vec![
                    Cell::text(name),
                    Cell::Reason(missing(set, calibration), n_numbers),
                ]);
                continue;
            };
            for (at, axis) in calibration.axes.iter().enumerate() {
                let full_scale = calibration.full_scale[at];
                let percent = |rmse: f64| {
                    (full_scale > 0.0).then(|| significant(100.0 * rmse / full_scale, 3))
                };
                let name = if at == 0 { name } else { "" };
                let mut row = vec![
                    Cell::text(name),
                    Cell::text(labelled(*axis)),
                    Cell::Number(significant(before[at], 4)),
                    Cell::Number(significant(after[at], 4)),
                    Cell::number(change(before[at], after[at])),
                    Cell::number(percent(before[at])),
                    Cell::number(percent(after[at])),
                ];
                row.extend(report.factory.as_ref().map(|factory| {
                    let rmse = set.factory_rmse(factory).get(at).copied().flatten();
                    Cell::number(rmse.map(|rmse| significant(rmse, 4)))
                }));
                rows.push(row);
            }
        }
        page.table(&head, rows);
        if let Some(factory) = &report.factory {
            let added = (calibration.axes.iter().zip(&factory.offsets))
                .filter_map(|(axis, offset)| {
                    let offset = offset.filter(|offset| *offset != 0.0)?;
                    Some(format!("{} {} {}", axis.symbol(), significant(offset, 3), axis.unit()))
                })
                .collect::<Vec<_>>();
            page.element("p", "Factory: the calibration that the sensor came with, on the same gauges.");
            if !added.is_empty() {
                let words = "For want of a tare, its mean error over the training recordings was taken away: ";
                page.element("p", &format!("{words}{}.", added.join(", ")));
            }
        }
    });
}

fn missing(set: ScoreSet, calibration: &Calibration) -> String {
    match set {
        ScoreSet::LeftOut => calibration
            .why_not_left_out()
            .unwrap_or("nothing was left out")
            .to_owned(),
        ScoreSet::Test => "no recording is in the test role".to_owned(),
        ScoreSet::Train => "no recording is in the train role".to_owned(),
    }
}

fn labelled(axis: Axis) -> String {
    format!("{} [{}]", axis.symbol(), axis.unit())
}

pub(super) fn change(before: f64, after: f64) -> Option<String> {
    percent_change(before, after).map(|percent| format!("{percent:+.1} %"))
}

pub(super) fn recordings(report: &ReportData, page: &mut Markup) {
    page.section("recordings", "page", "Recordings", |page| {
        let mut head = vec![Cell::text("Name"), Cell::text("Role")];
        head.extend(
            ["Samples", "Duration [s]", "Rate [Hz]"].map(|name| Cell::Number(name.to_owned())),
        );
        head.extend([Cell::text("File"), Cell::text("SHA-256 of the file")]);
        page.table(&head, report.recordings.iter().map(recording_row));
        let mut head = vec![Cell::text("RMSE, Conv. → Comp.")];
        let axes = report.calibration.axes.iter();
        head.extend(axes.map(|axis| Cell::Number(labelled(*axis))));
        let rows = report
            .recordings
            .iter()
            .map(|recording| rmse_row(recording, head.len() - 1));
        page.table(&head, rows.collect::<Vec<_>>());
    });
}

fn recording_row(recording: &ReportRecording) -> Vec<Cell> {
    let used = &recording.used;
    let role = match used.role {
        Role::Train => "train",
        Role::Test => "test",
        Role::Off => "off",
    };
    let (file, hash) = match (&used.file, &used.sha256) {
        (None, _) => ("built-in simulated sensor", Cell::text("–")),
        (Some(file), Some(hash)) => (&**file, Cell::Hash(hash.clone())),
        (Some(file), None) => (&**file, Cell::text("the file could not be read again")),
    };
    vec![
        Cell::text(&used.name),
        Cell::text(role),
        Cell::Number(recording.n_samples.to_string()),
        Cell::Number(significant(recording.duration_secs, 5)),
        Cell::number(recording.rate_hz.map(|rate| significant(rate, 4))),
        Cell::text(file),
        hash,
    ]
}

fn rmse_row(recording: &ReportRecording, n_axes: usize) -> Vec<Cell> {
    let mut row = vec![Cell::text(&recording.used.name)];
    match (&recording.conventional_rmse, &recording.compensated_rmse) {
        (Some(before), Some(after)) => {
            row.extend(before.iter().zip(after).map(|(before, after)| {
                Cell::Number(format!(
                    "{} → {}",
                    significant(*before, 3),
                    significant(*after, 3)
                ))
            }))
        }
        _ => row.push(Cell::Reason("no reference load".to_owned(), n_axes)),
    }
    row
}

pub(super) fn settings(report: &ReportData, page: &mut Markup) {
    page.section("settings", "", "Settings", |page| {
        let head = [Cell::text("Setting"), Cell::text("Value")];
        let rows = setting_rows(&report.calibration).into_iter();
        page.table(
            &head,
            rows.map(|(name, value)| vec![Cell::text(name), Cell::text(value)]),
        );
    });
}

fn setting_rows(calibration: &Calibration) -> Vec<(&'static str, String)> {
    let features = &calibration.features;
    let quality = &calibration.quality;
    let list = |values: &[f64], unit: &str| match values {
        [] => "none".to_owned(),
        values => {
            let texts: Vec<String> = values.iter().map(f64::to_string).collect();
            format!("{} {unit}", texts.join(", "))
        }
    };
    let look_backs: Vec<String> = (features.look_backs.iter())
        .map(|thresholds| match features.distance {
            Distance::Force => format!(
                "F_th {} N, t_th {} s",
                thresholds.f_th, thresholds.t_th_secs
            ),
            Distance::FullScale => format!(
                "F_th {} % of full scale, t_th {} s",
                100.0 * thresholds.f_th,
                thresholds.t_th_secs
            ),
        })
        .collect();
    let per_axis = |values: &[f64]| -> String {
        let axes = calibration.axes.iter().zip(values);
        let texts = axes.map(|(axis, value)| format!("{} {value}", axis.symbol()));
        texts.collect::<Vec<_>>().join(", ")
    };
    let ridge = match quality.ridge.iter().any(|strength| *strength > 0.0) {
        true => per_axis(&quality.ridge),
        false => "none".to_owned(),
    };
    let full_scale: Vec<String> = (calibration.axes.iter().zip(&calibration.full_scale))
        .map(|(axis, full)| {
            format!(
                "{} {} {}",
                axis.symbol(),
                significant(*full, 5),
                axis.unit()
            )
        })
        .collect();
    let condition = quality.condition;
    vec![
        ("Regressor", regressor(calibration)),
        (
            "Look-back",
            match look_backs.is_empty() {
                true => "none".to_owned(),
                false => look_backs.join("; "),
            },
        ),
        (
            "F_th is measured over",
            match features.distance {
                Distance::Force => "the force axes, in newtons",
                Distance::FullScale => "all axes, each divided by its full scale",
            }
            .to_owned(),
        ),
        ("Fixed lags", list(&features.fixed_lags_secs, "s")),
        ("Creep time constants", list(&features.creep_secs, "s")),
        (
            "Play radii",
            list(&features.play_radii, "standard deviations"),
        ),
        (
            "Polynomial",
            match features.polynomial {
                2 => "squares and products",
                3 => "squares, products and cubes",
                _ => "none",
            }
            .to_owned(),
        ),
        ("Ridge", ridge),
        (
            "Offset",
            match calibration.offset {
                true => "in the model",
                false => "none",
            }
            .to_owned(),
        ),
        (
            "Samples",
            format!(
                "{} fitted (one of every {}), {} tested",
                quality.n_train, calibration.decimation, quality.n_test
            ),
        ),
        ("Full scale", full_scale.join(", ")),
        ("Gauges", calibration.gauges.join(", ")),
        (
            "Rank and condition number",
            format!(
                "{} of {} features, {}",
                quality.rank,
                calibration.feature_names().len(),
                condition.map_or_else(|| "none".to_owned(), |number| significant(number, 4))
            ),
        ),
    ]
}

fn regressor(calibration: &Calibration) -> String {
    let label = calibration.regressor.label();
    match &calibration.learned {
        None => label.to_owned(),
        Some(Learned::Network(network)) => {
            format!("{label}, {} weights", network.n_parameters())
        }
        Some(Learned::Kernel(kernel)) => format!("{label}, {} landmarks", kernel.landmarks.len()),
    }
}

pub(super) fn matrices(report: &ReportData, page: &mut Markup) {
    let calibration = &report.calibration;
    page.section("matrices", "page", "Calibration matrices", |page| {
        page.element(
            "p",
            "The load is the sum over the features, each times its number. Forces in N, moments in N·m, gauges in the unit of \
             the recordings.",
        );
        matrix("Conventional (Conv.)", &calibration.conventional, calibration, page);
        if let Some(map) = &calibration.compensated {
            matrix("Compensated (Comp.)", map, calibration, page);
        }
        if calibration.learned.is_some() {
            page.element(
                "p",
                "What the network or kernel adds to it is in the complete calibration (JSON) alone.",
            );
        }
    });
}

fn matrix(title: &str, map: &LinearMap, calibration: &Calibration, page: &mut Markup) {
    page.element("h3", title);
    let mut head = vec![Cell::text("Feature")];
    head.extend(
        calibration
            .axes
            .iter()
            .map(|axis| Cell::Number(labelled(*axis))),
    );
    let features = map.names(&calibration.gauges);
    let features = features.iter().enumerate().take(MOST_FEATURES);
    let rows = features.map(|(column, feature)| {
        let mut row = vec![Cell::text(feature)];
        row.extend(
            map.matrix
                .iter()
                .map(|numbers| Cell::Number(significant(numbers[column], 7))),
        );
        row
    });
    page.table(&head, rows);
    if map.columns.len() > MOST_FEATURES {
        let more = map.columns.len() - MOST_FEATURES;
        page.element(
            "p",
            &format!("and {more} more, which the complete calibration (JSON) has."),
        );
    }
}
