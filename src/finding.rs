//! What the program tells its user beside numbers: what was seen, what it does to the calibration, what to do.
//!
//! Guarantees: what a finding does and what to do about it are worded here, once, in words of the matter; [`Way`] adds how the command line
//! or the window does it. What was seen is worded where it is found.

use std::cmp::Reverse;
use std::fmt;

use serde::ser::{Serialize, SerializeStruct as _, Serializer};
use strum::IntoStaticStr;

use crate::shown::first_clauses;

/// Maximum number of findings of one kind that are listed.
const LISTED: usize = 4;

/// What findings make of a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing speaks against it.
    Enough,
    /// It may do, and there is something to know.
    Doubtful,
    /// The coefficients say more about noise than about the sensor.
    Insufficient,
}

impl Verdict {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Enough => "Enough: the data carry the model",
            Self::Doubtful => "Doubtful: the data carry the model only in part",
            Self::Insufficient => "Not enough: the data do not carry the model",
        }
    }
}

/// Where a finding is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// In a terminal, or in the JSON that is printed there.
    CommandLine,
    /// In the window.
    Window,
    /// On a page, by somebody who need not have the program.
    Page,
}

/// How a face does what a finding asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Recordings get other roles.
    Roles,
    /// Recordings are grouped.
    Groups,
    /// Auxiliary channels are used.
    Auxiliary,
    /// Columns get other roles.
    Columns,
    /// Features are appended or left out.
    Features,
    /// The ridge is set.
    Ridge,
    /// The regressor is chosen.
    Regressor,
    /// Faulty samples are left out.
    Faulty,
    /// A recording is tared.
    Tare,
    /// A mass hangs on an arm.
    Arm,
    /// The clocks of two files are brought together.
    ClockOffset,
    /// A file is written over.
    Replace,
}

impl Way {
    /// In the words of the command line and of the window.
    fn words(self) -> [&'static str; 2] {
        match self {
            Self::Roles => ["--train, --test or --split", "press its role, or Split"],
            Self::Groups => ["--group", "press its group"],
            Self::Auxiliary => ["--auxiliary", "Settings, Auxiliary channels"],
            Self::Columns => [
                "`loopscope inspect FILE --write-map MAP.json`, then `--columns MAP.json`",
                "File > Import",
            ],
            Self::Features => ["--polynomial, --play and others", "Settings"],
            Self::Ridge => ["--ridge", "Settings, Ridge"],
            Self::Regressor => ["--regressor", "Settings, Regressor"],
            Self::Faulty => ["--leave-out-faulty", "Leave out"],
            Self::Tare => ["e.g. --tare 0:1.5", "right-click the recording"],
            Self::Arm => ["--arm", "Hanging mass"],
            Self::ClockOffset => [
                "`loopscope inspect FILE` estimates it; \"clock_offset_secs\" under \"join\" in the column map",
                "File > Import estimates it",
            ],
            Self::Replace => ["--force", "Replace"],
        }
    }
}

/// A text that asks for something, which each face does in its own way.
pub trait Advice: fmt::Display {
    /// How it is done.
    fn ways(&self) -> &'static [Way];

    /// Returns the text, with how this face does what it asks for.
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
    match ways.is_empty() {
        true => text,
        false => format!("{text} ({})", ways.join("; ")),
    }
}

/// One thing to know beside the scores.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Which.
    pub id: Id,
    /// What it makes of the verdict at least.
    pub severity: Verdict,
    /// What was seen and where, in a few words.
    pub seen: String,
    /// The figures beside it; empty where there are none.
    pub figures: String,
    /// Share of full scale by which it makes errors larger, or of the loads or samples that it concerns; 0 if unknown.
    pub cost: f64,
}

impl Finding {
    /// What was seen, in a few words.
    pub(crate) fn new(id: Id, severity: Verdict, seen: impl Into<String>) -> Self {
        Self { id, severity, seen: seen.into(), figures: String::new(), cost: 0.0 }
    }

