//! The arguments that several jobs share: which recordings, which blocks, which regressor.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use super::{JobError, ReadArgs, check_distinct, named_file, read_hearing};
use crate::calibration::{FitSettings, KernelSettings, NetworkSettings, Regressor, RidgeChoice};
use crate::features::{Distance, FeatureSettings, Thresholds};
use crate::import::LoadWarning;
use crate::recording::{Entry, RecordingSet, Role, simulated};

/// Which recordings, in which role.
#[derive(Debug, Args)]
pub struct RecordingArgs {
    #[command(flatten)]
    pub read: ReadArgs,
    /// Recordings to fit; without any, those of the built-in simulated sensor.
    #[arg(long, num_args = 1.., value_name = "FILE", value_parser = named_file())]
    pub train: Vec<PathBuf>,
    /// Recordings to score the fit on.
    #[arg(long, num_args = 1.., value_name = "FILE", requires = "train", value_parser = named_file())]
    pub test: Vec<PathBuf>,
    /// Instead of test files: train on this first part of each recording, test on the rest.
    #[arg(
        long,
        value_name = "FRACTION",
        conflicts_with = "test",
        allow_negative_numbers = true
    )]
    pub split: Option<f64>,
}

impl RecordingArgs {
    /// The files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &PathBuf> {
        let recordings = self.train.iter().chain(&self.test);
        recordings.chain(&self.read.columns)
    }

    /// Reads them; warnings go to standard error.
    pub fn read(&self) -> Result<RecordingSet, JobError> {
        self.read_hearing(&mut |_| {})
    }

    /// [`read`](Self::read), with an ear for the warnings.
    pub fn read_hearing(
        &self,
        hear: &mut dyn FnMut(&LoadWarning),
    ) -> Result<RecordingSet, JobError> {
        check_distinct(self.train.iter().chain(&self.test))?;
        let mut set = RecordingSet::default();
        if self.train.is_empty() {
            let built_in = simulated::recordings(simulated::DEFAULT_SEED);
            for entry in built_in.entries() {
                let recording = self.read.tared((*entry.recording).clone())?;
                set.push(Entry::new(recording, entry.role))?;
            }
        }
        for (files, role) in [(&self.train, Role::Train), (&self.test, Role::Test)] {
            for (path, recordings) in files.iter().zip(read_hearing(files, &self.read, hear)?) {
                for recording in recordings {
                    if !recording.has_reference() {
                        return Err(JobError::NoReference { path: path.clone() });
                    }
                    set.push(Entry::new(recording, role))?;
                }
            }
        }
        match self.split {
            None => Ok(set),
            Some(fraction) => {
                let split = set.split(fraction);
                let tests = split.entries().iter().any(|entry| entry.role == Role::Test);
                if fraction > 0.0 && fraction < 1.0 && tests {
                    Ok(split)
                } else {
                    Err(JobError::Split(fraction))
                }
            }
        }
    }
}

/// Numbers with commas between them.
#[derive(Clone, Debug, PartialEq)]
pub struct List(pub Vec<f64>);

