//! Parts of a calibration, with their names in files of parameters (YAML) and of arrays (NumPy, MATLAB). Only files of arrays
//! hold networks and kernels.

use self::Value::{Count, Flag, Flags, Matrix, Number, Numbers, Text, Texts};
use crate::{
    calibration::{Calibration, LinearMap, Scores},
    features::{AuxiliaryChannel, Setting, Stored, Thresholds},
};

pub(super) struct Field {
    /// Name of the group of parts that this part belongs to; empty for parts of the calibration itself.
    pub group: &'static str,
    pub name: &'static str,
    /// Explanation of the part for readers of the file; may be empty.
    pub about: &'static str,
    pub value: Value,
}

pub(super) enum Value {
    Flag(bool),
    /// One true or false per axis.
    Flags(Vec<bool>),
    Count(u64),
    Number(f64),
    Text(String),
    Texts(Vec<String>),
    Numbers(Vec<f64>),
    /// Matrix as a list of rows, one per axis.
    Matrix(Vec<Vec<f64>>),
}

/// Returns all parts of a calibration. The parts of a group follow each other.
pub(super) fn fields(calibration: &Calibration) -> Vec<Field> {
    let mut fields = of_calibration(calibration);
    for (item, text) in calibration.identity.entered() {
        fields.push(field("identity", item.key(), item.label(), Text(text.to_owned())));
    }
    fields.extend(of_features(calibration));
    let keep = "longest pause after which this memory is kept (s)";
    let kept = calibration.features.memories().into_iter();
    fields.extend(
        kept.map(|memory| {
            field("keep_secs", memory, keep, Number(calibration.keep_secs_of(memory)))
        }),
    );
    let fade = "factor of each unknown state of this block in the fade of the load";
    fields.extend(calibration.features.memories().into_iter().filter_map(|block| {
        Some(field("fade", block, fade, Numbers(calibration.fade.get(block)?.clone())))
    }));
    let scale = &calibration.gauge_scale;
    for (name, numbers) in [
        ("shift", &scale.shift),
        ("inverse_scale", &scale.inverse_scale),
        ("deviation", &scale.deviation),
        ("travel", &scale.travel),
    ] {
        fields.push(field("gauge_scale", name, "", Numbers(numbers.clone())));
    }
    let run_secs = scale.run_secs.map(|secs| field("gauge_scale", "run_secs", "", Number(secs)));
    fields.extend(run_secs);
    let quality = &calibration.quality;
    if let Some(known) = &quality.coefficients {
        let about = "standard error of each coefficient of the compensated matrix, by a jackknife";
        let group = "coefficient_errors";
        fields.extend([
            field(group, "left_out", "", Text(known.left_out.to_string())),
            field(group, "standard", about, Matrix(known.standard.clone())),
        ]);
    }
    let gauges = &calibration.gauges;
    add_map(&mut fields, "conventional", &calibration.conventional, &quality.conventional, gauges);
    if let Some(map) = &calibration.compensated {
        add_map(&mut fields, "compensated", map, &quality.compensated, gauges);
    }
    fields
}