    /// This with its figures.
    pub(crate) fn with(self, figures: impl Into<String>) -> Self {
        Self { figures: figures.into(), ..self }
    }

    /// This with its cost.
    pub(crate) fn costing(self, cost: f64) -> Self {
        Self { cost, ..self }
    }

    /// Returns findings in the order in which they are read: faults of recordings, then the gravest, then the dearest. Findings
    /// of one kind become one.
    pub(crate) fn ordered(found: Vec<Self>) -> Vec<Self> {
        let mut all: Vec<Vec<Self>> = Vec::new();
        for own in found {
            match all.iter_mut().find(|of| of[0].id == own.id && of[0].severity == own.severity) {
                Some(of) => of.push(own),
                None => all.push(vec![own]),
            }
        }
        let mut merged: Vec<Self> = all.into_iter().map(Self::merged).collect();
        merged.sort_by(|a, b| {
            let key = |own: &Self| {
                (!(own.severity > Verdict::Enough && own.id.is_cause()), Reverse(own.severity))
            };
            key(a).cmp(&key(b)).then(b.cost.total_cmp(&a.cost))
        });
        merged
    }

    fn merged(mut own: Vec<Self>) -> Self {
        own.sort_by(|a, b| b.cost.total_cmp(&a.cost));
        if own.len() == 1 {
            return own.remove(0);
        }
        let seen = own.iter().map(|own| match own.figures.is_empty() {
            true => own.seen.clone(),
            false => format!("{} ({})", own.seen, own.figures),
        });
        let seen = first_clauses(LISTED, seen.collect::<Vec<_>>());
        Self { seen, figures: String::new(), ..own.remove(0) }
    }

    /// A whole sentence without its full stop.
    pub fn text(&self, face: Face) -> String {
        let (_, then, ways) = self.id.words();
        let mut text = self.seen.clone();
        if !self.figures.is_empty() {
            text += &format!(" ({})", self.figures);
        }
        if !then.is_empty() {
            text += &format!(": {then}");
        }
        with_ways(text, ways, face)
    }
}

impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut found = serializer.serialize_struct("Finding", 5)?;
        found.serialize_field("id", <&str>::from(self.id))?;
        found.serialize_field("about", self.id.words().0)?;
        found.serialize_field("verdict", &self.severity)?;
        found.serialize_field("cost", &self.cost)?;
        found.serialize_field("text", &self.text(Face::CommandLine))?;
        found.end()
    }
}

/// What findings there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr)]
#[cfg_attr(test, derive(strum::EnumIter))]
#[strum(serialize_all = "snake_case")]
#[expect(missing_docs, reason = "what each means is worded below")]
pub enum Id {
    NoTest,
    NoTimes,
    Undetermined,
    NotLeftOut,
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
    LinearAlone,
    UnusedAuxiliary,
    NoAuxiliary,
    AuxiliaryBeyond,
    AuxiliaryLeft,
    NoGauge,
    TareChanged,
    ZerosDrift,
    GaugeChanged,
    AllGaugesChanged,
    ReferenceScale,
    FrameTurned,
    ColumnsSwapped,
    Odd,
    Noisy,
    Hum,
    Bent,
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
    FewDirections,
    MovesTogether,
    NotReached,
    LinearOnly,
    Unreached,
}

impl Id {
    /// Whether it is something wrong with recordings, rather than what that makes of errors and coefficients.
    pub(crate) fn is_cause(self) -> bool {
        matches!(
            self.words().0,
            "files" | "rig" | "lag" | "odd" | "no_gauge" | "faults" | "repeated"
        )
    }