impl FromStr for List {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.split(',')
            .map(|cell| {
                let cell = cell.trim();
                cell.parse().map_err(|_| {
                    format!("{cell:?} is not a number; write numbers with commas between them")
                })
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

/// F_th values, or none at all.
#[derive(Clone, Debug, PartialEq)]
pub struct LookBacks(Vec<f64>);

impl FromStr for LookBacks {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text == "none" {
            return Ok(Self(Vec::new()));
        }
        let List(values) = text
            .parse()
            .map_err(|error| format!("{error}, or \"none\""))?;
        Ok(Self(values))
    }
}

/// What is appended to the gauges beside look-backs, and how the linear fit is made.
///
/// Blocks add up; those that are not named are not used.
#[derive(Debug, Args)]
pub struct BlockArgs {
    /// The gauges so many seconds ago.
    #[arg(
        long,
        value_name = "SECONDS,…",
        allow_negative_numbers = true,
        num_args = 0..=1,
        default_missing_value = "0.5",
        help_heading = "Blocks"
    )]
    pub fixed_lag: Option<List>,
    /// First-order low-passes of the gauges, by time constant.
    #[arg(
        long,
        value_name = "SECONDS,…",
        allow_negative_numbers = true,
        num_args = 0..=1,
        default_missing_value = "1,6,40",
        help_heading = "Blocks"
    )]
    pub creep: Option<List>,
    /// Play operators, by radius in standard deviations of the gauge.
    #[arg(
        long,
        value_name = "SD,…",
        allow_negative_numbers = true,
        num_args = 0..=1,
        default_missing_value = "0.1,0.2,0.4,0.7,1.1,1.6",
        help_heading = "Blocks"
    )]
    pub play: Option<List>,
    /// Memoryless: 2 adds squares and products of the gauges, 3 also cubes.
    #[arg(long, value_name = "DEGREE", help_heading = "Blocks")]
    pub polynomial: Option<u8>,
    /// What F_th is measured in; without a force axis it is full-scale.
    #[arg(long, value_enum, default_value = "force", help_heading = "Blocks")]
    pub distance: Distance,
    /// How much the linear fit shrinks what the blocks append: a number, or "auto": by cross-validation, for each
    /// axis.
    #[arg(long, value_name = "STRENGTH", default_value = "0", value_parser = ridge, allow_negative_numbers = true, help_heading = "Regressor")]
    pub ridge: RidgeChoice,
    /// Full scale of each axis in N and N·m, in axis order; by default half the peak-to-peak training reference.
    #[arg(long, value_name = "FS,…", allow_negative_numbers = true)]
    pub full_scale: Option<List>,
    /// Fit without a constant term, as the paper does.
    #[arg(long)]
    pub no_offset: bool,
}

impl BlockArgs {
    /// Whether no block is named.
    fn is_empty(&self) -> bool {
        self.fixed_lag.is_none()
            && self.creep.is_none()
            && self.play.is_none()
            && self.polynomial.is_none()
    }

    /// What F_th is really measured in.
    fn distance(&self, recordings: &RecordingSet) -> Distance {
        self.distance.effective(&recordings.layout().axes)
    }

    /// The settings of a linear fit that these arguments mean for such recordings, without a look-back.
    pub fn settings(&self, recordings: &RecordingSet, decimation: usize) -> FitSettings {
        let values = |list: &Option<List>| list.as_ref().map_or(Vec::new(), |list| list.0.clone());
        FitSettings {
            features: FeatureSettings {
                look_backs: Vec::new(),
                distance: self.distance(recordings),
                fixed_lags_secs: values(&self.fixed_lag),
                creep_secs: values(&self.creep),
                play_radii: values(&self.play),
                polynomial: self.polynomial.unwrap_or(1),
            },
            ridge: self.ridge,
            offset: !self.no_offset,
            decimation,
            full_scale: values(&self.full_scale).into_iter().map(Some).collect(),
            ..FitSettings::default()
        }
    }
}

/// What is appended to the gauges, and how the load is made of it.
///
/// Blocks add up; those that are not named are not used, except that without any block there is one look-back.
#[derive(Debug, Args)]
pub struct FitChoices {
    /// How much the load must have differed: newtons, or over full scale a share of it (0.1 is 10 %) [default: 3, or
    /// 0.25 of full scale].
    #[arg(
        long,
        value_name = "F",
        allow_negative_numbers = true,
        conflicts_with = "look_back",
        value_parser = one_f_th,
        help_heading = "Blocks"
    )]
    pub f_th: Option<f64>,
    /// How old the past sample may be, in seconds [default: 15].
    #[arg(
        long,
        value_name = "SECONDS",
        allow_negative_numbers = true,
        help_heading = "Blocks"
    )]
    pub t_th: Option<f64>,
    /// Several look-backs at once, one per F_th; "none": no look-back.
    #[arg(
        long,
        value_name = "F,…",
        allow_negative_numbers = true,
        help_heading = "Blocks"
    )]
    pub look_back: Option<LookBacks>,
    #[command(flatten)]
    pub blocks: BlockArgs,
    /// Passes of a network over the training samples.
    #[arg(long, value_name = "N", default_value_t = NetworkSettings::default().epochs, help_heading = "Regressor")]
    pub epochs: usize,
    /// What a network starts from; the same seed gives the same network.
    #[arg(long, value_name = "N", default_value_t = NetworkSettings::default().seed, help_heading = "Regressor")]
    pub seed: u64,
    /// Samples that a kernel compares the others with.
    #[arg(long, value_name = "N", default_value_t = KernelSettings::default().landmarks, help_heading = "Regressor")]
    pub landmarks: usize,
}