fn of_calibration(calibration: &Calibration) -> Vec<Field> {
    let in_calibration = |name, about, value| field("", name, about, value);
    // Without an entered rated load, `calibration.rated` is empty, and no full scale counts as a rated load.
    let rated =
        (0..calibration.axes.len()).map(|at| calibration.rated.get(at) == Some(&true)).collect();
    let rated_about = "1 if the full scale is the rated load that the user entered";
    let step_about = "minimum time between the samples that look-backs and lags keep (s)";
    let symbols = calibration.axes.iter().map(ToString::to_string);
    let mut fields = vec![
        in_calibration("gauges", "", Texts(calibration.gauges.clone())),
        in_calibration("axes", "", Texts(symbols.collect())),
        in_calibration("units", "", Texts(calibration.units.clone())),
        in_calibration("full_scale", "", Numbers(calibration.full_scale.clone())),
        in_calibration("rated", rated_about, Flags(rated)),
        in_calibration(
            "limits",
            "largest known load: the rated load, else 1.2 times the largest training load; 0 if unknown",
            Numbers(calibration.limits.clone()),
        ),
        in_calibration("offset", "", Flag(calibration.offset)),
        in_calibration("regressor", "", Text(calibration.regressor.key().to_owned())),
        in_calibration(
            "gap_secs",
            "a longer step in time is a gap (s)",
            Number(calibration.gap_secs),
        ),
        in_calibration("history_step_secs", step_about, Number(calibration.history_step_secs)),
        in_calibration("decimation", "", Count(calibration.decimation as u64)),
        in_calibration("simulated", "", Flag(calibration.simulated)),
        in_calibration("trained_on", "", Texts(calibration.trained_on.clone())),
    ];
    let clipped_at = calibration.clipped_at().into_iter().flatten();
    let names = ["gauge_low", "gauge_high"].into_iter();
    let clipped = "a gauge that reaches this value is clipped; 1e30 in magnitude if unknown";
    fields.extend(
        names.zip(clipped_at).map(|(name, ends)| in_calibration(name, clipped, Numbers(ends))),
    );
    fields.extend(calibration.rate_hz.map(|rate| in_calibration("rate_hz", "", Number(rate))));
    let tare = calibration.tare.as_ref();
    fields.extend(tare.map(|tare| in_calibration("tared", "", Text(tare.to_string()))));
    if let Some(frame) = calibration.frame {
        let turn = "angles of the gauge frame about the fixed axes x, y, z of the sensor frame (degrees), in this order";
        let shift = "origin of the gauge frame in the sensor frame (m)";
        for (name, about, numbers) in [
            ("turn_degrees", turn, frame.turn_degrees),
            ("shift_metres", shift, frame.shift_metres),
        ] {
            fields.push(field("frame", name, about, Numbers(numbers.to_vec())));
        }
    }
    if let Some(tool) = calibration.tool {
        let mass = "mass of the weight that the sensor carried in the training recordings (kg)";
        fields.push(field("tool", "mass_kg", mass, Number(tool.mass_kg)));
        let centre = "centre of mass of this weight, in the frame of the loads (m)";
        fields.push(field("tool", "centre_m", centre, Numbers(tool.centre_m.to_vec())));
    }
    fields
}

fn of_features(calibration: &Calibration) -> Vec<Field> {
    let features = &calibration.features;
    let look_backs = |name, number: fn(&Thresholds) -> f64| {
        let look_backs = features.look_backs.iter();
        field("blocks", name, "", Numbers(look_backs.map(number).collect()))
    };
    let weights = "weight of each axis in the look-back: F_th is compared with the norm of the difference of conventional loads times the weights";
    let mut fields = vec![
        look_backs("f_th", |look_back| look_back.f_th),
        look_backs("t_th_secs", |look_back| look_back.t_th_secs),
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
            of("reference", "value at which the effect is zero", |channel| channel.reference),
            of("inverse_scale", "", |channel| channel.inverse_scale),
            of("min", "minimum in the training recordings", |channel| channel.min),
            of("max", "maximum in the training recordings", |channel| channel.max),
        ]);
    }
    fields
}

fn add_map(
    fields: &mut Vec<Field>,
    group: &'static str,
    map: &LinearMap,
    scores: &Scores,
    gauges: &[String],
) {
    fields.push(field(group, "features", "", Texts(map.names(gauges))));
    fields.push(field(group, "matrix", "", Matrix(map.matrix.clone())));
    for (name, rmse) in [
        ("test_rmse", &scores.test_rmse),
        ("left_out_rmse", &scores.cv_rmse),
        ("train_rmse", &scores.train_rmse),
    ] {
        fields.extend(rmse.clone().map(|rmse| field(group, name, "", Numbers(rmse))));
    }
}

fn field(group: &'static str, name: &'static str, about: &'static str, value: Value) -> Field {
    Field { group, name, about, value }
}
