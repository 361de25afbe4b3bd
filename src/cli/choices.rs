//! Command-line arguments for features and regressor, which several jobs share.

use std::collections::BTreeMap;
use std::str::FromStr;

use clap::builder::TypedValueParser;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use super::{
    messages::Messages,
    reading::Rated,
    values::{List, one_of},
};
use crate::{
    calibration::{
        CONSTANT_RATE, CROSS_VALIDATE, DECIMATION, EARLY_STOPPING, EPOCHS, FitSettings, LANDMARKS,
        Learner, OFFSET, RIDGE, Regressor, RidgeChoice, SEED, UNITS,
    },
    features::{
        BLOCKS, Block, Blocks, Distance, F_TH, FeatureSettings, HISTORY_RATE, Range, Setting, T_TH,
        Thresholds, listed,
    },
    recording::RecordingSet,
};

const HEADING: &str = "Features";
const REGRESSOR_HEADING: &str = "Regressor";

/// Command-line options that are made from a list of settings: those of the learners, or those of the feature blocks.
#[derive(Debug)]
struct FromList<const OF_LEARNERS: bool>(ArgMatches);

impl<const OF_LEARNERS: bool> Args for FromList<OF_LEARNERS> {
    fn augment_args(command: Command) -> Command {
        if OF_LEARNERS {
            command.args(LEARNER_SETTINGS.iter().map(OfLearner::argument))
        } else {
            command.args(BLOCKS.iter().map(|block| block_argument(*block)))
        }
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const OF_LEARNERS: bool> FromArgMatches for FromList<OF_LEARNERS> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(matches.clone()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.0 = matches.clone();
        Ok(())
    }
}

fn block_argument(block: &'static dyn Block) -> Arg {
    let setting = block.setting();
    let argument = described(setting, HEADING);
    if setting.choices().is_some() {
        let placeholder = setting.unit.placeholders[0];
        return argument.value_name(placeholder).value_parser(clap::value_parser!(u8));
    }
    let default = listed(setting.default, ",");
    argument
        .help(format!("{} [if the option is given without numbers: {default}]", setting.help()))
        .value_name(setting.unit.placeholders[1])
        .value_parser(List::from_str)
        .num_args(0..=1)
}

impl FromList<false> {
    /// Returns the feature blocks that the user named, even to switch them off, with their values.
    fn named(&self) -> impl Iterator<Item = (&'static dyn Block, Vec<f64>)> {
        let named =
            BLOCKS.iter().filter(|block| self.0.value_source(block.setting().option).is_some());
        named.map(|block| {
            let setting = block.setting();
            let values = match setting.choices() {
                Some(_) => self.0.get_one(setting.option).map(|n: &u8| vec![f64::from(*n)]),
                None => self.0.get_one(setting.option).map(|List(list)| list.clone()),
            };
            (*block, values.unwrap_or_else(|| setting.default.to_vec()))
        })
    }
}

/// Setting of the network or the kernel: a whole number, or a switch (1 is on).
#[derive(Debug)]
struct OfLearner {
    setting: &'static Setting,
    learner: Learner,
    set: fn(&mut FitSettings, u64),
}

static LEARNER_SETTINGS: [OfLearner; 7] = [
    of_network(&UNITS, |settings, n| settings.network.hidden.fill(n as usize)),
    of_network(&EPOCHS, |settings, n| settings.network.epochs = n as usize),
    of_network(&SEED, |settings, seed| settings.network.seed = seed),
    of_network(&CONSTANT_RATE, |settings, on| settings.network.constant_rate = on == 1),
    of_network(&EARLY_STOPPING, |settings, on| settings.network.early_stopping = on == 1),
    of_network(&CROSS_VALIDATE, |settings, on| settings.network.cross_validate = on == 1),
    OfLearner {
        setting: &LANDMARKS,
        learner: Learner::Kernel,
        set: |settings, n| settings.kernel.landmarks = n as usize,
    },
];

const fn of_network(setting: &'static Setting, set: fn(&mut FitSettings, u64)) -> OfLearner {
    OfLearner { setting, learner: Learner::Network, set }
}

impl OfLearner {
    fn argument(&self) -> Arg {
        let setting = self.setting;
        let argument = described(setting, REGRESSOR_HEADING);
        match (setting.range, setting.number() > 0.0) {
            (Range::Switch, is_on) => {
                let without = if is_on { "Train without: " } else { "" };
                let help = format!("{without}{}", setting.help());
                argument.help(help).action(ArgAction::SetTrue)
            }
            _ => argument
                .help(with_default(setting))
                .value_name(setting.unit.placeholders[0])
                .value_parser(clap::value_parser!(u64)),
        }
    }

