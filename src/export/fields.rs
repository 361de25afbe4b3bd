//! What a calibration is made of, under the names that files of settings and of arrays give it; told once for all of them.
//!
//! Networks and kernels are not in it: only files of arrays have room for them.

use crate::calibration::{Calibration, LinearMap, Scores};
use crate::features::{AuxiliaryChannel, Setting, Stored, Thresholds};

/// One of its parts.
pub(super) struct Field {
    /// The part that it is a part of; empty for the calibration itself.
    pub group: &'static str,
    pub name: &'static str,
    /// What somebody must know who reads the number alone; may be empty.
    pub about: &'static str,
    pub value: Value,
}

pub(super) enum Value {
    Flag(bool),
    /// One per axis.
    Flags(Vec<bool>),
    Count(u64),
    Number(f64),
    Text(String),
    Texts(Vec<String>),
    Numbers(Vec<f64>),
    /// One row per axis.
    Matrix(Vec<Vec<f64>>),
    /// Columns of one table, as long as each other.
    Table(Vec<(&'static str, Vec<f64>)>),
}

/// All of them, those of a group one after the other.
pub(super) fn fields(calibration: &Calibration) -> Vec<Field> {
    let features = &calibration.features;
    let scale = &calibration.gauge_scale;
    // None is rated where nobody entered any.
    let rated = (0..calibration.axes.len()).map(|at| calibration.rated.get(at) == Some(&true));
    let rated = rated.collect();
    let symbols = calibration.axes.iter().map(|axis| axis.symbol().to_owned());
    let look_backs = |number: fn(&Thresholds) -> f64| {
        let look_backs = features.look_backs.iter();
        look_backs.map(number).collect()
    };
    let mut fields = vec![
        field("", "gauges", Value::Texts(calibration.gauges.clone())),
        field("", "axes", Value::Texts(symbols.collect())),
        field("", "units", Value::Texts(calibration.units.clone())),
        numbers("", "full_scale", &calibration.full_scale),
        Field {
            about: "whether each full scale is the rated load that somebody entered",
            ..field("", "rated", Value::Flags(rated))
        },
        Field {
            about: "beyond these nothing is known of the sensor; 0 where that is not known",
            ..numbers("", "limits", &calibration.limits)
        },
        field("", "offset", Value::Flag(calibration.offset)),
        field(
            "",
            "regressor",
            Value::Text(calibration.regressor.key().to_owned()),
        ),
        Field {
            about: "a longer step than this is a gap (s)",
            ..field("", "gap_secs", Value::Number(calibration.gap_secs))
        },
        Field {
            about: "look-backs and lags keep no samples closer to each other than this (s)",
            ..field(
                "",
                "history_step_secs",
                Value::Number(calibration.history_step_secs),
            )
        },
        field(
            "",
            "decimation",
            Value::Count(calibration.decimation as u64),
        ),
        field("", "simulated", Value::Flag(calibration.simulated)),
        field(
            "",
            "trained_on",
            Value::Texts(calibration.trained_on.clone()),
        ),
    ];
    let clipped_at = calibration.clipped_at().into_iter().flatten();
    let names = ["gauge_low", "gauge_high"].into_iter();
    fields.extend(names.zip(clipped_at).map(|(name, ends)| Field {
        about: "a gauge that reaches this is clipped; 1e30 from zero where that is not known",
        ..numbers("", name, &ends)
    }));
    let rate = calibration.rate_hz.into_iter();
    fields.extend(rate.map(|rate| field("", "rate_hz", Value::Number(rate))));
    let tare = calibration.tare.iter();
    fields.extend(tare.map(|tare| field("", "tared", Value::Text(tare.to_string()))));
    let identity = calibration.identity.entered();
    fields.extend(identity.map(|(item, text)| Field {
        about: item.label(),
        ..field("identity", item.key(), Value::Text(text.to_owned()))
    }));
    fields.extend([
        field(
            "blocks",
            "look_backs",
            Value::Table(vec![
                ("f_th", look_backs(|look_back| look_back.f_th)),
                ("t_th_secs", look_backs(|look_back| look_back.t_th_secs)),
            ]),
        ),
        Field {
            about: "d of the look-back: the norm of the conventional load's differences times these",
            ..numbers(
                "blocks",
                "distance_weights",
                &calibration.distance_weights(),
            )
        },
    ]);
    fields.extend(features.blocks.stored().map(|(block, stored)| {
        let Setting { key, unit, .. } = block.setting();
        let value = match stored {
            Stored::Number(number) => Value::Count(number.into()),
            Stored::List(values) => Value::Numbers(values.to_vec()),
        };
        Field {
            about: unit.words,
            ..field("blocks", key, value)
        }
    }));
    if features.uses_auxiliary() {
        let channels = &features.auxiliary;
        let of = |name, about, pick: fn(&AuxiliaryChannel) -> f64| Field {
            about,
            ..field(
                "auxiliary",
                name,
                Value::Numbers(channels.iter().map(pick).collect()),
            )
        };
        let units = channels
            .iter()
            .map(|channel| channel.unit.clone())
            .collect();
        fields.extend([
            field(
                "auxiliary",
                "channels",
                Value::Texts(features.auxiliary_names()),
            ),
            field("auxiliary", "units", Value::Texts(units)),
            of("reference", "what the effect counts from", |own| {
                own.reference
            }),
            of("inverse_scale", "", |own| own.inverse_scale),
            of("min", "the least value that was trained", |own| own.min),
            of("max", "the greatest value that was trained", |own| own.max),
        ]);
    }
    fields.extend([
        numbers("gauge_scale", "shift", &scale.shift),
        numbers("gauge_scale", "inverse_scale", &scale.inverse_scale),
        numbers("gauge_scale", "deviation", &scale.deviation),
    ]);
    let quality = &calibration.quality;
    if let Some(known) = &quality.coefficients {
        let group = "coefficient_errors";
        fields.push(field(
            group,
            "left_out",
            Value::Text(known.left_out.to_string()),
        ));
        fields.push(Field {
            about: "of the coefficients of the compensated matrix, by a jackknife",
            ..field(group, "standard", Value::Matrix(known.standard.clone()))
        });
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

fn of_map<'a>(
    group: &'static str,
    map: &LinearMap,
    scores: &'a Scores,
    gauges: &[String],
) -> impl Iterator<Item = Field> + 'a {
    let names = field(group, "features", Value::Texts(map.names(gauges)));
    let matrix = field(group, "matrix", Value::Matrix(map.matrix.clone()));
    let scores = [
        ("test_rmse", &scores.test_rmse),
        ("left_out_rmse", &scores.cv_rmse),
        ("train_rmse", &scores.train_rmse),
    ];
    let scores = scores.into_iter();
    let scores = scores.filter_map(move |(name, rmse)| Some(numbers(group, name, rmse.as_ref()?)));
    [names, matrix].into_iter().chain(scores)
}

fn field(group: &'static str, name: &'static str, value: Value) -> Field {
    Field {
        group,
        name,
        about: "",
        value,
    }
}

fn numbers(group: &'static str, name: &'static str, numbers: &[f64]) -> Field {
    field(group, name, Value::Numbers(numbers.to_vec()))
}
