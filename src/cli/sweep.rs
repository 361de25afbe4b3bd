//! `loopscope sweep`: computes the errors at many pairs of force threshold F_th and time threshold t_th, and suggests a pair.

use std::io::{self, Write};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use clap::Args;
use clap::builder::TypedValueParser;
use serde::Serialize;

use super::{
    choices::BlockArgs,
    error::JobError,
    inputs::Files,
    recordings::RecordingArgs,
    run::{Run, Work, examples},
    values::{List, named_file, one_of},
};
use crate::{
    calibration::Scores,
    export::Together,
    features::{BLOCKS, Distance, Setting, Thresholds, listed},
    questions::{
        BlockSuggestion, HistoryBlock, Request, Study,
        thresholds::{
            Along, GridError, Measure, MeasureScale, PastAges, ShownFTh, Suggestion, ThresholdGrid,
            ThresholdMap, even_values, threshold_heat_map, write_threshold_csv,
            write_threshold_svg,
        },
    },
    recording::Axis,
    report::{Cell, Column, Table},
    scoring::{mean_hysteresis::MeanHysteresis, numbers::significant, score_set::ScoreSet},
};

/// Fit a calibration at each pair of force threshold F_th and time threshold t_th, print or draw the errors, and suggest a
/// pair.
#[derive(Debug, Args)]
#[command(after_help = examples(&[
    ("loopscope sweep --train day1.csv day2.csv --f-th 0:10:0.5 --t-th 1,5,15 --svg map.svg", "draws the map of errors over both thresholds"),
]))]
pub struct SweepJob {
    #[command(flatten)]
    recordings: RecordingArgs,
    #[command(flatten)]
    blocks: BlockArgs,
    /// Values of the force threshold F_th to try, as start:stop:step or separated by commas, in newtons or as shares of full
    /// scale [default: even steps up to 1.2 times full scale].
    #[arg(long, value_name = "RANGE", allow_negative_numbers = true)]
    f_th: Option<Values>,
    /// Values of the time threshold t_th to try in seconds, as start:stop:step or separated by commas.
    #[arg(
        long,
        value_name = "RANGE",
        default_value = "1,2,5,10,15,30",
        allow_negative_numbers = true
    )]
    t_th: Values,
    /// Error that the suggested thresholds minimise: of one axis, of all forces, of all moments, or of all axes in percent of full scale
    /// [default: forces, or full-scale without a force axis].
    #[arg(long, value_parser = measure_arg(), value_name = "MEASURE")]
    measure: Option<MeasureArg>,
    /// Also choose the values of these feature blocks by cross-validation. Each block is tried together with the features
    /// that other options set.
    #[arg(long, value_parser = searched_block(), value_delimiter = ',', value_name = "BLOCK,…")]
    pick: Vec<HistoryBlock>,
    /// Write the errors at all pairs of thresholds to this CSV file.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    csv: Option<PathBuf>,
    /// Write the map of the cross-validation error to this SVG file.
    #[arg(long, value_name = "FILE", value_parser = named_file())]
    svg: Option<PathBuf>,
    /// Overwrite existing files.
    #[arg(long)]
    force: bool,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Values {
    Even(f64, f64, f64),
    Listed(Vec<f64>),
}

impl FromStr for Values {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text.trim().is_empty() {
            return Ok(Self::Listed(Vec::new()));
        }
        let is_range = text.contains(':');
        let List(values) = List::split(text, if is_range { ':' } else { ',' })?;
        match values[..] {
            _ if !is_range => Ok(Self::Listed(values)),
            [start, stop, step] => Ok(Self::Even(start, stop, step)),
            _ => Err(format!("{text:?} is not start:stop:step, as in 0:14:0.5")),
        }
    }
}