    /// Returns the value that the user gave on the command line.
    fn given(&self, matches: &ArgMatches) -> Option<u64> {
        let setting = self.setting;
        match setting.range {
            Range::Switch => {
                matches.get_flag(setting.option).then_some(1 - setting.number() as u64)
            }
            _ => matches.get_one(setting.option).copied(),
        }
    }
}

/// Returns a command-line argument with the option name and the help text of a setting.
fn described(setting: &'static Setting, heading: &'static str) -> Arg {
    Arg::new(setting.option)
        .long(setting.option)
        .help(setting.help())
        .allow_negative_numbers(!matches!(setting.range, Range::Switch))
        .help_heading(heading)
}

/// Command-line arguments that do not depend on the model.
#[derive(Debug, Args)]
pub struct CommonArgs {
    /// Measure of the distance between two loads, and unit of the force threshold F_th. Recordings without a force axis
    /// always use full-scale.
    #[arg(long, value_parser = distance(), default_value = Distance::Force.option(), help_heading = HEADING)]
    pub distance: Distance,
    /// Full scale (rated load) of each axis in N and N·m, in axis order [default: half the peak-to-peak reference of the training
    /// recordings, or its largest magnitude for an axis that is loaded in one direction only].
    #[arg(long, value_name = "FS,…", allow_negative_numbers = true)]
    pub full_scale: Option<List>,
    #[arg(long = OFFSET.option, help = format!("Switch off: {}", OFFSET.help()))]
    pub no_offset: bool,
    #[arg(long = HISTORY_RATE.option, help = HISTORY_RATE.help(), value_name = HISTORY_RATE.unit.placeholders[0],
        allow_negative_numbers = true, help_heading = HEADING)]
    history_rate: Option<f64>,
    #[arg(long = DECIMATION.option, help = with_default(&DECIMATION), value_name = "N", allow_negative_numbers = true)]
    pub decimate: Option<usize>,
}

impl CommonArgs {
    pub fn rated(&self) -> Rated {
        let full_scale = self.full_scale.iter().flat_map(|list| &list.0).copied().collect();
        Rated { full_scale, ..Rated::default() }
    }

    /// Returns the settings of a conventional calibration that is fitted to these recordings.
    pub fn settings(&self, recordings: &RecordingSet) -> FitSettings {
        let full_scale = self.full_scale.iter().flat_map(|list| &list.0);
        FitSettings {
            features: FeatureSettings {
                distance: self.distance.effective(&recordings.layout().axes),
                ..FeatureSettings::present()
            },
            offset: !self.no_offset,
            decimation: self.decimate.unwrap_or(FitSettings::default().decimation),
            history_rate_hz: self.history_rate,
            full_scale: full_scale.copied().map(Some).collect(),
            ..FitSettings::default()
        }
    }
}

/// Command-line arguments for features other than look-backs, and for the linear fit.
///
/// All named features are used together. A feature that is not named is not used.
#[derive(Debug, Args)]
pub struct BlockArgs {
    #[command(flatten)]
    blocks: FromList<false>,
    #[command(flatten)]
    pub common: CommonArgs,
    #[arg(long = RIDGE.option, help = with_default(&RIDGE), value_name = RIDGE.unit.placeholders[0], value_parser = ridge, allow_negative_numbers = true, help_heading = REGRESSOR_HEADING)]
    pub ridge: Option<RidgeChoice>,
    /// Reference value of an auxiliary channel, as in T=22, at which the exported matrix and offset hold. Repeat the option for each
    /// channel [default: the mean of the channel in the training recordings].
    #[arg(long, value_name = "NAME=VALUE", value_parser = auxiliary_reference, help_heading = HEADING)]
    auxiliary_reference: Vec<(String, f64)>,
}

