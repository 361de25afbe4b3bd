//! ATI-style `.cal` files: XML with the matrix of a conventional calibration of up to eight gauges and six axes.
//!
//! Guarantees: a written file gives the same matrix when it is read back. Names of elements and attributes are
//! case-sensitive. A file with a missing row, an invalid number or an unknown unit is refused, so that nothing is guessed.

use std::io;

use minijinja::{Value, context};
use serde::Deserialize;

use super::matrix::{self, MATRIX};
use crate::{
    calibration::{Calibration, FORMAT, LinearMap, VERSION, history_step_by_rate},
    export::{
        target::{Export, Outline, Target},
        template::filled_markup,
        text::for_xml_comment,
    },
    features::{FeatureSettings, GaugeScale},
    recording::{
        Axis, Identity, Item,
        gap::gap_by_rate,
        units::{force_in_newtons, moment_in_newton_metres},
    },
    shown::joined,
};

pub(super) static CAL: Target = Target {
    name: "ATI-style calibration (XML)",
    purpose: "ATI drivers",
    endings: &["cal"],
    holds: "the conventional matrix of up to eight gauges and six axes",
    refusal: |outline| {
        let Outline { n_gauges, axes, .. } = *outline;
        let is_held = (1..=MOST_GAUGES).contains(&n_gauges) && *axes == Axis::ALL;
        let axes = Axis::symbols(axes).join(" ");
        (!is_held).then(|| {
            format!(
                "a .cal file holds up to {MOST_GAUGES} gauges and the axes Fx Fy Fz Mx My Mz, and this calibration has \
                 {n_gauges} gauges and the axes {axes}; use .yaml, .h, .inc or .json"
            )
        })
    },
    write,
    reader: Some(|content| {
        let note = "a .cal file holds only the conventional matrix, without compensation and offset, so tare the gauges";
        Ok((read(content)?, vec![note.to_owned()]))
    }),
    names_gauges: false,
    ..MATRIX
};

/// Maximum number of gauges that ATI's library reads from a `.cal` file.
const MOST_GAUGES: usize = 8;

