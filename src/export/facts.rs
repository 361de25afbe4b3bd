//! What every export says of itself: where it comes from, what it holds, what it leaves out, and how good it is.

use std::borrow::Cow;

use crate::calibration::{Calibration, Scores, UsedRecording};
use crate::evaluation::numbers::significant;
use crate::recording::Role;

/// More recordings than this are counted, not named.
const NAMED_RECORDINGS: usize = 40;

/// A name, unlike those of all other facts of a calibration, and a text.
pub(super) type Fact = (Cow<'static, str>, String);

/// Facts with their names, in the order in which they are told; texts as they are in the calibration, not escaped.
pub(super) fn facts(calibration: &Calibration, holds: &str, leaves_out: &str) -> Vec<Fact> {
    let units: Vec<String> = (calibration.axes.iter().zip(&calibration.units))
        .map(|(axis, unit)| format!("{} [{unit}]", axis.symbol()))
        .collect();
    let named = calibration.trained_on.len().min(NAMED_RECORDINGS);
    let mut recordings = calibration.trained_on[..named].join(", ");
    if calibration.trained_on.len() > named {
        let more = calibration.trained_on.len() - named;
        recordings.push_str(&format!(" and {more} more"));
    }
    let quality = &calibration.quality;
    let mut facts = vec![
        ("made by", calibration.program.clone()),
        (
            "written by",
            concat!("LoopScope ", env!("CARGO_PKG_VERSION")).to_owned(),
        ),
        ("holds", holds.to_owned()),
        ("leaves out", leaves_out.to_owned()),
        ("regressor", calibration.regressor.label().to_owned()),
        ("blocks", calibration.describe()),
        ("gauges", calibration.gauges.join(", ")),
        ("axes", units.join(", ")),
        ("full scale", numbers(&calibration.full_scale)),
        (
            "offset",
            match calibration.offset {
                true => "in the model",
                false => "none in the model",
            }
            .to_owned(),
        ),
        (
            "fitted",
            format!(
                "{} samples (one of every {}), {} tested",
                quality.n_train, calibration.decimation, quality.n_test
            ),
        ),
        ("trained on", recordings),
        (
            "recorded at",
            match calibration.rate_hz {
                Some(rate) => format!("{} Hz", significant(rate, 5)),
                None => "a rate that is not known".to_owned(),
            },
        ),
        ("RMSE conventional", scores(&quality.conventional)),
        ("RMSE compensated", scores(&quality.compensated)),
    ];
    if let Some(tare) = calibration.tare {
        let fact = format!("the gauges less their mean over {tare}; tare before use");
        facts.push(("tared", fact));
    }
    if calibration.simulated {
        facts.insert(
            0,
            (
                "warning",
                "made from the built-in simulated sensor, not from a real one".to_owned(),
            ),
        );
    }
    let facts = facts.into_iter().map(|(name, text)| (name.into(), text));
    facts.chain(source_files(&calibration.sources)).collect()
}

/// Each file by what it held, as far as they are named.
fn source_files(sources: &[UsedRecording]) -> Vec<Fact> {
    let files = sources.iter().enumerate().take(NAMED_RECORDINGS);
    let mut facts: Vec<Fact> = files
        .map(|(at, used)| {
            let role = match used.role {
                Role::Train => "train",
                Role::Test => "test",
                Role::Off => "off",
            };
            let file = used.file.as_deref().unwrap_or("no file");
            let hash = used.sha256.as_deref().unwrap_or("not known");
            let text = format!("{} ({role}): {file}, SHA-256 {hash}", used.name);
            (format!("source {}", at + 1).into(), text)
        })
        .collect();
    if sources.len() > NAMED_RECORDINGS {
        let more = sources.len() - NAMED_RECORDINGS;
        facts.push(("further sources".into(), more.to_string()));
    }
    facts
}

/// Errors per axis, held-out ones first: those are the ones to expect.
fn scores(scores: &Scores) -> String {
    let sets = [
        ("on test recordings", &scores.test_rmse),
        ("left out one by one", &scores.cv_rmse),
        ("on what was fitted", &scores.train_rmse),
    ];
    let told: Vec<String> = (sets.iter())
        .filter_map(|(name, rmse)| Some(format!("{name} {}", numbers(rmse.as_ref()?))))
        .collect();
    match told.is_empty() {
        true => "not known".to_owned(),
        false => told.join("; "),
    }
}

fn numbers(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| format!("{value:.6}")).collect();
    texts.join(" ")
}
