//! The table of formats that calibrations are written in.
//!
//! Guarantees: what a format cannot carry at all is refused before a byte is written; what it carries in part says so inside.

use std::io;
use std::path::Path;

use super::code::{LONGEST_WINDOW_SECS, Language, source_code};
use super::facts::facts;
use super::{cal, calibration_csv, mat, npz, onnx, yaml};
use crate::calibration::{Calibration, FitSettings, Learned, Learner, Regressor};
use crate::features::FeatureSettings;
use crate::recording::{Axis, Layout};

/// How a calibration is written.
///
/// | format | endings | holds | reads back |
/// |---|---|---|---|
/// | `Json` | `.json` | everything | whole |
/// | `Csv` | `.csv` | both matrices, rows and columns named, below `#` lines that say what it is | no |
/// | `CHeader` | `.h` | everything that runs: one C99 file | no |
/// | `Rust` | `.rs` | likewise, one Rust file | no |
/// | `Python` | `.py` | likewise, one Python file on NumPy | no |
/// | `Cal` | `.cal` | the conventional matrix of six gauges and six axes, without offset | conventional |
/// | `Yaml` | `.yaml`, `.yml` | both matrices, blocks, scales, quality; no network, no kernel | no |
/// | `Npz` | `.npz` | every array, network and kernel too, for NumPy | no |
/// | `Mat` | `.mat` | likewise for MATLAB (version 5) | no |
/// | `Onnx` | `.onnx` | the network (and the linear part before it), without the blocks | no |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the table says what they are")]
pub enum CalibrationFormat {
    Json,
    Csv,
    CHeader,
    Rust,
    Python,
    Cal,
    Yaml,
    Npz,
    Mat,
    Onnx,
}

/// Why a calibration cannot be written in a format.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum FormatError {
    #[error(
        "ONNX holds networks, and this calibration ({regressor}) has none; use .h, .py, .npz or .json, or fit a network"
    )]
    NoNetwork { regressor: &'static str },
    #[error(
        "a .cal file holds six gauges and the axes Fx Fy Fz Mx My Mz, and this calibration has {gauges} gauges and the axes {}; \
         use .yaml, .h or .json", .axes.join(" ")
    )]
    NotSix {
        gauges: usize,
        axes: Vec<&'static str>,
    },
    #[error(
        "the blocks look back {window_secs} s, and what runs this file would have to keep all samples of that time (at most \
         {LONGEST_WINDOW_SECS} s); fit with a smaller t_th or lag, or use .json"
    )]
    LongWindow { window_secs: f64 },
}

/// What formats ask of a calibration.
struct MadeOf<'a> {
    regressor: Regressor,
    has_network: bool,
    n_gauges: usize,
    axes: &'a [Axis],
    features: &'a FeatureSettings,
}

impl CalibrationFormat {
    /// All of them, the complete one first.
    pub const ALL: [Self; 10] = [
        Self::Json,
        Self::CHeader,
        Self::Rust,
        Self::Python,
        Self::Yaml,
        Self::Cal,
        Self::Csv,
        Self::Npz,
        Self::Mat,
        Self::Onnx,
    ];

