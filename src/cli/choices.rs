//! The arguments that several jobs share: which blocks, which regressor.

use std::collections::BTreeMap;
use std::str::FromStr;

use clap::builder::TypedValueParser;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

use super::messages::Messages;
use super::rated::Rated;
use super::values::{List, one_of};
use crate::calibration::{
    CONSTANT_RATE, CROSS_VALIDATE, DECIMATION, EARLY_STOPPING, EPOCHS, FitSettings, KernelSettings,
    LANDMARKS, Learner, NetworkSettings, OFFSET, RIDGE, Regressor, RidgeChoice, SEED,
};
use crate::features::{
    BLOCKS, Blocks, Distance, F_TH, FeatureSettings, HISTORY_RATE, Setting, T_TH, Thresholds,
    listed,
};
use crate::recording::RecordingSet;

/// Under which features stand in `--help`.
const HEADING: &str = "Features";

/// F_th values, or none at all.
#[derive(Clone, Debug, PartialEq)]
pub struct LookBacks(Vec<f64>);

impl FromStr for LookBacks {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text == "none" {
            return Ok(Self(Vec::new()));
        }
        let List(values) = text.parse().map_err(|error| format!("{error}, or \"none\""))?;
        Ok(Self(values))
    }
}

/// The blocks of the list, an option each.
#[derive(Debug)]
struct ListedBlocks {
    blocks: Blocks,
    /// Whether any is named, be it to say that it is not used.
    any_named: bool,
}

impl Args for ListedBlocks {
    fn augment_args(command: Command) -> Command {
        command.args(BLOCKS.iter().map(|block| {
            let setting = block.setting();
            let argument = described(setting, HEADING);
            if setting.choices().is_some() {
                return argument.value_parser(clap::value_parser!(u8));
            }
            let default = listed(setting.default, ",");
            argument
                .help(format!("{} [without numbers: {default}]", setting.help()))
                .value_name(setting.unit.placeholders[1])
                .value_parser(List::from_str)
                .num_args(0..=1)
        }))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for ListedBlocks {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut own = Self { blocks: Blocks::default(), any_named: false };
        own.update_from_arg_matches(matches)?;
        Ok(own)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for &block in BLOCKS {
            let setting = block.setting();
            if matches.value_source(setting.option).is_none() {
                continue;
            }
            let values = match setting.choices() {
                Some(_) => matches.get_one(setting.option).map(|n: &u8| vec![f64::from(*n)]),
                None => matches.get_one(setting.option).map(|List(list)| list.clone()),
            };
            self.any_named = true;
            self.blocks.set(block, values.unwrap_or_else(|| setting.default.to_vec()));
        }
        Ok(())
    }
}

/// An argument with the option, the placeholder and the explanation of a setting.
fn described(setting: &'static Setting, heading: &'static str) -> Arg {
    Arg::new(setting.option)
        .long(setting.option)
        .help(setting.help())
        .value_name(setting.unit.placeholders[0])
        .allow_negative_numbers(true)
        .help_heading(heading)
}

/// What all models of a sensor have in common.
#[derive(Debug, Args)]
pub struct CommonArgs {
    /// What F_th is measured in; without a force axis it is full-scale.
    #[arg(long, value_parser = distance(), default_value = Distance::Force.option(), help_heading = HEADING)]
    pub distance: Distance,
    /// Full scale (rated load) of each axis in N and N·m, in axis order; by default half the peak-to-peak training
    /// reference, or its largest magnitude where it goes one way only.
    #[arg(long, value_name = "FS,…", allow_negative_numbers = true)]
    pub full_scale: Option<List>,
    #[arg(long = OFFSET.option, help = format!("Fit without: {}", OFFSET.help()))]
    pub no_offset: bool,
    #[arg(long = HISTORY_RATE.option, help = HISTORY_RATE.help(), value_name = HISTORY_RATE.unit.placeholders[0],
        default_value_t = HISTORY_RATE.number(), allow_negative_numbers = true, help_heading = HEADING)]
    pub history_rate: f64,
}

