//! What iCub and YARP take: the matrix on the sensor's board, and the second matrix of a robot's configuration.
//!
//! The board's file has 36 lines, row by row, each a signed fraction of 16 bits in hexadecimal digits that stands for load over
//! full scale from gauges over 32767; then a 1; then six whole full scales. Moments come before forces, as the board's
//! software has them.

use std::io;

use super::matrix;
use crate::calibration::Calibration;
use crate::export::target::{Export, Outline, Refusal, Target};
use crate::export::text::for_xml_comment;
use crate::shown::for_xml;

/// What the largest gauge of a board counts.
const LARGEST_COUNT: f64 = 32_767.0;
/// What stands for 1 in its fractions.
const ONE: f64 = 32_768.0;

/// `.dat`.
pub(super) struct Board;

impl Target for Board {
    fn name(&self) -> &'static str {
        "iCub sensor board (strain)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["dat"]
    }

    fn holds(&self) -> &'static str {
        "the conventional matrix of six gauges in counts of the board, in fractions of 16 bits"
    }

    fn leaves_out(&self, _calibration: &Calibration) -> &'static str {
        matrix::LEFT_OUT
    }

    fn caution(&self, calibration: &Calibration) -> Option<String> {
        let what = "what it was made of, which the file has no room for; its coefficients are rounded to 16 bits";
        let left = matrix::leaves_out(calibration).into_iter();
        Some(left.chain([what.to_owned()]).collect::<Vec<_>>().join("; "))
    }

    fn check(&self, outline: &Outline<'_>) -> Result<(), Refusal> {
        matrix::check("a .dat file for iCub", (6, 6), outline)
    }

    fn write(&self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        let calibration = export.calibration;
        let axes = calibration.axes.iter().zip(&calibration.full_scale);
        let rows: Vec<_> = matrix::rows(calibration).zip(axes).collect();
        let board_rows = || rows[3..].iter().chain(&rows[..3]);
        let whole = |full_scale: f64| full_scale.ceil().max(1.0);
        for (row, (axis, full_scale)) in board_rows() {
            for value in *row {
                let fraction = value * LARGEST_COUNT / whole(**full_scale);
                if !(-1.0..=1.0).contains(&fraction) {
                    return Err(io::Error::other(OutOfFraction {
                        axis: axis.symbol(),
                        fraction,
                    }));
                }
                let bits = (fraction * ONE).round().min(ONE - 1.0) as i16;
                write!(out, "{bits:04x}\r\n")?;
            }
        }
        write!(out, "1\r\n")?;
        for (_, (_, full_scale)) in board_rows() {
            write!(out, "{}\r\n", whole(**full_scale))?;
        }
        Ok(())
    }
}

/// A coefficient that the board cannot hold.
#[derive(Debug, thiserror::Error)]
#[error(
    "a coefficient of {axis} is {fraction:.3} of full scale where the board holds -1 to 1; fit to gauges in counts of the board \
     (-32768 to 32767), or give a larger --full-scale"
)]
struct OutOfFraction {
    axis: &'static str,
    fraction: f64,
}

/// `.xml`.
pub(super) struct Secondary;

impl Target for Secondary {
    fn name(&self) -> &'static str {
        "iCub/YARP secondary calibration (XML)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["xml"]
    }

    fn holds(&self) -> &'static str {
        "the conventional matrix of six gauges and six axes"
    }

    fn leaves_out(&self, _calibration: &Calibration) -> &'static str {
        matrix::LEFT_OUT
    }

    fn caution(&self, calibration: &Calibration) -> Option<String> {
        matrix::leaves_out(calibration)
    }

    fn check(&self, outline: &Outline<'_>) -> Result<(), Refusal> {
        matrix::check("an .xml file for iCub", (6, 6), outline)
    }

    /// The parameter has the name of the file.
    fn write(&self, export: &Export<'_>, out: &mut dyn io::Write) -> io::Result<()> {
        writeln!(out, "<!--")?;
        for (name, text) in &export.facts {
            writeln!(out, "  {name}: {}", for_xml_comment(text))?;
        }
        if let Some(offsets) = matrix::offsets(export.calibration) {
            writeln!(
                out,
                "  offset left out, in N and N-m: {}",
                for_xml_comment(&offsets)
            )?;
        }
        writeln!(out, "-->\n<group name=\"FT_SECONDARY_CALIBRATION\">")?;
        let rows = matrix::rows(export.calibration).map(|row| {
            let values: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
            values.join(",")
        });
        writeln!(
            out,
            "  <param name=\"{}\">({})</param>\n</group>",
            for_xml(export.name),
            rows.collect::<Vec<_>>().join(",\n    ")
        )
    }
}