    /// The format that a file's ending asks for.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL
            .into_iter()
            .find(|format| format.endings().contains(&&*ending))
    }

    /// The endings of its files, in small letters and without the dot; the usual one first.
    #[must_use]
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Json => &["json"],
            Self::Csv => &["csv"],
            Self::CHeader => &["h"],
            Self::Rust => &["rs"],
            Self::Python => &["py"],
            Self::Cal => &["cal"],
            Self::Yaml => &["yaml", "yml"],
            Self::Npz => &["npz"],
            Self::Mat => &["mat"],
            Self::Onnx => &["onnx"],
        }
    }

    /// The usual endings of all formats with their dots, as messages list them.
    #[must_use]
    pub fn listed() -> String {
        let endings = Self::ALL.map(|format| format!(".{}", format.endings()[0]));
        endings.join(" ")
    }

    /// What people call it.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Json => "Complete calibration (JSON)",
            Self::Csv => "Matrices (CSV)",
            Self::CHeader => "C header",
            Self::Rust => "Rust source",
            Self::Python => "Python source",
            Self::Cal => "ATI-style calibration (XML)",
            Self::Yaml => "YAML",
            Self::Npz => "NumPy arrays",
            Self::Mat => "MATLAB arrays",
            Self::Onnx => "ONNX network",
        }
    }

    /// Whether [`read_calibration`](super::read_calibration) reads it.
    #[must_use]
    pub fn reads_back(self) -> bool {
        matches!(self, Self::Json | Self::Cal)
    }

    /// Whether its files name the gauges; where they do not, gauges are known by their order.
    #[must_use]
    pub fn names_gauges(self) -> bool {
        self != Self::Cal
    }

    /// What a file in this format holds of the calibration, and what it leaves out.
    #[must_use]
    pub fn contents(self, calibration: &Calibration) -> (&'static str, &'static str) {
        let has_kernel = matches!(calibration.learned, Some(Learned::Kernel(_)));
        match self {
            Self::Json => ("everything", "nothing"),
            Self::CHeader | Self::Rust | Self::Python if has_kernel => (
                "conventional and compensated load with all blocks",
                "the kernel's band",
            ),
            Self::CHeader | Self::Rust | Self::Python => (
                "conventional and compensated load with all blocks",
                "nothing",
            ),
            Self::Cal => (
                "the matrix of the conventional calibration",
                "all history (compensated load), the offset (take the unloaded gauges as bias), names of gauges",
            ),
            Self::Csv | Self::Yaml if calibration.learned.is_some() => (
                "matrices and choices of the blocks",
                "the network or kernel, without which the compensated load is not whole",
            ),
            Self::Csv => ("matrices", "choices of the blocks but in words, scales"),
            Self::Yaml => ("matrices, choices of the blocks, scales", "nothing"),
            Self::Npz | Self::Mat => (
                "matrices, choices of the blocks, scales, network or kernel",
                "nothing",
            ),
            Self::Onnx => (
                "from a row of features to the compensated load",
                "the blocks that make the row, the conventional load",
            ),
        }
    }

    /// Checks whether the format can carry the calibration.
    ///
    /// # Errors
    /// [`FormatError`] if it cannot.
    pub fn check(self, calibration: &Calibration) -> Result<(), FormatError> {
        self.check_made_of(&MadeOf {
            regressor: calibration.regressor,
            has_network: matches!(calibration.learned, Some(Learned::Network(_))),
            n_gauges: calibration.gauges.len(),
            axes: &calibration.axes,
            features: &calibration.features,
        })
    }

    /// Checks, before the fit, whether the format can carry what these settings make of recordings of this layout.
    ///
    /// # Errors
    /// [`FormatError`] if it cannot.
    pub fn check_fit(self, settings: &FitSettings, layout: &Layout) -> Result<(), FormatError> {
        self.check_made_of(&MadeOf {
            regressor: settings.regressor,
            has_network: settings.regressor.learner() == Some(Learner::Network),
            n_gauges: layout.gauge_names.len(),
            axes: &layout.axes,
            features: &settings.features,
        })
    }

    fn check_made_of(self, made_of: &MadeOf<'_>) -> Result<(), FormatError> {
        match self {
            Self::Onnx if !made_of.has_network => Err(FormatError::NoNetwork {
                regressor: made_of.regressor.label(),
            }),
            Self::Cal if made_of.n_gauges != 6 || *made_of.axes != Axis::ALL => {
                Err(FormatError::NotSix {
                    gauges: made_of.n_gauges,
                    axes: made_of.axes.iter().map(|axis| axis.symbol()).collect(),
                })
            }
            Self::CHeader | Self::Rust | Self::Python => {
                let window_secs = made_of.features.window_secs();
                match window_secs > LONGEST_WINDOW_SECS {
                    true => Err(FormatError::LongWindow { window_secs }),
                    false => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }

    /// Writes the calibration; `name` is what names inside are made of.
    pub(super) fn write(
        self,
        calibration: &Calibration,
        name: &str,
        out: &mut dyn io::Write,
    ) -> io::Result<()> {
        calibration.validate().map_err(io::Error::other)?;
        self.check(calibration).map_err(io::Error::other)?;
        let (holds, leaves_out) = self.contents(calibration);
        let facts = facts(calibration, holds, leaves_out);
        let mut code = |language| {
            let code = source_code(calibration, &facts, language, name);
            out.write_all(code.as_bytes())
        };
        match self {
            Self::CHeader => code(Language::C),
            Self::Rust => code(Language::Rust),
            Self::Python => code(Language::Python),
            Self::Json => {
                serde_json::to_writer_pretty(&mut *out, calibration)?;
                writeln!(out)
            }
            Self::Csv => calibration_csv::write(calibration, &facts, out),
            Self::Cal => cal::write(calibration, &facts, out),
            Self::Yaml => yaml::write(calibration, &facts, out),
            Self::Npz => npz::write(calibration, &facts, out),
            Self::Mat => mat::write(calibration, &facts, out),
            Self::Onnx => onnx::write(calibration, &facts, out),
        }
    }
}