impl CommonArgs {
    /// The rated loads.
    pub fn rated(&self) -> Rated {
        Rated::of(self.full_scale.as_ref().map_or(&[], |list| &list.0))
    }

    /// The settings of a conventional calibration that these arguments mean for such recordings.
    pub fn settings(&self, recordings: &RecordingSet, decimation: usize) -> FitSettings {
        let full_scale = self.full_scale.iter().flat_map(|list| &list.0);
        FitSettings {
            features: FeatureSettings {
                distance: self.distance.effective(&recordings.layout().axes),
                ..FeatureSettings::present()
            },
            offset: !self.no_offset,
            decimation,
            history_rate_hz: self.history_rate,
            full_scale: full_scale.copied().map(Some).collect(),
            ..FitSettings::default()
        }
    }
}

/// What is appended to the gauges beside look-backs, and how the linear fit is made.
///
/// Blocks add up; those that are not named are not used.
#[derive(Debug, Args)]
pub struct BlockArgs {
    #[command(flatten)]
    listed: ListedBlocks,
    #[command(flatten)]
    pub common: CommonArgs,
    #[arg(long = RIDGE.option, help = with_default(&RIDGE), value_name = RIDGE.unit.placeholders[0], value_parser = ridge, allow_negative_numbers = true, help_heading = "Regressor")]
    pub ridge: Option<RidgeChoice>,
    /// What the effect of an auxiliary channel counts from, as in T=22; again for each. The gauges' matrix and the offset are those
    /// there [default: the mean over the training recordings].
    #[arg(long, value_name = "NAME=VALUE", help_heading = HEADING)]
    pub auxiliary_reference: Vec<AuxiliaryReference>,
}

/// A channel and what its effect counts from.
#[derive(Clone, Debug)]
pub struct AuxiliaryReference(String, f64);

impl FromStr for AuxiliaryReference {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once('=').and_then(|(name, value)| {
            let value: f64 = value.trim().parse().ok()?;
            let name = name.trim();
            (!name.is_empty() && value.is_finite()).then(|| Self(name.to_owned(), value))
        });
        parts.ok_or_else(|| format!("{text:?} is not NAME=VALUE, as in T=22"))
    }
}

impl BlockArgs {
    fn auxiliary_references(
        &self,
        say: &Messages,
        recordings: &RecordingSet,
    ) -> BTreeMap<String, f64> {
        let names = recordings.entries().first();
        let names = names.map_or(&[][..], |entry| entry.recording.auxiliary().names());
        let given = self.auxiliary_reference.iter();
        for AuxiliaryReference(name, _) in given.clone().filter(|own| !names.contains(&own.0)) {
            let known = match names {
                [] => "there is none".to_owned(),
                names => format!("there are {}", names.join(" ")),
            };
            say.note(format_args!(
                "--auxiliary-reference {name}: no auxiliary channel has this name; {known}"
            ));
        }
        given.map(|AuxiliaryReference(name, value)| (name.clone(), *value)).collect()
    }

    /// The settings of a linear fit that these arguments mean for such recordings, without a look-back.
    pub fn settings(
        &self,
        say: &Messages,
        recordings: &RecordingSet,
        decimation: usize,
    ) -> FitSettings {
        let common = self.common.settings(recordings, decimation);
        FitSettings {
            features: FeatureSettings { blocks: self.listed.blocks.clone(), ..common.features },
            ridge: self.ridge.unwrap_or_default(),
            auxiliary_references: self.auxiliary_references(say, recordings),
            ..common
        }
    }
}