    /// What it is about, in a word that stays the same; what was seen does this to the calibration, and what to do; how to do it.
    fn words(self) -> (&'static str, &'static str, &'static [Way]) {
        match self {
            Self::NoTest => (
                "test",
                "nothing but cross-validation says how the calibration does on recordings it never saw; keep one out of the \
                 fit, or split the recordings in time",
                &[Way::Roles],
            ),
            Self::NoTimes => (
                "times",
                "look-backs and all else of the past are off, whatever the settings say, and cross-validation leaves out whole \
                 load cases, never a row beside its repeats",
                &[],
            ),
            Self::Undetermined => (
                "samples",
                "the fit can go through every one of them, so its training error says nothing; record more, or take fewer \
                 gauges and features",
                &[Way::Features],
            ),
            Self::NotLeftOut => ("cross_validation", "", &[]),
            Self::FewRecordings => (
                "groups",
                "contiguous blocks take turns in cross-validation, and each knows the same run from its neighbours, so the \
                 error on another run can be far larger; record more",
                &[],
            ),
            Self::FewGroups => (
                "groups",
                "they are too few to leave out in turn, so recordings are left out one by one, each known from those that \
                 repeat it, and the cross-validation error flatters; record more, or set the groups",
                &[Way::Groups],
            ),
            Self::UnusedLoneGroup => (
                "groups",
                "recordings are left out one by one rather than by group, and each is known from those that repeat it; load \
                 this axis in others, too, or set the groups",
                &[Way::Groups],
            ),
            Self::LoneGroup => (
                "groups",
                "left out, it is predicted by fits that never saw such loads; load this axis in others, too, or group otherwise",
                &[Way::Groups],
            ),
            Self::Still => (
                "still",
                "whatever the errors of this axis are, they say nothing of a load on it; record loads on it, or leave its \
                 column out",
                &[Way::Columns],
            ),
            Self::OutsideTrained => (
                "outside",
                "the test error there is that of an extrapolation; train on such loads, or test within",
                &[],
            ),
            Self::FewLoads => (
                "load_cases",
                "many fits do as well on these loads, and differ on others; record more loads, or take fewer features or a ridge",
                &[Way::Features, Way::Ridge],
            ),
            Self::Rank => (
                "undetermined",
                "some gauges or features repeat each other, or the past sample never differs from the present one; leave such \
                 gauges or features out",
                &[Way::Features],
            ),
            Self::WeakestKernelRidge => (
                "regressor",
                "left-out parts ask for a weaker one than keeps its weights small, so it may do worse on other data than its \
                 scores say; look at test recordings, or take fewer features",
                &[Way::Features],
            ),
            Self::StrongestKernelRidge => (
                "regressor",
                "left-out parts learn next to nothing from the kernel; take another regressor",
                &[Way::Regressor],
            ),
            Self::LinearAlone => (
                "regressor",
                "on left-out samples it is not surely better there, so the linear part stands alone; a \
                 linear calibration is as good, or record more",
                &[Way::Regressor],
            ),
            Self::UnusedAuxiliary => ("undetermined", "", &[]),
            Self::NoAuxiliary => ("undetermined", "say which is one", &[Way::Columns]),
            Self::AuxiliaryBeyond => {
                ("undetermined", "the effect is carried on in a straight line there", &[])
            }
            Self::AuxiliaryLeft => (
                "auxiliary",
                "the model does not use what changed meanwhile; where the sensor depends on it, add the auxiliary channels",
                &[Way::Auxiliary],
            ),
            Self::NoGauge => (
                "no_gauge",
                "no gauge of a sensor does so, and the sensor in use will not have such a column; give it another role",
                &[Way::Columns],
            ),
            Self::TareChanged => (
                "rig",
                "the fit takes the mean of both zeros; tare each recording, or leave out those before or after",
                &[Way::Tare, Way::Roles],
            ),
            Self::ZerosDrift => (
                "rig",
                "the fit takes the mean of the zeros; tare each recording, or let the sensor warm up",
                &[Way::Tare],
            ),
            Self::GaugeChanged => (
                "rig",
                "look at this gauge, its cable and its amplifier, or take the recordings out of training",
                &[Way::Roles],
            ),
            Self::AllGaugesChanged => (
                "rig",
                "look at the gain and the supply of the amplifier, and at the unit of the reference",
                &[Way::Columns, Way::Roles],
            ),
            Self::ReferenceScale => (
                "rig",
                "look at the unit and the sign of the reference's columns",
                &[Way::Columns, Way::Roles],
            ),
            Self::FrameTurned => (
                "rig",
                "look at how sensor and reference were mounted, or take the recording out of training",
                &[Way::Roles],
            ),
            Self::ColumnsSwapped => {
                ("rig", "give the columns their roles in this recording", &[Way::Columns])
            }
            Self::Noisy => (
                "rig",
                "the fit weighs this recording like the others; look at cables, shields and supply, or take it out of training",
                &[Way::Roles],
            ),
            Self::Hum => (
                "rig",
                "it adds to every error; look at shields, grounds and the logger's filter, and record again",
                &[],
            ),
            Self::Bent => (
                "rig",
                "the matrix takes it for a straight line, and errs most at large loads; look whether its amplifier or its mounting \
                 yields, take a smaller gain, or add a polynomial",
                &[Way::Features],
            ),
            Self::ReferenceClipped => (
                "rig",
                "the fit makes these loads too small; take a larger range of the reference, or leave such samples out",
                &[],
            ),
            Self::Lag => (
                "lag",
                "a time lag is not hysteresis, and thresholds or play radii fitted to it describe a filter. If stamps are late, set the clock \
                 offset in the import; if the sensor is slow, add a fixed lag to the features, which the exported code then needs too; \
                 else use a logger that samples both at once",
                &[Way::Columns],
            ),
            Self::SameSamples => (
                "repeated",
                "left out, it is predicted by itself, so the errors flatter; take one of them away",
                &[Way::Roles],
            ),
            Self::OneSided => (
                "reach",
                "the calibration is not shown to hold for the other way; record loads that way, or enter what is rated that way",
                &[],
            ),
            Self::OneAxisAtATime => {
                ("reach", "the expected error says nothing of combined loads; record some", &[])
            }
            Self::OneProgramme => (
                "reach",
                "the expected error says nothing of another programme, above all with a past; record another one",
                &[],
            ),
            Self::Odd => (
                "odd",
                "another mounting or sensor, a wrong or late reference, a gauge that changed, or loads of another kind; look at \
                 it, or take it out of training",
                &[Way::Roles],
            ),
            Self::Faults => (
                "faults",
                "the fit follows them; leave such samples out, load less, or take a smaller gain",
                &[Way::Faulty],
            ),
            Self::Unusable => {
                ("files", "left out of this check; mend or remove it before you calibrate", &[])
            }
            Self::WorseOnTest => (
                "error",
                "compensating does harm there; take fewer features, a ridge, or more kinds of motion to train on",
                &[Way::Features, Way::Ridge],
            ),
            Self::NoBetterThanMean => ("error", "no better than a guess", &[]),
            Self::LargerLeftOut => ("error_ratio", "", &[]),
            Self::FewDirections => (
                "correlation",
                "what the matrix says there is not of these loads; load these axes one without the other",
                &[],
            ),
            Self::MovesTogether => (
                "correlation",
                "what the gauges make of one can hardly be told from what they make of the other; load one without the other, \
                 with a mass on another arm for instance",
                &[],
            ),
            Self::NotReached => {
                ("reach", "beyond that the matrix extrapolates; record larger loads", &[])
            }
            Self::LinearOnly => (
                "regressor",
                "what a network or a kernel learns beside it has more freedom still, which cross-validation alone can judge",
                &[],
            ),
            Self::Unreached => (
                "next",
                "no proposed load tells of them; take other masses, or a mass on an arm",
                &[Way::Arm],
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator as _;

    use super::*;

    /// Words that only one of the faces knows.
    const OF_THE_COMMAND_LINE: [&str; 2] = ["--", "column map"];
    const OF_THE_WINDOW: [&str; 6] =
        ["click", "press ", "window", "Settings", "File >", "Hanging mass"];

    #[test]
    fn no_finding_names_what_another_face_does() {
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
