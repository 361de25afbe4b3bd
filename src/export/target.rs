//! Interface of the formats of calibration files. A calibration that a format cannot hold is refused before a byte is
//! written. A file that holds only a part of the calibration lists the omitted parts.

use std::error::Error;
use std::io;

use super::facts::{Fact, facts};
use crate::{
    calibration::{Calibration, FitSettings},
    features::FeatureSettings,
    recording::{Axis, Layout},
};

/// Reason why a calibration cannot be written in a format, or why a file is not a calibration.
pub type Refusal = Box<dyn Error + Send + Sync>;

/// Reads a calibration from the content of a file, with notes for the user.
pub type ReadBack = fn(&[u8]) -> Result<(Calibration, Vec<String>), Refusal>;

/// A format of calibration files. All formats are listed in [`TARGETS`](super::TARGETS).
pub struct Target {
    pub name: &'static str,
    /// What people need the file for, as the list of the window names it.
    pub purpose: &'static str,
    /// File name endings, in lower case and without the dot; the usual one first.
    pub endings: &'static [&'static str],
    pub holds: &'static str,
    pub leaves_out: fn(&Calibration) -> &'static str,
    /// Returns a warning, shown before writing, if the file gives other loads than this program shows. The text names the
    /// parts that the file omits.
    pub caution: fn(&Calibration) -> Option<String>,
    /// Returns the reason why the format cannot hold a calibration with this outline, and what to do instead.
    pub refusal: fn(&Outline<'_>) -> Option<String>,
    /// Writes a calibration that was checked for this format.
    pub write: fn(&Export<'_>, &mut dyn io::Write) -> io::Result<()>,
    pub reader: Option<ReadBack>,
    /// True if the files contain the names of the gauges. Otherwise gauges are identified by their order.
    pub names_gauges: bool,
    pub parts: fn(&Calibration) -> [Held; 4],
}

/// What a file has of one of the [`PARTS`] of a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    Whole,
    LeftOut,
    /// The calibration, or the kind of file, has no such part.
    NoPart,
}

/// Parts of a calibration whose absence from a file matters to a user.
pub const PARTS: [&str; 4] = ["compensation", "offset", "names", "self-test"];

/// Returns the parts of a file that leaves nothing out and has no self-test.
pub(super) fn all_parts(calibration: &Calibration) -> [Held; 4] {
    let held = |is_there: bool| if is_there { Held::Whole } else { Held::NoPart };
    [held(is_compensated(calibration)), held(calibration.offset), Held::Whole, Held::NoPart]
}

/// Returns the parts of a file of matrices, which cannot hold a network or kernel.
pub(super) fn linear_parts(calibration: &Calibration) -> [Held; 4] {
    let [compensation, offset, names, test] = all_parts(calibration);
    let compensation = calibration.learned.as_ref().map_or(compensation, |_| Held::LeftOut);
    [compensation, offset, names, test]
}

/// Returns true if the compensated load differs from the conventional load.
pub(super) fn is_compensated(calibration: &Calibration) -> bool {
    calibration.learned.is_some()
        || calibration.columns().len() > calibration.conventional.columns.len()
}

impl Target {
    /// Defaults of an export format: it leaves nothing out, accepts every calibration, and cannot be read back. Each format
    /// replaces what is different.
    pub(super) const PLAIN: Self = Self {
        name: "",
        purpose: "",
        endings: &[],
        holds: "",
        leaves_out: |_| "nothing",
        caution: |_| None,
        refusal: |_| None,
        write: |_, _| Ok(()),
        reader: None,
        names_gauges: true,
        parts: all_parts,
    };
}

/// Properties of a calibration that are known before the fit.
#[derive(Clone, Copy, Debug)]
pub struct Outline<'a> {
    pub n_gauges: usize,
    pub axes: &'a [Axis],
    pub features: &'a FeatureSettings,
}

impl<'a> Outline<'a> {
    pub fn of(calibration: &'a Calibration) -> Self {
        Self {
            n_gauges: calibration.gauges.len(),
            axes: &calibration.axes,
            features: &calibration.features,
        }
    }

    pub fn of_fit(settings: &'a FitSettings, layout: &'a Layout) -> Self {
        Self {
            n_gauges: layout.gauge_names.len(),
            axes: &layout.axes,
            features: &settings.features,
        }
    }
}

/// Calibration that was checked for its format and is written to a file, with the texts for the file.
#[derive(Debug)]
pub struct Export<'a> {
    /// The whole calibration, even if the format holds only a part.
    pub calibration: &'a Calibration,
    pub(super) facts: Vec<Fact>,
    /// Name of the calibration, from which the names inside the file are made.
    pub name: &'a str,
}

impl Export<'_> {
    /// Returns the facts about the calibration, one line each. `shown` escapes texts for the file.
    pub(super) fn lines<'s>(
        &'s self,
        shown: impl Fn(&str) -> String + 's,
    ) -> impl Iterator<Item = String> + 's {
        self.facts.iter().map(move |(name, text)| format!("{name}: {}", shown(text)))
    }
}

/// Checks that the format can hold a calibration, and returns it for writing. The names inside the file are made from `name`.
pub(super) fn of_target<'a>(
    target: &Target,
    calibration: &'a Calibration,
    name: &'a str,
) -> io::Result<Export<'a>> {
    calibration.validate().map_err(io::Error::other)?;
    if let Some(refusal) = (target.refusal)(&Outline::of(calibration)) {
        return Err(io::Error::other(refusal));
    }
    let facts = facts(calibration, target.holds, (target.leaves_out)(calibration));
    Ok(Export { calibration, facts, name })
}