fn auxiliary_reference(text: &str) -> Result<(String, f64), String> {
    let parts = text.rsplit_once('=').and_then(|(name, value)| {
        let value: f64 = value.trim().parse().ok()?;
        let name = name.trim();
        (!name.is_empty() && value.is_finite()).then(|| (name.to_owned(), value))
    });
    parts.ok_or_else(|| format!("{text:?} is not NAME=VALUE, as in T=22"))
}

impl BlockArgs {
    fn auxiliary_references(
        &self,
        say: &Messages,
        recordings: &RecordingSet,
    ) -> BTreeMap<String, f64> {
        let names = recordings.entries().first();
        let names = names.map_or(&[][..], |entry| entry.recording.auxiliary().names());
        let given = &self.auxiliary_reference;
        for (name, _) in given.iter().filter(|(name, _)| !names.contains(name)) {
            let known = match names {
                [] => "the recordings have no auxiliary channel".to_owned(),
                names => format!("the recordings have the channels {}", names.join(" ")),
            };
            say.note(format_args!(
                "--auxiliary-reference {name}: no auxiliary channel has this name; {known}"
            ));
        }
        given.iter().cloned().collect()
    }

    /// Returns the settings of a linear fit to these recordings, without a look-back.
    pub fn settings(&self, say: &Messages, recordings: &RecordingSet) -> FitSettings {
        let common = self.common.settings(recordings);
        let mut blocks = Blocks::default();
        self.blocks.named().for_each(|(block, values)| blocks.set(block, values));
        FitSettings {
            features: FeatureSettings { blocks, ..common.features },
            ridge: self.ridge.unwrap_or_default(),
            auxiliary_references: self.auxiliary_references(say, recordings),
            ..common
        }
    }
}

/// Command-line arguments for features and regressor of one fit.
///
/// All named features are used together. Without any named feature, one look-back is used.
#[derive(Debug, Args)]
pub struct ModelArgs {
    #[arg(
        long = F_TH.option,
        help = f_th_help(),
        value_name = F_TH.unit.placeholders[0],
        allow_negative_numbers = true,
        conflicts_with = "look_back",
        value_parser = one_f_th,
        help_heading = HEADING
    )]
    f_th: Option<f64>,
    #[arg(
        long = T_TH.option,
        help = with_default(&T_TH),
        value_name = T_TH.unit.placeholders[0],
        allow_negative_numbers = true,
        help_heading = HEADING
    )]
    t_th: Option<f64>,
    /// Force thresholds F_th of several look-backs, separated by commas; "none" for no look-back.
    #[arg(
        long,
        value_name = "F,…",
        value_parser = look_backs,
        allow_negative_numbers = true,
        help_heading = HEADING
    )]
    look_back: Option<List>,
    #[command(flatten)]
    blocks: BlockArgs,
    #[command(flatten)]
    learners: FromList<true>,
    /// Kind of model that computes the load from the features.
    #[arg(long, value_parser = regressor(), default_value = Regressor::Linear.key(), help_heading = REGRESSOR_HEADING)]
    regressor: Regressor,
}

fn with_default(setting: &Setting) -> String {
    format!("{} [default: {}]", setting.help(), setting.number())
}

fn f_th_help() -> String {
    let [newtons, share] = Distance::ALL.map(|distance| Thresholds::default_for(distance).f_th);
    format!(
        "{} [in newtons, or with --distance full-scale as a share of full scale (0.1 is 10 %); default: {newtons} N, or {share} of full scale]",
        F_TH.help()
    )
}

fn one_f_th(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| {
        let hint = if text.contains(',') {
            format!(
                "; write decimals with a point, or use --look-back {text} for several look-backs"
            )
        } else {
            String::new()
        };
        format!("this is not a number{hint}")
    })
}