fn one_f_th(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| match text.contains(',') {
        true => format!(
            "this is not one number; write decimals with a point, or several look-backs at once as --look-back {text}"
        ),
        false => "this is not a number".to_owned(),
    })
}

fn ridge(text: &str) -> Result<RidgeChoice, String> {
    match text {
        "auto" => Ok(RidgeChoice::Auto),
        number => number
            .parse()
            .map(RidgeChoice::Strength)
            .map_err(|_| format!("{number:?} is neither a number nor \"auto\"")),
    }
}

/// One fit: features, regressor, and which samples it sees.
#[derive(Debug, Args)]
pub struct ModelArgs {
    #[command(flatten)]
    choices: FitChoices,
    /// How the load is made of the features.
    #[arg(long, value_enum, default_value = "linear", help_heading = "Regressor")]
    regressor: Regressor,
    /// Use every N-th sample only.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub decimate: usize,
}

impl ModelArgs {
    /// The settings that these arguments mean for such recordings.
    pub fn settings(&self, recordings: &RecordingSet) -> FitSettings {
        let Self {
            choices,
            regressor,
            decimate,
        } = self;
        choices.settings(recordings, *regressor, *decimate)
    }
}

impl FitChoices {
    /// The settings that these arguments mean for such recordings.
    pub fn settings(
        &self,
        recordings: &RecordingSet,
        regressor: Regressor,
        decimation: usize,
    ) -> FitSettings {
        let mut settings = FitSettings {
            regressor,
            network: NetworkSettings {
                epochs: self.epochs,
                seed: self.seed,
                ..NetworkSettings::default()
            },
            kernel: KernelSettings {
                landmarks: self.landmarks,
                ..KernelSettings::default()
            },
            ..self.blocks.settings(recordings, decimation)
        };
        settings.features.look_backs = self.look_backs(settings.features.distance);
        settings
    }

    fn look_backs(&self, distance: Distance) -> Vec<Thresholds> {
        let default = Thresholds::default_for(distance);
        let t_th_secs = self.t_th.unwrap_or(default.t_th_secs);
        let f_ths = match (&self.look_back, self.f_th) {
            (Some(LookBacks(values)), _) => values.clone(),
            (None, Some(f_th)) => vec![f_th],
            (None, None) if self.t_th.is_some() || self.blocks.is_empty() => vec![default.f_th],
            (None, None) => Vec::new(),
        };
        let thresholds = f_ths.into_iter();
        thresholds
            .map(|f_th| Thresholds { f_th, t_th_secs })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        choices: FitChoices,
    }

    fn features(arguments: &[&str]) -> FeatureSettings {
        let arguments = [&["x"], arguments].concat();
        let only = Only::parse_from(arguments);
        let recordings = simulated::recordings(1);
        only.choices
            .settings(&recordings, Regressor::Linear, 1)
            .features
    }

    #[test]
    fn named_blocks_add_up_and_others_are_not_used() {
        let f_ths = |features: &FeatureSettings| -> Vec<f64> {
            features
                .look_backs
                .iter()
                .map(|look_back| look_back.f_th)
                .collect()
        };
        assert_eq!(features(&[]), FeatureSettings::default());
        assert_eq!(
            features(&["--look-back", "none"]),
            FeatureSettings::present()
        );
        assert_eq!(f_ths(&features(&["--look-back", "3,8"])), [3.0, 8.0]);
        let play = features(&["--play", "0.1, 0.2"]);
        assert_eq!((f_ths(&play), play.play_radii), (vec![], vec![0.1, 0.2]));
        let both = features(&["--t-th", "5", "--creep", "--polynomial", "2"]);
        assert_eq!(f_ths(&both), [3.0]);
        assert_eq!(both.look_backs[0].t_th_secs, 5.0);
        assert_eq!((both.creep_secs.len(), both.polynomial), (3, 2));
    }

    #[test]
    fn a_list_that_is_none_is_refused() {
        assert!("1,x".parse::<List>().unwrap_err().contains("\"x\""));
        assert!("nope".parse::<LookBacks>().is_err());
        assert!(ridge("much").is_err());
        assert_eq!(ridge("auto"), Ok(RidgeChoice::Auto));
    }
}