impl Values {
    fn values(&self, what: &'static str) -> Result<Vec<f64>, GridError> {
        match self {
            Self::Even(start, stop, step) => even_values(what, *start, *stop, *step),
            Self::Listed(values) => Ok(values.clone()),
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum MeasureArg {
    Of(Measure),
    Axis(Axis),
}

fn measure_arg() -> impl TypedValueParser<Value = MeasureArg> {
    let groups = [
        (Measure::Forces, "forces", "Root mean square over the force axes"),
        (Measure::Moments, "moments", "Root mean square over the moment axes"),
        (
            Measure::FullScale,
            "full-scale",
            "Root mean square over all axes in percent of full scale",
        ),
    ];
    let groups = groups.map(|(measure, name, about)| (MeasureArg::Of(measure), name, about));
    let axes = Axis::ALL.into_iter().zip(["fx", "fy", "fz", "mx", "my", "mz"]);
    let axes = axes.map(|(axis, name)| (MeasureArg::Axis(axis), name, axis.symbol()));
    one_of(groups.into_iter().chain(axes))
}

impl MeasureArg {
    fn measure(self, scale: &MeasureScale) -> Result<Measure, JobError> {
        let axis = match self {
            Self::Of(measure) => return Ok(measure),
            Self::Axis(axis) => axis,
        };
        let at = scale.axes.iter().position(|known| *known == axis);
        at.map(Measure::Axis).ok_or_else(|| {
            let (axis, axes) = (axis.symbol(), Axis::symbols(&scale.axes).join(" "));
            JobError::Usage(format!("the recordings have no {axis}; their axes are {axes}"))
        })
    }
}

fn searched_block() -> impl TypedValueParser<Value = HistoryBlock> {
    let blocks = BLOCKS.iter().filter(|block| block.search().is_some());
    one_of(blocks.map(|block| (*block, block.setting().option, block.setting().label)))
}

impl Work for SweepJob {
    fn files(&self) -> Files<'_> {
        self.recordings.files().writing(self.csv.iter().chain(&self.svg), self.force)
    }

    fn run(&self, run: &Run) -> Result<(), JobError> {
        // The thresholds are checked before the files are read, so that an error in them is reported at once.
        let given = self.f_th.as_ref().map(|values| values.values("F_th")).transpose()?;
        let t_ths_secs = self.t_th.values("t_th")?;
        let grid = |f_ths| ThresholdGrid::new(f_ths, t_ths_secs.clone());
        let given = given.map(grid).transpose()?;
        let inputs = self.recordings.read(run, self.blocks.common.rated())?;
        let settings = inputs.rated(self.blocks.settings(&run.say, &inputs.recordings));
        let recordings = inputs.recordings;
        let progress = &run.progress;
        let study = Study::prepare(&Request::fit(Arc::clone(&recordings), settings), progress)?;
        let measure = match self.measure {
            Some(measure) => measure.measure(&study.scale())?,
            None => study.scale().default_measure(),
        };
        let grid = match given {
            Some(grid) => grid,
            None => {
                let covering = ThresholdGrid::covering(study.largest_distance(), DEFAULT_F_THS, 1)?;
                grid(covering.f_ths.to_vec())?
            }
        };
        let map = study.threshold_map(None, &grid, progress, &|_| run.say.show(progress))?;
        let suggestion = map.suggestion(measure)?;
        if let Some(lag) = study.lag(progress)? {
            run.say.finding(lag);
        }
        let pick = |block: &HistoryBlock| study.suggest_block(*block, measure, progress);
        let scale = &map.scale;
        let sweep = Sweep {
            map: &map,
            by: measure,
            simulated: recordings.is_simulated(),
            recordings: recordings.entries().len(),
            n_train: map.n_train,
            n_test: map.n_test,
            axes: Axis::symbols(&scale.axes),
            units: scale.axes.iter().map(|axis| axis.unit()).collect(),
            full_scale: &scale.full_scale,
            distance: map.distance,
            measure: measure.label(scale),
            measure_unit: measure.unit(scale),
            conventional: &map.conventional.scores,
            points: (map.points())
                .map(|(Thresholds { f_th, t_th_secs }, point)| ReportedPoint {
                    f_th,
                    t_th: t_th_secs,
                    scores: &point.scores,
                })
                .collect(),
            mean_hysteresis: study.mean_hysteresis(),
            past_ages: study.past_ages(suggestion.thresholds),
            picks: self.pick.iter().map(pick).collect::<Result<_, _>>()?,
            suggestion,
        };
        let mut files = Together::default();
        if let Some(path) = &self.csv {
            files.write(path, |out| write_threshold_csv(&map, out))?;
        }
        if let Some(path) = &self.svg {
            let found = Some(&sweep.suggestion);
            let picture = threshold_heat_map(&map, ScoreSet::LeftOut, measure, found);
            write_threshold_svg(&picture, path, &mut files)?;
        }
        files.finish()?;
        run.print(self.json, &sweep, |out| print_sweep(&sweep, out))
    }
}

/// Number of nonzero values of the force threshold F_th that are tried by default.
const DEFAULT_F_THS: usize = 29;

#[derive(Serialize)]
struct Sweep<'a> {
    #[serde(skip)]
    map: &'a ThresholdMap,
    /// Error that the suggested thresholds minimise.
    #[serde(skip)]
    by: Measure,
    simulated: bool,
    recordings: usize,
    n_train: u64,
    n_test: u64,
    axes: Vec<&'static str>,
    units: Vec<&'static str>,
    full_scale: &'a [f64],
    distance: Distance,
    measure: &'static str,
    measure_unit: &'static str,
    conventional: &'a Scores,
    points: Vec<ReportedPoint<'a>>,
    suggestion: Suggestion,
    mean_hysteresis: MeanHysteresis,
    /// Ages of the earlier samples that the look-back finds at the suggested thresholds.
    past_ages: PastAges,
    picks: Vec<BlockSuggestion>,
}

#[derive(Serialize)]
struct ReportedPoint<'a> {
    f_th: f64,
    t_th: f64,
    #[serde(flatten)]
    scores: &'a Scores,
}

