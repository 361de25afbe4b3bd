//! A calibration as a library: its code in every language with examples, test samples with expected loads, and self-tests.
//! The expected loads are those of [`Estimator`](crate::calibration::Estimator). The same calibration always gives the same
//! bytes.

mod test_vector;

use std::io;

use minijinja::{Value, context};
use zip::CompressionMethod;

use self::test_vector::{Answered, test_vector};
use super::c_header::C;
use super::m_function::MATLAB;
use super::{python, rust};
use crate::{
    calibration::{Calibration, Learned, Status},
    export::{
        code::{CODE, Program, state_bytes},
        target::{Held, Target, all_parts, of_target},
        template::environment,
        text::{for_block_comment, identifier, library_name},
    },
    features::AuxiliaryChannel,
    formats::npz::zipped,
    recording::Axis,
    shown::joined,
};

/// Largest error that a self-test allows, as a share of full scale: in double precision, and in single precision.
const ALLOWED: (f64, f64) = (1e-9, 2e-6);

/// Returns the largest error that a self-test in single precision allows. Large weights of a kernel cancel, and so do large
/// coefficients of similar columns, which loses digits.
fn allowed_in_float(calibration: &Calibration) -> f64 {
    let deviations = &calibration.gauge_scale.deviation;
    let n_columns = deviations.len() * (1 + calibration.features.n_histories());
    let of_gauges = |row: &Vec<f64>| -> f64 {
        let terms = row.iter().zip(deviations.iter().cycle()).take(n_columns);
        terms.map(|(coefficient, deviation)| 2.0 * coefficient.abs() * deviation).sum()
    };
    let linear = calibration.compensated.iter().flat_map(|map| map.matrix.iter().map(of_gauges));
    let kernel = match &calibration.learned {
        Some(Learned::Kernel(kernel)) => &kernel.weights[..],
        _ => &[],
    };
    let kernel = kernel.iter().map(|weights| weights.iter().map(|weight| weight.abs()).sum());
    let scale = test_vector::full_scale(calibration);
    let lost = linear.chain(kernel).zip(scale.iter().cycle());
    lost.map(|(sum, scale): (f64, _)| 2.0 * f64::from(f32::EPSILON) * sum / scale)
        .fold(ALLOWED.1, f64::max)
}

macro_rules! template {
    ($path:literal, $name:literal) => {
        ($path, include_str!(concat!("../../templates/package/", $name)))
    };
}

const TEMPLATES: [(&str, &str); 14] = [
    template!("README.md", "README.md"),
    template!("main.c", "main.c"),
    template!("shared.c", "shared.c"),
    template!("CMakeLists.txt", "CMakeLists.txt"),
    template!("library.json", "library.json"),
    template!("library.properties", "library.properties"),
    template!("examples/read_load/read_load.ino", "sketch.ino"),
    template!("ros2/node.cpp", "ros_node.cpp"),
    template!("ros2/CMakeLists.txt", "ros_CMakeLists.txt"),
    template!("ros2/package.xml", "ros_package.xml"),
    template!("python/selftest.py", "selftest.py"),
    template!("python/shared.py", "shared.py"),
    template!("rust/selftest.rs", "selftest.rs"),
    template!("matlab/selftest.m", "selftest.m"),
];

/// Library for a calibration, in a `.zip` archive or in a folder.
pub(super) static PACKAGE: Target = Target {
    name: "Library with self-tests (C, Arduino, Rust, Python, MATLAB)",
    purpose: "C, Arduino, Rust … with self-tests",
    endings: &["zip"],
    write: |export, out| {
        let folder = identifier(export.name);
        let files = files(export.calibration, export.name)?
            .into_iter()
            .map(|(path, content)| (format!("{folder}/{path}"), content));
        out.write_all(&zipped(CompressionMethod::Deflated, files)?)
    },
    parts: |calibration| {
        let [compensation, offset, names, _] = all_parts(calibration);
        [compensation, offset, names, Held::Whole]
    },
    ..CODE
};

/// Files of a library, each with its path inside the library and its content.
pub(in crate::export) type Files = Vec<(String, String)>;