/// What is appended to the gauges, and how the load is made of it.
///
/// Blocks add up; those that are not named are not used, except that without any block there is one look-back.
#[derive(Debug, Args)]
pub struct FitChoices {
    #[arg(
        long = F_TH.option,
        help = f_th_help(),
        value_name = F_TH.unit.placeholders[0],
        allow_negative_numbers = true,
        conflicts_with = "look_back",
        value_parser = one_f_th,
        help_heading = HEADING
    )]
    pub f_th: Option<f64>,
    #[arg(
        long = T_TH.option,
        help = with_default(&T_TH),
        value_name = T_TH.unit.placeholders[0],
        allow_negative_numbers = true,
        help_heading = HEADING
    )]
    pub t_th: Option<f64>,
    /// Several look-backs at once, one per F_th; "none": no look-back.
    #[arg(
        long,
        value_name = "F,…",
        allow_negative_numbers = true,
        help_heading = HEADING
    )]
    pub look_back: Option<LookBacks>,
    #[command(flatten)]
    pub blocks: BlockArgs,
    #[arg(long = EPOCHS.option, help = with_default(&EPOCHS), value_name = "N", help_heading = "Regressor")]
    pub epochs: Option<usize>,
    #[arg(long = SEED.option, help = with_default(&SEED), value_name = "N", help_heading = "Regressor")]
    pub seed: Option<u64>,
    #[arg(long = CONSTANT_RATE.option, help = CONSTANT_RATE.help(), help_heading = "Regressor")]
    pub constant_rate: bool,
    #[arg(long = EARLY_STOPPING.option, help = format!("Train without: {}", EARLY_STOPPING.help()), help_heading = "Regressor")]
    pub no_early_stopping: bool,
    #[arg(long = CROSS_VALIDATE.option, help = CROSS_VALIDATE.help(), help_heading = "Regressor")]
    pub cross_validate: bool,
    #[arg(long = LANDMARKS.option, help = with_default(&LANDMARKS), value_name = "N", help_heading = "Regressor")]
    pub landmarks: Option<usize>,
}

fn with_default(setting: &Setting) -> String {
    format!("{} [default: {}]", setting.help(), setting.number())
}

fn f_th_help() -> String {
    let [newtons, share] = Distance::ALL.map(|distance| Thresholds::default_for(distance).f_th);
    format!(
        "{} [newtons, or over full scale a share of it (0.1 is 10 %); default: {newtons}, or {share} of full scale]",
        F_TH.help()
    )
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
        "by-block" => Ok(RidgeChoice::ByBlock),
        number => number
            .parse()
            .map(RidgeChoice::Strength)
            .map_err(|_| format!("{number:?} is neither a number nor \"auto\" nor \"by-block\"")),
    }
}

/// One fit: features, regressor, and which samples it sees.
#[derive(Debug, Args)]
pub struct ModelArgs {
    #[command(flatten)]
    choices: FitChoices,
    /// How the load is made of the features.
    #[arg(long, value_parser = regressor(), default_value = Regressor::Linear.key(), help_heading = "Regressor")]
    regressor: Regressor,
    #[arg(
        long = DECIMATION.option,
        help = DECIMATION.help(),
        value_name = "N",
        default_value_t = FitSettings::default().decimation,
        allow_negative_numbers = true
    )]
    pub decimate: usize,
}

impl ModelArgs {
    /// The rated loads.
    pub fn rated(&self) -> Rated {
        self.choices.blocks.common.rated()
    }

    /// The settings that these arguments mean for such recordings.
    pub fn settings(&self, say: &Messages, recordings: &RecordingSet) -> FitSettings {
        let learner = self.regressor.learner();
        for (option, of) in self.choices.of_learners() {
            if learner != Some(of) {
                let key = self.regressor.key();
                say.note(format_args!("--{option} does nothing with --regressor {key}"));
            }
        }
        self.choices.settings(say, recordings, self.regressor, self.decimate)
    }
}

impl FitChoices {
    /// The settings that these arguments mean for such recordings.
    pub fn settings(
        &self,
        say: &Messages,
        recordings: &RecordingSet,
        regressor: Regressor,
        decimation: usize,
    ) -> FitSettings {
        let (network, kernel) = (NetworkSettings::default(), KernelSettings::default());
        let mut settings = FitSettings {
            regressor,
            network: NetworkSettings {
                epochs: self.epochs.unwrap_or(network.epochs),
                seed: self.seed.unwrap_or(network.seed),
                constant_rate: self.constant_rate,
                early_stopping: !self.no_early_stopping,
                cross_validate: self.cross_validate,
                ..network
            },
            kernel: KernelSettings {
                landmarks: self.landmarks.unwrap_or(kernel.landmarks),
                ..kernel
            },
            ..self.blocks.settings(say, recordings, decimation)
        };
        settings.features.look_backs = self.look_backs(settings.features.distance);
        settings
    }

