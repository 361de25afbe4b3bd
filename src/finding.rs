//! Findings: sentences that the program shows beside its results. Each names an observation, its effect on the calibration,
//! and a remedy.
//!
//! Guarantees: effect and remedy of each kind of finding are worded here, once. [`Way`] names the option or the control by
//! which the user applies the remedy. The code that makes an observation also words it.

use std::cmp::Reverse;
use std::fmt;
use std::path::PathBuf;

use serde::ser::{Serialize, SerializeStruct as _, Serializer};
use strum::IntoStaticStr;

use crate::shown::{first, first_clauses};

/// Maximum number of observations that are listed in one finding. Further observations are only counted.
const LISTED: usize = 4;

/// Verdict on the recordings of a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// No problem was found.
    Enough,
    /// At least one problem was found, but the calibration may be usable.
    Doubtful,
    /// The coefficients depend more on noise than on the sensor.
    Insufficient,
}

impl Verdict {
    /// Returns the verdict in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Enough => "Enough: the recordings determine the model",
            Self::Doubtful => {
                "Doubtful: the findings limit where the model holds, or how accurate it is"
            }
            Self::Insufficient => "Not enough: these recordings do not give a usable model",
        }
    }
}

/// Place where a finding is shown, which decides how its remedy is described.
#[derive(Clone, Copy, Debug)]
pub enum Face {
    /// Output of the command line: text or JSON.
    CommandLine,
    /// The window of the program.
    Window,
    /// A report, whose readers may not have the program.
    Page,
}

/// Option of the command line, and control of the window, by which the user applies a remedy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// Changes the roles of recordings, such as training and test.
    Roles,
    /// Assigns recordings to groups, which cross-validation leaves out as a whole.
    Groups,
    /// Uses auxiliary channels, such as a temperature, in the fit.
    Auxiliary,
    /// Changes the roles of a file's columns, such as gauge, load and time.
    Columns,
    /// Adds features to the fit, or removes them.
    Features,
    /// Sets the ridge, the penalty on coefficients of features.
    Ridge,
    /// Chooses the regressor, which computes the load: linear, a network, a kernel, or a linear part plus one of these.
    Regressor,
    /// Excludes faulty samples from the fit.
    Faulty,
    /// Tares a recording: subtracts the gauge values without load.
    Tare,
    /// Corrects the offset between the clocks of two files.
    ClockOffset,
    /// Overwrites an existing file.
    Replace,
}

impl Way {
    fn words(self) -> [&'static str; 2] {
        match self {
            Self::Roles => {
                ["--train, --test or --split", "press the role of a recording, or Split"]
            }
            Self::Groups => ["--group", "press the group of a recording"],
            Self::Auxiliary => ["--auxiliary", "Settings, Auxiliary channels"],
            Self::Columns => [
                "`loopscope inspect FILE --write-map MAP.json`, then `--columns MAP.json`",
                "File > Import",
            ],
            Self::Features => ["--polynomial, --play and other options for features", "Settings"],
            Self::Ridge => ["--ridge", "Settings, Ridge"],
            Self::Regressor => ["--regressor", "Settings, Regressor"],
            Self::Faulty => ["--leave-out-faulty", "Leave out faulty samples"],
            Self::Tare => {
                ["--tare auto, or --tare FROM:TO in seconds", "right-click the recording"]
            }
            Self::ClockOffset => [
                "`loopscope inspect FILE` estimates it; \"clock_offset_secs\" under \"join\" in the column map",
                "File > Import estimates it",
            ],
            Self::Replace => ["--force", "Replace"],
        }
    }
}

/// Message that proposes a remedy.
pub trait Advice: fmt::Display {
    /// Returns the ways by which the user applies the remedy.
    fn ways(&self) -> &'static [Way];

    /// Returns the message, followed in parentheses by the options or controls that apply the remedy at this place.
    fn text(&self, face: Face) -> String {
        with_ways(self.to_string(), self.ways(), face)
    }
}

fn with_ways(text: String, ways: &[Way], face: Face) -> String {
    let ways: Vec<&str> = match face {
        Face::CommandLine => ways.iter().map(|way| way.words()[0]).collect(),
        Face::Window => ways.iter().map(|way| way.words()[1]).collect(),
        Face::Page => return text,
    };
    if ways.is_empty() { text } else { format!("{text} ({})", ways.join("; ")) }
}