/// Returns all files of a library. The names inside them are made from `name`.
pub(in crate::export) fn files(calibration: &Calibration, name: &str) -> io::Result<Files> {
    let name = library_name(name);
    let export = of_target(&CODE, calibration, &name)?;
    let (name, header) = C.source(&export);
    let (m_name, m_function) = MATLAB.source(&export);
    let rows = test_vector(calibration).map_err(io::Error::other)?;
    let expected = as_csv(calibration, &rows);
    let values = values(calibration, &name, &m_name, rows.len(), &expected);
    let mut files = vec![
        (format!("src/{name}.h"), header),
        ("expected.csv".to_owned(), expected),
        (format!("python/{name}.py"), python::LANGUAGE.source(&export).1),
        (format!("rust/{name}.rs"), rust::LANGUAGE.source(&export).1),
        (format!("matlab/{m_name}.m"), m_function),
    ];
    let templates = environment(false);
    for (path, template) in TEMPLATES {
        let filled = templates.render_str(template, &values);
        let filled = filled.expect("the templates are this program's own");
        files.push((path.to_owned(), filled));
    }
    Ok(files)
}

fn values(
    calibration: &Calibration,
    name: &str,
    m_name: &str,
    n_rows: usize,
    expected: &str,
) -> Value {
    let channels = &calibration.features.auxiliary;
    let (scale, program) = (test_vector::full_scale(calibration), Program::new(calibration));
    let longest_line = expected.lines().map(str::len).max().unwrap_or(0);
    context! {
        name,
        NAME => name.to_ascii_uppercase(),
        m_name,
        version => env!("CARGO_PKG_VERSION"),
        n_gauges => calibration.gauges.len(),
        n_inputs => calibration.gauges.len() + channels.len(),
        wrench => Axis::ALL.map(|axis| {
            let part = if axis.is_force() { "force" } else { "torque" };
            let along = axis.symbol()[1..].to_lowercase();
            let at = calibration.axes.iter().position(|known| *known == axis);
            (format!("{part}.{along}"), at)
        }),
        n_axes => calibration.axes.len(),
        gauges => for_block_comment(&calibration.gauges.join(", ")),
        n_auxiliary => channels.len(),
        auxiliary => for_block_comment(
            &joined("; ", channels.iter().map(AuxiliaryChannel::in_words)),
        ),
        axes => joined(", ", calibration.axes.iter().map(|axis| axis.label())),
        flags => Status::EXPORTED
            .map(|(name, flag)| format!("{} {name}", flag.bits()))
            .join(", "),
        full_scale => scale.iter().map(|scale| format!("{scale:?}")).collect::<Vec<_>>(),
        n_rows,
        line_bytes => longest_line + 3, // line end of two characters on Windows, and a closing zero
        bytes_double => state_bytes(&program, 8),
        bytes_float => state_bytes(&program, 4),
        tared => calibration.tare.is_some(),
        allowed_double => format!("{:?}", ALLOWED.0),
        allowed_float => format!("{:.1e}", allowed_in_float(calibration)),
    }
}

/// Returns the test samples as CSV. The header is only for human readers. Each row has time, gauges, auxiliary channels,
/// expected load, conventional load and status. The last cell tells whether the sample is at the edge of a threshold.
fn as_csv(calibration: &Calibration, rows: &[Answered]) -> String {
    let gauges = (1..=calibration.gauges.len()).map(|gauge| format!("gauge_{gauge}"));
    let axes = calibration.axes.iter().map(|axis| axis.symbol());
    let conventional = axes.clone().map(|axis| format!("conventional_{axis}"));
    let auxiliary = (1..=calibration.features.auxiliary.len()).map(|at| format!("auxiliary_{at}"));
    let names = std::iter::once("time".to_owned())
        .chain(gauges)
        .chain(auxiliary)
        .chain(axes.map(str::to_owned))
        .chain(conventional);
    let names = names.chain(["status", "at_edge"].map(str::to_owned));
    let mut out = joined(",", names);
    for row in rows {
        out.push_str(&format!("\n{:?}", row.sample.0));
        let numbers =
            row.sample.1.iter().chain(&row.sample.2).chain(&row.load).chain(&row.conventional);
        for number in numbers {
            out.push_str(&format!(",{number:?}"));
        }
        out.push_str(&format!(",{},{}", row.status, u8::from(row.at_edge)));
    }
    out.push('\n');
    out
}