    /// Returns the options that were given and the learner that each is for.
    fn of_learners(&self) -> impl Iterator<Item = (&'static str, Learner)> {
        let network = [
            (EPOCHS.option, self.epochs.is_some()),
            (SEED.option, self.seed.is_some()),
            (CONSTANT_RATE.option, self.constant_rate),
            (EARLY_STOPPING.option, self.no_early_stopping),
            (CROSS_VALIDATE.option, self.cross_validate),
        ];
        let network = network.map(|own| (own, Learner::Network));
        let kernel = ((LANDMARKS.option, self.landmarks.is_some()), Learner::Kernel);
        let all = network.into_iter().chain([kernel]);
        all.filter(|((_, is_given), _)| *is_given).map(|((option, _), of)| (option, of))
    }

    fn look_backs(&self, distance: Distance) -> Vec<Thresholds> {
        let default = Thresholds::default_for(distance);
        let t_th_secs = self.t_th.unwrap_or(default.t_th_secs);
        let f_ths = match (&self.look_back, self.f_th) {
            (Some(LookBacks(values)), _) => values.clone(),
            (None, Some(f_th)) => vec![f_th],
            (None, None) if self.t_th.is_some() || !self.blocks.listed.any_named => {
                vec![default.f_th]
            }
            (None, None) => Vec::new(),
        };
        let thresholds = f_ths.into_iter();
        thresholds.map(|f_th| Thresholds { f_th, t_th_secs }).collect()
    }
}

/// The arguments of `fit` that mean these settings for the same recordings.
pub fn fit_arguments(settings: &FitSettings) -> String {
    let default = FitSettings::default();
    let features = &settings.features;
    let mut words = Vec::new();
    let mut option = |name: &str, value: String| words.push(format!("--{name} {value}"));
    match &features.look_backs[..] {
        [] => option("look-back", "none".to_owned()),
        [first, ..] => {
            let f_ths: Vec<f64> = features.look_backs.iter().map(|own| own.f_th).collect();
            option("look-back", listed(&f_ths, ","));
            option(T_TH.option, first.t_th_secs.to_string());
        }
    }
    if features.distance != default.features.distance {
        option("distance", features.distance.option().to_owned());
    }
    for (block, values) in features.blocks.used() {
        option(block.setting().option, listed(values, ","));
    }
    if settings.regressor != default.regressor {
        option("regressor", settings.regressor.key().to_owned());
    }
    if settings.regressor.learner() == Some(Learner::Network) {
        option(EPOCHS.option, settings.network.epochs.to_string());
    }
    match settings.ridge {
        RidgeChoice::Strength(strength) if strength == RIDGE.number() => {}
        RidgeChoice::Strength(strength) => option(RIDGE.option, strength.to_string()),
        RidgeChoice::Auto => option(RIDGE.option, "auto".to_owned()),
        RidgeChoice::ByBlock => option(RIDGE.option, "by-block".to_owned()),
    }
    if settings.decimation != default.decimation {
        option(DECIMATION.option, settings.decimation.to_string());
    }
    if settings.history_rate_hz != default.history_rate_hz {
        option(HISTORY_RATE.option, settings.history_rate_hz.to_string());
    }
    let full_scale: Option<Vec<f64>> = settings.full_scale.iter().copied().collect();
    if let Some(full_scale) = full_scale.filter(|list| !list.is_empty()) {
        option("full-scale", listed(&full_scale, ","));
    }
    for (name, value) in &settings.auxiliary_references {
        option("auxiliary-reference", format!("{name}={value}"));
    }
    if !settings.offset {
        words.push(format!("--{}", OFFSET.option));
    }
    words.join(" ")
}

/// Takes a regressor by its name.
pub fn regressor() -> impl TypedValueParser<Value = Regressor> {
    one_of(Regressor::ALL.map(|own| (own, own.key(), own.explanation())))
}