/// Place in a file where something was found. Lines are counted from 1.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Place {
    /// Path of the file.
    pub path: PathBuf,
    /// First line of the file that the finding is about.
    pub first_line: u64,
    /// Last line of the file that the finding is about.
    pub last_line: u64,
    /// Number of lines or values that the finding is about.
    pub count: u64,
}

/// Observation with its effect on the calibration, and a remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Kind of the finding, which determines effect and remedy.
    pub id: Id,
    /// Best verdict on the recordings that is possible with this finding.
    pub severity: Verdict,
    /// Observation in a few words, with which the sentence of the finding begins.
    pub seen: String,
    /// Place in a file; `None` if the finding is not about lines of a file.
    pub place: Option<Place>,
    /// Numbers of the observation, shown in parentheses; may be empty.
    pub figures: String,
    /// Size of the effect, by which findings are ordered: increase of errors as a share of full scale, or share of the loads
    /// or samples concerned; 0 if unknown.
    pub cost: f64,
    /// Numbers of the observations, for JSON. A joined finding has one entry for each observation that has numbers.
    pub facts: Vec<serde_json::Value>,
}

impl Finding {
    pub(crate) fn new(id: Id, severity: Verdict, seen: impl Into<String>) -> Self {
        let (figures, facts) = (String::new(), Vec::new());
        Self { id, severity, seen: seen.into(), place: None, figures, cost: 0.0, facts }
    }

    pub(crate) fn with(self, figures: impl Into<String>) -> Self {
        Self { figures: figures.into(), ..self }
    }

    pub(crate) fn costing(self, cost: f64) -> Self {
        Self { cost, ..self }
    }

    pub(crate) fn facts(self, facts: Vec<serde_json::Value>) -> Self {
        Self { facts, ..self }
    }

    /// Joins findings of one kind and severity, and orders the results. Faults of recordings come first, then the others,
    /// both by severity and by size of the effect.
    pub(crate) fn ordered(found: Vec<Self>) -> Vec<Self> {
        let mut all: Vec<Vec<Self>> = Vec::new();
        for finding in found {
            let is_alike = |alike: &&mut Vec<Self>| {
                alike[0].id == finding.id && alike[0].severity == finding.severity
            };
            match all.iter_mut().find(is_alike) {
                Some(alike) => alike.push(finding),
                None => all.push(vec![finding]),
            }
        }
        let mut merged: Vec<Self> = all.into_iter().map(Self::merged).collect();
        merged.sort_by(|a, b| {
            let key = |finding: &Self| {
                let is_fault = finding.severity > Verdict::Enough && finding.id.is_cause();
                (!is_fault, Reverse(finding.severity))
            };
            key(a).cmp(&key(b)).then(b.cost.total_cmp(&a.cost))
        });
        merged
    }

    /// Joins findings that say the same about several files. The first finding then names the other files.
    pub(crate) fn by_file(found: Vec<Self>) -> Vec<Self> {
        let mut all: Vec<(Self, Vec<String>)> = Vec::new();
        for finding in found {
            let is_same = |(other, _): &&mut (Self, Vec<String>)| {
                other.place.is_some() && (&other.seen, other.id) == (&finding.seen, finding.id)
            };
            match (all.iter_mut().find(is_same), &finding.place) {
                (Some((_, files)), Some(place)) => files.push(place.path.display().to_string()),
                _ => all.push((finding, Vec::new())),
            }
        }
        let named = |(finding, files): (Self, Vec<String>)| {
            if files.is_empty() {
                finding
            } else {
                finding.with(format!("also in {}", first(LISTED, files)))
            }
        };
        all.into_iter().map(named).collect()
    }

    /// Joins the observations of findings of one kind and severity in one finding. The observation with the largest effect
    /// comes first.
    fn merged(mut found: Vec<Self>) -> Self {
        found.sort_by(|a, b| b.cost.total_cmp(&a.cost));
        if found.len() == 1 {
            return found.remove(0);
        }
        let seen = first_clauses(LISTED, found.iter().map(Self::observation).collect::<Vec<_>>());
        let facts = found.iter().flat_map(|own| own.facts.clone()).collect();
        Self { seen, figures: String::new(), facts, ..found.remove(0) }
    }

    fn observation(&self) -> String {
        let mut text = self.seen.clone();
        if !self.figures.is_empty() {
            text += &format!(" ({})", self.figures);
        }
        match &self.place {
            Some(Place { path, first_line, last_line, count }) => {
                let times = format!(" ({count} times, last on line {last_line})");
                let times = if *count > 1 { &*times } else { "" };
                format!("{}, line {first_line}: {text}{times}", path.display())
            }
            None => text,
        }
    }