#[derive(Debug, thiserror::Error)]
enum CalError {
    #[error("not an ATI-style calibration in XML (names are case-sensitive): {0}")]
    Xml(#[from] quick_xml::DeError),
    #[error("there is no element {element}; this is not an ATI-style calibration of version 1.1")]
    Missing { element: &'static str },
    #[error("element UserAxis {axis} occurs twice")]
    Twice { axis: Axis },
    #[error("{place}: {text:?} is not a usable number")]
    Number { place: String, text: String },
    #[error("{axis} has {actual} values, but NumGages is {expected}")]
    Values { axis: &'static str, expected: usize, actual: usize },
    #[error("{attribute} is {unit:?}; the known units are {known}")]
    Unit { attribute: &'static str, unit: String, known: &'static str },
}

/// Returns the symbol of an axis in `.cal` files, where moments are called T (torque).
fn spelled(axis: Axis) -> String {
    axis.symbol().replace('M', "T")
}

/// Writes the conventional matrix as XML elements `UserAxis`, one per axis. It is repeated as `Axis` elements with scale 1
/// for programs that read only `Axis`.
fn write(export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
    let calibration = export.calibration;
    let facts = matrix::facts(export, "in N and N-m", for_xml_comment).into_iter();
    let entered = |item| calibration.identity.get(item).trim();
    let date = in_order(entered(Item::Date), ["%Y-%m-%d", "%-m/%-d/%Y"]);
    let axes = calibration.axes.iter().zip(matrix::rows(calibration)).enumerate();
    let axes = axes.map(|(at, (axis, row))| {
        // Drivers limit the load to the maximum, so it must not be below the loads of the training recordings.
        let limit = calibration.limits.get(at).copied().unwrap_or(0.0);
        let max = calibration.full_scale[at].max(limit);
        (spelled(*axis), joined(" ", row), max.to_string())
    });
    let values = context! {
        facts => facts.map(Value::from_safe_string).collect::<Vec<_>>(),
        serial => entered(Item::Serial),
        model => entered(Item::Model),
        date,
        n_gauges => calibration.gauges.len(),
        program => &*calibration.program,
        axes => axes.collect::<Vec<_>>(),
    };
    let text = filled_markup(include_str!("../templates/calibration.cal"), values);
    out.write_all(text.as_bytes())
}

/// Converts a date from the format `from` to the format `to`. Texts that are no dates stay unchanged.
fn in_order(text: &str, [from, to]: [&str; 2]) -> String {
    match jiff::civil::Date::strptime(from, text) {
        Ok(day) => day.strftime(to).to_string(),
        Err(_) => text.to_owned(),
    }
}

/// Names the gauges of a calibration whose file identifies them only by their order. Does nothing if the number of names
/// differs from that of the gauges.
pub fn name_gauges(calibration: &mut Calibration, names: &[String]) {
    if names.len() != calibration.gauges.len() {
        return;
    }
    calibration.gauges = names.to_vec();
}

/// Elements and attributes of a `.cal` file that are read.
#[derive(Deserialize)]
struct Sensor {
    #[serde(rename = "@Serial", default)]
    serial: String,
    #[serde(rename = "@BodyStyle", default)]
    model: String,
    #[serde(rename = "@NumGages")]
    n_gauges: String,
    #[serde(rename = "Calibration")]
    about: About,
}

#[derive(Deserialize)]
struct About {
    #[serde(rename = "@CalDate", default)]
    date: String,
    #[serde(rename = "@ForceUnits")]
    force_unit: String,
    #[serde(rename = "@TorqueUnits")]
    moment_unit: String,
    #[serde(rename = "UserAxis", default)]
    rows: Vec<Row>,
}

#[derive(Deserialize)]
struct Row {
    #[serde(rename = "@Name")]
    name: String,
    #[serde(rename = "@values")]
    values: String,
    #[serde(rename = "@max")]
    max: String,
}

/// Reads the matrix from the XML elements `UserAxis`. Gauges are called SG0, SG1 and so on.
fn read(content: &[u8]) -> Result<Calibration, CalError> {
    if memchr::memmem::find(content, b"<FTSensor").is_none() {
        return Err(CalError::Missing { element: "FTSensor" });
    }
    let Sensor { serial, model, n_gauges, about } = quick_xml::de::from_reader(content)?;
    let n_gauges = parsed(&n_gauges, "NumGages", 0.0)?;
    let to_newtons =
        unit(&about.force_unit, "ForceUnits", force_in_newtons, "N, kN, lbf, klbf, kgf")?;
    let to_newton_metres = unit(
        &about.moment_unit,
        "TorqueUnits",
        moment_in_newton_metres,
        "N-m, N-mm, kN-m, lbf-in, lbf-ft, kgf-cm",
    )?;
    let (mut matrix, mut full_scale) = (Vec::new(), Vec::new());
    for axis in Axis::ALL {
        let mut rows = about.rows.iter().filter(|row| row.name.trim() == spelled(axis));
        let row = rows.next().ok_or(CalError::Missing {
            element: if axis.is_force() {
                "UserAxis for each of Fx Fy Fz"
            } else {
                "UserAxis for each of Tx Ty Tz"
            },
        })?;
        if rows.next().is_some() {
            return Err(CalError::Twice { axis });
        }
        let factor = if axis.is_force() { to_newtons } else { to_newton_metres };
        let place = format!("values of {}", spelled(axis));
        let values: Vec<f64> = (row.values.split_whitespace())
            .map(|text| Ok(parsed(text, &place, f64::MIN)? * factor))
            .collect::<Result<_, CalError>>()?;
        if values.len() as f64 != n_gauges || values.is_empty() {
            return Err(CalError::Values {
                axis: axis.symbol(),
                expected: n_gauges as usize,
                actual: values.len(),
            });
        }
        matrix.push(values);
        full_scale.push(parsed(&row.max, "max", 0.0)? * factor);
    }
    let mut identity = Identity::default();
    for (item, text) in [(Item::Serial, serial), (Item::Model, model), (Item::Date, about.date)] {
        identity.set(item, in_order(&text, ["%m/%d/%Y", "%Y-%m-%d"]));
    }
    Ok(conventional(matrix, full_scale, identity))
}

fn conventional(matrix: Vec<Vec<f64>>, full_scale: Vec<f64>, identity: Identity) -> Calibration {
    let n_gauges = matrix[0].len();
    let gauges: Vec<String> = (0..n_gauges).map(|gauge| format!("SG{gauge}")).collect();
    let map = LinearMap::new(FeatureSettings::present().columns(n_gauges, false), matrix);
    Calibration {
        format: FORMAT.to_owned(),
        version: VERSION,
        program: "read from a .cal file".to_owned(),
        identity,
        gauges,
        axes: Axis::ALL.to_vec(),
        units: Axis::ALL.map(|axis| axis.unit().to_owned()).to_vec(),
        rated: vec![true; full_scale.len()],
        limits: full_scale.clone(),
        full_scale,
        decimation: 1,
        gap_secs: gap_by_rate(None),
        history_step_secs: history_step_by_rate(None),
        features: FeatureSettings::present(),
        gauge_scale: GaugeScale::identity(n_gauges),
        conventional: map.clone(),
        compensated: Some(map),
        ..Calibration::default()
    }
}

/// Returns the unit that an attribute names, as its value in N or N·m. The unit must be one of `known`.
fn unit(
    named: &str,
    attribute: &'static str,
    in_si: fn(&str) -> Option<f64>,
    known: &'static str,
) -> Result<f64, CalError> {
    let found = known.split(", ").find(|unit| *unit == named.trim());
    let unit = || named.to_owned();
    found.and_then(in_si).ok_or_else(|| CalError::Unit { attribute, unit: unit(), known })
}

/// Returns the number in a text. A number below `min` is an error.
fn parsed(text: &str, place: &str, min: f64) -> Result<f64, CalError> {
    let value: Option<f64> = text.trim().parse().ok();
    value
        .filter(|value| value.is_finite() && *value >= min)
        .ok_or_else(|| CalError::Number { place: place.to_owned(), text: text.to_owned() })
}