fn distance() -> impl TypedValueParser<Value = Distance> {
    one_of(Distance::ALL.map(|own| (own, own.option(), own.explanation())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::{Creep, Play, Polynomial};
    use clap::Parser;

    use crate::recording::simulated;

    #[derive(Parser)]
    struct Only {
        #[command(flatten)]
        choices: FitChoices,
    }

    fn features(arguments: &[&str]) -> FeatureSettings {
        let arguments = [&["x"], arguments].concat();
        let only = Only::parse_from(arguments);
        let recordings = simulated::recordings(1);
        only.choices.settings(&Messages::default(), &recordings, Regressor::Linear, 1).features
    }

    #[test]
    fn named_blocks_add_up_and_others_are_not_used() {
        let f_ths = |features: &FeatureSettings| -> Vec<f64> {
            features.look_backs.iter().map(|look_back| look_back.f_th).collect()
        };
        assert_eq!(features(&[]), FeatureSettings::default());
        assert_eq!(features(&["--look-back", "none"]), FeatureSettings::present());
        assert_eq!(f_ths(&features(&["--look-back", "3,8"])), [3.0, 8.0]);
        let play = features(&["--play", "0.1, 0.2"]);
        assert!(play.look_backs.is_empty());
        assert_eq!(play.blocks, Blocks::default().with(&Play, &[0.1, 0.2]));
        let both = features(&["--t-th", "5", "--creep", "--polynomial", "2"]);
        assert_eq!(f_ths(&both), [3.0]);
        assert_eq!(both.look_backs[0].t_th_secs, 5.0);
        assert_eq!(both.blocks.of(&Creep).len(), 3);
        assert_eq!(both.blocks.of(&Polynomial), [2.0]);
    }

    #[test]
    fn a_list_that_is_none_is_refused() {
        assert!("1,x".parse::<List>().unwrap_err().contains("\"x\""));
        assert!("nope".parse::<LookBacks>().is_err());
        assert!(ridge("much").is_err());
        assert_eq!(ridge("auto"), Ok(RidgeChoice::Auto));
    }

    /// What the guide says of the settings is what the program says of them.
    #[test]
    fn the_guide_lists_every_setting_and_the_method_every_block() {
        let blocks = BLOCKS.iter().map(|block| block.setting());
        let others = [
            &RIDGE,
            &EPOCHS,
            &SEED,
            &CONSTANT_RATE,
            &EARLY_STOPPING,
            &CROSS_VALIDATE,
            &LANDMARKS,
            &OFFSET,
            &DECIMATION,
            &HISTORY_RATE,
        ];
        let rows = [&F_TH, &T_TH].into_iter().chain(blocks).chain(others);
        let rows = rows.map(|setting| {
            format!(
                "| `--{}` | {} | {} | {} | {} |\n",
                setting.option,
                setting.label,
                setting.in_words(setting.default),
                setting.range,
                setting.help()
            )
        });
        let head = "| option | setting | default | range | meaning |\n|---|---|---|---|---|\n";
        let table = head.to_owned() + &rows.collect::<String>();
        let page = include_str!("../../assets/guide/command-line.md");
        assert!(page.contains(&table), "the table of command-line.md should be\n{table}");
        let list: String = BLOCKS
            .iter()
            .map(|block| {
                let name = block.name().to_lowercase();
                format!("* **{name}**: {}: `{}`\n", block.setting().help(), block.formula())
            })
            .collect();
        let page = include_str!("../../assets/guide/method.md");
        assert!(page.contains(&list), "the list of method.md should be\n{list}");
        let readme = include_str!("../../README.md");
        for setting in BLOCKS.iter().map(|block| block.setting()) {
            let values = match setting.choices() {
                Some(choices) => {
                    let values = choices[1..].iter().map(|choice| f64::from(choice.value));
                    listed(&values.collect::<Vec<_>>(), "|")
                }
                None => listed(setting.default, ","),
            };
            let said = format!("[--{} {values}]", setting.option);
            assert!(readme.contains(&said), "README.md does not say {said}");
        }
    }
}