    /// Returns the finding as a sentence without full stop.
    pub fn text(&self, face: Face) -> String {
        let (_, then, ways) = self.id.words();
        let mut text = self.observation();
        if !then.is_empty() {
            text += &format!(": {then}");
        }
        with_ways(text, ways, face)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(Face::Page))
    }
}

impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut found = serializer.serialize_struct("Finding", 7)?;
        found.serialize_field("id", <&str>::from(self.id))?;
        found.serialize_field("about", self.id.words().0)?;
        found.serialize_field("verdict", &self.severity)?;
        found.serialize_field("cost", &self.cost)?;
        found.serialize_field("place", &self.place)?;
        found.serialize_field("facts", &self.facts)?;
        found.serialize_field("text", &self.text(Face::CommandLine))?;
        found.end()
    }
}

/// Kinds of findings.
#[derive(Clone, Copy, Debug, PartialEq, IntoStaticStr)]
#[cfg_attr(test, derive(strum::EnumIter))]
#[strum(serialize_all = "snake_case")]
#[expect(missing_docs, reason = "`Id::words` states the meaning of each kind")]
pub enum Id {
    RowsSkipped,
    PartsIgnored,
    Assumed,
    Stamps,
    Values,
    WithoutReference,
    NoFullScale,
    BeyondFullScale,
    SmallCycle,
    LagInLoop,
    NoTest,
    NoTimes,
    Undetermined,
    NoCrossValidation,
    FewRecordings,
    FewGroups,
    UnusedLoneGroup,
    LoneGroup,
    Still,
    OutsideTrained,
    FewLoads,
    Rank,
    WeakestKernelRidge,
    StrongestKernelRidge,
    UnknownState,
    ColdStart,
    LinearAlone,
    UnusedAuxiliary,
    NoAuxiliary,
    AuxiliaryBeyond,
    AuxiliaryLeft,
    NoGauge,
    TareChanged,
    ReferenceZero,
    ZerosDrift,
    DriftWithin,
    ZeroJumped,
    Mountings,
    GaugeChanged,
    OneDisagrees,
    AllGaugesChanged,
    ReferenceScale,
    FrameTurned,
    ColumnsSwapped,
    ReferenceClipped,
    Lag,
    SameSamples,
    OneSided,
    OneAxisAtATime,
    OneProgramme,
    Faults,
    Unusable,
    WorseOnTest,
    NoBetterThanMean,
    LargerLeftOut,
    MovesTogether,
    NotReached,
    LinearOnly,
    Simulated,
    NoLookBack,
    TaredUnderLoad,
}

impl Id {
    /// Returns true if this kind of finding is a fault of recordings, and false if it is about errors, coefficients or
    /// figures.
    pub fn is_cause(self) -> bool {
        matches!(self.words().0, "files" | "rig" | "lag" | "no_gauge" | "faults" | "repeated")
    }