fn print_sweep(sweep: &Sweep<'_>, out: &mut impl Write) -> io::Result<()> {
    if sweep.simulated {
        writeln!(out, "The built-in simulated sensor")?;
    }
    let Sweep { map, recordings, n_train, n_test, .. } = sweep;
    let (f_ths, t_ths) = (map.grid.f_ths.len(), map.grid.t_ths_secs.len());
    writeln!(
        out,
        "{recordings} recordings, {n_train} training and {n_test} test samples; {f_ths} F_th by {t_ths} t_th"
    )?;
    let mut measures = map.scale.measures();
    measures.retain(|measure| {
        matches!(measure, Measure::Forces | Measure::Moments) || *measure == sweep.by
    });
    for along in [Along::F, Along::T] {
        for &measure in &measures {
            write!(out, "\n{}", curves(sweep, measure, along).text())?;
        }
    }
    let shown = ShownFTh::of(sweep.distance);
    let width = |f_th: f64| format!("{} {}", significant(shown.factor * f_th, 3), shown.unit);
    writeln!(out, "\nThresholds at the {}", sweep.suggestion.in_words(map, sweep.by))?;
    writeln!(out, "  {}", sweep.suggestion.ranges_in_words(sweep.distance))?;
    writeln!(out, "The paper's rule: {}", sweep.mean_hysteresis.in_words(width))?;
    writeln!(out, "At these thresholds, {}", sweep.past_ages)?;
    sweep.picks.iter().try_for_each(|pick| print_pick(sweep.measure_unit, pick, out))
}

/// Returns the table of errors against one threshold (F_th or t_th). The other threshold has its suggested value.
fn curves(sweep: &Sweep<'_>, measure: Measure, along: Along) -> Table {
    let map = sweep.map;
    let (label, unit) = (measure.label(&map.scale), measure.unit(&map.scale));
    let Thresholds { f_th, t_th_secs } = sweep.suggestion.thresholds;
    let shown = ShownFTh::of(map.distance);
    let (head, at, factor) = match along {
        Along::F => (shown.label(), format!("t_th {t_th_secs} s"), shown.factor),
        Along::T => ("t_th [s]".to_owned(), format!("F_th {}", shown.text(f_th)), 1.0),
    };
    let curves: Vec<(ScoreSet, Vec<(f64, f64)>)> = (ScoreSet::ALL.into_iter())
        .map(|set| (set, map.curve(along, set, measure, sweep.suggestion.at)))
        .filter(|(_, curve)| !curve.is_empty())
        .collect();
    let thresholds = curves.first().map_or(&[][..], |(_, curve)| curve).iter().enumerate();
    let rows = std::iter::once(None).chain(thresholds.map(Some));
    Table::of(rows)
        .column(Column::numbers(head), |row| match row {
            None => Cell::words("conventional"),
            Some((_, (threshold, _))) => Cell::digits(Some(factor * threshold), 4),
        })
        .columns(
            &curves,
            |(set, _)| Column::numbers(set.label()),
            |row, (set, curve)| {
                let value = match row {
                    None => map.conventional_value(*set, measure),
                    Some((at, _)) => curve.get(*at).map(|(_, value)| *value),
                };
                Cell::digits(value, 4)
            },
        )
        .table(format!("RMSE of {label} [{unit}] at {at}"), "")
}

fn print_pick(unit: &str, pick: &BlockSuggestion, out: &mut impl Write) -> io::Result<()> {
    let Setting { label, option, unit: named, .. } = pick.block.setting();
    let [left_out, without] =
        [pick.left_out, pick.left_out_without].map(|error| significant(error, 4));
    let n = pick.n_tried;
    if pick.values.is_empty() {
        return writeln!(
            out,
            "{label}: none of {n} lists of values lowers the cross-validation error of {without} {unit} with 90 % confidence"
        );
    }
    let (words, values) = (named.words, listed(&pick.values, ","));
    writeln!(
        out,
        "{label} ({words}): --{option} {values}: cross-validation error {left_out} {unit}, and {without} {unit} without this feature; {n} lists of values tried"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_lists_are_distinguished() {
        let parsed = |text: &str| text.parse::<Values>();
        assert_eq!(parsed("0:14:0.5"), Ok(Values::Even(0.0, 14.0, 0.5)));
        assert_eq!(parsed("1, 2,5"), Ok(Values::Listed(vec![1.0, 2.0, 5.0])));
        assert_eq!(parsed(""), Ok(Values::Listed(Vec::new())));
        assert!(parsed("0:14").unwrap_err().contains("start:stop:step"));
        assert!(parsed("0:x:1").is_err());
        assert!(parsed("1,x").unwrap_err().contains("\"x\""));
    }
}
