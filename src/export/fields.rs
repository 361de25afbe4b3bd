//! Parts of a calibration with their names in files of settings and arrays. Networks and kernels are only in files of arrays.

use self::Value::{Count, Flag, Flags, Matrix, Number, Numbers, Table, Text, Texts};
use crate::calibration::{Calibration, LinearMap, Scores};
use crate::features::{AuxiliaryChannel, Setting, Stored, Thresholds};

pub(super) struct Field {
    /// Name of the group that the part belongs to; empty for the calibration itself.
    pub group: &'static str,
    pub name: &'static str,
    /// Explanation for readers of the number; may be empty.
    pub about: &'static str,
    pub value: Value,
}

pub(super) enum Value {
    Flag(bool),
    /// One value per axis.
    Flags(Vec<bool>),
    Count(u64),
    Number(f64),
    Text(String),
    Texts(Vec<String>),
    Numbers(Vec<f64>),
    /// One row per axis.
    Matrix(Vec<Vec<f64>>),
    /// Columns of one table, all of the same length.
    Table(Vec<(&'static str, Vec<f64>)>),
}

/// Returns all parts; the parts of a group follow each other.
pub(super) fn fields(calibration: &Calibration) -> Vec<Field> {
    let mut fields = of_calibration(calibration);
    let identity = calibration.identity.entered();
    fields
        .extend(identity.map(|(item, text)| {
            field("identity", item.key(), item.label(), Text(text.to_owned()))
        }));
    fields.extend(of_features(calibration));
    let scale = &calibration.gauge_scale;
    let scale = [
        ("shift", &scale.shift),
        ("inverse_scale", &scale.inverse_scale),
        ("deviation", &scale.deviation),
    ];
    let scale = scale.into_iter();
    fields.extend(
        scale.map(|(name, numbers)| field("gauge_scale", name, "", Numbers(numbers.clone()))),
    );
    let quality = &calibration.quality;
    if let Some(known) = &quality.coefficients {
        let about = "of the coefficients of the compensated matrix, by a jackknife";
        let group = "coefficient_errors";
        fields.extend([
            field(group, "left_out", "", Text(known.left_out.to_string())),
            field(group, "standard", about, Matrix(known.standard.clone())),
        ]);
    }
    let conventional = Some((&calibration.conventional, &quality.conventional));
    let compensated = calibration.compensated.as_ref();
    let compensated = compensated.map(|map| (map, &quality.compensated));
    for (group, parts) in [("conventional", conventional), ("compensated", compensated)] {
        if let Some((map, scores)) = parts {
            fields.extend(of_map(group, map, scores, &calibration.gauges));
        }
    }
    fields
}

fn of_calibration(calibration: &Calibration) -> Vec<Field> {
    let own = |name, about, value| field("", name, about, value);
    // No axis is rated if the user entered no rated load.
    let rated = (0..calibration.axes.len()).map(|at| calibration.rated.get(at) == Some(&true));
    let rated = rated.collect();
    let rated_about = "1 if the full scale is the rated load that the user entered";
    let step_about = "minimum time between the samples that look-backs and lags keep (s)";
    let symbols = calibration.axes.iter().map(ToString::to_string);
    let mut fields = vec![
        own("gauges", "", Texts(calibration.gauges.clone())),
        own("axes", "", Texts(symbols.collect())),
        own("units", "", Texts(calibration.units.clone())),
        own("full_scale", "", Numbers(calibration.full_scale.clone())),
        own("rated", rated_about, Flags(rated)),
        own(
            "limits",
            "largest loads of the recordings; 0 if unknown",
            Numbers(calibration.limits.clone()),
        ),
        own("offset", "", Flag(calibration.offset)),
        own("regressor", "", Text(calibration.regressor.key().to_owned())),
        own("gap_secs", "a longer step in time is a gap (s)", Number(calibration.gap_secs)),
        own("history_step_secs", step_about, Number(calibration.history_step_secs)),
        own("decimation", "", Count(calibration.decimation as u64)),
        own("simulated", "", Flag(calibration.simulated)),
        own("trained_on", "", Texts(calibration.trained_on.clone())),
    ];
    let clipped_at = calibration.clipped_at().into_iter().flatten();
    let names = ["gauge_low", "gauge_high"].into_iter();
    let clipped = "a gauge that reaches this value is clipped; 1e30 in magnitude if unknown";
    fields.extend(names.zip(clipped_at).map(|(name, ends)| own(name, clipped, Numbers(ends))));
    fields.extend(calibration.rate_hz.map(|rate| own("rate_hz", "", Number(rate))));
    let tare = calibration.tare.as_ref();
    fields.extend(tare.map(|tare| own("tared", "", Text(tare.to_string()))));
    fields
}

fn of_features(calibration: &Calibration) -> Vec<Field> {
    let features = &calibration.features;
    let look_backs = |number: fn(&Thresholds) -> f64| {
        let look_backs = features.look_backs.iter();
        look_backs.map(number).collect()
    };
    let weights =
        "weights of the look-back: d is the norm of the conventional load's difference times these";
    let mut fields = vec![
        field(
            "blocks",
            "look_backs",
            "",
            Table(vec![
                ("f_th", look_backs(|look_back| look_back.f_th)),
                ("t_th_secs", look_backs(|look_back| look_back.t_th_secs)),
            ]),
        ),
        field("blocks", "distance_weights", weights, Numbers(calibration.distance_weights())),
    ];
    fields.extend(features.blocks.stored().map(|(block, stored)| {
        let Setting { key, unit, .. } = block.setting();
        let value = match stored {
            Stored::Number(number) => Count(number.into()),
            Stored::List(values) => Numbers(values.to_vec()),
        };
        field("blocks", key, unit.words, value)
    }));
    if features.uses_auxiliary() {
        let channels = features.auxiliary.iter();
        let of = |name, about, pick: fn(&AuxiliaryChannel) -> f64| {
            let numbers = channels.clone().map(pick);
            field("auxiliary", name, about, Numbers(numbers.collect()))
        };
        let units = channels.clone().map(|channel| channel.unit.clone());
        fields.extend([
            field("auxiliary", "channels", "", Texts(features.auxiliary_names())),
            field("auxiliary", "units", "", Texts(units.collect())),
            of("reference", "value at which the effect is zero", |own| own.reference),
            of("inverse_scale", "", |own| own.inverse_scale),
            of("min", "minimum in the training recordings", |own| own.min),
            of("max", "maximum in the training recordings", |own| own.max),
        ]);
    }
    fields
}

fn of_map<'a>(
    group: &'static str,
    map: &LinearMap,
    scores: &'a Scores,
    gauges: &[String],
) -> impl Iterator<Item = Field> + 'a {
    let names = field(group, "features", "", Texts(map.names(gauges)));
    let matrix = field(group, "matrix", "", Matrix(map.matrix.clone()));
    let scores = [
        ("test_rmse", &scores.test_rmse),
        ("left_out_rmse", &scores.cv_rmse),
        ("train_rmse", &scores.train_rmse),
    ];
    let scores = scores.into_iter();
    let scores =
        scores.filter_map(move |(name, rmse)| Some(field(group, name, "", Numbers(rmse.clone()?))));
    [names, matrix].into_iter().chain(scores)
}

fn field(group: &'static str, name: &'static str, about: &'static str, value: Value) -> Field {
    Field { group, name, about, value }
}