    /// Returns the category of this kind of finding for JSON, its text of effect and remedy, and the ways to apply the
    /// remedy.
    fn words(self) -> (&'static str, &'static str, &'static [Way]) {
        use Way::{Auxiliary, Columns, Faulty, Features, Groups, Regressor, Ridge, Roles, Tare};
        match self {
            Self::RowsSkipped | Self::PartsIgnored | Self::Stamps | Self::Values => {
                ("file", "", &[])
            }
            Self::Assumed => ("file", "", &[Columns]),
            Self::WithoutReference => {
                ("figures", "errors and hysteresis are measured without these recordings", &[])
            }
            Self::NoFullScale => (
                "figures",
                "enter the rated load of the axis; without it, figures in percent of full scale are unknown",
                &[],
            ),
            Self::BeyondFullScale => (
                "figures",
                "figures in percent of full scale may be too large; enter the rated load of this axis",
                &[],
            ),
            Self::SmallCycle => (
                "figures",
                "the hysteresis figures describe only this small cycle; record one run over the whole range of the axis and back",
                &[],
            ),
            Self::LagInLoop => (
                "figures",
                "this part of the loop's width is no hysteresis; correct a late clock in the import, or use a fixed lag or a faster amplifier for a slow sensor",
                &[],
            ),
            Self::NoTest => (
                "test",
                "only cross-validation estimates the error on other recordings; use one recording, or the end of one, as a test",
                &[Roles],
            ),
            Self::NoTimes => (
                "times",
                "features with memory need loads that change in time and are not used",
                &[],
            ),
            Self::Undetermined => (
                "samples",
                "the fit can match each sample exactly, so its error says nothing; record more loads, or use fewer gauges and features",
                &[Features],
            ),
            Self::NoCrossValidation => ("cross_validation", "", &[]),
            Self::FewRecordings => (
                "groups",
                "cross-validation leaves out parts of a recording, which resemble its other parts, so its error may be far too small; record more recordings",
                &[],
            ),
            Self::FewGroups | Self::UnusedLoneGroup => (
                "groups",
                "repeats of a left-out recording stay in the fit, so the cross-validation error is too small; record more groups, load each axis in several groups, or set the groups",
                &[Groups],
            ),
            Self::LoneGroup => (
                "groups",
                "without this group, the fits of cross-validation have no load on the axis; load this axis in other groups too, or change the groups",
                &[Groups],
            ),
            Self::Still => (
                "still",
                "the errors of this axis do not apply to other loads; record loads on the axis, or remove its column",
                &[Columns],
            ),
            Self::OutsideTrained => (
                "outside",
                "the calibration extrapolates, so the test error is larger; use these loads for training too, or test smaller loads",
                &[],
            ),
            Self::FewLoads => (
                "load_cases",
                "calibrations that agree on these few loads can differ on others; record more loads, use fewer features, or use a ridge",
                &[Features, Ridge],
            ),
            Self::Rank => (
                "undetermined",
                "some gauges or features repeat each other, or the look-back finds no different sample; remove these gauges or features",
                &[Features],
            ),
            Self::WeakestKernelRidge => (
                "regressor",
                "the kernel may follow noise; check the errors on test recordings, or use fewer features",
                &[Features],
            ),
            Self::StrongestKernelRidge => (
                "regressor",
                "the kernel hardly reduces the error; use another regressor",
                &[Regressor],
            ),
            Self::UnknownState => (
                "cold_start",
                "until the gauge has moved by twice the radius, the play operator adds nothing; use a smaller radius, or record larger movements",
                &[Features],
            ),
            Self::ColdStart => (
                "cold_start",
                "earlier samples are missing after a start; ignore the first loads after it, or use features with a shorter memory",
                &[Features],
            ),
            Self::LinearAlone => (
                "regressor",
                "the network or kernel does not reduce the error there; use a linear calibration, or record more",
                &[Regressor],
            ),
            Self::UnusedAuxiliary => ("undetermined", "", &[]),
            Self::NoAuxiliary => (
                "undetermined",
                "the fit uses no auxiliary channel; give the columns of auxiliary channels this role",
                &[Columns],
            ),
            Self::AuxiliaryBeyond => {
                ("undetermined", "the effect of the channel is extrapolated linearly", &[])
            }
            Self::AuxiliaryLeft => (
                "auxiliary",
                "these channels changed; add them if the sensor depends on them",
                &[Auxiliary],
            ),
            Self::NoGauge => (
                "no_gauge",
                "check the cable of the gauge, or give its column another role",
                &[Columns],
            ),
            Self::TareChanged => (
                "rig",
                "tare sensor and reference before each recording, or exclude the recordings before or after the change",
                &[Tare, Roles],
            ),
            Self::ReferenceZero => (
                "rig",
                "the gauges agree with each other, so their tare does not help; set the reference to zero without load before each recording, or exclude the recordings before or after the change",
                &[Roles],
            ),
            Self::ZerosDrift => ("rig", "tare each recording, or let the sensor warm up", &[Tare]),
            Self::DriftWithin => (
                "rig",
                "the drift is an error of the loads; let the sensor warm up, record a temperature, or tare before each use",
                &[Auxiliary],
            ),
            Self::ZeroJumped => (
                "rig",
                "check screws, connectors and cables, and split the recording at this time or exclude one part",
                &[Roles],
            ),
            Self::Mountings => (
                "rig",
                "the difference is an error of the loads; subtract the unloaded gauge values of each mounting from its rows",
                &[],
            ),
            Self::GaugeChanged => (
                "rig",
                "check this gauge, its cable and its amplifier, or exclude the recordings from training",
                &[Roles],
            ),
            Self::OneDisagrees => (
                "rig",
                "compare its clock, the point and the units of its reference, and its kind of loading with the others; exclude it from training if one of them is wrong",
                &[Roles],
            ),
            Self::AllGaugesChanged => (
                "rig",
                "check the gain and the supply of the amplifier, and the unit of the reference columns",
                &[Columns, Roles],
            ),
            Self::ReferenceScale => {
                ("rig", "check the unit and the sign of the reference's columns", &[Columns, Roles])
            }
            Self::FrameTurned => (
                "rig",
                "check the mounting of sensor and reference, or exclude the recording from training",
                &[Roles],
            ),
            Self::ColumnsSwapped => {
                ("rig", "correct the roles of the columns in this recording", &[Columns])
            }
            Self::ReferenceClipped => (
                "rig",
                "the fit underestimates loads beyond the limit of the reference; use a reference with a larger range, or exclude these samples",
                &[],
            ),
            Self::Lag => (
                "lag",
                "thresholds and play radii would describe the lag as hysteresis; set the clock offset in the import if the time stamps are late, or add a fixed lag if the sensor is slow",
                &[Columns],
            ),
            Self::SameSamples => (
                "repeated",
                "each is predicted by a fit to its copy, so the errors are too small; keep only one of the copies",
                &[Roles],
            ),
            Self::OneSided => (
                "reach",
                "the errors do not apply to loads in the other direction; record such loads, or enter the rated load of the axis",
                &[],
            ),
            Self::OneAxisAtATime => (
                "reach",
                "the expected error does not apply to combined loads; record combined loads",
                &[],
            ),
            Self::OneProgramme => (
                "reach",
                "the expected error does not apply to other sequences of loads; record another one",
                &[],
            ),
            Self::Faults => (
                "faults",
                "faulty samples distort the fit; exclude them, reduce the load, or use a smaller gain",
                &[Faulty],
            ),
            Self::Unusable => (
                "files",
                "this check leaves the file out; correct or remove it before you calibrate",
                &[],
            ),
            Self::WorseOnTest => (
                "error",
                "use fewer features, a ridge, or more kinds of motion for training",
                &[Features, Ridge],
            ),
            Self::NoBetterThanMean => (
                "error",
                "the calibration is hardly more accurate than always reporting the mean load",
                &[],
            ),
            Self::LargerLeftOut => ("error_ratio", "", &[]),
            Self::MovesTogether => (
                "correlation",
                "the effects of these axes are hard to separate; load each axis without the others, for example with a mass on another arm",
                &[],
            ),
            Self::NotReached => {
                ("reach", "for larger loads the calibration extrapolates; record larger loads", &[])
            }
            Self::LinearOnly => {
                ("regressor", "only its cross-validation error can assess a network or kernel", &[])
            }
            Self::Simulated => ("origin", "", &[]),
            Self::NoLookBack => ("thresholds", "", &[]),
            Self::TaredUnderLoad => (
                "tare",
                "the tare subtracts the effect of this load; tare over a time without load",
                &[Tare],
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator as _;

    use super::*;

    /// Words that belong to only one of command line and window.
    const OF_THE_COMMAND_LINE: [&str; 2] = ["--", "column map"];
    const OF_THE_WINDOW: [&str; 5] = ["click", "press ", "window", "Settings", "File >"];

    #[test]
    fn equal_findings_about_several_files_are_joined() {
        let of = |path: &str, seen: &str| {
            let place = Place { path: path.into(), first_line: 3, last_line: 3, count: 1 };
            Finding { place: Some(place), ..Finding::new(Id::Simulated, Verdict::Enough, seen) }
        };
        let found = [of("a.csv", "one"), of("b.csv", "one"), of("b.csv", "two")].to_vec();
        let found = Finding::by_file(found);
        let texts: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(texts, ["a.csv, line 3: one (also in b.csv)", "b.csv, line 3: two"]);
    }

    #[test]
    fn no_finding_mentions_controls_of_another_face() {
        for id in Id::iter() {
            let found = Finding::new(id, Verdict::Doubtful, "seen").with("1 N");
            let [command_line, window, page] =
                [Face::CommandLine, Face::Window, Face::Page].map(|face| found.text(face));
            assert!(
                !OF_THE_WINDOW.iter().any(|word| command_line.contains(word)),
                "{command_line}"
            );
            assert!(!OF_THE_COMMAND_LINE.iter().any(|word| window.contains(word)), "{window}");
            let all = OF_THE_COMMAND_LINE.iter().chain(&OF_THE_WINDOW);
            assert!(!all.clone().any(|word| page.contains(word)), "{page}");
            assert!(page.starts_with("seen (1 N)") && !page.ends_with('.'), "{page}");
            let has_ways = !id.words().2.is_empty();
            assert_eq!((command_line != page, window != page), (has_ways, has_ways), "{id:?}");
        }
    }
}
