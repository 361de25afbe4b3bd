//! Facts that every exported file states: its origin and contents, the parts of the calibration that it leaves out, and the
//! errors of the calibration.

use std::borrow::Cow;

use crate::{
    calibration::{Calibration, Learned, Scores, UsedRecording},
    features::AuxiliaryChannel,
    scoring::numbers::significant,
    shown::{first, joined},
};

const NAMED_RECORDINGS: usize = 40;

/// Fact about an exported calibration: a unique name and a text.
pub(super) type Fact = (Cow<'static, str>, String);

/// Returns the facts in the order in which files state them, with the unescaped texts of the calibration.
pub(super) fn facts(calibration: &Calibration, holds: &str, leaves_out: &str) -> Vec<Fact> {
    let quality = &calibration.quality;
    let mut facts = vec![
        ("made by", calibration.program.clone()),
        ("written by", concat!("LoopScope ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("holds", holds.to_owned()),
        ("leaves out", leaves_out.to_owned()),
    ];
    let identity = calibration.identity.entered();
    facts.extend(identity.map(|(item, text)| (item.label(), text.to_owned())));
    facts.extend(settings_of(calibration));
    facts.extend([
        ("RMSE conventional", scores(&quality.conventional)),
        ("RMSE compensated", scores(&quality.compensated)),
    ]);
    if calibration.simulated {
        facts.insert(
            0,
            ("warning", "made from the built-in simulated sensor, not from a real one".to_owned()),
        );
    }
    facts
        .into_iter()
        .map(|(name, text)| (name.into(), text))
        .chain(source_files(&calibration.sources))
        .collect()
}

pub(crate) fn settings_of(calibration: &Calibration) -> Vec<(&'static str, String)> {
    let quality = &calibration.quality;
    let full_scale = calibration
        .axes
        .iter()
        .zip(&calibration.units)
        .zip(&calibration.full_scale)
        .enumerate()
        .map(|(at, ((axis, unit), full))| {
            let rated = match calibration.rated.get(at) {
                Some(true) => " (rated)",
                _ => "",
            };
            format!("{axis} {} {unit}{rated}", significant(*full, 5))
        });
    let recordings = first(NAMED_RECORDINGS, &calibration.trained_on);
    let offset = if calibration.offset { "in the model" } else { "none in the model" };
    let rate = match calibration.rate_hz {
        Some(rate) => format!("{} Hz", significant(rate, 5)),
        None => "an unknown rate".to_owned(),
    };
    let mut settings = vec![
        ("regressor", regressor(calibration)),
        ("blocks", calibration.describe()),
        ("gauges", calibration.gauges.join(", ")),
        ("axes", joined(", ", calibration.axes.iter().map(|axis| axis.label()))),
        ("full scale", joined(", ", full_scale)),
        ("offset", offset.to_owned()),
        (
            "fitted",
            format!(
                "{} samples (decimation {}), {} tested",
                quality.n_train, calibration.decimation, quality.n_test
            ),
        ),
        ("trained on", recordings),
        ("recorded at", rate),
    ];
    let channels = &calibration.features.auxiliary;
    if !channels.is_empty() {
        let channels = channels.iter().map(AuxiliaryChannel::in_words);
        settings.push(("auxiliary channels", joined("; ", channels)));
    }
    settings.extend(quality.history_scatter.as_ref().map(|scatter| {
        let axes = calibration.axes.iter().zip(scatter);
        let scatter = axes.map(|(axis, scatter)| {
            format!("{axis} {} {}", significant(*scatter, 3), axis.unit())
        });
        let text = format!(
            "at most one sample in {} s; loads of runs that start at different samples differ by (root mean square) {}",
            significant(calibration.history_step_secs, 4),
            joined(", ", scatter)
        );
        ("history", text)
    }));
    let how = quality.cross_validation.as_ref();
    settings.extend(how.map(|how| ("cross-validation", how.to_string())));
    settings.extend(calibration.frame.map(|frame| ("sensor frame", frame.to_string())));
    settings.extend(calibration.tare.map(|tare| {
        let text = format!("the gauges minus their mean over {tare}; tare before use");
        ("tared", text)
    }));
    settings
}

fn regressor(calibration: &Calibration) -> String {
    let label = calibration.regressor.label();
    match &calibration.learned {
        None => label.to_owned(),
        Some(Learned::Network(network)) => format!("{label}, {} weights", network.n_parameters()),
        Some(Learned::Kernel(kernel)) => format!("{label}, {} landmarks", kernel.landmarks.len()),
    }
}

/// Returns a fact for each recording, with its file and the hash of the file. Only the first [`NAMED_RECORDINGS`] are named.
fn source_files(sources: &[UsedRecording]) -> Vec<Fact> {
    let mut facts: Vec<Fact> = sources
        .iter()
        .enumerate()
        .take(NAMED_RECORDINGS)
        .map(|(at, used)| {
            let role = used.role.label();
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

/// Returns the root mean square errors per axis in words. Errors on held-out samples come first, because they predict the
/// errors on new recordings.
fn scores(scores: &Scores) -> String {
    let sets = [
        ("on test recordings", &scores.test_rmse),
        ("in cross-validation", &scores.cv_rmse),
        ("on the fitted samples", &scores.train_rmse),
    ];
    let numbers = |rmse: &[f64]| joined(" ", rmse.iter().map(|value| format!("{value:.6}")));
    let stated: Vec<String> = (sets.iter())
        .filter_map(|(name, rmse)| Some(format!("{name} {}", numbers(rmse.as_deref()?))))
        .collect();
    if stated.is_empty() { "not known".to_owned() } else { stated.join("; ") }
}