fn look_backs(text: &str) -> Result<List, String> {
    if text == "none" {
        return Ok(List(Vec::new()));
    }
    text.parse().map_err(|error| format!("{error}, or \"none\""))
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

impl ModelArgs {
    pub fn rated(&self) -> Rated {
        self.blocks.common.rated()
    }

    pub fn settings(&self, say: &Messages, recordings: &RecordingSet) -> FitSettings {
        let regressor = self.regressor;
        let mut settings = FitSettings { regressor, ..self.blocks.settings(say, recordings) };
        for choice in &LEARNER_SETTINGS {
            let Some(value) = choice.given(&self.learners.0) else { continue };
            (choice.set)(&mut settings, value);
            if regressor.learner() != Some(choice.learner) {
                let (option, key) = (choice.setting.option, regressor.key());
                say.note(format_args!("--{option} has no effect with --regressor {key}"));
            }
        }
        settings.features.look_backs = self.look_backs(settings.features.distance);
        settings
    }

    fn look_backs(&self, distance: Distance) -> Vec<Thresholds> {
        let default = Thresholds::default_for(distance);
        let t_th_secs = self.t_th.unwrap_or(default.t_th_secs);
        let f_ths = match (&self.look_back, self.f_th) {
            (Some(List(values)), _) => values.clone(),
            (None, Some(f_th)) => vec![f_th],
            (None, None) if self.t_th.is_some() || self.blocks.blocks.named().next().is_none() => {
                vec![default.f_th]
            }
            (None, None) => Vec::new(),
        };
        let thresholds = f_ths.into_iter();
        thresholds.map(|f_th| Thresholds { f_th, t_th_secs }).collect()
    }
}

/// Returns the arguments with which `loopscope fit` uses these settings.
pub fn fit_arguments(settings: &FitSettings) -> String {
    let default = FitSettings::default();
    let features = &settings.features;
    let mut words = Vec::new();
    let mut option = |name: &str, value: String| words.push(format!("--{name} {value}"));
    match &features.look_backs[..] {
        [] => option("look-back", "none".to_owned()),
        [first, ..] => {
            let f_ths: Vec<f64> =
                features.look_backs.iter().map(|look_back| look_back.f_th).collect();
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
    match settings.regressor.learner() {
        Some(Learner::Network) => {
            option(EPOCHS.option, settings.network.epochs.to_string());
            if let Some(units) = settings.network.hidden.first() {
                option(UNITS.option, units.to_string());
            }
        }
        Some(Learner::Kernel) => option(LANDMARKS.option, settings.kernel.landmarks.to_string()),
        None => {}
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
    if let Some(rate_hz) = settings.history_rate_hz {
        option(HISTORY_RATE.option, rate_hz.to_string());
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

pub fn regressor() -> impl TypedValueParser<Value = Regressor> {
    one_of(Regressor::ALL.map(|regressor| (regressor, regressor.key(), regressor.explanation())))
}

fn distance() -> impl TypedValueParser<Value = Distance> {
    one_of(Distance::ALL.map(|distance| (distance, distance.option(), distance.explanation())))
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
        choices: ModelArgs,
    }

    fn features(arguments: &[&str]) -> FeatureSettings {
        let arguments = [&["x"], arguments].concat();
        let only = Only::parse_from(arguments);
        let recordings = simulated::recordings(1);
        only.choices.settings(&Messages::default(), &recordings).features
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
        assert!(look_backs("nope").is_err());
        assert!(ridge("much").is_err());
        assert_eq!(ridge("auto"), Ok(RidgeChoice::Auto));
    }

    /// The guide must list the settings exactly as the program does.
    #[test]
    fn the_guide_lists_every_setting_and_the_method_every_block() {
        let blocks = BLOCKS.iter().map(|block| block.setting());
        let learning = LEARNER_SETTINGS.iter().map(|choice| choice.setting);
        let rows = [&F_TH, &T_TH].into_iter().chain(blocks).chain([&RIDGE]).chain(learning);
        let rows = rows.chain([&OFFSET, &DECIMATION, &HISTORY_RATE]);
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
            let option = format!("[--{} {values}]", setting.option);
            assert!(readme.contains(&option), "README.md does not contain {option}");
        }
    }
}
