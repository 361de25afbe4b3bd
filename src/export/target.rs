//! What a format is that calibrations are written in.
//!
//! Guarantees: what a format cannot carry at all is refused before a byte is written; what it carries in part says so inside.

use std::error::Error;
use std::io;

use super::facts::{Fact, facts};
use crate::calibration::{Calibration, FitSettings};
use crate::features::FeatureSettings;
use crate::recording::{Axis, Layout};

/// Why a calibration cannot be written in a format, or what a file holds is none.
pub type Refusal = Box<dyn Error + Send + Sync>;

/// Makes a calibration of what is in a file, with what its user must know of it.
pub type ReadBack = fn(&[u8]) -> Result<(Calibration, Vec<String>), Refusal>;

/// A format that calibrations are written in. All of them stand in [`TARGETS`](super::TARGETS).
pub struct Target {
    /// What people call it.
    pub name: &'static str,
    /// The endings of its files, in small letters and without the dot; the usual one first.
    pub endings: &'static [&'static str],
    /// What its files hold of a calibration.
    pub holds: &'static str,
    /// What a file leaves out of a calibration.
    pub leaves_out: fn(&Calibration) -> &'static str,
    /// What is to be told before a file of a calibration is written: that whoever loads it gets other loads than this program
    /// shows. It follows "leaves out".
    pub caution: fn(&Calibration) -> Option<String>,
    /// Checks whether the format can carry what is outlined; the refusal says what to do instead.
    pub check: fn(&Outline<'_>) -> Result<(), Refusal>,
    /// Writes a calibration that was checked.
    pub write: fn(&Export<'_>, &mut dyn io::Write) -> io::Result<()>,
    /// What reads its files back, where something does.
    pub reader: Option<ReadBack>,
    /// Whether its files name the gauges; where they do not, gauges are known by their order.
    pub names_gauges: bool,
}

impl Target {
    /// A format that leaves out nothing, carries every calibration and is not read back.
    pub(super) const PLAIN: Self = Self {
        name: "",
        endings: &[],
        holds: "",
        leaves_out: |_| "nothing",
        caution: |_| None,
        check: |_| Ok(()),
        write: |_, _| Ok(()),
        reader: None,
        names_gauges: true,
    };
}

/// What a calibration is made of, as far as it is known before the fit.
#[derive(Clone, Copy, Debug)]
pub struct Outline<'a> {
    pub n_gauges: usize,
    pub axes: &'a [Axis],
    pub features: &'a FeatureSettings,
}

impl<'a> Outline<'a> {
    /// Of a calibration that is there.
    pub fn of(calibration: &'a Calibration) -> Self {
        Self {
            n_gauges: calibration.gauges.len(),
            axes: &calibration.axes,
            features: &calibration.features,
        }
    }

    /// Of what these settings will make of recordings of this layout.
    pub fn of_fit(settings: &'a FitSettings, layout: &'a Layout) -> Self {
        Self {
            n_gauges: layout.gauge_names.len(),
            axes: &layout.axes,
            features: &settings.features,
        }
    }
}

/// What is written.
#[derive(Debug)]
pub struct Export<'a> {
    /// The whole calibration.
    pub calibration: &'a Calibration,
    /// What the file says of itself.
    pub(super) facts: Vec<Fact>,
    /// What names inside are made of.
    pub name: &'a str,
}

impl Export<'_> {
    /// What the file says of itself, a line each; `shown` makes texts harmless where they stand.
    pub(super) fn lines<'s>(
        &'s self,
        shown: impl Fn(&str) -> String + 's,
    ) -> impl Iterator<Item = String> + 's {
        let facts = self.facts.iter();
        facts.map(move |(name, text)| format!("{name}: {}", shown(text)))
    }
}

/// Checks the calibration for a format that is to write it; `name` is what names inside are made of.
pub(super) fn of_target<'a>(
    target: &Target,
    calibration: &'a Calibration,
    name: &'a str,
) -> io::Result<Export<'a>> {
    calibration.validate().map_err(io::Error::other)?;
    let outline = Outline::of(calibration);
    (target.check)(&outline).map_err(io::Error::other)?;
    let facts = facts(calibration, target.holds, (target.leaves_out)(calibration));
    Ok(Export { calibration, facts, name })
}
